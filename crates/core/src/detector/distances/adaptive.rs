//! The fall of the force relative to its usual changes: a detector that needs no configuration.

use super::super::DetectorInput;
use super::super::hypotheses::Hypotheses;
use super::tail::Tail;
use super::{BuiltIn, Distance, DistanceSettings};
use crate::lane::{Lane, Mask, by_index};

/// Threshold, in multiples of the usual change.
const THRESHOLD: f64 = 7.0;

/// Smallest length of a bin in s. The samples of a bin are averaged.
const BIN_S: f64 = 1e-3;

/// Number of stored bins: at least the longest window plus the reference before it.
const BINS: usize = 64;

/// Number of bins for which shorter extremes are stored. A longer extreme needs the shorter ones of at most seven bins
/// ago. Divides [`BINS`].
const SHORT: usize = 8;

const MEDIAN_BINS: usize = 3;

/// Windows over which the force may fall, in s.
const WINDOWS_S: [f64; 5] = [2e-3, 4e-3, 8e-3, 16e-3, 32e-3];

/// Length of the reference before a window in s. Longer than the spike of an impact.
const REFERENCE_S: f64 = 15e-3;

/// Interval over which the present velocity is measured, in s.
const INSTANT_S: f64 = 4e-3;

/// Velocities below this count as rest, in m/s.
const SLOW_M_PER_S: f64 = 2e-3;

/// Share of the force that viscosity can release when the needle stops.
const VISCOUS_SHARE: f64 = 0.7;

/// A needle moves on if it has lost less than this share of its velocity and is faster than [`MOVES_ON_M_PER_S`].
const EVEN_SHARE: f64 = 0.1;
const MOVES_ON_M_PER_S: f64 = 5e-3;

/// Smallest fall that counts, as a share of the force before it.
const LEAST_SHARE: f64 = 0.1;

/// Smallest fall that counts, as a share of the largest recent force.
const LEAST_RECENT_SHARE: f64 = 0.05;

const LOAD_MEMORY_S: f64 = 0.3;

const SCALE_MEMORY_S: f64 = 1.0;

/// Changes are clipped at this multiple of their scale before they update it.
const CLIP: f64 = 3.0;

/// Smallest scale, as a share of the force sensor's step.
const STEP_SHARE: f64 = 0.5;

const LEAST_SCALE_N: f64 = 1e-9;

/// Number of bins after which the scales are valid.
const KNOWN_BINS: f64 = 50.0;

const STIFFNESS_MEMORY_S: f64 = 0.3;

const STIFFNESS_INTERVAL_S: f64 = 8e-3;

/// Forces and rises above this multiple of their scale count as a load.
const LOAD: f64 = 6.0;

const STIFFEST_MEMORY_S: f64 = 5.0;

/// Largest step of an encoder, in m.
const MAX_RESOLUTION_M: f64 = 1e-4;

/// Changes below these are rounding errors, in m and N.
const ROUNDING: [f64; 2] = [1e-9, 1e-6];

/// A force that has been constant for this time is stuck, in s.
const STUCK_S: f64 = 0.2;

/// Longest time after an alarm that belongs to the same fall, in s.
const HOLD_S: f64 = 0.15;

/// A rise above the lowest force by this multiple of the scale ends the fall: a new load.
const NEW_LOAD: f64 = 10.0;

/// Number of bins for which the new load must last.
const NEW_LOAD_BINS: f64 = 2.0;

