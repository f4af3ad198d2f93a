//! From a scenario to an engine.

use std::borrow::Cow;
use std::sync::Arc;

use super::engine_kind::EngineKind;
use super::error::ScenarioError;
use super::resolve::{DelayTicks, Scenario};
use super::specs::{OperatorSpec, TissueSpec};
use super::steps::Steps;
use crate::augmentation::Supervisor;
use crate::channel::Delay;
use crate::detection::Detector;
use crate::engine::{
    Engine, ExactPlants, FractionalDelayPlants, IntegratedPlants, IntegrationError, LimitedPlants, Observer,
    ScheduledAlarms,
};
use crate::error::InvalidValue;
use crate::estimation::{Estimator, VelocityFilter};
use crate::lane::Lane;
use crate::operator::{Hand, Motion, Operator, Ramp, Reflex};
use crate::plant::{MasterStep, PlantError, SlaveStep};
use crate::sensor::Sensor;
use crate::teleoperation::{Link, LinkReport};
use crate::tissue::{DepthReplay, RecordedForce, Tissue};

/// Set the two directions' random numbers apart from all others with the same seed.
const FORWARD: u64 = 0x66_6f72_7761_7264;
const BACKWARD: u64 = 0x6261_636b_7761_7264;

/// An engine of any kind.
#[derive(Debug, Clone)]
pub enum ScenarioEngine {
    /// Stepped exactly.
    Exact(Box<Engine<f64, ExactPlants<f64>>>),
    /// Stepped exactly, with motors that saturate.
    Limited(Box<Engine<f64, LimitedPlants<f64>>>),
    /// Stepped exactly, with samples that arrive between ticks.
    Split(Box<Engine<f64, FractionalDelayPlants<f64>>>),
    /// Integrated numerically.
    Integrated(Box<Engine<f64, IntegratedPlants>>),
}

impl ScenarioEngine {
    /// Runs the scenario. The plain exact engine is compiled for the observer that watches it; the others call it, as there
    /// is more in their ticks than such a call.
    ///
    /// # Errors
    /// As [`Engine::run`].
    pub fn run<O: Observer<f64>>(&mut self, observer: &mut O) -> Result<(), IntegrationError> {
        let called: &mut dyn Observer<f64> = &mut *observer;
        match self {
            Self::Exact(engine) => engine.run(observer),
            Self::Limited(engine) => engine.run(&mut { called }),
            Self::Split(engine) => engine.run(&mut { called }),
            Self::Integrated(engine) => engine.run(&mut { called }),
        }
    }

    /// As [`Engine::ask_higher_thresholds`].
    pub(crate) fn ask_higher_thresholds(&mut self, thresholds: &[f64]) {
        match self {
            Self::Exact(engine) => engine.ask_higher_thresholds(thresholds),
            Self::Limited(engine) => engine.ask_higher_thresholds(thresholds),
            Self::Split(engine) => engine.ask_higher_thresholds(thresholds),
            Self::Integrated(engine) => engine.ask_higher_thresholds(thresholds),
        }
    }

    /// As [`Engine::thresholds_alike`], of the only lane.
    pub(crate) fn thresholds_alike(&self) -> Vec<f64> {
        match self {
            Self::Exact(engine) => engine.thresholds_alike(0),
            Self::Limited(engine) => engine.thresholds_alike(0),
            Self::Split(engine) => engine.thresholds_alike(0),
            Self::Integrated(engine) => engine.thresholds_alike(0),
        }
    }

    /// What the link has seen; none where positions and forces arrive at once and as they are.
    #[must_use]
    pub fn link_report(&self) -> Option<LinkReport> {
        let link = match self {
            Self::Exact(engine) => &engine.link,
            Self::Limited(engine) => &engine.link,
            Self::Split(engine) => &engine.link,
            Self::Integrated(engine) => &engine.link,
        };
        (!link.is_direct()).then(|| link.report(0))
    }
}

impl Scenario {
    /// The engine that the scenario asks for, ready at tick 0.
    ///
    /// # Errors
    /// [`ScenarioError`] where the parameters make no machine that can be computed with.
    pub fn build(&self) -> Result<ScenarioEngine, ScenarioError> {
        Ok(match self.engine {
            EngineKind::Exact if self.is_split() => ScenarioEngine::Split(Box::new(self.split_engine(0)?)),
            EngineKind::Exact if self.actuators.are_none() => ScenarioEngine::Exact(Box::new(self.exact_engine(0)?)),
            EngineKind::Exact => ScenarioEngine::Limited(Box::new(self.limited_engine(0)?)),
            EngineKind::Dop853 => {
                let start_m = self.start_m();
                let plants = IntegratedPlants::new(
                    (&self.master, &self.arm, &self.slave),
                    self.timing,
                    self.grid.tick_s(),
                    start_m,
                    self.position_scale() * start_m,
                );
                let plants = plants.limited(&self.actuators).split(self.backward.share, self.forward.share);
                ScenarioEngine::Integrated(Box::new(self.assemble(plants, 0)?))
            }
        })
    }

