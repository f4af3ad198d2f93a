use super::settings::RlsSettings;
use crate::lane::{Lane, by_index};

/// The gain `F` of [`super::Rls`] (eq. 13, 15, 17, 18) for `N` parameters.
///
/// Only one triangle is computed, so `F` stays symmetric; at most `F φ φᵀ F / (φᵀ F φ)` is subtracted, so it stays
/// positive definite.
#[derive(Debug, Clone)]
pub(super) struct Resetting<L, const N: usize> {
    initial_gain: L,
    initial_information: L,
    reset_threshold: L,
    gain: [[L; N]; N],
    information: L,
}

impl<L: Lane, const N: usize> Resetting<L, N> {
    pub(super) fn new(settings: &RlsSettings) -> Self {
        let gain = settings.initial_gain;
        let initial = N as f64 / gain;
        // The setting is for two parameters.
        let threshold = settings.reset_threshold + (initial - 2.0 / gain);
        Self {
            initial_gain: L::splat(gain),
            initial_information: L::splat(initial),
            reset_threshold: L::splat(threshold),
            gain: core::array::from_fn(|i| core::array::from_fn(|j| L::splat(if i == j { gain } else { 0.0 }))),
            information: L::splat(initial),
        }
    }

    /// Returns `F φ` and its factor to each parameter's share of an error.
    #[inline(always)]
    pub(super) fn update(&mut self, regressor: [L; N], delta: L, squared: L, inverse_weight: L) -> ([L; N], L) {
        let direction: [L; N] = by_index!(N, |i| dot(self.gain[i], regressor));
        let share = delta * (L::splat(1.0) / (inverse_weight + dot(regressor, direction)));
        self.information = self.information + delta * (squared / inverse_weight);
        let restore = self.information.ge(self.reset_threshold);
        for i in 0..N {
            for j in i..N {
                let learnt = self.gain[i][j] - share * (direction[i] * direction[j]);
                let initial = if i == j { self.initial_gain } else { L::zero() };
                let gain = L::select(restore, initial, learnt);
                self.gain[i][j] = gain;
                self.gain[j][i] = gain;
            }
        }
        self.information = L::select(restore, self.initial_information, self.information);
        (direction, share)
    }

    #[cfg(test)]
    pub(super) fn gain(&self) -> [[L; N]; N] {
        self.gain
    }
}

#[inline(always)]
pub(super) fn dot<L: Lane, const N: usize>(a: [L; N], b: [L; N]) -> L {
    let mut sum = a[0] * b[0];
    for i in 1..N {
        sum = sum + a[i] * b[i];
    }
    sum
}

crate::lane::gather!(Resetting[N] { initial_gain, initial_information, reset_threshold, gain, information } stored);
