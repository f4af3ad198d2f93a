use std::ops::ControlFlow;

use super::signals::{Desired, FedBack, SlaveMeasurement};
use super::{EngineError, MasterOutput, Observer, Plants, Signals, SlaveOutput};
use crate::operator::Operator;
use crate::sensor::{NoiseBank, Sensor};
use crate::teleoperation::{AtMaster, AtSlave, Connection, LinkReport, MasterReading};
use crate::tissue::Tissue;
use trocar_core::augmentation::{
    AnyForceLaw, ForceLaw, HeldReference, Modes, MotionLaw, SlaveCommand, Supervisor, SupervisorInput,
};
use trocar_core::chain::Chain;
use trocar_core::detector::Detector;
use trocar_core::estimation::Estimator;
use trocar_core::lane::{Gather, LANES, Lane, of_each};
use trocar_core::safety::CommandLimits;

pub trait Wiring {
    type Lane: Lane;

    fn begin(&mut self) -> Self::Lane;

    fn tick<P: Plants<Self::Lane>, O: Observer<Self::Lane>>(
        &mut self,
        tick: u64,
        desired_m: Self::Lane,
        plants: &mut P,
        observer: &mut O,
    ) -> ControlFlow<Result<(), EngineError>, Self::Lane>;

    fn link_report(&self, index: usize) -> Option<LinkReport>;

    fn share_noise(&mut self, bank: &mut NoiseBank, ticks: u64);
}

#[derive(Debug, Clone)]
pub struct Parts<L: Lane, O, T, S, E, D, K, M = HeldReference<L>, F = AnyForceLaw<L>> {
    pub operator: O,
    pub tissue: T,
    pub sensor: S,
    pub chain: Chain<L, E, D>,
    pub supervisor: Supervisor<L, M, F>,
    pub link: K,
    pub safety: Option<CommandLimits<L>>,
    pub master_reading: Option<MasterReading<L>>,
}

/// Each side reads only its own values, so that it can run as [`MasterSide`](super::MasterSide) or
/// [`SlaveSide`](super::SlaveSide).
impl<L, O, T, S, E, D, K, M, F> Parts<L, O, T, S, E, D, K, M, F>
where
    L: Lane,
    O: Operator<L>,
    T: Tissue<L>,
    S: Sensor<L>,
    E: Estimator<L>,
    D: Detector<L>,
    K: Connection<L>,
    M: MotionLaw<L>,
    F: ForceLaw<L>,
{
    #[inline(always)]
    pub(super) fn read_master(&mut self, tick: u64, master: &MasterOutput<L>) -> AtMaster<L> {
        let MasterOutput { position_m, velocity_m_per_s, hand_force_n } = *master;
        let exact = AtMaster { position_m, velocity_m_per_s, hand_force_n };
        match &mut self.master_reading {
            Some(reading) => reading.read(tick, exact),
            None => exact,
        }
    }

    #[inline(always)]
    pub(super) fn sense(&mut self, tick: u64, slave: &SlaveOutput<L>) -> SlaveMeasurement<L> {
        let reaction = self.tissue.react(tick, slave.position_m, slave.velocity_m_per_s);
        let sensed_n = if self.sensor.excludes_shaft() {
            reaction.force_n - self.tissue.shaft_force_n()
        } else {
            reaction.force_n
        };
        let measurement = self.sensor.read(sensed_n, slave.position_m, slave.velocity_m_per_s);
        let output = self.chain.step(&measurement);
        let at_slave = AtSlave {
            position_m: measurement.position_m,
            velocity_m_per_s: measurement.velocity_m_per_s,
            force_n: measurement.force_n,
        };
        SlaveMeasurement { reaction, output, at_slave }
    }

    #[inline(always)]
    pub(super) fn command_slave(&mut self, tick: u64, hand_m: L, measured: &SlaveMeasurement<L>) -> SlaveCommand<L> {
        let SlaveMeasurement { output, at_slave, .. } = measured;
        let command = self.supervisor.decide(&SupervisorInput {
            tick,
            alarm: output.decision.alarm,
            decision: output.decision.decision,
            hand_m,
            slave_m: at_slave.position_m,
            force_n: at_slave.force_n,
        });
        let reference_m = self.link.limit_reference(command.slave_reference_m, at_slave);
        let slave_reference_m = match &mut self.safety {
            Some(limits) => limits.reference_m(reference_m, at_slave.position_m),
            None => reference_m,
        };
        SlaveCommand { slave_reference_m, ..command }
    }

    #[inline(always)]
    pub(super) fn feed_back(&mut self, mode: Modes<L>, force_n: L, at_master: &AtMaster<L>) -> FedBack<L> {
        let (commanded_n, allowed_step_n) = self.supervisor.feedback_force(mode, force_n, at_master.velocity_m_per_s);
        let limited_n = self.link.limit(commanded_n, at_master);
        let is_free = self.master_reading.as_ref().is_some_and(MasterReading::is_open);
        let force_n = if is_free { L::zero() } else { limited_n };
        let force_n = match &mut self.safety {
            Some(limits) => limits.force_n(force_n),
            None => force_n,
        };
        FedBack { commanded_n, allowed_step_n, force_n }
    }

    #[inline(always)]
    pub(super) fn desired(&self, desired_m: L) -> Desired<L> {
        let intended_m = self.operator.intended_position_m(desired_m);
        Desired {
            position_m: desired_m,
            intended_m: self.master_reading.as_ref().map_or(intended_m, |reading| reading.intended_m(intended_m)),
            is_noticed: self.operator.notices(),
        }
    }

    #[inline(always)]
    pub(super) fn next_desired_m(&mut self, tick: u64, arrived_mode: Modes<L>, master: &MasterOutput<L>) -> L {
        self.operator.cue(self.supervisor.cue(arrived_mode));
        self.operator.master(master.position_m);
        self.operator.desired_position_m(tick + 1, master.hand_force_n)
    }
}

