//! The signals of a tick, for its observers.

use crate::lane::{Lane, Mask};

/// Every signal of one tick.
#[derive(Debug, Clone, Copy)]
pub struct Signals<L: Lane> {
    /// The tick's number; its time is `k * tick_s`.
    pub tick: u64,
    /// `x_d` in m.
    pub desired_position_m: L,
    /// `x_v` in m: the position of the master that the operator means to reach.
    pub intended_position_m: L,
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
    /// The estimator's extra parameter, in the unit of its column; 0 without one.
    pub extra_parameter: L,
    /// `e` in N.
    pub residual_n: L,
    /// `s`, in the unit of the distance.
    pub distance: L,
    /// `g`, in the unit of the distance.
    pub decision: L,
    /// 0 teleoperation, 1 augmented, 2 re-engaging.
    pub mode: L,
    /// Whether a layer ruptures at this tick: ground truth.
    pub ruptured: L::Mask,
    /// Whether the operator notices a change of the felt force at this tick.
    pub noticed: L::Mask,
    /// Whether the detector raises an alarm at this tick.
    pub alarm: L::Mask,
    /// Whether the supervisor acts on the alarm (with augmentation disabled: whether there is one).
    pub alarm_taken: L::Mask,
    /// `F_ed` as the supervisor commands it, before the channel, in N.
    pub commanded_force_n: L,
    /// Largest change of the commanded force from the last tick that the active law allows, in N.
    pub allowed_force_step_n: L,
}

impl<L: Lane> Signals<L> {
    /// The signals of lane `index` alone.
    #[inline(always)]
    #[must_use]
    pub fn lane(&self, index: usize) -> Signals<f64> {
        Signals {
            tick: self.tick,
            desired_position_m: self.desired_position_m.lane(index),
            intended_position_m: self.intended_position_m.lane(index),
            master_position_m: self.master_position_m.lane(index),
            master_velocity_m_per_s: self.master_velocity_m_per_s.lane(index),
            operator_force_n: self.operator_force_n.lane(index),
            slave_reference_m: self.slave_reference_m.lane(index),
            slave_position_m: self.slave_position_m.lane(index),
            slave_velocity_m_per_s: self.slave_velocity_m_per_s.lane(index),
            tissue_force_n: self.tissue_force_n.lane(index),
            measured_force_n: self.measured_force_n.lane(index),
            feedback_force_n: self.feedback_force_n.lane(index),
            stiffness_n_per_m: self.stiffness_n_per_m.lane(index),
            damping_n_s_per_m: self.damping_n_s_per_m.lane(index),
            extra_parameter: self.extra_parameter.lane(index),
            residual_n: self.residual_n.lane(index),
            distance: self.distance.lane(index),
            decision: self.decision.lane(index),
            mode: self.mode.lane(index),
            ruptured: self.ruptured.lane(index),
            noticed: self.noticed.lane(index),
            alarm: self.alarm.lane(index),
            alarm_taken: self.alarm_taken.lane(index),
            commanded_force_n: self.commanded_force_n.lane(index),
            allowed_force_step_n: self.allowed_force_step_n.lane(index),
        }
    }
}
