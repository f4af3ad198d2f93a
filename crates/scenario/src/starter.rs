//! Starter scenarios, with the keys' meanings and defaults as comments.

use trocar_core::settings::{Fallback, Key, Kind};

use super::key_table::SECTIONS;
use super::keys::find;
use super::layers::field;
use super::value::Value;
use super::values::{harmless_name, keys_of};
use trocar_engine::tissue::{LAYER_KEYS, LAYER_LIST};

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Starter {
    /// A user-defined tissue with layers.
    Tissue,
    Replay,
    /// The paper's augmented scenario and a few changes.
    Minimal,
    All,
}

#[derive(Debug, Clone, Copy)]
enum Line {
    Set(&'static str, &'static str),
    Default(&'static str),
    /// Commented out with an example value; no fixed default.
    Example(&'static str, &'static str),
    Layer(&'static str),
}

use Line::{Default, Example, Layer, Set};

const BASE: &str = "base = \"paper/augmented\" # Inherit from a shipped scenario, or from a file relative to this one, then override.\n";

const TISSUE: &[Line] = &[
    Set("simulation.duration_s", "8.0"),
    Default("simulation.seed"),
    Default("scaling.force"),
    Default("channel.delay_s"),
    Set("operator.kind", "\"insertion-extraction\""),
    Set("operator.end_m", "0.06"),
    Set("operator.movement_s", "5.0"),
    Default("operator.tremor_amplitude_m"),
    Set("perception.reflex", "\"stop\""),
    Set("tissue.kind", "\"layers\""),
    Layer("skin"),
    Set("tissue.layer.*.thickness_m", "0.002"),
    Set("tissue.layer.*.stiffening_n_per_m2", "3.5e4"),
    Set("tissue.layer.*.rupture_force_n", "5.3"),
    Set("tissue.layer.*.cutting_force_n", "1.5"),
    Layer("muscle"),
    Set("tissue.layer.*.thickness_m", "0.025"),
    Set("tissue.layer.*.rupture_force_n", "2.0"),
    Set("tissue.layer.*.cutting_force_n", "0.4"),
    Layer("organ"),
    Default("tissue.layer.*.thickness_m"),
    Default("tissue.layer.*.friction_n_per_m"),
    Set("sensor.force_noise_std_n", "0.025"),
    Set("estimator.dead_zone_n", "0.05"),
    Example("detector.threshold", "0.01"),
    Default("augmentation.enabled"),
    Default("augmentation.reengage"),
];

const REPLAY: &[Line] = &[
    Default("scaling.force"),
    Default("channel.delay_s"),
    Default("tissue.index"),
    Set("recording.file", "\"builtin:in_vivo_like.csv\""),
    Set("recording.ruptures_s", "[5.52, 8.85]"),
    Default("recording.position_sign"),
    Default("recording.force_sign"),
    Default("recording.columns.time_s"),
    Default("recording.columns.position_m"),
    Set("recording.columns.velocity_m_per_s", "\"velocity_m_per_s\""),
    Default("recording.columns.force_n"),
    Default("recording.scale.time_s"),
    Default("recording.scale.position_m"),
    Default("recording.scale.velocity_m_per_s"),
    Default("recording.scale.force_n"),
    Example("estimator.contact_m", "0.012"),
    Default("estimator.dead_zone_n"),
    Default("detector.distance"),
    Example("detector.threshold", "0.01"),
    Default("augmentation.enabled"),
    Default("augmentation.force_law"),
    Default("augmentation.reengage"),
];

const MINIMAL: &[Line] = &[
    Set("scaling.force", "0.8"),
    Default("channel.delay_s"),
    Default("sensor.force_noise_std_n"),
    Example("detector.threshold", "0.01"),
    Default("augmentation.enabled"),
    Default("augmentation.force_law"),
    Default("augmentation.reengage"),
];

impl Line {
    fn path(self) -> &'static str {
        match self {
            Set(path, _) | Default(path) | Example(path, _) => path,
            Layer(_) => LAYER_LIST,
        }
    }

    fn text(self) -> Option<String> {
        if let Layer(name) = self {
            return Some(format!("\n[[{LAYER_LIST}]]\nname = {name:?} # Name of the layer.\n"));
        }
        let key = find(self.path())?;
        let name = field(key.key.path);
        let about = format!("{}{}", key.meaning, must(&key));
        let default = match key.fallback {
            Fallback::Value(value) => Some(Value::from(value).to_toml().to_string()),
            Fallback::Derived(rule) => Some(rule.to_owned()),
            Fallback::Unset => None,
        };
        let remark = default.as_ref().map_or_else(String::new, |default| format!(" Default: {default}."));
        Some(match self {
            Set(_, value) => format!("{name} = {value} # {about}{remark}\n"),
            Default(_) => format!("# {name} = {} # {about}\n", default?),
            Example(_, value) => format!("# {name} = {value} # {about} Example value.{remark}\n"),
            Layer(_) => return None,
        })
    }
}

impl Starter {
    /// The name is made valid for a folder.
    pub fn text(self, name: &str) -> String {
        let (subject, base, lines) = match self {
            Self::All => return every_key(name),
            Self::Tissue => ("An insertion through layers of tissue.", "", TISSUE),
            Self::Replay => ("A replay of a recording: replace the file and name its columns.", "", REPLAY),
            Self::Minimal => ("The paper's augmented insertion, with changes.", BASE, MINIMAL),
        };
        let mut text = format!(
            "# {subject}\n\
             # Check it with `trocar check`, run it with `trocar run`. Uncomment a line to override the default.\n\
             {UNITS}\
             # Every key: docs/src/reference/keys.md, or `trocar init --all`.\n\
             \n\
             {}{base}",
            name_line(name)
        );
        let mut here = "";
        for line in lines {
            let section = line.path().rsplit_once('.').map_or("", |(section, _)| section);
            let is_in_layer = matches!(line, Layer(_)) || section.starts_with(LAYER_LIST);
            if section != here && !is_in_layer {
                here = section;
                // Keeps the starter short.
                text.push_str(&format!("\n[{section}] # {}\n", subject_of(section)));
            }
            text.extend(line.text());
        }
        text
    }
}

const UNITS: &str = "# Lengths in m, times in s, forces in N, positive when they resist insertion.\n";

fn name_line(name: &str) -> String {
    format!("name = {}\n", toml::Value::String(harmless_name(name)))
}

fn subject_of(section: &str) -> &'static str {
    SECTIONS.iter().find(|(known, _)| *known == section).map_or("", |(_, about)| about)
}

