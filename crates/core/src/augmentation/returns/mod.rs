//! The return closes the gap between the slave's reference and the hand after a hold.
//!
//! A built-in return is one file of this folder and one line of the registry below.

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

/// Inputs of a return at a tick: positions in m, on the slave's scale.
#[derive(Debug, Clone, Copy)]
pub struct ReturnTick<L: Lane> {
    /// The gap at the tick before: the slave's reference minus the hand's position. At the release, the gap with which the
    /// reference does not jump.
    pub gap_m: L,
    /// Motion of the hand since the tick before.
    pub hand_step_m: L,
    /// The measured force in N; the last one of the event in teleoperation.
    pub force_n: L,
    /// Lanes that are released at this tick.
    pub begins: L::Mask,
}

/// Closes the gap, or leaves it.
pub trait Return<L: Lane> {
    /// True if the gap also changes in teleoperation, after the event.
    const CONTINUES: bool = false;

    /// The gap in m. Called at each tick of an event, and in teleoperation if the return continues. Lanes that are held
    /// ignore the result.
    fn gap_m(&mut self, now: &ReturnTick<L>) -> L;

    /// The lanes in which the event may end with this gap (m): all, unless the return must close it first.
    #[inline(always)]
    fn may_end(&self, _gap_m: L) -> L::Mask {
        L::Mask::splat(true)
    }
}

/// The gap after an event as a linear map, for the certificate of events.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ReturnMap {
    /// It only shrinks, and is closed when the event ends.
    Closes,
    /// It closes at once.
    Jumps,
    /// It closes exponentially, also after the event.
    Fades {
        /// Time constant in s.
        time_constant_s: f64,
    },
    /// It is kept.
    Keeps,
}

/// The gap after it has closed by at most `step`.
#[inline(always)]
fn closed_by<L: Lane>(gap_m: L, step: L) -> L {
    gap_m - gap_m.clamp(-step, step)
}

crate::registry! {
    /// How the gap to the hand closes after a hold.
    ///
    /// During the freeze the hand moves on by millimetres.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub enum Reengage at "augmentation.reengage" = Ramp;
    /// Any of the built-in returns.
    pub enum AnyReturn<L> by (each, of_kind) stored;

    /// The gap closes at a bounded speed, in addition to the hand's motion.
    "ramp" => Ramp(RampSettings) = ramp::Ramp,
    /// The gap closes at a bounded speed until the force rises; the remaining gap is kept.
    "ramp-until-load" => RampUntilLoad(RampUntilLoadSettings) = ramp_until_load::RampUntilLoad,
    /// The gap closes exponentially, also after the event.
    "fade" => Fade(FadeSettings) = fade::Fade,
    /// The gap closes while the hand stands still or moves back, also after the event.
    "when-still" => WhenStill(WhenStillSettings) = when_still::WhenStill,
    /// The gap is kept: the slave continues from its frozen position.
    "clutch" => Clutch = clutch::Clutch,
    /// The gap closes at once, which throws the needle. Included to show the danger.
    "snap" => Snap = snap::Snap,
}

impl Reengage {
    /// The return as a linear map; `None` if the certificate of events does not cover it.
    #[must_use]
    pub fn map(&self) -> Option<ReturnMap> {
        of_kind!(self, Part(kind_settings) => Part::<f64>::map(kind_settings))
    }
}

impl<L: Lane> AnyReturn<L> {
    /// Creates the return of the settings for ticks of `tick_s`.
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
