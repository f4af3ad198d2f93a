//! After Lawrence (1993), with local controllers (eq. 29 and 31):
//!
//! ```text
//! F_ed  = k_f F_e - k_h F_h + k_x (P x_h - x_e) + k_v (P v_h - v_e) - k_b v_e - k_a a_e
//! x_ref = P x_h + g_v v_h + g_a a_h + g_h F_h - g_e f_e
//! ```
//! with `F_e` the measured force scaled to the master, `f_e` unscaled, and `P` the position scale.

#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MasterGains {
    /// `k_f`.
    pub force: f64,
    /// `k_h`.
    pub hand: f64,
    /// `k_x` in N/m.
    pub position: f64,
    /// `k_v` in N·s/m.
    pub velocity: f64,
    /// `k_b` in N·s/m.
    pub drag: f64,
    /// `k_a` in kg.
    pub inertia: f64,
}

#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SlaveGains {
    /// `g_v` in s.
    pub velocity: f64,
    /// `g_a` in s².
    pub acceleration: f64,
    /// `g_h` in m/N.
    pub hand_force: f64,
    /// `g_e` in m/N.
    pub local_force: f64,
}
