use crate::lane::Lane;

const BLOCK_S: f64 = 0.1;

const TAIL_FROM: f64 = 3.0;

/// Prior: s, peaks, and means of `ln(peak / TAIL_FROM)` and of its square. Heavier than normal noise, so that the first
/// minutes have too few false alarms.
const ASSUMED_S: f64 = 20.0;
const ASSUMED_PEAKS: f64 = 10.0;
const ASSUMED_MOMENTS: [f64; 2] = [0.18, 0.062];

/// Below -0.5 the tail ends, above 1 it has no mean.
const SHAPE: (f64, f64) = (-0.5, 1.0);

crate::settings! {
    /// The wanted rate of false alarms.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct RateSettings in "detector." {
        /// Wanted rate of false alarms of the adaptive detector, per minute; its threshold of 7 then corresponds to
        /// this rate.
        ///
        /// A generalised Pareto tail of the peaks, by the moments of Dekkers, Einmahl and de Haan (*Annals of
        /// Statistics* 17, 1989).
        false_alarms_per_min: Option<f64> [POSITIVE],
    }
}

#[derive(Debug, Clone)]
pub(super) struct Tail<L> {
    wanted_hz: f64,
    block_bins: usize,
    bins: usize,
    block_s: f64,
    time_s: f64,
    peak: L,
    /// Number of peaks, sums of `ln(peak / TAIL_FROM)` and its square.
    sums: [L; 3],
    level: L,
    beyond: [L; 2],
    /// False alarms that the wanted rate still allows.
    credit: L,
}

impl<L: Lane> Tail<L> {
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

    pub(super) fn level(&self) -> L {
        self.level
    }

    #[inline(always)]
    pub(super) fn add(&mut self, value: L) {
        self.peak = self.peak.max(value);
        self.bins += 1;
        if self.bins >= self.block_bins {
            self.end_block();
        }
    }

