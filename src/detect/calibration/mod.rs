//! Settings of estimator and detector from the beginning of a recording, for a wanted interval between false alarms.
//!
//! # The rule
//! 1. *Noise* `σ_n` of the force: from second differences ([`spread`]). Dead zone `N_0 = 2 σ_n`, at least the force's
//!    resolution and 1 mN. With 3 σ_n the estimator's bias within the dead zone outgrows the noise.
//! 2. *Contact*, unless given: where force begins, or the line through force and position ends ([`contact`]).
//! 3. *Quiet spread* `σ_0`: the residual's root mean square (its bias included) that nine tenths of blocks of 0.1 s do not
//!    exceed, of those in contact, settled and without a rupture. Ruptures are those that hindsight shows: the decision
//!    crosses, and the force falls by a quarter within 0.1 s while the needle is not drawn back ([`excursions`]).
//!    A segment may be given instead.
//! 4. *Drift* `ν`: where the likelihood ratio of eq. 23 changes its sign for `σ_1² = 100 σ_0²`, the paper's ratio (4.6):
//!    `ν = σ_0² ln(r) r / (r - 1)`. The paper's own, halfway between the variances, lies ten times higher.
//! 5. *Threshold* `γ`: the one for which the average run length to a false alarm is as wanted ([`run_length`]), and at
//!    least twice the largest harmless excursion of the decision in the segment, as no real residual is white.
//! 6. *Memory* of the estimator, in corrections: of those tried, the one that best tells the slowest rupture from the
//!    fastest harmless change, both put into the recording at up to forty moments ([`probe`]). Finding a rupture counts
//!    1, an alarm at a harmless change -3; the middle one is kept unless another does better.
//! 7. *Withdrawal speed* above which nothing counts: three standard deviations of the velocity's noise, at least 0.5 mm/s.
//!
//! The distance is the squared drop: the residual of a tissue that stiffens is large too, and disarms the detector of e².

mod contact;
mod excursions;
mod probe;
pub mod run_length;
mod signal;
mod spread;
mod whiteness;

pub use contact::ContactRule;
pub use whiteness::{LAGS, Whiteness};

use super::{Samples, position_step_m, samples};
use crate::detection::{ArmingSettings, CusumSettings, DetectorSettings, Distance, DistanceKind, Hypotheses};
use crate::error::{InvalidValue, positive, require};
use crate::estimation::{RlsSettings, VelocityFilter};
use crate::scenario::DetectionSpec;
use excursions::{excursions, is_rupture};
use probe::Fall;
use run_length::{Tails, average_run_length, threshold_for};
use signal::{Residuals, Signal};
use spread::{least_step, median, noise_std, quantile, root_mean_square};

/// Memories that are tried, in corrections; the first is kept unless another does better.
const MEMORIES: [f64; 5] = [10.0, 5.0, 7.0, 14.0, 20.0];
const FULL_GAIN_DEPTH_M: f64 = 1e-3;
const GAIN_RATIO: f64 = 10.0;

/// `N_0` in standard deviations of the noise, and the least, in N.
const DEAD_ZONE_STDS: f64 = 2.0;
const LEAST_DEAD_ZONE_N: f64 = 1e-3;

const BLOCK_S: f64 = 0.1;
const FEWEST_BLOCKS: usize = 5;
/// The share of blocks that are no louder than `σ_0`: first with ruptures among them, then without.
const FIRST_SHARE: f64 = 0.75;
const QUIET_SHARE: f64 = 0.9;

/// What is left out around a rupture, in s.
const BEFORE_RUPTURE_S: f64 = 20e-3;
const AFTER_RUPTURE_S: f64 = 0.3;

/// The threshold over the largest harmless excursion.
const GUARD: f64 = 2.0;
const CAP_THRESHOLDS: f64 = 10.0;
const VELOCITY_STDS: f64 = 3.0;
const LEAST_WITHDRAWAL_M_PER_S: f64 = 5e-4;

