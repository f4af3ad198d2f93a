//! A user-defined detector in a shipped scenario: the force minus its moving average, with a threshold.
//!
//! `cargo run --release --example user_defined_detector`

use trocar::detector::{Decision, Detector, DetectorInput};
use trocar::document::Study as _;
use trocar::engine::UserDefinedParts;
use trocar::run::{Run, RunReport, run_with};
use trocar::scenario::{Scenario, Source};

/// Raises an alarm if the force falls below its exponential moving average by more than a threshold. Requires some
/// quiet samples in contact before an alarm.
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
    fn update(&mut self, input: &DetectorInput<f64>) -> Decision<f64> {
        let fall_n = (self.average_n - input.force_n).max(0.0);
        self.average_n += self.weight * (input.force_n - self.average_n);
        let falls = fall_n > self.threshold_n;
        let is_armed = self.quiet_samples >= self.settle_samples;
        self.quiet_samples = if falls || !input.in_contact { 0 } else { self.quiet_samples + 1 };
        let is_not_withdrawn = input.velocity_m_per_s > -0.005;
        Decision {
            distance: fall_n,
            decision: fall_n,
            alarm: falls && is_armed && is_not_withdrawn && input.force_n > 0.0,
        }
    }
}

/// Runs the paper's augmented insertion with the detector.
pub fn run() -> Result<Run, Box<dyn std::error::Error>> {
    let scenario = Scenario::load(&Source::parse("paper/augmented"), &[])?;
    Ok(run_with(scenario, UserDefinedParts::default().detector(FallDetector::new(0.15)))?)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let run = run()?;
    print!("{}", trocar::report::document_text(&RunReport::of(&run).document(), false));
    Ok(())
}