/// The fall of the force, in multiples of its usual change.
///
/// Samples are averaged in bins of at least 1 ms, and a median of three bins removes single outliers. Let `f` be the
/// force, `x` the position and `K` the stiffness, from a regression of changes of `f` on changes of `x` under load. The
/// surplus `r` is the force that the motion does not explain: `Δr = Δf - K Δx`. For each window `w`
///
/// ```text
/// fall_w = min(min r before the window - r - continued, max f before the window - f - released)
/// s_k    = max over w of min(fall_w, max f) / c_w
/// ```
///
/// - *before the window*: the 15 ms before it. `min r` covers only the last two bins if a load of at least a tenth of
///   the force arrived in these 15 ms and the needle moves on through the fall: an impact stops a needle, a rupture
///   lets it through.
/// - `c_w`: the running mean, over 1 s, of the changes over `w`, each clipped at three means; at least half of the
///   sensor's step.
/// - *released*: the force that the retreat so far, plus one encoder step, can release at the stiffest load seen so
///   far. A hand that lets go of a rigid stop is not a rupture.
/// - *continued*: the amount that an earlier fall adds if it continues at its rate (relaxation).
///
/// A fall counts as 0 if it is
///
/// - less than a tenth of the force, or less than a twentieth of the largest force of the last 0.3 s,
/// - less than 0.7 of the force, times the share of its velocity that the needle has lost (viscosity),
/// - during a retreat of the needle, or after 64 bins of rest,
/// - part of the fall after an alarm, which lasts until no further tenth of the force is lost within 30 ms, or a new
///   load has risen.
///
/// The constants were chosen on synthetic recordings (`trocar roc --trials`), with other seeds than the reported ones.
#[derive(Debug, Clone)]
pub struct Adaptive<L> {
    bin: Bin<L>,
    times: Times,
    bins: f64,
    newest: usize,
    force: [L; BINS],
    /// The force that the motion does not explain, in N.
    surplus: [L; BINS],
    position: [L; BINS],
    /// Maximum force, minimum surplus and maximum position over the reference that ends at each bin.
    peak: Extremes<L>,
    low: Extremes<L>,
    high: Extremes<L>,
    /// Velocity over the reference that ends at each bin in m/s: the larger of the mean and the last velocity.
    speed: [L; BINS],
    scales: [L; WINDOWS_S.len()],
    /// Running means of `Δx²` and `Δx Δf`.
    moments: [L; 2],
    stiffest: L,
    /// The largest recent force, which decays, in N.
    recent_load: L,
    hold: FallHold<L>,
    /// The tail of the values, for a wanted rate of false alarms.
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
            hold: FallHold { lowest: zero, since_lowest: L::splat(-1.0), bins: zero },
            tail: settings.rate.false_alarms_per_min.map(|per_min| Tail::new(per_min, bin_s)),
            value: zero,
        }
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
        self.hold.begin(mask, self.force[self.newest]);
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
        let held = self.hold.update(force, self.scales[0], &self.times);
        if let Some(ended) = held.ended {
            // The next fall is measured from here.
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

    /// The stiffness in N/m, from a regression of force changes on position changes under load.
    #[inline(always)]
    fn stiffness(&mut self) -> L {
        let zero = L::zero();
        let interval = self.times.stiffness;
        let (rise, advance) = (self.change(&self.force, interval), self.change(&self.position, interval));
        let is_loaded = self.ago(&self.force, interval).gt(L::splat(LOAD) * self.scales[0]);
        let share = L::select(is_loaded, L::splat(self.times.stiffness_share), zero);
        let [squares, products] = self.moments;
        let squares = squares + (advance * advance - squares) * share;
        let products = products + (advance * rise - products) * share;
        self.moments = [squares, products];
        L::select(squares.gt(zero), (products / squares).max(zero), zero)
    }

    /// The entry of `speed` for the newest bin.
    #[inline(always)]
    fn speed(&self) -> L {
        let (reference, instant) = (self.times.reference, self.times.instant);
        let mean = self.change(&self.position, reference) * L::splat(self.times.per_reference);
        // Ignore single encoder steps when estimating velocity.
        let at_last = (self.change(&self.position, instant) - self.bin.steps[0]) * L::splat(self.times.per_instant);
        mean.max(at_last)
    }

    #[inline(always)]
    fn largest_fall(&self, stiffness: L) -> L {
        let zero = L::zero();
        // Fast path: most forces have not fallen by the smallest share below any earlier force, over any window.
        let may_count = self.force[self.newest].lt(self.maximum(&self.peak) * L::splat(1.0 - LEAST_SHARE));
        if !may_count.any() {
            return zero;
        }
        // The force that a retreat from the deepest position can release.
        let retreat = self.maximum(&self.high) - self.position[self.newest] + self.bin.steps[0];
        let released = stiffness.max(self.stiffest) * retreat;
        // The force is a median and lags by one bin. The velocity uses the next position, because the force falls with
        // the velocity.
        let since = self.ago(&self.position, self.times.instant - 1);
        let velocity = (self.bin.position - since) * L::splat(self.times.per_instant);
        let mut largest = zero;
        for index in 0..WINDOWS_S.len() {
            largest = largest.max(self.relative_fall(index, velocity, released));
        }
        // A position that has never changed, or only by coarse steps, does not show that the needle is at rest.
        let is_at_rest = self.bin.steps[0].lt(L::splat(MAX_RESOLUTION_M))
            & !self.change(&self.position, BINS - 1).gt(L::splat(ROUNDING[0]));
        L::select(is_at_rest, zero, largest)
    }

    /// The maximum over the longest window and the reference before it.
    #[inline(always)]
    fn maximum(&self, maxima: &Extremes<L>) -> L {
        let reference = self.times.reference;
        let longest = BINS - 1 - reference;
        let mut maximum = maxima.whole[self.newest];
        // The maxima of four adjacent references cover both.
        for part in 1..4 {
            maximum = maximum.max(self.ago(&maxima.whole, (part * reference).min(longest)));
        }
        maximum
    }

    /// The fall over a window at a velocity (m/s), relative to its scale.
    #[inline(always)]
    fn relative_fall(&self, index: usize, velocity: L, released: L) -> L {
        let zero = L::zero();
        let window = self.times.windows[index];
        // Skip the computation while the needle retreats, because no fall counts then.
        let advances = self.change(&self.position, window).ge(zero);
        if !advances.any() {
            return zero;
        }
        let (force, surplus) = (self.force[self.newest], self.surplus[self.newest]);
        let peak = self.ago(&self.peak.whole, window);

        let speed = self.ago(&self.speed, window);
        let inverse = L::splat(1.0) / speed.max(L::splat(SLOW_M_PER_S));
        let lost = ((speed - velocity) * inverse).min(L::splat(1.0));
        let moves_on = lost.lt(L::splat(EVEN_SHARE)) & velocity.gt(L::splat(MOVES_ON_M_PER_S));
        let (last, lowest) = (self.ago(&self.low.twos, window), self.ago(&self.low.whole, window));
        let was_loaded = (last - lowest).ge(L::splat(LEAST_SHARE) * peak);
        let reference = L::select(moves_on & was_loaded, last, lowest);

        let fall = self.ago(&self.surplus, window + self.times.reference) - self.ago(&self.surplus, window);
        let continued = fall.max(zero) * L::splat(self.times.trends[index]);
        let fall = (reference - surplus - continued).min(peak - force - released);
        let least = (L::splat(LEAST_SHARE).max(L::splat(VISCOUS_SHARE) * lost) * peak)
            .max(L::splat(LEAST_RECENT_SHARE) * self.recent_load);
        let counts = fall.gt(least) & advances;
        let scale = self.scales[index].max(self.bin.steps[1] * L::splat(STEP_SHARE)).max(L::splat(LEAST_SCALE_N));
        // A fall is at most the force before it: noise around zero force is not a fall.
        L::select(counts, fall.min(peak), zero) / scale
    }

    #[inline(always)]
    fn learn(&mut self, stiffness: L) {
        let share = L::splat((1.0 / self.bins).max(self.times.scale_share));
        // Medians of three bins share bins with the next two medians, so their change over fewer than three bins is too
        // small.
        let windows = by_index!(WINDOWS_S.len(), 0, |i| self.times.windows[i].max(MEDIAN_BINS));
        // The loops run array by array rather than window by window, so that the compiler can vectorise them.
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
        self.recent_load = (self.recent_load * L::splat(self.times.load_decay)).max(self.force[self.newest]);
        let (rise, advance) = (rises[WINDOWS_S.len() - 1], advances[WINDOWS_S.len() - 1]);
        let resolution = self.bin.steps[0];
        let is_load = rise.gt(L::splat(LOAD) * self.scales[WINDOWS_S.len() - 1]) & advance.ge(-resolution);
        let load = L::select(is_load, rise, L::zero()) / advance.max(resolution).max(L::splat(ROUNDING[0]));
        self.stiffest = load.max(self.stiffest * L::splat(self.times.stiffest_decay));
    }
}

