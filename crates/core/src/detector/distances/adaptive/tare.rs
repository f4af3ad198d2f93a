//! The force without load: what the sensor shows before contact.

use crate::lane::Lane;

/// Time constant with which the force without load follows a lower force, in s.
const SINKING_S: f64 = 5.0;

/// A load below this share of the force without load may be no load at all: the recording may begin under load.
const LEAST_SHARE: f64 = 0.05;

/// The force without load, so that a constant offset of the sensor does not hide ruptures.
///
/// It is the mean of the first forces. Later it follows lower forces, because a recording may begin under load.
#[derive(Debug, Clone)]
pub(super) struct Tare<L> {
    unloaded_n: L,
}

impl<L: Lane> Tare<L> {
    pub(super) fn new() -> Self {
        Self { unloaded_n: L::zero() }
    }

    /// Averages the force of a bin (N), the `bins`th from the beginning.
    #[inline(always)]
    pub(super) fn average(&mut self, force: L, bins: f64) {
        self.unloaded_n = self.unloaded_n + (force - self.unloaded_n) * L::splat(1.0 / bins);
    }

    /// Follows a lower force (N) by a share per bin.
    #[inline(always)]
    pub(super) fn sink(&mut self, force: L, share: f64) {
        self.unloaded_n = self.unloaded_n + (force - self.unloaded_n).min(L::zero()) * L::splat(share);
    }

    /// The share by which the force without load sinks per bin of `bin_s`.
    pub(super) fn share(bin_s: f64) -> f64 {
        (bin_s / SINKING_S).min(1.0)
    }

    /// The load at a force in N.
    #[inline(always)]
    pub(super) fn load(&self, force: L) -> L {
        force - self.unloaded_n
    }

    /// The force that a fall is compared with, in N: the load, or the force itself as long as there may be no load.
    #[inline(always)]
    pub(super) fn size(&self, force: L) -> L {
        let load = self.load(force);
        L::select(load.lt(self.unloaded_n.abs() * L::splat(LEAST_SHARE)), force.abs(), load)
    }
}

crate::lane::gather!(Tare { unloaded_n } stored);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_force_without_load_is_the_mean_of_the_first_forces() {
        let mut tare = Tare::<f64>::new();
        [19.0, 20.0, 21.0, 20.0].into_iter().zip(1..).for_each(|(force, bins)| tare.average(force, f64::from(bins)));
        assert!((tare.load(23.0) - 3.0).abs() < 1e-12);
    }

    #[test]
    fn the_force_without_load_follows_lower_forces_only() {
        let mut tare = Tare::<f64>::new();
        (0..100).for_each(|_| tare.sink(1.0, 0.1));
        assert_eq!(tare.load(1.0), 1.0);
        tare.sink(-1.0, 0.1);
        assert!((tare.load(0.0) - 0.1).abs() < 1e-12);
        assert_eq!(Tare::<f64>::share(0.01), 0.002);
    }

    #[test]
    fn without_a_clear_load_a_fall_is_compared_with_the_force() {
        let mut tare = Tare::<f64>::new();
        tare.average(8.0, 1.0);
        assert_eq!([8.3, 7.0, 8.5].map(|force| tare.size(force)), [8.3, 7.0, 0.5]);
    }
}