/// Probes: how far apart and how many, how far from the ends and from ruptures, what force they need, what they take.
const PROBE_EVERY_S: f64 = 0.1;
const MOST_PROBES: usize = 40;
const FEWEST_PROBES: usize = 5;
const PROBES_FROM_S: f64 = 0.7;
const PROBES_TO_END_S: f64 = 0.6;
const PROBE_CLEARANCE_S: f64 = 0.4;
const PROBE_CONTACT_S: f64 = 0.3;
const LEAST_PROBED_N: f64 = 0.5;
const REMAINING_SHARE: f64 = 0.5;
const HARMLESS_PENALTY: f64 = 3.0;

/// The fewest samples that a calibration can be made of.
const FEWEST_SAMPLES: usize = 100;

/// What a calibration is to achieve, and from what.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CalibrationRequest {
    /// How much of the recording is looked at, from its first sample on, in s, above 0.
    pub first_s: f64,
    /// The quiet segment in s after the first sample, if it is given and not found.
    pub quiet_s: Option<(f64, f64)>,
    /// Whether `estimator.contact_m` is taken as it is.
    pub keeps_contact: bool,
    /// Wanted time between false alarms, in s, above 0.
    pub false_alarm_s: f64,
    /// The time in which the slowest rupture takes half of the force, in s, above 0.
    pub slowest_rupture_s: f64,
    /// The time in which the fastest harmless change takes half of the force, in s, above `slowest_rupture_s`.
    pub fastest_harmless_s: f64,
    /// `σ_1²/σ_0²`, above 1.
    pub variance_ratio: f64,
}

impl Default for CalibrationRequest {
    fn default() -> Self {
        Self {
            first_s: 5.0,
            quiet_s: None,
            keeps_contact: false,
            false_alarm_s: 3600.0,
            slowest_rupture_s: 0.03,
            fastest_harmless_s: 0.5,
            variance_ratio: 100.0,
        }
    }
}

impl CalibrationRequest {
    /// Checks the ranges that the fields state.
    ///
    /// # Errors
    /// [`InvalidValue`] naming the option that is out of range.
    pub fn validate(&self) -> Result<(), InvalidValue> {
        positive("--first-s", self.first_s)?;
        positive("--false-alarm-s", self.false_alarm_s)?;
        positive("--slowest-rupture-s", self.slowest_rupture_s)?;
        positive("--fastest-harmless-s", self.fastest_harmless_s)?;
        let slower = self.fastest_harmless_s > self.slowest_rupture_s;
        require("--fastest-harmless-s", self.fastest_harmless_s, slower, "above --slowest-rupture-s")?;
        let grows = self.variance_ratio.is_finite() && self.variance_ratio > 1.0;
        require("--variance-ratio", self.variance_ratio, grows, "a finite number above 1")?;
        if let Some((from_s, to_s)) = self.quiet_s {
            let inside = from_s >= 0.0 && to_s.is_finite() && to_s > from_s;
            require("--quiet-s", to_s, inside, "two times in s, the second one later")?;
        }
        Ok(())
    }
}

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

impl Candidate {
    /// What is maximised.
    fn score(&self) -> f64 {
        self.found_share.unwrap_or(0.0) - HARMLESS_PENALTY * self.harmless_share.unwrap_or(0.0)
    }
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
            let step_m = position_step_m(&position_m, spec.position_resolution_m);
            let mut filter = VelocityFilter::<f64>::new(interval_s, step_m, spec.acceleration_std_m_per_s2)?;
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

/// What every candidate shares.
struct Bench<'a> {
    signal: Signal<'a>,
    request: &'a CalibrationRequest,
    labels: Vec<usize>,
    quiet: Option<std::ops::Range<usize>>,
    noise_n: f64,
    contact: (f64, ContactRule),
    withdrawal_m_per_s: f64,
    /// Drift and threshold of the wanted run length for a variance of 1.
    drift: f64,
    threshold: f64,
}

