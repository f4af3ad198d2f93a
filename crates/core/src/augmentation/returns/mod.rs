mod clutch;
mod fade;
mod ramp;
mod ramp_until_load;
mod snap;
mod when_still;

pub use clutch::Clutch;
pub use fade::{Fade, FadeSettings};
pub use ramp::{Ramp, RampSettings};
pub use ramp_until_load::{RampUntilLoad, RampUntilLoadSettings};
pub use snap::Snap;
pub use when_still::{WhenStill, WhenStillSettings};

use super::BuiltIn;
use crate::lane::{Lane, Mask};

/// Inputs at a tick, on the slave's scale.
#[derive(Debug, Clone, Copy)]
pub struct ReturnTick<L: Lane> {
    /// Slave's reference minus hand, one tick before.
    pub gap_m: L,
    /// Of the hand since the tick before.
    pub hand_step_m: L,
    /// The last one of the event, in teleoperation.
    pub force_n: L,
    /// Lanes released at this tick.
    pub begins: L::Mask,
}

/// Closes or keeps the gap.
pub trait Return<L: Lane> {
    /// True if the gap also changes in teleoperation.
    const CONTINUES: bool = false;

    /// In m; ignored in held lanes.
    fn gap_m(&mut self, now: &ReturnTick<L>) -> L;

    /// Lanes in which the event may end with this gap (m).
    #[inline(always)]
    fn may_end(&self, _gap_m: L) -> L::Mask {
        L::Mask::splat(true)
    }
}

/// For the certificate of events.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ReturnMap {
    /// Closed when the event ends.
    Closes,
    /// Closed at once.
    Jumps,
    /// Closed exponentially, also after the event.
    Fades {
        /// In s.
        time_constant_s: f64,
    },
    /// Kept.
    Keeps,
}

#[inline(always)]
fn closed_by<L: Lane>(gap_m: L, step: L) -> L {
    gap_m - gap_m.clamp(-step, step)
}

crate::registry! {
    /// How the gap to the hand closes after a hold.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub enum Reengage at "augmentation.reengage" = Ramp;
    /// Any built-in return.
    pub enum AnyReturn<L> by (each, of_kind) stored;

    "ramp" => Ramp(RampSettings) = ramp::Ramp,
    "ramp-until-load" => RampUntilLoad(RampUntilLoadSettings) = ramp_until_load::RampUntilLoad,
    "fade" => Fade(FadeSettings) = fade::Fade,
    "when-still" => WhenStill(WhenStillSettings) = when_still::WhenStill,
    "clutch" => Clutch = clutch::Clutch,
    /// Throws the needle; included to show the danger.
    "snap" => Snap = snap::Snap,
}

impl Reengage {
    /// `None` if the certificate does not cover it.
    #[must_use]
    pub fn map(&self) -> Option<ReturnMap> {
        of_kind!(self, Part(kind_settings) => Part::<f64>::map(kind_settings))
    }
}

impl<L: Lane> AnyReturn<L> {
    /// For ticks of `tick_s`.
    #[must_use]
    pub fn new(settings: &Reengage, tick_s: f64) -> Self {
        of_kind!(settings, Part(kind_settings) => Part::<L>::build(kind_settings, tick_s).into())
    }

    /// [`Return::CONTINUES`] of the return.
    #[inline(always)]
    pub fn continues(&self) -> bool {
        fn of<L: Lane, R: Return<L>>(_: &R) -> bool {
            R::CONTINUES
        }
        each!(self, one => of::<L, _>(one))
    }
}

impl<L: Lane> Return<L> for AnyReturn<L> {
    #[inline(always)]
    fn gap_m(&mut self, now: &ReturnTick<L>) -> L {
        each!(self, one => one.gap_m(now))
    }

    #[inline(always)]
    fn may_end(&self, gap_m: L) -> L::Mask {
        each!(self, one => one.may_end(gap_m))
    }
}