    /// An alarm counts as false only while the wanted rate allows one. Without these peaks the tail would be cut off;
    /// with all of them ruptures would raise the level.
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

/// The value that one of `times` peaks exceeds, and the means over larger peaks.
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

#[cfg(test)]
impl<L: Lane> Tail<L> {
    pub(super) fn sums(&self) -> [L; 3] {
        self.sums
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn is_close(a: f64, b: f64) -> bool {
        (a - b).abs() < 1e-9 * b.abs().max(1.0)
    }

    #[test]
    fn the_level_of_a_pareto_tail_is_its_quantile() {
        // P(X > x) = (x / 3)^(-1/γ): the logarithm of X/3 is exponential with the mean γ.
        for shape in [0.05, 0.13, 0.5, 0.9] {
            for times in [1.0, 2.0, 50.0] {
                let (level, beyond) = level(times, [shape, 2.0 * shape * shape]);
                assert!(is_close(level, TAIL_FROM * f64::powf(times, shape)), "{shape} {times}: {level}");
                // For larger values the logarithm is again exponential, with the mean γ above the logarithm of the
                // level.
                let mean = shape * (times.ln() + 1.0);
                assert!(is_close(beyond[0], mean), "{shape} {times}: {beyond:?}");
                assert!(is_close(beyond[1], mean * mean + shape * shape), "{shape} {times}: {beyond:?}");
            }
        }
    }

    #[test]
    fn a_bounded_tail_stays_below_its_end() {
        // First moment 0.2, second 1.5 · 0.2²: the shape is 0.2 - 0.5 = -0.3, the scale 3 · 0.2 · 1.5 = 0.9, the end
        // 3 + 0.9 / 0.3.
        let of = |times| level(times, [0.2, 0.06]).0;
        assert!(is_close(of(8.0), 3.0 + 3.0 * (1.0 - f64::powf(8.0, -0.3))), "{}", of(8.0));
        assert!(of(1e30) < 6.0 && of(1e30) > 5.999);
    }

    #[test]
    fn a_tail_of_shape_0_is_exponential() {
        // First moment 0.25; the second makes the lower part of the shape -0.25, with a spread of 0.5 / 1.25.
        let second = 0.0625 / (1.0 - 0.4);
        let (level, _) = level(20.0, [0.25, second]);
        assert!(is_close(level, 3.0 + 3.0 * 0.25 * 1.25 * 20.0_f64.ln()), "{level}");
    }

    #[test]
    fn the_shape_of_the_tail_is_bounded() {
        // A lower part of -2, then an upper part of 2.
        let (short, _) = level(100.0, [0.1, 0.012]);
        assert!(is_close(short, 3.0 + 0.3 * 3.0 * (1.0 - 100.0_f64.powf(-0.5)) / 0.5), "{short}");
        let (heavy, _) = level(100.0, [2.0, 8.0]);
        assert!(is_close(heavy, 3.0 + 6.0 * 99.0), "{heavy}");
    }

    #[test]
    fn with_fewer_peaks_than_the_target_the_level_stays_at_the_beginning_of_the_tail() {
        assert_eq!(level(0.2, [0.18, 0.062]).0, TAIL_FROM);
    }

    /// The expected level for the assumed peaks plus the given ones, after a time in s.
    fn expected(per_min: f64, time_s: f64, peaks: &[f64]) -> f64 {
        let logs = peaks.iter().map(|peak| (peak / TAIL_FROM).ln());
        let count = ASSUMED_PEAKS + peaks.len() as f64;
        let first = ASSUMED_MOMENTS[0] * ASSUMED_PEAKS + logs.clone().sum::<f64>();
        let second = ASSUMED_MOMENTS[1] * ASSUMED_PEAKS + logs.map(|log| log * log).sum::<f64>();
        level(count / (ASSUMED_S + time_s) / (per_min / 60.0), [first / count, second / count]).0
    }

    #[test]
    fn before_the_first_sample_the_level_follows_from_the_assumed_peaks() {
        assert!(is_close(Tail::<f64>::new(1.0, 1e-3).level(), expected(1.0, 0.0, &[])));
        assert!(Tail::<f64>::new(0.1, 1e-3).level() > Tail::<f64>::new(1.0, 1e-3).level(), "a rarer alarm");
    }

    #[test]
    fn a_block_of_a_tenth_of_a_second_counts_its_largest_value_above_3() {
        for bin_s in [1e-3, 2e-3] {
            let mut tail = Tail::<f64>::new(0.5, bin_s);
            let bins = (0.1 / bin_s).round() as usize;
            for bin in 0..bins - 1 {
                tail.add(if bin == 7 { 4.5 } else { 2.0 });
                assert!(is_close(tail.level(), expected(0.5, 0.0, &[])), "not before its end");
            }
            tail.add(4.0);
            assert!(is_close(tail.level(), expected(0.5, 0.1, &[4.5])));
            (0..bins).for_each(|_| tail.add(3.0));
            assert!(is_close(tail.level(), expected(0.5, 0.2, &[4.5])), "3 is no peak");
            (0..bins).for_each(|_| tail.add(6.0));
            assert!(is_close(tail.level(), expected(0.5, 0.3, &[4.5, 6.0])));
        }
    }

    #[test]
    fn an_alarm_counts_as_false_while_the_wanted_rate_allows_it() {
        // 300 per minute: 0.5 per block.
        let mut tail = Tail::<f64>::new(300.0, 0.1);
        tail.add(0.0);
        let beyond = tail.beyond;
        let before = tail.sums;
        tail.take_alarm(false);
        assert_eq!(tail.sums, before, "no alarm");
        tail.take_alarm(true);
        let share = 0.5;
        for (index, mean) in [1.0, beyond[0], beyond[1]].into_iter().enumerate() {
            assert!(is_close(tail.sums[index], before[index] + share * mean), "{index}");
        }
        let before = tail.sums;
        tail.take_alarm(true);
        assert_eq!(tail.sums, before, "the credit is spent");
        for _ in 0..6 {
            tail.add(0.0);
        }
        let before = tail.sums[0];
        tail.take_alarm(true);
        assert!(is_close(tail.sums[0], before + 1.0), "an alarm counts at most once");
    }

    #[test]
    fn the_block_of_an_alarm_has_no_peak() {
        let mut tail = Tail::<f64>::new(1e-6, 1e-3);
        (0..50).for_each(|_| tail.add(20.0));
        tail.take_alarm(true);
        (0..50).for_each(|_| tail.add(1.0));
        assert!(is_close(tail.level(), expected(1e-6, 0.1, &[])));
    }
}
