//! Settings of estimator and detector from the beginning of a recording, for a wanted interval between false alarms.
//!
//! # The rule
//! 1. *Noise* `σ_n` of the force: from second differences (`spread`). Dead zone `N_0 = 2 σ_n`, at least the force's
//!    resolution and 1 mN. With 3 σ_n the estimator's bias within the dead zone outgrows the noise.
//! 2. *Contact*, unless given: where force begins, or the line through force and position ends (`contact`).
//! 3. *Quiet spread* `σ_0`: the residual's root mean square (its bias included) that nine tenths of blocks of 0.1 s do not
//!    exceed, of those in contact, settled and without a rupture. Ruptures are those that hindsight shows: the decision
//!    crosses, and the force falls by a quarter within 0.1 s while the needle is not drawn back (`excursions`).
//!    A segment may be given instead.
//! 4. *Drift* `ν`: where the likelihood ratio of eq. 23 changes its sign for `σ_1² = 100 σ_0²`, the paper's ratio (4.6):
//!    `ν = σ_0² ln(r) r / (r - 1)`. The paper's own, halfway between the variances, lies ten times higher.
//! 5. *Threshold* `γ`: the one for which the average run length to a false alarm is as wanted ([`run_length`]), and at
//!    least twice the largest harmless excursion of the decision in the segment, as no real residual is white.
//! 6. *Memory* of the estimator, in corrections: of those tried, the one that best tells the slowest rupture from the
//!    fastest harmless change, both put into the recording at up to forty moments (`probe`). Finding a rupture counts
//!    1, an alarm at a harmless change -3; the middle one is kept unless another does better.
//! 7. *Withdrawal speed* above which nothing counts: three standard deviations of the velocity's noise, at least 1 mm/s.
//!
//! The distance is the squared drop: the residual of a tissue that stiffens is large too, and disarms the detector of e².

mod bench;
mod contact;
mod excursions;
mod probe;
mod request;
pub mod run_length;
mod signal;
mod spread;
mod whiteness;

pub use contact::ContactRule;
pub use request::CalibrationRequest;
pub use run_length::{RunLength, Tails};
pub use whiteness::{LAGS, Whiteness};

use super::{Samples, position_step_m, samples};
use crate::detection::DetectorSettings;
use crate::error::InvalidValue;
use crate::estimation::{RlsSettings, VelocityFilter};
use crate::scenario::DetectionSpec;
use bench::Bench;
use signal::Signal;

/// The fewest samples that a calibration can be made of.
const FEWEST_SAMPLES: usize = 100;

/// Settings that were tried.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// Corrections between two restorations of the estimator's gain.
    pub memory_updates: f64,
    /// Where the tissue is taken to begin, in m.
    pub contact_m: f64,
    /// The estimator.
    pub estimator: RlsSettings,
    /// The detector.
    pub detector: DetectorSettings,
    /// The threshold that the wanted run length alone asks for, in N².
    pub run_length_threshold: f64,
    /// The largest harmless excursion of the decision, in N².
    pub harmless_peak: f64,
    /// Share of the slowest ruptures put into the recording that are found; none where there was room for none.
    pub found_share: Option<f64>,
    /// Median delay of those that are found, in s.
    pub delay_s: Option<f64>,
    /// Share of the fastest harmless changes put into the recording that raise an alarm.
    pub harmless_share: Option<f64>,
}

/// What came out.
#[derive(Debug, Clone, PartialEq)]
pub struct Calibration {
    /// How much of the recording was looked at, in s.
    pub looked_at_s: f64,
    /// Interval between two samples, in s.
    pub interval_s: f64,
    /// `σ_n`: the force's white noise, in N.
    pub noise_std_n: f64,
    /// How the contact was found.
    pub contact_rule: ContactRule,
    /// `σ_0` in N.
    pub quiet_std_n: f64,
    /// Blocks that `σ_0` was taken from; 0 where there were too few and it is the noise's.
    pub quiet_blocks: usize,
    /// The longest stretch without a rupture, in contact and settled, in s after the first sample.
    pub quiet_segment_s: Option<(f64, f64)>,
    /// Whether the residual in that stretch is white and Gaussian.
    pub whiteness: Option<Whiteness>,
    /// The ruptures that hindsight shows, in s after the first sample.
    pub ruptures_s: Vec<f64>,
    /// How many probes were put into the recording.
    pub probes: usize,
    /// Every memory that was tried, in ascending order.
    pub candidates: Vec<Candidate>,
    /// Which one was taken.
    pub chosen: usize,
    /// Predicted interval between false alarms on white noise of `σ_0`, in s.
    pub false_alarm_s: f64,
}

impl Calibration {
    /// The settings that were chosen.
    #[must_use]
    pub fn settings(&self) -> &Candidate {
        &self.candidates[self.chosen]
    }
}

/// Why a recording cannot be calibrated on.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CalibrationError {
    /// A setting of the request or of the recording is out of range.
    #[error(transparent)]
    Invalid(#[from] InvalidValue),
    /// There is too little of it.
    #[error(
        "{samples} samples are too few to calibrate on, at least {FEWEST_SAMPLES} are needed; give a longer recording or --first-s"
    )]
    TooShort {
        /// How many there are.
        samples: usize,
    },
    /// No threshold can be found for so long or so short a time between false alarms.
    #[error(
        "--false-alarm-s is {wanted_s:?}, must be from {min_s:.3e} to {max_s:.3e} s: 2 to 1e10 samples of this recording, as longer run lengths are not told apart"
    )]
    FalseAlarm {
        /// What was wanted, in s.
        wanted_s: f64,
        /// The least, in s.
        min_s: f64,
        /// The most, in s.
        max_s: f64,
    },
    /// The quiet segment holds too little.
    #[error(
        "the quiet segment from {from_s} to {to_s} s holds {samples} samples of the first {first_s} s, at least {FEWEST_SAMPLES} are needed; move --quiet-s or --first-s"
    )]
    NoQuiet {
        /// Its beginning, in s.
        from_s: f64,
        /// Its end, in s.
        to_s: f64,
        /// How many samples it has.
        samples: usize,
        /// How much was looked at, in s.
        first_s: f64,
    },
}

/// Calibrates on the beginning of a recording; labelled ruptures in it are left out of what is quiet.
///
/// # Errors
/// [`CalibrationError`].
pub fn calibrate(spec: &DetectionSpec, request: &CalibrationRequest) -> Result<Calibration, CalibrationError> {
    request.validate()?;
    let Samples { position_m, velocity_m_per_s, force_n, .. } = samples(&spec.recording.recording);
    let interval_s = spec.recording.recording.median_interval_s();
    let velocity_m_per_s = match velocity_m_per_s {
        Some(velocity) => velocity,
        None => {
            let step_m = position_step_m(&position_m, spec.settings.position_resolution_m);
            let mut filter = VelocityFilter::<f64>::new(interval_s, step_m, spec.settings.acceleration_std_m_per_s2)?;
            position_m.iter().map(|&position| filter.update(position)).collect()
        }
    };
    let count = ((request.first_s / interval_s).ceil() as usize).min(force_n.len());
    if count < FEWEST_SAMPLES {
        return Err(CalibrationError::TooShort { samples: count });
    }
    let signal = Signal {
        interval_s,
        position_m: &position_m[..count],
        velocity_m_per_s: &velocity_m_per_s[..count],
        force_n: &force_n[..count],
    };
    Bench::new(signal, spec, request)?.calibrate()
}
