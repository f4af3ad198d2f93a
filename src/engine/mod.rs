//! One tick, N ticks, and the observers that see them.
//!
//! The physics between ticks is linear, so it is stepped exactly; the sides meet only through the sampled channel. A
//! tick, at `k * tick_s`:
//!
//! 1. read both sides: `x_h, v_h, F_h`; `x_e, v_e`
//! 2. tissue: `f_e`; sensors: the measured force `y`, position and velocity
//! 3. estimator: `e_k`, then its parameters
//! 4. detector: `s_k`, then `g_k` and the alarm
//! 5. link, and supervisor on the slave's side, fed with the hand's position as it arrives: mode, `x_ref`
//! 6. link, and force law on the master's side, fed with force and mode as they arrive: `F_ed`
//! 7. both sides to tick `k + 1`

mod dispatch;
mod exact;
mod integrated;
mod limited;
mod motor;
mod observer;
mod pack;
mod sides;
mod signals;
mod split;
mod trace;

pub use exact::ExactSides;
pub use integrated::{IntegratedSides, IntegrationError};
pub use limited::LimitedSides;
pub use observer::Observer;
pub use pack::InstructionSet;
pub(crate) use pack::{Wide, gather};
pub use sides::{MasterReading, Sides, SlaveReading};
pub use signals::Signals;
pub use split::SplitSides;
pub use trace::{COLUMNS, Trace};

use crate::augmentation::{Command, Situation, SlaveCommand, Supervisor};
use crate::detection::{Detector, Evidence};
use crate::estimation::{Estimator, VelocityFilter};
use crate::lane::Lane;
use crate::operator::{Operator, recorded};
use crate::sensor::Sensor;
use crate::teleoperation::{AtMaster, AtSlave, Link};
use crate::time::TickGrid;
use crate::tissue::{Layers, Reaction, RecordedForce, Tissue};

/// Everything that one insertion is made of, over any number of lanes.
#[derive(Debug, Clone)]
pub struct Engine<L: Lane, S> {
    /// Which ticks there are.
    pub grid: TickGrid,
    /// The two machines.
    pub sides: S,
    /// What the person wants.
    pub operator: Operator<L>,
    /// What the needle meets.
    pub tissue: Tissue<L>,
    /// How force and position are measured.
    pub sensor: Sensor<L>,
    /// The velocity from measured positions; without it the slave's own velocity is read.
    pub velocity_filter: Option<VelocityFilter<L>>,
    /// Where the estimator takes the tissue to begin, in m.
    pub contact_m: L,
    /// The estimator.
    pub estimator: Estimator<L>,
    /// The detector.
    pub detector: Detector<L>,
    /// The supervisor.
    pub supervisor: Supervisor<L>,
    /// What joins the sides.
    pub link: Link<L>,
}

/// What the person wants, known beforehand or not.
trait Desire<L: Lane> {
    /// The desired position in m at `tick`, after what was felt (N) at the one before.
    fn desired_m(&mut self, tick: u64, felt_n: L) -> L;
}

impl<L: Lane> Desire<L> for Operator<L> {
    #[inline(always)]
    fn desired_m(&mut self, tick: u64, felt_n: L) -> L {
        self.desired_position_m(tick, felt_n)
    }
}

/// Positions in m that are known beforehand.
struct Replay<'a>(&'a [f64]);

impl<L: Lane> Desire<L> for Replay<'_> {
    #[inline(always)]
    fn desired_m(&mut self, tick: u64, _felt_n: L) -> L {
        recorded(self.0, tick)
    }
}

/// What the needle meets, known or not when the run is compiled.
trait Answer<L: Lane> {
    /// The reaction at `tick` to the slave.
    fn answer(&mut self, tick: u64, slave: SlaveReading<L>) -> Reaction<L>;
}

impl<L: Lane> Answer<L> for Tissue<L> {
    #[inline(always)]
    fn answer(&mut self, tick: u64, slave: SlaveReading<L>) -> Reaction<L> {
        self.react(tick, slave.position_m, slave.velocity_m_per_s)
    }
}

impl<L: Lane> Answer<L> for RecordedForce {
    #[inline(always)]
    fn answer(&mut self, tick: u64, _slave: SlaveReading<L>) -> Reaction<L> {
        self.react(tick)
    }
}

