use std::sync::Arc;

use super::measures::{Errors, contrast, squared_changes_n2};
use super::statement::Judgement;
use super::{load, quiet_residual_n, quiet_stretches};
use crate::run::{Run, RunError, measure, run};
use trocar_base::parallel::try_map;
use trocar_core::estimation::{Parameters, RlsSettings};
use trocar_metrics::Metrics;
use trocar_recording::{InVivoLikeVariant, in_vivo_like_variant_csv};
use trocar_scenario::{Scenario, TissueSpec};

use super::super::ADDED_NOISE_STD_N;

/// Factors of `F_0` and `N_0`: the scenario's values, and corners around them.
const SETTINGS: [(f64, f64); 5] = [(1.0, 1.0), (1.0 / 3.0, 0.5), (1.0 / 3.0, 2.0), (3.0, 0.5), (3.0, 2.0)];
pub(super) const SETTINGS_TEXT: &str = "with F_0 times 1/3 to 3 and N_0 times 1/2 to 2";

/// Time constants of the force's fall: the shipped recording's, half of it, and double.
pub(super) const FALLS_S: [f64; 3] = [0.045, 0.0225, 0.09];
const RECORDING_SEED: u64 = 1;

pub const NOISE_SEEDS: usize = 20;

/// Largest power of √2 in the factors of threshold and drift.
const THRESHOLD_STEPS: i32 = 10;

#[derive(Debug, Clone)]
pub(super) struct Varied<T>(pub(super) Vec<T>);

impl<T> Varied<T> {
    pub(super) fn judge(&self, is_met: impl Fn(&T) -> bool) -> Judgement {
        Judgement::over(self.0.iter().map(is_met))
    }

    pub(super) fn range(&self, of: impl Fn(&T) -> f64) -> (f64, f64) {
        let values: Vec<f64> = self.0.iter().map(of).collect();
        super::measures::range(&values)
    }
}

#[derive(Debug, Clone)]
pub(super) struct OfSettings {
    pub(super) run: Run,
    pub(super) both: Errors,
    pub(super) alone: Errors,
    /// In the quiet stretches, with K and B.
    pub(super) quiet_variance_n2: f64,
}

pub(super) fn over_settings(name: &str) -> Result<Varied<OfSettings>, RunError> {
    let base = load(name, &[])?;
    let of = |index: usize| {
        let (gain, zone) = SETTINGS[index];
        let with = |parameters: Parameters| {
            let mut scenario = base.clone();
            let settings = &mut scenario.estimator;
            let scaled = settings.initial_gain * gain;
            // Keeps the distance of α_0 from tr(F_0⁻¹).
            settings.reset_threshold += 2.0 / scaled - 2.0 / settings.initial_gain;
            settings.initial_gain = scaled;
            settings.dead_zone_n *= zone;
            settings.parameters = parameters;
            run(scenario)
        };
        let both = with(Parameters::StiffnessAndDamping)?;
        let residual_n = quiet_residual_n(&quiet_stretches(&both));
        Ok::<_, RunError>(OfSettings {
            both: Errors::of(&both),
            alone: Errors::of(&with(Parameters::Stiffness)?),
            quiet_variance_n2: super::measures::mean_and_variance(residual_n).1,
            run: both,
        })
    };
    Ok(Varied(try_map(SETTINGS.len(), of)?))
}

/// With K and B, and with K alone.
pub(super) fn with_default_estimator(name: &str) -> Result<[f64; 2], RunError> {
    let base = load(name, &[])?;
    let with = |parameters: Parameters| {
        let mut scenario = base.clone();
        scenario.estimator = RlsSettings { parameters, ..RlsSettings::default() };
        Ok::<_, RunError>(Errors::of(&run(scenario)?).mean_n)
    };
    Ok([with(Parameters::StiffnessAndDamping)?, with(Parameters::Stiffness)?])
}

fn with_fall(scenario: &Scenario, fall_s: f64) -> Scenario {
    let variant = InVivoLikeVariant { fall_s: Some(fall_s), ..InVivoLikeVariant::default() };
    let text = in_vivo_like_variant_csv(RECORDING_SEED, &variant);
    let rows = text.lines().skip(1);
    let mut recorded = rows.filter_map(|row| row.rsplit(',').next()?.parse::<f64>().ok());
    let mut scenario = scenario.clone();
    if let TissueSpec::Recording { force_n, .. } = &mut scenario.tissue {
        let mut last = 0.0;
        let forces: Arc<[f64]> = force_n
            .iter()
            .map(|_| {
                last = recorded.next().unwrap_or(last);
                last
            })
            .collect();
        *force_n = forces;
    }
    scenario
}

