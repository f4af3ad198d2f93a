//! The role of the estimator.
//!
//! A built-in estimator is one file of this folder, one line in `any.rs`, and one word of [`Parameters`] where what it
//! estimates is new.

use super::settings::RlsSettings;
use crate::lane::Lane;

/// What one sample said.
#[derive(Debug, Clone, Copy)]
pub struct Estimate<L> {
    /// `ŷ_k = φ_{k-1}ᵀ θ_{k-1}` in N (eq. 6).
    pub predicted_force_n: L,
    /// `e_k = y_k - ŷ_k` in N (eq. 7).
    pub residual_n: L,
    /// `H_k`, the change of stiffness (N/m) and damping (N·s/m) that the sample caused (eq. 25).
    pub correction: [L; 2],
    /// `K_k` in N/m.
    pub stiffness_n_per_m: L,
    /// `B_k` in N·s/m.
    pub damping_n_s_per_m: L,
    /// What [`RlsSettings::extra_parameter_column`] names, in its unit; 0 where it names nothing.
    pub extra_parameter: L,
}

/// Learns the tissue from samples, one at a time.
///
/// An estimator of one's own implements this for `f64`; the built-in ones do for any number of lanes.
pub trait Estimator<L: Lane> {
    /// Takes the sample: force `y` (N), depth `p` below the contact (m, negative outside), velocity `v` (m/s).
    ///
    /// The residual of the estimate is that of the prediction that was made before the sample (eq. 6-7).
    fn update(&mut self, force_n: L, depth_m: L, velocity_m_per_s: L) -> Estimate<L>;

    /// Takes note that samples are missing: the next one has no prediction to be compared with.
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

/// What a built-in estimator says of itself.
pub(super) trait BuiltIn {
    /// Whether it is the paper's, which a rig runs.
    const IS_BASELINE: bool = false;
    /// What it estimates besides stiffness and damping, as a column's name with its unit.
    const EXTRA_PARAMETER: Option<&'static str> = None;

    /// The estimator of the settings, without any sample.
    fn build(settings: &RlsSettings) -> Self;
}
