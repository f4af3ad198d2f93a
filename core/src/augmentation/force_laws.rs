//! The role of the force law, and the built-in ones: what the hand feels while the slave is frozen.
//!
//! A built-in law is one file of this folder and one line of [`force_laws!`].

mod amplify;
mod decay;

pub use amplify::{Amplify, AmplifySettings};
pub use decay::{Decay, DecaySettings};

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

/// A built-in force law: made of settings.
trait BuiltIn<L>: ForceLaw<L>
where
    L: Lane,
{
    /// Its settings.
    type Settings;

    /// The law of the settings on ticks `tick_s` apart (s).
    fn build(settings: &Self::Settings, tick_s: f64) -> Self;
}

/// The settings and the enum of the built-in force laws, from a line each: word, type, type of the settings.
macro_rules! force_laws {
    ($($word:literal => $Law:ident($Settings:ident),)*) => {
        crate::choice! {
            /// Let the felt force decay, or scale its variation.
            ///
            /// `F*` is the force fed back just before the alarm.
            #[derive(Debug, Clone, Copy, PartialEq)]
            pub enum ForceLawSettings at "augmentation.force_law" = Decay {
                $($word => $Law($Settings),)*
            }
        }

        /// Any of the built-in force laws.
        #[derive(Debug, Clone)]
        pub enum AnyForceLaw<L> {
            $(#[doc = concat!("See [`", stringify!($Law), "`].")] $Law($Law<L>),)*
        }

        impl<L: Lane> AnyForceLaw<L> {
            /// The law of the settings, on ticks `tick_s` apart (s).
            #[must_use]
            pub fn new(settings: &ForceLawSettings, tick_s: f64) -> Self {
                match settings {
                    $(ForceLawSettings::$Law(settings) => Self::$Law(BuiltIn::build(settings, tick_s)),)*
                }
            }
        }

        impl<L: Lane> ForceLaw<L> for AnyForceLaw<L> {
            #[inline(always)]
            fn augmented(&mut self, now: &AugmentedTick<L>) -> (L, L) {
                match self {
                    $(Self::$Law(law) => law.augmented(now),)*
                }
            }
        }

        crate::lane::gather_variants!(AnyForceLaw { $($Law),* });
    };
}

force_laws! {
    "decay" => Decay(DecaySettings),
    "amplify" => Amplify(AmplifySettings),
}
