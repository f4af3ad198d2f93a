//! Engines side by side, in the instruction set that is chosen when the program runs.

#[cfg(target_arch = "x86_64")]
use super::eight::{Avx2, Avx512};
use super::{Engine, IntegrationError, Observer, Plants};
use crate::lane::{Gather, LANES, Lane};

/// What several cases are computed with. All give the same bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InstructionSet {
    /// Eight side by side, eight numbers in a register.
    Avx512,
    /// Eight side by side, four numbers in a register.
    Avx2,
    /// One after the other, in what every machine has (SSE2 on x86-64): side by side would not be faster there.
    Baseline,
}

impl InstructionSet {
    /// Every one, the widest first.
    pub const ALL: [Self; 3] = [Self::Avx512, Self::Avx2, Self::Baseline];

    /// Whether this machine has it.
    #[must_use]
    pub fn is_available(self) -> bool {
        #[cfg(target_arch = "x86_64")]
        match self {
            Self::Avx512 => {
                std::arch::is_x86_feature_detected!("avx512f")
                    && std::arch::is_x86_feature_detected!("avx512vl")
                    && std::arch::is_x86_feature_detected!("avx512dq")
            }
            Self::Avx2 => std::arch::is_x86_feature_detected!("avx2"),
            Self::Baseline => true,
        }
        #[cfg(not(target_arch = "x86_64"))]
        {
            self == Self::Baseline
        }
    }

    /// The widest that this machine has.
    #[must_use]
    pub fn widest() -> Self {
        Self::ALL.into_iter().find(|set| set.is_available()).unwrap_or(Self::Baseline)
    }
}

/// Eight lanes of an instruction set.
pub(crate) trait Wide: Lane {
    /// [`Engine::run`] in this instruction set.
    ///
    /// # Errors
    /// As [`Engine::run`].
    fn run<S: Plants<Self>, O: Observer<Self>>(
        engine: &mut Engine<Self, S>,
        observer: &mut O,
    ) -> Result<(), IntegrationError>;
}

#[cfg(target_arch = "x86_64")]
macro_rules! wide {
    ($($(#[$attribute:meta])* $Number:ident;)*) => {$(
        #[allow(unsafe_code, unused_unsafe, reason = "calling a function that is compiled for an instruction set")]
        const _: () = {
            impl Wide for $Number {
                fn run<S: Plants<Self>, O: Observer<Self>>(
                    engine: &mut Engine<Self, S>,
                    observer: &mut O,
                ) -> Result<(), IntegrationError> {
                    // SAFETY: such a number exists only where the machine has been asked for its instructions.
                    unsafe { run(engine, observer) }
                }
            }

            $(#[$attribute])*
            fn run<S: Plants<$Number>, O: Observer<$Number>>(
                engine: &mut Engine<$Number, S>,
                observer: &mut O,
            ) -> Result<(), IntegrationError> {
                engine.run_ticks::<true, _>(observer)
            }
        };
    )*};
}

#[cfg(target_arch = "x86_64")]
wide! {
    #[target_feature(enable = "avx2")]
    Avx2;
    #[target_feature(enable = "avx512f,avx512vl,avx512dq")]
    Avx512;
}

/// Eight engines as one, the first in lane 0; nothing where they differ in more than numbers, or have begun. `plants` lays
/// their machines side by side.
pub(crate) fn gather<L: Lane, S, T>(
    all: [&Engine<f64, S>; LANES],
    plants: impl FnOnce([&S; LANES]) -> Option<T>,
) -> Option<Engine<L, T>> {
    let grid = all[0].grid;
    if all.iter().any(|one| one.grid != grid) {
        return None;
    }
    Some(Engine {
        grid,
        plants: plants(crate::lane::of_each!(all, |one| &one.plants))?,
        operator: Gather::gather(crate::lane::of_each!(all, |one| &one.operator))?,
        tissue: Gather::gather(crate::lane::of_each!(all, |one| &one.tissue))?,
        sensor: Gather::gather(crate::lane::of_each!(all, |one| &one.sensor))?,
        velocity_filter: Gather::gather(crate::lane::of_each!(all, |one| &one.velocity_filter))?,
        contact_m: Gather::gather(crate::lane::of_each!(all, |one| &one.contact_m))?,
        estimator: Gather::gather(crate::lane::of_each!(all, |one| &one.estimator))?,
        detector: Gather::gather(crate::lane::of_each!(all, |one| &one.detector))?,
        supervisor: Gather::gather(crate::lane::of_each!(all, |one| &one.supervisor))?,
        link: Gather::gather(crate::lane::of_each!(all, |one| &one.link))?,
        scheduled: all[0].scheduled.in_all(crate::lane::of_each!(all, |one| &one.scheduled))?,
    })
}