    /// The exact engine over lanes, all running this scenario, lane `i` with the noise of stream `first_stream + i`.
    ///
    /// # Errors
    /// As [`Scenario::build`], and for a scenario with actuator limits, which takes [`Scenario::limited_engine`], or with
    /// delays of no whole number of ticks, which takes [`Scenario::split_engine`].
    pub fn exact_engine<L: Lane>(&self, first_stream: u64) -> Result<Engine<L, ExactPlants<L>>, ScenarioError> {
        if !self.actuators.are_none() {
            return Err(
                ScenarioError::new("this engine has no actuator limits").at(self.values().section_place("actuator"))
            );
        }
        if self.is_split() {
            let message = "this engine has no samples that arrive between ticks";
            return Err(ScenarioError::new(message).at(self.values().section_place("channel")));
        }
        self.assemble(self.exact_plants()?, first_stream)
    }

    /// Whether samples arrive between ticks.
    pub(super) fn is_split(&self) -> bool {
        self.forward.share > 0.0 || self.backward.share > 0.0
    }

    /// As [`Scenario::exact_engine`], with samples that arrive between ticks.
    ///
    /// # Errors
    /// As [`Scenario::build`].
    pub fn split_engine<L: Lane>(
        &self,
        first_stream: u64,
    ) -> Result<Engine<L, FractionalDelayPlants<L>>, ScenarioError> {
        let tick_s = self.grid.tick_s();
        let plant = |error| self.unbuildable(&error);
        let rest_s = |delay: DelayTicks| (1.0 - delay.share) * tick_s;
        let master = MasterStep::new(&self.master, &self.arm, self.timing, rest_s(self.backward)).map_err(plant)?;
        let slave = SlaveStep::new(&self.slave, self.timing, rest_s(self.forward)).map_err(plant)?;
        let reference_m = self.position_scale() * self.start_m();
        self.assemble(FractionalDelayPlants::new(self.exact_plants()?, &master, &slave, reference_m), first_stream)
    }

    /// The steps of master and slave over a whole tick.
    pub(super) fn whole_steps(&self) -> Result<(Cow<'_, MasterStep>, Cow<'_, SlaveStep>), PlantError> {
        let (sides, tick_s) = ((&self.master, &self.arm, &self.slave), self.grid.tick_s());
        if let Some(kept) = self.steps.get().filter(|kept| kept.are_of(sides, self.timing, tick_s)) {
            return Ok((Cow::Borrowed(&kept.master), Cow::Borrowed(&kept.slave)));
        }
        let made = Steps::new(sides, self.timing, tick_s)?;
        let steps = (Cow::Owned(made.master.clone()), Cow::Owned(made.slave.clone()));
        // Another thread may have been first, with the same numbers; or they belong to a copy that was changed.
        let _ = self.steps.set(made);
        Ok(steps)
    }

    /// Both plants over whole ticks.
    fn exact_plants<L: Lane>(&self) -> Result<ExactPlants<L>, ScenarioError> {
        let start_m = self.start_m();
        let (master, slave) = self.whole_steps().map_err(|error| self.unbuildable(&error))?;
        Ok(ExactPlants::new(&master, &slave, start_m, self.position_scale() * start_m))
    }

    /// As [`Scenario::exact_engine`], with sampled controllers and the scenario's actuator limits.
    ///
    /// # Errors
    /// As [`Scenario::build`].
    pub fn limited_engine<L: Lane>(&self, first_stream: u64) -> Result<Engine<L, LimitedPlants<L>>, ScenarioError> {
        let machines = (&self.master, &self.arm, &self.slave);
        let start_m = self.start_m();
        let reference_m = self.position_scale() * start_m;
        let plants = LimitedPlants::new(machines, &self.actuators, self.grid.tick_s(), start_m, reference_m);
        self.assemble(plants.map_err(|error| self.unbuildable(&error))?, first_stream)
    }

    /// A side that cannot be built, at the place of what is wrong with it.
    fn unbuildable(&self, error: &PlantError) -> ScenarioError {
        match error {
            PlantError::Parameter(invalid) => self.values().out_of_range(invalid),
            PlantError::SlaveDegree { .. } => {
                ScenarioError::new(error.to_string()).at(self.values().section_place("slave"))
            }
            PlantError::Build { side, .. } => ScenarioError::new(error.to_string())
                .at(self.values().section_place(side))
                .remedy(format!("look at the numbers of [{side}]")),
        }
    }

