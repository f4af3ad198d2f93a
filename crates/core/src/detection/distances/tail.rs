//! The tail of a distance without ruptures: the threshold that a wanted rate of false alarms needs.

use crate::lane::Lane;

/// Length of a block in s: its largest value counts as one peak, as values closer together belong to the same fall.
const BLOCK_S: f64 = 0.1;

/// Values above this belong to the tail.
const TAIL_FROM: f64 = 3.0;

/// What is assumed before the first sample, as if it had been observed: time in s, number of peaks above
/// [`TAIL_FROM`] in it, and the means of the logarithm of a peak over [`TAIL_FROM`] and of its square.
///
/// A peak every 2 s with a shape of 0.13: heavier than normal noise, so that there are rather too few false alarms in the
/// first minutes than too many.
const ASSUMED_S: f64 = 20.0;
const ASSUMED_PEAKS: f64 = 10.0;
const ASSUMED_MOMENTS: [f64; 2] = [0.18, 0.062];

/// Range of the shape of the tail. Below -0.5 it ends, above 1 it has no mean.
const SHAPE: (f64, f64) = (-0.5, 1.0);

crate::settings! {
    /// The wanted rate of false alarms.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct RateSettings in "detector." {
        /// Wanted rate of false alarms of the adaptive detector, per minute; its threshold of 7 then stands for it.
        ///
        /// The peaks of the distance above 3 since the start, one per 0.1 s and without those of alarms, give a
        /// generalised Pareto tail by the moments of Dekkers, Einmahl and de Haan (*Annals of Statistics* 17, 1989).
        /// Within a factor of three for noise with tails up to Student's t with 3 degrees of freedom, and for correlated
        /// normal noise; above it if the noise is both. Less where a tenth of the force is more than the noise.
        false_alarms_per_min: Option<f64> [POSITIVE],
    }
}

/// The peaks of a distance above [`TAIL_FROM`], and the value that is exceeded at a wanted rate.
#[derive(Debug, Clone)]
pub(super) struct Tail<L> {
    /// Wanted number of exceedances per s.
    wanted_hz: f64,
    block_bins: usize,
    bins: usize,
    block_s: f64,
    time_s: f64,
    /// The largest value of the present block.
    peak: L,
    /// Number of peaks, and sums of `ln(peak / TAIL_FROM)` and of its square.
    sums: [L; 3],
    /// The value that is exceeded at the wanted rate, and the mean logarithm of larger values over it.
    level: L,
    beyond: [L; 2],
    /// Number of alarms that can be false by the wanted rate, and have not come.
    credit: L,
}

impl<L: Lane> Tail<L> {
    /// The tail before the first bin, for bins `bin_s` (s) apart.
    pub(super) fn new(wanted_per_min: f64, bin_s: f64) -> Self {
        let block_bins = (libm::round(BLOCK_S / bin_s) as usize).max(1);
        let [first, second] = ASSUMED_MOMENTS;
        let sums = [1.0, first, second].map(|mean| L::splat(mean * ASSUMED_PEAKS));
        let mut tail = Self {
            wanted_hz: wanted_per_min / 60.0,
            block_bins,
            bins: 0,
            block_s: block_bins as f64 * bin_s,
            time_s: ASSUMED_S,
            peak: L::zero(),
            sums,
            level: L::zero(),
            beyond: [L::zero(); 2],
            credit: L::zero(),
        };
        tail.renew();
        tail
    }

    /// The value that is exceeded at the wanted rate.
    pub(super) fn level(&self) -> L {
        self.level
    }

    /// Adds the distance of a bin.
    #[inline(always)]
    pub(super) fn add(&mut self, value: L) {
        self.peak = self.peak.max(value);
        self.bins += 1;
        if self.bins >= self.block_bins {
            self.end_block();
        }
    }

    /// Takes the present block as one with an alarm, in the lanes of the mask.
    ///
    /// It is a rupture or a false alarm. As false count at most those of the wanted rate, with the mean of larger peaks:
    /// without them the tail would be cut off, and with all of them ruptures would raise the level.
    pub(super) fn take_alarm(&mut self, mask: L::Mask) {
        let zero = L::zero();
        self.peak = L::select(mask, zero, self.peak);
        let number = L::select(mask, self.credit.min(L::splat(1.0)), zero);
        self.credit = self.credit - number;
        let [mean, square] = self.beyond;
        self.count(number, number * mean, number * square);
    }

    #[inline(never)]
    fn end_block(&mut self) {
        self.time_s += self.block_s;
        self.bins = 0;
        let zero = L::zero();
        let peak = self.peak;
        let is_peak = L::select(peak.gt(L::splat(TAIL_FROM)), L::splat(1.0), zero);
        let log = L::from_lanes(|lane| libm::log((peak.lane(lane) / TAIL_FROM).max(1.0)));
        self.count(is_peak, log, log * log);
        self.credit = self.credit + L::splat(self.wanted_hz * self.block_s);
        self.peak = L::zero();
        self.renew();
    }

    /// Adds to the sums.
    fn count(&mut self, number: L, first: L, second: L) {
        for (sum, added) in self.sums.iter_mut().zip([number, first, second]) {
            *sum = *sum + added;
        }
    }

    fn renew(&mut self) {
        let [count, first, second] = self.sums;
        let (time_s, wanted_hz) = (self.time_s, self.wanted_hz);
        let mut beyond = self.beyond;
        self.level = L::from_lanes(|lane| {
            let count = count.lane(lane);
            let means = [first, second].map(|sum| sum.lane(lane) / count);
            let (level, means) = level(count / time_s / wanted_hz, means);
            (0..2).for_each(|moment| beyond[moment].set_lane(lane, means[moment]));
            level
        });
        self.beyond = beyond;
    }
}

/// The value that is exceeded by one of `times` peaks, from the means of the logarithm and of its square; and the mean
/// logarithm of larger peaks.
fn level(times: f64, [first, second]: [f64; 2]) -> (f64, [f64; 2]) {
    let spread = 1.0 - first * first / second;
    let lower = 1.0 - 0.5 / spread;
    let shape = (first + lower).clamp(SHAPE.0, SHAPE.1);
    let scale = TAIL_FROM * first * (1.0 - lower).max(0.0);
    let log = libm::log(times.max(1.0));
    let excess = if shape.abs() < 1e-6 { log } else { libm::expm1(shape * log) / shape };
    let level = TAIL_FROM + scale * excess;
    let further = (scale + shape * (level - TAIL_FROM)) / level;
    let beyond = libm::log(level / TAIL_FROM) + further;
    (level, [beyond, beyond * beyond + further * further])
}

crate::lane::gather!(Tail { peak, sums, level, beyond, credit } same { wanted_hz, block_bins, bins, block_s, time_s } stored);
