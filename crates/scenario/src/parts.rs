//! Builds the parts around the plants of a scenario.

use std::sync::Arc;

use super::error::ScenarioError;
use super::resolve::DelayTicks;
use super::scenario::Scenario;
use super::specs::{OperatorSpec, TissueSpec};
use trocar_core::augmentation::{AnyForceLaw, HeldReference, Supervisor};
use trocar_core::chain::Chain;
use trocar_core::detector::{CusumDetector, DistanceKind, SquaredResidual};
use trocar_core::estimation::{AnyEstimator, Rls};
use trocar_core::lane::Lane;
use trocar_core::safety::CommandLimits;
use trocar_engine::channel::{Delay, Irregularity, Schedule};
use trocar_engine::engine::BuiltInOr::{BuiltIn, UserDefined};
use trocar_engine::engine::{
    Any, AnyDetector, Engine, Parts, ScheduledAlarms, UserDefinedParts, UserDefinedWiring, Wired,
};
use trocar_engine::operator::{HumanOperator, Motion, Ramp, Reflex, Replay};
use trocar_engine::sensor::{AnySensor, ForceSensor, PerfectSensor};
use trocar_engine::teleoperation::{DirectLink, Lines, Link, MasterReading, PAYLOAD};
use trocar_engine::tissue::{AnyTissue, DepthReplay, RecordedForce, Recording, StillTissue};

const FORWARD: u64 = 0x66_6f72_7761_7264;
const BACKWARD: u64 = 0x6261_636b_7761_7264;

struct Line<'a> {
    tick_s: f64,
    irregularity: &'a Irregularity,
}

impl Line<'_> {
    fn delay<L: Lane, const N: usize>(
        &self,
        initial: [L; N],
        (delay, schedule, random): (&DelayTicks, &Schedule, (u64, u64)),
    ) -> Delay<L, N> {
        Delay::new(delay.whole, initial).irregular(self.irregularity, schedule, self.tick_s, initial, random)
    }
}

impl Scenario {
    pub(super) fn general<L: Lane, P>(&self, plants: P, first_stream: u64) -> Result<Engine<P, Any<L>>, ScenarioError> {
        let link = self.link(first_stream)?;
        let parts = (self.operator(first_stream)?, self.any_tissue()?, self.any_sensor(first_stream)?);
        Ok(self.engine_of(plants, self.parts(parts, self.any_chain(), link)?))
    }

    pub(super) fn wired<L: Lane, P>(&self, plants: P, first_stream: u64) -> Result<Wired<L, P>, ScenarioError> {
        use AnyTissue::Still;
        let link: Link<L> = self.link(first_stream)?;
        if !link.is_direct() {
            return self.general(plants, first_stream).map(Wired::Any);
        }
        let machines = &self.link.machines;
        let link = DirectLink::new(machines.position_scale, machines.force_scale);
        let is_common = self.estimator.is_baseline()
            && self.alarm_ticks().is_empty()
            && self.sensor.reads_position_exactly()
            && !self.sensor.at_tip;
        let is_papers = self.detector.distance.kind == DistanceKind::SquaredResidual;
        let force_sensor = || ForceSensor::new(&self.sensor, self.grid.tick_s(), self.seed, first_stream);
        let reads_exactly = self.sensor.reads_force_exactly();
        Ok(match (self.replay().filter(|_| is_common), self.any_tissue()?) {
            (Some(operator), Still(StillTissue::Recording(Recording::Time(tissue)))) if is_papers && reads_exactly => {
                Wired::Paper(
                    self.engine_of(plants, self.parts((operator, tissue, PerfectSensor), self.paper_chain(), link)?),
                )
            }
            (Some(operator), Still(StillTissue::Recording(Recording::Time(tissue)))) if is_papers => {
                Wired::NoisyRecording(
                    self.engine_of(plants, self.parts((operator, tissue, force_sensor()), self.paper_chain(), link)?),
                )
            }
            (Some(operator), Still(StillTissue::Layers(tissue))) => Wired::NoisyLayers(
                self.engine_of(plants, self.parts((operator, tissue, force_sensor()), self.rls_chain(), link)?),
            ),
            (Some(operator), Still(StillTissue::Recording(Recording::Depth(tissue)))) if is_papers && reads_exactly => {
                Wired::Depth(
                    self.engine_of(plants, self.parts((operator, tissue, PerfectSensor), self.paper_chain(), link)?),
                )
            }
            (_, tissue) => {
                let parts = (self.operator(first_stream)?, tissue, self.any_sensor(first_stream)?);
                Wired::AnyDirect(self.engine_of(plants, self.parts(parts, self.any_chain(), link)?))
            }
        })
    }

    #[expect(clippy::type_complexity, reason = "one parameter per role")]
    fn parts<L: Lane, O, T, S, E, D, K>(
        &self,
        (operator, tissue, sensor): (O, T, S),
        chain: Chain<L, E, D>,
        link: K,
    ) -> Result<Parts<L, O, T, S, E, D, K>, ScenarioError> {
        let (supervisor, safety) = (self.supervisor(), self.command_limits());
        Ok(Parts { operator, tissue, sensor, chain, supervisor, link, safety, master_reading: self.master_reading()? })
    }

