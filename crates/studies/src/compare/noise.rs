use schemars::JsonSchema;
use serde::Serialize;

use crate::run::{RunError, measure, observe};
use trocar_core::time::nearest_ticks;
use trocar_engine::engine::{Observer, Signals};
use trocar_metrics::Metrics;
use trocar_metrics::metrics;
use trocar_scenario::Scenario;

/// The paper's 6.25e-4 N² (4.1).
pub const ADDED_NOISE_STD_N: f64 = 0.025;

const RUPTURE_S: f64 = 0.1;

metrics! {
    /// The detection of a scenario with white noise added to its force, by the scenario's detector and by the paper's
    /// baseline.
    #[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
    #[schemars(transform = trocar_metrics::schema::with_units(Self::METRICS))]
    pub struct NoiseCheck in Noise {
        /// Standard deviation of the added noise, in N.
        added_noise_std_n: f64;
        /// Number of ruptures.
        ruptures: u64;
        /// Ruptures missed when the scenario is run again with 0.025 N of added force noise.
        missed_ruptures: u64 = "missed ruptures", Count, Lower;
        /// False alarms when the scenario is run again with the added force noise.
        false_alarms: u64 = "false alarms", Count, Lower;
        /// Ruptures missed in the added noise by the derivative CUSUM, the baseline of the paper.
        derivative_missed_ruptures: u64 = "missed ruptures, derivative CUSUM", Count, Lower;
        /// False alarms of the derivative CUSUM in the added noise.
        derivative_false_alarms: u64 = "false alarms, derivative CUSUM", Count, Lower;
        /// The highest threshold on the squared change, in N², that still detects every rupture; `None` without ruptures.
        derivative_threshold_n2: Option<f64>;
        /// Samples away from ruptures whose squared change exceeds the highest threshold that detects all ruptures.
        derivative_exceedances: Option<u64> = "false samples, derivative at best", Count, Lower;
    }
}

pub fn check_in_noise(scenario: &Scenario) -> Result<NoiseCheck, RunError> {
    let mut noisy = scenario.clone();
    noisy.sensor.force_noise_std_n = libm::hypot(noisy.sensor.force_noise_std_n, ADDED_NOISE_STD_N);
    let mut derivatives = Derivatives::new(scenario);
    let observed = observe(&noisy, &mut derivatives)?;
    let baseline = measure(&derivative_baseline(&noisy))?;
    let threshold = derivatives.threshold();
    let missed = |metrics: &Metrics| metrics.missed_ruptures;
    Ok(NoiseCheck {
        added_noise_std_n: ADDED_NOISE_STD_N,
        ruptures: observed.ruptures.len() as u64,
        missed_ruptures: missed(&observed),
        false_alarms: observed.false_alarms,
        derivative_missed_ruptures: missed(&baseline),
        derivative_false_alarms: baseline.false_alarms,
        derivative_threshold_n2: threshold,
        derivative_exceedances: threshold.map(|threshold| derivatives.exceedances(threshold)),
    })
}

/// The derivative is the distance; the thresholds are from the paper's variances.
fn derivative_baseline(scenario: &Scenario) -> Scenario {
    use trocar_core::detector::{DetectorSettings, DistanceKind};
    let mut baseline = scenario.clone();
    let hypotheses = scenario.detector.distance.hypotheses;
    let arming = scenario.detector.arming;
    baseline.detector =
        DetectorSettings { arming, ..DetectorSettings::for_kind(DistanceKind::ForceDerivative, hypotheses) };
    baseline
}

/// `(f_k - f_{k-1})²` after ruptures and at all other times.
struct Derivatives {
    last_n: Option<f64>,
    rupture_ticks: u64,
    rupture: Option<u64>,
    peaks: Vec<f64>,
    elsewhere: Vec<f64>,
}

impl Derivatives {
    fn new(scenario: &Scenario) -> Self {
        Self {
            last_n: None,
            rupture_ticks: nearest_ticks(RUPTURE_S, scenario.grid.tick_s()),
            rupture: None,
            peaks: Vec::with_capacity(16),
            elsewhere: Vec::with_capacity(scenario.grid.ticks() as usize),
        }
    }

    fn threshold(&self) -> Option<f64> {
        self.peaks.iter().copied().reduce(f64::min)
    }

    fn exceedances(&self, threshold: f64) -> u64 {
        self.elsewhere.iter().filter(|&&square| square >= threshold).count() as u64
    }
}

impl Observer<f64> for Derivatives {
    fn observe(&mut self, s: &Signals<f64>) {
        let change = self.last_n.map_or(0.0, |last| s.measured_force_n - last);
        self.last_n = Some(s.measured_force_n);
        let square = change * change;
        match self.rupture.filter(|rupture| s.tick - rupture <= self.rupture_ticks) {
            Some(rupture) if s.tick == rupture + 1 => self.peaks.push(square),
            Some(_) => {
                if let Some(peak) = self.peaks.last_mut() {
                    *peak = peak.max(square);
                }
            }
            None => self.elsewhere.push(square),
        }
        if s.ruptured {
            self.rupture = Some(s.tick);
        }
    }
}