crate::lane::gather!(Adaptive {
    bin, force, surplus, position, peak, low, high, speed, scales, moments, stiffest, recent_load, hold, tail, value
} same { times, bins, newest } stored);

#[inline(always)]
fn before(bin: usize, bins: usize) -> usize {
    (bin + BINS - bins) % BINS
}

/// The extremes of a signal over the last two, four and eight bins and over the reference, for each bin. Each is
/// computed from two shorter extremes.
#[derive(Debug, Clone)]
struct Extremes<L> {
    twos: [L; BINS],
    fours: [L; SHORT],
    eights: [L; SHORT],
    whole: [L; BINS],
}

impl<L: Lane> Extremes<L> {
    fn new(value: L) -> Self {
        Self { twos: [value; BINS], fours: [value; SHORT], eights: [value; SHORT], whole: [value; BINS] }
    }

    /// Adds the newest value; `more` is the minimum or the maximum of two.
    #[inline(always)]
    fn update(&mut self, values: &[L; BINS], newest: usize, reference: usize, more: impl Fn(L, L) -> L) {
        let one = values[newest];
        let two = more(one, values[before(newest, 1)]);
        self.twos[newest] = two;
        let four = more(two, self.twos[before(newest, 2)]);
        self.fours[newest % SHORT] = four;
        let eight = more(four, self.fours[before(newest, 4) % SHORT]);
        self.eights[newest % SHORT] = eight;
        // The reference is at most 15 bins.
        self.whole[newest] = match reference {
            8.. => more(eight, self.eights[before(newest, reference - 8) % SHORT]),
            4.. => more(four, self.fours[before(newest, reference - 4) % SHORT]),
            2.. => more(two, self.twos[before(newest, reference - 2)]),
            ..2 => one,
        };
    }

    /// Resets the lanes of the mask, as if every bin so far had had this value.
    #[inline(always)]
    fn forget(&mut self, mask: L::Mask, value: L) {
        let Self { twos, fours, eights, whole } = self;
        for old in twos.iter_mut().chain(fours).chain(eights).chain(whole) {
            *old = L::select(mask, value, *old);
        }
    }
}

crate::lane::gather!(Extremes { twos, fours, eights, whole } stored);

#[derive(Debug, Clone, Copy, PartialEq)]
struct Times {
    windows: [usize; WINDOWS_S.len()],
    /// Ratio of the window to the reference: the continuation of a fall, in multiples of the fall over the reference.
    trends: [f64; WINDOWS_S.len()],
    reference: usize,
    stiffness: usize,
    instant: usize,
    hold: f64,
    stuck: f64,
    /// Inverse of the reference and of the interval of the present velocity, in 1/s.
    per_reference: f64,
    per_instant: f64,
    scale_share: f64,
    stiffness_share: f64,
    stiffest_decay: f64,
    load_decay: f64,
}

impl Times {
    fn of(bin_s: f64) -> Self {
        // A bin is at least 1 ms long, so the longest window and the reference before it are at most 47 of the 64 bins.
        let bins = |time_s: f64| (libm::round(time_s / bin_s) as usize).max(1);
        let per = |time_s: f64| 1.0 / (bins(time_s) as f64 * bin_s);
        let (windows, reference) = (WINDOWS_S.map(bins), bins(REFERENCE_S));
        Self {
            windows,
            trends: windows.map(|window| window as f64 / reference as f64),
            reference,
            stiffness: bins(STIFFNESS_INTERVAL_S),
            instant: bins(INSTANT_S),
            hold: bins(HOLD_S) as f64,
            stuck: bins(STUCK_S) as f64,
            per_reference: per(REFERENCE_S),
            per_instant: per(INSTANT_S),
            scale_share: (bin_s / SCALE_MEMORY_S).min(1.0),
            stiffness_share: (bin_s / STIFFNESS_MEMORY_S).min(1.0),
            stiffest_decay: libm::exp(-bin_s / STIFFEST_MEMORY_S),
            load_decay: libm::exp(-bin_s / LOAD_MEMORY_S),
        }
    }
}

/// Stores nothing, because all values follow from the settings.
impl crate::lane::Stored for Times {
    fn numbers(&mut self, _with: &mut dyn FnMut(&mut u64)) {}
}

