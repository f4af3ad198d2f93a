//! Plausible numbers of a needle insertion.

use super::offset::offset;
use super::{Detection, LabelMiss, Samples};
use trocar_base::interrupt;
use trocar_base::warning::{Code, Warning};
use trocar_scenario::DetectionSettings;

/// Sampling rates without a warning.
///
/// With the defaults of `trocar calibrate`, the slowest rupture's force falls by half in 30 ms, three samples at the
/// minimum rate. No force sensor samples faster than the maximum.
const RATE_HZ: (f64, f64) = (100.0, 1e5);

/// The largest rupture force of a layer is 19.2 N; handles and phantoms take more.
const MAX_FORCE_N: f64 = 60.0;

/// Above a thousandth of [`MAX_FORCE_N`], and below the largest force of a needle in any tissue of the literature.
const MIN_FORCE_N: f64 = 0.1;

const TRAVEL_M: (f64, f64) = (3e-4, 0.5);

/// Ten times the stiffness of a rig's stiffest layer.
const MAX_STIFFNESS_N_PER_M: f64 = 2e4;

/// Correlation of force and position, while the needle advances, below which the force does not resist. The check needs
/// at least the force in N.
const FALLING: f64 = -0.5;
const MIN_RESISTING_N: f64 = 1.0;

/// Accepted ratio of the slope of the positions to the recorded velocity.
const RATIO: (f64, f64) = (0.5, 2.0);

const SLOPE_SAMPLES: usize = 20;

/// Windows of [`SLOPE_SAMPLES`] summed together, for vectorisation.
const WINDOWS_AT_ONCE: usize = 256;

/// Motion in contact over which a force of at least [`MIN_RESISTING_N`] must change.
const MIN_MOTION_M: f64 = 5e-4;

/// Warns if samples `interval_s` (s) apart are too far apart for a rupture, or closer than sensors sample.
pub fn sampling_rate(interval_s: f64) -> Option<Warning> {
    let rate_hz = 1.0 / interval_s;
    // The measured rate has a tolerance of 1 %.
    let warning = if rate_hz < 0.99 * RATE_HZ.0 {
        let message = format!(
            "the sampling rate is {rate_hz:.3} Hz, below {} Hz: a rupture lasts about 30 ms and can fall between two samples",
            RATE_HZ.0
        );
        Warning::new(Code::LowSamplingRate, message)
    } else if rate_hz > RATE_HZ.1 {
        Warning::new(
            Code::HighSamplingRate,
            format!("the sampling rate is {rate_hz:.3e} Hz, above {:.0e} Hz", RATE_HZ.1),
        )
    } else {
        return None;
    };
    Some(warning.at("--time").remedy("check the unit of the time, as in --time COLUMN:ms; record at 1 kHz or more"))
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Signals<'a> {
    pub(super) time_s: &'a [f64],
    pub(super) position_m: &'a [f64],
    pub(super) velocity_m_per_s: Option<&'a [f64]>,
    pub(super) force_n: &'a [f64],
    pub(super) has_extra_parameter: bool,
    interval_s: f64,
    contact_m: f64,
    drop_n: Option<f64>,
}

impl<'a> Signals<'a> {
    pub(super) fn of(samples: &'a Samples, interval_s: f64, settings: &DetectionSettings) -> Self {
        let distance = &settings.detector.distance;
        Self {
            time_s: &samples.time_s,
            position_m: &samples.position_m,
            velocity_m_per_s: samples.velocity_m_per_s.as_deref(),
            force_n: &samples.force_n,
            has_extra_parameter: settings.estimator.extra_parameter_column().is_some(),
            interval_s,
            contact_m: settings.contact_m,
            drop_n: distance.kind.waits_for().is_none().then_some(distance.hypotheses.rupture_std_n),
        }
    }
}

#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Plausibility {
    peak: Option<usize>,
    magnitudes: Vec<Warning>,
    constant_force: Option<Warning>,
}

