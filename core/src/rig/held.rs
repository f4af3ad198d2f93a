//! A commanded quantity that outlives bad samples.

/// A value that is passed on, held while its channel is bad, and then led back to what is read.
///
/// ```text
/// good        y = reading
/// bad         y = the last one
/// leading back  y = reading + gap, the gap from what was held, less a step a tick until it is 0
/// ```
#[derive(Debug, Clone)]
pub(super) struct Held {
    value: f64,
    gap: f64,
    step: f64,
    is_held: bool,
}

impl Held {
    /// At a value, with the greatest change of the gap in one tick.
    pub(super) fn at(value: f64, step: f64) -> Self {
        Self { value, gap: 0.0, step, is_held: false }
    }

    /// The reading as it is, where nothing is held or led back.
    #[inline(always)]
    pub(super) fn pass(&mut self, reading: f64) -> f64 {
        self.value = reading;
        reading
    }

    /// The last value.
    pub(super) fn hold(&mut self) -> f64 {
        self.is_held = true;
        self.value
    }

    /// The reading, with what remains of the gap to what was held.
    pub(super) fn lead_back(&mut self, reading: f64) -> f64 {
        if self.is_held {
            self.is_held = false;
            self.gap = self.value - reading;
        }
        self.gap -= self.gap.max(-self.step).min(self.step);
        self.value = reading + self.gap;
        self.value
    }

    /// Whether the reading passes as it is.
    pub(super) fn is_back(&self) -> bool {
        !self.is_held && self.gap == 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_held_comes_back_by_steps() {
        let mut held = Held::at(0.0, 0.5);
        assert_eq!(held.pass(1.0), 1.0);
        assert_eq!([held.hold(), held.hold()], [1.0, 1.0]);
        assert!(!held.is_back());
        assert_eq!([held.lead_back(2.25), held.lead_back(2.25), held.lead_back(2.25)], [1.5, 2.0, 2.25]);
        assert!(held.is_back());
    }
}
