use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

use super::RocError;
use super::samples::Samples;
use super::tally::Labels;
use super::trials::Trial;
use crate::run::observe;
use trocar_core::detector::{DetectorInput, DetectorSettings, DistanceKind, DistanceSettings};
use trocar_core::estimation::{AnyEstimator, Estimator, RlsSettings};
use trocar_detect as detect;
use trocar_recording::{Columns, InVivoLikeVariant, Limits, RUPTURES_S, in_vivo_like_variant_csv, read_csv};
use trocar_scenario::{DetectionSpec, RecordingSpec, Scenario, ScenarioError};

/// Differs from the stream of the synthetic recording.
const NOISE_STREAM: u64 = 0x6e_6f69_7365;

/// Seed of the shipped recording.
const SYNTHETIC_SEED: u64 = 1;

#[derive(Debug, Clone)]
pub struct Signal {
    pub name: String,
    pub variant: InVivoLikeVariant,
    pub kind: SignalKind,
    pub estimator: RlsSettings,
    pub contact_m: f64,
    pub detectors: Vec<DetectorSettings>,
}

#[derive(Debug, Clone)]
pub enum SignalKind {
    /// A recording with added noise.
    Recorded(Samples),
    Trials,
    /// Augmentation is off, because it would depend on the threshold.
    ClosedLoop(Box<Scenario>),
}

impl Signal {
    /// Samples are even and have a velocity, as in `trocar detect`.
    pub fn recorded(name: String, spec: &DetectionSpec, kinds: &[DistanceKind]) -> Result<Self, RocError> {
        let detection = detect::detect(spec)?;
        let samples = Samples {
            tick_s: detection.interval_s,
            force_n: detection.measured_force_n,
            position_m: detection.position_m,
            velocity_m_per_s: detection.velocity_m_per_s,
            ruptures_s: spec.recording.ruptures_s.clone(),
        };
        Ok(Self {
            name,
            variant: InVivoLikeVariant::default(),
            kind: SignalKind::Recorded(samples),
            estimator: spec.settings.estimator,
            contact_m: spec.settings.contact_m,
            detectors: detectors(&spec.settings.detector, kinds),
        })
    }

    pub fn synthetic(
        spec: &DetectionSpec,
        variant: InVivoLikeVariant,
        kinds: &[DistanceKind],
    ) -> Result<Self, RocError> {
        let column = |name: &str| name.parse().map_err(|error| ScenarioError::new(format!("{error}")));
        let columns = Columns {
            time: column("time_s")?,
            position: column("position_m")?,
            velocity: Some(column("velocity_m_per_s")?),
            force: column("force_n")?,
        };
        let text = in_vivo_like_variant_csv(SYNTHETIC_SEED, &variant);
        let recording = read_csv("the synthetic insertion", text.as_bytes(), &columns, &Limits::default())
            .map_err(|error| ScenarioError::new(error.to_string()))?;
        let synthetic =
            DetectionSpec { recording: RecordingSpec { recording, ruptures_s: RUPTURES_S.to_vec() }, ..spec.clone() };
        Ok(Self { variant, ..Self::recorded("in_vivo_like".into(), &synthetic, kinds)? })
    }

    pub fn trials(spec: &DetectionSpec, kinds: &[DistanceKind]) -> Self {
        Self {
            name: "trials".into(),
            variant: InVivoLikeVariant::default(),
            kind: SignalKind::Trials,
            estimator: spec.settings.estimator,
            contact_m: 0.0,
            detectors: detectors(&spec.settings.detector, kinds),
        }
    }

    /// # Errors
    /// A scenario with a position resolution, because the engine does not output the quantised positions.
    pub fn closed_loop(mut scenario: Scenario, kinds: &[DistanceKind]) -> Result<Self, RocError> {
        if scenario.sensor.position_resolution_m > 0.0 {
            let message = "sensor.position_resolution_m is not 0, but the study needs exact positions";
            return Err(ScenarioError::new(format!("{}: {message}", scenario.name))
                .remedy("use --set sensor.position_resolution_m=0")
                .into());
        }
        scenario.augmentation.enabled = false;
        Ok(Self {
            name: scenario.name.clone(),
            variant: InVivoLikeVariant::default(),
            estimator: scenario.estimator,
            contact_m: scenario.contact_m,
            detectors: detectors(&scenario.detector, kinds),
            kind: SignalKind::ClosedLoop(Box::new(scenario)),
        })
    }

    pub(super) fn evaluate(
        &self,
        noise_std_n: f64,
        seed: u64,
        within_s: f64,
        input: &mut Vec<DetectorInput<f64>>,
    ) -> Result<Labels, RocError> {
        let labels = |samples: &Samples| {
            Labels::new(samples.ruptures_s.clone(), samples.force_n.len(), samples.tick_s, within_s)
        };
        match &self.kind {
            SignalKind::Recorded(samples) => {
                let mut rng = ChaCha8Rng::seed_from_u64(seed);
                rng.set_stream(NOISE_STREAM);
                self.estimate(samples, self.contact_m, input, || {
                    let noise: f64 = StandardNormal.sample(&mut rng);
                    noise_std_n * noise
                });
                Ok(labels(samples))
            }
            SignalKind::Trials => {
                let trial = Trial::new(Trial::BEFORE_FIRST + seed);
                let labels = Labels::of_trial(&trial, within_s);
                let (contact_m, samples) = (trial.contact_m, trial.samples()?);
                self.estimate(&samples, contact_m, input, || 0.0);
                Ok(labels)
            }
            SignalKind::ClosedLoop(scenario) => {
                let mut noisy = scenario.with_seed(seed);
                noisy.sensor.force_noise_std_n = libm::hypot(noisy.sensor.force_noise_std_n, noise_std_n);
                let mut samples = Samples { tick_s: noisy.grid.tick_s(), ..Samples::default() };
                let metrics = observe(&noisy, &mut samples)?;
                samples.ruptures_s = metrics.ruptures.iter().map(|rupture| rupture.time_s).collect();
                self.estimate(&samples, self.contact_m, input, || 0.0);
                Ok(labels(&samples))
            }
        }
    }

    fn estimate(
        &self,
        samples: &Samples,
        contact_m: f64,
        input: &mut Vec<DetectorInput<f64>>,
        mut noise_n: impl FnMut() -> f64,
    ) {
        let mut estimator = AnyEstimator::<f64>::new(&self.estimator);
        let forces = samples.force_n.iter().zip(&samples.position_m).zip(&samples.velocity_m_per_s);
        input.clear();
        input.extend(forces.map(|((force_n, position_m), &velocity_m_per_s)| {
            let force_n = force_n + noise_n();
            let depth_m = position_m - contact_m;
            let estimate = estimator.update(force_n, depth_m, velocity_m_per_s);
            DetectorInput::new(force_n, depth_m, velocity_m_per_s, &estimate)
        }));
    }
}

/// Settings of other kinds are derived from the same hypotheses.
fn detectors(configured: &DetectorSettings, kinds: &[DistanceKind]) -> Vec<DetectorSettings> {
    let of = |&kind: &DistanceKind| {
        if kind == configured.distance.kind {
            return *configured;
        }
        let mut derived = DetectorSettings::for_kind(kind, configured.distance.hypotheses);
        derived.distance = DistanceSettings { kind, ..configured.distance };
        derived.arming = configured.arming;
        derived
    };
    kinds.iter().map(of).collect()
}
