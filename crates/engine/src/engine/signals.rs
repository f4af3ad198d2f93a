use super::{MasterOutput, SlaveOutput, TissueForce};
use crate::teleoperation::AtSlave;
use crate::tissue::Reaction;
use trocar_core::augmentation::{Mode, Modes, SlaveCommand};
use trocar_core::chain::ChainOutput;
use trocar_core::detector::Decision;
use trocar_core::estimation::Estimate;
use trocar_core::lane::{Lane, Mask};

#[derive(Debug, Clone, Copy)]
pub struct Signals<L: Lane> {
    pub tick: u64,
    /// `x_d`.
    pub desired_position_m: L,
    /// `x_v`, less the travel under a clutch.
    pub intended_position_m: L,
    /// `x_h`.
    pub master_position_m: L,
    /// `v_h`.
    pub master_velocity_m_per_s: L,
    /// `F_h`.
    pub operator_force_n: L,
    /// `x_ref`.
    pub slave_reference_m: L,
    /// `x_e`.
    pub slave_position_m: L,
    /// `v_e`.
    pub slave_velocity_m_per_s: L,
    /// `f_e`.
    pub tissue_force_n: L,
    /// `y`.
    pub measured_force_n: L,
    /// `F_ed` at the master.
    pub feedback_force_n: L,
    /// `K`.
    pub stiffness_n_per_m: L,
    /// `B`.
    pub damping_n_s_per_m: L,
    pub extra_parameter: L,
    /// `e`.
    pub residual_n: L,
    /// `s`.
    pub distance: L,
    /// `g`, in the unit of the distance.
    pub decision: L,
    pub mode: Modes<L>,
    /// Ground truth.
    pub ruptured: L::Mask,
    pub noticed: L::Mask,
    pub alarm: L::Mask,
    /// Alarms on which the supervisor acts; all without augmentation.
    pub alarm_taken: L::Mask,
    /// The supervisor's command, before the channel.
    pub commanded_force_n: L,
    pub allowed_force_step_n: L,
}

#[derive(Debug, Clone, Copy)]
pub struct SelectedSignals<L: Lane> {
    pub tick: u64,
    pub intended_position_m: L,
    pub slave_position_m: L,
    pub residual_n: L,
    pub decision: L,
    pub mode: Modes<L>,
    pub ruptured: L::Mask,
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

#[derive(Debug, Clone, Copy)]
pub(super) struct Desired<L: Lane> {
    pub(super) position_m: L,
    pub(super) intended_m: L,
    pub(super) is_noticed: L::Mask,
}

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

    #[inline(always)]
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
