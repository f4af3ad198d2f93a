//! The role of the force law, and the built-in ones: what the hand feels while the slave is frozen.

mod amplify;
mod decay;

pub use amplify::Amplify;
pub use decay::Decay;

use crate::error::{InvalidValue, finite, non_negative, positive, require};
use crate::lane::Lane;

/// What a force law goes by at a tick.
#[derive(Debug, Clone, Copy)]
pub struct AugmentedTick<L: Lane> {
    /// `F*`: the force fed back just before the alarm, in N.
    pub anchor_n: L,
    /// `F⁻`: the force fed back at the tick before, in N.
    pub last_n: L,
    /// `F_e`: the measured force, scaled to the master, in N.
    pub measured_n: L,
    /// By how much it has moved since the tick before, in N.
    pub moved_n: L,
    /// Where this is the first tick of the event.
    pub begins: L::Mask,
}

/// Gives the force that is fed back while the slave is frozen.
///
/// The way back to the measured force is the same for all of them: a cross-fade from the law's last force. A law of one's own
/// implements this for `f64`; the built-in ones do for any number of lanes.
pub trait ForceLaw<L: Lane> {
    /// The force to feed back, and the most by which the law lets it differ from the last tick's, both in N.
    ///
    /// Called at ticks at which some lane is frozen; what it gives for the other lanes is not used.
    fn augmented(&mut self, now: &AugmentedTick<L>) -> (L, L);
}

#[cfg(feature = "alloc")]
impl<L: Lane, F: ForceLaw<L> + ?Sized> ForceLaw<L> for alloc::boxed::Box<F> {
    fn augmented(&mut self, now: &AugmentedTick<L>) -> (L, L) {
        (**self).augmented(now)
    }
}

/// What the hand feels while the slave is frozen. `F*` is the force fed back just before the alarm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ForceLawSettings {
    /// `F* → ratio · F*`, exponentially: the same crisp drop at every rupture, whatever its size.
    Decay {
        /// Where the force goes, as a share of `F*`, from 0 to 1.
        ratio: f64,
        /// Time constant in s, above 0.
        time_constant_s: f64,
    },
    /// `F* + κ (F_e - F*)`, floored at 0: the measured variation is scaled, and its size still tells.
    Amplify {
        /// κ, at least 1.
        gain: f64,
    },
}

impl ForceLawSettings {
    /// Checks the ranges that the fields state.
    ///
    /// # Errors
    /// [`InvalidValue`] naming the setting out of range.
    pub fn validate(&self) -> Result<(), InvalidValue> {
        match *self {
            Self::Decay { ratio, time_constant_s } => {
                non_negative("augmentation.decay_ratio", ratio)?;
                require("augmentation.decay_ratio", ratio, ratio <= 1.0, "from 0 to 1")?;
                positive("augmentation.decay_time_constant_s", time_constant_s)?;
            }
            Self::Amplify { gain } => {
                finite("augmentation.amplification", gain)?;
                require("augmentation.amplification", gain, gain >= 1.0, "at least 1")?;
            }
        }
        Ok(())
    }
}

impl Default for ForceLawSettings {
    fn default() -> Self {
        Self::Decay { ratio: 0.0, time_constant_s: 0.03 }
    }
}

/// The enum of the built-in force laws, from a line each.
macro_rules! force_laws {
    ($($Part:ident,)*) => {
        /// Any of the built-in force laws.
        #[derive(Debug, Clone)]
        pub enum AnyForceLaw<L> {
            $(#[doc = concat!("See [`", stringify!($Part), "`].")] $Part($Part<L>),)*
        }

        impl<L: Lane> ForceLaw<L> for AnyForceLaw<L> {
            #[inline(always)]
            fn augmented(&mut self, now: &AugmentedTick<L>) -> (L, L) {
                match self {
                    $(Self::$Part(part) => part.augmented(now),)*
                }
            }
        }

        crate::lane::gather_variants!(AnyForceLaw { $($Part),* });
    };
}

force_laws! {
    Decay,
    Amplify,
}

impl<L: Lane> AnyForceLaw<L> {
    /// The law of the settings, on ticks `tick_s` apart (s).
    #[must_use]
    pub fn new(settings: &ForceLawSettings, tick_s: f64) -> Self {
        match *settings {
            ForceLawSettings::Decay { ratio, time_constant_s } => {
                Self::Decay(Decay::new(ratio, time_constant_s, tick_s))
            }
            ForceLawSettings::Amplify { gain } => Self::Amplify(Amplify::new(gain)),
        }
    }
}
