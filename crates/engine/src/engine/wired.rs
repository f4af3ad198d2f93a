//! The combinations of parts for which the engine is compiled.

use super::{Engine, EngineError, Observer, Parts, Plants, ScheduledAlarms, Wiring, instruction_set};
use crate::operator::{HumanOperator, Replay};
use crate::sensor::{AnySensor, ForceSensor, NoiseBank, PerfectSensor};
use crate::teleoperation::{DirectLink, Link, LinkReport};
use crate::tissue::{AnyTissue, DepthReplay, Layers, RecordedForce};
use trocar_core::detection::{CusumDetector, SquaredResidual};
use trocar_core::estimation::{AnyEstimator, Rls};
use trocar_core::lane::{LANES, Lane, of_each};

/// Any built-in detector, with scheduled alarms.
pub type AnyDetector<L> = ScheduledAlarms<CusumDetector<L>>;
/// Any built-in estimator and detector with an operator, a tissue, a sensor and a link.
pub type AnyChain<L, O, T, S, K> = Parts<L, O, T, S, AnyEstimator<L>, AnyDetector<L>, K>;
/// The paper's estimator and detector with the same parts.
pub type PaperChain<L, O, T, S, K> = Parts<L, O, T, S, Rls<L>, CusumDetector<L, SquaredResidual<L>>, K>;
/// Any built-in part in each role.
pub type Any<L> = AnyChain<L, HumanOperator<L>, AnyTissue<L>, AnySensor<L>, Link<L>>;

/// Defines the enum of the wirings, one line each.
macro_rules! wirings {
    ($($(#[$doc:meta])* $Wiring:ident($Parts:ty),)*) => {
        /// An engine with parts known at compile time: those of the most frequent experiments, and all others.
        ///
        /// All give the same bits; a tick is faster with fewer branches on the kind of a part.
        #[derive(Debug, Clone)]
        pub enum Wired<L: Lane, P> {
            $($(#[$doc])* $Wiring(Engine<P, $Parts>),)*
        }

        impl<L: Lane, P: Plants<L>> Wired<L, P> {
            /// As [`Engine::run`], in the registers of every machine.
            ///
            /// # Errors
            /// As [`Engine::run`].
            pub fn run(&mut self, observer: &mut dyn Observer<L>) -> Result<(), EngineError> {
                match self {
                    $(Self::$Wiring(engine) => instruction_set::run_portably(engine, observer),)*
                }
            }

            /// [`Wired::run`], compiled for the observer and for wider registers, if the machine has them: identical bit
            /// for bit, faster, and longer to build by a copy of the tick for each wiring.
            ///
            /// # Errors
            /// As [`Engine::run`].
            pub fn run_compiled<O: Observer<L>>(&mut self, observer: &mut O) -> Result<(), EngineError> {
                match self {
                    $(Self::$Wiring(engine) => instruction_set::run(engine, observer),)*
                }
            }

            /// As [`Engine::run`], in the instruction set of the lanes.
            ///
            /// # Errors
            /// As [`Engine::run`].
            pub fn run_wide<O: Observer<L>>(&mut self, observer: &mut O) -> Result<(), EngineError>
            where
                L: instruction_set::Wide,
            {
                match self {
                    $(Self::$Wiring(engine) => L::run(engine, observer),)*
                }
            }

            /// As [`Wiring::link_report`].
            #[must_use]
            pub fn link_report(&self, index: usize) -> Option<LinkReport> {
                match self {
                    $(Self::$Wiring(engine) => engine.parts.link_report(index),)*
                }
            }

            /// Takes the run's noise from a bank, if it has it or has room. The numbers are the same as without a bank.
            pub fn share_noise(&mut self, bank: &mut NoiseBank) {
                match self {
                    $(Self::$Wiring(engine) => engine.parts.share_noise(bank, engine.grid.ticks()),)*
                }
            }
        }

        impl<P> Wired<f64, P> {
            /// Combines eight engines of one wiring into one, the first in lane 0; `None` if they differ in more than
            /// numbers. `plants` combines their machines.
            pub fn gather<L: Lane, Q>(
                all: [&Self; LANES],
                plants: impl FnOnce([&P; LANES]) -> Option<Q>,
            ) -> Option<Wired<L, Q>> {
                match all[0] {
                    $(Self::$Wiring(_) => {
                        let engines = of_each!(all, |one| {
                            let Self::$Wiring(engine) = one else { return None };
                            engine
                        });
                        super::gather(engines, plants).map(Wired::$Wiring)
                    })*
                }
            }
        }
    };
}

wirings! {
    /// The paper's experiment: recorded hand and force, a direct link, ideal sensors.
    Paper(PaperChain<L, Replay, RecordedForce, PerfectSensor, DirectLink<L>>),
    /// The same with a force sensor that is not ideal.
    NoisyRecording(PaperChain<L, Replay, RecordedForce, ForceSensor<L>, DirectLink<L>>),
    /// Layered tissue, with a force sensor that is not ideal and any built-in distance.
    NoisyLayers(Parts<L, Replay, Layers<L>, ForceSensor<L>, Rls<L>, CusumDetector<L>, DirectLink<L>>),
    /// A recording replayed by depth.
    Depth(PaperChain<L, Replay, DepthReplay<L>, PerfectSensor, DirectLink<L>>),
    /// Any parts with a direct link.
    AnyDirect(AnyChain<L, HumanOperator<L>, AnyTissue<L>, AnySensor<L>, DirectLink<L>>),
    /// Any parts.
    Any(Any<L>),
}
