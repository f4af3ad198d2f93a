use super::{AugmentedTick, BuiltIn, ForceLaw, ForceMap};
use crate::lane::Lane;

crate::settings! {
    /// Settings of [`Damp`].
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct DampSettings in "augmentation.damp_" {
        /// Damping that the damp law adds to the master; with 0 the feedback force is the measured force.
        damping_n_s_per_m: f64 [NON_NEGATIVE] = 100.0,
        /// Time constant with which the added damping rises.
        time_constant_s: f64 [POSITIVE] = 0.03,
    }
}

/// `F = F_e + b_k v_h`, `b_k = b (1 - exp(-k T/τ))` with `k` ticks since the alarm; `|ΔF| <= |ΔF_e| + |Δ(b_k v_h)|`
#[derive(Debug, Clone)]
pub struct Damp<L> {
    damping: L,
    keep: L,
    /// `b_k`, and the last `b_k v_h`.
    risen: L,
    braking: L,
}

impl<L: Lane> BuiltIn for Damp<L> {
    type Settings = DampSettings;
    type Map = ForceMap;

    fn build(settings: &DampSettings, tick_s: f64) -> Self {
        let keep = L::splat(libm::exp(-tick_s / settings.time_constant_s));
        Self { damping: L::splat(settings.damping_n_s_per_m), keep, risen: L::zero(), braking: L::zero() }
    }

    fn map(settings: &DampSettings) -> Option<ForceMap> {
        Some(ForceMap::IsDamped { damping_n_s_per_m: settings.damping_n_s_per_m })
    }
}

impl<L: Lane> ForceLaw<L> for Damp<L> {
    #[inline(always)]
    fn augmented(&mut self, now: &AugmentedTick<L>) -> (L, L) {
        let risen = L::select(now.begins, L::zero(), self.risen);
        let before = L::select(now.begins, L::zero(), self.braking);
        self.risen = self.damping + (risen - self.damping) * self.keep;
        self.braking = self.risen * now.velocity_m_per_s;
        (now.measured_n + self.braking, now.moved_n + (self.braking - before).abs())
    }
}

crate::lane::gather!(Damp { damping, keep, risen, braking } stored);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_damping_rises_with_its_time_constant_from_the_alarm_on() {
        let mut law = Damp::<f64>::build(&DampSettings { damping_n_s_per_m: 80.0, time_constant_s: 0.02 }, 1e-3);
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
            // In a second event the damping rises from 0 again.
            let mut braking_before = 0.0;
            for tick in 1..=40 {
                let velocity = if tick % 2 == 0 { 0.01 } else { -0.03 };
                let braking = 80.0 * (1.0 - (-f64::from(tick) * 0.05_f64).exp()) * velocity;
                let (force_n, allowed_n) = at(velocity, tick == 1);
                assert!((force_n - (2.0 + braking)).abs() < 1e-12, "{tick}: {force_n}");
                assert!((allowed_n - (0.25 + f64::abs(braking - braking_before))).abs() < 1e-12, "{tick}: {allowed_n}");
                braking_before = braking;
            }
        }
    }
}
