use trocar_base::warning::{Code, Warning};

use super::{Part, Signals};
use crate::measured::span;
use crate::plausibility::{LARGEST_RATIO, Warnings};

/// Smaller ranges suggest a wrong unit.
const LEAST_FORCE_N: f64 = 5e-3;

pub(super) fn warnings(part: Part, signals: &Signals) -> Vec<Warning> {
    let mut warnings = Warnings::of(&signals.name, signals.unfinished.as_ref());
    let (side, flag) = part.moving();
    let moved_m = span(&signals.position_m);
    warnings.motion(side, flag, moved_m);
    warnings.force(&signals.force_n);
    let span_n = span(&signals.force_n);
    if span_n < LEAST_FORCE_N {
        let message = format!("the force changes by {span_n:.3e} N");
        warnings.add(Code::ForceMagnitude, message, "--force", "give the unit of the column, as in --force COLUMN:kN");
    }
    match (&signals.input, part) {
        (Some(desired_m), Part::Arm) => {
            let ratio = span(desired_m) / moved_m;
            // A constant desired position is a position to hold.
            if ratio > LARGEST_RATIO || (ratio > 0.0 && ratio < 1.0 / LARGEST_RATIO / LARGEST_RATIO) {
                let message = format!("the desired motion is {ratio:.3e} times the master's");
                let remedy = "give both in the same unit, as in --desired COLUMN:mm";
                warnings.add(Code::PositionMagnitude, message, "--desired, --master", remedy);
            }
        }
        (Some(motor_n), Part::Master) => {
            let ratio = span(motor_n) / span_n;
            if ratio > LARGEST_RATIO || (ratio > 0.0 && ratio < 1.0 / LARGEST_RATIO) {
                let message = format!("the motor's force changes {ratio:.3e} times as much as the hand's");
                let remedy = "give both in the same unit, as in --actuator COLUMN:mN";
                warnings.add(Code::ForceMagnitude, message, "--actuator, --force", remedy);
            }
        }
        _ => {}
    }
    warnings.rate(signals.interval_s);
    warnings.list
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_wrong_by_1000_are_reported() {
        let codes = |part, position: f64, force: f64, input: Option<f64>| -> Vec<Code> {
            let wave = |scale: f64| -> Vec<f64> { (0..800).map(|k| scale * (0.01 * f64::from(k)).sin()).collect() };
            let one = Signals::new("a.csv", part, 1e-3, wave(0.05 * position), wave(5.0 * force), input.map(wave));
            warnings(part, &one.expect("a recording")).iter().map(|warning| warning.code).collect()
        };
        assert_eq!(codes(Part::Tissue, 1.0, 1.0, None), []);
        assert_eq!(codes(Part::Tissue, 1e3, 1.0, None), [Code::PositionMagnitude]);
        assert_eq!(codes(Part::Tissue, 1e-3, 1.0, None), [Code::PositionMagnitude]);
        assert_eq!(codes(Part::Tissue, 1.0, 1e3, None), [Code::ForceMagnitude]);
        assert_eq!(codes(Part::Tissue, 1.0, 1e-4, None), [Code::ForceMagnitude]);
        assert_eq!(codes(Part::Arm, 1.0, 1.0, Some(0.05)), []);
        assert_eq!(codes(Part::Arm, 1.0, 1.0, Some(50.0)), [Code::PositionMagnitude]);
        assert_eq!(codes(Part::Master, 1.0, 1.0, Some(5.0)), []);
        assert_eq!(codes(Part::Master, 1.0, 1.0, Some(5e3)), [Code::ForceMagnitude]);
    }
}
