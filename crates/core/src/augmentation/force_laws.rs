//! The role of the force law, and the built-in laws: the feedback force while the slave is frozen.
//!
//! A built-in law is one file of this folder and one line of [`force_laws!`].

mod amplify;
mod damp;
mod decay;

pub use amplify::{Amplify, AmplifySettings};
pub use damp::{Damp, DampSettings};
pub use decay::{Decay, DecaySettings};

use crate::lane::Lane;

/// Inputs of a force law at a tick.
#[derive(Debug, Clone, Copy)]
pub struct AugmentedTick<L: Lane> {
    /// `F*`: the feedback force just before the alarm, in N.
    pub anchor_n: L,
    /// `F⁻`: the feedback force at the tick before, in N.
    pub last_n: L,
    /// `F_e`: the measured force, scaled to the master, in N.
    pub measured_n: L,
    /// Magnitude of its change since the tick before, in N.
    pub moved_n: L,
    /// The master's velocity in m/s.
    pub velocity_m_per_s: L,
    /// Lanes in the first tick of the event.
    pub begins: L::Mask,
}

/// Gives the feedback force while the slave is frozen.
///
/// The return to the measured force is the same for all laws: a cross-fade from the law's last force. A user-defined
/// law implements this for `f64`; the built-in laws for any number of lanes.
pub trait ForceLaw<L: Lane> {
    /// The feedback force, and its largest allowed change from the last tick, both in N.
    ///
    /// Called at ticks at which any lane is frozen; the results of the other lanes are not used.
    fn augmented(&mut self, now: &AugmentedTick<L>) -> (L, L);
}

#[cfg(feature = "alloc")]
impl<L: Lane, F: ForceLaw<L> + ?Sized> ForceLaw<L> for alloc::boxed::Box<F> {
    fn augmented(&mut self, now: &AugmentedTick<L>) -> (L, L) {
        (**self).augmented(now)
    }
}

/// A built-in force law, built from settings.
trait BuiltIn<L>: ForceLaw<L>
where
    L: Lane,
{
    /// Its settings.
    type Settings;

    /// The law of the settings on ticks `tick_s` apart (s).
    fn build(settings: &Self::Settings, tick_s: f64) -> Self;
}

/// Defines the settings and the enum of the built-in force laws, one line each: word, type, type of the settings.
macro_rules! force_laws {
    ($($word:literal => $Law:ident($Settings:ident),)*) => {
        crate::choice! {
            /// Let the feedback force decay, scale its variation, or add damping of the master.
            ///
            /// `F*` is the feedback force just before the alarm.
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

        crate::lane::gather_variants!(AnyForceLaw { $($Law),* } stored);
    };
}

force_laws! {
    "decay" => Decay(DecaySettings),
    "amplify" => Amplify(AmplifySettings),
    "damp" => Damp(DampSettings),
}
