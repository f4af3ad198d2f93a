mod aftermath;
mod bin;
mod extremes;
mod fall_hold;
mod tare;
mod times;

use super::super::DetectorInput;
use super::super::hypotheses::Hypotheses;
use super::tail::Tail;
use super::{BuiltIn, Distance, DistanceSettings};
use crate::lane::{Lane, Mask, by_index};
use aftermath::{Aftermath, FallLimits};
use bin::Bin;
use extremes::Extremes;
use fall_hold::FallHold;
use tare::Tare;
use times::Times;

const THRESHOLD: f64 = 7.0;

const BIN_S: f64 = 1e-3;

/// At least the longest window plus the reference.
const BINS: usize = 64;

/// A longer extreme needs shorter ones of at most seven bins ago. Divides [`BINS`].
const SHORT: usize = 8;

const MEDIAN_BINS: usize = 3;

const WINDOWS_S: [f64; 5] = [2e-3, 4e-3, 8e-3, 16e-3, 32e-3];

/// Longer than the spike of an impact.
const REFERENCE_S: f64 = 15e-3;

const INSTANT_S: f64 = 4e-3;

const SLOW_M_PER_S: f64 = 2e-3;

/// Force that viscosity can release when the needle stops, relative to the load.
const VISCOUS_SHARE: f64 = 0.7;

/// Largest lost share of the velocity of a needle that moves on.
const EVEN_SHARE: f64 = 0.1;
const MOVES_ON_M_PER_S: f64 = 5e-3;

const LEAST_SHARE: f64 = 0.1;

const LEAST_RECENT_SHARE: f64 = 0.05;

const LOAD_MEMORY_S: f64 = 0.3;

const SCALE_MEMORY_S: f64 = 1.0;

const CLIP: f64 = 3.0;

/// Relative to the sensor's step.
const STEP_SHARE: f64 = 0.5;

const LEAST_SCALE_N: f64 = 1e-9;

const KNOWN_BINS: f64 = 50.0;

const STIFFNESS_MEMORY_S: f64 = 0.3;

const STIFFNESS_INTERVAL_S: f64 = 8e-3;

const LOAD: f64 = 6.0;

const STIFFEST_MEMORY_S: f64 = 5.0;

const MAX_RESOLUTION_M: f64 = 1e-4;

/// In m and N.
const ROUNDING: [f64; 2] = [1e-9, 1e-6];

const STUCK_S: f64 = 0.2;

const HOLD_S: f64 = 0.15;

const MERGE_S: f64 = 0.03;

/// In multiples of the scale.
const NEW_LOAD: f64 = 10.0;

const NEW_LOAD_BINS: f64 = 2.0;

/// The fall of the force in multiples of its usual change, without configuration.
///
/// Works on medians of three bins of averaged samples. `K` regresses changes of the force `f` on changes of the
/// position `x` under load; `r` is the force that the motion does not explain (`Δr = Δf - K Δx`); the *load* is the
/// force above the mean of the first 50 bins, or above 0 if that is noise.
/// For each window `w`:
///
/// ```text
/// fall_w = min(min r before the window - r - continued, max f before the window - f - released)
/// s_k    = max over w of min(fall_w, load) / c_w
/// ```
///
/// - *before the window*: in 15 ms, for `min r` in two bins if a tenth of the load arrived in the 15 ms and the needle
///   moves on: an impact stops a needle.
/// - `c_w`: mean over 1 s of the clipped changes over `w`; at least half of the sensor's step.
/// - *released*: what the retreat plus one encoder step can release at the stiffest load so far.
/// - *continued*: what an earlier fall adds at its rate (relaxation).
///
/// A fall counts as 0 below a tenth of the load, a twentieth of the largest load of the last 0.3 s, or 0.7 of the load
/// times the lost share of the velocity (viscosity); during a retreat, after 64 bins of rest, and within an alarm's
/// fall or ring-down.
///
/// The constants were chosen on synthetic recordings with other seeds than the reported ones.
#[derive(Debug, Clone)]
pub struct Adaptive<L> {
    bin: Bin<L>,
    times: Times,
    bins: f64,
    newest: usize,
    force: [L; BINS],
    /// `r` in N.
    surplus: [L; BINS],
    position: [L; BINS],
    peak: Extremes<L>,
    low: Extremes<L>,
    high: Extremes<L>,
    /// In m/s: the larger of mean and last velocity over the reference.
    speed: [L; BINS],
    scales: [L; WINDOWS_S.len()],
    /// Means of `Δx²` and `Δx Δf`.
    moments: [L; 2],
    stiffest: L,
    recent_load: L,
    tare: Tare<L>,
    hold: FallHold<L>,
    aftermath: Aftermath<L>,
    tail: Option<Tail<L>>,
    value: L,
}

