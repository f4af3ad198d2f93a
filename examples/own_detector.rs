//! A detector of one's own in a shipped scenario: the force less its moving average, against a multiple of the noise.
//!
//! `cargo run --release --example own_detector`

use trocar::detection::{Decision, Detector, Evidence};
use trocar::engine::OwnParts;
use trocar::run::{Run, run_with};
use trocar::scenario::{Scenario, Source};

/// Announces a rupture where the force falls below its exponential moving average by more than a threshold, after some quiet
/// samples in contact.
struct FallDetector {
    weight: f64,
    threshold_n: f64,
    settle_samples: u32,
    average_n: f64,
    quiet_samples: u32,
}

impl FallDetector {
    fn new(threshold_n: f64) -> Self {
        Self { weight: 0.2, threshold_n, settle_samples: 100, average_n: 0.0, quiet_samples: 0 }
    }
}

impl Detector<f64> for FallDetector {
    fn update(&mut self, evidence: &Evidence<f64>) -> Decision<f64> {
        let fall_n = (self.average_n - evidence.force_n).max(0.0);
        self.average_n += self.weight * (evidence.force_n - self.average_n);
        let falls = fall_n > self.threshold_n;
        let is_armed = self.quiet_samples >= self.settle_samples;
        self.quiet_samples = if falls || !evidence.in_contact { 0 } else { self.quiet_samples + 1 };
        let goes_in = evidence.velocity_m_per_s > -0.005;
        Decision { distance: fall_n, decision: fall_n, alarm: falls && is_armed && goes_in && evidence.force_n > 0.0 }
    }
}

/// Runs the paper's augmented insertion with the detector.
pub fn run() -> Result<Run, Box<dyn std::error::Error>> {
    let scenario = Scenario::load(&Source::Builtin("augmented.toml".into()), &[])?;
    Ok(run_with(scenario, OwnParts::default().detector(FallDetector::new(0.15)))?)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let run = run()?;
    print!("{}", trocar::report::run_text(&run));
    Ok(())
}
