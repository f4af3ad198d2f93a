//! Settings of estimator and detector from the beginning of a recording, for a wanted time between false alarms.
//!
//! 1. *Noise* `σ_n` of the force, from second differences. The dead zone `N_0` is `2 σ_n`, at least the resolution and
//!    1 mN; with `3 σ_n` the bias within it exceeds the noise.
//! 2. *Contact*, unless given: where the force begins, or the zero of the line of force over position.
//! 3. *Quiet standard deviation* `σ_0`: the root mean square of the residual that nine tenths of the 0.1 s blocks in
//!    contact and without rupture do not exceed.
//! 4. *Drift* `ν`: where the likelihood ratio of eq. 23 changes its sign for `r = σ_1²/σ_0² = 100` (paper, 4.6):
//!    `ν = σ_0² ln(r) r / (r - 1)`. The paper's drift is ten times higher.
//! 5. *Threshold* `γ`: gives the wanted run length ([`run_length`]), and is at least twice the largest harmless
//!    excursion, because a real residual is not white.
//! 6. *Memory*: best separates the slowest rupture from the fastest harmless change, both added to the recording. A
//!    detection scores 1, an alarm at a harmless change -3.
//! 7. *Withdrawal speed*, above which no sample counts: three standard deviations of the velocity noise.

mod bench;
mod contact;
mod document;
mod excursions;
mod probe;
mod request;
pub mod run_length;
mod signal;
mod spread;
mod whiteness;

pub use contact::ContactRule;
pub use document::{CalibrationFile, CalibrationStudy, run_lengths_document};
pub use request::CalibrationRequest;
pub use run_length::RunLength;
pub(super) use spread::noise_std;
pub use whiteness::{LAGS, Whiteness};

use super::even::{is_even, samples};
use super::position_step_m;
use bench::CandidateBench;
use signal::Signal;
use trocar_base::warning::{Code, Warning};
use trocar_core::detector::DetectorSettings;
use trocar_core::error::InvalidValue;
use trocar_core::estimation::{RlsSettings, VelocityFilter};
use trocar_scenario::DetectionSpec;

/// Below it a warning says that slow ruptures are missed.
const MIN_FOUND: f64 = 0.5;
const MAX_HARMLESS: f64 = 0.2;

const MIN_SAMPLES: usize = 100;

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// Corrections between two resets of the estimator's gain.
    pub memory_updates: f64,
    pub contact_m: f64,
    pub estimator: RlsSettings,
    pub detector: DetectorSettings,
    /// N², before the guard against harmless excursions.
    pub run_length_threshold: f64,
    /// N².
    pub harmless_peak: f64,
    /// Share of the slowest probes; `None` if too few probes fit.
    pub found_share: Option<f64>,
    /// Median over the detected probes.
    pub delay_s: Option<f64>,
    /// Share of the fastest harmless changes.
    pub harmless_share: Option<f64>,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Calibration {
    pub looked_at_s: f64,
    pub interval_s: f64,
    /// `σ_n`: white noise of the force.
    pub noise_std_n: f64,
    pub contact_rule: ContactRule,
    /// `σ_0`.
    pub quiet_std_n: f64,
    /// 0 if the noise gives `σ_0`.
    pub quiet_blocks: usize,
    /// In contact and without a rupture, in s after the first sample.
    pub quiet_segment_s: Option<(f64, f64)>,
    /// Of the residual in that interval.
    pub whiteness: Option<Whiteness>,
    /// In s after the first sample.
    pub ruptures_s: Vec<f64>,
    pub probes: usize,
    /// Ascending memories.
    pub candidates: Vec<Candidate>,
    pub chosen: usize,
    /// `None` unless the quiet residual is white and Gaussian.
    pub false_alarm_s: Option<f64>,
    /// Quiet contact without an alarm.
    pub quiet_s: f64,
}

/// `-ln 0.05`: with this expected number, no false alarm has a probability of 5 %.
const NONE_EXPECTED: f64 = 2.995_732_273_553_991;

impl Calibration {
    /// Lower bound with 95 % confidence.
    pub fn least_false_alarm_s(&self) -> f64 {
        self.quiet_s / NONE_EXPECTED
    }