/// The mean of the samples of a bin, the median of three bins, and the steps of the sensors.
#[derive(Debug, Clone)]
struct Bin<L> {
    /// Number of samples per bin, and number of samples so far.
    samples: usize,
    filled: usize,
    has_any: bool,
    sums: [L; 2],
    last: [L; 2],
    /// Smallest change between two samples: at most the step of the encoder (m) and of the sensor (N).
    steps: [L; 2],
    unchanged: L,
    /// Forces of the last three bins, and the position of the last one.
    forces: [L; MEDIAN_BINS],
    position: L,
}

impl<L: Lane> Bin<L> {
    fn new(samples: usize) -> Self {
        let zero = L::zero();
        Self {
            samples,
            filled: 0,
            has_any: false,
            sums: [zero; 2],
            last: [zero; 2],
            steps: [L::splat(MAX_RESOLUTION_M), L::splat(f64::MAX)],
            unchanged: zero,
            forces: [zero; MEDIAN_BINS],
            position: zero,
        }
    }

    /// Adds a sample. If it completes a bin, returns the force and the position of the bin before.
    #[inline(always)]
    fn add(&mut self, force: L, position: L) -> Option<(L, L)> {
        let sample = [position, force];
        if self.has_any {
            for i in 0..2 {
                let change = (sample[i] - self.last[i]).abs();
                let is_step = change.gt(L::splat(ROUNDING[i]));
                self.steps[i] = L::select(is_step, self.steps[i].min(change), self.steps[i]);
            }
        } else {
            (self.forces, self.position) = ([force; MEDIAN_BINS], position);
            self.has_any = true;
        }
        self.unchanged = L::select((force - self.last[1]).abs().gt(L::zero()), L::zero(), self.unchanged);
        self.last = sample;
        self.sums = [self.sums[0] + position, self.sums[1] + force];
        self.filled += 1;
        if self.filled < self.samples {
            return None;
        }
        self.unchanged = self.unchanged + L::splat(1.0);
        let share = L::splat(1.0 / self.samples as f64);
        let [position, force] = [self.sums[0] * share, self.sums[1] * share];
        (self.filled, self.sums) = (0, [L::zero(); 2]);
        self.forces = [self.forces[1], self.forces[2], force];
        let [a, b, c] = self.forces;
        let median = a.min(b).max(a.max(b).min(c));
        Some((median, core::mem::replace(&mut self.position, position)))
    }
}

crate::lane::gather!(Bin { sums, last, steps, unchanged, forces, position } same { samples, filled, has_any } stored);

/// The fall after an alarm. It raises no further alarm.
#[derive(Debug, Clone)]
struct FallHold<L> {
    lowest: L,
    /// Bins since the lowest force; negative if no fall is held.
    since_lowest: L,
    bins: L,
}

struct FallState<L: Lane> {
    was_holding: L::Mask,
    ended: Option<L::Mask>,
}

impl<L: Lane> FallHold<L> {
    #[inline(always)]
    fn begin(&mut self, mask: L::Mask, force: L) {
        self.lowest = L::select(mask, force, self.lowest);
        self.since_lowest = L::select(mask, L::zero(), self.since_lowest);
        self.bins = L::select(mask, L::zero(), self.bins);
    }

    /// Processes the force of a bin (N) with the scale of its changes. The fall ends after two references in which the
    /// force has not fallen further, or with a new load.
    #[inline(always)]
    fn update(&mut self, force: L, scale: L, times: &Times) -> FallState<L> {
        let one = L::splat(1.0);
        let was_holding = self.since_lowest.ge(L::zero());
        if !was_holding.any() {
            return FallState { was_holding, ended: None };
        }
        let is_lower = force.lt(self.lowest - scale.max(L::splat(LEAST_SHARE) * self.lowest));
        self.lowest = L::select(is_lower, force, self.lowest);
        let since = L::select(is_lower, L::zero(), self.since_lowest + one);
        self.bins = self.bins + one;
        let is_loaded = force.gt(self.lowest + L::splat(NEW_LOAD) * scale) & since.ge(L::splat(NEW_LOAD_BINS));
        let is_over = since.ge(L::splat(2.0 * times.reference as f64)) | self.bins.ge(L::splat(times.hold));
        let ends = was_holding & (is_loaded | is_over);
        self.since_lowest = L::select(was_holding & !ends, since, -one);
        FallState { was_holding, ended: ends.any().then_some(ends) }
    }
}

crate::lane::gather!(FallHold { lowest, since_lowest, bins } stored);

#[cfg(test)]
mod tests {
    use super::*;

    /// Processes forces (N) and positions (m) `tick_s` apart. Returns the times (s) at which the distance exceeds 7.
    fn alarms_s(tick_s: f64, end_s: f64, signal: impl Fn(f64) -> (f64, f64)) -> [Option<f64>; 3] {
        let mut adaptive = Adaptive::<f64>::new(&DistanceSettings::DEFAULT, tick_s);
        let mut found = [None; 3];
        let mut count = 0;
        for sample in 0..(end_s / tick_s) as usize {
            let time_s = sample as f64 * tick_s;
            let (force_n, depth_m) = signal(time_s);
            // A synthetic noise of 10 mN, the same at every rate.
            let noise_n = 0.02 * (libm::fmod(libm::fabs(libm::sin(12.9898 * sample as f64)) * 43_758.5, 1.0) - 0.5);
            let input = DetectorInput {
                force_n: force_n + noise_n,
                predicted_force_n: 0.0,
                residual_n: 0.0,
                correction: [0.0; 2],
                depth_m,
                velocity_m_per_s: 0.0,
                in_contact: false,
            };
            if adaptive.update(&input) > 7.0 {
                adaptive.reset(true);
                if count < found.len() {
                    found[count] = Some(time_s);
                    count += 1;
                }
            }
        }
        found
    }

