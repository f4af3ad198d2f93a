//! One tick, N ticks, and the observers that see them.
//!
//! The physics between ticks is linear, so it is stepped exactly; the two sides meet only through the sampled channel. A
//! tick, at `k * tick_s`:
//!
//! 1. read both plants: `x_h, v_h, F_h`; `x_e, v_e`
//! 2. tissue: `f_e`; sensors: the measured force `y`, position and velocity
//! 3. estimator: `e_k`, then its parameters
//! 4. detector: `s_k`, then `g_k` and the alarm
//! 5. link, and supervisor on the slave's side, fed with the hand's position as it arrives: mode, `x_ref`
//! 6. link, and force law on the master's side, fed with force and mode as they arrive: `F_ed`
//! 7. both plants to tick `k + 1`

mod dispatch;
#[cfg(target_arch = "x86_64")]
mod eight;
mod exact;
mod integrated;
mod limited;
mod motor;
mod observer;
mod pack;
mod plants;
mod scheduled;
mod signals;
mod split;
mod trace;

#[cfg(target_arch = "x86_64")]
pub(crate) use eight::{Avx2, Avx512};
pub use exact::ExactPlants;
pub use integrated::{IntegratedPlants, IntegrationError};
pub use limited::LimitedPlants;
pub use observer::Observer;
pub use pack::InstructionSet;
pub(crate) use pack::{Wide, gather};
pub use plants::{MasterReading, Plants, SlaveReading};
pub use scheduled::ScheduledAlarms;
pub use signals::Signals;
pub use split::FractionalDelayPlants;
pub use trace::{COLUMNS, ColumnValues, TRACE_COLUMNS, Trace, TraceColumn};

use std::ops::ControlFlow;

use crate::augmentation::{Command, Situation, SlaveCommand, Supervisor};
use crate::detection::{Detector, Evidence};
use crate::estimation::{Estimate, Estimator, VelocityFilter};
use crate::lane::{Lane, Mask};
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
    pub plants: S,
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
    /// What joins the two sides.
    pub link: Link<L>,
    /// Alarms that are raised whatever the detector says.
    pub scheduled: ScheduledAlarms,
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

impl<S> Engine<f64, S> {
    /// Asks thresholds that are above the detector's own and below its cap whether the run under them is the same.
    pub(crate) fn ask_higher_thresholds(&mut self, thresholds: &[f64]) {
        self.detector.ask_higher(thresholds);
    }
}

impl<L: Lane, S> Engine<L, S> {
    /// Those of the thresholds that were asked under which lane `index` has been the same run, to the last bit; some of which
    /// that is true may be missing.
    pub(crate) fn thresholds_alike(&self, index: usize) -> Vec<f64> {
        if self.supervisor.depends_on_threshold(index) { vec![] } else { self.detector.alike(index).collect() }
    }
}

impl<L: Lane, S: Plants<L>> Engine<L, S> {
    /// Runs every tick of the grid, or until the observer has seen enough. Nothing is allocated on the way.
    ///
    /// # Errors
    /// [`IntegrationError`] where the plants are integrated numerically and the integrator gives up.
    pub fn run<O: Observer<L>>(&mut self, observer: &mut O) -> Result<(), IntegrationError> {
        dispatch::run(self, observer)
    }

    /// [`Engine::run`] without the machine's wider registers: slower, and equal to the last bit.
    ///
    /// # Errors
    /// As [`Engine::run`].
    pub fn run_portably<O: Observer<L>>(&mut self, observer: &mut O) -> Result<(), IntegrationError> {
        self.run_ticks::<false, _>(observer)
    }

    /// [`Engine::run`] in the instruction set of whoever inlines it.
    ///
    /// Person and tissue are taken out for the run, and for the observers that matter and where `APART` the ticks of a motion
    /// that is known beforehand, on a replay or in layers, are compiled apart: what they need stays at hand.
    #[inline(always)]
    fn run_ticks<const APART: bool, O: Observer<L>>(&mut self, observer: &mut O) -> Result<(), IntegrationError> {
        let mut operator = std::mem::replace(&mut self.operator, Operator::nobody());
        let mut tissue = std::mem::replace(&mut self.tissue, Tissue::nothing());
        let outcome = if APART && O::is_common() {
            self.run_with(observer, &mut operator, &mut tissue)
        } else if APART && L::WIDTH == 1 && self.passes_positions_on() {
            // Whoever watches: one straight way for all persons, tissues and sensors.
            self.run_where::<true, false, _, _, _>(observer, &mut operator, &mut tissue)
        } else {
            self.run_where::<false, false, _, _, _>(observer, &mut operator, &mut tissue)
        };
        (self.operator, self.tissue) = (operator, tissue);
        outcome
    }

