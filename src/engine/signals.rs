//! What a tick shows to its observers.

use crate::lane::Lane;

/// Every signal of one tick.
#[derive(Debug, Clone, Copy)]
pub struct Signals<L: Lane> {
    /// The tick's number; its time is `k * tick_s`.
    pub tick: u64,
    /// `x_d` in m.
    pub desired_position_m: L,
    /// `x_h` in m.
    pub master_position_m: L,
    /// `v_h` in m/s.
    pub master_velocity_m_per_s: L,
    /// `F_h` in N.
    pub operator_force_n: L,
    /// `x_ref` in m.
    pub slave_reference_m: L,
    /// `x_e` in m.
    pub slave_position_m: L,
    /// `v_e` in m/s.
    pub slave_velocity_m_per_s: L,
    /// `f_e` in N.
    pub tissue_force_n: L,
    /// `y` in N.
    pub measured_force_n: L,
    /// `F_ed` as it arrives at the master, in N.
    pub feedback_force_n: L,
    /// `K` in N/m.
    pub stiffness_n_per_m: L,
    /// `B` in N·s/m.
    pub damping_n_s_per_m: L,
    /// `e` in N.
    pub residual_n: L,
    /// `s`, in the unit of the distance.
    pub distance: L,
    /// `g`, in the unit of the distance.
    pub decision: L,
    /// 0 teleoperation, 1 augmented, 2 reengaging.
    pub mode: L,
    /// Whether a layer ruptures at this tick: the truth.
    pub ruptured: L::Mask,
    /// Whether the detector announces a rupture at this tick.
    pub alarm: L::Mask,
    /// `F_ed` as the supervisor commands it, before the channel, in N.
    pub commanded_force_n: L,
    /// By how much the law in force lets it differ from the last tick's, in N.
    pub allowed_force_step_n: L,
}
