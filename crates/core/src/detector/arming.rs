use super::DetectorInput;
use crate::lane::{Lane, Mask};
use crate::time::nearest_ticks;

crate::settings! {
    /// When the detector is armed.
    ///
    /// A CUSUM alone raises alarms at the first contact and while the estimator converges, so it needs contact for
    /// `settle_s` with `g` at or below the threshold. The cost: it misses a rupture within `settle_s` after another
    /// crossing.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct ArmingSettings in "detector." {
        /// Duration of quiet contact before the detector is armed.
        settle_s: f64 [NON_NEGATIVE] = 0.1,
        /// Ignores changes other than a force below a predicted resisting force.
        drop_only: bool = true,
        /// Motion of the needle during which a drop counts.
        motion: Motion,
        /// A drop does not count while the needle is withdrawn faster than this (not-withdrawn).
        withdrawal_speed_m_per_s: f64 [NON_NEGATIVE] for Motion::NotWithdrawn = 5e-3,
        /// A drop does not count while the needle is inserted more slowly than this (inserting).
        insertion_speed_m_per_s: f64 [NON_NEGATIVE] for Motion::Inserting = 1e-3,
        /// Smallest depth below estimator.contact_m at which a drop counts.
        minimum_depth_m: f64 [NON_NEGATIVE] = 0.0,
    }
}

crate::choice! {
    /// Motion of the needle during which a drop counts.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Motion at "detector.motion" = NotWithdrawn {
        "any" => Any,
        /// The needle may rest or retreat slightly.
        "not-withdrawn" => NotWithdrawn,
        "inserting" => Inserting,
    }
}

/// Conditions on an alarm; all must hold.
#[derive(Debug, Clone, Copy)]
pub struct AlarmConditions<L: Lane> {
    /// The needle is in contact.
    pub in_contact: L::Mask,
    /// Contact was quiet for `settle_s`.
    pub armed: L::Mask,
    /// Force below a predicted resisting force; always true without `drop_only`.
    pub is_drop: L::Mask,
    /// As `motion` requires.
    pub moves_as_required: L::Mask,
    /// At least `minimum_depth_m`.
    pub is_deep: L::Mask,
    /// Quiet samples in contact before this one.
    pub quiet_samples: L,
}

impl<L: Lane> AlarmConditions<L> {
    /// Lanes in which all hold.
    #[inline(always)]
    pub fn all(&self) -> L::Mask {
        self.armed & self.in_contact & self.moves_as_required & self.is_deep & self.is_drop
    }
}

#[derive(Debug, Clone)]
pub(super) struct Arming<L> {
    settle_ticks: L,
    quiet_ticks: L,
    drop_only: bool,
    min_velocity: L,
    minimum_depth: L,
}

impl<L: Lane> Arming<L> {
    pub(super) fn new(settings: &ArmingSettings, tick_s: f64) -> Self {
        Self {
            settle_ticks: L::splat(nearest_ticks(settings.settle_s, tick_s) as f64),
            quiet_ticks: L::zero(),
            drop_only: settings.drop_only,
            min_velocity: L::splat(match settings.motion {
                Motion::Any => f64::NEG_INFINITY,
                Motion::NotWithdrawn => -settings.withdrawal_speed_m_per_s,
                Motion::Inserting => settings.insertion_speed_m_per_s,
            }),
            minimum_depth: L::splat(settings.minimum_depth_m),
        }
    }

    #[inline(always)]
    pub(super) fn is_armed(&self) -> L::Mask {
        self.quiet_ticks.ge(self.settle_ticks)
    }

    #[inline(always)]
    pub(super) fn conditions(&self, input: &DetectorInput<L>) -> AlarmConditions<L> {
        let zero = L::zero();
        let is_drop = if self.drop_only {
            input.residual_n.lt(zero) & input.predicted_force_n.gt(zero)
        } else {
            L::Mask::splat(true)
        };
        AlarmConditions {
            in_contact: input.in_contact,
            armed: self.is_armed(),
            is_drop,
            moves_as_required: input.velocity_m_per_s.ge(self.min_velocity),
            is_deep: input.depth_m.ge(self.minimum_depth) | self.minimum_depth.le(zero),
            quiet_samples: self.quiet_ticks,
        }
    }

    #[inline(always)]
    pub(super) fn update(&mut self, above: L::Mask, input: &DetectorInput<L>) -> L::Mask {
        let zero = L::zero();
        let quiet_ticks = L::select(input.in_contact, self.quiet_ticks + L::splat(1.0), zero);
        if !above.any() {
            self.quiet_ticks = quiet_ticks;
            return L::Mask::splat(false);
        }
        let conditions = self.conditions(input);
        self.quiet_ticks = L::select(above, zero, quiet_ticks);
        above & conditions.all()
    }
}