    fn command_limits<L: Lane>(&self) -> Option<CommandLimits<L>> {
        CommandLimits::in_simulation(&self.safety, self.grid.tick_s(), self.slave_start_m())
    }

    fn engine_of<P, W>(&self, plants: P, parts: W) -> Engine<P, W> {
        Engine { grid: self.grid, plants, parts }
    }

    fn any_chain<L: Lane>(&self) -> Chain<L, AnyEstimator<L>, AnyDetector<L>> {
        let detector = CusumDetector::new(&self.detector, self.grid.tick_s());
        let detector = ScheduledAlarms::new(detector, self.alarm_ticks());
        Chain { contact_m: L::splat(self.contact_m), estimator: AnyEstimator::new(&self.estimator), detector }
    }

    fn rls_chain<L: Lane>(&self) -> Chain<L, Rls<L>, CusumDetector<L>> {
        let detector = CusumDetector::new(&self.detector, self.grid.tick_s());
        Chain { contact_m: L::splat(self.contact_m), estimator: Rls::new(&self.estimator), detector }
    }

    fn paper_chain<L: Lane>(&self) -> Chain<L, Rls<L>, CusumDetector<L, SquaredResidual<L>>> {
        let distance = SquaredResidual::new();
        let detector = CusumDetector::with_distance(distance, &self.detector, self.grid.tick_s());
        Chain { contact_m: L::splat(self.contact_m), estimator: Rls::new(&self.estimator), detector }
    }

    pub(super) fn user_defined_wiring(&self, parts: UserDefinedParts) -> Result<UserDefinedWiring, ScenarioError> {
        let tick_s = self.grid.tick_s();
        let link = self.link(0)?;
        let link = match (parts.architecture, parts.scheme) {
            (None, None) if link.is_direct() => {
                let machines = &self.link.machines;
                BuiltIn(DirectLink::new(machines.position_scale, machines.force_scale))
            }
            (None, None) => UserDefined(Box::new(link) as Box<_>),
            (Some(architecture), None) => UserDefined(Box::new(link.with_architecture(architecture)) as Box<_>),
            (None, Some(scheme)) => UserDefined(Box::new(link.with_scheme(scheme)) as Box<_>),
            (Some(architecture), Some(scheme)) => {
                UserDefined(Box::new(link.with_architecture(architecture).with_scheme(scheme)) as Box<_>)
            }
        };
        let any = self.any_chain();
        let (settings, alarms) = (&self.detector, self.alarm_ticks());
        let detector = match (parts.detector, parts.distance) {
            (Some(detector), _) if alarms.is_empty() => UserDefined(detector),
            (Some(detector), _) => UserDefined(Box::new(ScheduledAlarms::new(detector, alarms)) as Box<_>),
            (None, Some(distance)) => {
                let detector = CusumDetector::with_distance(distance, settings, tick_s);
                UserDefined(Box::new(ScheduledAlarms::new(detector, alarms)) as Box<_>)
            }
            (None, None) => BuiltIn(any.detector),
        };
        let augmentation = &self.augmentation;
        let motion_law = parts.motion_law.map_or_else(
            || {
                let law = HeldReference::new(augmentation.freeze, augmentation.reengage, tick_s, self.reference_m());
                BuiltIn(law.holding(&augmentation.hold, tick_s))
            },
            UserDefined,
        );
        let force_law =
            parts.force_law.map_or_else(|| BuiltIn(AnyForceLaw::new(&augmentation.force, tick_s)), UserDefined);
        let estimator = parts.estimator.map_or(BuiltIn(any.estimator), UserDefined);
        Ok(Parts {
            operator: match parts.operator {
                Some(operator) => UserDefined(operator),
                None => BuiltIn(self.operator(0)?),
            },
            tissue: match parts.tissue {
                Some(tissue) => UserDefined(tissue),
                None => BuiltIn(self.any_tissue()?),
            },
            sensor: self.any_sensor(0)?,
            chain: Chain { contact_m: any.contact_m, estimator, detector },
            supervisor: Supervisor::with_laws(motion_law, force_law, augmentation, settings.cusum.threshold, tick_s),
            link,
            safety: self.command_limits(),
            master_reading: self.master_reading()?,
        })
    }

    /// The reference in m that the master's start gives.
    pub(super) fn reference_m(&self) -> f64 {
        self.position_scale() * self.start_m()
    }

    /// The reference in m of the slave at rest.
    pub(super) fn slave_start_m(&self) -> f64 {
        self.slave.start_m.unwrap_or_else(|| self.reference_m())
    }

    pub(super) fn master_reading<L: Lane>(&self) -> Result<Option<MasterReading<L>>, ScenarioError> {
        let acceleration = self.sensor.acceleration_std_m_per_s2;
        let at = (self.grid.tick_s(), self.start_m());
        let reading = MasterReading::new(&self.encoder, acceleration, &self.clutch, at);
        reading.map_err(|error| self.values().out_of_range(&error))
    }

