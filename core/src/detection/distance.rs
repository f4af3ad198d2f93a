//! The distance `s_k`: how unlike the hypothesis "nothing happened" a sample is (eq. 22, 23, 26, the paper's choices and two
//! textbook tests).

use super::likelihood_ratio::{LikelihoodRatio, MAX_WINDOW_SAMPLES};
use super::page_hinkley::PageHinkley;
use crate::lane::Lane;

crate::choice! {
    /// What decides: e², e² of drops, eq. 22, 23, the stiffness of eq. 26, the derivative, GLR or Page-Hinkley.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum DistanceKind at "detector.distance" = SquaredResidual {
        /// `s_k = e_k²` in N²: the paper's choice (4.4.3).
        "squared-residual" => SquaredResidual,
        /// `s_k = e_k²` in N² where the force falls short of an expected resisting force (`e_k < 0 < ŷ_k`), else 0. A tissue
        /// that stiffens faster than the estimator follows then neither adds to the decision nor disarms the detector.
        "squared-drop" => SquaredDrop,
        /// Log-likelihood ratio of a mean shifted from 0 to `m_1` (eq. 22), dimensionless.
        "mean-change" => MeanChange,
        /// Log-likelihood ratio of a variance grown from `σ_0²` to `σ_1²` (eq. 23), dimensionless.
        "variance-change" => VarianceChange,
        /// Magnitude of the stiffness component of `H_k` in N/m (eq. 26): the earlier proposal of Barbé et al. (2006).
        "parameter-change" => ParameterChange,
        /// `(y_k - y_{k-1})²` in N²: the direct filtering that the paper compares with (4.1).
        "force-derivative" => ForceDerivative,
        /// Log-likelihood ratio of a mean shifted by an unknown size within the last samples, dimensionless: it is what is
        /// compared with the threshold, and not accumulated (Willsky and Jones 1976).
        "likelihood-ratio" => LikelihoodRatio,
        /// What the residual lies beyond its running mean, in N: accumulated, the Page-Hinkley test (Hinkley 1971).
        "page-hinkley" => PageHinkley,
    }
}

impl DistanceKind {
    /// Whether the distance adds up (eq. 27); one that looks back by itself does not.
    #[must_use]
    pub fn accumulates(self) -> bool {
        self != Self::LikelihoodRatio
    }

    /// Whether only a mean shifted the way of `m_1` is seen.
    #[must_use]
    pub fn is_one_sided(self) -> bool {
        matches!(self, Self::MeanChange | Self::PageHinkley)
    }

    /// The unit of the distance, of its threshold and its drift.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Self::SquaredResidual | Self::SquaredDrop | Self::ForceDerivative => "N²",
            Self::MeanChange | Self::VarianceChange | Self::LikelihoodRatio => "1",
            Self::ParameterChange => "N/m",
            Self::PageHinkley => "N",
        }
    }
}

crate::settings! {
    /// What the two hypotheses of eq. 19 say of the residual.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Hypotheses in "detector." {
        /// sigma_0: spread of the residual when nothing happens.
        ///
        /// The paper measured 0.02 N.
        quiet_std_n: f64 [POSITIVE] = 0.02,
        /// sigma_1: its spread after a rupture.
        ///
        /// Above `σ_0`; the paper: at least 0.2 N.
        rupture_std_n: f64 [POSITIVE] = 0.2,
        /// m_1 of eq. 22: its mean after a rupture.
        ///
        /// Not 0; negative as the force falls short.
        rupture_mean_n: f64 [ANY] = -0.2,
        /// Correction of the stiffness that a rupture causes, for eq. 26.
        ///
        /// By one sample, in N/m.
        stiffness_change_n_per_m: f64 [POSITIVE] = 20.0,
    }
    where rupture_std_n: |s| s.rupture_std_n > s.quiet_std_n, "above detector.quiet_std_n";
    where rupture_mean_n: |s| s.rupture_mean_n != 0.0, "a finite number other than 0";
}

