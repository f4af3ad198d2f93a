//! A built-in part is named in its own file and in its line of the registry only. Other places that name a part are
//! about that part, and are listed here with the reason.

use std::collections::HashMap;
use std::fs;
use std::path::Path;

use crate::support::{file, files_with};
use trocar::scenario::{KEYS, Kind};

const CORE: &str = "core/src/";
const SIM: &str = "sim/src/";

/// Another place that may name a part, and the reason.
type Exception = (&'static str, &'static str);

/// A built-in part: its own file, its names, and its exceptions.
type Part = (&'static str, &'static [&'static str], &'static [Exception]);

/// The compiled wirings of frequent parts.
const WIRED: [Exception; 2] = [
    ("sim/src/engine/wired.rs", "the wirings that are compiled for their parts"),
    ("sim/src/scenario/parts.rs", "which of these wirings a scenario has"),
];
const SWITCHING: Exception = ("sim/src/stability/switching/modes.rs", "the modes that each force law gives the loop");
const BOTH: Exception = ("sim/src/teleoperation/architecture/four_channel.rs", "four channels are both, and more");
const NOISE_BENCH: Exception = ("sim/src/detect/calibration/run_length.rs", "run lengths in closed form, for squares");
const WITH_AND_WITHOUT: Exception = ("core/src/estimation/least_residual.rs", "runs both");
const PARAMETERS: Exception =
    ("core/src/estimation/settings.rs", "the word for what is estimated, and its friction's keys");

const TISSUES: &[Part] = &[
    (
        "kelvin_voigt.rs",
        &["KelvinVoigt", "KelvinVoigtSettings"],
        &[
            ("sim/src/stability/tissue_kind.rs", "the tissue of the linear loop"),
            ("sim/src/stability_check/run.rs", "runs the linear loop"),
            ("sim/src/stability_check/sequences.rs", "runs the linear loop with events"),
        ],
    ),
    ("hunt_crossley.rs", &["HuntCrossley", "HuntCrossleySettings"], &[]),
    ("generalised.rs", &["Generalised", "GeneralisedSettings"], &[]),
    ("layers.rs", &["Layers", "LayersParameters"], &WIRED),
    ("tearing.rs", &["Tearing", "TearingSettings"], &[]),
    (
        "fmu.rs",
        &["Fmu", "FmuSettings"],
        &[
            ("sim/src/scenario/specs.rs", "what opens the unit's file"),
            ("sim/src/scenario/parts.rs", "what instantiates it"),
        ],
    ),
];

const FORCE_LAWS: &[Part] = &[
    ("force_laws/decay.rs", &["Decay", "DecaySettings"], &[SWITCHING]),
    (
        "force_laws/amplify.rs",
        &["Amplify", "AmplifySettings"],
        &[SWITCHING, ("core/src/rig/settings.rs", "what a gain may be on a real machine")],
    ),
    (
        "force_laws/damp.rs",
        &["Damp", "DampSettings"],
        &[
            SWITCHING,
            ("sim/src/stability/coverage.rs", "what the linear loop leaves out"),
            ("core/src/rig/settings.rs", "what a damping may be on a real machine"),
        ],
    ),
];

const HOLDS: &[Part] = &[
    (
        "holds/freeze.rs",
        &["Frozen"],
        &[
            ("core/src/augmentation/position.rs", "what holds the slave unless another hold is set"),
            ("sim/src/stability/coverage.rs", "the hold that the analysis of events has"),
        ],
    ),
    ("holds/follow.rs", &["Following"], &[]),
    ("holds/speed_limit.rs", &["SpeedLimit", "SpeedLimitSettings"], &[]),
    ("holds/forbidden_region.rs", &["ForbiddenRegion", "ForbiddenRegionSettings"], &[]),
];

const DISTANCES: &[Part] = &[
    (
        "squared_residual.rs",
        &["SquaredResidual"],
        &[WIRED[0], WIRED[1], NOISE_BENCH, ("core/src/detection/mod.rs", "the paper's detector")],
    ),
    (
        "squared_drop.rs",
        &["SquaredDrop"],
        &[NOISE_BENCH, ("sim/src/detect/calibration/bench.rs", "calibrates with drops alone")],
    ),
    ("mean_change.rs", &["MeanChange"], &[]),
    ("variance_change.rs", &["VarianceChange"], &[]),
    ("parameter_change.rs", &["ParameterChange"], &[]),
    ("force_derivative.rs", &["ForceDerivative"], &[("sim/src/compare/noise.rs", "the paper's baseline")]),
    ("likelihood_ratio.rs", &["LikelihoodRatio", "WindowSettings"], &[]),
    ("page_hinkley.rs", &["PageHinkley"], &[]),
    ("adaptive.rs", &["Adaptive"], &[("sim/src/scenario/values.rs", "the detector of recordings")]),
    ("moving_average.rs", &["MovingAverage"], &[]),
    ("windowed_derivative.rs", &["WindowedDerivative"], &[]),
    ("linear_fit.rs", &["LinearFit"], &[]),
];

const ESTIMATORS: &[Part] = &[
    ("rls.rs", &["Rls"], &[("core/src/rig/mod.rs", "a rig runs no other")]),
    ("linear.rs", &["Linear"], &[WITH_AND_WITHOUT]),
    ("friction.rs", &["Friction"], &[WITH_AND_WITHOUT]),
    ("hunt_crossley.rs", &["HuntCrossley"], &[PARAMETERS]),
    ("least_residual.rs", &["LeastResidual"], &[PARAMETERS]),
];

const ARCHITECTURES: &[Part] = &[
    (
        "architecture/position_force.rs",
        &["PositionForce"],
        &[
            ("sim/src/teleoperation/settings.rs", "whether the link is the paper's"),
            ("sim/src/teleoperation/link.rs", "whether the link is the paper's"),
            ("sim/src/scenario/link.rs", "what only the paper's architecture goes with"),
            ("sim/src/stability/limit.rs", "the limit in closed form is the paper's"),
            ("sim/src/stability/sampled.rs", "the reduced loop is the paper's"),
            ("sim/src/stability/sensitivity.rs", "the paper's has no coupling"),
            ("sim/src/stability/z_width.rs", "the paper's master computes a wall"),
        ],
    ),
    ("architecture/local_force.rs", &["LocalForce"], &[BOTH]),
    ("architecture/position_position.rs", &["PositionPosition"], &[BOTH]),
    ("architecture/four_channel.rs", &["FourChannel", "FourChannelSettings"], &[]),
];

const SCHEMES: &[Part] = &[
    ("passivity/no_scheme.rs", &["NoScheme"], &[]),
    ("passivity/time_domain.rs", &["TimeDomain"], &[]),
    ("passivity/waves.rs", &["Waves", "WavesSettings", "WaveVariables"], &[]),
    ("passivity/tank.rs", &["Tank", "TankSettings", "EnergyTank"], &[]),
];

/// Returns the sources of both crates as code alone: without comments, imports and tests.
fn sources() -> HashMap<String, String> {
    let mut sources = HashMap::new();
    for folder in [CORE, SIM] {
        for path in files_with("rs", &file(folder)) {
            let name = path.strip_prefix(file("")).expect("in the project").to_string_lossy().replace('\\', "/");
            if !name.ends_with("tests.rs") {
                sources.insert(name, code(&path));
            }
        }
    }
    assert!(sources.len() > 150, "{}", sources.len());
    sources
}

/// Returns a file without comments, imports, module names and tests.
fn code(path: &Path) -> String {
    let text = fs::read_to_string(path).expect("text");
    let mut code = String::new();
    let mut in_import = false;
    for line in text.lines().take_while(|line| !line.starts_with("mod tests {")) {
        let start = line.trim_start();
        in_import |= ["use ", "pub use ", "pub(super) use "].iter().any(|word| start.starts_with(word));
        let is_module = start.ends_with(';') && ["mod ", "pub mod "].iter().any(|word| start.starts_with(word));
        if !(in_import || is_module || start.starts_with("//")) {
            code.push_str(line);
            code.push('\n');
        }
        in_import &= !start.ends_with(';');
    }
    code
}

/// Returns whether a line of code contains a whole name.
fn names(line: &str, name: &str) -> bool {
    let part_of_name = |c: char| c.is_alphanumeric() || c == '_';
    line.match_indices(name)
        .any(|(at, _)| !line[..at].ends_with(part_of_name) && !line[at + name.len()..].starts_with(part_of_name))
}

/// Checks that each part of a registry is named in its own file, in one line of the registry and in its exceptions
/// only, in the files whose paths start with one of `within`.
fn named_once(registry: &str, within: &[&str], parts: &[Part]) {
    let sources = sources();
    let folder = registry.rsplit_once('/').expect("a folder").0;
    for (own, names_of_part, exceptions) in parts {
        let own = format!("{folder}/{own}");
        assert!(sources.contains_key(&own), "{own}");
        let lines = |text: &str| {
            // The first line of a choice names its default.
            let counts = |line: &&str| !line.contains("pub enum") && names_of_part.iter().any(|name| names(line, name));
            text.lines().filter(counts).count()
        };
        for (path, text) in &sources {
            let excepted = exceptions.iter().any(|(file, _)| file == path);
            if *path == own || excepted || !within.iter().any(|folder| path.starts_with(folder)) {
                continue;
            }
            assert_eq!(lines(text), usize::from(path == registry), "lines that name {names_of_part:?} in {path}");
        }
        for (path, reason) in *exceptions {
            assert!(lines(&sources[*path]) > 0, "{path} no longer names {names_of_part:?} ({reason})");
        }
    }
}

#[test]
fn a_part_is_named_in_its_file_and_its_line_in_the_registry() {
    named_once("sim/src/tissue/kind.rs", &[SIM], TISSUES);
    named_once("core/src/augmentation/force_laws.rs", &[CORE, SIM], FORCE_LAWS);
    named_once("core/src/augmentation/holds.rs", &[CORE, "sim/src/stability/coverage"], HOLDS);
    named_once("core/src/detection/distances/mod.rs", &[CORE, SIM], DISTANCES);
    assert_eq!(DISTANCES.len(), trocar::detection::DistanceKind::WORDS.len());
    named_once("core/src/estimation/any.rs", &[CORE], ESTIMATORS);
    named_once("sim/src/teleoperation/mod.rs", &[SIM], ARCHITECTURES);
    named_once("sim/src/teleoperation/mod.rs", &[SIM], SCHEMES);
}

/// Texts that equal a word of a choice, and their meaning.
const SPELT_ALIKE: [(&str, &str, &str); 22] = [
    ("none", "core/src/augmentation/mod.rs", "the hold that is none"),
    ("exact", "sim/src/engine/plants.rs", "the remedy of an error"),
    ("hold", "sim/src/detect/phases.rs", "a phase of a recording"),
    ("none", "sim/src/compare/facts.rs", "what was asked of a fact"),
    ("none", "sim/src/compare/facts.rs", "what was asked of another"),
    ("none", "sim/src/compare/strategies/catalogue.rs", "a strategy"),
    ("speed-limit", "sim/src/compare/strategies/catalogue.rs", "a strategy"),
    ("forbidden-region", "sim/src/compare/strategies/catalogue.rs", "a strategy"),
    ("recording", "sim/src/scenario/key_table.rs", "a section"),
    ("time", "sim/src/metrics/rupture.rs", "a metric"),
    ("time", "sim/src/recording/containers/ros.rs", "a type of ROS"),
    ("sampled", "sim/src/scenario/key_table.rs", "the sentence of a section"),
    ("layers", "sim/src/scenario/key_table.rs", "the sentence of a section"),
    ("layers", "sim/src/scenario/starter.rs", "a value of a starter"),
    ("insertion-extraction", "sim/src/scenario/starter.rs", "a value of a starter"),
    ("stop", "sim/src/scenario/starter.rs", "a value of a starter"),
    ("stiffness", "sim/src/scenario/quantity.rs", "the name of a quantity"),
    ("minimum-jerk", "sim/src/scenario/replay.rs", "the remedy of an error"),
    ("layers", "sim/src/scenario/replay.rs", "the remedy of an error"),
    ("continuous", "sim/src/fmu/description.rs", "the variability of an input in FMI"),
    ("continuous", "sim/src/fmu/description.rs", "the variability of the time in FMI"),
    ("time", "sim/src/fmu/description.rs", "the name of the time in FMI"),
];

#[test]
fn a_word_of_a_choice_stands_in_one_line() {
    let sources = sources();
    let mut choices: HashMap<&str, usize> = HashMap::new();
    for key in KEYS {
        if let Kind::Choice(words) = key.kind {
            words.iter().for_each(|word| *choices.entry(word).or_default() += 1);
        }
    }
    assert!(choices.len() > 50, "{}", choices.len());
    for (word, choices) in choices {
        let spelt = |text: &str| {
            text.matches(&format!("\"{word}\"")).count() + text.matches(&format!("\\\"{word}\\\"")).count()
        };
        let mut found = vec![];
        for (path, text) in &sources {
            let alike = SPELT_ALIKE.iter().filter(|(other, file, _)| *other == word && file == path).count();
            let here = spelt(text);
            assert!(here >= alike, "{path} no longer has {word:?}");
            found.extend(std::iter::repeat_n(path, here - alike));
        }
        assert_eq!(found.len(), choices, "{word:?} stands in {found:?}");
    }
}