/// A stretch's quiet, and the settings that follow from it.
struct Quiet {
    std_n: f64,
    blocks: usize,
    usable: Vec<bool>,
    ruptures: Vec<usize>,
    residuals: Residuals,
}

impl<'a> Bench<'a> {
    fn new(
        signal: Signal<'a>,
        spec: &DetectionSpec,
        request: &'a CalibrationRequest,
    ) -> Result<Self, CalibrationError> {
        let noise_n = noise_std(signal.force_n);
        let count = signal.force_n.len();
        let sample = |time_s: f64| ((time_s / signal.interval_s).round() as usize).min(count);
        let quiet = request.quiet_s.map(|(from_s, to_s)| sample(from_s)..sample(to_s));
        if let (Some(range), Some((from_s, to_s))) = (&quiet, request.quiet_s)
            && range.len() < FEWEST_SAMPLES
        {
            let first_s = count as f64 * signal.interval_s;
            return Err(CalibrationError::NoQuiet { from_s, to_s, samples: range.len(), first_s });
        }
        let contact = match request.keeps_contact {
            true => (spec.contact_m, ContactRule::Given),
            false => contact::contact(signal.position_m, signal.force_n, noise_n),
        };
        let ratio = request.variance_ratio;
        let drift = ratio.ln() * ratio / (ratio - 1.0);
        let samples = (request.false_alarm_s / signal.interval_s).clamp(2.0, 1e10);
        Ok(Self {
            request,
            labels: spec.recording.ruptures_s.iter().map(|label| sample(*label)).collect(),
            quiet,
            noise_n,
            contact,
            withdrawal_m_per_s: (VELOCITY_STDS * noise_std(signal.velocity_m_per_s)).max(LEAST_WITHDRAWAL_M_PER_S),
            drift,
            threshold: threshold_for(Tails::Lower, drift, samples),
            signal,
        })
    }

    fn calibrate(&self) -> Result<Calibration, CalibrationError> {
        let tried: Vec<(Candidate, Quiet)> = MEMORIES.iter().map(|&memory| self.candidate(memory)).collect();
        let probes = self.probes(&tried[0].1.ruptures);
        let mut tried: Vec<(Candidate, Quiet)> =
            tried.into_iter().map(|(candidate, quiet)| (self.probed(candidate, &probes), quiet)).collect();
        let best = tried.iter().enumerate().skip(1).fold(0, |best, (index, (candidate, _))| {
            if candidate.score() > tried[best].0.score() + 1e-9 { index } else { best }
        });
        let memory_updates = tried[best].0.memory_updates;
        tried.sort_by(|a, b| a.0.memory_updates.total_cmp(&b.0.memory_updates));
        let chosen = tried.iter().position(|(candidate, _)| candidate.memory_updates == memory_updates).unwrap_or(0);
        let (settings, quiet) = &tried[chosen];
        settings.estimator.validate()?;
        settings.detector.validate()?;
        let interval_s = self.signal.interval_s;
        let segment = longest_run(&quiet.usable);
        let second = |sample: usize| sample as f64 * interval_s;
        let variance = quiet.std_n * quiet.std_n;
        let run_length = average_run_length(Tails::Lower, self.drift, settings.detector.cusum.threshold / variance);
        Ok(Calibration {
            looked_at_s: second(self.signal.force_n.len()),
            interval_s,
            noise_std_n: self.noise_n,
            contact_rule: self.contact.1,
            quiet_std_n: quiet.std_n,
            quiet_blocks: quiet.blocks,
            whiteness: segment.clone().and_then(|range| Whiteness::of(&quiet.residuals.residual_n[range])),
            quiet_segment_s: segment.map(|range| (second(range.start), second(range.end))),
            ruptures_s: quiet.ruptures.iter().map(|&sample| second(sample)).collect(),
            probes: probes.len(),
            chosen,
            false_alarm_s: run_length * interval_s,
            candidates: tried.into_iter().map(|(candidate, _)| candidate).collect(),
        })
    }