impl<L: Lane> BuiltIn for Adaptive<L> {
    const UNIT: &'static str = "1";
    const ACCUMULATES: bool = false;
    const WAITS_FOR: Option<&'static str> =
        Some("50 samples, or 50 ms above 1 kHz, to learn the noise, and for a force that has changed within 0.2 s");

    fn tuning(_hypotheses: &Hypotheses) -> (f64, f64) {
        (THRESHOLD, 0.0)
    }

    fn new(settings: &DistanceSettings, tick_s: f64) -> Self {
        let samples = (libm::ceil(BIN_S / tick_s - 1e-9) as usize).max(1);
        let bin_s = samples as f64 * tick_s;
        let zero = L::zero();
        Self {
            bin: Bin::new(samples),
            times: Times::of(bin_s),
            bins: 0.0,
            newest: 0,
            force: [zero; BINS],
            surplus: [zero; BINS],
            position: [zero; BINS],
            peak: Extremes::new(zero),
            low: Extremes::new(zero),
            high: Extremes::new(zero),
            speed: [zero; BINS],
            scales: [zero; WINDOWS_S.len()],
            moments: [zero; 2],
            stiffest: zero,
            recent_load: zero,
            tare: Tare::new(),
            hold: FallHold { lowest: zero, since_lowest: L::splat(-1.0), bins: zero },
            aftermath: Aftermath::new(),
            tail: settings.rate.false_alarms_per_min.map(|per_min| Tail::new(per_min, bin_s)),
            value: zero,
        }
    }

    fn restarted(&self, settings: &DistanceSettings, tick_s: f64) -> Self {
        // Samples after the gap may be under load: keep the sensor's offset.
        Self { tare: self.tare.clone(), ..<Self as BuiltIn>::new(settings, tick_s) }
    }
}

impl<L: Lane> Distance<L> for Adaptive<L> {
    #[inline(always)]
    fn update(&mut self, input: &DetectorInput<L>) -> L {
        if let Some((force, position)) = self.bin.add(input.force_n, input.depth_m) {
            self.process(force, position);
        }
        self.value
    }

    #[inline(always)]
    fn reset(&mut self, mask: L::Mask) {
        self.value = L::select(mask, L::zero(), self.value);
        let force = self.force[self.newest];
        self.hold.begin(mask, force);
        self.aftermath.begin(mask, self.maximum(&self.peak), force);
        if let Some(tail) = &mut self.tail {
            tail.take_alarm(mask);
        }
    }

    #[inline(always)]
    fn accumulates(&self) -> bool {
        Self::ACCUMULATES
    }

    #[inline(always)]
    fn is_ready(&self) -> Option<L::Mask> {
        let is_stuck = self.bin.unchanged.gt(L::splat(self.times.stuck));
        Some(L::Mask::splat(self.bins >= KNOWN_BINS) & !is_stuck)
    }
}

impl<L: Lane> Adaptive<L> {
    #[inline(always)]
    fn ago(&self, values: &[L; BINS], bins: usize) -> L {
        values[before(self.newest, bins)]
    }

    #[inline(always)]
    fn change(&self, values: &[L; BINS], bins: usize) -> L {
        values[self.newest] - self.ago(values, bins)
    }

