use super::{AugmentedTick, BuiltIn, ForceLaw, ForceMap};
use crate::lane::Lane;

crate::settings! {
    /// Settings of [`Guide`].
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct GuideSettings in "augmentation.guide_" {
        /// Stiffness of the spring between the master and its position at the alarm.
        stiffness_n_per_m: f64 [NON_NEGATIVE] = 200.0,
    }
}

/// `F = F_e + k d` with the master's motion `d = Σ v_h T` since the alarm; `|ΔF| <= |ΔF_e| + k |v_h| T`
#[derive(Debug, Clone)]
pub struct Guide<L> {
    /// `k T`.
    per_speed: L,
    /// `k d`.
    pull: L,
}

impl<L: Lane> BuiltIn for Guide<L> {
    type Settings = GuideSettings;
    type Map = ForceMap;

    fn build(settings: &GuideSettings, tick_s: f64) -> Self {
        Self { per_speed: L::splat(settings.stiffness_n_per_m * tick_s), pull: L::zero() }
    }
}

impl<L: Lane> ForceLaw<L> for Guide<L> {
    #[inline(always)]
    fn augmented(&mut self, now: &AugmentedTick<L>) -> (L, L) {
        let step = self.per_speed * now.velocity_m_per_s;
        self.pull = L::select(now.begins, L::zero(), self.pull) + step;
        (now.measured_n + self.pull, now.moved_n + step.abs())
    }
}

crate::lane::gather!(Guide { per_speed, pull } stored);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_spring_pulls_with_the_motion_since_the_alarm() {
        let mut law = Guide::<f64>::build(&GuideSettings { stiffness_n_per_m: 200.0 }, 1e-3);
        let mut at = |velocity_m_per_s, begins| {
            law.augmented(&AugmentedTick {
                anchor_n: 100.0,
                last_n: 100.0,
                measured_n: 2.0,
                moved_n: 0.25,
                velocity_m_per_s,
                begins,
            })
        };
        for _ in 0..2 {
            // In a second event the motion counts from its own alarm.
            for tick in 1..=40 {
                let (force_n, allowed_n) = at(0.05, tick == 1);
                assert!((force_n - (2.0 + 200.0 * 5e-5 * f64::from(tick))).abs() < 1e-12, "{tick}: {force_n}");
                assert!((allowed_n - 0.26).abs() < 1e-12, "{tick}: {allowed_n}");
            }
        }
    }
}