impl Hypotheses {
    /// Threshold γ and drift ν for a kind of distance, in its unit.
    ///
    /// The drift lies halfway between the two hypotheses and the threshold is what one sample of the changed one adds:
    /// for the squared residual `γ = (σ_1² - σ_0²)/2`, `ν = (σ_1² + σ_0²)/2` (4.6). A log-likelihood ratio brings its
    /// own drift.
    #[must_use]
    pub fn tuning(&self, kind: DistanceKind) -> (f64, f64) {
        let (quiet, changed) = (square(self.quiet_std_n), square(self.rupture_std_n));
        match kind {
            DistanceKind::SquaredResidual | DistanceKind::SquaredDrop | DistanceKind::ForceDerivative => {
                ((changed - quiet) / 2.0, (changed + quiet) / 2.0)
            }
            DistanceKind::MeanChange | DistanceKind::LikelihoodRatio => {
                (square(self.rupture_mean_n) / (2.0 * quiet), 0.0)
            }
            DistanceKind::VarianceChange => {
                (libm::log(self.quiet_std_n / self.rupture_std_n) + (changed / quiet - 1.0) / 2.0, 0.0)
            }
            DistanceKind::ParameterChange => (self.stiffness_change_n_per_m / 2.0, self.stiffness_change_n_per_m / 2.0),
            // Half of the smallest shift that is to be found is Hinkley's drift.
            DistanceKind::PageHinkley => (self.rupture_mean_n.abs() / 2.0, self.rupture_mean_n.abs() / 2.0),
        }
    }
}

/// The window that a likelihood ratio has unless told otherwise: what the estimator's default memory is in updates, after
/// which it has learnt the change and the residual no longer shows it (chosen here).
pub const WINDOW_SAMPLES: usize = 10;

crate::settings! {
    /// A kind of distance with the hypotheses that scale it.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Distance in "detector." {
        /// Which distance.
        kind: DistanceKind,
        /// What it compares.
        hypotheses: Hypotheses,
        /// How many samples the likelihood ratio looks back over, at most 64.
        ///
        /// From 1 to [`MAX_WINDOW_SAMPLES`]; the other distances have no window.
        window_samples: usize [1..] for "detector.distance" "likelihood-ratio" = WINDOW_SAMPLES,
    }
    where window_samples: |s| s.window_samples <= MAX_WINDOW_SAMPLES, "a whole number from 1 to 64";
}

impl Distance {
    /// Threshold γ and drift ν by [`Hypotheses::tuning`].
    #[must_use]
    pub fn tuning(&self) -> (f64, f64) {
        self.hypotheses.tuning(self.kind)
    }
}

/// A distance at work.
///
/// ```text
/// mean:      s = m_1/σ_0² (e - m_1/2)                              (22)
/// variance:  s = ln(σ_0/σ_1) + (1/σ_0² - 1/σ_1²) e²/2              (23)
/// ```
#[derive(Debug, Clone)]
pub(super) struct DistanceState<L> {
    kind: DistanceKind,
    scale: L,
    offset: L,
    last_force: L,
    started: bool,
    page_hinkley: PageHinkley<L>,
    /// Where it is this kind: by far the largest, and laid side by side with the rest.
    likelihood_ratio: Option<LikelihoodRatio<L>>,
}

impl<L: Lane> DistanceState<L> {
    pub(super) fn new(distance: &Distance) -> Self {
        let h = &distance.hypotheses;
        let (quiet, changed) = (square(h.quiet_std_n), square(h.rupture_std_n));
        let (scale, offset) = match distance.kind {
            DistanceKind::MeanChange => (h.rupture_mean_n / quiet, -square(h.rupture_mean_n) / (2.0 * quiet)),
            DistanceKind::VarianceChange => {
                ((1.0 / quiet - 1.0 / changed) / 2.0, libm::log(h.quiet_std_n / h.rupture_std_n))
            }
            _ => (1.0, 0.0),
        };
        Self {
            kind: distance.kind,
            scale: L::splat(scale),
            offset: L::splat(offset),
            last_force: L::zero(),
            started: false,
            page_hinkley: PageHinkley::new(h.rupture_mean_n),
            likelihood_ratio: (distance.kind == DistanceKind::LikelihoodRatio)
                .then(|| LikelihoodRatio::new(distance.window_samples, h.quiet_std_n)),
        }
    }

