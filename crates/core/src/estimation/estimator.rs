use super::settings::RlsSettings;
use crate::lane::Lane;

/// The estimate after one sample.
#[derive(Debug, Clone, Copy)]
pub struct Estimate<L> {
    /// `ŷ_k = φ_{k-1}ᵀ θ_{k-1}` (eq. 6).
    pub predicted_force_n: L,
    /// `e_k = y_k - ŷ_k` (eq. 7).
    pub residual_n: L,
    /// `H_k`: change of stiffness (N/m) and damping (N·s/m) (eq. 25).
    pub correction: [L; 2],
    /// `K_k`.
    pub stiffness_n_per_m: L,
    /// `B_k`.
    pub damping_n_s_per_m: L,
    /// The parameter of [`RlsSettings::extra_parameter_column`]; 0 without one.
    pub extra_parameter: L,
}

/// User-defined estimators implement it for `f64`.
pub trait Estimator<L: Lane> {
    /// Processes `y`, the depth `p` below the contact (negative outside) and `v` (eq. 6-7).
    fn update(&mut self, force_n: L, depth_m: L, velocity_m_per_s: L) -> Estimate<L>;

    /// Marks a gap: the next sample has no prediction.
    fn skip(&mut self);
}

#[cfg(feature = "alloc")]
impl<L: Lane, E: Estimator<L> + ?Sized> Estimator<L> for alloc::boxed::Box<E> {
    fn update(&mut self, force_n: L, depth_m: L, velocity_m_per_s: L) -> Estimate<L> {
        (**self).update(force_n, depth_m, velocity_m_per_s)
    }

    fn skip(&mut self) {
        (**self).skip();
    }
}

pub(super) trait BuiltIn {
    /// The paper's estimator, which a rig runs.
    const IS_BASELINE: bool = false;
    const EXTRA_PARAMETER: Option<&'static str> = None;

    fn build(settings: &RlsSettings) -> Self;
}
