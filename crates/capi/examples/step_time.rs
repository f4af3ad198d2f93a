//! Compares the time of a step through the C interface with Rust's controller, on the same samples in turn.
//!
//! ```sh
//! cargo run --release -p trocar-c --example step_time
//! ```
#![allow(unsafe_code, reason = "it calls the C interface")]

use std::f64::consts::TAU;
use std::hint::black_box;
use std::mem::size_of;
use std::process::ExitCode;
use std::time::Instant;

use trocar_c::{Command, Rig, Sample, Settings, Status, trocar_rig_init, trocar_rig_size, trocar_rig_step};
use trocar_core::rig::{self, HapticController};

/// Number of samples in a block, which fits into the first-level cache.
const BLOCK: usize = 200;
/// Number of blocks, each timed for Rust and for C.
const BLOCKS: usize = 50_000;

/// A needle that oscillates slowly in a Kelvin-Voigt tissue (300 N/m, 10 N·s/m), with a force error that the estimator
/// corrects.
fn sample(k: usize) -> rig::Sample {
    let (sine, cosine) = (TAU * k as f64 / BLOCK as f64).sin_cos();
    let (depth_m, velocity) = (0.02 + 1e-4 * sine, 3e-3 * cosine);
    rig::Sample {
        master_position_m: depth_m,
        slave_position_m: depth_m,
        slave_velocity_m_per_s: velocity,
        force_n: 300.0 * depth_m + 10.0 * velocity + 0.05 * sine,
    }
}

/// Returns the best and the median time per step of a block, in ns.
fn quantiles(mut times_s: Vec<f64>) -> [f64; 2] {
    times_s.sort_by(f64::total_cmp);
    [times_s[0], times_s[times_s.len() / 2]].map(|time_s| 1e9 * time_s / BLOCK as f64)
}

fn main() -> ExitCode {
    let Ok(mut controller) = HapticController::new(&rig::Settings::default()) else { return ExitCode::FAILURE };
    let mut memory = vec![0_u64; trocar_rig_size().div_ceil(8)];
    let mut rig: *mut Rig = std::ptr::null_mut();
    let settings = Settings::defaults();
    // SAFETY: the memory is aligned to 8 bytes and large enough; there is no error buffer.
    let status = unsafe {
        let size = 8 * memory.len();
        trocar_rig_init(memory.as_mut_ptr().cast(), size, &raw const settings, &raw mut rig, std::ptr::null_mut(), 0)
    };
    if status != Status::Ok {
        return ExitCode::FAILURE;
    }
    // Prevents inlining, as in a C program.
    let step: unsafe extern "C" fn(*mut Rig, *const Sample, *mut Command) -> Status = black_box(trocar_rig_step);
    let samples: Vec<rig::Sample> = (0..BLOCK).map(sample).collect();
    let in_c: Vec<Sample> = samples
        .iter()
        .map(|&sample| {
            let rig::Sample { master_position_m, slave_position_m, slave_velocity_m_per_s, force_n } = sample;
            let struct_size = size_of::<Sample>() as u64;
            Sample { struct_size, master_position_m, slave_position_m, slave_velocity_m_per_s, force_n }
        })
        .collect();
    let mut command = Command::from(controller.clone().step(&rig::Sample::MISSING));
    let (mut of_rust, mut of_c) = (vec![], vec![]);
    for _ in 0..BLOCKS {
        let start = Instant::now();
        for sample in &samples {
            black_box(controller.step(black_box(sample)));
        }
        of_rust.push(start.elapsed().as_secs_f64());
        let start = Instant::now();
        for sample in &in_c {
            // SAFETY: the rig is initialised; sample and command are valid.
            unsafe { step(rig, black_box(sample), &raw mut command) };
            black_box(&command);
        }
        of_c.push(start.elapsed().as_secs_f64());
    }
    let (rust, c) = (quantiles(of_rust), quantiles(of_c));
    println!("ns per step          best  median");
    println!("Rust's controller   {:5.1} {:7.1}", rust[0], rust[1]);
    println!("through C           {:5.1} {:7.1}", c[0], c[1]);
    println!("difference          {:5.1} {:7.1}", c[0] - rust[0], c[1] - rust[1]);
    ExitCode::SUCCESS
}
