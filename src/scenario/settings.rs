//! From values to the settings of estimator, detector and supervisor.

use super::error::ScenarioError;
use super::key_table::DISTANCES;
use super::value::Value;
use super::values::Values;
use crate::augmentation::{AugmentationSettings, AutomatonSettings, ForceLaw, Freeze, Reengage};
use crate::detection::{ArmingSettings, CusumSettings, DetectorSettings, Distance, DistanceKind, Hypotheses};
use crate::estimation::RlsSettings;

/// The estimator's settings.
pub(super) fn estimator(values: &mut Values) -> Result<RlsSettings, ScenarioError> {
    let normalisation = values.number("estimator.normalisation")?;
    let initial_gain = values.optional_number("estimator.initial_gain").unwrap_or(if normalisation > 0.0 {
        10.0 * normalisation
    } else {
        1e4
    });
    let memory = if normalisation > 0.0 { 10.0 / normalisation } else { 5e-4 };
    let reset_threshold = values.optional_number("estimator.reset_threshold").unwrap_or(2.0 / initial_gain + memory);
    values.derive_if_missing("estimator.initial_gain", Value::Number(initial_gain));
    values.derive_if_missing("estimator.reset_threshold", Value::Number(reset_threshold));
    let dead_zone_n = values.number("estimator.dead_zone_n")?;
    Ok(RlsSettings { initial_gain, reset_threshold, dead_zone_n, normalisation })
}

/// The detector's settings.
pub(super) fn detector(values: &mut Values) -> Result<DetectorSettings, ScenarioError> {
    let word = values.text("detector.distance")?;
    let index = DISTANCES.iter().position(|known| *known == word).unwrap_or(0);
    let kind = DistanceKind::ALL[index];
    let hypotheses = Hypotheses {
        quiet_std_n: values.number("detector.quiet_std_n")?,
        rupture_std_n: values.number("detector.rupture_std_n")?,
        rupture_mean_n: values.number("detector.rupture_mean_n")?,
        stiffness_change_n_per_m: values.number("detector.stiffness_change_n_per_m")?,
    };
    hypotheses.validate().map_err(|error| values.out_of_range(&error))?;
    let (threshold, drift) = hypotheses.tuning(kind);
    let threshold = values.optional_number("detector.threshold").unwrap_or(threshold);
    let drift = values.optional_number("detector.drift").unwrap_or(drift);
    let cap = values.optional_number("detector.cap").unwrap_or(10.0 * threshold);
    values.derive_if_missing("detector.threshold", Value::Number(threshold));
    values.derive_if_missing("detector.drift", Value::Number(drift));
    values.derive_if_missing("detector.cap", Value::Number(cap));
    Ok(DetectorSettings {
        distance: Distance { kind, hypotheses },
        cusum: CusumSettings { threshold, drift, cap },
        arming: ArmingSettings {
            settle_s: values.number("detector.settle_s")?,
            drop_only: values.flag("detector.drop_only")?,
            withdrawal_speed_m_per_s: values.number("detector.withdrawal_speed_m_per_s")?,
        },
    })
}

/// The supervisor's settings.
pub(super) fn augmentation(values: &Values) -> Result<AugmentationSettings, ScenarioError> {
    Ok(AugmentationSettings {
        enabled: values.flag("augmentation.enabled")?,
        automaton: AutomatonSettings {
            min_hold_s: values.number("augmentation.min_hold_s")?,
            max_hold_s: values.number("augmentation.max_hold_s")?,
            exit_ratio: values.number("augmentation.exit_ratio")?,
            exit_quiet_s: values.number("augmentation.exit_quiet_s")?,
            refractory_s: values.number("augmentation.refractory_s")?,
        },
        freeze: match values.text("augmentation.freeze")? {
            "reference" => Freeze::Reference,
            _ => Freeze::Measured,
        },
        reengage: match values.text("augmentation.reengage")? {
            "clutch" => Reengage::Clutch,
            "snap" => Reengage::Snap,
            _ => Reengage::Ramp { catch_up_speed_m_per_s: values.number("augmentation.catch_up_speed_m_per_s")? },
        },
        force: match values.text("augmentation.force_law")? {
            "amplify" => ForceLaw::Amplify { gain: values.number("augmentation.amplification")? },
            _ => ForceLaw::Decay {
                ratio: values.number("augmentation.decay_ratio")?,
                time_constant_s: values.number("augmentation.decay_time_constant_s")?,
            },
        },
        blend_s: values.number("augmentation.blend_s")?,
    })
}