fn every_key(name: &str) -> String {
    let mut text = format!(
        "# A trocar scenario. Check it with `trocar check`, run it with `trocar run`.\n\
         # Every key is here with its default, commented out. Uncomment a line to override the default. The base\n\
         # overrides defaults too.\n\
         {UNITS}\n{}{BASE}",
        name_line(name)
    );
    for (section, about) in SECTIONS {
        text.push_str(&format!("\n# {about}\n[{section}]\n"));
        for key in keys_of(section) {
            let name = field(key.path);
            match key.fallback {
                Fallback::Value(_) => text.extend(Default(key.path).text()),
                Fallback::Derived(rule) => text.push_str(&format!("# {name} = # {} Default: {rule}.\n", key.meaning)),
                Fallback::Unset => text.push_str(&format!("# {name} = # {}\n", key.meaning)),
            }
        }
        if LAYER_LIST.strip_suffix(".layer") == Some(section) {
            text.push_str(&any_layer());
        }
    }
    text
}

fn any_layer() -> String {
    let acts = LAYER_KEYS.first().and_then(|key| key.acts_for);
    let kinds = acts.map_or(String::new(), |acts| format!(", for {} = {}", acts.key, acts.words().join(", ")));
    let mut text = format!("# [[{LAYER_LIST}]] # A layer{kinds}; the first one is at the surface.\n");
    // Indented: not of the section above.
    text.push_str("#   name = \"organ\" # Name of the layer.\n");
    let lines = LAYER_KEYS.iter().filter_map(|key| Default(key.path).text());
    text.extend(lines.map(|line| line.replacen("# ", "#   ", 1)));
    text
}

fn must(key: &Key) -> String {
    match key.kind {
        Kind::Choice(_) => format!(" ({})", key.kind),
        _ => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Scenario, Source};
    use super::*;

    fn load(text: &str) -> Scenario {
        let source = Source::Text { name: "starter".into(), text: text.into() };
        Scenario::load(&source, &[]).unwrap_or_else(|error| panic!("{error}\n{text}"))
    }

    #[test]
    fn a_starter_is_short_and_valid_with_any_line_uncommented() {
        for (starter, listed) in [(Starter::Tissue, TISSUE), (Starter::Replay, REPLAY), (Starter::Minimal, MINIMAL)] {
            let text = starter.text("mine");
            assert!(text.lines().count() <= 60, "{text}");
            assert!(text.contains("docs/src/reference/keys.md"));
            assert!(text.contains("Uncomment a line to override the default."), "{text}");
            // A commented value that differs from the default says so.
            for line in listed.iter().filter(|line| matches!(line, Example(..))) {
                let name = find(line.path()).map(|key| field(key.key.path)).expect("a key");
                let example = text.lines().find(|text| text.starts_with(&format!("# {name} = "))).expect("a line");
                assert!(example.contains(" Example value."), "{example}");
            }
            assert_eq!(load(&text).name, "mine");
            let is_key = |line: &str| line.strip_prefix("# ").is_some_and(|line| line.split(' ').nth(1) == Some("="));
            let mut uncommented = 0;
            for commented in text.lines().filter(|line| is_key(line)) {
                load(&text.replace(commented, &commented[2..]));
                uncommented += 1;
            }
            let set = listed.iter().filter(|line| matches!(line, Set(..) | Layer(_))).count();
            assert_eq!(uncommented + set, listed.len(), "{text}");
        }
    }
}