    /// An insertion at 10 mm/s into 500 N/m that ruptures at 1 s, within `fall_s`.
    fn insertion(fall_s: f64) -> impl Fn(f64) -> (f64, f64) {
        move |time_s| {
            let (load_n, depth_m) = (5.0 * time_s.min(1.0), 0.01 * time_s);
            (load_n - 3.0 * ((time_s - 1.0) / fall_s).clamp(0.0, 1.0), depth_m)
        }
    }

    #[test]
    fn a_fall_raises_exactly_one_alarm_at_every_rate() {
        for rate_hz in [100.0, 333.0, 700.0, 1000.0, 2000.0, 10_000.0] {
            for fall_s in [1e-3, 10e-3, 50e-3] {
                let found = alarms_s(1.0 / rate_hz, 2.0, insertion(fall_s));
                let latest_s = 1.0 + fall_s + f64::max(0.010, 3.0 / rate_hz);
                let is_in_time = found[0].is_some_and(|time_s| (1.0..=latest_s).contains(&time_s));
                assert!(is_in_time && found[1].is_none(), "{rate_hz} Hz, {fall_s} s: {found:?}");
            }
        }
    }

    #[test]
    fn a_released_or_stopped_needle_is_not_a_rupture() {
        // A rigid stop of 20 kN/m, pressed with 5 N and released in 30 ms; an encoder of 50 µm.
        let let_go = |time_s: f64| {
            let force_n = 5.0 * (time_s / 0.5).min(1.0) - 5.0 * ((time_s - 1.0) / 0.03).clamp(0.0, 1.0);
            (force_n, libm::round(force_n / 20e3 / 50e-6) * 50e-6)
        };
        // A spring of 300 N/m and a damper of 20 N·s/m, pushed at 50 mm/s and stopped within 20 ms.
        let stopped = |time_s: f64| {
            let since_s = (time_s - 0.5).max(0.0);
            let slowed = libm::exp(-since_s / 0.02);
            let depth_m = 0.05 * time_s.min(0.5) + 0.05 * 0.02 * (1.0 - slowed);
            (300.0 * depth_m + 20.0 * 0.05 * slowed, depth_m)
        };
        for rate_hz in [333.0, 1000.0, 5000.0] {
            assert_eq!(alarms_s(1.0 / rate_hz, 2.0, let_go), [None; 3], "let go at {rate_hz} Hz");
            assert_eq!(alarms_s(1.0 / rate_hz, 2.0, stopped), [None; 3], "stopped at {rate_hz} Hz");
        }
    }

    #[test]
    fn no_window_is_longer_than_the_bins() {
        for micros in 1..200_000 {
            let tick_s = 1e-6 * f64::from(micros);
            let Times { windows, reference, stiffness, .. } =
                Adaptive::<f64>::new(&DistanceSettings::DEFAULT, tick_s).times;
            assert!(windows[WINDOWS_S.len() - 1] + reference < BINS && stiffness < BINS, "{tick_s}");
        }
    }

    /// The definition in the doc comment, computed from the whole history of a signal without alarms, on bins of
    /// `bin_s`. Before the first bin the force and the position have their first values, and the surplus is 0.
    struct Definition {
        bin_s: f64,
        force: Vec<f64>,
        position: Vec<f64>,
        surplus: Vec<f64>,
        speed: Vec<f64>,
        scales: [f64; 5],
        squares: f64,
        products: f64,
        stiffest: f64,
        load: f64,
    }

    /// The value of a signal `ago` bins before its end, or its first value before its beginning.
    fn ago(signal: &[f64], ago: usize) -> f64 {
        signal[signal.len().saturating_sub(1 + ago)]
    }

    /// The value of a signal `ago` bins before its end, or 0 before its beginning.
    fn ago_or_0(signal: &[f64], ago: usize) -> f64 {
        if ago < signal.len() { signal[signal.len() - 1 - ago] } else { 0.0 }
    }

    impl Definition {
        fn bins(&self, time_s: f64) -> usize {
            ((time_s / self.bin_s).round() as usize).max(1)
        }

        fn moved(signal: &[f64], bins: usize) -> f64 {
            ago(signal, 0) - ago(signal, bins)
        }