    #[inline(always)]
    fn process(&mut self, force: L, position: L) {
        if self.bins == 0.0 {
            (self.force, self.peak) = ([force; BINS], Extremes::new(force));
            (self.position, self.high) = ([position; BINS], Extremes::new(position));
        }
        self.bins += 1.0;
        self.tare.update(force, self.times.tare_share);
        let last_surplus = self.surplus[self.newest];
        self.newest = (self.newest + 1) % BINS;
        self.force[self.newest] = force;
        self.position[self.newest] = position;
        let stiffness = self.stiffness();
        let explained = stiffness * self.change(&self.position, 1);
        self.surplus[self.newest] = last_surplus + self.change(&self.force, 1) - explained;
        let (newest, reference) = (self.newest, self.times.reference);
        self.low.update(&self.surplus, newest, reference, L::min);
        self.peak.update(&self.force, newest, reference, L::max);
        self.high.update(&self.position, newest, reference, L::max);

        self.speed[newest] = self.speed();

        let largest = self.largest_fall(stiffness);
        self.learn(stiffness);
        if self.bins == KNOWN_BINS {
            self.tare.settle(self.scales[0]);
        }
        let held = self.hold.update(force, self.scales[0], &self.tare, &self.times);
        self.aftermath.update(force, self.scales[0], held.was_holding, &self.times.aftermath);
        if let Some(ended) = held.ended {
            self.low.forget(ended, self.surplus[self.newest]);
            self.peak.forget(ended, force);
        }
        let counts = !held.was_holding & L::Mask::splat(self.bins >= KNOWN_BINS);
        let value = L::select(counts, largest, L::zero());
        self.value = match &mut self.tail {
            Some(tail) => {
                let relative = value * (L::splat(THRESHOLD) / tail.level());
                tail.add(value);
                relative
            }
            None => value,
        };
    }

    /// In N/m.
    #[inline(always)]
    fn stiffness(&mut self) -> L {
        let zero = L::zero();
        let interval = self.times.stiffness;
        let (rise, advance) = (self.change(&self.force, interval), self.change(&self.position, interval));
        let is_loaded = self.tare.load(self.ago(&self.force, interval)).gt(L::splat(LOAD) * self.scales[0]);
        let share = L::select(is_loaded, L::splat(self.times.stiffness_share), zero);
        let [squares, products] = self.moments;
        let squares = squares + (advance * advance - squares) * share;
        let products = products + (advance * rise - products) * share;
        self.moments = [squares, products];
        L::select(squares.gt(zero), (products / squares).max(zero), zero)
    }

    #[inline(always)]
    fn speed(&self) -> L {
        let (reference, instant) = (self.times.reference, self.times.instant);
        let mean = self.change(&self.position, reference) * L::splat(self.times.per_reference);
        // Ignore single encoder steps.
        let at_last = (self.change(&self.position, instant) - self.bin.steps[0]) * L::splat(self.times.per_instant);
        mean.max(at_last)
    }

    #[inline(always)]
    fn largest_fall(&self, stiffness: L) -> L {
        let zero = L::zero();
        // Fast path: most forces have hardly fallen.
        let (force, peak) = (self.force[self.newest], self.maximum(&self.peak));
        let may_count = (peak - force).gt(self.tare.smallest_size(peak) * L::splat(LEAST_SHARE));
        if !may_count.any() {
            return zero;
        }
        let retreat = self.maximum(&self.high) - self.position[self.newest] + self.bin.steps[0];
        let released = stiffness.max(self.stiffest) * retreat;
        // The force is a median and lags by one bin.
        let since = self.ago(&self.position, self.times.instant - 1);
        let velocity = (self.bin.position - since) * L::splat(self.times.per_instant);
        let ring = self.aftermath.limits(force);
        let mut largest = zero;
        for index in 0..WINDOWS_S.len() {
            largest = largest.max(self.relative_fall(index, velocity, released, &ring));
        }
        // A constant or coarse position does not show rest.
        let is_at_rest = self.bin.steps[0].lt(L::splat(MAX_RESOLUTION_M))
            & !self.change(&self.position, BINS - 1).gt(L::splat(ROUNDING[0]));
        L::select(is_at_rest, zero, largest)
    }

    #[inline(always)]
    fn maximum(&self, maxima: &Extremes<L>) -> L {
        let reference = self.times.reference;
        let longest = BINS - 1 - reference;
        let mut maximum = maxima.whole[self.newest];
        // Four adjacent references cover both.
        for part in 1..4 {
            maximum = maximum.max(self.ago(&maxima.whole, (part * reference).min(longest)));
        }
        maximum
    }