impl<L, O, T, S, E, D, K, M, F> Wiring for Parts<L, O, T, S, E, D, K, M, F>
where
    L: Lane,
    O: Operator<L>,
    T: Tissue<L>,
    S: Sensor<L>,
    E: Estimator<L>,
    D: Detector<L>,
    K: Connection<L>,
    M: MotionLaw<L>,
    F: ForceLaw<L>,
{
    type Lane = L;

    #[inline(always)]
    fn begin(&mut self) -> L {
        self.operator.desired_position_m(0, L::zero())
    }

    #[inline(always)]
    fn tick<P: Plants<L>, Ob: Observer<L>>(
        &mut self,
        tick: u64,
        desired_m: L,
        plants: &mut P,
        observer: &mut Ob,
    ) -> ControlFlow<Result<(), EngineError>, L> {
        // Step 1 of the module's list.
        let (master, slave) = (plants.master(), plants.slave());
        let at_master = self.read_master(tick, &master);
        // Steps 2 to 4.
        let measured = self.sense(tick, &slave);
        // Step 5.
        let hand_m = self.link.to_slave(&at_master, &measured.at_slave);
        let command = self.command_slave(tick, hand_m, &measured);
        // Step 6.
        let (arrived_mode, arrived_force_n) = self.link.to_master(command.mode, &measured.at_slave, &at_master);
        let fed_back = self.feed_back(arrived_mode, arrived_force_n, &at_master);

        let desired = self.desired(desired_m);
        observer.observe(&Signals::of_both(tick, &(desired, master, fed_back), &(slave, measured, command)));
        if observer.is_done() {
            return ControlFlow::Break(Ok(()));
        }

        // Step 7.
        let desired_next_m = self.next_desired_m(tick, arrived_mode, &master);
        let deflection_m = self.link.deflection_m(measured.reaction.force_n);
        let force = measured.tissue_force();
        match plants.step(desired_m, desired_next_m, fed_back.force_n, command.slave_reference_m, deflection_m, force) {
            Ok(()) => ControlFlow::Continue(desired_next_m),
            Err(error) => ControlFlow::Break(Err(error.into())),
        }
    }

    fn link_report(&self, index: usize) -> Option<LinkReport> {
        self.link.report(index)
    }

    fn share_noise(&mut self, bank: &mut NoiseBank, ticks: u64) {
        self.sensor.share_noise(bank, ticks);
    }
}

impl<O, T, S, E, D, K, M, F> Gather for Parts<f64, O, T, S, E, D, K, M, F>
where
    O: Gather,
    T: Gather,
    S: Gather,
    E: Gather,
    D: Gather,
    K: Gather,
    M: Gather,
    F: Gather,
{
    type Of<L: Lane> = Parts<L, O::Of<L>, T::Of<L>, S::Of<L>, E::Of<L>, D::Of<L>, K::Of<L>, M::Of<L>, F::Of<L>>;

    fn gather<L: Lane>(all: [&Self; LANES]) -> Option<Self::Of<L>> {
        Some(Parts {
            operator: O::gather(of_each!(all, |one| &one.operator))?,
            tissue: T::gather(of_each!(all, |one| &one.tissue))?,
            sensor: S::gather(of_each!(all, |one| &one.sensor))?,
            chain: Gather::gather(of_each!(all, |one| &one.chain))?,
            supervisor: Gather::gather(of_each!(all, |one| &one.supervisor))?,
            link: K::gather(of_each!(all, |one| &one.link))?,
            safety: Gather::gather(of_each!(all, |one| &one.safety))?,
            master_reading: Gather::gather(of_each!(all, |one| &one.master_reading))?,
        })
    }
}