impl<L: Lane> Answer<L> for Layers<L> {
    #[inline(always)]
    fn answer(&mut self, _tick: u64, slave: SlaveReading<L>) -> Reaction<L> {
        self.react(slave.position_m, slave.velocity_m_per_s)
    }
}

impl<L: Lane, S: Sides<L>> Engine<L, S> {
    /// Runs every tick of the grid, or until the observer has seen enough. Nothing is allocated on the way.
    ///
    /// # Errors
    /// [`IntegrationError`] where the sides are integrated numerically and the integrator gives up.
    pub fn run<O: Observer<L>>(&mut self, observer: &mut O) -> Result<(), IntegrationError> {
        dispatch::run(self, observer)
    }

    /// [`Engine::run`] without the machine's wider registers: slower, and equal to the last bit.
    ///
    /// # Errors
    /// As [`Engine::run`].
    pub fn run_portably<O: Observer<L>>(&mut self, observer: &mut O) -> Result<(), IntegrationError> {
        self.run_ticks(observer)
    }

    /// [`Engine::run`] in the instruction set of whoever inlines it.
    ///
    /// Person and tissue are taken out for the run, and the ticks of a motion that is known beforehand, on a replay or in
    /// layers, are compiled apart: what they need stays at hand.
    #[inline(always)]
    fn run_ticks<O: Observer<L>>(&mut self, observer: &mut O) -> Result<(), IntegrationError> {
        let mut operator = std::mem::replace(&mut self.operator, Operator::nobody());
        let mut tissue = std::mem::replace(&mut self.tissue, Tissue::nothing());
        let outcome = self.run_with(observer, &mut operator, &mut tissue);
        (self.operator, self.tissue) = (operator, tissue);
        outcome
    }

    /// The run with whom and what it is about.
    #[inline(always)]
    fn run_with<O: Observer<L>>(
        &mut self,
        observer: &mut O,
        operator: &mut Operator<L>,
        tissue: &mut Tissue<L>,
    ) -> Result<(), IntegrationError> {
        let direct = self.passes_positions_on();
        let exact = self.sensor.reads_force_exactly();
        if let Some(positions) = operator.as_replay() {
            let mut replay = Replay(positions);
            match (&mut *tissue, direct, exact) {
                (Tissue::Recording(force), true, true) => {
                    return self.run_where::<true, true, _, _, _>(observer, &mut replay, force);
                }
                (Tissue::Layers(layers), true, _) => {
                    return self.run_where::<true, false, _, _, _>(observer, &mut replay, &mut **layers);
                }
                _ => {}
            }
        }
        if direct && exact {
            self.run_where::<true, true, _, _, _>(observer, operator, tissue)
        } else {
            self.run_where::<false, false, _, _, _>(observer, operator, tissue)
        }
    }

    /// Whether positions and the fed-back force arrive at once and as they are: no encoder, no filter, no delay. The
    /// estimator has to be the paper's, too: the others are compiled into the way that is not straight.
    fn passes_positions_on(&self) -> bool {
        self.sensor.reads_position_exactly()
            && self.velocity_filter.is_none()
            && self.link.is_direct()
            && self.estimator.is_the_papers()
    }

    /// The run, compiled apart for positions that are `DIRECT`ly passed on and forces read `EXACT`ly, so that its ticks need not
    /// ask, and for the
    /// tissue; `desire` gives the desired position in m at a tick, after what was felt (N) at the one before.
    #[inline(always)]
    fn run_where<const DIRECT: bool, const EXACT: bool, O, D, T>(
        &mut self,
        observer: &mut O,
        desire: &mut D,
        tissue: &mut T,
    ) -> Result<(), IntegrationError>
    where
        O: Observer<L>,
        D: Desire<L>,
        T: Answer<L>,
    {
        // The estimator stays in `self`: it is more than the registers hold, and a copy here would push out what each
        // tick needs.
        let mut outcome = Ok(());
        let mut desired = desire.desired_m(0, L::zero());
        for tick in 0..self.grid.ticks() {
            let reaction = tissue.answer(tick, self.sides.slave());
            let signals = self.sense_and_decide::<DIRECT, EXACT>(tick, desired, reaction);
            observer.observe(&signals);
            if observer.is_done() {
                break;
            }
            let desired_next = desire.desired_m(tick + 1, signals.operator_force_n);
            let reference = if DIRECT {
                signals.slave_reference_m
            } else {
                self.link.yielding(signals.slave_reference_m, signals.tissue_force_n)
            };
            outcome = self.sides.step(desired, desired_next, signals.feedback_force_n, reference);
            if outcome.is_err() {
                break;
            }
            desired = desired_next;
        }
        outcome
    }

