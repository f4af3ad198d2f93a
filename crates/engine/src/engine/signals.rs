//! The signals of a tick, for its observers.

use super::{MasterOutput, SlaveOutput, TissueForce};
use crate::teleoperation::AtSlave;
use crate::tissue::Reaction;
use trocar_core::augmentation::{Mode, Modes, SlaveCommand};
use trocar_core::chain::ChainOutput;
use trocar_core::detector::Decision;
use trocar_core::estimation::Estimate;
use trocar_core::lane::{Lane, Mask};

/// All signals of one tick.
#[derive(Debug, Clone, Copy)]
pub struct Signals<L: Lane> {
    /// The tick's number `k`; its time is `k * tick_s`.
    pub tick: u64,
    /// `x_d` in m.
    pub desired_position_m: L,
    /// Position of the master that the operator intends, `x_v` in m, less the travel under a clutch.
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
    /// Feedback force `F_ed` at the master, in N.
    pub feedback_force_n: L,
    /// `K` in N/m.
    pub stiffness_n_per_m: L,
    /// `B` in N·s/m.
    pub damping_n_s_per_m: L,
    /// The estimator's extra parameter, in the unit of its column; 0 without one.
    pub extra_parameter: L,
    /// `e` in N.
    pub residual_n: L,
    /// Distance `s`, in its unit.
    pub distance: L,
    /// Decision function `g`, in the unit of the distance.
    pub decision: L,
    /// The mode of the supervisor.
    pub mode: Modes<L>,
    /// Lanes in which a layer ruptures at this tick (ground truth).
    pub ruptured: L::Mask,
    /// Lanes in which the operator notices a change of the felt force at this tick.
    pub noticed: L::Mask,
    /// Lanes in which the detector raises an alarm at this tick.
    pub alarm: L::Mask,
    /// Lanes in which the supervisor acts on an alarm; with augmentation disabled, lanes with an alarm.
    pub alarm_taken: L::Mask,
    /// Feedback force `F_ed` commanded by the supervisor, before the channel, in N.
    pub commanded_force_n: L,
    /// Largest change of the commanded force from the last tick that the active law allows, in N.
    pub allowed_force_step_n: L,
}

/// A few of the [`Signals`] of a tick, because each one stays live throughout the tick.
#[derive(Debug, Clone, Copy)]
pub struct SelectedSignals<L: Lane> {
    /// The tick's number.
    pub tick: u64,
    /// Position of the master that the operator intends, in m.
    pub intended_position_m: L,
    /// `x_e` in m.
    pub slave_position_m: L,
    /// `e` in N.
    pub residual_n: L,
    /// Decision function `g`, in the unit of the distance.
    pub decision: L,
    /// The mode of the supervisor.
    pub mode: Modes<L>,
    /// Lanes in which a layer ruptures at this tick.
    pub ruptured: L::Mask,
    /// Lanes in which the detector raises an alarm at this tick.
    pub alarm: L::Mask,
}

impl<L: Lane> SelectedSignals<L> {
    #[inline(always)]
    pub(crate) fn of(s: &Signals<L>) -> Self {
        Self {
            tick: s.tick,
            intended_position_m: s.intended_position_m,
            slave_position_m: s.slave_position_m,
            residual_n: s.residual_n,
            decision: s.decision,
            mode: s.mode,
            ruptured: s.ruptured,
            alarm: s.alarm,
        }
    }
}

/// Positions of the operator at a tick in m; true if a change of the felt force is noticed.
#[derive(Debug, Clone, Copy)]
pub(super) struct Desired<L: Lane> {
    pub(super) position_m: L,
    pub(super) intended_m: L,
    pub(super) is_noticed: L::Mask,
}

/// The feedback force at a tick in N: commanded by the force law, its allowed change, and limited by the link.
#[derive(Debug, Clone, Copy)]
pub(super) struct FedBack<L> {
    pub(super) commanded_n: L,
    pub(super) allowed_step_n: L,
    pub(super) force_n: L,
}

