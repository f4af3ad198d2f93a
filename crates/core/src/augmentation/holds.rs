//! The role of the hold, and the built-in holds: the slave's reference during an event.
//!
//! A built-in hold is one file of this folder and one line of [`holds!`].

mod follow;
mod forbidden_region;
mod freeze;
mod speed_limit;

pub use follow::Following;
pub use forbidden_region::{ForbiddenRegion, ForbiddenRegionSettings};
pub use freeze::Frozen;
pub use speed_limit::{SpeedLimit, SpeedLimitSettings};

use crate::lane::Lane;

/// Inputs of a hold at a tick. All positions are in m, on the slave's scale.
#[derive(Debug, Clone, Copy)]
pub struct HeldTick<L> {
    /// Where the slave was at the alarm.
    pub anchor_m: L,
    /// The slave's reference at the tick before; at the first tick of an event the anchor.
    pub last_m: L,
    /// Where the slave would be without the event: the hand's position with the offset left by a clutch.
    pub hand_m: L,
}

/// Gives the slave's reference during an event.
pub trait Hold<L: Lane> {
    /// The slave's reference in m.
    fn reference_m(&self, now: &HeldTick<L>) -> L;
}

/// Defines the settings and the enum of the built-in holds, one line each: word and type, of those with settings also
/// their type.
macro_rules! holds {
    (
        plain { $($(#[doc = $plain_doc:literal])* $plain_word:literal => $Plain:ident,)* }
        set { $($(#[doc = $doc:literal])* $word:literal => $Hold:ident($Settings:ident),)* }
    ) => {
        crate::choice! {
            /// What holds the slave during an event: a freeze, a speed limit, a region that it must not enter, or nothing.
            #[derive(Debug, Clone, Copy, PartialEq)]
            pub enum HoldSettings at "augmentation.hold" = Frozen {
                $($(#[doc = $plain_doc])* $plain_word => $Plain,)*
                $($(#[doc = $doc])* $word => $Hold($Settings),)*
            }
        }

        /// Any of the built-in holds.
        #[derive(Debug, Clone)]
        pub enum AnyHold<L> {
            $(#[doc = concat!("See [`", stringify!($Plain), "`].")] $Plain,)*
            $(#[doc = concat!("See [`", stringify!($Hold), "`].")] $Hold($Hold<L>),)*
        }

        impl<L: Lane> AnyHold<L> {
            /// The hold of the settings, on ticks `tick_s` apart (s).
            #[must_use]
            pub fn new(settings: &HoldSettings, tick_s: f64) -> Self {
                match settings {
                    $(HoldSettings::$Plain => Self::$Plain,)*
                    $(HoldSettings::$Hold(settings) => Self::$Hold($Hold::new(settings, tick_s)),)*
                }
            }
        }

        impl<L: Lane> Hold<L> for AnyHold<L> {
            #[inline(always)]
            fn reference_m(&self, now: &HeldTick<L>) -> L {
                match self {
                    $(Self::$Plain => $Plain.reference_m(now),)*
                    $(Self::$Hold(hold) => hold.reference_m(now),)*
                }
            }
        }

        crate::lane::gather_variants!(AnyHold { $($Hold),* } empty { $($Plain),* } stored);
    };
}

holds! {
    plain {
        /// It is frozen.
        "freeze" => Frozen,
        /// It follows the hand.
        "none" => Following,
    }
    set {
        /// It follows the hand at a bounded speed.
        "speed-limit" => SpeedLimit(SpeedLimitSettings),
        /// It follows the hand, but not beyond where it was at the alarm.
        "forbidden-region" => ForbiddenRegion(ForbiddenRegionSettings),
    }
}
