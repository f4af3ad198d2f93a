//! What goes into a step and what comes out.

use crate::augmentation::Mode;

/// What a rig has measured at a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// `x_h` in m.
    pub master_position_m: f64,
    /// `x_e` in m, growing into the tissue.
    pub slave_position_m: f64,
    /// `v_e` in m/s; not read with [`VelocitySource::Filtered`](super::VelocitySource).
    pub slave_velocity_m_per_s: f64,
    /// `y` in N, positive when it resists insertion.
    pub force_n: f64,
}

impl Sample {
    /// The sample of a tick at which nothing was measured: all of it counts as bad.
    pub const MISSING: Self = Self {
        master_position_m: f64::NAN,
        slave_position_m: f64::NAN,
        slave_velocity_m_per_s: f64::NAN,
        force_n: f64::NAN,
    };
}

/// Which numbers of a sample could not be true.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Faults {
    /// The master's position.
    pub master_position: bool,
    /// The slave's position.
    pub slave_position: bool,
    /// The slave's velocity, where it is read.
    pub slave_velocity: bool,
    /// The force.
    pub force: bool,
}

impl Faults {
    /// Whether there is one.
    #[inline(always)]
    #[must_use]
    pub fn any(self) -> bool {
        self.master_position | self.slave_position | self.slave_velocity | self.force
    }
}

/// What a rig is to do at a tick, and why.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Command {
    /// `x_ref` for the slave's position controller, in m.
    pub slave_reference_m: f64,
    /// `F_ed` for the master's force controller, in N.
    pub master_force_n: f64,
    /// The most by which the law in force lets `F_ed` differ from the last tick's, in N.
    pub allowed_force_step_n: f64,
    /// What the supervisor is doing.
    pub mode: Mode,
    /// Whether a rupture is announced at this sample.
    pub alarm: bool,
    /// Whether the supervisor acts on it (with augmentation disabled: whether there is one).
    pub alarm_taken: bool,
    /// `K` in N/m.
    pub stiffness_n_per_m: f64,
    /// `B` in N·s/m.
    pub damping_n_s_per_m: f64,
    /// `ŷ` in N; 0 where there is no prediction.
    pub predicted_force_n: f64,
    /// `e = y - ŷ` in N; 0 at a bad sample and at the one after.
    pub residual_n: f64,
    /// `s`, in the unit of the distance.
    pub distance: f64,
    /// `g`, in the unit of the distance.
    pub decision: f64,
    /// `v_e` as the estimator took it, in m/s.
    pub slave_velocity_m_per_s: f64,
    /// What was wrong with the sample.
    pub faults: Faults,
    /// How many bad samples on end this one makes; 0 where it is good.
    pub faulty_samples: u32,
}
