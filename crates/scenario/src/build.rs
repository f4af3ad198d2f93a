use std::borrow::Cow;
use std::sync::Arc;

use super::engine_kind::EngineKind;
use super::error::ScenarioError;
use super::resolve::DelayTicks;
use super::scenario::Scenario;
use super::specs::{OperatorSpec, TissueSpec};
use super::steps::Steps;
use trocar_core::error::positive;
use trocar_core::lane::Lane;
use trocar_engine::channel::{Irregularity, MAX_DELAY_TICKS, Schedule};
use trocar_engine::engine::{
    Any, BuiltInOr, ControlledMaster, Engine, EngineError, ExactPlants, FractionalDelayPlants, GeneralPlants,
    GeneralSlave, IntegratedPlants, LimitedPlants, MasterPlants, MasterSide, Observer, Plants, SideEngine, SlaveSide,
    UserDefinedEngine, UserDefinedParts, Wired, Wiring,
};
use trocar_engine::plant::{GeneralMaster, MasterStep, PlantError, SlaveParameters, SlaveStep};
use trocar_engine::sensor::AnySensor;
use trocar_engine::teleoperation::LinkReport;
use trocar_engine::tissue::AnyTissue;

#[derive(Debug, Clone)]
pub enum ScenarioEngine {
    Exact(Box<Wired<f64, ExactPlants<f64>>>),
    /// Exact steps, with motors that saturate.
    Limited(Box<Engine<LimitedPlants<f64>, Any<f64>>>),
    /// Exact steps, with samples that arrive between ticks.
    Split(Box<Engine<FractionalDelayPlants<f64>, Any<f64>>>),
    Integrated(Box<Engine<IntegratedPlants, Any<f64>>>),
    /// A master or slave other than the appendix'.
    General(Box<Engine<GeneralPlants, Any<f64>>>),
}

impl ScenarioEngine {
    pub fn run(&mut self, mut observer: &mut dyn Observer<f64>) -> Result<(), EngineError> {
        match self {
            Self::Exact(engine) => engine.run(observer),
            Self::Limited(engine) => engine.run(&mut observer),
            Self::Split(engine) => engine.run(&mut observer),
            Self::Integrated(engine) => engine.run(&mut observer),
            Self::General(engine) => engine.run(&mut observer),
        }
    }

    /// Like [`ScenarioEngine::run`], with the exact engine compiled for its observer and the processor's registers. For
    /// the other engines this gain is small compared with their ticks.
    pub fn run_compiled<O: Observer<f64>>(&mut self, observer: &mut O) -> Result<(), EngineError> {
        match self {
            Self::Exact(engine) => engine.run_compiled(observer),
            Self::Limited(_) | Self::Split(_) | Self::Integrated(_) | Self::General(_) => self.run(observer),
        }
    }

    /// `None` for a direct link.
    pub fn link_report(&self) -> Option<LinkReport> {
        match self {
            Self::Exact(engine) => engine.link_report(0),
            Self::Limited(engine) => engine.parts.link_report(0),
            Self::Split(engine) => engine.parts.link_report(0),
            Self::Integrated(engine) => engine.parts.link_report(0),
            Self::General(engine) => engine.parts.link_report(0),
        }
    }
}

impl Scenario {
    /// Builds the engine at tick 0.
    pub fn build(&self) -> Result<ScenarioEngine, ScenarioError> {
        if self.has_general_machine() {
            return Ok(ScenarioEngine::General(Box::new(self.general(self.general_plants()?, 0)?)));
        }
        Ok(match self.engine {
            EngineKind::Exact if self.is_split() => ScenarioEngine::Split(Box::new(self.split_engine(0)?)),
            EngineKind::Exact if self.actuators.are_none() => ScenarioEngine::Exact(Box::new(self.exact_engine(0)?)),
            EngineKind::Exact => ScenarioEngine::Limited(Box::new(self.limited_engine(0)?)),
            EngineKind::Dop853 => ScenarioEngine::Integrated(Box::new(self.general(self.integrated_plants(), 0)?)),
        })
    }

