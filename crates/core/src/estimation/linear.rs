use super::Parameters;
use super::estimator::{BuiltIn, Estimate, Estimator};
use super::regression::Regression;
use super::settings::RlsSettings;
use crate::lane::Lane;

/// `y = K p + B v` in contact (eq. 8).
#[derive(Debug, Clone)]
pub struct Linear<L> {
    regression: Regression<L, 2>,
    velocity_share: L,
}

impl<L: Lane> Linear<L> {
    pub(super) fn new(settings: &RlsSettings) -> Self {
        let velocity_share = if settings.parameters == Parameters::Stiffness { 0.0 } else { 1.0 };
        Self { regression: Regression::new(settings), velocity_share: L::splat(velocity_share) }
    }
}

impl<L: Lane> BuiltIn for Linear<L> {
    fn build(settings: &RlsSettings) -> Self {
        Self::new(settings)
    }
}

impl<L: Lane> Estimator<L> for Linear<L> {
    #[inline(always)]
    fn update(&mut self, force_n: L, depth_m: L, velocity_m_per_s: L) -> Estimate<L> {
        let zero = L::zero();
        let update = self.regression.update(force_n);
        let contact = depth_m.gt(zero);
        let velocity = self.velocity_share * velocity_m_per_s;
        self.regression.set_regressor([L::select(contact, depth_m, zero), L::select(contact, velocity, zero)]);
        let [stiffness, damping] = self.regression.parameters();
        Estimate {
            predicted_force_n: update.predicted_force_n,
            residual_n: update.residual_n,
            correction: update.correction,
            stiffness_n_per_m: stiffness,
            damping_n_s_per_m: damping,
            extra_parameter: zero,
        }
    }

    #[inline(always)]
    fn skip(&mut self) {
        self.regression.set_regressor([L::zero(); 2]);
    }
}

crate::lane::gather!(Linear { regression, velocity_share } stored);
