//! The machine's peak rate of additions and multiplications, by instruction set.

use std::hint::black_box;

use trocar::engine::InstructionSet;

use crate::measured::available;
use crate::timing::{elapsed_s, time_ns};

/// Number of independent registers: enough to hide the latency, and few enough for 16 registers.
const CHAINS: usize = 12;
const ROUNDS: u64 = 20_000;

pub struct Peak {
    pub set: InstructionSet,
    /// Additions and multiplications per ns.
    pub operations_per_ns: f64,
}

/// Performs a multiplication and an addition on each of `CHAINS` registers, `ROUNDS` times. All numbers tend to 1.
macro_rules! rounds {
    ($($(#[$attribute:meta])* $name:ident, $Vector:ty, $splat:expr, $mul:expr, $add:expr;)*) => {$(
        $(#[$attribute])*
        fn $name() -> [$Vector; CHAINS] {
            let (factor, summand) = ($splat(black_box(0.999)), $splat(black_box(0.001)));
            let mut chains = [$splat(black_box(0.5)); CHAINS];
            for _ in 0..ROUNDS {
                for chain in &mut chains {
                    *chain = $add($mul(*chain, factor), summand);
                }
            }
            chains
        }
    )*};
}

#[cfg(target_arch = "x86_64")]
use std::arch::x86_64::{
    __m128d, __m256d, __m512d, _mm_add_pd, _mm_mul_pd, _mm_set1_pd, _mm256_add_pd, _mm256_mul_pd, _mm256_set1_pd,
    _mm512_add_pd, _mm512_mul_pd, _mm512_set1_pd,
};

#[cfg(target_arch = "x86_64")]
rounds! {
    #[target_feature(enable = "avx512f")]
    rounds_avx512, __m512d, _mm512_set1_pd, _mm512_mul_pd, _mm512_add_pd;
    #[target_feature(enable = "avx2")]
    rounds_avx2, __m256d, _mm256_set1_pd, _mm256_mul_pd, _mm256_add_pd;
    #[target_feature(enable = "sse2")]
    rounds_baseline, __m128d, _mm_set1_pd, _mm_mul_pd, _mm_add_pd;
}

#[cfg(not(target_arch = "x86_64"))]
rounds! {
    rounds_baseline, f64, f64::from, std::ops::Mul::mul, std::ops::Add::add;
}

/// Runs the rounds in an available instruction set. Returns the numbers per register.
#[allow(unsafe_code, unused_unsafe, reason = "calling functions that are compiled for an instruction set")]
fn run(set: InstructionSet) -> usize {
    assert!(set.is_available(), "{set:?}");
    match set {
        #[cfg(target_arch = "x86_64")]
        InstructionSet::Avx512 => {
            // SAFETY: the assertion above ensures that the machine has the instructions of the set.
            black_box(unsafe { rounds_avx512() });
            8
        }
        #[cfg(target_arch = "x86_64")]
        InstructionSet::Avx2 => {
            // SAFETY: as for AVX-512, by the assertion.
            black_box(unsafe { rounds_avx2() });
            4
        }
        _ => {
            // SAFETY: every machine has the instructions that the program is compiled for.
            let rounds = black_box(unsafe { rounds_baseline() });
            size_of_val(&rounds[0]) / size_of::<f64>()
        }
    }
}

pub fn measure() -> Vec<Peak> {
    let peak = |set| {
        let lanes = run(set);
        let operations = 2.0 * CHAINS as f64 * ROUNDS as f64 * lanes as f64;
        let cost = time_ns(operations, || {
            elapsed_s(|| {
                run(set);
            })
        });
        Peak { set, operations_per_ns: 1.0 / cost.best }
    };
    available().map(peak).collect()
}
