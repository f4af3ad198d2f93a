//! When an alarm may be taken at all.

use super::Evidence;
use crate::error::{InvalidValue, non_negative};
use crate::lane::{Lane, Mask};
use crate::time::nearest_ticks;

/// When the detector listens.
///
/// A CUSUM alone announces the first touch, the estimator's own convergence, and every other large error. It is armed
/// only once the needle has been in contact, with `g` at or below the threshold, for `settle_s` on end; any crossing
/// ends that quiet. What crosses while armed is a rupture if it looks like one: the force falls *short* of an expected
/// *resisting* force (`drop_only`), the needle is not being withdrawn (`motion`), and it is deep enough
/// (`minimum_depth_m`). What these gates turn away ends the quiet all the same. The price: a rupture within `settle_s`
/// after any crossing, be it of another rupture or of a spike, is not announced.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ArmingSettings {
    /// Quiet contact before alarms are taken, in s, at least 0.
    pub settle_s: f64,
    /// Whether only a force below an expected resisting force counts.
    pub drop_only: bool,
    /// During which motion of the needle it counts.
    pub motion: Motion,
    /// Speed of withdrawal in m/s, at least 0, above which nothing counts, for [`Motion::NotWithdrawn`].
    pub withdrawal_speed_m_per_s: f64,
    /// Speed of insertion in m/s, at least 0, from which on it counts, for [`Motion::Inserting`].
    pub insertion_speed_m_per_s: f64,
    /// Depth below the contact in m, at least 0, from which on it counts.
    pub minimum_depth_m: f64,
}

/// During which motion a crossing counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Motion {
    /// Any.
    Any,
    /// Not while the needle is withdrawn: it may rest, and yield a little.
    #[default]
    NotWithdrawn,
    /// Only while it goes in.
    Inserting,
}

impl ArmingSettings {
    /// Checks the ranges that the fields state.
    ///
    /// # Errors
    /// [`InvalidValue`] naming the first setting out of range.
    pub fn validate(&self) -> Result<(), InvalidValue> {
        non_negative("detector.settle_s", self.settle_s)?;
        non_negative("detector.withdrawal_speed_m_per_s", self.withdrawal_speed_m_per_s)?;
        non_negative("detector.insertion_speed_m_per_s", self.insertion_speed_m_per_s)?;
        non_negative("detector.minimum_depth_m", self.minimum_depth_m)?;
        Ok(())
    }
}

impl Default for ArmingSettings {
    fn default() -> Self {
        Self {
            settle_s: 0.1,
            drop_only: true,
            motion: Motion::default(),
            withdrawal_speed_m_per_s: 5e-3,
            insertion_speed_m_per_s: 1e-3,
            minimum_depth_m: 0.0,
        }
    }
}

/// The count of quiet samples, and the conditions on an alarm.
#[derive(Debug, Clone)]
pub(super) struct Arming<L> {
    settle_ticks: L,
    quiet_ticks: L,
    drop_only: bool,
    slowest_velocity: L,
    minimum_depth: L,
}

impl<L: Lane> Arming<L> {
    pub(super) fn new(settings: &ArmingSettings, tick_s: f64) -> Self {
        Self {
            settle_ticks: L::splat(nearest_ticks(settings.settle_s, tick_s) as f64),
            quiet_ticks: L::zero(),
            drop_only: settings.drop_only,
            slowest_velocity: L::splat(match settings.motion {
                Motion::Any => f64::NEG_INFINITY,
                Motion::NotWithdrawn => -settings.withdrawal_speed_m_per_s,
                Motion::Inserting => settings.insertion_speed_m_per_s,
            }),
            minimum_depth: L::splat(settings.minimum_depth_m),
        }
    }

    /// Whether a sample whose `g` is `above` the threshold is an alarm.
    #[inline(always)]
    pub(super) fn update(&mut self, above: L::Mask, evidence: &Evidence<L>) -> L::Mask {
        let zero = L::zero();
        let quiet_before = self.quiet_ticks;
        let quiet_ticks = L::select(evidence.in_contact, quiet_before + L::splat(1.0), zero);
        if !above.any() {
            self.quiet_ticks = quiet_ticks;
            return L::Mask::splat(false);
        }
        self.quiet_ticks = L::select(above, zero, quiet_ticks);
        let armed = quiet_before.ge(self.settle_ticks);
        let inserting = evidence.velocity_m_per_s.ge(self.slowest_velocity);
        let deep = evidence.depth_m.ge(self.minimum_depth);
        let mut like_rupture = evidence.in_contact & inserting & deep;
        if self.drop_only {
            like_rupture = like_rupture & evidence.residual_n.lt(zero) & evidence.predicted_force_n.gt(zero);
        }
        armed & above & like_rupture
    }
}

crate::lane::gather!(Arming { settle_ticks, quiet_ticks, slowest_velocity, minimum_depth } same { drop_only });
