//! All give the same bits: no fused multiply-add, and sums keep their order.

#[cfg(target_arch = "x86_64")]
use super::{Avx2, Avx512};
use super::{Engine, EngineError, EventObserver, Observer, Plants, SelectedSignals, Wiring};
use trocar_core::lane::Lane;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InstructionSet {
    Avx512,
    Avx2,
    /// SSE2 on x86-64, without lanes, which would not be faster.
    Baseline,
}

impl InstructionSet {
    /// The widest first.
    pub const ALL: [Self; 3] = [Self::Avx512, Self::Avx2, Self::Baseline];

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

    pub fn widest() -> Self {
        Self::ALL.into_iter().find(|set| set.is_available()).unwrap_or(Self::Baseline)
    }
}

#[cfg_attr(target_arch = "x86_64", allow(unsafe_code, reason = "calls a function compiled for an instruction set"))]
pub(super) fn run<P: Plants<W::Lane>, W: Wiring, O: Observer<W::Lane>>(
    engine: &mut Engine<P, W>,
    observer: &mut O,
) -> Result<(), EngineError> {
    #[cfg(target_arch = "x86_64")]
    if InstructionSet::Avx2.is_available() {
        // SAFETY: the check above shows that the machine has the instructions of the function.
        return unsafe { run_avx2(engine, observer) };
    }
    run_portably(engine, observer)
}

#[inline(never)]
pub(super) fn run_portably<P: Plants<W::Lane>, W: Wiring>(
    engine: &mut Engine<P, W>,
    mut observer: &mut dyn Observer<W::Lane>,
) -> Result<(), EngineError> {
    engine.run_ticks(&mut observer)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn run_avx2<P: Plants<W::Lane>, W: Wiring, O: Observer<W::Lane>>(
    engine: &mut Engine<P, W>,
    observer: &mut O,
) -> Result<(), EngineError> {
    engine.run_ticks(observer)
}

pub trait Wide: Lane {
    fn run<P: Plants<Self>, W: Wiring<Lane = Self>, O: Observer<Self>>(
        engine: &mut Engine<P, W>,
        observer: &mut O,
    ) -> Result<(), EngineError>;

    fn observe<O: EventObserver<Self>>(observer: &mut O, signals: &SelectedSignals<Self>);
}

pub struct InSet<O>(pub O);

impl<L: Wide, O: EventObserver<L>> EventObserver<L> for InSet<O> {
    fn observe(&mut self, signals: &SelectedSignals<L>) {
        L::observe(&mut self.0, signals);
    }
}

#[cfg(target_arch = "x86_64")]
macro_rules! wide {
    ($($(#[$attribute:meta])* $Number:ident;)*) => {$(
        #[allow(unsafe_code, unused_unsafe, reason = "calls a function compiled for an instruction set")]
        const _: () = {
            impl Wide for $Number {
                fn run<P: Plants<Self>, W: Wiring<Lane = Self>, O: Observer<Self>>(
                    engine: &mut Engine<P, W>,
                    observer: &mut O,
                ) -> Result<(), EngineError> {
                    // SAFETY: such a number exists only if the machine has the instructions.
                    unsafe { run(engine, observer) }
                }

                fn observe<O: EventObserver<Self>>(observer: &mut O, signals: &SelectedSignals<Self>) {
                    // SAFETY: as above.
                    unsafe { observe(observer, signals) }
                }
            }

            $(#[$attribute])*
            fn run<P: Plants<$Number>, W: Wiring<Lane = $Number>, O: Observer<$Number>>(
                engine: &mut Engine<P, W>,
                observer: &mut O,
            ) -> Result<(), EngineError> {
                engine.run_ticks(observer)
            }

            $(#[$attribute])*
            fn observe<O: EventObserver<$Number>>(observer: &mut O, signals: &SelectedSignals<$Number>) {
                observer.observe(signals);
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
