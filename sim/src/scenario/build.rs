//! From a scenario to an engine.

use std::borrow::Cow;
use std::sync::Arc;

use super::engine_kind::EngineKind;
use super::error::ScenarioError;
use super::resolve::{DelayTicks, Scenario};
use super::specs::{OperatorSpec, TissueSpec};
use super::steps::Steps;
use crate::augmentation::Supervisor;
use crate::chain::Chain;
use crate::channel::Delay;
use crate::detection::{CusumDetector, DistanceKind, SquaredResidual};
use crate::engine::{
    Any, AnyDetector, Engine, ExactPlants, FractionalDelayPlants, IntegratedPlants, IntegrationError, LimitedPlants,
    Observer, Parts, ScheduledAlarms, Wired, Wiring,
};
use crate::estimation::{AnyEstimator, Rls};
use crate::lane::Lane;
use crate::operator::{Hand, Motion, Person, Ramp, Reflex, Replay};
use crate::plant::{MasterStep, PlantError, SlaveStep};
use crate::sensor::{AnySensor, ForceSensor, PerfectSensor};
use crate::teleoperation::{DirectLink, Link, LinkReport};
use crate::tissue::{AnyTissue, DepthReplay, RecordedForce};

/// Set the two directions' random numbers apart from all others with the same seed.
const FORWARD: u64 = 0x66_6f72_7761_7264;
const BACKWARD: u64 = 0x6261_636b_7761_7264;

/// An engine of any kind.
#[derive(Debug, Clone)]
pub enum ScenarioEngine {
    /// Stepped exactly.
    Exact(Box<Wired<f64, ExactPlants<f64>>>),
    /// Stepped exactly, with motors that saturate.
    Limited(Box<Engine<LimitedPlants<f64>, Any<f64>>>),
    /// Stepped exactly, with samples that arrive between ticks.
    Split(Box<Engine<FractionalDelayPlants<f64>, Any<f64>>>),
    /// Integrated numerically.
    Integrated(Box<Engine<IntegratedPlants, Any<f64>>>),
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

