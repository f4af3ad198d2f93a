mod kind;
mod motion;
mod perception;
mod reflex;
mod stiffening;
mod stretch;
mod traits;
mod tremor;

pub use kind::{
    EndSettings, InsertionExtractionSettings, MinimumJerkSettings, MotionSettings, MovementSettings, RampSettings,
    SineSettings, StartSettings,
};
pub use motion::{insertion_extraction, minimum_jerk, sine};
pub use perception::{Perception, PerceptionSettings};
pub use reflex::{Reflex, ReflexSettings};
pub use stiffening::StiffeningSettings;
pub use stretch::StretchSettings;
pub use traits::OperatorTraits;
pub use tremor::TremorSettings;

use reflex::Reaction;
use stiffening::Stiffening;
use stretch::Stretch;

use std::sync::Arc;

use trocar_core::error::{InvalidValue, finite};
use trocar_core::lane::{Lane, Mask};

pub const MAX_POSITION_M: f64 = 1.0;

/// Linear between ticks.
#[derive(Debug, Clone)]
pub enum Motion<L> {
    Recording(Arc<[f64]>),
    Ramp(Ramp<L>),
}

/// A user-defined operator implements it for `f64`.
pub trait Operator<L: Lane> {
    /// Once per tick, from 0; `felt_n` is from the tick before.
    fn desired_position_m(&mut self, tick: u64, felt_n: L) -> L;

    /// Without involuntary motion such as tremor.
    #[inline(always)]
    fn intended_position_m(&self, desired_m: L) -> L {
        desired_m
    }

    #[inline(always)]
    fn master(&mut self, _position_m: L) {}

    #[inline(always)]
    fn cue(&mut self, _is_on: L::Mask) {}

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

#[derive(Debug, Clone)]
pub struct HumanOperator<L: Lane> {
    motion: Motion<L>,
    tremor: Option<Arc<[L]>>,
    reaction: Option<Reaction<L>>,
    stretch: Option<Stretch<L>>,
    stiffening: Option<Stiffening<L>>,
    intended_m: L,
    stretch_m: L,
    withdraws: L::Mask,
}

/// `x_d = start + speed · t`, up to `end`.
#[derive(Debug, Clone, Copy)]
pub struct Ramp<L> {
    start: L,
    step: L,
    low: L,
    high: L,
}

impl<L: Lane> Ramp<L> {
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

#[inline(always)]
pub fn recorded<L: Lane>(positions: &[f64], tick: u64) -> L {
    let held = || positions.last().copied().unwrap_or(0.0);
    L::splat(positions.get(tick as usize).copied().unwrap_or_else(held))
}

impl<L: Lane> Motion<L> {
    #[inline(always)]
    fn at(&self, ticks: L) -> L {
        match self {
            Self::Recording(positions) => L::from_lanes(|lane| recorded(positions, ticks.lane(lane) as u64)),
            Self::Ramp(ramp) => (ramp.start + ramp.step * ticks).clamp(ramp.low, ramp.high),
        }
    }
}

impl<L: Lane> HumanOperator<L> {
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

    pub fn trembling(mut self, displacements_m: Arc<[L]>) -> Self {
        self.tremor = Some(displacements_m);
        self
    }

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
    /// Stretch reflexes and grip belong to the loop and continue.
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
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::ops::Range;

