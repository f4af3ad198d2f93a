//! A person who notices that the resistance falls, and reacts.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use crate::error::InvalidValue;
use crate::lane::{Lane, Mask};
use crate::time::nearest_ticks;

/// How many reaction times are drawn; then they repeat.
const DRAWN: usize = 16;

/// Sets the reaction times apart from the other random numbers with the same seed.
const DOMAIN: u64 = 0x7265_666c_6578;

trocar_core::choice! {
    /// What the person does, a reaction time after the felt force has fallen: go on, pause, or pause and withdraw.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub enum Reflex at "operator.reflex" = None {
        /// Goes on.
        "none" => None,
        /// Stops, for the pause.
        "stop" => Stop,
        /// Stops, and withdraws meanwhile.
        "withdraw" => Withdraw in "operator.reflex_withdraw_" {
            /// How far they withdraw.
            distance_m: f64 at "operator.reflex_withdraw_m" [NON_NEGATIVE] = 0.005,
            /// How fast they withdraw.
            speed_m_per_s: f64 [POSITIVE] = 0.02,
        },
    }
}

trocar_core::settings! {
    /// When a person notices, how fast they react, and for how long.
    ///
    /// A drop is noticed when the felt force is below `1 - weber_fraction` times its recent level. The threshold for telling
    /// forces of 2.5 to 10 N apart is about 7 % (Pang, Tan and Durlach 1991); the default of 15 % is chosen here, as the hand
    /// is busy. Reaction times are drawn uniformly, anew for each reaction; their default of 150 to 250 ms, memory, pause and
    /// least force are chosen here too.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct ReflexSettings in "operator.reflex_" {
        /// What the person does.
        reflex: Reflex [kinds last],
        /// By what share of its recent level the felt force has to fall to be noticed.
        ///
        /// Weber fraction, between 0 and 1.
        weber_fraction: f64 [SHARE] = 0.15,
        /// Shortest reaction time.
        reaction_min_s: f64 [NON_NEGATIVE] = 0.15,
        /// Longest reaction time.
        reaction_max_s: f64 [NON_NEGATIVE] = 0.25,
        /// Time constant of the recent level.
        memory_s: f64 [POSITIVE] = 0.05,
        /// Level below which no fall is noticed.
        min_force_n: f64 at "operator.reflex_least_force_n" [NON_NEGATIVE] = 0.3,
        /// How long the person pauses.
        pause_s: f64 [NON_NEGATIVE] = 0.5,
    }
    where weber_fraction: |s| s.weber_fraction > 0.0 && s.weber_fraction < 1.0, "between 0 and 1";
    where reaction_max_s: |s| s.reaction_max_s >= s.reaction_min_s, "at least operator.reflex_reaction_min_s";
}

impl ReflexSettings {
    /// Whether the person reacts at all.
    #[must_use]
    pub fn reacts(&self) -> bool {
        self.reflex != Reflex::None
    }

    /// Checks the ranges that the fields state, where the person reacts.
    ///
    /// # Errors
    /// [`InvalidValue`] naming the first setting out of range.
    pub fn validate_where_reacting(&self) -> Result<(), InvalidValue> {
        if self.reacts() { self.validate() } else { Ok(()) }
    }
}

/// A person's reaction at work: when it comes, and what it makes of the motion.
///
/// ```text
/// level_k = F_h + exp(-T/τ) (level_{k-1} - F_h)
/// noticed:  F_h < (1 - w) level_{k-1},  level_{k-1} >= least force,  no reaction pending
/// ```
/// A reaction time after the notice the person's own clock stands still for the pause; the motion then goes on from where
/// it was. Until the pause has passed nothing else is noticed.
#[derive(Debug, Clone)]
pub(super) struct Reaction<L: Lane> {
    keep: L,
    noticed_share: L,
    min_force: L,
    pause_ticks: L,
    withdraw_step: L,
    withdraw_m: L,
    reaction_ticks: [L; DRAWN],
    /// The level; below any force before the first tick.
    level: L,
    /// When the reaction comes; never while none is pending.
    due: L,
    reactions: L,
    /// The person's own time in ticks.
    clock: L,
    withdrawn: L,
    withdrawn_before: L,
}

impl<L: Lane> Reaction<L> {
    /// A person with nothing felt so far; lane `i` reacts by stream `first_stream + i` of the seed.
    pub(super) fn new(settings: &ReflexSettings, seed: u64, first_stream: u64, tick_s: f64) -> Self {
        let ticks = |duration_s: f64| nearest_ticks(duration_s, tick_s) as f64;
        let (withdraw_m, speed) = match settings.reflex {
            Reflex::None | Reflex::Stop => (0.0, 0.0),
            Reflex::Withdraw { distance_m, speed_m_per_s } => (distance_m, speed_m_per_s),
        };
        let mut reaction_ticks = [L::zero(); DRAWN];
        for lane in 0..L::WIDTH {
            let mut rng = ChaCha8Rng::seed_from_u64(seed ^ DOMAIN);
            rng.set_stream(first_stream + lane as u64);
            for drawn in &mut reaction_ticks {
                let spread = settings.reaction_max_s - settings.reaction_min_s;
                let reaction_s = settings.reaction_min_s + spread * rng.random::<f64>();
                *drawn = drawn.with_lane(lane, ticks(reaction_s));
            }
        }
        Self {
            keep: L::splat(libm::exp(-tick_s / settings.memory_s)),
            noticed_share: L::splat(1.0 - settings.weber_fraction),
            min_force: L::splat(settings.min_force_n),
            pause_ticks: L::splat(ticks(settings.pause_s)),
            withdraw_step: L::splat(speed * tick_s),
            withdraw_m: L::splat(withdraw_m),
            reaction_ticks,
            level: L::splat(f64::NEG_INFINITY),
            due: L::splat(f64::INFINITY),
            reactions: L::zero(),
            clock: L::zero(),
            withdrawn: L::zero(),
            withdrawn_before: L::zero(),
        }
    }