    /// What the link has seen; none where positions and forces arrive at once and as they are.
    #[must_use]
    pub fn link_report(&self) -> Option<LinkReport> {
        match self {
            Self::Exact(engine) => engine.link_report(0),
            Self::Limited(engine) => engine.parts.link_report(0),
            Self::Split(engine) => engine.parts.link_report(0),
            Self::Integrated(engine) => engine.parts.link_report(0),
        }
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
                ScenarioEngine::Integrated(Box::new(self.general(plants, 0)?))
            }
        })
    }

    /// The exact engine over lanes, all running this scenario, lane `i` with the noise of stream `first_stream + i`.
    ///
    /// # Errors
    /// As [`Scenario::build`], and for a scenario with actuator limits, which takes [`Scenario::limited_engine`], or with
    /// delays of no whole number of ticks, which takes [`Scenario::split_engine`].
    pub fn exact_engine<L: Lane>(&self, first_stream: u64) -> Result<Wired<L, ExactPlants<L>>, ScenarioError> {
        if !self.actuators.are_none() {
            return Err(
                ScenarioError::new("this engine has no actuator limits").at(self.values().section_place("actuator"))
            );
        }
        if self.is_split() {
            let message = "this engine has no samples that arrive between ticks";
            return Err(ScenarioError::new(message).at(self.values().section_place("channel")));
        }
        self.wired(self.exact_plants()?, first_stream)
    }

    /// As [`Scenario::exact_engine`], compiled for any parts.
    ///
    /// # Errors
    /// As [`Scenario::build`].
    pub fn general_engine<L: Lane>(&self, first_stream: u64) -> Result<Engine<ExactPlants<L>, Any<L>>, ScenarioError> {
        self.general(self.exact_plants()?, first_stream)
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
    ) -> Result<Engine<FractionalDelayPlants<L>, Any<L>>, ScenarioError> {
        let tick_s = self.grid.tick_s();
        let plant = |error| self.unbuildable(&error);
        let rest_s = |delay: DelayTicks| (1.0 - delay.share) * tick_s;
        let master = MasterStep::new(&self.master, &self.arm, self.timing, rest_s(self.backward)).map_err(plant)?;
        let slave = SlaveStep::new(&self.slave, self.timing, rest_s(self.forward)).map_err(plant)?;
        let reference_m = self.position_scale() * self.start_m();
        self.general(FractionalDelayPlants::new(self.exact_plants()?, &master, &slave, reference_m), first_stream)
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
    pub fn limited_engine<L: Lane>(
        &self,
        first_stream: u64,
    ) -> Result<Engine<LimitedPlants<L>, Any<L>>, ScenarioError> {
        let machines = (&self.master, &self.arm, &self.slave);
        let start_m = self.start_m();
        let reference_m = self.position_scale() * start_m;
        let plants = LimitedPlants::new(machines, &self.actuators, self.grid.tick_s(), start_m, reference_m);
        self.general(plants.map_err(|error| self.unbuildable(&error))?, first_stream)
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

    /// The scenario around two machines, compiled for any parts.
    fn general<L: Lane, P>(&self, plants: P, first_stream: u64) -> Result<Engine<P, Any<L>>, ScenarioError> {
        let link = self.joined(first_stream)?;
        self.around(plants, self.person(first_stream)?, self.any_tissue()?, self.any_sensor(first_stream)?, link)
    }

    /// The scenario around two machines, compiled for its parts where they are common.
    fn wired<L: Lane, P>(&self, plants: P, first_stream: u64) -> Result<Wired<L, P>, ScenarioError> {
        let link: Link<L> = self.joined(first_stream)?;
        if !link.is_direct() {
            return self.general(plants, first_stream).map(Wired::Any);
        }
        let machines = &self.link.machines;
        let link = DirectLink::new(machines.position_scale, machines.force_scale);
        let is_baseline = self.estimator.is_baseline()
            && self.detector.distance.kind == DistanceKind::SquaredResidual
            && self.alarm_ticks().is_empty()
            && self.sensor.reads_position_exactly();
        let force_sensor = || ForceSensor::new(&self.sensor, self.grid.tick_s(), self.seed, first_stream);
        let reads_exactly = self.sensor.reads_force_exactly();
        Ok(match (self.replay().filter(|_| is_baseline), self.any_tissue()?) {
            (Some(operator), AnyTissue::Recording(tissue)) if reads_exactly => {
                Wired::Paper(self.baseline(plants, operator, tissue, PerfectSensor, link))
            }
            (Some(operator), AnyTissue::Recording(tissue)) => {
                Wired::NoisyRecording(self.baseline(plants, operator, tissue, force_sensor(), link))
            }
            (Some(operator), AnyTissue::Layers(tissue)) => {
                Wired::NoisyLayers(self.baseline(plants, operator, tissue, force_sensor(), link))
            }
            (Some(operator), AnyTissue::Depth(tissue)) if reads_exactly => {
                Wired::Depth(self.baseline(plants, operator, tissue, PerfectSensor, link))
            }
            (_, tissue) => Wired::AnyDirect(self.around(
                plants,
                self.person(first_stream)?,
                tissue,
                self.any_sensor(first_stream)?,
                link,
            )?),
        })
    }

    /// Parts with any built-in estimator and detector around two machines.
    fn around<L: Lane, P, O, T, S, K>(
        &self,
        plants: P,
        operator: O,
        tissue: T,
        sensor: S,
        link: K,
    ) -> Result<Engine<P, Parts<L, O, T, S, AnyEstimator<L>, AnyDetector<L>, K>>, ScenarioError> {
        let detector = CusumDetector::new(&self.detector, self.grid.tick_s());
        let detector = ScheduledAlarms::new(detector, self.alarm_ticks());
        let chain =
            Chain { contact_m: L::splat(self.contact_m), estimator: AnyEstimator::new(&self.estimator), detector };
        Ok(self.engine_of(plants, Parts { operator, tissue, sensor, chain, supervisor: self.supervisor(), link }))
    }

    /// Parts with the paper's estimator and detector around two machines.
    fn baseline<L: Lane, P, O, T, S, K>(
        &self,
        plants: P,
        operator: O,
        tissue: T,
        sensor: S,
        link: K,
    ) -> Engine<P, Parts<L, O, T, S, Rls<L>, CusumDetector<L, SquaredResidual<L>>, K>> {
        let distance = SquaredResidual::new();
        let detector = CusumDetector::with_distance(distance, &self.detector, self.grid.tick_s());
        let chain = Chain { contact_m: L::splat(self.contact_m), estimator: Rls::new(&self.estimator), detector };
        self.engine_of(plants, Parts { operator, tissue, sensor, chain, supervisor: self.supervisor(), link })
    }

    fn engine_of<P, W>(&self, plants: P, parts: W) -> Engine<P, W> {
        Engine { grid: self.grid, plants, parts }
    }

    /// What the needle meets.
    fn any_tissue<L: Lane>(&self) -> Result<AnyTissue<L>, ScenarioError> {
        let start_m = self.position_scale() * self.start_m();
        let tissue = match &self.tissue {
            TissueSpec::Recording { force_n, rupture_ticks } => {
                Ok(AnyTissue::Recording(RecordedForce::new(force_n.clone(), rupture_ticks.clone())))
            }
            TissueSpec::Depth { curves, rupture_depths_m, presliding_m } => {
                let ruptures = rupture_depths_m.clone();
                DepthReplay::new(curves.clone(), ruptures, *presliding_m, start_m).map(AnyTissue::Depth)
            }
            TissueSpec::Model(settings) => settings.build(self.grid.tick_s(), start_m),
        };
        tissue.map_err(|error| self.values().out_of_range(&error))
    }

    fn any_sensor<L: Lane>(&self, first_stream: u64) -> Result<AnySensor<L>, ScenarioError> {
        let stream = (self.seed, first_stream);
        AnySensor::new(&self.sensor, self.grid.tick_s(), stream).map_err(|error| self.values().out_of_range(&error))
    }

    fn supervisor<L: Lane>(&self) -> Supervisor<L> {
        let reference_m = L::splat(self.position_scale() * self.start_m());
        Supervisor::new(&self.augmentation, self.detector.cusum.threshold, self.grid.tick_s(), reference_m)
    }

    /// The ticks of scheduled alarms. Without augmentation there is nothing that an alarm could begin.
    fn alarm_ticks(&self) -> Arc<[u64]> {
        if self.augmentation.enabled { self.events.clone() } else { Arc::default() }
    }

    /// The motion of a person who follows what is known beforehand, whatever they feel.
    fn replay(&self) -> Option<Replay> {
        match &self.operator {
            OperatorSpec::Recording(positions)
                if self.tremor.amplitude_m <= 0.0 && self.reflex.reflex == Reflex::None =>
            {
                Some(Replay(positions.clone()))
            }
            OperatorSpec::Recording(_) | OperatorSpec::Ramp { .. } | OperatorSpec::Hand(_) => None,
        }
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
    fn person<L: Lane>(&self, first_stream: u64) -> Result<Person<L>, ScenarioError> {
        let tick_s = self.grid.tick_s();
        let motion = match &self.operator {
            OperatorSpec::Recording(positions) => Motion::Recording(positions.clone()),
            OperatorSpec::Ramp { start_m, end_m, speed_m_per_s } => {
                let ramp = Ramp::new(*start_m, *end_m, *speed_m_per_s, tick_s);
                Motion::Ramp(ramp.map_err(|error| self.values().out_of_range(&error))?)
            }
            OperatorSpec::Hand(hand) => Motion::Hand(hand.clone()),
        };
        let mut person = Person::new(motion);
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