#[derive(Debug, Clone, Copy)]
pub(super) struct SlaveMeasurement<L: Lane> {
    pub(super) reaction: Reaction<L>,
    pub(super) output: ChainOutput<L>,
    pub(super) at_slave: AtSlave<L>,
}

impl<L: Lane> SlaveMeasurement<L> {
    #[inline(always)]
    pub(super) fn tissue_force(&self) -> TissueForce<L> {
        TissueForce { on_needle_n: self.reaction.force_n, measured_n: self.at_slave.force_n }
    }
}

pub(super) type AtMasterSide<L> = (Desired<L>, MasterOutput<L>, FedBack<L>);
pub(super) type AtSlaveSide<L> = (SlaveOutput<L>, SlaveMeasurement<L>, SlaveCommand<L>);

/// Both sides with zeros everywhere, for a side whose values are unknown.
pub(super) fn at_rest() -> (AtMasterSide<f64>, AtSlaveSide<f64>) {
    let desired = Desired { position_m: 0.0, intended_m: 0.0, is_noticed: false };
    let master = MasterOutput { position_m: 0.0, velocity_m_per_s: 0.0, hand_force_n: 0.0 };
    let fed_back = FedBack { commanded_n: 0.0, allowed_step_n: 0.0, force_n: 0.0 };
    let estimate = Estimate {
        predicted_force_n: 0.0,
        residual_n: 0.0,
        correction: [0.0; 2],
        stiffness_n_per_m: 0.0,
        damping_n_s_per_m: 0.0,
        extra_parameter: 0.0,
    };
    let measured = SlaveMeasurement {
        reaction: Reaction { force_n: 0.0, ruptured: false },
        output: ChainOutput {
            depth_m: 0.0,
            estimate,
            decision: Decision { distance: 0.0, decision: 0.0, alarm: false },
        },
        at_slave: AtSlave { position_m: 0.0, velocity_m_per_s: 0.0, force_n: 0.0 },
    };
    let command = SlaveCommand { mode: Modes::splat(Mode::Teleoperation), slave_reference_m: 0.0, alarm_taken: false };
    let slave = SlaveOutput { position_m: 0.0, velocity_m_per_s: 0.0 };
    ((desired, master, fed_back), (slave, measured, command))
}

impl<L: Lane> Signals<L> {
    #[inline(always)]
    pub(super) fn of_both(
        tick: u64,
        (desired, master, fed_back): &AtMasterSide<L>,
        (slave, measured, command): &AtSlaveSide<L>,
    ) -> Self {
        let SlaveMeasurement { reaction, output, at_slave } = measured;
        Self {
            tick,
            desired_position_m: desired.position_m,
            intended_position_m: desired.intended_m,
            master_position_m: master.position_m,
            master_velocity_m_per_s: master.velocity_m_per_s,
            operator_force_n: master.hand_force_n,
            slave_reference_m: command.slave_reference_m,
            slave_position_m: slave.position_m,
            slave_velocity_m_per_s: slave.velocity_m_per_s,
            tissue_force_n: reaction.force_n,
            measured_force_n: at_slave.force_n,
            feedback_force_n: fed_back.force_n,
            stiffness_n_per_m: output.estimate.stiffness_n_per_m,
            damping_n_s_per_m: output.estimate.damping_n_s_per_m,
            extra_parameter: output.estimate.extra_parameter,
            residual_n: output.estimate.residual_n,
            distance: output.decision.distance,
            decision: output.decision.decision,
            mode: command.mode,
            ruptured: reaction.ruptured,
            noticed: desired.is_noticed,
            alarm: output.decision.alarm,
            alarm_taken: command.alarm_taken,
            commanded_force_n: fed_back.commanded_n,
            allowed_force_step_n: fed_back.allowed_step_n,
        }
    }

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
            mode: Modes::splat(self.mode.lane(index)),
            ruptured: self.ruptured.lane(index),
            noticed: self.noticed.lane(index),
            alarm: self.alarm.lane(index),
            alarm_taken: self.alarm_taken.lane(index),
            commanded_force_n: self.commanded_force_n.lane(index),
            allowed_force_step_n: self.allowed_force_step_n.lane(index),
        }
    }
}