    /// Does not build an engine.
    pub(super) fn check_parts(&self) -> Result<(), ScenarioError> {
        let (tick_s, reference_m) = (self.grid.tick_s(), self.slave_start_m());
        let invalid = |error| self.values().out_of_range(&error);
        self.whole_steps().map_err(|error| self.unbuildable(&error))?;
        if self.has_general_machine() {
            self.general_plants()?;
        } else if self.is_split() {
            self.split_plants::<f64>()?;
        } else if !self.actuators.are_none() {
            self.limited_plants::<f64>()?;
        }
        self.link.check(tick_s).map_err(invalid)?;
        match &self.tissue {
            TissueSpec::Model(settings) => settings.check(tick_s, reference_m).map_err(invalid)?,
            TissueSpec::Depth { presliding_m, .. } => {
                positive("tissue.presliding_m", *presliding_m).map(drop).map_err(invalid)?
            }
            TissueSpec::Recording { .. } => {}
        }
        self.master_reading::<f64>()?;
        AnySensor::<f64>::new(&self.sensor, tick_s, (self.seed, 0)).map(drop).map_err(invalid)
    }

    pub fn build_with(&self, parts: UserDefinedParts) -> Result<UserDefinedEngine, ScenarioError> {
        if parts.tissue.is_some() && self.organ_motion.moves() {
            let message = "the motion of the organs does not act on a user-defined tissue";
            let place = self.values().section_place("tissue");
            let remedy = "set tissue.breathing_amplitude_m = 0 and tissue.heartbeat_amplitude_m = 0, and move the tissue in its own code";
            return Err(ScenarioError::new(message).at(place).remedy(remedy));
        }
        let plants = match self.engine {
            _ if self.has_general_machine() => BuiltInOr::UserDefined(Box::new(self.general_plants()?) as Box<_>),
            EngineKind::Exact if self.is_split() => BuiltInOr::UserDefined(Box::new(self.split_plants()?) as Box<_>),
            EngineKind::Exact if self.actuators.are_none() => BuiltInOr::BuiltIn(self.exact_plants()?),
            EngineKind::Exact => BuiltInOr::UserDefined(Box::new(self.limited_plants()?) as Box<_>),
            EngineKind::Dop853 => BuiltInOr::UserDefined(Box::new(self.integrated_plants()) as Box<_>),
        };
        Ok(Engine { grid: self.grid, plants, parts: self.user_defined_wiring(parts)? })
    }

    /// Builds only the tissue, before its first tick.
    pub fn tissue_part(&self) -> Result<AnyTissue<f64>, ScenarioError> {
        self.any_tissue()
    }

    /// The delays of the scenario's link have no effect, because messages arrive in real time. A message counts as
    /// missing after the longest delay.
    pub fn master_side(&self) -> Result<MasterSide, ScenarioError> {
        let (_, initial) = self.initial_samples();
        Ok(MasterSide::new(self.side_engine()?, initial))
    }

    /// Like [`Scenario::master_side`].
    pub fn slave_side(&self) -> Result<SlaveSide, ScenarioError> {
        let (initial, _) = self.initial_samples();
        Ok(SlaveSide::new(self.side_engine()?, initial))
    }

    /// A link with delayed messages, and independent machines.
    fn side_engine(&self) -> Result<SideEngine, ScenarioError> {
        if self.engine == EngineKind::Dop853 {
            let message = "the sides cannot be stepped apart by dop853, which integrates both machines together";
            let error = ScenarioError::new(message).at(self.values().place("simulation.engine"));
            return Err(error.remedy(format!("use simulation.engine = \"{}\"", EngineKind::Exact.word())));
        }
        let mut apart = self.clone();
        let [forward, backward] = self.longest_delays_ticks();
        let whole = DelayTicks { whole: 0, share: 0.0 };
        (apart.forward, apart.backward) = (whole, whole);
        apart.irregularity = Irregularity::DEFAULT;
        let delayed = |ticks: u64| Schedule::new([ticks.min(MAX_DELAY_TICKS) as u32].into(), Arc::default());
        (apart.forward_schedule, apart.backward_schedule) = (delayed(forward), delayed(backward));
        let plants: Box<dyn Plants<f64> + Send> = if self.has_general_machine() {
            Box::new(apart.general_plants()?)
        } else if self.actuators.are_none() {
            Box::new(apart.exact_plants()?)
        } else {
            Box::new(apart.limited_plants()?)
        };
        apart.general(plants, 0)
    }

