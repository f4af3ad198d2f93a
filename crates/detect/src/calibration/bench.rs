use super::contact::{ContactRule, contact};
use super::excursions::{excursions, is_rupture};
use super::probe::{Fall, delays};
use super::run_length::{WANTED, average_run_length, threshold_for};
use super::signal::{Residuals, Signal};
use super::spread::{median, min_step, noise_std, quantile, root_mean_square};
use super::{Calibration, CalibrationError, CalibrationRequest, Candidate, MIN_SAMPLES, Whiteness};
use trocar_core::detector::{ArmingSettings, CusumSettings, DetectorSettings, DistanceKind, Hypotheses};
use trocar_core::estimation::RlsSettings;
use trocar_scenario::DetectionSpec;

/// The first candidate wins a tie.
const MEMORIES: [f64; 5] = [10.0, 5.0, 7.0, 14.0, 20.0];
const FULL_GAIN_DEPTH_M: f64 = 1e-3;
const GAIN_RATIO: f64 = 10.0;

/// Standard deviations of the noise.
const DEAD_ZONE_STDS: f64 = 2.0;
const MIN_DEAD_ZONE_N: f64 = 1e-3;

const BLOCK_S: f64 = 0.1;
const MIN_BLOCKS: usize = 5;
/// Gives `σ_0` while the residual still contains ruptures.
const FIRST_SHARE: f64 = 0.75;
const QUIET_SHARE: f64 = 0.9;

const BEFORE_RUPTURE_S: f64 = 20e-3;
const AFTER_RUPTURE_S: f64 = 0.3;

const GUARD: f64 = 2.0;
const CAP_THRESHOLDS: f64 = 10.0;
const VELOCITY_STDS: f64 = 3.0;
/// A hand-held needle recoils at about 0.7 mm/s.
const MIN_WITHDRAWAL_M_PER_S: f64 = 1e-3;

const PROBE_EVERY_S: f64 = 0.1;
const MAX_PROBES: usize = 40;
const MIN_PROBES: usize = 5;
const PROBES_FROM_S: f64 = 0.7;
const PROBES_TO_END_S: f64 = 0.6;
const PROBE_CLEARANCE_S: f64 = 0.4;
const PROBE_CONTACT_S: f64 = 0.3;
const MIN_PROBED_N: f64 = 0.5;
const REMAINING_SHARE: f64 = 0.5;
const HARMLESS_PENALTY: f64 = 3.0;

pub(super) struct CandidateBench<'a> {
    signal: Signal<'a>,
    request: &'a CalibrationRequest,
    labels: Vec<usize>,
    quiet: Option<std::ops::Range<usize>>,
    noise_n: f64,
    contact: (f64, ContactRule),
    withdrawal_m_per_s: f64,
    /// At a variance of 1.
    drift: f64,
    threshold: f64,
}

struct Quiet {
    std_n: f64,
    blocks: usize,
    usable: Vec<bool>,
    ruptures: Vec<usize>,
    residuals: Residuals,
}

impl<'a> CandidateBench<'a> {
    pub(super) fn new(
        signal: Signal<'a>,
        spec: &DetectionSpec,
        request: &'a CalibrationRequest,
    ) -> Result<Self, CalibrationError> {
        let noise_n = noise_std(signal.force_n);
        let count = signal.force_n.len();
        let sample = |time_s: f64| ((time_s / signal.interval_s).round() as usize).min(count);
        let quiet = request.quiet_s.map(|(from_s, to_s)| sample(from_s)..sample(to_s));
        if let (Some(range), Some((from_s, to_s))) = (&quiet, request.quiet_s)
            && range.len() < MIN_SAMPLES
        {
            let first_s = count as f64 * signal.interval_s;
            return Err(CalibrationError::NoQuiet { from_s, to_s, samples: range.len(), first_s });
        }
        let contact = match request.keeps_contact {
            true => (spec.settings.contact_m, ContactRule::Given),
            false => {
                let (contact_m, rule) = contact(signal.position_m, signal.force_n, noise_n);
                (rounded(contact_m), rule)
            }
        };
        let drift = request.drift();
        let samples = request.false_alarm_s / signal.interval_s;
        if !WANTED.contains(&samples) {
            let [min_s, max_s] = [WANTED.start(), WANTED.end()].map(|samples| samples * signal.interval_s);
            return Err(CalibrationError::FalseAlarm { wanted_s: request.false_alarm_s, min_s, max_s });
        }
        Ok(Self {
            request,
            labels: spec.recording.ruptures_s.iter().map(|label| sample(*label)).collect(),
            quiet,
            noise_n,
            contact,
            withdrawal_m_per_s: rounded(
                (VELOCITY_STDS * noise_std(signal.velocity_m_per_s)).max(MIN_WITHDRAWAL_M_PER_S),
            ),
            drift,
            threshold: threshold_for(drift, samples),
            signal,
        })
    }

