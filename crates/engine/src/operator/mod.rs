//! The operator: the desired position towards which the arm pulls the master.

mod hand;
mod kind;
mod motion;
mod perception;
mod reflex;
mod stiffening;
mod stretch;
mod tremor;

pub use hand::Hand;
pub use kind::{
    EndSettings, InsertionExtractionSettings, MinimumJerkSettings, MotionSettings, MovementSettings, RampSettings,
    SineSettings, StartSettings,
};
pub use motion::{insertion_extraction, minimum_jerk, sine};
pub use perception::{Perception, PerceptionSettings};
pub use reflex::{Reflex, ReflexSettings};
pub use stiffening::StiffeningSettings;
pub use stretch::StretchSettings;
pub use tremor::TremorSettings;

use reflex::Reaction;
use stiffening::Stiffening;
use stretch::Stretch;

use std::sync::Arc;

use trocar_core::error::{InvalidValue, finite};
use trocar_core::lane::{Lane, Mask};

/// Largest distance of the desired position from 0, in m. A run beyond it has diverged.
pub const MAX_POSITION_M: f64 = 1.0;

/// The kinds of motion. The desired position is linear between ticks.
#[derive(Debug, Clone)]
pub enum Motion<L> {
    /// A recorded or computed motion, one position per tick; the last one is held after the end.
    Recording(Arc<[f64]>),
    /// A constant speed from a start to an end.
    Ramp(Ramp<L>),
    /// The motion of a live hand.
    Hand(Arc<Hand>),
}

/// Gives the operator's desired position of the master.
///
/// A user-defined operator implements this for `f64`; [`HumanOperator`] and [`Replay`] for any number of lanes.
pub trait Operator<L: Lane> {
    /// The desired position at `tick` in m, given the felt force `felt_n` (N) at the tick before. Called once per tick,
    /// starting at 0.
    fn desired_position_m(&mut self, tick: u64, felt_n: L) -> L;

    /// The position in m that the operator means to reach, at the tick of the last desired position `desired_m` (m).
    ///
    /// It is the desired position without what the hand does involuntarily, such as a tremor.
    #[inline(always)]
    fn intended_position_m(&self, desired_m: L) -> L {
        desired_m
    }

    /// Receives the position of the master in m, before the desired position of the next tick.
    #[inline(always)]
    fn master(&mut self, _position_m: L) {}

    /// Receives whether a cue on the skin is on. Called before the desired position of the next tick.
    #[inline(always)]
    fn cue(&mut self, _is_on: L::Mask) {}

    /// Whether the operator noticed a change of the felt force, at the tick of the last desired position.
    #[inline(always)]
    fn notices(&self) -> L::Mask {
        L::Mask::splat(false)
    }
}

impl<L: Lane, O: Operator<L> + ?Sized> Operator<L> for Box<O> {
    #[inline(always)]
    fn desired_position_m(&mut self, tick: u64, felt_n: L) -> L {
        (**self).desired_position_m(tick, felt_n)
    }

    #[inline(always)]
    fn intended_position_m(&self, desired_m: L) -> L {
        (**self).intended_position_m(desired_m)
    }

    #[inline(always)]
    fn master(&mut self, position_m: L) {
        (**self).master(position_m);
    }

    #[inline(always)]
    fn cue(&mut self, is_on: L::Mask) {
        (**self).cue(is_on);
    }

    #[inline(always)]
    fn notices(&self) -> L::Mask {
        (**self).notices()
    }
}

/// A motion known in advance: one position per tick in m; the last one is held after the end.
#[derive(Debug, Clone)]
pub struct Replay(pub Arc<[f64]>);

impl<L: Lane> Operator<L> for Replay {
    #[inline(always)]
    fn desired_position_m(&mut self, tick: u64, _felt_n: L) -> L {
        recorded(&self.0, tick)
    }
}

impl trocar_core::lane::Gather for Replay {
    type Of<L: Lane> = Self;

    fn gather<L: Lane>(all: [&Self; trocar_core::lane::LANES]) -> Option<Self> {
        trocar_core::lane::same_list(trocar_core::lane::of_each!(all, |one| &one.0)).then(|| all[0].clone())
    }
}