        /// The distance at a bin, from the position of the next bin and the steps of encoder and sensor.
        fn update(&mut self, force: f64, position: f64, next_position: f64, steps: [f64; 2]) -> f64 {
            self.force.push(force);
            self.position.push(position);
            let [eight, reference, instant] = [8e-3, 15e-3, 4e-3].map(|time_s| self.bins(time_s));
            let is_loaded = ago(&self.force, eight) > 6.0 * self.scales[0];
            if is_loaded {
                let (rise, advance) = (Self::moved(&self.force, eight), Self::moved(&self.position, eight));
                let share = self.bin_s / 0.3;
                self.squares += (advance * advance - self.squares) * share;
                self.products += (advance * rise - self.products) * share;
            }
            let stiffness = if self.squares > 0.0 { (self.products / self.squares).max(0.0) } else { 0.0 };
            let unexplained = Self::moved(&self.force, 1) - stiffness * Self::moved(&self.position, 1);
            self.surplus.push(ago_or_0(&self.surplus, 0) + unexplained);
            let per = |bins: usize| 1.0 / (bins as f64 * self.bin_s);
            let mean = Self::moved(&self.position, reference) * per(reference);
            self.speed.push(mean.max((Self::moved(&self.position, instant) - steps[0]) * per(instant)));

            let over = |signal: &[f64], from: usize, to: usize, more: fn(f64, f64) -> f64| {
                (from..=to).map(|bins| ago(signal, bins)).reduce(more).expect("a bin")
            };
            let surplus_over = |from: usize, to: usize| {
                (from..=to).map(|bins| ago_or_0(&self.surplus, bins)).reduce(f64::min).expect("a bin")
            };
            // Four references, which cover the longest window and the reference before it.
            let whole = 4 * reference - 1;
            let retreat = over(&self.position, 0, whole, f64::max) - position + steps[0];
            let released = stiffness.max(self.stiffest) * retreat;
            let velocity = (next_position - ago(&self.position, instant - 1)) * per(instant);
            let mut largest = 0.0_f64;
            for (index, window_s) in [2e-3, 4e-3, 8e-3, 16e-3, 32e-3].into_iter().enumerate() {
                let window = self.bins(window_s);
                if Self::moved(&self.position, window) < 0.0 {
                    continue;
                }
                let peak = over(&self.force, window, window + reference - 1, f64::max);
                let speed = ago_or_0(&self.speed, window);
                let lost = ((speed - velocity) / speed.max(2e-3)).min(1.0);
                let (last, lowest) = (surplus_over(window, window + 1), surplus_over(window, window + reference - 1));
                let goes_through = lost < 0.1 && velocity > 5e-3 && last - lowest >= 0.1 * peak;
                let before = if goes_through { last } else { lowest };
                let falling = ago_or_0(&self.surplus, window + reference) - ago_or_0(&self.surplus, window);
                let continued = falling.max(0.0) * window as f64 / reference as f64;
                let fall = (before - ago(&self.surplus, 0) - continued).min(peak - force - released);
                let least = (0.1_f64.max(0.7 * lost) * peak).max(0.05 * self.load);
                if fall > least {
                    let scale = self.scales[index].max(0.5 * steps[1]).max(1e-9);
                    largest = largest.max(fall.min(peak) / scale);
                }
            }
            let is_at_rest = steps[0] < 1e-4 && Self::moved(&self.position, BINS - 1) <= 1e-9;
            let has_fallen = force < 0.9 * over(&self.force, 0, whole, f64::max);

            let count = self.force.len() as f64;
            let share = (1.0 / count).max((self.bin_s / 1.0).min(1.0));
            for (index, window_s) in [2e-3, 4e-3, 8e-3, 16e-3, 32e-3].into_iter().enumerate() {
                let window = self.bins(window_s).max(3);
                let rise = Self::moved(&self.force, window);
                let change = rise.abs().min((rise - stiffness * Self::moved(&self.position, window)).abs());
                let clipped = if count >= 50.0 { change.min(3.0 * self.scales[index]) } else { change };
                self.scales[index] += (clipped - self.scales[index]) * share;
            }
            self.load = (self.load * (-self.bin_s / 0.3).exp()).max(force);
            let longest = self.bins(32e-3).max(3);
            let (rise, advance) = (Self::moved(&self.force, longest), Self::moved(&self.position, longest));
            let is_load = rise > 6.0 * self.scales[4] && advance >= -steps[0];
            let load = if is_load { rise / advance.max(steps[0]).max(1e-9) } else { 0.0 };
            self.stiffest = load.max(self.stiffest * (-self.bin_s / 5.0).exp());
            if count >= 50.0 && has_fallen && !is_at_rest { largest } else { 0.0 }
        }
    }

    /// Compares the distance with its definition. Returns the number of samples at which it is above 0.
    fn compare(tick_s: f64, samples: usize, mut signal: impl FnMut(f64) -> (f64, f64)) -> usize {
        let mut adaptive = Adaptive::<f64>::new(&DistanceSettings::DEFAULT, tick_s);
        let in_bin = (1e-3 / tick_s - 1e-9).ceil().max(1.0) as usize;
        let mut definition = Definition {
            bin_s: in_bin as f64 * tick_s,
            force: vec![],
            position: vec![],
            surplus: vec![],
            speed: vec![],
            scales: [0.0; 5],
            squares: 0.0,
            products: 0.0,
            stiffest: 0.0,
            load: 0.0,
        };
        let (mut last, mut steps, mut bin) = (None::<[f64; 2]>, [1e-4, f64::MAX], vec![]);
        let (mut forces, mut positions): (Vec<f64>, Vec<f64>) = (vec![], vec![]);
        let (mut expected, mut above) = (0.0, 0);
        for sample in 0..samples {
            let (force, position) = signal(sample as f64 * tick_s);
            if let Some([x, f]) = last {
                for (step, (change, rounding)) in steps.iter_mut().zip([(position - x, 1e-9), (force - f, 1e-6)]) {
                    let change: f64 = change;
                    if change.abs() > rounding {
                        *step = step.min(change.abs());
                    }
                }
            } else {
                (forces, positions) = (vec![force; 2], vec![position]);
            }
            last = Some([position, force]);
            bin.push((force, position));
            if bin.len() == in_bin {
                let share = 1.0 / in_bin as f64;
                forces.push(bin.iter().map(|sample| sample.0).sum::<f64>() * share);
                positions.push(bin.iter().map(|sample| sample.1).sum::<f64>() * share);
                bin.clear();
                let mut three = [ago(&forces, 0), ago(&forces, 1), ago(&forces, 2)];
                three.sort_by(f64::total_cmp);
                expected = definition.update(three[1], ago(&positions, 1), ago(&positions, 0), steps);
            }
            let input = DetectorInput { force_n: force, depth_m: position, ..super::super::super::fixtures::QUIET };
            let distance = adaptive.update(&input);
            assert!(
                (distance - expected).abs() <= 1e-6 * expected.abs(),
                "{tick_s} s, sample {sample}: {distance} instead of {expected}"
            );
            above += usize::from(expected > 0.0);
        }
        above
    }

