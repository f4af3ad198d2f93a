//! Warnings about units that are probably wrong.

use trocar_base::warning::{Code, Warning};

use crate::measured::{Measured, span};

/// The range of plausible motions in m.
const MOTION_M: (f64, f64) = (3e-4, 2.0);

/// Motions of master and slave that differ by more than this factor have different units.
const LARGEST_RATIO: f64 = 30.0;

/// The largest plausible force on a machine in N.
const LARGEST_FORCE_N: f64 = 2e3;

/// The range of plausible rates in Hz.
const RATE_HZ: (f64, f64) = (50.0, 1e5);

/// Returns the warnings about a recording.
pub(crate) fn warnings(measured: &Measured) -> Vec<Warning> {
    let mut warnings: Vec<Warning> =
        measured.unfinished.clone().into_iter().map(|warning| warning.of(&measured.name)).collect();
    let mut warn = |code, message: String, place: &str, remedy: &str| {
        warnings.push(Warning::new(code, message).at(place).remedy(remedy).of(&measured.name));
    };
    let (master_m, slave_m) = (span(&measured.master_m), span(&measured.slave_m));
    let ratio = slave_m / master_m;
    if !(1.0 / LARGEST_RATIO..=LARGEST_RATIO).contains(&ratio) {
        let message = format!("the slave's motion is {ratio:.3e} times the master's");
        let remedy = "give both in the same unit, as in --master COLUMN:mm, and scale the master to the slave's side";
        warn(Code::PositionMagnitude, message, "--master, --slave", remedy);
    } else if !(MOTION_M.0..=MOTION_M.1).contains(&slave_m) {
        let message = format!("the slave moves by {slave_m:.3e} m");
        warn(Code::PositionMagnitude, message, "--slave", "give the unit of the column, as in --slave COLUMN:mm");
    }
    let force_n = measured.force_n.iter().fold(0.0_f64, |largest, force| largest.max(force.abs()));
    if force_n > LARGEST_FORCE_N {
        let message = format!("the largest force is {force_n:.3e} N");
        warn(Code::ForceMagnitude, message, "--force", "give the unit of the column, as in --force COLUMN:mN");
    }
    let rate_hz = 1.0 / measured.interval_s;
    if rate_hz < RATE_HZ.0 {
        let message =
            format!("the recording has {rate_hz:.3e} samples per second, too few for the motion of a machine");
        warn(Code::LowSamplingRate, message, "--time", "give the unit of the column, as in --time COLUMN:ms");
    } else if rate_hz > RATE_HZ.1 {
        let message = format!("the recording has {rate_hz:.3e} samples per second");
        warn(Code::HighSamplingRate, message, "--time", "check the unit of the column, as in --time COLUMN:s");
    }
    warnings
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measured::tests::measured;

    #[test]
    fn units_wrong_by_1000_are_reported() {
        let codes = |master: f64, slave: f64, force: f64, interval_s: f64| -> Vec<Code> {
            let wave = |t_s: f64| (0.01 * t_s / interval_s).sin();
            let one = measured(interval_s, 800, |t_s| {
                (0.05 * master * wave(t_s), 0.05 * slave * wave(t_s), 5.0 * force * wave(t_s))
            });
            warnings(&one).iter().map(|warning| warning.code).collect()
        };
        assert_eq!(codes(1.0, 1.0, 1.0, 1e-3), []);
        assert_eq!(codes(1e3, 1.0, 1.0, 1e-3), [Code::PositionMagnitude]);
        assert_eq!(codes(1e3, 1e3, 1.0, 1e-3), [Code::PositionMagnitude]);
        assert_eq!(codes(1.0, 1.0, 1e3, 1e-3), [Code::ForceMagnitude]);
        assert_eq!(codes(1.0, 1.0, 1.0, 1.0), [Code::LowSamplingRate]);
        assert_eq!(codes(1.0, 1.0, 1.0, 1e-6), [Code::HighSamplingRate]);
    }
}