    pub(super) fn calibrate(&self, report: &dyn Fn(usize, usize)) -> Result<Calibration, CalibrationError> {
        let steps = 2 * MEMORIES.len();
        let candidate = |(step, &memory): (usize, &f64)| {
            report(step, steps);
            self.candidate(memory)
        };
        let tried: Vec<(Candidate, Quiet)> = MEMORIES.iter().enumerate().map(candidate).collect();
        let probes = self.probes(&tried[0].1.ruptures);
        let probed = |(step, (candidate, quiet)): (usize, (Candidate, Quiet))| {
            report(MEMORIES.len() + step, steps);
            (self.probed(candidate, &probes), quiet)
        };
        let mut tried: Vec<(Candidate, Quiet)> = tried.into_iter().enumerate().map(probed).collect();
        report(steps, steps);
        let best = tried.iter().enumerate().skip(1).fold(0, |best, (index, (candidate, _))| {
            if score(candidate) > score(&tried[best].0) + 1e-9 { index } else { best }
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
        let run_length = average_run_length(self.drift, settings.detector.cusum.threshold / variance);
        let whiteness = segment.clone().and_then(|range| Whiteness::of(&quiet.residuals.residual_n[range]));
        let is_predictable = quiet.blocks > 0 && whiteness.is_some_and(|test| !test.is_rejected());
        let usable = quiet.usable.iter().filter(|usable| **usable).count();
        Ok(Calibration {
            looked_at_s: second(self.signal.force_n.len()),
            interval_s,
            noise_std_n: self.noise_n,
            contact_rule: self.contact.1,
            quiet_std_n: quiet.std_n,
            quiet_blocks: quiet.blocks,
            whiteness,
            quiet_segment_s: segment.map(|range| (second(range.start), second(range.end))),
            ruptures_s: quiet.ruptures.iter().map(|&sample| second(sample)).collect(),
            probes: probes.len(),
            chosen,
            false_alarm_s: is_predictable.then_some(run_length * interval_s),
            quiet_s: second(usable),
            candidates: tried.into_iter().map(|(candidate, _)| candidate).collect(),
        })
    }

    fn candidate(&self, memory_updates: f64) -> (Candidate, Quiet) {
        let dead_zone_n = (DEAD_ZONE_STDS * self.noise_n).max(min_step(self.signal.force_n)).max(MIN_DEAD_ZONE_N);
        let dead_zone_n = rounded(dead_zone_n);
        let estimator = RlsSettings::normalised(FULL_GAIN_DEPTH_M, GAIN_RATIO, memory_updates, dead_zone_n);
        let residuals = Residuals::of(&self.signal, &estimator, self.contact.0);
        let quiet = self.quiet_of(residuals, dead_zone_n / DEAD_ZONE_STDS);
        let variance = quiet.std_n * quiet.std_n;
        let (drift, run_length_threshold) = (rounded(self.drift * variance), self.threshold * variance);
        let harmless =
            excursions(&self.signal, &quiet.residuals, (drift, run_length_threshold), self.withdrawal_m_per_s);
        let harmless = harmless.iter().filter(|excursion| quiet.usable[excursion.peak_at]);
        let harmless_peak = harmless.map(|excursion| excursion.peak).fold(0.0, f64::max);
        let threshold = rounded(run_length_threshold.max(GUARD * harmless_peak));
        let hypotheses = Hypotheses {
            quiet_std_n: rounded(quiet.std_n),
            rupture_std_n: rounded(quiet.std_n * self.request.variance_ratio.sqrt()),
            ..Hypotheses::default()
        };
        let detector = DetectorSettings {
            cusum: CusumSettings { threshold, drift, cap: rounded(CAP_THRESHOLDS * threshold) },
            arming: ArmingSettings { withdrawal_speed_m_per_s: self.withdrawal_m_per_s, ..ArmingSettings::default() },
            ..DetectorSettings::for_kind(DistanceKind::SquaredResidual, hypotheses)
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

    fn quiet_of(&self, residuals: Residuals, min_n: f64) -> Quiet {
        let count = residuals.residual_n.len();
        let first = residuals.depth_m.iter().position(|&depth_m| depth_m > 0.0).unwrap_or(count);
        let settled = first.saturating_add(self.signal.samples_in(ArmingSettings::default().settle_s, 1));
        let mut usable: Vec<bool> =
            residuals.depth_m.iter().enumerate().map(|(sample, &depth_m)| depth_m > 0.0 && sample >= settled).collect();
        if let Some(range) = &self.quiet {
            usable.iter_mut().enumerate().for_each(|(sample, usable)| *usable = range.contains(&sample));
            let std_n = root_mean_square(&residuals.residual_n[range.clone()]).max(min_n);
            return Quiet { std_n, blocks: 1, usable, ruptures: vec![], residuals };
        }
        let exclude = |usable: &mut [bool], from: usize, to: usize| {
            let from = from.saturating_sub(self.signal.samples_in(BEFORE_RUPTURE_S, 1));
            let to = to.saturating_add(self.signal.samples_in(AFTER_RUPTURE_S, 1)).min(count);
            usable[from.min(to)..to].fill(false);
        };
        let mut ruptures = self.labels.clone();
        for &label in &self.labels {
            exclude(&mut usable, label, label);
        }
        let first_std_n = self.block_std(&residuals, &usable, FIRST_SHARE).map_or(min_n, |(std_n, _)| std_n);
        let variance = first_std_n.max(min_n).powi(2);
        let tuning = (self.drift * variance, self.threshold * variance);
        for excursion in excursions(&self.signal, &residuals, tuning, self.withdrawal_m_per_s) {
            let Some(crossing) = excursion.crossing else { continue };
            if excursion.peak > tuning.1
                && usable[excursion.peak_at]
                && is_rupture(&self.signal, crossing, self.noise_n)
            {
                exclude(&mut usable, excursion.from, excursion.to);
                ruptures.push(crossing);
            }
        }
        ruptures.sort_unstable();
        let (std_n, blocks) = self.block_std(&residuals, &usable, QUIET_SHARE).unwrap_or((first_std_n, 0));
        Quiet { std_n: std_n.max(min_n), blocks, usable, ruptures, residuals }
    }

    /// Quantile of the usable blocks' root mean square, and their number.
    fn block_std(&self, residuals: &Residuals, usable: &[bool], share: f64) -> Option<(f64, usize)> {
        let length = self.signal.samples_in(BLOCK_S, 10);
        let blocks = residuals.residual_n.chunks_exact(length).zip(usable.chunks_exact(length));
        let mean_squares: Vec<f64> = blocks
            .filter(|(_, usable)| usable.iter().all(|&usable| usable))
            .map(|(residual, _)| root_mean_square(residual).powi(2))
            .collect();
        let count = mean_squares.len();
        if count < MIN_BLOCKS { None } else { Some((quantile(mean_squares, share)?.sqrt(), count)) }
    }

    /// Samples in contact, inserting, under load, away from ruptures and ends.
    fn probes(&self, ruptures: &[usize]) -> Vec<usize> {
        let signal = &self.signal;
        let samples_in = |time_s: f64| signal.samples_in(time_s, 1);
        let end = signal.force_n.len().saturating_sub(samples_in(PROBES_TO_END_S));
        let min_n = MIN_PROBED_N.max(10.0 * self.noise_n);
        let in_contact = |sample: usize| signal.position_m[sample] > self.contact.0;
        let suits = |&sample: &usize| {
            let clear = ruptures.iter().all(|rupture| rupture.abs_diff(sample) >= samples_in(PROBE_CLEARANCE_S));
            let inserting = signal.velocity_m_per_s[sample] > -self.withdrawal_m_per_s;
            let touching = in_contact(sample) && in_contact(sample.saturating_sub(samples_in(PROBE_CONTACT_S)));
            clear && inserting && touching && signal.force_n[sample] > min_n
        };
        let all: Vec<usize> =
            (samples_in(PROBES_FROM_S)..end).step_by(samples_in(PROBE_EVERY_S)).filter(suits).collect();
        let stride = all.len().div_ceil(MAX_PROBES).max(1);
        all.into_iter().step_by(stride).collect()
    }

    fn probed(&self, mut candidate: Candidate, probes: &[usize]) -> Candidate {
        if probes.len() < MIN_PROBES {
            return candidate;
        }
        let share = |duration_s: f64| {
            let fall = Fall { duration_s, remaining_share: REMAINING_SHARE };
            let delays = delays(&self.signal, probes, fall, &candidate);
            let found: Vec<f64> = delays.into_iter().flatten().collect();
            (found.len() as f64 / probes.len() as f64, median(&found))
        };
        let (found_share, delay_s) = share(self.request.slowest_rupture_s);
        let (harmless_share, _) = share(self.request.fastest_harmless_s);
        candidate.found_share = Some(found_share);
        candidate.delay_s = delay_s;
        candidate.harmless_share = Some(harmless_share);
        candidate
    }
}

fn score(candidate: &Candidate) -> f64 {
    candidate.found_share.unwrap_or(0.0) - HARMLESS_PENALTY * candidate.harmless_share.unwrap_or(0.0)
}

fn rounded(value: f64) -> f64 {
    format!("{value:.3e}").parse().unwrap_or(value)
}

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
