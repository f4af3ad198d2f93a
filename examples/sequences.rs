//! Compares random sequences of events on the engine with the bounds of the certificate.
//!
//! ```text
//! cargo run --release --example sequences -- 1000000
//! ```
//! Nine of ten sequences last 0.24 s and have short events. One of ten lasts 2.5 s with the events of the shipped
//! scenario. The needle rests in a spring of 50 to 600 N/m, which moves by 1 µm to 10 mm as by a heartbeat. Fails if the
//! needle moves farther than the certificate allows for the force of this motion.

use std::process::ExitCode;

use trocar::scenario::Source;
use trocar::stability::{Switching, SwitchingSettings};
use trocar::stability_check::{linear_loop, random_sequences, without_alarms};

/// Range of the tissue stiffness, in N/m.
const TISSUE: (f64, f64) = (50.0, 600.0);

/// Short events, many of which fit into a short run.
const SHORT: [&str; 5] = [
    "augmentation.min_hold_s=0.02",
    "augmentation.max_hold_s=0.1",
    "augmentation.exit_quiet_s=0.0",
    "augmentation.blend_s=0.02",
    "augmentation.refractory_s=0.15",
];

/// Runs the sequences with these settings. Returns true if all stay within the bounds.
fn compare(settings: &[&str], count: u64, ticks: u64) -> Result<bool, Box<dyn std::error::Error>> {
    let tissue = ["tissue.stiffness_n_per_m=200", "tissue.damping_n_s_per_m=5"];
    let settings: Vec<String> = tissue.iter().chain(settings).map(|&setting| setting.to_owned()).collect();
    let source = Source::parse("builtin:paper/augmented.toml");
    let base = without_alarms(&source, &settings)?;
    let switching = Switching::of(&SwitchingSettings::of(&base, linear_loop(&base)?, TISSUE)?)?;
    let Some(peaks) = &switching.peaks else { return Ok(false) };
    let farthest = random_sequences(&base, (TISSUE, switching.phases), (count, ticks), 7)?;
    println!(
        "{count} sequences with {} events: the needle moves at most {:.4} mm/N, certified {:.4}",
        farthest.events,
        1e3 * farthest.needle_m_per_n,
        1e3 * peaks.needle_m_per_n,
    );
    Ok(farthest.needle_m_per_n <= peaks.needle_m_per_n)
}

fn main() -> Result<ExitCode, Box<dyn std::error::Error>> {
    let count: u64 = std::env::args().nth(1).and_then(|text| text.parse().ok()).unwrap_or(10_000);
    let long = count / 10;
    let holds = compare(&SHORT, count - long, 240)? & compare(&[], long, 2_500)?;
    Ok(if holds { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
