#[cfg(test)]
use super::resetting::dot;
use super::settings::RlsSettings;
use crate::lane::Lane;

/// The information `D` from samples, in addition to the prior:
///
/// ```text
/// D_k = D_{k-1} + δ (α φ φᵀ - (1-λ) D_{k-1}),   D_0 = 0
/// F_k = (I/F_0 + D_k)⁻¹
/// ```
/// Plain forgetting, `F_k⁻¹ = λ F_{k-1}⁻¹ + α φ φᵀ`, lets the gain grow by `1/λ` per sample in directions without
/// excitation. Here `0 <= D <= max(α φᵀφ) / (1-λ)`, so `1 / (1/F_0 + max(α φᵀφ) / (1-λ)) <= F <= F_0`.
///
/// Derived here; Lai and Bernstein (2023, arXiv:2308.04259, introduction read) survey such methods.
#[derive(Debug, Clone)]
pub(super) struct Exponential<L, const N: usize> {
    /// `1/F_0`.
    prior: L,
    /// `1 - λ`.
    forgotten: L,
    information: [[L; N]; N],
}

impl<L: Lane, const N: usize> Exponential<L, N> {
    pub(super) fn new(settings: &RlsSettings, factor: f64) -> Self {
        Self {
            prior: L::splat(1.0 / settings.initial_gain),
            forgotten: L::splat(1.0 - factor),
            information: [[L::zero(); N]; N],
        }
    }

    /// Returns `F_k φ` and its factor to each parameter's share of an error.
    #[inline(always)]
    pub(super) fn update(&mut self, regressor: [L; N], delta: L, inverse_weight: L) -> ([L; N], L) {
        let weight = delta / inverse_weight;
        let kept = L::splat(1.0) - delta * self.forgotten;
        for i in 0..N {
            for j in i..N {
                let information = self.information[i][j] * kept + weight * (regressor[i] * regressor[j]);
                self.information[i][j] = information;
                self.information[j][i] = information;
            }
        }
        (self.solve(regressor), weight)
    }

    /// `(I/F_0 + D)⁻¹ b` by `L D Lᵀ` elimination; the pivots' bound guards against rounding.
    #[inline(always)]
    fn solve(&self, b: [L; N]) -> [L; N] {
        let mut rows = self.information;
        let mut x = b;
        let mut inverse_pivots = [L::zero(); N];
        for k in 0..N {
            let pivot = (rows[k][k] + self.prior).max(self.prior);
            inverse_pivots[k] = L::splat(1.0) / pivot;
            let above = rows[k];
            for i in k + 1..N {
                let factor = above[i] * inverse_pivots[k];
                for (value, above) in rows[i].iter_mut().zip(above).skip(i) {
                    *value = *value - factor * above;
                }
                x[i] = x[i] - factor * x[k];
            }
        }
        for k in (0..N).rev() {
            let mut sum = x[k];
            for j in k + 1..N {
                sum = sum - rows[k][j] * x[j];
            }
            x[k] = sum * inverse_pivots[k];
        }
        x
    }

    #[cfg(test)]
    pub(super) fn gain(&self) -> [[L; N]; N] {
        core::array::from_fn(|i| self.solve(core::array::from_fn(|j| L::splat(if i == j { 1.0 } else { 0.0 }))))
    }
}

#[cfg(test)]
pub(super) fn form<L: Lane, const N: usize>(gain: [[L; N]; N], regressor: [L; N]) -> L {
    dot(core::array::from_fn(|i| dot(gain[i], regressor)), regressor)
}

crate::lane::gather!(Exponential[N] { prior, forgotten, information } stored);
