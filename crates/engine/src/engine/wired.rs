use super::{Engine, EngineError, Observer, Parts, Plants, ScheduledAlarms, Wiring, instruction_set};
use crate::operator::{HumanOperator, Replay};
use crate::sensor::{AnySensor, ForceSensor, NoiseBank, PerfectSensor};
use crate::teleoperation::{DirectLink, Link, LinkReport};
use crate::tissue::{AnyTissue, DepthReplay, Layers, RecordedForce};
use trocar_core::detector::{CusumDetector, SquaredResidual};
use trocar_core::estimation::{AnyEstimator, Rls};
use trocar_core::lane::{LANES, Lane, of_one_variant};

pub type AnyDetector<L> = ScheduledAlarms<CusumDetector<L>>;
pub type AnyChain<L, O, T, S, K> = Parts<L, O, T, S, AnyEstimator<L>, AnyDetector<L>, K>;
pub type PaperChain<L, O, T, S, K> = Parts<L, O, T, S, Rls<L>, CusumDetector<L, SquaredResidual<L>>, K>;
pub type Any<L> = AnyChain<L, HumanOperator<L>, AnyTissue<L>, AnySensor<L>, Link<L>>;

/// Fewer branches on the kind of a part make a tick faster.
#[derive(Debug, Clone)]
#[expect(clippy::type_complexity, reason = "each variant names the parts for which the engine is compiled")]
pub enum Wired<L: Lane, P> {
    /// Recorded hand and force, a direct link, ideal sensors.
    Paper(Engine<P, PaperChain<L, Replay, RecordedForce, PerfectSensor, DirectLink<L>>>),
    NoisyRecording(Engine<P, PaperChain<L, Replay, RecordedForce, ForceSensor<L>, DirectLink<L>>>),
    /// With a non-ideal force sensor and any built-in distance.
    NoisyLayers(Engine<P, Parts<L, Replay, Layers<L>, ForceSensor<L>, Rls<L>, CusumDetector<L>, DirectLink<L>>>),
    Depth(Engine<P, PaperChain<L, Replay, DepthReplay<L>, PerfectSensor, DirectLink<L>>>),
    AnyDirect(Engine<P, AnyChain<L, HumanOperator<L>, AnyTissue<L>, AnySensor<L>, DirectLink<L>>>),
    Any(Engine<P, Any<L>>),
}

trocar_core::variants!(each of Wired { Paper, NoisyRecording, NoisyLayers, Depth, AnyDirect, Any });

impl<L: Lane, P: Plants<L>> Wired<L, P> {
    pub fn run(&mut self, observer: &mut dyn Observer<L>) -> Result<(), EngineError> {
        each!(self, engine => instruction_set::run_portably(engine, observer))
    }

    /// Wider registers are faster, for one more copy of the tick per wiring.
    pub fn run_compiled<O: Observer<L>>(&mut self, observer: &mut O) -> Result<(), EngineError> {
        each!(self, engine => instruction_set::run(engine, observer))
    }

    pub fn run_wide<O: Observer<L>>(&mut self, observer: &mut O) -> Result<(), EngineError>
    where
        L: instruction_set::Wide,
    {
        each!(self, engine => L::run(engine, observer))
    }

    pub fn link_report(&self, index: usize) -> Option<LinkReport> {
        each!(self, engine => engine.parts.link_report(index))
    }

    pub fn share_noise(&mut self, bank: &mut NoiseBank) {
        each!(self, engine => engine.parts.share_noise(bank, engine.grid.ticks()));
    }
}

impl<P> Wired<f64, P> {
    pub fn gather<L: Lane, Q>(
        all: [&Self; LANES],
        plants: impl FnOnce([&P; LANES]) -> Option<Q>,
    ) -> Option<Wired<L, Q>> {
        of_one_variant!(all, Wired { Paper, NoisyRecording, NoisyLayers, Depth, AnyDirect, Any }, |engines| {
            super::gather(engines, plants)
        })
    }
}