crate::lane::gather!(Arming { settle_ticks, quiet_ticks, min_velocity, minimum_depth } same { drop_only } stored);

#[cfg(test)]
mod tests {
    use super::super::fixtures::{QUIET, with_residual};
    use super::*;

    /// Settings that let a drop count after 4 ticks of quiet contact.
    const ARMING: ArmingSettings = ArmingSettings { settle_s: 4e-3, ..ArmingSettings::DEFAULT };

    fn arming(settings: ArmingSettings) -> Arming<f64> {
        Arming::new(&settings, 1e-3)
    }

    /// The indices of the samples that raise an alarm; each sample states whether `g` is above the threshold.
    fn alarms(mut arming: Arming<f64>, samples: &[(bool, DetectorInput<f64>)]) -> Vec<usize> {
        let mut is_alarm = |(above, input): &(bool, DetectorInput<f64>)| arming.update(*above, input);
        samples.iter().enumerate().filter_map(|(k, sample)| is_alarm(sample).then_some(k)).collect()
    }

    #[test]
    fn a_crossing_counts_after_exactly_the_settling_time_in_contact() {
        let drop = (true, with_residual(-0.5));
        let quiet = (false, QUIET);
        assert_eq!(alarms(arming(ARMING), &[quiet, quiet, quiet, drop]), [0_usize; 0]);
        assert_eq!(alarms(arming(ARMING), &[quiet, quiet, quiet, quiet, drop]), [4]);
    }

    #[test]
    fn a_crossing_and_a_loss_of_contact_restart_the_settling_time() {
        let (drop, quiet) = ((true, with_residual(-0.5)), (false, QUIET));
        let outside = (false, DetectorInput { in_contact: false, ..QUIET });
        let after = |between| {
            let mut samples = vec![quiet; 4];
            samples.push(between);
            samples.extend([quiet; 3]);
            samples.extend([drop, quiet, quiet, quiet, quiet, drop]);
            alarms(arming(ARMING), &samples)
        };
        assert_eq!(after(quiet), [8, 13], "without a break");
        assert_eq!(after(drop), [4, 13], "a rupture");
        assert_eq!(after((true, with_residual(0.5))), [13], "a crossing that is no drop");
        assert_eq!(after(outside), [13], "a loss of contact");
        assert_eq!(
            after((true, DetectorInput { in_contact: false, ..with_residual(-0.5) })),
            [13],
            "a drop out of contact"
        );
    }

    #[test]
    fn the_count_of_quiet_samples_excludes_the_current_sample() {
        let mut arming = arming(ARMING);
        for quiet in 0..6 {
            let conditions = arming.conditions(&QUIET);
            assert_eq!((conditions.quiet_samples, conditions.armed), (f64::from(quiet), quiet >= 4));
            arming.update(false, &QUIET);
        }
    }

    #[test]
    fn only_a_force_below_a_predicted_resisting_force_is_a_drop() {
        let is_drop = |residual_n, predicted_force_n, drop_only| {
            let arming = arming(ArmingSettings { drop_only, ..ARMING });
            arming.conditions(&DetectorInput { residual_n, predicted_force_n, ..QUIET }).is_drop
        };
        assert!(is_drop(-0.1, 2.0, true));
        assert!(!is_drop(0.1, 2.0, true), "a rise");
        assert!(!is_drop(0.0, 2.0, true), "no change");
        assert!(!is_drop(-0.1, -2.0, true), "a force that pulls");
        assert!(!is_drop(-0.1, 0.0, true), "nothing predicted");
        assert!(is_drop(0.1, -2.0, false), "any crossing counts without drop_only");
    }

    #[test]
    fn without_a_minimum_depth_every_depth_counts() {
        let is_deep = |minimum_depth_m, depth_m| {
            let arming = arming(ArmingSettings { minimum_depth_m, ..ARMING });
            arming.conditions(&DetectorInput { depth_m, ..QUIET }).is_deep
        };
        assert_eq!([is_deep(0.0, -0.01), is_deep(0.0, 0.01)], [true; 2]);
        assert_eq!([is_deep(5e-3, -0.01), is_deep(5e-3, 4.9e-3), is_deep(5e-3, 5e-3)], [false, false, true]);
    }

    #[test]
    fn an_alarm_needs_every_condition() {
        let all = AlarmConditions::<f64> {
            in_contact: true,
            armed: true,
            is_drop: true,
            moves_as_required: true,
            is_deep: true,
            quiet_samples: 0.0,
        };
        assert!(all.all());
        for one in [
            AlarmConditions { in_contact: false, ..all },
            AlarmConditions { armed: false, ..all },
            AlarmConditions { is_drop: false, ..all },
            AlarmConditions { moves_as_required: false, ..all },
            AlarmConditions { is_deep: false, ..all },
        ] {
            assert!(!one.all(), "{one:?}");
        }
    }
}