    /// The scenario around two machines.
    fn assemble<L: Lane, S>(&self, plants: S, first_stream: u64) -> Result<Engine<L, S>, ScenarioError> {
        let tick_s = self.grid.tick_s();
        let start_m = self.start_m();
        let out_of_range = |error| self.values().out_of_range(&error);
        let velocity_filter = (self.sensor.position_resolution_m > 0.0)
            .then(|| {
                VelocityFilter::new(tick_s, self.sensor.position_resolution_m, self.sensor.acceleration_std_m_per_s2)
            })
            .transpose()
            .map_err(out_of_range)?;
        Ok(Engine {
            grid: self.grid,
            plants,
            operator: self.person(first_stream).map_err(out_of_range)?,
            tissue: match &self.tissue {
                TissueSpec::Recording { force_n, rupture_ticks } => {
                    Tissue::Recording(RecordedForce::new(force_n.clone(), rupture_ticks.clone()))
                }
                TissueSpec::Depth { position_m, force_n, rupture_depths_m, presliding_m } => {
                    let start_m = self.position_scale() * start_m;
                    let recording = (&**position_m, &**force_n);
                    let replay = DepthReplay::new(recording, rupture_depths_m.clone(), *presliding_m, start_m);
                    Tissue::Depth(replay.map_err(out_of_range)?)
                }
                TissueSpec::Model(settings) => {
                    settings.build(tick_s, self.position_scale() * start_m).map_err(out_of_range)?
                }
            },
            sensor: Sensor::new(&self.sensor, tick_s, self.seed, first_stream),
            velocity_filter,
            contact_m: L::splat(self.contact_m),
            estimator: Estimator::new(&self.estimator),
            detector: Detector::new(&self.detector, tick_s),
            supervisor: Supervisor::new(
                &self.augmentation,
                self.detector.cusum.threshold,
                tick_s,
                L::splat(self.position_scale() * start_m),
            ),
            link: self.joined(first_stream)?,
            // Without augmentation there is nothing that an alarm could begin.
            scheduled: ScheduledAlarms::new(if self.augmentation.enabled {
                self.events.clone()
            } else {
                Arc::default()
            }),
        })
    }

    /// What joins the two sides.
    fn joined<L: Lane>(&self, first_stream: u64) -> Result<Link<L>, ScenarioError> {
        let (tick_s, start_m, zero) = (self.grid.tick_s(), self.start_m(), L::zero());
        let (at_master, at_slave) = (L::splat(start_m), L::splat(self.position_scale() * start_m));
        let forth = [at_master, zero, zero, zero, zero];
        let forth = Delay::new(self.forward.whole, forth).irregular(
            &self.irregularity,
            &self.forward_schedule,
            tick_s,
            forth,
            (self.seed ^ FORWARD, first_stream),
        );
        let back = [zero, at_slave, zero, zero, zero, zero];
        let back = Delay::new(self.backward.whole, back).irregular(
            &self.irregularity,
            &self.backward_schedule,
            tick_s,
            back,
            (self.seed ^ BACKWARD, first_stream),
        );
        Link::new(&self.link, (forth, back), tick_s, start_m).map_err(|error| self.values().out_of_range(&error))
    }

    /// The person, lane `i` with the tremor and the reaction times of stream `first_stream + i`.
    fn person<L: Lane>(&self, first_stream: u64) -> Result<Operator<L>, InvalidValue> {
        let tick_s = self.grid.tick_s();
        let motion = match &self.operator {
            OperatorSpec::Recording(positions) => Motion::Recording(positions.clone()),
            OperatorSpec::Ramp { start_m, end_m, speed_m_per_s } => {
                Motion::Ramp(Ramp::new(*start_m, *end_m, *speed_m_per_s, tick_s)?)
            }
            OperatorSpec::Hand(hand) => Motion::Hand(hand.clone()),
        };
        let mut person = Operator::new(motion);
        if self.tremor.amplitude_m > 0.0 {
            let ticks = self.grid.ticks() + 1;
            person = person.trembling(self.tremor.displacements(self.seed, first_stream, tick_s, ticks));
        }
        Ok(person.reacting(&self.reflex, self.seed, first_stream, tick_s))
    }

    /// Where the person begins, in m; both plants begin there at rest.
    pub(super) fn start_m(&self) -> f64 {
        match &self.operator {
            OperatorSpec::Recording(positions) => positions.first().copied().unwrap_or(0.0),
            OperatorSpec::Ramp { start_m, .. } => *start_m,
            OperatorSpec::Hand(hand) => hand.position_m(),
        }
    }

    /// The same scenario in somebody's hand: where it begins is where the hand is, and nothing else trembles or reacts.
    #[must_use]
    pub fn held_by(mut self, hand: Arc<Hand>) -> Self {
        self.operator = OperatorSpec::Hand(hand);
        self.tremor.amplitude_m = 0.0;
        self.reflex.reflex = Reflex::None;
        self
    }
}
