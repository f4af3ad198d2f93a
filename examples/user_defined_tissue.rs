//! A user-defined tissue in a shipped scenario: a standard linear solid, whose force relaxes at a constant depth.
//!
//! `cargo run --release --example user_defined_tissue`

use trocar::document::Study as _;
use trocar::engine::UserDefinedParts;
use trocar::run::{Run, RunReport, run_with};
use trocar::scenario::{Scenario, Source};
use trocar::tissue::{Reaction, Tissue};

/// A spring `K∞` parallel to a spring `K1` in series with a damper: `f = K∞ p + f1`, `f1' = K1 v - f1/τ`.
struct StandardLinearSolid {
    equilibrium_n_per_m: f64,
    relaxing_n_per_m: f64,
    /// `exp(-T/τ)` over a tick.
    decay: f64,
    contact_m: f64,
    depth_m: f64,
    relaxing_n: f64,
}

impl StandardLinearSolid {
    fn new((equilibrium_n_per_m, relaxing_n_per_m): (f64, f64), tau_s: f64, contact_m: f64, tick_s: f64) -> Self {
        let decay = (-tick_s / tau_s).exp();
        Self { equilibrium_n_per_m, relaxing_n_per_m, decay, contact_m, depth_m: 0.0, relaxing_n: 0.0 }
    }
}

impl Tissue<f64> for StandardLinearSolid {
    fn react(&mut self, _tick: u64, position_m: f64, _velocity_m_per_s: f64) -> Reaction<f64> {
        let depth_m = (position_m - self.contact_m).max(0.0);
        let moved_m = depth_m - std::mem::replace(&mut self.depth_m, depth_m);
        self.relaxing_n = self.decay * self.relaxing_n + self.relaxing_n_per_m * moved_m;
        let force_n = self.equilibrium_n_per_m * depth_m + self.relaxing_n;
        Reaction { force_n: if depth_m > 0.0 { force_n.max(0.0) } else { 0.0 }, ruptured: false }
    }
}

/// Runs the paper's insertion into the solid.
pub fn run() -> Result<Run, Box<dyn std::error::Error>> {
    let scenario = Scenario::load(&Source::parse("paper/classical"), &[])?;
    let tissue = StandardLinearSolid::new((150.0, 200.0), 0.5, 0.012, scenario.grid.tick_s());
    Ok(run_with(scenario, UserDefinedParts::default().tissue(tissue))?)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let run = run()?;
    print!("{}", trocar::report::document_text(&RunReport::of(&run).document(), false));
    Ok(())
}
