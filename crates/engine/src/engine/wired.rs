//! The combinations of parts for which the engine is compiled.

use super::{Engine, EngineError, Observer, Parts, Plants, ScheduledAlarms, Wiring, instruction_set};
use crate::operator::{HumanOperator, Replay};
use crate::sensor::{AnySensor, ForceSensor, NoiseBank, PerfectSensor};
use crate::teleoperation::{DirectLink, Link, LinkReport};
use crate::tissue::{AnyTissue, DepthReplay, Layers, RecordedForce};
use trocar_core::detector::{CusumDetector, SquaredResidual};
use trocar_core::estimation::{AnyEstimator, Rls};
use trocar_core::lane::{LANES, Lane, of_one_variant};

/// Any built-in detector, with scheduled alarms.
pub type AnyDetector<L> = ScheduledAlarms<CusumDetector<L>>;
/// Any built-in estimator and detector with an operator, a tissue, a sensor and a link.
pub type AnyChain<L, O, T, S, K> = Parts<L, O, T, S, AnyEstimator<L>, AnyDetector<L>, K>;
/// The paper's estimator and detector with the same parts.
pub type PaperChain<L, O, T, S, K> = Parts<L, O, T, S, Rls<L>, CusumDetector<L, SquaredResidual<L>>, K>;
/// Any built-in part in each role.
pub type Any<L> = AnyChain<L, HumanOperator<L>, AnyTissue<L>, AnySensor<L>, Link<L>>;

/// An engine with parts known at compile time: the most frequent combinations, and any parts.
///
/// All give the same bits. Fewer branches on the kind of a part make a tick faster.
#[derive(Debug, Clone)]
#[expect(clippy::type_complexity, reason = "each variant names the parts for which the engine is compiled")]
pub enum Wired<L: Lane, P> {
    /// The paper's experiment: recorded hand and force, a direct link, ideal sensors.
    Paper(Engine<P, PaperChain<L, Replay, RecordedForce, PerfectSensor, DirectLink<L>>>),
    /// The paper's experiment with a non-ideal force sensor.
    NoisyRecording(Engine<P, PaperChain<L, Replay, RecordedForce, ForceSensor<L>, DirectLink<L>>>),
    /// Layered tissue, with a non-ideal force sensor and any built-in distance.
    NoisyLayers(Engine<P, Parts<L, Replay, Layers<L>, ForceSensor<L>, Rls<L>, CusumDetector<L>, DirectLink<L>>>),
    /// A recording replayed by depth.
    Depth(Engine<P, PaperChain<L, Replay, DepthReplay<L>, PerfectSensor, DirectLink<L>>>),
    /// Any parts with a direct link.
    AnyDirect(Engine<P, AnyChain<L, HumanOperator<L>, AnyTissue<L>, AnySensor<L>, DirectLink<L>>>),
    /// Any parts.
    Any(Engine<P, Any<L>>),
}

trocar_core::variants!(each of Wired { Paper, NoisyRecording, NoisyLayers, Depth, AnyDirect, Any });

impl<L: Lane, P: Plants<L>> Wired<L, P> {
    /// [`Engine::run`] in the registers that every machine has.
    ///
    /// # Errors
    /// See [`Engine::run`].
    pub fn run(&mut self, observer: &mut dyn Observer<L>) -> Result<(), EngineError> {
        each!(self, engine => instruction_set::run_portably(engine, observer))
    }

    /// [`Wired::run`], compiled for the observer and, if available, for wider registers: the same bits, faster, for one
    /// more copy of the tick per wiring.
    ///
    /// # Errors
    /// See [`Engine::run`].
    pub fn run_compiled<O: Observer<L>>(&mut self, observer: &mut O) -> Result<(), EngineError> {
        each!(self, engine => instruction_set::run(engine, observer))
    }

    /// [`Engine::run`] in the instruction set of the lanes.
    ///
    /// # Errors
    /// See [`Engine::run`].
    pub fn run_wide<O: Observer<L>>(&mut self, observer: &mut O) -> Result<(), EngineError>
    where
        L: instruction_set::Wide,
    {
        each!(self, engine => L::run(engine, observer))
    }

    /// See [`Wiring::link_report`].
    #[must_use]
    pub fn link_report(&self, index: usize) -> Option<LinkReport> {
        each!(self, engine => engine.parts.link_report(index))
    }

    /// See [`Wiring::share_noise`].
    pub fn share_noise(&mut self, bank: &mut NoiseBank) {
        each!(self, engine => engine.parts.share_noise(bank, engine.grid.ticks()));
    }
}

impl<P> Wired<f64, P> {
    /// Combines eight engines of one wiring, the first in lane 0; `None` if they differ in more than numbers. `plants`
    /// combines their machines.
    pub fn gather<L: Lane, Q>(
        all: [&Self; LANES],
        plants: impl FnOnce([&P; LANES]) -> Option<Q>,
    ) -> Option<Wired<L, Q>> {
        of_one_variant!(all, Wired { Paper, NoisyRecording, NoisyLayers, Depth, AnyDirect, Any }, |engines| {
            super::gather(engines, plants)
        })
    }
}
