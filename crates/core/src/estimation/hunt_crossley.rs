use super::estimator::{BuiltIn, Estimate, Estimator};
use super::regression::Regression;
use super::settings::RlsSettings;
use crate::lane::{Lane, Mask};

/// `p_r` in m, at which the power has no effect: `κ` and `n` are nearly independent at some centimetres. Chosen here.
const REFERENCE_DEPTH_M: f64 = 0.01;
/// `v_r`. Chosen here: at 0.01 m/s the errors on the in-vivo-like recording spread several times as far.
const REFERENCE_VELOCITY_M_PER_S: f64 = 0.05;
const FIRST_POWER: f64 = 1.0;
const MIN_POWER: f64 = 0.5;
const MAX_POWER: f64 = 4.0;
const MIN_DEPTH_M: f64 = 1e-6;
const MAX_DEPTH_M: f64 = 1.0;
/// Information `Σ b²` at which the power's gain is restored.
const POWER_MEMORY_N2: f64 = 20.0;

/// `y = μ pⁿ + λ pⁿ v` in contact (eq. 2), as `y = p_r p̃ⁿ (κ + ρ v / v_r)`.
///
/// Two estimators alternate (Diolaiti et al. 2005): one for `(κ, ρ)`, one for `n` from
/// `ln(y / (p_r (κ + ρ v/v_r))) = n ln p̃`, linearised and weighted by the force, because the logarithm overweighs small
/// forces:
///
/// ```text
/// e⁺_k = y_k - φᵀθ_k = ŷ⁺ ln p̃ (n - n_{k-1}),      ŷ⁺ = φᵀθ_k
/// n_k = n_{k-1} + f b e⁺ / (1 + f b²),    b = ŷ⁺ ln p̃,    f_k = f_{k-1} / (1 + f_{k-1} b²)
/// ```
/// `f` is restored to `1/N²` when `Σ b²` reaches 20 N². The text of Diolaiti et al. was not available: the stages are
/// from the paper's introduction and the abstract of Haddadi and Hashtrudi-Zaad (2012, IEEE T-RO 28(3)), the equations
/// derived and the numbers chosen here.
///
/// Reported are stiffness `y / p` at rest and damping `dy/dv` at the needle's depth; the paper's are
/// `μ = K p^(1-n)` and `λ = B p^-n`.
#[derive(Debug, Clone)]
pub struct HuntCrossley<L> {
    regression: Regression<L, 2>,
    power: L,
    power_gain: L,
    power_information: L,
    log_depth: L,
    dead_zone: L,
    local: [L; 2],
}

impl<L: Lane> HuntCrossley<L> {
    pub(super) fn new(settings: &RlsSettings) -> Self {
        let zero = L::zero();
        Self {
            regression: Regression::new(settings),
            power: L::splat(FIRST_POWER),
            power_gain: L::splat(1.0),
            power_information: zero,
            log_depth: zero,
            dead_zone: L::splat(settings.dead_zone_n),
            local: [zero; 2],
        }
    }
}

impl<L: Lane> BuiltIn for HuntCrossley<L> {
    const EXTRA_PARAMETER: Option<&'static str> = Some("power");

    fn build(settings: &RlsSettings) -> Self {
        Self::new(settings)
    }
}

impl<L: Lane> Estimator<L> for HuntCrossley<L> {
    #[inline(always)]
    fn update(&mut self, force_n: L, depth_m: L, velocity_m_per_s: L) -> Estimate<L> {
        let zero = L::zero();
        let contact = depth_m.gt(zero);
        let bounded = depth_m.clamp(L::splat(MIN_DEPTH_M), L::splat(MAX_DEPTH_M));
        let is_any = contact.any();
        // Before the branch on the error, which is often mispredicted.
        let log_depth = if is_any { each(bounded * L::splat(1.0 / REFERENCE_DEPTH_M), libm::log) } else { zero };
        let update = self.regression.update(force_n);
        self.update_power(force_n);
        let base = if is_any { L::splat(REFERENCE_DEPTH_M) * each(self.power * log_depth, libm::exp) } else { zero };
        self.log_depth = L::select(contact, log_depth, zero);
        let base = L::select(contact, base, zero);
        let velocity = velocity_m_per_s * L::splat(1.0 / REFERENCE_VELOCITY_M_PER_S);
        self.regression.set_regressor([base, L::select(contact, base * velocity, zero)]);

        let [kappa, rho] = self.regression.parameters();
        let secant = kappa * (base / bounded);
        let local_damping = rho * base * L::splat(1.0 / REFERENCE_VELOCITY_M_PER_S);
        self.local = [L::select(contact, secant, self.local[0]), L::select(contact, local_damping, self.local[1])];
        Estimate {
            predicted_force_n: update.predicted_force_n,
            residual_n: update.residual_n,
            correction: update.correction,
            stiffness_n_per_m: self.local[0],
            damping_n_s_per_m: self.local[1],
            extra_parameter: self.power,
        }
    }

    #[inline(always)]
    fn skip(&mut self) {
        self.regression.set_regressor([L::zero(); 2]);
        self.log_depth = L::zero();
    }
}

impl<L: Lane> HuntCrossley<L> {
    #[inline(always)]
    fn update_power(&mut self, force_n: L) {
        let one = L::splat(1.0);
        let [base, damped] = self.regression.regressor();
        let [kappa, rho] = self.regression.parameters();
        let predicted = base * kappa + damped * rho;
        let remaining = force_n - predicted;
        let slope = predicted * self.log_depth;
        let share = self.power_gain / (one + self.power_gain * (slope * slope));
        let outside = remaining.abs().gt(self.dead_zone);
        let power = self.power + share * (slope * remaining);
        let power = power.clamp(L::splat(MIN_POWER), L::splat(MAX_POWER));
        self.power = L::select(outside, power, self.power);
        let information = self.power_information + slope * slope;
        let restore = information.ge(L::splat(POWER_MEMORY_N2));
        self.power_gain = L::select(outside, L::select(restore, one, share), self.power_gain);
        let information = L::select(restore, L::zero(), information);
        self.power_information = L::select(outside, information, self.power_information);
    }
}

#[inline(always)]
fn each<L: Lane>(mut value: L, function: impl Fn(f64) -> f64) -> L {
    for lane in 0..L::WIDTH {
        value = value.with_lane(lane, function(value.lane(lane)));
    }
    value
}

crate::lane::gather!(HuntCrossley { regression, power, power_gain, power_information, log_depth, dead_zone, local } stored);
