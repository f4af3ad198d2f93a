use super::{MAX_RESOLUTION_M, MEDIAN_BINS, ROUNDING};
use crate::lane::Lane;

#[derive(Debug, Clone)]
pub(super) struct Bin<L> {
    samples: usize,
    filled: usize,
    has_any: bool,
    sums: [L; 2],
    last: [L; 2],
    /// Smallest changes of position (m) and force (N).
    pub(super) steps: [L; 2],
    pub(super) unchanged: L,
    forces: [L; MEDIAN_BINS],
    pub(super) position: L,
}

impl<L: Lane> Bin<L> {
    pub(super) fn new(samples: usize) -> Self {
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

    /// Returns the median force and the position of the bin before, once a bin is complete.
    #[inline(always)]
    pub(super) fn add(&mut self, force: L, position: L) -> Option<(L, L)> {
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

#[cfg(test)]
mod tests {
    use super::*;

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
}
