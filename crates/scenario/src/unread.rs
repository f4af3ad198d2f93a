use super::document::parse_setting;
use super::key_table::KEYS;
use super::keys::{KeyAt, find};
use super::scenario::Scenario;
use super::values::{Values, replays_force, replays_position};
use trocar_base::warning::{Code, Warning};
use trocar_engine::operator::Reflex;

const OF_VELOCITY: [&str; 2] = ["sensor.position_resolution_m", "sensor.acceleration_std_m_per_s2"];

const SEED: &str = "simulation.seed";

const CONTACT: &str = "estimator.contact_m";

/// A command that reads keys about a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reader {
    Detection,
    /// A live stream has no labels and no tare.
    Stream,
    /// Computes the settings of estimator and detector.
    Calibration,
    /// Computes or varies the detectors' settings.
    Roc,
}

impl Reader {
    fn refusal(self, path: &str) -> Option<(&'static str, &'static str)> {
        let is_in = |section: &str| path.starts_with(section);
        if self == Self::Calibration && is_in("recording.ruptures_s") || OF_VELOCITY.contains(&path) {
            return None;
        }
        if path == "recording.tare_s" && self == Self::Stream {
            return Some((
                "a live stream is not tared",
                "tare the sensor before the stream, or subtract the offset in its source",
            ));
        }
        if is_in("recording.") || path == CONTACT || path == "name" {
            return None;
        }
        if is_in("estimator.") || is_in("detector.") {
            return (self == Self::Calibration).then_some((
                "a calibration computes it from the recording",
                "leave it out and give --false-alarm-s, --variance-ratio or --quiet-s, or change it in calibrated.toml",
            ));
        }
        if is_in("sensor.force_bias") {
            return Some((
                "it acts on the simulated sensor only, not on recorded forces",
                "subtract the offset of the recorded force with --tare-s (recording.tare_s)",
            ));
        }
        if is_in("sensor.") {
            return Some((
                "it acts on the simulated sensor only, not on recorded samples",
                "leave it out; `trocar run` reads it",
            ));
        }
        Some((
            "a recording is not simulated",
            "leave it out; the keys of [recording], [estimator] and [detector] act here, and `trocar run` reads the \
             others",
        ))
    }
}

const COMMAND_LINE: &str = "--set";

/// Warnings about command-line keys without effect in a run: keys of an unused recording, and the seed without random
/// numbers.
pub fn idle_keys(scenario: &Scenario) -> Vec<Warning> {
    let values = scenario.values();
    let replays = replays_position(values) || replays_force(values);
    let is_given = |path: &str| values.place(path).is_some_and(|place| &*place.file == COMMAND_LINE);
    let of = |path: &'static str| {
        let (why, remedy) = if path.starts_with("recording.") && !replays {
            ("the scenario replays no recording", "set operator.kind or tissue.kind to \"recording\", or leave it out")
        } else if path == SEED && !scenario.has_random_numbers() {
            (
                "the scenario has no random numbers",
                "add noise, as in --set sensor.force_noise_std_n=0.025, or leave it out",
            )
        } else {
            return None;
        };
        is_given(path).then(|| {
            let message = format!("{path} changes nothing here: {why}");
            Warning::new(Code::KeyWithoutEffect, message).at(path).remedy(remedy)
        })
    };
    KEYS.iter().map(|key| key.path).filter_map(of).collect()
}

/// The sections without effect on the linear loop.
const NOT_OF_LOOP: [&str; 5] = ["estimator.", "detector.", "perception.", SEED, "recording.ruptures_s"];

/// Settings (`section.key=value`) without effect on the linear loop. An operator's reflex has one: the analysis leaves
/// it out, so the stability is unknown. The seed draws the population.
pub fn keys_outside_loop(scenario: &Scenario, settings: &[String]) -> Vec<Warning> {
    let acts = |path: &str| path == Reflex::KEY.path || path == SEED && scenario.population.varies();
    let of = |path: String| {
        let message = format!("{path} changes nothing here: the linear loop has no detection and no random numbers");
        let is_outside = NOT_OF_LOOP.iter().any(|section| path.starts_with(section)) && !acts(&path);
        is_outside.then(|| {
            Warning::new(Code::KeyWithoutEffect, message).at(path).remedy("leave it out; `trocar run` reads it")
        })
    };
    paths(settings).into_iter().filter_map(of).collect()
}

fn paths(settings: &[String]) -> Vec<String> {
    let entries = settings.iter().filter_map(|setting| parse_setting(setting).ok()).flatten();
    let mut paths: Vec<String> = entries.map(|entry| entry.path).collect();
    paths.sort();
    paths.dedup();
    paths
}

