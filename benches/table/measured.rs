//! The scenarios and instruction sets of several measurements.

use trocar::engine::InstructionSet;

/// The noise of the paper's force cell (4.1).
pub const NOISE: &str = "sensor.force_noise_std_n=0.025";

/// The scenarios of several measurements: name, file, and settings.
pub const MEASURED: [(&str, &str, &[&str]); 5] = [
    ("augmented", "augmented", &[]),
    ("augmented, noise", "augmented", &[NOISE]),
    ("classical", "classical", &[]),
    ("through the skin", "layers/through-the-skin", &[]),
    ("depth, augmented", "paper/depth-augmented", &[]),
];

pub fn available() -> impl Iterator<Item = InstructionSet> {
    InstructionSet::ALL.into_iter().filter(|set| set.is_available())
}

pub fn name_of(set: InstructionSet) -> &'static str {
    match set {
        InstructionSet::Avx512 => "AVX-512",
        InstructionSet::Avx2 => "AVX2",
        InstructionSet::Baseline if cfg!(target_arch = "x86_64") => "SSE2",
        InstructionSet::Baseline => "baseline",
    }
}
