//! Every key of a scenario: its section, type, default and meaning.
//!
//! Validation, the resolved echo, the JSON Schema and the starter file are generated from this table. A key is declared
//! beside the part that it sets; this file holds the sections and the order of the groups.

use trocar_core::settings::{Key, count, joined};

use super::run_settings::RunSettings;
use super::schedule_settings::{EventSettings, ScheduleSettings};
use crate::population::PopulationSettings;
use trocar_core::augmentation::AugmentationSettings;
use trocar_core::detection::DetectorSettings;
use trocar_core::estimation::{ContactSettings, RlsSettings};
use trocar_engine::channel::{DelaySettings, Irregularity};
use trocar_engine::operator::{
    MotionSettings, Perception, ReflexSettings, StiffeningSettings, StretchSettings, TremorSettings,
};
use trocar_engine::plant::{ActuatorLimits, ArmParameters, ArmRoles, Grip, MasterParameters, SlaveParameters};
use trocar_engine::sensor::SensorSettings;
use trocar_engine::teleoperation::{
    ComplianceSettings, ControllerSettings, PassivitySettings, RecoverySettings, Scales,
};
use trocar_engine::tissue::{OrganMotion, TissueSettings};
use trocar_recording::{ColumnSettings, FileSettings, Limits, ScaleSettings, SignSettings};

/// The sections in the order in which they are written, each with its subject.
pub const SECTIONS: [(&str, &str); 21] = [
    ("simulation", "Duration, tick and engine."),
    ("master", "The master (eq. 28) and its force controller (eq. 29)."),
    ("arm", "The operator's arm (eq. 32-35), in the paper's symbols."),
    ("slave", "The slave (eq. 30) and its position controller (eq. 31)."),
    ("actuator", "Limits of both motors; they need simulation.control = \"sampled\"."),
    ("scaling", "Scale factors between the two sides."),
    ("controller", "The teleoperation architecture: which signals each side receives."),
    ("channel", "The link between master and slave."),
    ("passivity", "The passivity scheme, which keeps the link from generating energy under delay."),
    ("operator", "The operator's motion."),
    ("perception", "What the operator notices of the felt force."),
    ("tissue", "The tissue that the needle enters."),
    ("tissue.fmu", "A tissue in a functional mock-up unit of others, whose code is executed: run trusted units only."),
    ("recording", "The recording that the operator or the tissue replays, and that detect reads."),
    ("recording.columns", "The columns of the recording, by their names in the header of the file."),
    ("recording.scale", "The factor that converts each column to SI units."),
    ("sensor", "How force and position are measured."),
    ("estimator", "The online estimation of the tissue (eq. 12-18)."),
    ("detector", "The detection of ruptures (eq. 19-27)."),
    ("augmentation", "The response to an alarm (section 5.1)."),
    ("population", "The people, tissues and links over which trocar stability computes limits."),
];

/// Every key, in the order in which they are written, except those of the layers (`trocar_engine::tissue::LAYER_KEYS`).
pub const KEYS: &[Key] = &joined::<{ count(&GROUPS) }>(&GROUPS);

const GROUPS: [&[Key]; 35] = [
    RunSettings::KEYS,
    MasterParameters::KEYS,
    Grip::KEYS,
    ArmRoles::KEYS,
    ArmParameters::KEYS,
    SlaveParameters::KEYS,
    ComplianceSettings::KEYS,
    ActuatorLimits::KEYS,
    Scales::KEYS,
    ControllerSettings::KEYS,
    DelaySettings::KEYS,
    Irregularity::KEYS,
    ScheduleSettings::KEYS,
    RecoverySettings::KEYS,
    PassivitySettings::KEYS,
    MotionSettings::KEYS,
    TremorSettings::KEYS,
    StretchSettings::KEYS,
    StiffeningSettings::KEYS,
    ReflexSettings::KEYS,
    Perception::KEYS,
    TissueSettings::KEYS,
    OrganMotion::KEYS,
    FileSettings::KEYS,
    SignSettings::KEYS,
    Limits::KEYS,
    ColumnSettings::KEYS,
    ScaleSettings::KEYS,
    SensorSettings::KEYS,
    RlsSettings::KEYS,
    ContactSettings::KEYS,
    DetectorSettings::KEYS,
    AugmentationSettings::KEYS,
    EventSettings::KEYS,
    PopulationSettings::KEYS,
];

#[cfg(test)]
mod tests {
    use std::fmt::Write as _;

    use trocar_core::settings::{Fallback, Kind};

    use super::super::Value;
    use super::*;
    use trocar_engine::tissue::LAYER_KEYS;

    /// Compares with a file beside this one; `BLESS=1` writes it.
    fn assert_snapshot(name: &str, text: &str) {
        let path = format!("{}/src/snapshots/{name}", env!("CARGO_MANIFEST_DIR"));
        if std::env::var_os("BLESS").is_some() {
            std::fs::write(&path, text).expect("written");
        }
        let expected = std::fs::read_to_string(&path).expect("a snapshot");
        let differing = expected.lines().zip(text.lines()).find(|(expected, now)| expected != now);
        assert!(expected == text, "{name} differs at {differing:?}; BLESS=1 writes it anew");
    }

    #[test]
    fn regress_every_key_matches_the_snapshot() {
        let mut text = String::new();
        for key in KEYS.iter().chain(LAYER_KEYS) {
            let range = if let Kind::Number(range) = key.kind {
                format!(" [{:e} {} {:e}]", range.low().0, range.low().1, range.high())
            } else {
                String::new()
            };
            let fallback = match key.fallback {
                Fallback::Value(value) => format!("= {}", Value::from(value).to_toml()),
                Fallback::Derived(rule) => format!("derived: {rule}"),
                Fallback::Unset => "unset".into(),
            };
            let must = key.kind.to_string();
            writeln!(text, "{}\n    {must}{range}\n    {fallback}\n    {}", key.path, key.meaning).expect("text");
        }
        assert_snapshot("keys.txt", &text);
    }
}
