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

/// Inputs at a tick, on the slave's scale.
#[derive(Debug, Clone, Copy)]
pub struct HeldTick<L> {
    /// Slave at the alarm.
    pub anchor_m: L,
    /// Slave's reference at the tick before; first the anchor.
    pub last_m: L,
    /// Without the event: the hand plus the offset left by a clutch.
    pub hand_m: L,
}

/// Gives the slave's reference during an event.
pub trait Hold<L: Lane> {
    /// In m.
    fn reference_m(&self, now: &HeldTick<L>) -> L;
}

/// For the certificate of events.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HoldMap {
    /// A constant reference.
    Frozen,
    /// The hand's position.
    Following,
}

crate::registry! {
    /// Hold the slave during an event: by a freeze, a speed limit, a forbidden region, a fixture that yields, or not at all.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub enum HoldSettings at "augmentation.hold" = Frozen;
    /// Any built-in hold.
    pub enum AnyHold<L> by (each, of_kind) stored;

    "freeze" => Frozen = freeze::Frozen,
    "none" => Following = follow::Following,
    "speed-limit" => SpeedLimit(SpeedLimitSettings) = speed_limit::SpeedLimit,
    "forbidden-region" => ForbiddenRegion(ForbiddenRegionSettings) = forbidden_region::ForbiddenRegion,
    "yielding" => Yielding(YieldingSettings) = yielding::Yielding,
}

impl HoldSettings {
    /// `None` if the certificate does not cover it.
    #[must_use]
    pub fn map(&self) -> Option<HoldMap> {
        of_kind!(self, Part(kind_settings) => Part::<f64>::map(kind_settings))
    }
}

impl<L: Lane> AnyHold<L> {
    /// For ticks of `tick_s`.
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