    /// A tick's steps 1 and 3 to 6: everything that is known before the sides move on.
    #[inline(always)]
    fn sense_and_decide<const DIRECT: bool, const EXACT: bool>(
        &mut self,
        tick: u64,
        desired: L,
        reaction: Reaction<L>,
    ) -> Signals<L> {
        let master = self.sides.master();
        let slave = self.sides.slave();
        let measured_force = if EXACT { reaction.force_n } else { self.sensor.read_force(reaction.force_n) };
        let (mut measured_position, mut measured_velocity) = (slave.position_m, slave.velocity_m_per_s);
        if !DIRECT {
            measured_position = self.sensor.read_position(slave.position_m);
            if let Some(filter) = &mut self.velocity_filter {
                measured_velocity = filter.update(measured_position);
            }
        }
        let depth = measured_position - self.contact_m;
        let estimate = if DIRECT {
            self.estimator.update_papers(measured_force, depth, measured_velocity)
        } else {
            self.estimator.update(measured_force, depth, measured_velocity)
        };
        let decision = self.detector.update(&Evidence {
            force_n: measured_force,
            predicted_force_n: estimate.predicted_force_n,
            residual_n: estimate.residual_n,
            correction: estimate.correction,
            depth_m: depth,
            velocity_m_per_s: measured_velocity,
            in_contact: depth.gt(L::zero()),
        });

        let mut situation = Situation {
            tick,
            alarm: decision.alarm,
            decision: decision.decision,
            hand_m: self.link.position_scale() * master.position_m,
            slave_m: measured_position,
            force_n: self.link.force_scale() * measured_force,
        };
        let (command, feedback_force) = if DIRECT {
            let command = self.supervisor.update(&situation);
            (command, command.feedback_force_n)
        } else {
            let at_master = AtMaster {
                position_m: master.position_m,
                velocity_m_per_s: master.velocity_m_per_s,
                hand_force_n: master.hand_force_n,
            };
            let at_slave =
                AtSlave { position_m: measured_position, velocity_m_per_s: measured_velocity, force_n: measured_force };
            situation.hand_m = self.link.to_slave(&at_master, &at_slave);
            let SlaveCommand { mode, slave_reference_m, alarm_taken } = self.supervisor.decide(&situation);
            let (arrived_mode, force) = self.link.to_master(mode, &at_slave, &at_master);
            let (feedback_force_n, allowed_step_n) = self.supervisor.feel(arrived_mode, force);
            let command = Command { mode, slave_reference_m, feedback_force_n, allowed_step_n, alarm_taken };
            (command, self.link.limit(feedback_force_n, &at_master))
        };

        Signals {
            tick,
            desired_position_m: desired,
            master_position_m: master.position_m,
            master_velocity_m_per_s: master.velocity_m_per_s,
            operator_force_n: master.hand_force_n,
            slave_reference_m: command.slave_reference_m,
            slave_position_m: slave.position_m,
            slave_velocity_m_per_s: slave.velocity_m_per_s,
            tissue_force_n: reaction.force_n,
            measured_force_n: measured_force,
            feedback_force_n: feedback_force,
            stiffness_n_per_m: estimate.stiffness_n_per_m,
            damping_n_s_per_m: estimate.damping_n_s_per_m,
            further: estimate.further,
            residual_n: estimate.residual_n,
            distance: decision.distance,
            decision: decision.decision,
            mode: command.mode,
            ruptured: reaction.ruptured,
            alarm: decision.alarm,
            alarm_taken: command.alarm_taken,
            commanded_force_n: command.feedback_force_n,
            allowed_force_step_n: command.allowed_step_n,
        }
    }
}