    /// Whether it is `e_k²`, of every residual or of those that tell of a drop; neither needs a state.
    #[inline(always)]
    pub(super) fn is_square(&self) -> bool {
        matches!(self.kind, DistanceKind::SquaredResidual | DistanceKind::SquaredDrop)
    }

    /// The distance, where it [is a square](DistanceState::is_square).
    #[inline(always)]
    pub(super) fn square(&self, e: L, predicted_force: L) -> L {
        if self.kind == DistanceKind::SquaredResidual {
            return e * e;
        }
        let falls_short = e.lt(L::zero()) & predicted_force.gt(L::zero());
        L::select(falls_short, e * e, L::zero())
    }

    #[inline(always)]
    pub(super) fn accumulates(&self) -> bool {
        self.kind.accumulates()
    }

    /// The distance of any kind.
    #[inline(always)]
    pub(super) fn update(&mut self, e: L, predicted_force: L, stiffness_correction: L, force: L) -> L {
        match self.kind {
            DistanceKind::SquaredResidual | DistanceKind::SquaredDrop => self.square(e, predicted_force),
            DistanceKind::MeanChange => self.scale * e + self.offset,
            DistanceKind::VarianceChange => self.scale * (e * e) + self.offset,
            DistanceKind::ParameterChange => stiffness_correction.abs(),
            DistanceKind::ForceDerivative => {
                if !self.started {
                    self.started = true;
                    self.last_force = force;
                }
                let change = force - self.last_force;
                self.last_force = force;
                change * change
            }
            DistanceKind::LikelihoodRatio => self.likelihood_ratio.as_mut().map_or(L::zero(), |ratio| ratio.update(e)),
            DistanceKind::PageHinkley => self.page_hinkley.update(e),
        }
    }

    /// Starts what looks back again where the mask holds.
    #[inline(always)]
    pub(super) fn reset(&mut self, mask: L::Mask) {
        if let Some(ratio) = &mut self.likelihood_ratio {
            ratio.reset(mask);
        }
        if self.kind == DistanceKind::PageHinkley {
            self.page_hinkley.reset(mask);
        }
    }
}

/// `x²`; `powi` is not in `core`.
fn square(x: f64) -> f64 {
    x * x
}

crate::lane::gather!(DistanceState { scale, offset, last_force, page_hinkley, likelihood_ratio } same { kind, started });

#[cfg(test)]
mod tests {
    use super::*;

    fn log_density(e: f64, mean: f64, std: f64) -> f64 {
        -(e - mean).powi(2) / (2.0 * std * std) - std.ln()
    }

    #[test]
    fn a_drop_is_a_resisting_force_that_falls_short() {
        let hypotheses = Hypotheses::default();
        let distance = |residual: f64, predicted: f64| {
            let distance = Distance { kind: DistanceKind::SquaredDrop, hypotheses, window_samples: 1 };
            DistanceState::<f64>::new(&distance).update(residual, predicted, 0.0, predicted + residual)
        };
        assert_eq!([distance(-0.5, 2.0), distance(0.5, 2.0), distance(-0.5, -2.0)], [0.25, 0.0, 0.0]);
    }

    #[test]
    fn eq_22_and_23_are_the_log_likelihood_ratios_of_eq_20() {
        let hypotheses = Hypotheses::default();
        for e in [-0.4, -0.07, 0.0, 0.03, 0.2] {
            let distance = |kind| {
                DistanceState::<f64>::new(&Distance { kind, hypotheses, window_samples: 1 }).update(e, 0.0, 0.0, e)
            };
            let mean = log_density(e, -0.2, 0.02) - log_density(e, 0.0, 0.02);
            let variance = log_density(e, 0.0, 0.2) - log_density(e, 0.0, 0.02);
            assert!((distance(DistanceKind::MeanChange) - mean).abs() < 1e-9);
            assert!((distance(DistanceKind::VarianceChange) - variance).abs() < 1e-9);
        }
    }
}