    pub fn settings(&self) -> &Candidate {
        &self.candidates[self.chosen]
    }

    pub fn warnings(&self) -> Vec<Warning> {
        let Candidate { found_share, harmless_share, .. } = self.settings();
        let missed = found_share.filter(|share| *share < MIN_FOUND).map(|share| {
            let message = format!("the settings detect {:.0} % of the slowest inserted ruptures", 100.0 * share);
            Warning::new(Code::SlowRupturesMissed, message).at("--slowest-rupture-s").remedy(
                "give a longer --first-s, accept more false alarms (--false-alarm-s), or a faster --slowest-rupture-s",
            )
        });
        let harmless = harmless_share.filter(|share| *share > MAX_HARMLESS).map(|share| {
            let message =
                format!("the settings raise an alarm at {:.0} % of the inserted harmless changes", 100.0 * share);
            Warning::new(Code::HarmlessAlarms, message)
                .at("--fastest-harmless-s")
                .remedy("give a longer --first-s, or a slower --fastest-harmless-s if the tissue changes more slowly")
        });
        missed.into_iter().chain(harmless).collect()
    }
}

#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CalibrationError {
    #[error(transparent)]
    Invalid(#[from] InvalidValue),
    #[error(
        "{samples} samples are too few for a calibration, which needs at least {MIN_SAMPLES}; give a longer recording or --first-s"
    )]
    TooShort {
        /// Samples of the evaluated part.
        samples: usize,
    },
    #[error(
        "--false-alarm-s is {wanted_s:?}, must be from {min_s:.3e} to {max_s:.3e} s: 2 to 1e10 samples of this recording; longer run lengths cannot be distinguished"
    )]
    FalseAlarm {
        wanted_s: f64,
        /// Range of [`run_length::WANTED`].
        min_s: f64,
        max_s: f64,
    },
    #[error(
        "the quiet segment from {from_s} to {to_s} s has {samples} samples of the first {first_s} s, but needs at least {MIN_SAMPLES}; move --quiet-s or --first-s"
    )]
    NoQuiet {
        /// In s after the first sample.
        from_s: f64,
        to_s: f64,
        samples: usize,
        first_s: f64,
    },
}

pub fn calibrate(spec: &DetectionSpec, request: &CalibrationRequest) -> Result<Calibration, CalibrationError> {
    calibrate_with_progress(spec, request, &|_, _| ())
}

/// `report` receives the numbers of complete and of all steps.
pub fn calibrate_with_progress(
    spec: &DetectionSpec,
    request: &CalibrationRequest,
    report: &dyn Fn(usize, usize),
) -> Result<Calibration, CalibrationError> {
    request.validate()?;
    let recording = &spec.recording.recording;
    let resampled = (!is_even(recording)).then(|| samples(recording.clone()));
    let (position_m, velocity_m_per_s, force_n) = match &resampled {
        Some(even) => (&*even.position_m, even.velocity_m_per_s.as_deref(), &*even.force_n),
        None => (recording.position_m(), recording.velocity_m_per_s(), recording.force_n()),
    };
    let interval_s = resampled.as_ref().map_or(recording.median_interval_s(), |even| even.interval_s);
    let filtered: Vec<f64>;
    let velocity_m_per_s = match velocity_m_per_s {
        Some(velocity) => velocity,
        None => {
            let step_m = position_step_m(position_m, spec.settings.position_resolution_m);
            let mut filter = VelocityFilter::<f64>::new(interval_s, step_m, spec.settings.acceleration_std_m_per_s2)?;
            filtered = position_m.iter().map(|&position| filter.update(position)).collect();
            &filtered
        }
    };
    let count = ((request.first_s / interval_s).ceil() as usize).min(force_n.len());
    if count < MIN_SAMPLES {
        return Err(CalibrationError::TooShort { samples: count });
    }
    let signal = Signal {
        interval_s,
        position_m: &position_m[..count],
        velocity_m_per_s: &velocity_m_per_s[..count],
        force_n: &force_n[..count],
    };
    CandidateBench::new(signal, spec, request)?.calibrate(report)
}