    /// The exact engine over lanes that all run this scenario. Lane `i` has the noise of stream `first_stream + i`.
    ///
    /// # Errors
    /// A scenario with actuator limits needs [`Scenario::limited_engine`]; delays that are not whole ticks need
    /// [`Scenario::split_engine`].
    pub fn exact_engine<L: Lane>(&self, first_stream: u64) -> Result<Wired<L, ExactPlants<L>>, ScenarioError> {
        if !self.actuators.are_none() {
            return Err(ScenarioError::new("this engine does not support actuator limits")
                .at(self.values().section_place("actuator")));
        }
        if self.is_split() {
            let message = "this engine does not support samples that arrive between ticks";
            return Err(ScenarioError::new(message).at(self.values().section_place("channel")));
        }
        self.wired(self.exact_plants()?, first_stream)
    }

    /// Like [`Scenario::exact_engine`], compiled for any parts.
    pub fn general_engine<L: Lane>(&self, first_stream: u64) -> Result<Engine<ExactPlants<L>, Any<L>>, ScenarioError> {
        self.general(self.exact_plants()?, first_stream)
    }

    pub(super) fn is_split(&self) -> bool {
        self.forward.share > 0.0 || self.backward.share > 0.0
    }

    /// Like [`Scenario::exact_engine`], with samples that arrive between ticks.
    pub fn split_engine<L: Lane>(
        &self,
        first_stream: u64,
    ) -> Result<Engine<FractionalDelayPlants<L>, Any<L>>, ScenarioError> {
        self.general(self.split_plants()?, first_stream)
    }

    fn split_plants<L: Lane>(&self) -> Result<FractionalDelayPlants<L>, ScenarioError> {
        let tick_s = self.grid.tick_s();
        let plant = |error| self.unbuildable(&error);
        let rest_s = |delay: DelayTicks| (1.0 - delay.share) * tick_s;
        let master = MasterStep::new(&self.master, &self.arm, self.timing, rest_s(self.backward)).map_err(plant)?;
        let slave = SlaveStep::new(&self.slave, self.timing, rest_s(self.forward)).map_err(plant)?;
        let reference_m = self.slave_start_m();
        Ok(FractionalDelayPlants::new(self.exact_plants()?, &master, &slave, reference_m))
    }

    /// Over a whole tick, computed once per set of parameters.
    pub(super) fn whole_steps(&self) -> Result<(Cow<'_, MasterStep>, Cow<'_, SlaveStep>), PlantError> {
        let (parameters, tick_s) = ((&self.master, &self.arm, &self.slave), self.grid.tick_s());
        if let Some(stored) = self.steps.get().filter(|stored| stored.are_of(parameters, self.timing, tick_s)) {
            return Ok((Cow::Borrowed(&stored.master), Cow::Borrowed(&stored.slave)));
        }
        let built = Steps::new(parameters, self.timing, tick_s)?;
        let steps = (Cow::Owned(built.master.clone()), Cow::Owned(built.slave.clone()));
        // Another thread may have stored the same steps first.
        let _ = self.steps.set(built);
        Ok(steps)
    }

    fn exact_plants<L: Lane>(&self) -> Result<ExactPlants<L>, ScenarioError> {
        self.require_appendix()?;
        self.plants_of_appendix()
    }

    fn require_appendix(&self) -> Result<(), ScenarioError> {
        if self.has_general_machine() {
            let message = "this engine supports the appendix' machines only";
            let side = if self.slave.is_general() { "slave" } else { "master" };
            return Err(ScenarioError::new(message).at(self.values().section_place(side)));
        }
        Ok(())
    }

    fn plants_of_appendix<L: Lane>(&self) -> Result<ExactPlants<L>, ScenarioError> {
        let start_m = self.start_m();
        let (master, slave) = self.whole_steps().map_err(|error| self.unbuildable(&error))?;
        Ok(ExactPlants::new(&master, &slave, start_m, self.slave_start_m()))
    }

