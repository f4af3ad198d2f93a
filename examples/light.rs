//! A run with the light library, `trocar = { ..., default-features = false }`: `cargo run --release --example light`.

use trocar::run::measure;
use trocar::scenario::{Scenario, Source};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let settings = [("scaling.force", 0.8.into()), ("simulation.seed", 7.into())];
    let scenario = Scenario::load_with(&Source::parse("layers/skin-augmented"), &settings)?;
    let metrics = measure(&scenario)?;
    for rupture in &metrics.ruptures {
        println!("rupture at {} s, overshoot {:?} m", rupture.time_s, rupture.slave_overshoot_m);
    }
    Ok(())
}
