use crate::lane::Stored;

/// Holds a value while its channel is bad. On recovery the gap to the reading shrinks by at most `step` per tick.
#[derive(Debug, Clone)]
pub(super) struct HeldMeasurement {
    value: f64,
    gap: f64,
    step: f64,
    is_held: bool,
}

impl HeldMeasurement {
    pub(super) fn at(value: f64, step: f64) -> Self {
        Self { value, gap: 0.0, step, is_held: false }
    }

    /// Only without a recovery in progress.
    #[inline(always)]
    pub(super) fn pass(&mut self, measurement: f64) -> f64 {
        self.value = measurement;
        measurement
    }

    pub(super) fn hold(&mut self) -> f64 {
        self.is_held = true;
        self.value
    }

    pub(super) fn recover(&mut self, measurement: f64) -> f64 {
        if self.is_held {
            self.is_held = false;
            self.gap = self.value - measurement;
        }
        self.gap -= self.gap.max(-self.step).min(self.step);
        self.value = measurement + self.gap;
        self.value
    }

    pub(super) fn is_recovered(&self) -> bool {
        !self.is_held && self.gap == 0.0
    }
}

impl Stored for HeldMeasurement {
    fn numbers(&mut self, with: &mut dyn FnMut(&mut u64)) {
        let Self { value, gap, step, is_held } = self;
        value.numbers(with);
        gap.numbers(with);
        step.numbers(with);
        is_held.numbers(with);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_held_value_returns_in_steps() {
        let mut held = HeldMeasurement::at(0.0, 0.5);
        assert_eq!(held.pass(1.0), 1.0);
        assert_eq!([held.hold(), held.hold()], [1.0, 1.0]);
        assert!(!held.is_recovered());
        assert_eq!([held.recover(2.25), held.recover(2.25), held.recover(2.25)], [1.5, 2.0, 2.25]);
        assert!(held.is_recovered());
    }
}