    /// The settings for a memory, not probed yet.
    fn candidate(&self, memory_updates: f64) -> (Candidate, Quiet) {
        let dead_zone_n = (DEAD_ZONE_STDS * self.noise_n).max(least_step(self.signal.force_n)).max(LEAST_DEAD_ZONE_N);
        let estimator = RlsSettings::normalised(FULL_GAIN_DEPTH_M, GAIN_RATIO, memory_updates, dead_zone_n);
        let residuals = Residuals::of(&self.signal, &estimator, self.contact.0);
        let quiet = self.quiet_of(residuals, dead_zone_n / DEAD_ZONE_STDS);
        let variance = quiet.std_n * quiet.std_n;
        let (drift, run_length_threshold) = (self.drift * variance, self.threshold * variance);
        let harmless =
            excursions(&self.signal, &quiet.residuals, (drift, run_length_threshold), self.withdrawal_m_per_s);
        let harmless = harmless.iter().filter(|excursion| quiet.usable[excursion.peak_at]);
        let harmless_peak = harmless.map(|excursion| excursion.peak).fold(0.0, f64::max);
        let threshold = run_length_threshold.max(GUARD * harmless_peak);
        let hypotheses = Hypotheses {
            quiet_std_n: quiet.std_n,
            rupture_std_n: quiet.std_n * self.request.variance_ratio.sqrt(),
            ..Hypotheses::default()
        };
        let detector = DetectorSettings {
            distance: Distance { kind: DistanceKind::SquaredDrop, hypotheses },
            cusum: CusumSettings { threshold, drift, cap: CAP_THRESHOLDS * threshold },
            arming: ArmingSettings { withdrawal_speed_m_per_s: self.withdrawal_m_per_s, ..ArmingSettings::default() },
        };
        let candidate = Candidate {
            memory_updates,
            contact_m: self.contact.0,
            estimator,
            detector,
            run_length_threshold,
            harmless_peak,
            found_share: None,
            delay_s: None,
            harmless_share: None,
        };
        (candidate, quiet)
    }

    /// Where the residual is quiet, and how quiet, but no quieter than `least_n`.
    fn quiet_of(&self, residuals: Residuals, least_n: f64) -> Quiet {
        let count = residuals.residual_n.len();
        let first = residuals.in_contact.iter().position(|&touches| touches).unwrap_or(count);
        let settled = first + self.signal.samples_in(ArmingSettings::default().settle_s, 1);
        let mut usable: Vec<bool> =
            residuals.in_contact.iter().enumerate().map(|(sample, &touches)| touches && sample >= settled).collect();
        if let Some(range) = &self.quiet {
            usable.iter_mut().enumerate().for_each(|(sample, usable)| *usable = range.contains(&sample));
            let std_n = root_mean_square(&residuals.residual_n[range.clone()]).max(least_n);
            return Quiet { std_n, blocks: 1, usable, ruptures: vec![], residuals };
        }
        let strike = |usable: &mut [bool], from: usize, to: usize| {
            let from = from.saturating_sub(self.signal.samples_in(BEFORE_RUPTURE_S, 1));
            let to = (to + self.signal.samples_in(AFTER_RUPTURE_S, 1)).min(count);
            usable[from.min(to)..to].fill(false);
        };
        let mut ruptures = self.labels.clone();
        for &label in &self.labels {
            strike(&mut usable, label, label);
        }
        let first_std_n = self.block_std(&residuals, &usable, FIRST_SHARE).map_or(least_n, |(std_n, _)| std_n);
        let variance = first_std_n.max(least_n).powi(2);
        let tuning = (self.drift * variance, self.threshold * variance);
        for excursion in excursions(&self.signal, &residuals, tuning, self.withdrawal_m_per_s) {
            let Some(crossing) = excursion.crossing else { continue };
            if excursion.peak > tuning.1
                && usable[excursion.peak_at]
                && is_rupture(&self.signal, crossing, self.noise_n)
            {
                strike(&mut usable, excursion.from, excursion.to);
                ruptures.push(crossing);
            }
        }
        ruptures.sort_unstable();
        let (std_n, blocks) = self.block_std(&residuals, &usable, QUIET_SHARE).unwrap_or((first_std_n, 0));
        Quiet { std_n: std_n.max(least_n), blocks, usable, ruptures, residuals }
    }

