//! Judges a motion independently of trocar's own rule for oscillations.

/// Smallest swing in m from peak to peak, and the smallest ratio of its later to its earlier size. A stable loop that
/// decays more slowly is within about one per cent of its boundary.
const SWING_M: f64 = 4e-4;
const KEPT: f64 = 0.9;

/// Largest motion at rest in m from peak to peak.
const REST_M: f64 = 2e-5;

/// Length of a window in s, windows that swing, and sides of the trend on which the needle is in turn within them.
const WINDOW_S: f64 = 0.5;
const WINDOWS: usize = 4;
const MIN_SIDES: usize = 5;

/// The motion of the needle while the hand rests.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Motion {
    /// It swings for 2 s without losing a tenth in 1 s, or diverges.
    Swings,
    /// It is at rest in the last second, apart from a creep.
    Rests,
    /// Neither.
    Undecided,
}

/// Judges the needle's positions in the holds.
pub fn motion(positions_m: &[f64], tick_s: f64, holds_s: &[(f64, f64)]) -> Motion {
    let ticks = |time_s: f64| (time_s / tick_s).round() as usize;
    let window = ticks(WINDOW_S);
    let of_hold = |(from_s, to_s): (f64, f64)| &positions_m[ticks(from_s)..ticks(to_s).min(positions_m.len())];
    let swings = |hold: &(f64, f64)| {
        let hold = of_hold(*hold);
        (0..hold.len() / window).any(|first| {
            let part = hold.get(first * window..(first + WINDOWS) * window);
            part.is_some_and(|part| keeps_swinging(&without_trend(part), window))
        })
    };
    if holds_s.iter().any(swings) {
        return Motion::Swings;
    }
    let last = of_hold(holds_s[holds_s.len() - 1]);
    let is_still = range(&without_trend(&last[last.len() - 2 * window..])) < REST_M;
    if is_still { Motion::Rests } else { Motion::Undecided }
}

/// A relaxation and a single fall stay on few sides of their trend.
fn keeps_swinging(relative_m: &[f64], window: usize) -> bool {
    let far = relative_m.iter().filter(|x| x.abs() > SWING_M / 4.0).map(|x| *x > 0.0);
    let (_, sides) = far.fold((None, 0), |(last, count), side| (Some(side), count + usize::from(last != Some(side))));
    let swings_m: Vec<f64> = relative_m.chunks(window).map(range).collect();
    let (early, late) = swings_m.split_at(WINDOWS / 2);
    let largest = |swings_m: &[f64]| swings_m.iter().copied().fold(0.0, f64::max);
    let is_kept = largest(late) >= KEPT * largest(early);
    sides >= MIN_SIDES && is_kept && swings_m.iter().all(|swing_m| *swing_m > SWING_M)
}

/// Subtracts the line of least squares.
fn without_trend(values: &[f64]) -> Vec<f64> {
    let middle = (values.len() as f64 - 1.0) / 2.0;
    let at = || (0..values.len()).map(|k| k as f64 - middle);
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let slope = at().zip(values).map(|(k, x)| k * x).sum::<f64>() / at().map(|k| k * k).sum::<f64>();
    at().zip(values).map(|(k, x)| x - mean - slope * k).collect()
}

fn range(values: &[f64]) -> f64 {
    let bounds = (f64::INFINITY, f64::NEG_INFINITY);
    let (low, high) = values.iter().fold(bounds, |(low, high), x| (low.min(*x), high.max(*x)));
    high - low
}