/// A human operator: the intended motion, the hand's tremor, its reflexes and grip, and the reaction to the felt force.
#[derive(Debug, Clone)]
pub struct HumanOperator<L: Lane> {
    motion: Motion<L>,
    tremor: Option<Arc<[L]>>,
    reaction: Option<Reaction<L>>,
    stretch: Option<Stretch<L>>,
    stiffening: Option<Stiffening<L>>,
    /// The position at the last tick without what the hand does involuntarily.
    intended_m: L,
    /// How far the master was beyond it at the last tick, in m.
    stretch_m: L,
    /// Lanes in which it was less deep than at the tick before.
    withdraws: L::Mask,
}

/// `x_d = start + speed · t` until `end` is reached, then `end`.
#[derive(Debug, Clone, Copy)]
pub struct Ramp<L> {
    start: L,
    step: L,
    low: L,
    high: L,
}

impl<L: Lane> Ramp<L> {
    /// A ramp from `start_m` at `speed_m_per_s` (either sign) to `end_m`, on ticks `tick_s` apart.
    ///
    /// # Errors
    /// [`InvalidValue`] naming the argument that is not finite.
    pub fn new(start_m: f64, end_m: f64, speed_m_per_s: f64, tick_s: f64) -> Result<Self, InvalidValue> {
        finite("operator.start_m", start_m)?;
        finite("operator.end_m", end_m)?;
        finite("operator.speed_m_per_s", speed_m_per_s)?;
        Ok(Self {
            start: L::splat(start_m),
            step: L::splat(speed_m_per_s.abs() * (end_m - start_m).signum() * tick_s),
            low: L::splat(start_m.min(end_m)),
            high: L::splat(start_m.max(end_m)),
        })
    }
}

/// The position of a recorded motion at `tick`, in m; the last one is held after the end.
#[inline(always)]
pub fn recorded<L: Lane>(positions: &[f64], tick: u64) -> L {
    let held = || positions.last().copied().unwrap_or(0.0);
    L::splat(positions.get(tick as usize).copied().unwrap_or_else(held))
}

impl<L: Lane> Motion<L> {
    /// The desired position in m at a time of the motion in ticks.
    #[inline(always)]
    fn at(&self, ticks: L) -> L {
        match self {
            Self::Recording(positions) => L::from_lanes(|lane| recorded(positions, ticks.lane(lane) as u64)),
            Self::Ramp(ramp) => (ramp.start + ramp.step * ticks).clamp(ramp.low, ramp.high),
            Self::Hand(hand) => L::splat(hand.position_m()),
        }
    }
}

impl<L: Lane> HumanOperator<L> {
    /// An operator without tremor who does not react to the felt force.
    #[must_use]
    pub fn new(motion: Motion<L>) -> Self {
        Self {
            motion,
            tremor: None,
            reaction: None,
            stretch: None,
            stiffening: None,
            intended_m: L::zero(),
            stretch_m: L::zero(),
            withdraws: L::Mask::splat(false),
        }
    }

    /// Adds a tremor: one displacement in m per tick, as from [`TremorSettings::displacements`].
    #[must_use]
    pub fn trembling(mut self, displacements_m: Arc<[L]>) -> Self {
        self.tremor = Some(displacements_m);
        self
    }

    /// Adds stretch reflexes of an arm of the static stiffness `stiffness_n_per_m` (N/m), and a grip that stiffens, if the settings
    /// have them; on ticks of `tick_s` (s).
    #[must_use]
    pub fn tensing(
        mut self,
        stretch: &StretchSettings,
        stiffening: &StiffeningSettings,
        stiffness_n_per_m: f64,
        tick_s: f64,
    ) -> Self {
        self.stretch = Stretch::new(stretch, stiffness_n_per_m, tick_s);
        self.stiffening = Stiffening::new(stiffening, tick_s);
        self
    }

    /// Adds what the operator notices of the felt force, and the reaction to it, if the settings have one of them; lane `i`
    /// uses stream `first_stream + i` of the seed, on ticks of `tick_s` (s).
    #[must_use]
    pub fn reacting(
        mut self,
        reflex: &ReflexSettings,
        perception: &Perception,
        (seed, first_stream): (u64, u64),
        tick_s: f64,
    ) -> Self {
        let is_any = reflex.reacts() || perception.settings().is_some();
        self.reaction = is_any.then(|| Reaction::new(reflex, perception, (seed, first_stream), tick_s));
        self
    }
}

