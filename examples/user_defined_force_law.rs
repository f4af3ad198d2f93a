//! A user-defined force law in a shipped scenario: while the slave is frozen, the force decreases linearly.
//!
//! `cargo run --release --example user_defined_force_law`

use trocar::augmentation::{AugmentedTick, ForceLaw};
use trocar::document::Study as _;
use trocar::engine::UserDefinedParts;
use trocar::run::{Run, RunReport, run_with};
use trocar::scenario::{Scenario, Source};

/// Decreases the force from its value before the alarm to 0 in equal steps.
struct LinearDecrease {
    ticks: f64,
}

impl ForceLaw<f64> for LinearDecrease {
    fn augmented(&mut self, now: &AugmentedTick<f64>) -> (f64, f64) {
        let step_n = now.anchor_n / self.ticks;
        let end = if now.anchor_n > 0.0 { (now.last_n - step_n).max(0.0) } else { (now.last_n - step_n).min(0.0) };
        (end, step_n.abs())
    }
}

/// Runs the paper's augmented insertion with the law: the force is 0 from 60 ms after the alarm.
pub fn run() -> Result<Run, Box<dyn std::error::Error>> {
    let scenario = Scenario::load(&Source::parse("paper/augmented"), &[])?;
    let ticks = (0.06 / scenario.grid.tick_s()).round();
    Ok(run_with(scenario, UserDefinedParts::default().force_law(LinearDecrease { ticks }))?)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let run = run()?;
    print!("{}", trocar::report::document_text(&RunReport::of(&run).document(), false));
    Ok(())
}