    /// An insertion with loads of several stiffnesses, falls of several lengths, impacts, stops, and retreats.
    fn eventful(seed: u64, encoder_m: f64, noise_n: f64) -> impl FnMut(f64) -> (f64, f64) {
        let mut noise = super::super::super::fixtures::Noise(seed);
        let (mut position, mut load, mut stiffness, mut speed, mut fall, mut phase) = (0.0, 0.5, 300.0, 0.01, 1.0, 0);
        let mut last_s = 0.0;
        move |time_s| {
            let passed_s = time_s - last_s;
            last_s = time_s;
            let next = (time_s / 0.1) as u32;
            if next != phase {
                phase = next;
                stiffness = 800.0 * (1.0 + noise.next());
                speed = [0.01, 0.03, 0.0, 0.012, -0.01, 0.02, 0.006][phase as usize % 7] * (1.0 + 0.2 * noise.next());
                fall = if phase % 2 == 0 { 0.1 + 0.6 * noise.next().abs() } else { 0.0 };
            }
            // In the first ten milliseconds of every other phase a share of the load is lost.
            if time_s - 0.1 * f64::from(phase) < 0.01 {
                load *= 1.0 - fall * (passed_s / 0.01).min(1.0);
            }
            position += speed * passed_s;
            load += stiffness * speed * passed_s;
            let spike = if phase % 5 == 3 && time_s - 0.1 * f64::from(phase) > 0.05 { 0.3 * load } else { 0.0 };
            let read_m = if encoder_m > 0.0 { (position / encoder_m).round() * encoder_m } else { position };
            (load + spike + 2.0 * speed + noise_n * noise.next(), read_m)
        }
    }

    #[test]
    fn the_distance_follows_its_definition_at_every_sample() {
        for tick_s in [1e-3, 5e-4, 3e-4, 2e-3, 6e-3, 0.02] {
            let samples = (6.0 / tick_s) as usize;
            for (seed, encoder_m, noise_n) in [(1, 0.0, 0.01), (2, 2e-6, 0.02), (3, 2e-4, 0.005), (4, 0.0, 0.1)] {
                let above = compare(tick_s, samples, eventful(seed, encoder_m, noise_n));
                assert!(above > samples / 500, "falls are found: {above} at {tick_s} s, {seed}");
            }
        }
    }

    #[test]
    fn extremes_cover_the_last_bins() {
        let mut noise = super::super::super::fixtures::Noise(3);
        for reference in 1..=15 {
            let mut values = [0.0; BINS];
            let (mut low, mut high) = (Extremes::<f64>::new(0.0), Extremes::<f64>::new(0.0));
            let mut all: Vec<f64> = vec![0.0; BINS];
            for bin in 1..200 {
                let (newest, value) = (bin % BINS, noise.next());
                (values[newest], all) = (value, {
                    all.push(value);
                    all
                });
                low.update(&values, newest, reference, Lane::min);
                high.update(&values, newest, reference, Lane::max);
                let last = |count: usize| all[all.len() - count..].iter().copied();
                assert_eq!(low.whole[newest], last(reference).fold(f64::INFINITY, f64::min), "{reference} {bin}");
                assert_eq!(high.whole[newest], last(reference).fold(f64::NEG_INFINITY, f64::max), "{reference} {bin}");
                assert_eq!(low.twos[newest], last(2).fold(f64::INFINITY, f64::min), "{bin}");
            }
        }
    }

    #[test]
    fn after_forgetting_every_earlier_value_equals_the_given_one() {
        let mut extremes = Extremes::<f64>::new(3.0);
        extremes.forget(false, 1.0);
        assert!(extremes.whole.iter().chain(&extremes.twos).all(|&value| value == 3.0));
        extremes.forget(true, 1.0);
        assert!(extremes.whole.iter().chain(&extremes.twos).all(|&value| value == 1.0));
        assert!(extremes.fours.iter().chain(&extremes.eights).all(|&value| value == 1.0));
    }

    #[test]
    fn a_bin_is_the_mean_of_its_samples_and_the_median_of_three_bins() {
        let mut bin = Bin::<f64>::new(2);
        let mut add = |force, position| bin.add(force, position);
        assert_eq!(add(1.0, 0.5), None);
        // The bins before the first one have its force and position.
        assert_eq!(add(3.0, 1.5), Some((1.0, 0.5)));
        assert_eq!((add(4.0, 2.0), add(6.0, 4.0)), (None, Some((2.0, 1.0))));
        assert_eq!((add(0.0, 5.0), add(1.0, 5.0)), (None, Some((2.0, 3.0))), "an outlier is dropped");
        assert_eq!((add(3.0, 6.0), add(3.0, 6.0)), (None, Some((3.0, 5.0))));
    }

    #[test]
    fn the_steps_of_the_sensors_are_the_smallest_changes_above_rounding() {
        let mut bin = Bin::<f64>::new(1);
        bin.add(1.0, 0.0);
        assert_eq!(bin.steps, [MAX_RESOLUTION_M, f64::MAX], "before any change");
        bin.add(1.5, 3e-5);
        bin.add(1.25, 1e-5);
        bin.add(1.25 + 1e-7, 1e-5 + 1e-10);
        bin.add(2.25, -1.0);
        assert!((bin.steps[0] - 2e-5).abs() < 1e-15 && bin.steps[1] == 0.25, "{:?}", bin.steps);
    }

