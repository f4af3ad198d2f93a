use super::calibration::noise_std;
use super::plausibility::{Signals, range};
use super::position_step_m;
use trocar_base::interrupt;
use trocar_base::warning::{Code, Warning};

const MIN_SAMPLES: usize = 100;

/// Minimum ratio of roughness at which the columns count as swapped. In this project's recordings, positions are 2.2 to
/// 12,000 times *less* rough than forces: a needle has mass and a guide.
const SWAPPED_RATIO: f64 = 3.0;

/// Roughness that the encoder explains, in its steps.
const ENCODER_STEPS: f64 = 5.0;

const BLOCK: usize = 20;

/// A free needle moves at least so far at constant force.
const FREE_TRAVEL_M: f64 = 5e-4;
const MIN_OFFSET_N: f64 = 0.05;
const CONSTANT_STDS: f64 = 3.0;
const CONSTANT_N: f64 = 0.02;

/// Share of the largest change of the force. A larger constant force is a load.
const MAX_OFFSET_SHARE: f64 = 0.5;

fn roughness(values: &[f64]) -> Option<(f64, f64)> {
    let (low, high) = range(values)?;
    let mut sum = 0.0;
    for (sample, w) in values.windows(3).enumerate() {
        interrupt::check_at(sample as u64);
        sum += (w[2] - 2.0 * w[1] + w[0]).powi(2);
    }
    (high > low).then(|| ((sum / values.len().saturating_sub(2).max(1) as f64).sqrt(), high - low))
}

pub(super) fn swapped(signals: &Signals<'_>) -> Option<Warning> {
    if signals.position_m.len() < MIN_SAMPLES {
        return None;
    }
    let (position_m, travel_m) = roughness(signals.position_m)?;
    let (force_n, span_n) = roughness(signals.force_n)?;
    let ratio = (position_m / travel_m) / (force_n / span_n).max(f64::MIN_POSITIVE);
    let is_encoder = position_m <= ENCODER_STEPS * position_step_m(signals.position_m, 0.0);
    (ratio > SWAPPED_RATIO && !is_encoder).then(|| {
        let times = if ratio > 1e3 { "over 1000 times".to_owned() } else { format!("{ratio:.0} times") };
        let message = format!(
            "the second difference of the position is {:.2e} of its range (root mean square), {times} that of the \
             force: the columns of position and force seem to be swapped",
            position_m / travel_m
        );
        let remedy = "exchange --position and --force, each with its unit";
        Warning::new(Code::ColumnsSwapped, message).at("--position and --force").remedy(remedy)
    })
}

pub(super) fn offset(signals: &Signals<'_>) -> Option<Warning> {
    if signals.force_n.len() < MIN_SAMPLES {
        return None;
    }
    free_motion(signals).or_else(|| beginning(signals))
}

fn free_motion(signals: &Signals<'_>) -> Option<Warning> {
    let (force, position) = (signals.force_n, signals.position_m);
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len().max(1) as f64;
    let first_n = mean(&force[..BLOCK]);
    let tolerance_n = (CONSTANT_STDS * noise_std(force)).max(CONSTANT_N);
    let blocks = force.chunks_exact(BLOCK).take_while(|block| (mean(block) - first_n).abs() <= tolerance_n).count();
    let end = blocks * BLOCK;
    // Constant to the end: no information about the contact.
    if end + BLOCK > force.len() {
        return None;
    }
    let offset_n = mean(&force[..end]);
    let (low_m, high_m) = range(&position[..end])?;
    let largest_n = force.iter().map(|force_n| (force_n - offset_n).abs()).fold(0.0, f64::max);
    let is_offset = offset_n.abs() > tolerance_n.max(MIN_OFFSET_N) && offset_n.abs() < MAX_OFFSET_SHARE * largest_n;
    (is_offset && high_m - low_m >= FREE_TRAVEL_M).then(|| {
        let end_s = signals.time_s[end - 1] - signals.time_s[0];
        let message = format!(
            "in the first {end_s:.3} s the needle moves by {:.2} mm and the force stays at {offset_n:.3} N, which is \
             not 0: the sensor seems not to be tared",
            1e3 * (high_m - low_m)
        );
        let remedy = format!(
            "subtract it with --tare-s {:.3} (recording.tare_s), if the needle is free until then; otherwise the \
             recording begins in the tissue",
            0.5 * end_s
        );
        Warning::new(Code::ForceOffset, message).at("--tare-s or --force").remedy(remedy)
    })
}

/// Warns of a first force that exceeds all later changes, or that pulls at the needle.
fn beginning(signals: &Signals<'_>) -> Option<Warning> {
    let force = signals.force_n;
    let first_n = force[..BLOCK].iter().sum::<f64>() / BLOCK as f64;
    let least_n = (CONSTANT_STDS * noise_std(force)).max(MIN_OFFSET_N);
    let (low_n, high_n) = range(force)?;
    let change_n = (high_n - first_n).max(first_n - low_n);
    let is_offset = first_n.abs() > change_n || (first_n < -least_n && high_n - first_n > -first_n);
    (first_n.abs() > least_n && change_n > least_n && is_offset).then(|| {
        let message = format!(
            "the recording begins with a force of {first_n:.3} N and changes from there by at most {change_n:.3} N: the sensor seems not \
             to be tared"
        );
        let end_s = signals.time_s[BLOCK - 1] - signals.time_s[0];
        let remedy = format!(
            "subtract it with --tare-s {end_s:.3} (recording.tare_s), if the needle is free until then; otherwise the recording begins in \
             the tissue"
        );
        Warning::new(Code::ForceOffset, message).at("--tare-s or --force").remedy(remedy)
    })
}
