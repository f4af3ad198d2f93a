use super::calibration::noise_std;
use super::plausibility::{Signals, range};
use trocar_base::warning::{Code, Warning};

const MIN_SAMPLES: usize = 100;

/// Their mean force is compared with the initial force.
const BLOCK: usize = 20;

/// A free needle moves at least so far at constant force.
const FREE_TRAVEL_M: f64 = 5e-4;
const MIN_OFFSET_N: f64 = 0.05;
const CONSTANT_STDS: f64 = 3.0;
const CONSTANT_N: f64 = 0.02;

/// Share of the largest change of the force. A larger constant force is a load.
const MAX_OFFSET_SHARE: f64 = 0.5;

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
    // Constant to the end: no information.
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

/// A first force that exceeds all later changes, or that pulls at the needle.
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