    #[test]
    fn a_force_that_does_not_change_is_stuck_after_a_fifth_of_a_second() {
        for tick_s in [1e-3, 5e-4] {
            let mut adaptive = Adaptive::<f64>::new(&DistanceSettings::DEFAULT, tick_s);
            let mut ready = |force_n| {
                adaptive.update(&super::super::super::fixtures::with_force(force_n));
                adaptive.is_ready() == Some(true)
            };
            let per_bin = (1e-3 / tick_s).round() as u32;
            let known = (1..).find(|&sample| ready(f64::from(sample % 2)));
            assert_eq!(known, Some(50 * per_bin), "after 50 bins the scales are known");
            let stuck = (1..).find(|_| !ready(0.5));
            // A force that has just changed counts as changed until the end of its bin.
            assert!(stuck.is_some_and(|samples| (201 * per_bin..=202 * per_bin).contains(&samples)), "{stuck:?}");
            assert!(ready(1.0), "it has changed");
        }
    }

    fn hold() -> (FallHold<f64>, Times) {
        (FallHold { lowest: 0.0, since_lowest: -1.0, bins: 0.0 }, Times::of(1e-3))
    }

    /// The number of bins after which a fall that begins at 4 N ends, for the forces of the following bins.
    fn ends_after(scale: f64, force: impl Fn(u32) -> f64) -> u32 {
        let (mut hold, times) = hold();
        assert!(!hold.update(4.0, scale, &times).was_holding, "not before an alarm");
        hold.begin(false, 4.0);
        assert!(!hold.update(4.0, scale, &times).was_holding, "in another lane");
        hold.begin(true, 4.0);
        for bin in 1..500 {
            let held = hold.update(force(bin), scale, &times);
            assert!(held.was_holding, "{bin}");
            if held.ended == Some(true) {
                assert!(!hold.update(force(bin), scale, &times).was_holding, "it has ended");
                return bin;
            }
            assert_eq!(held.ended, None);
        }
        panic!("it does not end");
    }

    #[test]
    fn a_held_fall_ends_after_two_references_without_a_further_fall() {
        assert_eq!(ends_after(0.01, |_| 4.0), 30);
        // At bin 20 the force loses a quarter more, which restarts the 30 bins.
        assert_eq!(ends_after(0.01, |bin| if bin < 20 { 4.0 } else { 3.0 }), 50);
        // A loss of less than a tenth of the force, or less than the scale, is not a further fall.
        assert_eq!(ends_after(0.01, |bin| if bin < 20 { 4.0 } else { 3.7 }), 30);
        assert_eq!(ends_after(2.0, |bin| if bin < 20 { 4.0 } else { 3.0 }), 30);
    }

    #[test]
    fn a_held_fall_ends_at_the_latest_after_150_ms() {
        assert_eq!(ends_after(1e-30, |bin| 4.0 * 0.85_f64.powi(bin as i32)), 150);
    }

    #[test]
    fn a_new_load_ends_a_held_fall_once_it_has_lasted_two_bins() {
        // Ten scales above the lowest force.
        assert_eq!(ends_after(0.01, |bin| if bin < 5 { 4.0 } else { 4.11 }), 5);
        assert_eq!(ends_after(0.01, |_| 4.11), 2, "not in the first bin");
        assert_eq!(ends_after(0.01, |_| 4.09), 30, "a smaller rise is no load");
    }

    #[test]
    fn times_are_rounded_to_whole_bins() {
        let times = Times::of(2e-3);
        assert_eq!((times.windows, times.reference, times.stiffness, times.instant), ([1, 2, 4, 8, 16], 8, 4, 2));
        assert_eq!((times.hold, times.stuck), (75.0, 100.0));
        assert_eq!(times.trends, [0.125, 0.25, 0.5, 1.0, 2.0]);
        let is_close = |a: f64, b: f64| (a - b).abs() < 1e-9 * b;
        assert!(is_close(times.per_reference, 1.0 / 16e-3) && is_close(times.per_instant, 1.0 / 4e-3), "{times:?}");
        assert!(is_close(times.scale_share, 2e-3) && is_close(times.stiffness_share, 2e-3 / 0.3), "{times:?}");
        assert!(
            is_close(times.stiffest_decay, (-4e-4_f64).exp()) && is_close(times.load_decay, (-2e-3_f64 / 0.3).exp())
        );
        let slow = Times::of(3.0);
        assert_eq!((slow.scale_share, slow.stiffness_share, slow.windows), (1.0, 1.0, [1; 5]));
    }

    #[test]
    fn a_wanted_rate_scales_the_distance_by_the_threshold_over_its_level() {
        let rate = |false_alarms_per_min| {
            let rate = super::super::RateSettings { false_alarms_per_min };
            Adaptive::<f64>::new(&DistanceSettings { rate, ..DistanceSettings::DEFAULT }, 1e-3)
        };
        let (mut plain, mut rated) = (rate(None), rate(Some(0.1)));
        let mut signal = eventful(7, 0.0, 0.02);
        let mut above = 0;
        for sample in 0..3000 {
            let (force_n, depth_m) = signal(1e-3 * f64::from(sample));
            let input = DetectorInput { force_n, depth_m, ..super::super::super::fixtures::QUIET };
            let level = rated.tail.as_ref().expect("a rate is wanted").level();
            let (value, relative) = (plain.update(&input), rated.update(&input));
            assert!((relative - value * THRESHOLD / level).abs() < 1e-9 * value.max(1.0), "{sample}");
            above += usize::from(value > 0.0);
        }
        assert!(above > 10, "{above}");
        let credit = rated.tail.as_ref().expect("a rate is wanted").sums();
        rated.reset(true);
        assert_ne!(rated.tail.as_ref().expect("a rate is wanted").sums(), credit, "an alarm counts in the tail");
        assert_eq!(rated.value, 0.0);
    }
}