    /// The root mean square that a share of the usable blocks does not exceed, and how many there are; none of too few.
    fn block_std(&self, residuals: &Residuals, usable: &[bool], share: f64) -> Option<(f64, usize)> {
        let length = self.signal.samples_in(BLOCK_S, 10);
        let blocks = residuals.residual_n.chunks_exact(length).zip(usable.chunks_exact(length));
        let loudness: Vec<f64> = blocks
            .filter(|(_, usable)| usable.iter().all(|&usable| usable))
            .map(|(residual, _)| root_mean_square(residual).powi(2))
            .collect();
        let count = loudness.len();
        if count < FEWEST_BLOCKS { None } else { Some((quantile(loudness, share)?.sqrt(), count)) }
    }

    /// Where ruptures are put in: in contact, inserting, under load, away from ruptures and from the ends.
    fn probes(&self, ruptures: &[usize]) -> Vec<usize> {
        let signal = &self.signal;
        let samples_in = |time_s: f64| signal.samples_in(time_s, 1);
        let end = signal.force_n.len().saturating_sub(samples_in(PROBES_TO_END_S));
        let least_n = LEAST_PROBED_N.max(10.0 * self.noise_n);
        let touches = |sample: usize| signal.position_m[sample] > self.contact.0;
        let suits = |&sample: &usize| {
            let clear = ruptures.iter().all(|rupture| rupture.abs_diff(sample) >= samples_in(PROBE_CLEARANCE_S));
            let inserting = signal.velocity_m_per_s[sample] > -self.withdrawal_m_per_s;
            let touching = touches(sample) && touches(sample.saturating_sub(samples_in(PROBE_CONTACT_S)));
            clear && inserting && touching && signal.force_n[sample] > least_n
        };
        let all: Vec<usize> =
            (samples_in(PROBES_FROM_S)..end).step_by(samples_in(PROBE_EVERY_S)).filter(suits).collect();
        let stride = all.len().div_ceil(MOST_PROBES).max(1);
        all.into_iter().step_by(stride).collect()
    }

    /// A candidate with what it makes of the probes.
    fn probed(&self, mut candidate: Candidate, probes: &[usize]) -> Candidate {
        if probes.len() < FEWEST_PROBES {
            return candidate;
        }
        let delays = |duration_s: f64| {
            let fall = Fall { duration_s, remaining_share: REMAINING_SHARE };
            let delays = probe::delays(&self.signal, probes, fall, &candidate);
            let found: Vec<f64> = delays.into_iter().flatten().collect();
            (found.len() as f64 / probes.len() as f64, median(&found))
        };
        let (found_share, delay_s) = delays(self.request.slowest_rupture_s);
        let (harmless_share, _) = delays(self.request.fastest_harmless_s);
        candidate.found_share = Some(found_share);
        candidate.delay_s = delay_s;
        candidate.harmless_share = Some(harmless_share);
        candidate
    }
}

/// The longest run of `true`; none where there is none.
fn longest_run(flags: &[bool]) -> Option<std::ops::Range<usize>> {
    let mut longest: Option<std::ops::Range<usize>> = None;
    let mut start = 0;
    for end in 0..=flags.len() {
        if end < flags.len() && flags[end] {
            continue;
        }
        if end > start && longest.as_ref().is_none_or(|run| end - start > run.len()) {
            longest = Some(start..end);
        }
        start = end + 1;
    }
    longest
}