    /// The run with whom and what it is about, compiled apart for the kinds that are common.
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
            match (&mut *tissue, direct) {
                (Tissue::Recording(force), true) if exact && L::WIDTH == 1 => {
                    return self.run_where::<true, true, _, _, _>(observer, &mut replay, force);
                }
                (Tissue::Recording(force), true) => {
                    return self.run_where::<true, false, _, _, _>(observer, &mut replay, force);
                }
                (Tissue::Layers(layers), true) => {
                    return self.run_where::<true, false, _, _, _>(observer, &mut replay, &mut **layers);
                }
                _ => {}
            }
        }
        // Side by side, what is seldom asked for is compiled once.
        if direct && exact && L::WIDTH == 1 {
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
            && self.estimator.is_baseline()
            && self.detector.is_square()
            && self.scheduled.is_empty()
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
        let mut desired = desire.desired_m(0, L::zero());
        for tick in 0..self.grid.ticks() {
            let reaction = tissue.answer(tick, self.plants.slave());
            let sensed = self.sense::<DIRECT, EXACT>(tick, desired, reaction);
            // The ticks on which nothing happens, which most are, are compiled apart up to their end: that there is no alarm and
            // no other mode need not be asked again, nor do their numbers wait for the others' in the same registers.
            let flow = if DIRECT && self.supervisor.passes_on(sensed.situation.alarm) {
                let command = self.supervisor.pass(&sensed.situation);
                self.conclude::<true, _, _>(sensed, command, command.feedback_force_n, observer, desire)
            } else {
                self.tick_closely::<DIRECT, _, _>(sensed, observer, desire)
            };
            match flow {
                ControlFlow::Continue(desired_next) => desired = desired_next,
                ControlFlow::Break(outcome) => return outcome,
            }
        }
        Ok(())
    }

    /// The rest of a tick, steps 5 to 7, on which something may happen.
    #[inline(always)]
    fn tick_closely<const DIRECT: bool, O, D>(
        &mut self,
        sensed: Sensed<L>,
        observer: &mut O,
        desire: &mut D,
    ) -> ControlFlow<Result<(), IntegrationError>, L>
    where
        O: Observer<L>,
        D: Desire<L>,
    {
        if DIRECT {
            std::hint::cold_path();
            let command = self.supervisor.update(&sensed.situation);
            return self.conclude::<true, _, _>(sensed, command, command.feedback_force_n, observer, desire);
        }
        let Sensed { master, mut situation, .. } = sensed;
        let at_master = AtMaster {
            position_m: master.position_m,
            velocity_m_per_s: master.velocity_m_per_s,
            hand_force_n: master.hand_force_n,
        };
        let at_slave = AtSlave {
            position_m: sensed.measured_position_m,
            velocity_m_per_s: sensed.measured_velocity_m_per_s,
            force_n: sensed.measured_force_n,
        };
        if self.scheduled.is_due(situation.tick) {
            situation.alarm = L::Mask::splat(true);
        }
        situation.hand_m = self.link.to_slave(&at_master, &at_slave);
        let SlaveCommand { mode, slave_reference_m, alarm_taken } = self.supervisor.decide(&situation);
        let (arrived_mode, force) = self.link.to_master(mode, &at_slave, &at_master);
        let (feedback_force_n, allowed_step_n) = self.supervisor.feel(arrived_mode, force);
        let command = Command { mode, slave_reference_m, feedback_force_n, allowed_step_n, alarm_taken };
        let feedback_force = self.link.limit(feedback_force_n, &at_master);
        self.conclude::<false, _, _>(sensed, command, feedback_force, observer, desire)
    }

    /// The end of a tick: its signals are shown, and both plants go to the next. Gives the desired position there, or how the
    /// run has ended.
    #[inline(always)]
    fn conclude<const DIRECT: bool, O, D>(
        &mut self,
        sensed: Sensed<L>,
        command: Command<L>,
        feedback_force_n: L,
        observer: &mut O,
        desire: &mut D,
    ) -> ControlFlow<Result<(), IntegrationError>, L>
    where
        O: Observer<L>,
        D: Desire<L>,
    {
        let signals = sensed.signals(&command, feedback_force_n);
        observer.observe(&signals);
        if observer.is_done() {
            return ControlFlow::Break(Ok(()));
        }
        let desired = signals.desired_position_m;
        let desired_next = desire.desired_m(signals.tick + 1, signals.operator_force_n);
        let reference = if DIRECT {
            signals.slave_reference_m
        } else {
            self.link.apply_compliance(signals.slave_reference_m, signals.tissue_force_n)
        };
        match self.plants.step(desired, desired_next, feedback_force_n, reference) {
            Ok(()) => ControlFlow::Continue(desired_next),
            Err(error) => ControlFlow::Break(Err(error)),
        }
    }

    /// A tick's steps 1, 3 and 4: what is read, estimated and detected.
    #[inline(always)]
    fn sense<const DIRECT: bool, const EXACT: bool>(
        &mut self,
        tick: u64,
        desired_position_m: L,
        reaction: Reaction<L>,
    ) -> Sensed<L> {
        let master = self.plants.master();
        let slave = self.plants.slave();
        let measured_force_n = if EXACT { reaction.force_n } else { self.sensor.read_force(reaction.force_n) };
        let (mut measured_position_m, mut measured_velocity_m_per_s) = (slave.position_m, slave.velocity_m_per_s);
        if !DIRECT {
            measured_position_m = self.sensor.read_position(slave.position_m);
            if let Some(filter) = &mut self.velocity_filter {
                measured_velocity_m_per_s = filter.update(measured_position_m);
            }
        }
        let depth = measured_position_m - self.contact_m;
        let estimate = if DIRECT {
            self.estimator.update_papers(measured_force_n, depth, measured_velocity_m_per_s)
        } else {
            self.estimator.update(measured_force_n, depth, measured_velocity_m_per_s)
        };
        let evidence = Evidence {
            force_n: measured_force_n,
            predicted_force_n: estimate.predicted_force_n,
            residual_n: estimate.residual_n,
            correction: estimate.correction,
            depth_m: depth,
            velocity_m_per_s: measured_velocity_m_per_s,
            in_contact: depth.gt(L::zero()),
        };
        let decision = if DIRECT { self.detector.update_square(&evidence) } else { self.detector.update(&evidence) };
        let situation = Situation {
            tick,
            alarm: decision.alarm,
            decision: decision.decision,
            hand_m: self.link.position_scale() * master.position_m,
            slave_m: measured_position_m,
            force_n: self.link.force_scale() * measured_force_n,
        };
        Sensed {
            desired_position_m,
            reaction,
            master,
            slave,
            measured_force_n,
            measured_position_m,
            measured_velocity_m_per_s,
            estimate,
            distance: decision.distance,
            situation,
        }
    }
}