    /// Takes the force felt at the tick before `tick`; gives the person's own time at `tick` in ticks, and how far they
    /// have withdrawn in m.
    #[inline(always)]
    pub(super) fn step(&mut self, tick: u64, felt: L) -> (L, L) {
        let (zero, one, never) = (L::zero(), L::splat(1.0), L::splat(f64::INFINITY));
        let now = L::splat(tick as f64);
        let first = self.level.lt(L::splat(f64::MIN));
        let idle = self.due.ge(never);
        let fallen = felt.lt(self.noticed_share * self.level) & self.level.ge(self.min_force);
        let notices = idle & fallen & !first;
        if notices.any() {
            self.notice(notices, now);
        }
        let followed = felt + self.keep * (self.level - felt);
        let acts = now.gt(self.due) & now.le(self.due + self.pause_ticks);
        let is_over = now.gt(self.due + self.pause_ticks) & self.due.lt(never);
        // After a reaction the present force is what the next drop is told from.
        self.level = L::select(first | is_over, felt, followed);
        self.due = L::select(is_over, never, self.due);
        self.clock = self.clock + L::select(acts, zero, one);
        let farther = (self.withdrawn + self.withdraw_step).min(self.withdrawn_before + self.withdraw_m);
        self.withdrawn = L::select(acts, farther, self.withdrawn);
        self.withdrawn_before = L::select(is_over, self.withdrawn, self.withdrawn_before);
        (self.clock, self.withdrawn)
    }

    /// Sets the time of the reaction where a drop is noticed.
    #[cold]
    #[inline(never)]
    fn notice(&mut self, notices: L::Mask, now: L) {
        for lane in (0..L::WIDTH).filter(|&lane| notices.lane(lane)) {
            let count = self.reactions.lane(lane);
            let wait = self.reaction_ticks[count as usize % DRAWN].lane(lane);
            self.due = self.due.with_lane(lane, now.lane(lane) + wait);
            self.reactions = self.reactions.with_lane(lane, count + 1.0);
        }
    }
}

crate::lane::gather!(Reaction {
    keep,
    noticed_share,
    min_force,
    pause_ticks,
    withdraw_step,
    withdraw_m,
    reaction_ticks,
    level,
    due,
    reactions,
    clock,
    withdrawn,
    withdrawn_before,
});

#[cfg(test)]
mod tests {
    use super::*;

    fn settings() -> ReflexSettings {
        ReflexSettings {
            reflex: Reflex::Stop,
            weber_fraction: 0.15,
            reaction_min_s: 0.15,
            reaction_max_s: 0.25,
            memory_s: 0.05,
            min_force_n: 0.3,
            pause_s: 0.4,
        }
    }

    /// The person's own time and withdrawal at each tick of a force.
    fn live(settings: &ReflexSettings, seed: u64, force: impl Fn(u64) -> f64) -> Vec<(f64, f64)> {
        let mut reaction = Reaction::<f64>::new(settings, seed, 0, 1e-3);
        (1..3000).map(|tick| reaction.step(tick, force(tick - 1))).collect()
    }

    fn drop_at(tick: u64) -> impl Fn(u64) -> f64 {
        move |k| if k < tick { 2.0 } else { 1.0 }
    }

    #[test]
    fn a_drop_is_acted_on_after_a_reaction_time_and_the_motion_then_goes_on() {
        for seed in 0..50 {
            let lived = live(&settings(), seed, drop_at(1000));
            let stood: Vec<usize> = (1..lived.len()).filter(|&k| lived[k].0 == lived[k - 1].0).collect();
            assert_eq!(stood.len(), 400, "one pause of 0.4 s");
            assert!((1150..=1252).contains(&stood[0]), "{}", stood[0]);
            assert!(stood.windows(2).all(|pair| pair[1] == pair[0] + 1));
            assert_eq!(lived.last().expect("lived").0, 2999.0 - 400.0);
        }
    }

    #[test]
    fn without_a_drop_nobody_reacts() {
        for force in [&(|_| 2.0) as &dyn Fn(u64) -> f64, &|k| 2.0 - 0.05 * (k % 3) as f64, &|k| 1e-3 * k as f64] {
            assert_eq!(live(&settings(), 1, force).last().expect("lived").0, 2999.0);
        }
        assert_eq!(live(&settings(), 1, |k| 0.1 * drop_at(1000)(k)).last().expect("lived").0, 2999.0, "too faint");
    }

    #[test]
    fn a_withdrawal_goes_as_far_and_as_fast_as_it_says() {
        let reflex = Reflex::Withdraw { distance_m: 0.004, speed_m_per_s: 0.05 };
        let lived = live(&ReflexSettings { reflex, ..settings() }, 1, drop_at(1000));
        let fastest = lived.windows(2).map(|pair| pair[1].1 - pair[0].1).fold(0.0, f64::max);
        assert!((fastest - 5e-5).abs() < 1e-15, "{fastest}");
        assert!((lived.last().expect("lived").1 - 0.004).abs() < 1e-12);
    }

    #[test]
    fn settings_that_cannot_be_are_refused() {
        assert!(settings().validate().is_ok());
        for bad in [
            ReflexSettings { weber_fraction: 1.0, ..settings() },
            ReflexSettings { reaction_max_s: 0.1, ..settings() },
            ReflexSettings { memory_s: 0.0, ..settings() },
        ] {
            assert!(bad.validate().is_err(), "{bad:?}");
        }
    }
}
