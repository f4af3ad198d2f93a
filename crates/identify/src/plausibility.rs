use trocar_base::warning::{Code, Warning};

use crate::measured::{Measured, span};

const MOTION_M: (f64, f64) = (3e-4, 2.0);

/// A larger ratio of the motions suggests different units.
pub(crate) const LARGEST_RATIO: f64 = 30.0;

const LARGEST_FORCE_N: f64 = 2e3;

const RATE_HZ: (f64, f64) = (50.0, 1e5);

pub(crate) struct Warnings<'a> {
    recording: &'a str,
    pub(crate) list: Vec<Warning>,
}

impl<'a> Warnings<'a> {
    pub(crate) fn of(recording: &'a str, unfinished: Option<&Warning>) -> Self {
        Self { recording, list: unfinished.cloned().map(|warning| warning.of(recording)).into_iter().collect() }
    }

    pub(crate) fn add(&mut self, code: Code, message: String, place: &str, remedy: &str) {
        self.list.push(Warning::new(code, message).at(place).remedy(remedy).of(self.recording));
    }

    pub(crate) fn motion(&mut self, side: &str, flag: &str, moved_m: f64) {
        if !(MOTION_M.0..=MOTION_M.1).contains(&moved_m) {
            let message = format!("the {side} moves by {moved_m:.3e} m");
            let remedy = format!("give the unit of the column, as in {flag} COLUMN:mm");
            self.add(Code::PositionMagnitude, message, flag, &remedy);
        }
    }

    pub(crate) fn force(&mut self, force_n: &[f64]) {
        let force_n = force_n.iter().fold(0.0_f64, |largest, force| largest.max(force.abs()));
        if force_n > LARGEST_FORCE_N {
            let message = format!("the largest force is {force_n:.3e} N");
            self.add(Code::ForceMagnitude, message, "--force", "give the unit of the column, as in --force COLUMN:mN");
        }
    }

    pub(crate) fn rate(&mut self, interval_s: f64) {
        let rate_hz = 1.0 / interval_s;
        if rate_hz < RATE_HZ.0 {
            let message =
                format!("the recording has {rate_hz:.3e} samples per second, too few for the motion of a machine");
            let remedy = "give the unit of the column, as in --time COLUMN:ms";
            self.add(Code::LowSamplingRate, message, "--time", remedy);
        } else if rate_hz > RATE_HZ.1 {
            let message = format!("the recording has {rate_hz:.3e} samples per second");
            let remedy = "check the unit of the column, as in --time COLUMN:s";
            self.add(Code::HighSamplingRate, message, "--time", remedy);
        }
    }
}

pub(crate) fn warnings(measured: &Measured) -> Vec<Warning> {
    let mut warnings = Warnings::of(&measured.name, measured.unfinished.as_ref());
    let (master_m, slave_m) = (span(&measured.master_m), span(&measured.slave_m));
    let ratio = slave_m / master_m;
    if (1.0 / LARGEST_RATIO..=LARGEST_RATIO).contains(&ratio) {
        warnings.motion("slave", "--slave", slave_m);
    } else {
        let message = format!("the slave's motion is {ratio:.3e} times the master's");
        let remedy = "give both in the same unit, as in --master COLUMN:mm, and scale the master to the slave's side";
        warnings.add(Code::PositionMagnitude, message, "--master, --slave", remedy);
    }
    warnings.force(&measured.force_n);
    warnings.rate(measured.interval_s);
    warnings.list
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
