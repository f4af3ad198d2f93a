//! The conditions on an alarm.

use super::Evidence;
use crate::lane::{Lane, Mask};
use crate::time::nearest_ticks;

crate::settings! {
    /// When the detector is armed.
    ///
    /// A CUSUM alone raises alarms at the first contact, while the estimator converges, and at every other large error.
    /// The detector is armed once the needle has been in contact, with `g` at or below the threshold, for `settle_s`
    /// without a break; any crossing of the threshold restarts this time. A crossing while armed is a rupture if the
    /// force falls *below* a predicted *resisting* force (`drop_only`), the needle is not being withdrawn (`motion`),
    /// and it is deep enough (`minimum_depth_m`). A crossing that fails these conditions restarts the time as well. The
    /// price: a rupture within `settle_s` after any crossing, by another rupture or by a spike, is not detected.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct ArmingSettings in "detector." {
        /// Duration of quiet contact before the detector is armed.
        settle_s: f64 [NON_NEGATIVE] = 0.1,
        /// Whether only a force below a predicted resisting force counts.
        drop_only: bool = true,
        /// The motion of the needle during which a drop counts.
        motion: Motion,
        /// A drop does not count while the needle is withdrawn faster than this (not-withdrawn).
        withdrawal_speed_m_per_s: f64 [NON_NEGATIVE] for Motion::NotWithdrawn = 5e-3,
        /// A drop does not count while the needle is inserted more slowly than this (inserting).
        insertion_speed_m_per_s: f64 [NON_NEGATIVE] for Motion::Inserting = 1e-3,
        /// A drop counts only from this depth below estimator.contact_m.
        minimum_depth_m: f64 [NON_NEGATIVE] = 0.0,
    }
}

crate::choice! {
    /// The motion of the needle during which a drop counts.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Motion at "detector.motion" = NotWithdrawn {
        /// Any.
        "any" => Any,
        /// Not during a withdrawal; the needle may rest or retreat slightly.
        "not-withdrawn" => NotWithdrawn,
        /// Only during insertion.
        "inserting" => Inserting,
    }
}

/// The conditions on an alarm, each as it stands at one sample. All must hold.
#[derive(Debug, Clone, Copy)]
pub struct AlarmConditions<L: Lane> {
    /// The needle is in contact.
    pub in_contact: L::Mask,
    /// The contact was quiet for `settle_s`.
    pub armed: L::Mask,
    /// The force falls below a predicted resisting force; always true without `drop_only`.
    pub is_drop: L::Mask,
    /// The velocity agrees with `motion`.
    pub moves_as_required: L::Mask,
    /// The depth is at least `minimum_depth_m`.
    pub is_deep: L::Mask,
    /// Number of quiet samples in contact before this one.
    pub quiet_samples: L,
}

impl<L: Lane> AlarmConditions<L> {
    /// Whether all hold.
    #[inline(always)]
    pub fn all(&self) -> L::Mask {
        self.armed & self.in_contact & self.moves_as_required & self.is_deep & self.is_drop
    }
}

/// The count of quiet samples, and the conditions on an alarm.
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

    /// The conditions on an alarm at the next sample.
    #[inline(always)]
    pub(super) fn conditions(&self, evidence: &Evidence<L>) -> AlarmConditions<L> {
        let zero = L::zero();
        let is_drop = if self.drop_only {
            evidence.residual_n.lt(zero) & evidence.predicted_force_n.gt(zero)
        } else {
            L::Mask::splat(true)
        };
        AlarmConditions {
            in_contact: evidence.in_contact,
            armed: self.quiet_ticks.ge(self.settle_ticks),
            is_drop,
            moves_as_required: evidence.velocity_m_per_s.ge(self.min_velocity),
            // Without a minimum the contact alone decides, for the detectors that need one.
            is_deep: evidence.depth_m.ge(self.minimum_depth) | self.minimum_depth.le(zero),
            quiet_samples: self.quiet_ticks,
        }
    }

    /// Whether a sample whose `g` is `above` the threshold is an alarm.
    #[inline(always)]
    pub(super) fn update(&mut self, above: L::Mask, evidence: &Evidence<L>) -> L::Mask {
        let zero = L::zero();
        let quiet_ticks = L::select(evidence.in_contact, self.quiet_ticks + L::splat(1.0), zero);
        if !above.any() {
            self.quiet_ticks = quiet_ticks;
            return L::Mask::splat(false);
        }
        let conditions = self.conditions(evidence);
        self.quiet_ticks = L::select(above, zero, quiet_ticks);
        above & conditions.all()
    }
}

crate::lane::gather!(Arming { settle_ticks, quiet_ticks, min_velocity, minimum_depth } same { drop_only } stored);
