//! The hold gives the slave's reference during an event.
//!
//! A built-in hold is one file of this folder and one line of the registry below.

mod follow;
mod forbidden_region;
mod freeze;
mod speed_limit;
mod yielding;

pub use follow::Following;
pub use forbidden_region::{ForbiddenRegion, ForbiddenRegionSettings};
pub use freeze::Frozen;
pub use speed_limit::{SpeedLimit, SpeedLimitSettings};
pub use yielding::{Yielding, YieldingSettings};

use super::BuiltIn;
use crate::lane::Lane;

/// Inputs of a hold at a tick: positions in m, on the slave's scale.
#[derive(Debug, Clone, Copy)]
pub struct HeldTick<L> {
    /// Position of the slave at the alarm.
    pub anchor_m: L,
    /// The slave's reference at the tick before; the anchor at the first tick of an event.
    pub last_m: L,
    /// Reference of the slave without the event: the hand's position plus the offset left by a clutch.
    pub hand_m: L,
}

/// Gives the slave's reference during an event.
pub trait Hold<L: Lane> {
    /// The slave's reference in m.
    fn reference_m(&self, now: &HeldTick<L>) -> L;
}

/// The slave's reference during an event as a linear map, for the certificate of events.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HoldMap {
    /// It is constant.
    Frozen,
    /// It is the hand's position.
    Following,
}

crate::registry! {
    /// Hold the slave during an event: by a freeze, a speed limit, a forbidden region, a fixture that yields, or not at all.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub enum HoldSettings at "augmentation.hold" = Frozen;
    /// Any of the built-in holds.
    pub enum AnyHold<L> by (each, of_kind) stored;

    /// The slave is frozen.
    "freeze" => Frozen = freeze::Frozen,
    /// The slave follows the hand.
    "none" => Following = follow::Following,
    /// The slave follows the hand at a bounded speed.
    "speed-limit" => SpeedLimit(SpeedLimitSettings) = speed_limit::SpeedLimit,
    /// The slave follows the hand, but no deeper than its position at the alarm plus a margin.
    "forbidden-region" => ForbiddenRegion(ForbiddenRegionSettings) = forbidden_region::ForbiddenRegion,
    /// The slave is held until the hand pushes on by a distance, and then follows.
    "yielding" => Yielding(YieldingSettings) = yielding::Yielding,
}

impl HoldSettings {
    /// The hold as a linear map; `None` if the certificate of events does not cover it.
    #[must_use]
    pub fn map(&self) -> Option<HoldMap> {
        of_kind!(self, Part(kind_settings) => Part::<f64>::map(kind_settings))
    }
}

impl<L: Lane> AnyHold<L> {
    /// Creates the hold of the settings for ticks of `tick_s`.
    #[must_use]
    pub fn new(settings: &HoldSettings, tick_s: f64) -> Self {
        of_kind!(settings, Part(kind_settings) => Part::<L>::build(kind_settings, tick_s).into())
    }
}

impl<L: Lane> Hold<L> for AnyHold<L> {
    #[inline(always)]
    fn reference_m(&self, now: &HeldTick<L>) -> L {
        each!(self, hold => hold.reference_m(now))
    }
}
