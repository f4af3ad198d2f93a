//! The Hunt-Crossley model, estimated online in two stages.

use super::estimator::{BuiltIn, Estimate, Estimator};
use super::regression::Regression;
use super::settings::RlsSettings;
use crate::lane::{Lane, Mask};

/// Depth in m at which the power does not matter: `p̃ = p / p_r`. It makes `κ` and `n` nearly independent for needles
/// some centimetres deep, where in metres a change of n is a change of κ by decades. Chosen here.
const REFERENCE_DEPTH_M: f64 = 0.01;
/// Velocity in m/s that counts as much as the stiffness. Chosen here: at 0.01 m/s, which the lurch after a rupture
/// exceeds, the errors on the in-vivo-like recording spread several times as far.
const REFERENCE_VELOCITY_M_PER_S: f64 = 0.05;
/// Where the power begins and within what it stays. Tissue stiffens with depth; 1 makes the model a line.
const FIRST_POWER: f64 = 1.0;
const MIN_POWER: f64 = 0.5;
const MAX_POWER: f64 = 4.0;
/// Depths in m at which the logarithm is taken as that of the bound.
const MIN_DEPTH_M: f64 = 1e-6;
const MAX_DEPTH_M: f64 = 1.0;
/// Information in N², of the force's sensitivity to the power, after which the power's gain is restored.
const POWER_MEMORY_N2: f64 = 20.0;

/// `y = μ pⁿ + λ pⁿ v` in contact (eq. 2), as `y = p_r p̃ⁿ (κ + ρ v / v_r)`.
///
/// Two estimators pull each other up by their bootstraps, as Diolaiti et al. (2005) have it: the first takes `n` as known
/// and estimates `(κ, ρ)` linearly; the second takes these as known and estimates `n`, of which
///
/// ```text
/// ln(y / (p_r (κ + ρ v/v_r))) = n ln p̃
/// ```
/// is linear. A logarithm of a force is undefined from 0 down and counts a millinewton near the surface like a newton
/// below; so the second stage weighs by the force and takes the logarithm's first order, what is then
///
/// ```text
/// e⁺_k = y_k - φᵀθ_k = ŷ⁺ ln p̃ (n - n_{k-1}),      ŷ⁺ = φᵀθ_k
/// n_k = n_{k-1} + f b e⁺ / (1 + f b²),    b = ŷ⁺ ln p̃,    f_k = f_{k-1} / (1 + f_{k-1} b²)
/// ```
/// with `f = 1/N²` restored when `Σ b²` reaches 20 N², and errors within the dead zone left alone. It sees what the first stage has left over, so that no error is
/// corrected twice, and keeps within 0.5 and 4. The text of Diolaiti et al. was not at hand: that the method has two
/// stages is from the paper's introduction and the abstract of Haddadi and Hashtrudi-Zaad (2012, IEEE T-RO 28(3)), what is
/// in them is derived here, and its numbers are chosen here.
///
/// Stiffness and damping are reported where the needle is, `y / p` of a needle at rest and `dy/dv`, in N/m and N·s/m; the
/// paper's are `μ = K p^(1-n)` and `λ = B p^-n`.
///
/// `ln` and `exp` once a sample in contact are those of `libm`, a lane at a time: plain arithmetic without fused
/// operations, the same bits on every machine. The README says what they cost.
#[derive(Debug, Clone)]
pub struct HuntCrossley<L> {
    regression: Regression<L, 2>,
    power: L,
    power_gain: L,
    power_information: L,
    /// `ln p̃` of the regressor.
    log_depth: L,
    /// Smaller errors than this teach nothing, as in the first stage.
    dead_zone: L,
    /// Stiffness and damping where the needle last was.
    seen: [L; 2],
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
            seen: [zero; 2],
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
        let lesson = self.regression.judge(force_n);
        self.learn_power(force_n);

        let contact = depth_m.gt(zero);
        let bounded = depth_m.clamp(L::splat(MIN_DEPTH_M), L::splat(MAX_DEPTH_M));
        let (mut base, mut log_depth) = (zero, zero);
        if contact.any() {
            log_depth = each(bounded * L::splat(1.0 / REFERENCE_DEPTH_M), libm::log);
            base = L::splat(REFERENCE_DEPTH_M) * each(self.power * log_depth, libm::exp);
        }
        self.log_depth = L::select(contact, log_depth, zero);
        let base = L::select(contact, base, zero);
        let velocity = velocity_m_per_s * L::splat(1.0 / REFERENCE_VELOCITY_M_PER_S);
        self.regression.expect([base, L::select(contact, base * velocity, zero)]);

        let [kappa, rho] = self.regression.parameters();
        let secant = kappa * (base / bounded);
        let local_damping = rho * base * L::splat(1.0 / REFERENCE_VELOCITY_M_PER_S);
        self.seen = [L::select(contact, secant, self.seen[0]), L::select(contact, local_damping, self.seen[1])];
        Estimate {
            predicted_force_n: lesson.predicted_force_n,
            residual_n: lesson.residual_n,
            correction: lesson.correction,
            stiffness_n_per_m: self.seen[0],
            damping_n_s_per_m: self.seen[1],
            extra_parameter: self.power,
        }
    }

    #[inline(always)]
    fn skip(&mut self) {
        self.regression.expect([L::zero(); 2]);
        self.log_depth = L::zero();
    }
}

impl<L: Lane> HuntCrossley<L> {
    /// The second stage.
    #[inline(always)]
    fn learn_power(&mut self, force_n: L) {
        let one = L::splat(1.0);
        let [base, damped] = self.regression.regressor();
        let [kappa, rho] = self.regression.parameters();
        let expected = base * kappa + damped * rho;
        let left_over = force_n - expected;
        let slope = expected * self.log_depth;
        let share = self.power_gain / (one + self.power_gain * (slope * slope));
        let outside = left_over.abs().gt(self.dead_zone);
        let power = self.power + share * (slope * left_over);
        let power = power.clamp(L::splat(MIN_POWER), L::splat(MAX_POWER));
        self.power = L::select(outside, power, self.power);
        let information = self.power_information + slope * slope;
        let restore = information.ge(L::splat(POWER_MEMORY_N2));
        self.power_gain = L::select(outside, L::select(restore, one, share), self.power_gain);
        let information = L::select(restore, L::zero(), information);
        self.power_information = L::select(outside, information, self.power_information);
    }
}

/// A scalar function of each lane, out of line.
#[inline(never)]
fn each<L: Lane>(mut value: L, function: fn(f64) -> f64) -> L {
    for lane in 0..L::WIDTH {
        value = value.with_lane(lane, function(value.lane(lane)));
    }
    value
}

crate::lane::gather!(HuntCrossley { regression, power, power_gain, power_information, log_depth, dead_zone, seen });