pub(super) fn over_falls(classical: &Scenario) -> Result<Varied<Run>, RunError> {
    let of = |index: usize| run(with_fall(classical, FALLS_S[index]));
    Ok(Varied(try_map(FALLS_S.len(), of)?))
}

#[derive(Debug, Clone, Copy)]
pub(super) struct NoisySeed {
    pub(super) derivative_contrast: f64,
    pub(super) residual_contrast: f64,
    pub(super) residual_detects: bool,
    pub(super) moving_average_detects: bool,
}

pub(super) fn detects_both(metrics: &Metrics) -> bool {
    metrics.ruptures.len() == 2 && metrics.missed_ruptures + metrics.false_alarms == 0
}

pub(super) fn in_noise() -> Result<Varied<Vec<NoisySeed>>, RunError> {
    let noise = format!("sensor.force_noise_std_n={ADDED_NOISE_STD_N}");
    let with = |further: &str| load("paper/classical", &[noise.clone(), further.to_owned()]);
    let shipped = with("simulation.seed=0")?;
    let baseline = with("detector.distance=moving-average")?;
    let of_fall = |fall_s: f64| {
        let (shipped, baseline) = (with_fall(&shipped, fall_s), with_fall(&baseline, fall_s));
        let of = |index: usize| {
            let seeded = |scenario: &Scenario| {
                let mut scenario = scenario.clone();
                scenario.seed = index as u64 + 1;
                scenario
            };
            let noisy = run(seeded(&shipped))?;
            Ok::<_, RunError>(NoisySeed {
                derivative_contrast: contrast(&noisy, &squared_changes_n2(&noisy)),
                residual_contrast: contrast(&noisy, &noisy.trace.distance),
                residual_detects: detects_both(&noisy.metrics),
                moving_average_detects: detects_both(&measure(&seeded(&baseline))?),
            })
        };
        try_map(NOISE_SEEDS, of)
    };
    Ok(Varied(FALLS_S.into_iter().map(of_fall).collect::<Result<_, _>>()?))
}

/// The smallest and largest working factor for each of [`FALLS_S`].
pub(super) fn working_thresholds(distance: &str) -> Result<Varied<Option<(f64, f64)>>, RunError> {
    let base = load("paper/classical", &[format!("detector.distance={distance}")])?;
    let steps = -THRESHOLD_STEPS..=THRESHOLD_STEPS;
    let factors: Vec<f64> = steps.map(|step| 2.0_f64.powf(0.5 * f64::from(step))).collect();
    let of_fall = |fall_s: f64| {
        let base = with_fall(&base, fall_s);
        let works = try_map(factors.len(), |index| {
            let mut scenario = base.clone();
            let cusum = &mut scenario.detector.cusum;
            for setting in [&mut cusum.threshold, &mut cusum.drift, &mut cusum.cap] {
                *setting *= factors[index];
            }
            Ok::<_, RunError>(detects_both(&measure(&scenario)?))
        })?;
        let working: Vec<f64> =
            factors.iter().zip(works).filter(|(_, works)| *works).map(|(factor, _)| *factor).collect();
        Ok::<_, RunError>(working.first().copied().zip(working.last().copied()))
    };
    Ok(Varied(FALLS_S.into_iter().map(of_fall).collect::<Result<_, _>>()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_fall_and_the_first_settings_are_the_shipped_ones() {
        let classical = load("paper/classical", &[]).expect("shipped");
        assert_eq!(with_fall(&classical, FALLS_S[0]).tissue, classical.tissue);
        assert_ne!(with_fall(&classical, FALLS_S[1]).tissue, classical.tissue);
        let varied = over_settings("layers/direct-access").expect("runs");
        let shipped = Errors::of(&run(load("layers/direct-access", &[]).expect("shipped")).expect("runs"));
        assert_eq!(varied.0[0].both.mean_n, shipped.mean_n);
        let (low, high) = varied.range(|of| of.both.mean_n);
        assert!(low < shipped.mean_n && shipped.mean_n < high, "{low} {high}");
    }
}
