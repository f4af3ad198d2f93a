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

/// Inputs at a tick.
#[derive(Debug, Clone, Copy)]
pub struct AugmentedTick<L: Lane> {
    /// `F*`: feedback force just before the alarm.
    pub anchor_n: L,
    /// `F⁻`: feedback force at the tick before.
    pub last_n: L,
    /// `F_e`: measured force scaled to the master.
    pub measured_n: L,
    /// `|ΔF_e|`.
    pub moved_n: L,
    /// Of the master.
    pub velocity_m_per_s: L,
    /// Lanes in the first tick of the event.
    pub begins: L::Mask,
}

/// User-defined laws implement it for `f64`.
pub trait ForceLaw<L: Lane> {
    /// The force and its largest allowed change, both in N.
    fn augmented(&mut self, now: &AugmentedTick<L>) -> (L, L);
}

/// For the certificate of events.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ForceMap {
    /// Towards a share of the force at the alarm.
    Decays {
        /// Remaining share.
        ratio: f64,
        /// In s.
        time_constant_s: f64,
    },
    /// `max(F* + gain · (F_e - F*), floor)`.
    FollowsTissue {
        /// The gain.
        gain: f64,
    },
    /// Force of teleoperation plus a rising damping.
    IsDamped {
        /// Largest damping.
        damping_n_s_per_m: f64,
    },
}

#[cfg(feature = "alloc")]
impl<L: Lane, F: ForceLaw<L> + ?Sized> ForceLaw<L> for alloc::boxed::Box<F> {
    fn augmented(&mut self, now: &AugmentedTick<L>) -> (L, L) {
        (**self).augmented(now)
    }
}

crate::registry! {
    /// Let the feedback force decay, scale its variation, add damping of the master, or guide it back to the needle.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub enum ForceLawSettings at "augmentation.force_law" = Decay;
    /// Any built-in force law.
    pub enum AnyForceLaw<L> by (each, of_kind) stored;

    "decay" => Decay(DecaySettings) = decay::Decay,
    "amplify" => Amplify(AmplifySettings) = amplify::Amplify,
    "damp" => Damp(DampSettings) = damp::Damp,
    "guide" => Guide(GuideSettings) = guide::Guide,
}

impl ForceLawSettings {
    /// `None` if the certificate does not cover it.
    #[must_use]
    pub fn map(&self) -> Option<ForceMap> {
        of_kind!(self, Part(kind_settings) => Part::<f64>::map(kind_settings))
    }
}

impl<L: Lane> AnyForceLaw<L> {
    /// For ticks of `tick_s`.
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

#[cfg(test)]
mod tests {
    use super::*;

    /// The smallest and the largest force of a map, in N.
    fn of_map(map: ForceMap, now: &AugmentedTick<f64>, tick_s: f64) -> (f64, f64) {
        let between = |a: f64, b: f64| (a.min(b), a.max(b));
        match map {
            ForceMap::Decays { ratio, time_constant_s } => {
                let keep = (-tick_s / time_constant_s).exp();
                let force_n = now.last_n * keep + ratio * now.anchor_n * (1.0 - keep);
                (force_n, force_n)
            }
            ForceMap::FollowsTissue { gain } => {
                between(now.anchor_n, now.anchor_n + gain * (now.measured_n - now.anchor_n))
            }
            ForceMap::IsDamped { damping_n_s_per_m } => {
                between(now.measured_n, now.measured_n + damping_n_s_per_m * now.velocity_m_per_s)
            }
        }
    }

    #[test]
    fn each_law_with_a_map_gives_a_force_of_its_map() {
        let tick_s = 1e-3;
        let laws = of_kind!([WORD, Part] => {
            let settings = Default::default();
            (WORD, Part::<f64>::map(&settings), AnyForceLaw::<f64>::from(Part::build(&settings, tick_s)))
        });
        let mut covered = 0;
        for (word, map, mut law) in laws {
            let Some(map) = map else { continue };
            covered += 1;
            let (mut last_n, anchor_n) = (3.0, 3.0);
            for tick in 0..200 {
                let phase = 0.1 * f64::from(tick);
                let now = AugmentedTick {
                    anchor_n,
                    last_n,
                    measured_n: 3.0 + 2.0 * phase.sin(),
                    moved_n: 0.2,
                    velocity_m_per_s: 0.1 * phase.cos(),
                    begins: tick == 0,
                };
                let (low, high) = of_map(map, &now, tick_s);
                (last_n, _) = law.augmented(&now);
                assert!((low - 1e-12..=high + 1e-12).contains(&last_n), "{word} at {tick}: {low} {last_n} {high}");
            }
        }
        assert!(covered >= 3);
    }
}
