use trocar_core::detector::AlarmConditions;

/// One byte per sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SampleConditions(u8);

impl SampleConditions {
    #[inline]
    pub(super) fn of(conditions: &AlarmConditions<f64>) -> Self {
        let AlarmConditions { in_contact, armed, is_drop, moves_as_required, is_deep, .. } = *conditions;
        let all = [in_contact, armed, is_drop, moves_as_required, is_deep];
        Self(all.into_iter().enumerate().map(|(bit, holds)| u8::from(holds) << bit).sum())
    }

    pub(super) fn with_quiet(self, quiet_samples: f64) -> AlarmConditions<f64> {
        let [in_contact, armed, is_drop, moves_as_required, is_deep] = [0, 1, 2, 3, 4].map(|bit| self.holds(bit));
        AlarmConditions { in_contact, armed, is_drop, moves_as_required, is_deep, quiet_samples }
    }

    pub fn in_contact(self) -> bool {
        self.holds(0)
    }

    pub fn armed(self) -> bool {
        self.holds(1)
    }

    fn holds(self, bit: u8) -> bool {
        self.0 >> bit & 1 == 1
    }
}
