use super::estimator::{BuiltIn, Estimate, Estimator};
use super::regression::Regression;
use super::settings::RlsSettings;
use crate::lane::{Lane, by_index};

/// `y = K p + B v + C s(v)` in contact, with `s(v) = v / (|v| + v_s)`: a sign function would switch with noise at
/// standstill, and `tanh` is transcendental.
/// The regressor `ℓ s(v)` has the size of a depth, so `F_0` and `β` suit all three. Only different depths separate
/// friction from stiffness, only different speeds from damping.
#[derive(Debug, Clone)]
pub struct Friction<L> {
    regression: Regression<L, 3>,
    length: L,
    speed: L,
}

impl<L: Lane> Friction<L> {
    pub(super) fn new(settings: &RlsSettings) -> Self {
        Self {
            regression: Regression::new(settings),
            length: L::splat(settings.friction.length_m),
            speed: L::splat(settings.friction.speed_m_per_s),
        }
    }
}

impl<L: Lane> BuiltIn for Friction<L> {
    const EXTRA_PARAMETER: Option<&'static str> = Some("friction_n");

    fn build(settings: &RlsSettings) -> Self {
        Self::new(settings)
    }
}

impl<L: Lane> Estimator<L> for Friction<L> {
    #[inline(always)]
    fn update(&mut self, force_n: L, depth_m: L, velocity_m_per_s: L) -> Estimate<L> {
        let zero = L::zero();
        let update = self.regression.update(force_n);
        let sign = velocity_m_per_s / (velocity_m_per_s.abs() + self.speed);
        let contact = depth_m.gt(zero);
        let regressor = [depth_m, velocity_m_per_s, self.length * sign];
        self.regression.set_regressor(by_index!(3, |i| L::select(contact, regressor[i], zero)));
        let [stiffness, damping, friction] = self.regression.parameters();
        let [stiffness_change, damping_change, _] = update.correction;
        Estimate {
            predicted_force_n: update.predicted_force_n,
            residual_n: update.residual_n,
            correction: [stiffness_change, damping_change],
            stiffness_n_per_m: stiffness,
            damping_n_s_per_m: damping,
            extra_parameter: self.length * friction,
        }
    }

    #[inline(always)]
    fn skip(&mut self) {
        self.regression.set_regressor([L::zero(); 3]);
    }
}

crate::lane::gather!(Friction { regression, length, speed } stored);