impl Plausibility {
    pub(super) fn of(signals: &Signals<'_>) -> Self {
        let Some(peak) = peak(signals.force_n) else { return Self::default() };
        let checks: [&dyn Fn() -> Option<Warning>; 4] =
            [&|| force(signals, peak), &|| travel(signals), &|| velocity(signals), &|| offset(signals)];
        let magnitudes = checks.into_iter().filter_map(|check| check()).collect();
        Self { peak: Some(peak), magnitudes, constant_force: constant_force(signals, peak) }
    }
}

/// About a recording replayed at `interval_s` (s): implausible position (m) or force (N). The remedies name flags,
/// whose keys have the same names.
pub fn recorded_warnings(interval_s: f64, position_m: &[f64], force_n: &[f64]) -> Vec<Warning> {
    let count = position_m.len().min(force_n.len());
    let time_s: Vec<f64> = (0..count).map(|sample| sample as f64 * interval_s).collect();
    let signals = Signals {
        time_s: &time_s,
        position_m: &position_m[..count],
        velocity_m_per_s: None,
        force_n: &force_n[..count],
        has_extra_parameter: false,
        interval_s,
        contact_m: f64::NEG_INFINITY,
        drop_n: None,
    };
    let keys = [
        ("--position", "recording.columns.position_m"),
        ("--force", "recording.columns.force_n"),
        ("--tare-s", "recording.tare_s"),
    ];
    let by_keys = |text: String| keys.iter().fold(text, |text, (flag, key)| text.replace(flag, key));
    let in_keys = |warning: Warning| Warning { place: warning.place.map(by_keys), remedy: None, ..warning };
    let remedy = "correct the columns, recording.scale, the signs or recording.tare_s; `trocar detect` with this scenario shows more";
    Plausibility::of(&signals).magnitudes.into_iter().map(|warning| in_keys(warning).remedy(remedy)).collect()
}

pub(super) fn warnings(detection: &Detection, misses: &[LabelMiss]) -> Vec<Warning> {
    let mut all: Vec<Warning> = misses.iter().map(LabelMiss::warning).collect();
    all.extend(sampling_rate(detection.interval_s));
    let Plausibility { peak, magnitudes, constant_force } = &detection.recorded;
    if let Some(peak) = *peak {
        all.extend_from_slice(magnitudes);
        all.extend(contact(detection, peak));
        all.extend(constant_force.clone());
    }
    all
}

pub(super) fn range(values: &[f64]) -> Option<(f64, f64)> {
    let low = values.iter().copied().reduce(f64::min)?;
    Some((low, values.iter().copied().fold(low, f64::max)))
}

fn peak(values: &[f64]) -> Option<usize> {
    let largest = values.iter().copied().map(f64::abs).reduce(f64::max)?;
    values.iter().rposition(|value| value.abs() == largest)
}

fn force(signals: &Signals<'_>, peak: usize) -> Option<Warning> {
    let peak_n = signals.force_n[peak].abs();
    let unit = "check the unit of the force, as in --force COLUMN:mN or --force COLUMN:gf";
    if peak_n > MAX_FORCE_N {
        let message = format!("the force reaches {peak_n:.3} N; needle insertions stay below {MAX_FORCE_N} N");
        return Some(Warning::new(Code::ForceMagnitude, message).at("--force").remedy(unit));
    }
    if peak_n < MIN_FORCE_N {
        let message =
            format!("the force stays within {peak_n:.3e} N; needle insertions reach at least {MIN_FORCE_N} N");
        return Some(Warning::new(Code::ForceMagnitude, message).at("--force").remedy(unit));
    }
    if let Some(drop_n) = signals.drop_n.filter(|drop_n| peak_n < *drop_n) {
        let message = format!(
            "the force stays within {peak_n:.3e} N, and the detector expects drops of {drop_n} N (detector.rupture_std_n)"
        );
        return Some(Warning::new(Code::ForceMagnitude, message).at("--force").remedy(unit));
    }
    let slope = Slope::of(signals, peak)?;
    if peak_n >= MIN_RESISTING_N && slope.correlation < FALLING && slope.work_j < 0.0 {
        let message = format!(
            "the force falls by {:.0} N/m while the needle advances: it does not resist the insertion",
            -slope.n_per_m
        );
        let remedy = "change the sign of the unit or factor, as in --force COLUMN:-N; or that of --position";
        return Some(Warning::new(Code::ForceSign, message).at("--force or --position").remedy(remedy));
    }
    if peak_n >= MIN_RESISTING_N && slope.correlation > -FALLING && slope.n_per_m > MAX_STIFFNESS_N_PER_M {
        let message = format!(
            "the force rises by {:.3e} N/m while the needle advances, above {MAX_STIFFNESS_N_PER_M:.0e} N/m",
            slope.n_per_m
        );
        let remedy = "check the units of --force and --position";
        return Some(Warning::new(Code::ForceMagnitude, message).at("--force or --position").remedy(remedy));
    }
    None
}