    #[test]
    fn a_ramp_reaches_its_end_in_either_direction() {
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

    fn ramp() -> HumanOperator<f64> {
        HumanOperator::new(Motion::Ramp(Ramp::new(0.0, 0.02, 0.01, 1e-3).expect("valid")))
    }

    #[test]
    fn the_sign_of_a_speed_is_ignored_and_a_speed_must_be_finite() {
        let backwards = Ramp::<f64>::new(0.0, 0.02, -0.01, 1e-3).expect("valid");
        let position = HumanOperator::new(Motion::Ramp(backwards)).desired_position_m(500, 0.0);
        assert!((position - 0.005).abs() < 1e-15);
        for (start, end, speed, name) in [
            (f64::NAN, 0.0, 0.0, "operator.start_m"),
            (0.0, f64::INFINITY, 0.0, "operator.end_m"),
            (0.0, 0.0, f64::NAN, "operator.speed_m_per_s"),
        ] {
            assert_eq!(Ramp::<f64>::new(start, end, speed, 1e-3).expect_err("not finite").name, name);
        }
    }

    #[test]
    fn a_recorded_motion_is_held_after_its_end() {
        let positions: Arc<[f64]> = Arc::from([0.5, 0.25, 0.75]);
        let mut operator = HumanOperator::<f64>::new(Motion::Recording(positions.clone()));
        let mut replay = Replay(positions);
        for (tick, expected) in [(0, 0.5), (1, 0.25), (2, 0.75), (3, 0.75), (99, 0.75)] {
            assert_eq!(operator.desired_position_m(tick, 0.0), expected);
            assert_eq!(Operator::<f64>::desired_position_m(&mut replay, tick, 0.0), expected);
        }
        assert_eq!(recorded::<f64>(&[], 5), 0.0);
        assert!(!Operator::<f64>::notices(&replay) && Operator::<f64>::intended_position_m(&replay, 0.1) == 0.1);
    }

    #[test]
    fn a_tremor_is_added_to_the_motion_and_not_intended() {
        let mut operator = ramp().trembling(Arc::from([1e-4, -2e-4]));
        let positions: Vec<f64> = (0..3).map(|tick| operator.desired_position_m(tick, 0.0)).collect();
        assert!((positions[0] - 1e-4).abs() < 1e-15 && (positions[1] - (1e-5 - 2e-4)).abs() < 1e-15, "{positions:?}");
        assert!((positions[2] - 2e-5).abs() < 1e-15, "after the end of the tremor there is none");
        assert!((operator.intended_position_m(9.0) - 2e-5).abs() < 1e-15);
    }

    #[test]
    fn reflexes_and_grip_respond_to_the_stretch_beyond_the_intended_position() {
        let stretch = StretchSettings {
            long_gain_n_per_m: 100.0,
            long_delay_s: 0.0,
            activation_s: 0.0,
            ..StretchSettings::default()
        };
        let stiffening = StiffeningSettings { per_n: 0.5, limit: 1.0, time_s: 0.0 };
        let shift = |stretch: &StretchSettings, stiffening: &StiffeningSettings| {
            let mut operator: Box<dyn Operator<f64>> = Box::new(ramp().tensing(stretch, stiffening, 500.0, 1e-3));
            Operator::<f64>::desired_position_m(&mut operator, 100, 0.0);
            Operator::<f64>::master(&mut operator, 0.003);
            // 2 mm beyond 1 mm; the felt force is 1 N.
            Operator::<f64>::desired_position_m(&mut operator, 101, 1.0) - 1.01e-3
        };
        let none = (StretchSettings::default(), StiffeningSettings::default());
        assert!(shift(&none.0, &none.1).abs() < 1e-15);
        // The reflex: 100 N/m times 2 mm over 500 N/m shifts back by 0.4 mm. The grip, stiffer by half: back by 1 mm.
        assert!((shift(&stretch, &none.1) + 4e-4).abs() < 1e-15, "{}", shift(&stretch, &none.1));
        assert!((shift(&none.0, &stiffening) + 1e-3).abs() < 1e-15, "{}", shift(&none.0, &stiffening));
        assert!((shift(&stretch, &stiffening) + 1.4e-3).abs() < 1e-15);
    }

    fn reacting(reflex: Reflex) -> HumanOperator<f64> {
        let settings = ReflexSettings { reflex, reaction_min_s: 0.1, reaction_max_s: 0.1, ..ReflexSettings::default() };
        ramp().reacting(&settings, &Perception::None, (1, 0), 1e-3)
    }

    /// The ticks at which an operator notices a change. In a box, as user-defined operators are.
    fn noticed(operator: HumanOperator<f64>, cue: Range<u64>, felt_n: fn(u64) -> f64) -> Vec<u64> {
        let mut operator: Box<dyn Operator<f64>> = Box::new(operator);
        let mut notices = |tick: &u64| {
            Operator::<f64>::cue(&mut operator, cue.contains(tick));
            Operator::<f64>::desired_position_m(&mut operator, *tick, felt_n(*tick));
            Operator::<f64>::notices(&operator)
        };
        (0..1500).filter(&mut notices).collect()
    }

    #[test]
    fn an_operator_reports_that_a_drop_is_noticed() {
        let dropped = |tick: u64| if tick < 501 { 2.0 } else { 1.0 };
        assert_eq!(noticed(reacting(Reflex::Stop), 0..0, dropped), [501]);
        assert_eq!(noticed(ramp(), 0..0, dropped), [0_u64; 0], "without a reaction nothing is noticed");
    }

    #[test]
    fn an_operator_who_rests_stays_at_the_last_desired_position() {
        let mut operator = reacting(Reflex::Stop).trembling(Arc::from([0.0, 0.0, 3e-4]));
        let last = (0..3).map(|tick| operator.desired_position_m(tick, 2.0)).last().expect("ticks");
        operator.rest(2);
        assert!((last - 3.2e-4).abs() < 1e-15);
        for tick in 3..1000 {
            assert!((operator.desired_position_m(tick, 0.0) - last).abs() < 1e-15, "{tick}");
        }
        assert!(!operator.notices());
    }

    #[test]
    fn the_positions_of_a_motion_follow_from_its_settings() {
        let (start, end) = (StartSettings { start_m: 0.01 }, EndSettings { end_m: 0.03 });
        let movement = MovementSettings { movement_s: 0.5 };
        let jerk = MinimumJerkSettings { start, end, movement }.positions_m(1e-3, 600);
        assert_eq!((jerk.len(), jerk[0], jerk[599]), (600, 0.01, 0.03));
        assert!((jerk[250] - 0.02).abs() < 1e-12);
        let both = InsertionExtractionSettings { start, end, movement, pushes: 2, hold_s: 0.1, withdrawal_s: 0.4 };
        let both = both.positions_m(1e-3, 1100);
        assert!((both[250] - 0.02).abs() < 1e-12 && both[550] == 0.03 && (both[800] - 0.02).abs() < 1e-12);
        let sine = SineSettings { start, amplitude_m: 0.002, frequency_hz: 5.0 }.positions_m(1e-3, 100);
        assert!((sine[50] - 0.012).abs() < 1e-12 && sine[0] == 0.01);
    }

    #[test]
    fn a_cue_on_the_skin_is_noticed() {
        let settings = PerceptionSettings { lapse_rate: 0.0, criterion: 9.0, ..PerceptionSettings::DEFAULT };
        let perception = Perception::Psychometric(settings);
        let operator = ramp().reacting(&ReflexSettings::default(), &perception, (1, 0), 1e-3);
        // Half of the cue is integrated after ln 2 of the 50 ms.
        assert_eq!(noticed(operator, 200..400, |_| 2.0), [234]);
    }
}