/// Settings (`section.key=value`) that the reader ignores, or without effect for the kinds in `values`.
pub fn keys_without_effect(values: &Values, settings: &[String], reader: Reader) -> Vec<Warning> {
    let of = |path: &String| {
        let (why, remedy) = match reader.refusal(path) {
            Some((why, remedy)) => (why.to_owned(), remedy.to_owned()),
            None => inert(values, &find(path)?)?,
        };
        let message = format!("{path} changes nothing here: {why}");
        Some(Warning::new(Code::KeyWithoutEffect, message).at(path.clone()).remedy(remedy))
    };
    paths(settings).iter().filter_map(of).collect()
}

fn inert(values: &Values, key: &KeyAt) -> Option<(String, String)> {
    let is_judged = ["estimator.", "detector."].iter().any(|section| key.path.starts_with(section));
    let unmet = is_judged.then(|| values.unmet(key).next()).flatten()?;
    let words = unmet.words().join(" or ");
    let present = values.get(unmet.key).map(super::Value::to_toml).map(|value| value.to_string()).unwrap_or_default();
    Some((
        format!("it acts for {} = {words}, which is {present}", unmet.key),
        format!("leave it out, or change {}", unmet.key),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn warned(reader: Reader, settings: &[&str]) -> Vec<String> {
        let settings: Vec<String> = settings.iter().map(|&setting| setting.to_owned()).collect();
        let values = Values::from_settings("a", &settings).expect("valid");
        let text = |warning: Warning| format!("{} ({})", warning.message, warning.remedy.expect("a remedy"));
        keys_without_effect(&values, &settings, reader).into_iter().map(text).collect()
    }

    #[test]
    fn a_key_of_the_simulated_sensor_has_no_effect_on_a_recording() {
        let found =
            warned(Reader::Detection, &["sensor.force_bias_n=-0.35", "detector.threshold=2", "recording.tare_s=1"]);
        assert_eq!(
            found,
            ["sensor.force_bias_n changes nothing here: it acts on the simulated sensor only, not on recorded \
                 forces \
              (subtract the offset of the recorded force with --tare-s (recording.tare_s))"]
        );
        assert_eq!(warned(Reader::Detection, &["sensor.force_noise_std_n=0.1"]).len(), 1);
        assert!(
            warned(Reader::Detection, &["sensor.position_resolution_m=1e-5", "estimator.dead_zone_n=0.1"]).is_empty()
        );
    }

    #[test]
    fn a_calibration_computes_estimator_and_detector_itself() {
        let settings = ["detector.threshold=2", "estimator.dead_zone_n=0.1", "estimator.contact_m=0.001"];
        let found = warned(Reader::Calibration, &settings);
        assert_eq!(found.len(), 2, "{found:?}");
        assert!(
            found[0].starts_with("detector.threshold changes nothing here: a calibration computes it"),
            "{found:?}"
        );
        assert!(warned(Reader::Detection, &settings).is_empty());
    }

    #[test]
    fn a_run_reads_neither_an_unused_recording_nor_a_seed_without_noise() {
        let warned = |name: &str, settings: &[&str]| {
            let settings: Vec<String> = settings.iter().map(|&setting| setting.to_owned()).collect();
            let scenario = Scenario::load(&super::super::Source::parse(name), &settings).expect("loads");
            idle_keys(&scenario).into_iter().map(|warning| warning.message).collect::<Vec<_>>()
        };
        let settings = ["simulation.seed=5", "recording.force_sign=-1"];
        assert_eq!(
            warned("layers/through-the-skin", &settings),
            ["recording.force_sign changes nothing here: the scenario replays no recording"]
        );
        assert_eq!(
            warned("paper/classical", &settings),
            ["simulation.seed changes nothing here: the scenario has no random numbers"]
        );
        assert!(warned("layers/through-the-skin", &[]).is_empty());
    }

    #[test]
    fn the_linear_loop_has_no_detector() {
        let warned = |settings: &[&str]| {
            let settings: Vec<String> = settings.iter().map(|&setting| setting.to_owned()).collect();
            let scenario = Scenario::load(&super::super::Source::parse("paper/classical"), &settings).expect("loads");
            keys_outside_loop(&scenario, &settings).into_iter().map(|warning| warning.message).collect::<Vec<_>>()
        };
        let found = warned(&["detector.threshold=2", "scaling.force=2", "channel.delay_s=0.01"]);
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(found[0].starts_with("detector.threshold changes nothing here: the linear loop"), "{found:?}");
        assert!(warned(&["perception.reflex=stop"]).is_empty());
        assert_eq!(warned(&["simulation.seed=5"]).len(), 1);
        assert!(warned(&["simulation.seed=5", "population.arm=people"]).is_empty());
    }

    #[test]
    fn a_warning_names_the_kind_for_which_the_key_has_an_effect() {
        let found = warned(Reader::Detection, &["detector.insertion_speed_m_per_s=0.01"]);
        assert!(found.len() == 1 && found[0].contains("detector.motion"), "{found:?}");
        assert!(
            warned(Reader::Detection, &["detector.insertion_speed_m_per_s=0.01", "detector.motion=inserting"])
                .is_empty()
        );
    }
}