/// While the needle advances, up to the largest force.
struct Slope {
    n_per_m: f64,
    correlation: f64,
    work_j: f64,
}

impl Slope {
    fn of(signals: &Signals<'_>, peak: usize) -> Option<Self> {
        // After the largest force the needle advances in ruptured tissue.
        let pairs = || signals.position_m[..=peak].iter().zip(&signals.force_n[..=peak]);
        let advancing = || {
            pairs()
                .zip(pairs().skip(1))
                .filter(|((x, _), (next, _))| next > x)
                .map(|((x, f), (next, _))| (*x, *f, next - x))
        };
        let (mut count, mut sum_x, mut sum_f) = (0.0, 0.0, 0.0);
        for (x, f, _) in advancing() {
            count += 1.0;
            sum_x += x;
            sum_f += f;
        }
        if count < SLOPE_SAMPLES as f64 {
            return None;
        }
        let (mean_x, mean_f) = (sum_x / count, sum_f / count);
        let (mut xx, mut xf, mut ff, mut work_j) = (0.0, 0.0, 0.0, 0.0);
        for (x, f, step) in advancing() {
            xx += (x - mean_x) * (x - mean_x);
            xf += (x - mean_x) * (f - mean_f);
            ff += (f - mean_f) * (f - mean_f);
            work_j += f * step;
        }
        (xx > 0.0 && ff > 0.0).then(|| Self { n_per_m: xf / xx, correlation: xf / (xx * ff).sqrt(), work_j })
    }
}

fn travel(signals: &Signals<'_>) -> Option<Warning> {
    let (low_m, high_m) = range(signals.position_m)?;
    let (travel_m, (min_m, max_m)) = (high_m - low_m, TRAVEL_M);
    (travel_m > max_m || travel_m < min_m).then(|| {
        let message = format!(
            "the positions span {:.4} mm; needle insertions span {} to {} mm",
            1e3 * travel_m,
            1e3 * min_m,
            1e3 * max_m
        );
        let remedy = "check the unit of the position, as in --position COLUMN:mm";
        Warning::new(Code::PositionMagnitude, message).at("--position").remedy(remedy)
    })
}

fn velocity(signals: &Signals<'_>) -> Option<Warning> {
    let (position, velocity) = (signals.position_m, signals.velocity_m_per_s?);
    let length = SLOPE_SAMPLES as f64 * signals.interval_s;
    let (mut vv, mut vs, mut ss) = (0.0, 0.0, 0.0);
    let windows = velocity.len().saturating_sub(SLOPE_SAMPLES);
    let mut sums = [0.0; WINDOWS_AT_ONCE];
    for first in (0..windows).step_by(WINDOWS_AT_ONCE) {
        interrupt::check();
        let sums = &mut sums[..WINDOWS_AT_ONCE.min(windows - first)];
        sums.fill(-0.0);
        for offset in 1..SLOPE_SAMPLES {
            sums.iter_mut().zip(&velocity[first + offset..]).for_each(|(sum, speed)| *sum += speed);
        }
        for (at, sum) in (first..).zip(sums) {
            let slope = (position[at + SLOPE_SAMPLES] - position[at]) / length;
            let mean = (0.5 * (velocity[at] + velocity[at + SLOPE_SAMPLES]) + *sum) / SLOPE_SAMPLES as f64;
            vv += mean * mean;
            vs += mean * slope;
            ss += slope * slope;
        }
    }
    if vv == 0.0 || ss == 0.0 {
        return None;
    }
    // Noise does not bias the ratio of the magnitudes.
    let ratio = (ss / vv).sqrt() * vs.signum();
    let is_related = vs.abs() > 0.5 * (vv * ss).sqrt();
    (is_related && !(RATIO.0..=RATIO.1).contains(&ratio)).then(|| {
        let message = format!("the slope of --position is {ratio:.3} times --velocity: one of the two columns is wrong");
        let remedy = format!("multiply the factor of --velocity by {ratio:.3}, or divide that of --position by it; or leave --velocity out");
        Warning::new(Code::VelocityMagnitude, message).at("--velocity or --position").remedy(remedy)
    })
}

