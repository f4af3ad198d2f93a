use super::KNOWN_BINS;
use crate::lane::Lane;

const SINKING_S: f64 = 5.0;

/// Smallest clear load, relative to the force without load.
const LEAST_SHARE: f64 = 0.05;

/// Smallest clear load, in multiples of the usual change.
const LEAST_SCALES: f64 = 6.0;

/// A smaller mean, in multiples of the usual change, is noise.
const TARED_SCALES: f64 = 20.0;

/// The force without load: the mean of the first forces, or 0 if it is noise. It follows lower forces down to 0,
/// because a recording may begin under load.
#[derive(Debug, Clone)]
pub(super) struct Tare<L> {
    unloaded_n: L,
    bins: f64,
}

impl<L: Lane> Tare<L> {
    pub(super) fn new() -> Self {
        Self { unloaded_n: L::zero(), bins: 0.0 }
    }

    #[inline(always)]
    pub(super) fn update(&mut self, force: L, share: f64) {
        let zero = L::zero();
        if self.bins < KNOWN_BINS {
            self.bins += 1.0;
            self.unloaded_n = self.unloaded_n + (force - self.unloaded_n) * L::splat(1.0 / self.bins);
        } else {
            let lower = (force - self.unloaded_n).min(zero) * L::splat(share);
            self.unloaded_n = (self.unloaded_n + lower).max(self.unloaded_n.min(zero));
        }
    }

    #[inline(always)]
    pub(super) fn settle(&mut self, scale: L) {
        let is_tared = self.unloaded_n.abs().lt(scale * L::splat(TARED_SCALES));
        self.unloaded_n = L::select(is_tared, L::zero(), self.unloaded_n);
    }

    pub(super) fn share(bin_s: f64) -> f64 {
        (bin_s / SINKING_S).min(1.0)
    }

    #[inline(always)]
    pub(super) fn load(&self, force: L) -> L {
        force - self.unloaded_n
    }

    /// The load, or the force unless the load is clear now and `before`.
    #[inline(always)]
    pub(super) fn size(&self, force: L, before: L, scale: L) -> L {
        let clear = (self.unloaded_n.abs() * L::splat(LEAST_SHARE)).max(scale * L::splat(LEAST_SCALES));
        let is_clear = self.load(force.min(before)).ge(clear);
        L::select(is_clear, self.load(force), force.abs())
    }

    #[inline(always)]
    pub(super) fn smallest_size(&self, force: L) -> L {
        self.load(force).min(force.abs())
    }
}

crate::lane::gather!(Tare { unloaded_n } same { bins } stored);

#[cfg(test)]
mod tests {
    use super::*;

    /// The tare after bins of a constant force (N), as many as it averages.
    fn after(force: f64) -> Tare<f64> {
        let mut tare = Tare::<f64>::new();
        (0..KNOWN_BINS as u32).for_each(|_| tare.update(force, 0.1));
        tare
    }

    #[test]
    fn the_force_without_load_is_the_mean_of_the_first_forces() {
        let mut tare = Tare::<f64>::new();
        [19.0, 20.0, 21.0, 20.0].into_iter().for_each(|force| tare.update(force, 0.1));
        assert!((tare.load(23.0) - 3.0).abs() < 1e-12);
    }

    #[test]
    fn a_mean_that_is_noise_is_a_tared_sensor() {
        for (mean, expected) in [(0.19, 0.0), (-0.19, 0.0), (0.21, 0.21), (-3.0, -3.0)] {
            let mut tare = after(mean);
            tare.settle(0.01);
            assert_eq!(tare.load(0.0), -expected);
        }
    }

    #[test]
    fn the_force_without_load_follows_lower_forces_down_to_0() {
        let at = |start: f64, force: f64, bins: u32| {
            let mut tare = after(start);
            (0..bins).for_each(|_| tare.update(force, 0.1));
            -tare.load(0.0)
        };
        assert!((at(8.0, 6.0, 1) - 7.8).abs() < 1e-12);
        assert_eq!((at(8.0, 9.0, 100), at(8.0, -5.0, 100)), (8.0, 0.0));
        assert_eq!((at(0.0, -5.0, 100), at(-3.0, -5.0, 100)), (0.0, -3.0), "a sensor that is tared, or below 0");
        assert_eq!(Tare::<f64>::share(0.01), 0.002);
    }

    #[test]
    fn without_a_clear_load_a_fall_is_compared_with_the_force() {
        let tare = after(8.0);
        assert_eq!([8.3, 7.0, 8.5].map(|force| tare.size(force, force, 0.01)), [8.3, 7.0, 0.5]);
        assert_eq!(tare.size(8.5, 8.0, 0.01), 8.5, "a load that has just come may be noise");
        assert_eq!([8.5, 8.75].map(|force| tare.size(force, force, 0.1)), [8.5, 0.75], "noise");
        assert_eq!([8.5, 7.0].map(|force| tare.smallest_size(force)), [0.5, -1.0]);
    }
}
