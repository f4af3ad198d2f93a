//! Compares the bounds of random certificates of events with a greedy adversary, and their statement with the engine.
//!
//! ```text
//! cargo run --release --example certified -- 2000
//! ```
//! Each case is `layers/skin-augmented`, with ruptures, and random scale factors, delays up to 50 ms, force laws, holds,
//! ways to re-engage and times. If its certificate states that every motion decays, the adversary chooses events,
//! springs, dampers and additional forces, and no motion may exceed the bounds of the certificate. The engine runs the
//! scenario too, and the run may neither diverge nor end in a swing. Fails if any of this occurs.

use std::process::ExitCode;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use trocar::metrics::Outcome;
use trocar::run::run;
use trocar::scenario::{Scenario, Source};
use trocar::stability::{Peaks, SwitchingSettings, adversary};
use trocar::stability_check::linear_loop;

/// Sequences of the adversary per case, and events of each.
const SEQUENCES: (u64, usize) = (2, 3);

/// One case whose certificate was found.
#[derive(Debug, Clone)]
pub struct Certified {
    /// The drawn settings.
    pub settings: Vec<String>,
    /// The motions of needle and hand that the adversary found, over their bounds.
    pub shares: [f64; 2],
    /// The outcome of the run.
    pub outcome: Outcome,
}

impl Certified {
    /// True if the motions and the run agree with the statement.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.shares.iter().all(|share| *share <= 1.0) && self.outcome == Outcome::Completed
    }
}

fn drawn(case: u64) -> Vec<String> {
    let mut rng = ChaCha8Rng::seed_from_u64(60);
    rng.set_stream(case);
    let mut between = |low: f64, high: f64| low + (high - low) * rng.random::<f64>();
    let tick_s = [0.001, 0.002, 0.005][between(0.0, 3.0) as usize];
    // Both ways together have at most 24 ticks.
    let most = f64::min(12.0, 0.05 / tick_s);
    let mut delay_s = || if between(0.0, 1.0) < 0.5 { 0.0 } else { between(0.0, most).floor() * tick_s };
    let (forward_s, backward_s) = (delay_s(), delay_s());
    let law = [
        format!("decay_time_constant_s={}", between(0.01, 0.1)),
        format!("amplification={}", between(1.0, 4.0)),
        format!("damp_damping_n_s_per_m={}", between(0.0, 100.0)),
    ];
    let (laws, at) = (["decay", "amplify", "damp"], between(0.0, 3.0) as usize);
    // Added damping is covered without a freeze.
    let hold = if laws[at] == "damp" || between(0.0, 1.0) < 0.3 { "none" } else { "freeze" };
    let mut settings = vec![
        format!("simulation.tick_s={tick_s}"),
        format!("channel.forward_delay_s={forward_s}"),
        format!("channel.backward_delay_s={backward_s}"),
        format!("scaling.force={}", between(0.5, 2.0)),
        format!("augmentation.force_law={}", laws[at]),
        format!("augmentation.{}", law[at]),
        format!("augmentation.hold={hold}"),
        format!("augmentation.blend_s={}", between(0.0, 0.2)),
        format!("augmentation.refractory_s={}", between(0.1, 0.5)),
    ];
    let shortest_s = between(0.05, 0.5);
    settings.push(format!("augmentation.min_hold_s={shortest_s}"));
    settings.push(format!("augmentation.max_hold_s={}", shortest_s + between(0.0, 0.5)));
    if hold == "freeze" {
        settings.push(format!("augmentation.reengage={}", ["ramp", "snap"][between(0.0, 2.0) as usize]));
    }
    settings
}

/// Certifies a case and compares the certificate. `None` if no certificate was found.
///
/// # Errors
/// If the case cannot be loaded, analysed or run.
pub fn compare(case: u64) -> Result<Option<Certified>, Box<dyn std::error::Error + Send + Sync>> {
    let settings = drawn(case);
    let scenario = Scenario::load(&Source::parse("builtin:layers/skin-augmented.toml"), &settings)?;
    let of_loop = linear_loop(&scenario)?;
    let range = of_loop.tissue.sector_n_per_m();
    let Ok(events) = SwitchingSettings::of(&scenario, of_loop, range) else { return Ok(None) };
    let Some(peaks) = Peaks::of(&events)? else { return Ok(None) };
    let [needle, hand] = adversary(&events, SEQUENCES, case)?;
    let shares = [needle / peaks.needle_m_per_n, hand / peaks.hand_m_per_n];
    Ok(Some(Certified { settings, shares, outcome: run(scenario)?.metrics.outcome }))
}

fn main() -> ExitCode {
    let wanted: u64 = std::env::args().nth(1).and_then(|text| text.parse().ok()).unwrap_or(2000);
    let (mut drawn, mut certified, mut broken) = (0, 0, 0);
    let mut largest: f64 = 0.0;
    while certified < wanted {
        let cases: Vec<_> = (drawn..drawn + 16).into_par_iter().map(compare).collect();
        drawn += 16;
        for case in cases {
            match case {
                Ok(Some(found)) => {
                    certified += 1;
                    largest = found.shares.iter().copied().fold(largest, f64::max);
                    if !found.holds() {
                        broken += 1;
                        println!("broken: {:?} {:?} {:?}", found.settings, found.shares, found.outcome);
                    }
                }
                Ok(None) => {}
                Err(error) => {
                    println!("error: {error}");
                    return ExitCode::FAILURE;
                }
            }
        }
        println!("{drawn} drawn, {certified} certified, {broken} broken; largest share of a bound {largest:.3}");
    }
    if broken == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