    #[inline(always)]
    fn relative_fall(&self, index: usize, velocity: L, released: L, ring: &FallLimits<L>) -> L {
        let zero = L::zero();
        let window = self.times.windows[index];
        let advances = self.change(&self.position, window).ge(zero);
        if !advances.any() {
            return zero;
        }
        let (force, surplus) = (self.force[self.newest], self.surplus[self.newest]);
        let peak = self.ago(&self.peak.whole, window);
        let before = self.ago(&self.force, window + self.times.reference);
        let size = self.tare.size(peak, before, self.scales[0]);

        let speed = self.ago(&self.speed, window);
        let inverse = L::splat(1.0) / speed.max(L::splat(SLOW_M_PER_S));
        let lost = ((speed - velocity) * inverse).min(L::splat(1.0));
        let moves_on = lost.lt(L::splat(EVEN_SHARE)) & velocity.gt(L::splat(MOVES_ON_M_PER_S));
        let (last, lowest) = (self.ago(&self.low.twos, window), self.ago(&self.low.whole, window));
        let was_loaded = (last - lowest).ge(L::splat(LEAST_SHARE) * size);
        let reference = L::select(moves_on & was_loaded, last, lowest);

        let fall = self.ago(&self.surplus, window + self.times.reference) - self.ago(&self.surplus, window);
        let continued = fall.max(zero) * L::splat(self.times.trends[index]);
        let fall = (reference - surplus - continued).min(peak - force - released).min(ring.largest);
        let least = (L::splat(LEAST_SHARE).max(L::splat(VISCOUS_SHARE) * lost) * size)
            .max(L::splat(LEAST_RECENT_SHARE) * self.recent_load)
            .max(ring.least);
        let counts = fall.gt(least) & advances;
        let scale = self.scales[index].max(self.bin.steps[1] * L::splat(STEP_SHARE)).max(L::splat(LEAST_SCALE_N));
        // Noise without load is not a fall.
        L::select(counts, fall.min(size), zero) / scale
    }

    #[inline(always)]
    fn learn(&mut self, stiffness: L) {
        let share = L::splat((1.0 / self.bins).max(self.times.scale_share));
        // Medians of three bins share bins, so shorter changes are too small.
        let windows = by_index!(WINDOWS_S.len(), 0, |i| self.times.windows[i].max(MEDIAN_BINS));
        // The compiler does not vectorise loops over windows.
        let rises = by_index!(WINDOWS_S.len(), |i| self.change(&self.force, windows[i]));
        let advances = by_index!(WINDOWS_S.len(), |i| self.change(&self.position, windows[i]));
        let unexplained =
            by_index!(WINDOWS_S.len(), |i| rises[i].abs().min((rises[i] - stiffness * advances[i]).abs()));
        let clipped = if self.bins >= KNOWN_BINS {
            by_index!(WINDOWS_S.len(), |i| unexplained[i].min(L::splat(CLIP) * self.scales[i]))
        } else {
            unexplained
        };
        self.scales = by_index!(WINDOWS_S.len(), |i| self.scales[i] + (clipped[i] - self.scales[i]) * share);
        self.recent_load =
            (self.recent_load * L::splat(self.times.load_decay)).max(self.tare.load(self.force[self.newest]));
        let (rise, advance) = (rises[WINDOWS_S.len() - 1], advances[WINDOWS_S.len() - 1]);
        let resolution = self.bin.steps[0];
        let is_load = rise.gt(L::splat(LOAD) * self.scales[WINDOWS_S.len() - 1]) & advance.ge(-resolution);
        let load = L::select(is_load, rise, L::zero()) / advance.max(resolution).max(L::splat(ROUNDING[0]));
        self.stiffest = load.max(self.stiffest * L::splat(self.times.stiffest_decay));
    }
}

crate::lane::gather!(Adaptive {
    bin, force, surplus, position, peak, low, high, speed, scales, moments, stiffest, recent_load, tare, hold, aftermath,
    tail, value
} same { times, bins, newest } stored);

#[inline(always)]
fn before(bin: usize, bins: usize) -> usize {
    (bin + BINS - bins) % BINS
}

#[cfg(test)]
mod tests;
