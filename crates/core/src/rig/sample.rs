use super::DetectionState;
use crate::augmentation::Mode;
use crate::safety::{FaultCause, Limited, SafetyState};

/// A rig's measurements.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// `x_h`.
    pub master_position_m: f64,
    /// `x_e`, increasing into the tissue.
    pub slave_position_m: f64,
    /// `v_e`; ignored with [`VelocitySource::Filtered`](super::VelocitySource).
    pub slave_velocity_m_per_s: f64,
    /// `y`, positive when the tissue resists insertion.
    pub force_n: f64,
}

impl Sample {
    /// Every channel counts as bad.
    pub const MISSING: Self = Self {
        master_position_m: f64::NAN,
        slave_position_m: f64::NAN,
        slave_velocity_m_per_s: f64::NAN,
        force_n: f64::NAN,
    };
}

/// Channels with an impossible value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Faults {
    /// Of the master.
    pub master_position: bool,
    /// Of the slave.
    pub slave_position: bool,
    /// Only if it is used.
    pub slave_velocity: bool,
    /// Of the needle.
    pub force: bool,
}

impl Faults {
    /// True if any channel is faulty.
    #[inline(always)]
    #[must_use]
    pub fn any(self) -> bool {
        self.master_position | self.slave_position | self.slave_velocity | self.force
    }

    /// 1: master's position, 2: slave's position, 4: its velocity, 8: force; summed.
    #[must_use]
    pub fn bits(self) -> u32 {
        let flags = [self.master_position, self.slave_position, self.slave_velocity, self.force];
        flags.into_iter().rev().fold(0, |bits, flag| bits << 1 | u32::from(flag))
    }

    /// True if the detection lacks a channel.
    #[inline(always)]
    #[must_use]
    pub fn of_slave(self) -> bool {
        self.slave_position | self.slave_velocity | self.force
    }
}

/// Commands at one tick, and the values behind them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Command {
    /// `x_ref` for the slave's position controller.
    pub slave_reference_m: f64,
    /// `F_ed` for the master's force controller.
    pub master_force_n: f64,
    /// Largest allowed change of `F_ed` since the last tick.
    pub allowed_force_step_n: f64,
    /// Mode of the supervisor.
    pub mode: Mode,
    /// True if this sample raises an alarm.
    pub alarm: bool,
    /// True if an alarm began an event; without augmentation, at each alarm.
    pub alarm_taken: bool,
    /// `K`.
    pub stiffness_n_per_m: f64,
    /// `B`.
    pub damping_n_s_per_m: f64,
    /// `ŷ`; 0 without a prediction.
    pub predicted_force_n: f64,
    /// `e = y - ŷ`; 0 at a bad sample and at the next one.
    pub residual_n: f64,
    /// `s`.
    pub distance: f64,
    /// `g`.
    pub decision: f64,
    /// `v_e` used by the estimator.
    pub slave_velocity_m_per_s: f64,
    /// Faults of the sample.
    pub faults: Faults,
    /// Consecutive bad samples, this one included.
    pub faulty_samples: u32,
    /// State of the detection.
    pub detection: DetectionState,
    /// Ticks since `detection` began.
    pub detection_ticks: u32,
    /// State of the commands.
    pub state: SafetyState,
    /// Cause of the last fault since [`HapticController::enable`](super::HapticController).
    pub fault: Option<FaultCause>,
    /// Safety limits that acted.
    pub limited: Limited,
}
