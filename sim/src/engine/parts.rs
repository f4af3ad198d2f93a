//! The parts around the plants, and the tick.

use std::ops::ControlFlow;

use super::{IntegrationError, Observer, Plants, Signals};
use crate::augmentation::{AnyForceLaw, ForceLaw, HeldReference, MotionLaw, Situation, SlaveCommand, Supervisor};
use crate::chain::Chain;
use crate::detection::Detector;
use crate::estimation::Estimator;
use crate::lane::{Gather, LANES, Lane, of_each};
use crate::operator::Operator;
use crate::sensor::{NoiseBank, Sensor};
use crate::teleoperation::{AtMaster, AtSlave, Connection, LinkReport};
use crate::tissue::Tissue;

/// The interface of [`Parts`] to the engine, independent of the part types.
pub trait Wiring {
    /// The number type of the tick.
    type Lane: Lane;

    /// The desired position at tick 0 in m.
    fn begin(&mut self) -> Self::Lane;

    /// Runs one tick with the desired position `desired_m` (m). Returns the desired position at the next tick, or the
    /// outcome at the end of the run.
    fn tick<P: Plants<Self::Lane>, O: Observer<Self::Lane>>(
        &mut self,
        tick: u64,
        desired_m: Self::Lane,
        plants: &mut P,
        observer: &mut O,
    ) -> ControlFlow<Result<(), IntegrationError>, Self::Lane>;

    /// The report of the link in lane `index`; `None` for a link that passes everything on in the same tick.
    fn link_report(&self, index: usize) -> Option<LinkReport>;

    /// Takes the noise of `ticks` ticks from a bank, if it has it or has room. The numbers are the same as without a
    /// bank.
    fn share_noise(&mut self, bank: &mut NoiseBank, ticks: u64);
}

/// The parts of an insertion besides the plants, one per role: operator, tissue, sensor, estimator, detector, link,
/// motion law and force law.
#[derive(Debug, Clone)]
pub struct Parts<L: Lane, O, T, S, E, D, K, M = HeldReference<L>, F = AnyForceLaw<L>> {
    /// The operator, who gives the desired position.
    pub operator: O,
    /// The tissue, which gives the force on the needle.
    pub tissue: T,
    /// The sensors of force, position and velocity.
    pub sensor: S,
    /// Estimator and detector.
    pub chain: Chain<L, E, D>,
    /// Automaton, motion law and force law.
    pub supervisor: Supervisor<L, M, F>,
    /// The link between the two sides.
    pub link: K,
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
    ) -> ControlFlow<Result<(), IntegrationError>, L> {
        // 1. read both plants
        let (master, slave) = (plants.master(), plants.slave());
        // 2. tissue and sensors
        let reaction = self.tissue.react(tick, slave.position_m, slave.velocity_m_per_s);
        let sensed_n = if self.sensor.excludes_shaft() {
            reaction.force_n - self.tissue.shaft_force_n()
        } else {
            reaction.force_n
        };
        let reading = self.sensor.read(sensed_n, slave.position_m, slave.velocity_m_per_s);
        // 3. and 4. estimator and detector
        let insight = self.chain.step(&reading);
        // 5. link and supervisor on the slave's side
        let at_master = AtMaster {
            position_m: master.position_m,
            velocity_m_per_s: master.velocity_m_per_s,
            hand_force_n: master.hand_force_n,
        };
        let at_slave = AtSlave {
            position_m: reading.position_m,
            velocity_m_per_s: reading.velocity_m_per_s,
            force_n: reading.force_n,
        };
        let SlaveCommand { mode, slave_reference_m: commanded_m, alarm_taken } = self.supervisor.decide(&Situation {
            tick,
            alarm: insight.decision.alarm,
            decision: insight.decision.decision,
            hand_m: self.link.to_slave(&at_master, &at_slave),
            slave_m: reading.position_m,
            force_n: reading.force_n,
        });
        let slave_reference_m = self.link.limit_reference(commanded_m, &at_slave);
        // 6. link and force law on the master's side
        let (arrived_mode, arrived_force_n) = self.link.to_master(mode, &at_slave, &at_master);
        let (commanded_force_n, allowed_force_step_n) =
            self.supervisor.feedback_force(arrived_mode, arrived_force_n, master.velocity_m_per_s);
        let feedback_force_n = self.link.limit(commanded_force_n, &at_master);

        observer.observe(&Signals {
            tick,
            desired_position_m: desired_m,
            intended_position_m: self.operator.intended_position_m(desired_m),
            master_position_m: master.position_m,
            master_velocity_m_per_s: master.velocity_m_per_s,
            operator_force_n: master.hand_force_n,
            slave_reference_m,
            slave_position_m: slave.position_m,
            slave_velocity_m_per_s: slave.velocity_m_per_s,
            tissue_force_n: reaction.force_n,
            measured_force_n: reading.force_n,
            feedback_force_n,
            stiffness_n_per_m: insight.estimate.stiffness_n_per_m,
            damping_n_s_per_m: insight.estimate.damping_n_s_per_m,
            extra_parameter: insight.estimate.extra_parameter,
            residual_n: insight.estimate.residual_n,
            distance: insight.decision.distance,
            decision: insight.decision.decision,
            mode,
            ruptured: reaction.ruptured,
            noticed: self.operator.notices(),
            alarm: insight.decision.alarm,
            alarm_taken,
            commanded_force_n,
            allowed_force_step_n,
        });
        if observer.is_done() {
            return ControlFlow::Break(Ok(()));
        }

        // 7. both plants to the next tick
        self.operator.cue(self.supervisor.cue(arrived_mode));
        let desired_next_m = self.operator.desired_position_m(tick + 1, master.hand_force_n);
        let reference_m = self.link.apply_compliance(slave_reference_m, reaction.force_n);
        match plants.step(desired_m, desired_next_m, feedback_force_n, reference_m) {
            Ok(()) => ControlFlow::Continue(desired_next_m),
            Err(error) => ControlFlow::Break(Err(error)),
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
        })
    }
}
