use super::estimator::{BuiltIn, Estimate, Estimator};
use super::friction::Friction;
use super::linear::Linear;
use super::settings::RlsSettings;
use crate::lane::{Lane, by_index};

/// The smaller error of the models with and without friction: one of them predicts other changes, such as a reversal,
/// but neither a rupture. No source was found. An interacting multiple model (Blom and Bar-Shalom 1988) needs a
/// noise level and a transition matrix.
///
/// Stiffness and damping come from the model without friction, so they do not jump.
#[derive(Debug, Clone)]
pub struct LeastResidual<L> {
    without: Linear<L>,
    with: Friction<L>,
}

impl<L: Lane> LeastResidual<L> {
    pub(super) fn new(settings: &RlsSettings) -> Self {
        Self { without: Linear::new(settings), with: Friction::new(settings) }
    }
}

impl<L: Lane> BuiltIn for LeastResidual<L> {
    const EXTRA_PARAMETER: Option<&'static str> = <Friction<f64> as BuiltIn>::EXTRA_PARAMETER;

    fn build(settings: &RlsSettings) -> Self {
        Self::new(settings)
    }
}

impl<L: Lane> Estimator<L> for LeastResidual<L> {
    #[inline(always)]
    fn update(&mut self, force_n: L, depth_m: L, velocity_m_per_s: L) -> Estimate<L> {
        let without = self.without.update(force_n, depth_m, velocity_m_per_s);
        let with = self.with.update(force_n, depth_m, velocity_m_per_s);
        let friction_is_better = with.residual_n.abs().lt(without.residual_n.abs());
        let chosen = |with: L, without: L| L::select(friction_is_better, with, without);
        Estimate {
            predicted_force_n: chosen(with.predicted_force_n, without.predicted_force_n),
            residual_n: chosen(with.residual_n, without.residual_n),
            correction: by_index!(2, |i| chosen(with.correction[i], without.correction[i])),
            stiffness_n_per_m: without.stiffness_n_per_m,
            damping_n_s_per_m: without.damping_n_s_per_m,
            extra_parameter: with.extra_parameter,
        }
    }

    #[inline(always)]
    fn skip(&mut self) {
        self.without.skip();
        self.with.skip();
    }
}

crate::lane::gather!(LeastResidual { without, with } stored);
