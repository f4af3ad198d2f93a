use super::ArrivedAtMaster;
use trocar_core::lane::Lane;

/// While the slave is frozen, holds the last force plus the change of the tissue force since then.
#[derive(Debug, Clone)]
pub(super) struct FrozenForce<L> {
    whole_n: L,
    tissue_n: L,
}

impl<L: Lane> Default for FrozenForce<L> {
    fn default() -> Self {
        Self { whole_n: L::zero(), tissue_n: L::zero() }
    }
}

impl<L: Lane> FrozenForce<L> {
    #[inline(always)]
    pub(super) fn update(&mut self, force_n: L, arrived: &ArrivedAtMaster<L>) -> L {
        let is_frozen = arrived.mode.is_augmented();
        let tissue_n = arrived.sample.force_n;
        let held_n = self.whole_n + (tissue_n - self.tissue_n);
        self.whole_n = L::select(is_frozen, self.whole_n, force_n);
        self.tissue_n = L::select(is_frozen, self.tissue_n, tissue_n);
        L::select(is_frozen, held_n, force_n)
    }
}

trocar_core::lane::gather!(FrozenForce { whole_n, tissue_n });

#[cfg(test)]
mod tests {
    use super::super::SlaveSample;
    use super::*;
    use trocar_core::augmentation::{Mode, Modes};

    #[test]
    fn while_frozen_the_force_is_the_last_one_plus_the_change_of_the_tissue_force() {
        let mut frozen = FrozenForce::<f64>::default();
        let mut at = |mode, law_n, tissue_n| {
            let sample =
                SlaveSample { force_n: tissue_n, position_m: 0.0, velocity_m_per_s: 0.0, acceleration_m_per_s2: 0.0 };
            frozen.update(law_n, &ArrivedAtMaster { sample, force_n: 99.0, mode: Modes::splat(mode) })
        };
        assert_eq!(at(Mode::Teleoperation, 5.0, 2.0), 5.0);
        assert_eq!(at(Mode::Augmented, 100.0, 1.5), 4.5);
        assert_eq!(at(Mode::Augmented, 200.0, 2.25), 5.25);
        assert_eq!(at(Mode::Reengaging, 7.0, 3.0), 7.0);
        assert_eq!(at(Mode::Augmented, 300.0, 2.0), 6.0, "from the last tick that was not frozen");
    }
}