fn contact(detection: &Detection, peak: usize) -> Option<Warning> {
    let contact_m = detection.contact_m;
    if !detection.touched {
        let (low_m, high_m) = range(&detection.position_m)?;
        let message = format!(
            "the needle never passes the contact position of {contact_m} m: it moves from {low_m:.3e} to {high_m:.3e} m"
        );
        let remedy = "set --contact-m to the surface of the tissue, or change the unit or the sign of --position";
        return Some(Warning::new(Code::NoContact, message).at("--contact-m or --position").remedy(remedy));
    }
    let force = &detection.measured_force_n;
    if force[peak].abs() >= MIN_RESISTING_N && detection.position_m[peak] <= contact_m {
        let message = format!(
            "the largest force, {:.3} N at {:.3} s, acts out of contact: the needle is at {:.3} mm, the contact at {:.3} mm",
            force[peak],
            detection.time_s[peak],
            1e3 * detection.position_m[peak],
            1e3 * contact_m
        );
        let remedy = "give a smaller --contact-m, or change the sign of --position, as in --position COLUMN:-mm";
        return Some(Warning::new(Code::ForceOutOfContact, message).at("--contact-m or --position").remedy(remedy));
    }
    let alarm = detection.alarms.iter().position(|&sample| detection.position_m[sample] <= contact_m)?;
    let sample = detection.alarms[alarm];
    let message = format!(
        "alarm {} at {:.3} s is raised out of contact, at a force of {:.3} N: the needle is at {:.3} mm, the contact at {:.3} mm",
        alarm + 1,
        detection.time_s[sample],
        force[sample],
        1e3 * detection.position_m[sample],
        1e3 * contact_m
    );
    let remedy = "give a smaller --contact-m, or change the sign of --position or --force, as in --force COLUMN:-N";
    Some(Warning::new(Code::ForceOutOfContact, message).at("--contact-m, --position or --force").remedy(remedy))
}

fn constant_force(signals: &Signals<'_>, peak: usize) -> Option<Warning> {
    let (force, position) = (signals.force_n, signals.position_m);
    let mut start = 0;
    let mut longest: Option<(f64, usize, usize)> = None;
    for sample in 1..=force.len() {
        if sample < force.len() && force[sample] == force[start] {
            continue;
        }
        // A value that occurs once is not constant.
        if sample - start > 1 && force[start].abs() >= MIN_RESISTING_N {
            let (low_m, high_m) = range(&position[start..sample])?;
            let travel_m = high_m - low_m.max(signals.contact_m);
            if travel_m >= MIN_MOTION_M && longest.is_none_or(|(other_m, ..)| travel_m > other_m) {
                longest = Some((travel_m, start, sample - 1));
            }
        }
        start = sample;
    }
    let (travel_m, from, to) = longest?;
    let is_largest = force[peak].abs() == force[from].abs();
    let cause = if is_largest {
        "the sensor is at the end of its range"
    } else {
        "its value is not renewed, or has coarse steps"
    };
    let message = format!(
        "the force stays at {:.4} N from {:.4} to {:.4} s, while the needle moves by {:.2} mm: {cause}, and no rupture in this time can be detected",
        force[from],
        signals.time_s[from],
        signals.time_s[to],
        1e3 * travel_m
    );
    let remedy = "use a sensor with a larger range or finer steps, or record its value anew at every sample";
    Some(Warning::new(Code::ConstantForce, message).at("--force").remedy(remedy))
}
