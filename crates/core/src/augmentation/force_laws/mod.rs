//! The force law gives the feedback force while the slave is frozen.
//!
//! A built-in law is one file of this folder and one line of the registry below.

mod amplify;
mod damp;
mod decay;
mod guide;

pub use amplify::{Amplify, AmplifySettings};
pub use damp::{Damp, DampSettings};
pub use decay::{Decay, DecaySettings};
pub use guide::{Guide, GuideSettings};

use super::BuiltIn;
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
    /// Magnitude of the change of `measured_n` since the tick before, in N.
    pub moved_n: L,
    /// The master's velocity in m/s.
    pub velocity_m_per_s: L,
    /// Lanes in the first tick of the event.
    pub begins: L::Mask,
}

/// Gives the feedback force while the slave is frozen.
///
/// All laws return to the measured force by the same cross-fade, from the law's last force. A user-defined law
/// implements this trait for `f64`, the built-in laws for any number of lanes.
pub trait ForceLaw<L: Lane> {
    /// The feedback force and its largest allowed change from the last tick, both in N.
    ///
    /// Called at ticks at which any lane is frozen; the results of the other lanes are ignored.
    fn augmented(&mut self, now: &AugmentedTick<L>) -> (L, L);
}

#[cfg(feature = "alloc")]
impl<L: Lane, F: ForceLaw<L> + ?Sized> ForceLaw<L> for alloc::boxed::Box<F> {
    fn augmented(&mut self, now: &AugmentedTick<L>) -> (L, L) {
        (**self).augmented(now)
    }
}

crate::registry! {
    /// Let the feedback force decay, scale its variation, add damping of the master, or guide it back to the needle.
    ///
    /// `F*` is the feedback force just before the alarm.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub enum ForceLawSettings at "augmentation.force_law" = Decay;
    /// Any of the built-in force laws.
    pub enum AnyForceLaw<L> by (each, of_kind) stored;

    "decay" => Decay(DecaySettings) = decay::Decay,
    "amplify" => Amplify(AmplifySettings) = amplify::Amplify,
    "damp" => Damp(DampSettings) = damp::Damp,
    "guide" => Guide(GuideSettings) = guide::Guide,
}

impl<L: Lane> AnyForceLaw<L> {
    /// Creates the law of the settings for ticks of `tick_s`.
    #[must_use]
    pub fn new(settings: &ForceLawSettings, tick_s: f64) -> Self {
        of_kind!(settings, Part(kind_settings) => Part::<L>::build(kind_settings, tick_s).into())
    }
}

impl<L: Lane> ForceLaw<L> for AnyForceLaw<L> {
    #[inline(always)]
    fn augmented(&mut self, now: &AugmentedTick<L>) -> (L, L) {
        each!(self, law => law.augmented(now))
    }
}
