//! Identifies synthetic slaves, tissues, arms or masters with the noise and the encoder steps of a real rig, and prints how
//! often the 95 % intervals contain the truth, and the median errors:
//! `cargo run --release -p trocar-identify --example coverage [slave|tissue|arm|master] [COUNT]`.

mod parts;
mod slave;

use std::collections::BTreeMap;
use std::num::NonZero;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng as _, SeedableRng as _};

const INTERVAL_S: f64 = 5e-4;
const SAMPLES: usize = 12_000;

/// Steps of the simulation per sample.
const STEPS: usize = 200;

/// A step of the encoders of the rig in `tests/data/teleop_1dof`: 2π / 300,000 on a lever of 0.075 m.
const ENCODER_M: f64 = 1.57e-6;

/// Noise and ripple of its torque sensor.
const FORCE_NOISE_N: f64 = 0.02;
const RIPPLE_N: f64 = 0.05;

/// A uniform number from `low` to `high`.
fn uniform(random: &mut ChaCha8Rng, low: f64, high: f64) -> f64 {
    low + (high - low) * (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
}

/// Returns true values by their keys, with the value and the interval that were found for each.
type Found = Vec<(&'static str, f64, Option<(f64, [f64; 2])>)>;

fn main() -> Result<(), String> {
    let mut arguments = std::env::args().skip(1);
    let one = match arguments.next().as_deref() {
        None | Some("slave") => slave::slave,
        Some("tissue") => parts::tissue,
        Some("arm") => parts::arm,
        Some("master") => parts::master,
        Some(other) => return Err(format!("slave, tissue, arm or master, not {other}")),
    };
    let count = arguments.next().map_or(Ok(200), |text| text.parse());
    let count: u64 = count.map_err(|error| format!("the count: {error}"))?;
    let mut found: BTreeMap<&str, Vec<(bool, f64)>> = BTreeMap::new();
    for (seed, identified) in all(one, count) {
        let Some(identified) = identified else {
            println!("{seed} is not identified");
            continue;
        };
        for (key, truth, parameter) in identified {
            let Some((value, [low, high])) = parameter else { continue };
            let error = (value / truth - 1.0).abs();
            found.entry(key).or_default().push(((low..=high).contains(&truth), error));
        }
    }
    println!("{:<28}{:>8}{:>12}{:>16}", "parameter", "count", "covered", "median error");
    for (key, mut results) in found {
        results.sort_by(|a, b| a.1.total_cmp(&b.1));
        let covered = results.iter().filter(|(is_covered, _)| *is_covered).count();
        let (share, median) = (covered as f64 / results.len() as f64, results[results.len() / 2].1);
        println!("{key:<28}{:>8}{:>10.1} %{:>14.2} %", results.len(), 100.0 * share, 100.0 * median);
    }
    Ok(())
}

/// Identifies synthetic recordings with the seeds from 0 on, on all processors.
fn all(one: fn(&mut ChaCha8Rng) -> Option<Found>, count: u64) -> Vec<(u64, Option<Found>)> {
    let threads = std::thread::available_parallelism().map_or(1, NonZero::get) as u64;
    let of_thread = |thread: u64| -> Vec<(u64, Option<Found>)> {
        let seeds = (thread..count).step_by(threads as usize);
        seeds.map(|seed| (seed, one(&mut ChaCha8Rng::seed_from_u64(seed)))).collect()
    };
    let mut found: Vec<(u64, Option<Found>)> = std::thread::scope(|scope| {
        let running: Vec<_> = (0..threads).map(|thread| scope.spawn(move || of_thread(thread))).collect();
        running.into_iter().flat_map(|thread| thread.join().expect("a thread that ends")).collect()
    });
    found.sort_by_key(|(seed, _)| *seed);
    found
}