impl HumanOperator<f64> {
    /// Rests at the desired position of `tick`, which is the last one given. Stretch reflexes and grip go on: they answer to the
    /// master's motion and belong to the loop.
    pub fn rest(&mut self, tick: u64) {
        let displacement_m = self.tremor.take().and_then(|all| all.get(tick as usize).copied());
        self.intended_m += displacement_m.unwrap_or(0.0);
        self.motion = Motion::Recording(Arc::new([self.intended_m]));
        self.reaction = None;
    }
}

impl<L: Lane> Operator<L> for HumanOperator<L> {
    #[inline(always)]
    fn desired_position_m(&mut self, tick: u64, felt_n: L) -> L {
        let intended = match &mut self.reaction {
            Some(reaction) if tick > 0 => {
                let (motion_ticks, withdrawn_m) = reaction.step(tick, felt_n, self.withdraws);
                self.motion.at(motion_ticks) - withdrawn_m
            }
            _ => self.motion.at(L::splat(tick as f64)),
        };
        self.withdraws = intended.lt(self.intended_m);
        self.intended_m = intended;
        let mut desired = intended;
        if let Some(displacements) = &self.tremor {
            desired = desired + displacements.get(tick as usize).copied().unwrap_or(L::zero());
        }
        if let Some(stretch) = &mut self.stretch {
            desired = desired + stretch.step(self.stretch_m);
        }
        if let Some(stiffening) = &mut self.stiffening {
            desired = desired + stiffening.step(felt_n, self.stretch_m);
        }
        desired
    }

    #[inline(always)]
    fn master(&mut self, position_m: L) {
        self.stretch_m = position_m - self.intended_m;
    }

    #[inline(always)]
    fn intended_position_m(&self, _desired_m: L) -> L {
        self.intended_m
    }

    #[inline(always)]
    fn cue(&mut self, is_on: L::Mask) {
        if let Some(reaction) = &mut self.reaction {
            reaction.cue(is_on);
        }
    }

    #[inline(always)]
    fn notices(&self) -> L::Mask {
        match &self.reaction {
            Some(reaction) => reaction.has_noticed(),
            None => L::Mask::splat(false),
        }
    }
}

trocar_core::lane::gather!(HumanOperator { motion, tremor, reaction, stretch, stiffening, intended_m, stretch_m } masks { withdraws });
trocar_core::lane::gather!(Ramp { start, step, low, high });

impl trocar_core::lane::Gather for Motion<f64> {
    type Of<L: Lane> = Motion<L>;

    fn gather<L: Lane>(all: [&Self; trocar_core::lane::LANES]) -> Option<Motion<L>> {
        use trocar_core::lane::{of_each, same_list};
        match all[0] {
            Self::Recording(positions) => {
                let lists = of_each!(all, |one| {
                    let Self::Recording(list) = one else { return None };
                    list
                });
                same_list(lists).then(|| Motion::Recording(positions.clone()))
            }
            Self::Ramp(_) => {
                let ramps = of_each!(all, |one| {
                    let Self::Ramp(ramp) = one else { return None };
                    ramp
                });
                trocar_core::lane::Gather::gather(ramps).map(Motion::Ramp)
            }
            // Live hands cannot be combined.
            Self::Hand(_) => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ramp_ends_where_it_should_in_either_direction() {
        let at = |start, end, tick| {
            let ramp = Ramp::<f64>::new(start, end, 0.01, 1e-3).expect("valid");
            HumanOperator::new(Motion::Ramp(ramp)).desired_position_m(tick, 0.0)
        };
        assert_eq!(at(0.0, 0.02, 0), 0.0);
        assert!((at(0.0, 0.02, 500) - 0.005).abs() < 1e-15);
        assert_eq!(at(0.0, 0.02, 5000), 0.02);
        assert!((at(0.02, 0.0, 500) - 0.015).abs() < 1e-15);
        assert_eq!(at(0.02, 0.0, 5000), 0.0);
    }
}