    pub(super) fn any_tissue<L: Lane>(&self) -> Result<AnyTissue<L>, ScenarioError> {
        let start_m = self.slave_start_m();
        let tissue = match &self.tissue {
            TissueSpec::Recording { force_n, rupture_ticks } => {
                Ok(Recording::Time(RecordedForce::new(force_n.clone(), rupture_ticks.clone())).into())
            }
            TissueSpec::Depth { curves, rupture_depths_m, presliding_m } => {
                let ruptures = rupture_depths_m.clone();
                DepthReplay::new(curves.clone(), ruptures, *presliding_m, start_m)
                    .map(|tissue| Recording::Depth(tissue).into())
            }
            TissueSpec::Model(settings) => settings
                .build(self.grid.tick_s(), start_m)
                .and_then(|tissue| self.organ_motion.applied_to(tissue, self.grid.tick_s())),
        };
        tissue.map_err(|error| self.values().out_of_range(&error))
    }

    fn any_sensor<L: Lane>(&self, first_stream: u64) -> Result<AnySensor<L>, ScenarioError> {
        let stream = (self.seed, first_stream);
        AnySensor::new(&self.sensor, self.grid.tick_s(), stream).map_err(|error| self.values().out_of_range(&error))
    }

    fn supervisor<L: Lane>(&self) -> Supervisor<L> {
        let reference_m = L::splat(self.reference_m());
        Supervisor::new(&self.augmentation, self.detector.cusum.threshold, self.grid.tick_s(), reference_m)
    }

    /// None without augmentation.
    fn alarm_ticks(&self) -> Arc<[u64]> {
        if self.augmentation.enabled { self.events.clone() } else { Arc::default() }
    }

    fn replay(&self) -> Option<Replay> {
        match &self.operator {
            OperatorSpec::Recording(positions)
                if self.tremor.amplitude_m <= 0.0
                    && self.reflex.reflex == Reflex::None
                    && self.perception.settings().is_none()
                    && !self.stretch.acts()
                    && !self.stiffening.acts() =>
            {
                Some(Replay(positions.clone()))
            }
            OperatorSpec::Recording(_) | OperatorSpec::Ramp { .. } => None,
        }
    }

    pub(super) fn initial_samples(&self) -> ([f64; 4], [f64; 5]) {
        ([self.start_m(), 0.0, 0.0, 0.0], [0.0, self.slave_start_m(), 0.0, 0.0, 0.0])
    }

    /// The longest delays of samples that arrive, forward and backward, in ticks.
    pub fn longest_delays_ticks(&self) -> [u64; 2] {
        let line = Line { tick_s: self.grid.tick_s(), irregularity: &self.irregularity };
        let of = |delay, schedule| line.delay::<f64, 1>([0.0], (delay, schedule, (0, 0))).longest_ticks();
        [of(&self.forward, &self.forward_schedule), of(&self.backward, &self.backward_schedule)]
    }

    fn link<L: Lane>(&self, first_stream: u64) -> Result<Link<L>, ScenarioError> {
        let (tick_s, start_m, zero) = (self.grid.tick_s(), self.start_m(), L::zero());
        let (to_slave, to_master) = self.initial_samples();
        // A payload arrives with its sample.
        let line = Line { tick_s, irregularity: &self.irregularity };
        let forth = (&self.forward, &self.forward_schedule, (self.seed ^ FORWARD, first_stream));
        let back = (&self.backward, &self.backward_schedule, (self.seed ^ BACKWARD, first_stream));
        let lines = Lines {
            forward: line.delay(to_slave.map(L::splat), forth),
            backward: line.delay(to_master.map(L::splat), back),
            forward_payload: line.delay([zero; PAYLOAD], forth),
            backward_payload: line.delay([zero; PAYLOAD], back),
        };
        let (_, slave) = self.whole_steps().map_err(|error| self.unbuildable(&error))?;
        let link = Link::new(&self.link, lines, &slave, tick_s, start_m);
        let link = link.map_err(|error| self.values().out_of_range(&error))?;
        Ok(link.with_slave_at(self.slave_start_m()))
    }

    /// Lane `i` has the tremor and reaction times of stream `first_stream + i`.
    fn operator<L: Lane>(&self, first_stream: u64) -> Result<HumanOperator<L>, ScenarioError> {
        let tick_s = self.grid.tick_s();
        let motion = match &self.operator {
            OperatorSpec::Recording(positions) => Motion::Recording(positions.clone()),
            OperatorSpec::Ramp { start_m, end_m, speed_m_per_s } => {
                let ramp = Ramp::new(*start_m, *end_m, *speed_m_per_s, tick_s);
                Motion::Ramp(ramp.map_err(|error| self.values().out_of_range(&error))?)
            }
        };
        let mut operator = HumanOperator::new(motion);
        if self.tremor.amplitude_m > 0.0 {
            let ticks = self.grid.ticks() + 1;
            operator = operator.trembling(self.tremor.displacements(self.seed, first_stream, tick_s, ticks));
        }
        let operator = operator.tensing(&self.stretch, &self.stiffening, self.arm.static_stiffness_n_per_m(), tick_s);
        Ok(operator.reacting(&self.reflex, &self.perception, (self.seed, first_stream), tick_s))
    }
}
