//! The instruction set, chosen at run time.
//!
//! The same source is compiled once for the baseline and once for wider registers. All give the same bits: no fused
//! multiply-add is enabled, and sums keep their order.

use super::{Engine, IntegrationError, Observer, Plants};
use crate::lane::Lane;

/// Runs the engine in the widest instruction set that the machine has.
#[allow(unsafe_code, reason = "calling a function that is compiled for an instruction set")]
pub(super) fn run<L: Lane, S: Plants<L>, O: Observer<L>>(
    engine: &mut Engine<L, S>,
    observer: &mut O,
) -> Result<(), IntegrationError> {
    #[cfg(target_arch = "x86_64")]
    if S::IS_VECTOR && std::arch::is_x86_feature_detected!("avx2") {
        // SAFETY: the machine has the instructions that the function is compiled for, as was just asked.
        return unsafe { run_avx2(engine, observer) };
    }
    // Every x86-64 of the last ten years has gone the other way.
    engine.run_ticks::<{ cfg!(not(target_arch = "x86_64")) }, _>(observer)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn run_avx2<L: Lane, S: Plants<L>, O: Observer<L>>(
    engine: &mut Engine<L, S>,
    observer: &mut O,
) -> Result<(), IntegrationError> {
    engine.run_ticks::<true, _>(observer)
}