/// What is known of a tick before the supervisor decides.
struct Sensed<L: Lane> {
    desired_position_m: L,
    reaction: Reaction<L>,
    master: MasterReading<L>,
    slave: SlaveReading<L>,
    measured_force_n: L,
    measured_position_m: L,
    measured_velocity_m_per_s: L,
    estimate: Estimate<L>,
    distance: L,
    situation: Situation<L>,
}

impl<L: Lane> Sensed<L> {
    /// The tick's signals under a command; the fed-back force is the one that arrives, in N.
    #[inline(always)]
    fn signals(&self, command: &Command<L>, feedback_force_n: L) -> Signals<L> {
        let Self { master, slave, estimate, situation, .. } = self;
        Signals {
            tick: situation.tick,
            desired_position_m: self.desired_position_m,
            master_position_m: master.position_m,
            master_velocity_m_per_s: master.velocity_m_per_s,
            operator_force_n: master.hand_force_n,
            slave_reference_m: command.slave_reference_m,
            slave_position_m: slave.position_m,
            slave_velocity_m_per_s: slave.velocity_m_per_s,
            tissue_force_n: self.reaction.force_n,
            measured_force_n: self.measured_force_n,
            feedback_force_n,
            stiffness_n_per_m: estimate.stiffness_n_per_m,
            damping_n_s_per_m: estimate.damping_n_s_per_m,
            extra_parameter: estimate.extra_parameter,
            residual_n: estimate.residual_n,
            distance: self.distance,
            decision: situation.decision,
            mode: command.mode,
            ruptured: self.reaction.ruptured,
            alarm: situation.alarm,
            alarm_taken: command.alarm_taken,
            commanded_force_n: command.feedback_force_n,
            allowed_force_step_n: command.allowed_step_n,
        }
    }
}