    /// Like [`Scenario::exact_engine`], with sampled controllers and the scenario's actuator limits.
    pub fn limited_engine<L: Lane>(
        &self,
        first_stream: u64,
    ) -> Result<Engine<LimitedPlants<L>, Any<L>>, ScenarioError> {
        self.require_appendix()?;
        self.general(self.limited_plants()?, first_stream)
    }

    fn limited_plants<L: Lane>(&self) -> Result<LimitedPlants<L>, ScenarioError> {
        let machines = (&self.master, &self.arm, &self.slave);
        let (start_m, reference_m) = (self.start_m(), self.slave_start_m());
        let plants = LimitedPlants::new(machines, &self.actuators, self.grid.tick_s(), start_m, reference_m);
        plants.map_err(|error| self.unbuildable(&error))
    }

    /// The side of an appendix' master comes from plants with the appendix' slave, which is not used.
    fn general_plants(&self) -> Result<GeneralPlants, ScenarioError> {
        let plant = |error| self.unbuildable(&error);
        let (tick_s, start_m, reference_m) = (self.grid.tick_s(), self.start_m(), self.slave_start_m());
        let limits = &self.actuators;
        let slave = match self.engine {
            EngineKind::Exact => GeneralSlave::exact(&self.slave, limits, tick_s, reference_m),
            EngineKind::Dop853 => GeneralSlave::integrated(&self.slave, limits, tick_s, reference_m),
        };
        let master = if self.master_model.is_general() {
            let master = GeneralMaster { parameters: &self.master, model: &self.master_model, arm: &self.arm };
            let controlled = match self.engine {
                EngineKind::Exact => ControlledMaster::exact(&master, limits, tick_s, start_m),
                EngineKind::Dop853 => ControlledMaster::integrated(&master, limits, tick_s, start_m),
            };
            MasterPlants::General(Box::new(controlled.map_err(plant)?))
        } else {
            let beside = Self { slave: SlaveParameters::default(), ..self.clone() };
            match self.engine {
                EngineKind::Dop853 => MasterPlants::Integrated(Box::new(beside.integrated_plants())),
                EngineKind::Exact if limits.are_none() => MasterPlants::Exact(Box::new(self.plants_of_appendix()?)),
                EngineKind::Exact => MasterPlants::Limited(Box::new(beside.limited_plants()?)),
            }
        };
        Ok(GeneralPlants::new(master, slave.map_err(plant)?))
    }

    fn integrated_plants(&self) -> IntegratedPlants {
        let machines = (&self.master, &self.arm, &self.slave);
        let (start_m, reference_m) = (self.start_m(), self.slave_start_m());
        IntegratedPlants::new(machines, self.timing, self.grid.tick_s(), start_m, reference_m)
            .limited(&self.actuators)
            .split(self.backward.share, self.forward.share)
    }

    pub(super) fn unbuildable(&self, error: &PlantError) -> ScenarioError {
        if let Some((key, remedy)) = error.of_model() {
            let section = key.split_once('.').map_or("slave", |(section, _)| section);
            let place = self.values().place(&key).or_else(|| self.values().section_place(section));
            return ScenarioError::new(error.to_string()).at(place).remedy(remedy);
        }
        match error {
            PlantError::Parameter(invalid) => self.values().out_of_range(invalid),
            PlantError::SlaveDegree { .. } => {
                ScenarioError::new(error.to_string()).at(self.values().section_place("slave"))
            }
            PlantError::Improper { .. }
            | PlantError::VelocityJumps { .. }
            | PlantError::TooManyStates { .. }
            | PlantError::TooFewStates { .. }
            | PlantError::Size { .. }
            | PlantError::Unstable { .. }
            | PlantError::NoRest { .. } => ScenarioError::new(error.to_string()),
            PlantError::Build { side, .. } => ScenarioError::new(error.to_string())
                .at(self.values().section_place(side))
                .remedy(format!("check the values of [{side}]")),
        }
    }

    /// In m. Both plants start there at rest.
    pub(super) fn start_m(&self) -> f64 {
        match &self.operator {
            OperatorSpec::Recording(positions) => positions.first().copied().unwrap_or(0.0),
            OperatorSpec::Ramp { start_m, .. } => *start_m,
        }
    }
}
