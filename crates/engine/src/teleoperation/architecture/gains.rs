//! The gains of the linear control law of every built-in architecture.
//!
//! After Lawrence (1993, *Stability and transparency in bilateral teleoperation*), for sides that keep their local
//! controllers (eq. 29 and 31). At each tick
//!
//! ```text
//! F_ed  = k_f F_e - k_h F_h + k_x (P x_h - x_e) + k_v (P v_h - v_e) - k_b v_e - k_a a_e
//! x_ref = P x_h + g_v v_h + g_a a_h + g_h F_h - g_e f_e
//! ```
//! with `F_e` the measured force scaled to the master, `f_e` unscaled, and `P` the position scale. Signals of the other
//! side are the received ones.

/// The gains of the master's law; see the module.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MasterGains {
    /// `k_f`, on the measured force.
    pub force: f64,
    /// `k_h`, on the hand's force.
    pub hand: f64,
    /// `k_x` in N/m, on the position difference.
    pub position: f64,
    /// `k_v` in N·s/m, on the velocity difference.
    pub velocity: f64,
    /// `k_b` in N·s/m, on the slave's velocity.
    pub drag: f64,
    /// `k_a` in kg, on the slave's acceleration.
    pub inertia: f64,
}

/// The gains of the slave's law; see the module.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SlaveGains {
    /// `g_v` in s, on the master's velocity.
    pub velocity: f64,
    /// `g_a` in s², on the master's acceleration.
    pub acceleration: f64,
    /// `g_h` in m/N, on the hand's force.
    pub hand_force: f64,
    /// `g_e` in m/N, on the slave's measured force.
    pub local_force: f64,
}
