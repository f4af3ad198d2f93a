//! Every key of a scenario: where it stands, what it holds, its default and its meaning.
//!
//! Validation, the resolved echo, the JSON Schema and the starter file are all read off this one table. A key is declared beside
//! what it sets; here stand the sections, and the order of the groups.

use trocar_core::settings::{Key, count, joined};

use super::run_settings::RunSettings;
use super::schedule_settings::{EventSettings, ScheduleSettings};
use crate::augmentation::AugmentationSettings;
use crate::channel::{DelaySettings, Irregularity};
use crate::detection::DetectorSettings;
use crate::estimation::{ContactSettings, RlsSettings};
use crate::operator::{MotionSettings, ReflexSettings, TremorSettings};
use crate::plant::{ActuatorLimits, ArmParameters, Grip, MasterParameters, SlaveParameters};
use crate::recording::{ColumnSettings, FileSettings, Limits, ScaleSettings, SignSettings};
use crate::sensor::SensorSettings;
use crate::teleoperation::{ComplianceSettings, ControllerSettings, PassivitySettings, RecoverySettings, Scales};
use crate::tissue::TissueSettings;

/// The sections, in the order in which they are written, with what each is about.
pub const SECTIONS: [(&str, &str); 23] = [
    ("simulation", "How long, how finely, by which engine."),
    ("master", "The machine in the hand (eq. 28) and its force controller (eq. 29)."),
    ("arm", "The arm that holds it (eq. 32-35), in the paper's letters."),
    ("slave", "The machine that holds the needle (eq. 30) and its position controller (eq. 31)."),
    ("actuator", "What the motors of both plants can do; needs simulation.control = \"sampled\"."),
    ("scaling", "What a newton and a millimetre become on the other side."),
    ("controller", "Which of positions and forces go which way."),
    ("channel", "The link between the plants."),
    ("passivity", "What keeps the link from making energy, whatever its delay."),
    ("operator", "What the person wants to do."),
    ("tissue", "What the needle meets."),
    ("tissue.skin", "The first of its layers, for kind = \"layers\"."),
    ("tissue.fat", "The second layer."),
    ("tissue.muscle", "The third layer."),
    ("tissue.capsule", "The fourth layer: the organ's membrane."),
    ("tissue.organ", "The last layer."),
    ("recording", "The recording that operator or tissue replay, and that detect reads."),
    ("recording.columns", "Its columns, by the names in the file's header."),
    ("recording.scale", "The factor that turns each column into SI."),
    ("sensor", "How force and position are measured."),
    ("estimator", "The online estimation of the tissue (eq. 12-18)."),
    ("detector", "The detection of ruptures (eq. 19-27)."),
    ("augmentation", "What happens on a detection (section 5.1)."),
];

/// Every key, in the order in which they are written: those of the layers last.
pub const KEYS: &[Key] = &joined::<{ count(&GROUPS) }>(&GROUPS);

const GROUPS: [&[Key]; 30] = [
    RunSettings::KEYS,
    MasterParameters::KEYS,
    Grip::KEYS,
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
    ReflexSettings::KEYS,
    TissueSettings::KEYS,
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
    TissueSettings::LAST_KEYS,
];

#[cfg(test)]
mod tests {
    use std::fmt::Write as _;

    use trocar_core::settings::{Fallback, Kind};

    use super::super::Value;
    use super::*;

    /// Compares with a file beside this one; `BLESS=1` writes it.
    fn assert_snapshot(name: &str, text: &str) {
        let path = format!("{}/src/scenario/snapshots/{name}", env!("CARGO_MANIFEST_DIR"));
        if std::env::var_os("BLESS").is_some() {
            std::fs::write(&path, text).expect("written");
        }
        let kept = std::fs::read_to_string(&path).expect("a snapshot");
        let differing = kept.lines().zip(text.lines()).find(|(kept, now)| kept != now);
        assert!(kept == text, "{name} differs at {differing:?}; BLESS=1 writes it anew");
    }

    #[test]
    fn regress_every_key_is_as_it_was() {
        let mut text = String::new();
        for key in KEYS {
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
