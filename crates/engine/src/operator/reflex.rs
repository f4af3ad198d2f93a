use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use trocar_core::settings::ActsFor;

use super::perception::{Noticing, Perception};
use trocar_core::error::InvalidValue;
use trocar_core::lane::{Lane, Mask};
use trocar_core::time::nearest_ticks;

const DRAWN: usize = 16;

/// Separates these random numbers from others with the same seed.
const DOMAIN: u64 = 0x7265_666c_6578;

trocar_core::choice! {
    /// Let the operator react, one reaction time after a drop of the felt force: not at all, by a pause, or by a pause
    /// and a withdrawal.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub enum Reflex at "perception.reflex" = None {
        "none" => None,
        "stop" => Stop,
        "withdraw" => Withdraw in "perception.reflex_withdraw_" {
            /// Distance of the withdrawal.
            distance_m: f64 at "perception.reflex_withdraw_m" [NON_NEGATIVE] = 0.005,
            /// Speed of the withdrawal.
            speed_m_per_s: f64 [POSITIVE] = 0.02,
        },
    }
}

const WHEN_REACTING: ActsFor = ActsFor::new(Reflex::KEY.path, Reflex::WORDS.split_at(1).1);
/// A psychometric decision replaces the fixed threshold.
const WITH_A_THRESHOLD: ActsFor = WHEN_REACTING.only_with(Perception::KEY.path, Perception::None.word());

trocar_core::settings! {
    /// Thresholds for 2.5 to 10 N are about 7 % (Pang, Tan and Durlach 1991); the default of 15 % for a moving hand and
    /// the others are chosen here.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct ReflexSettings in "perception.reflex_" {
        reflex: Reflex [kinds last],
        /// Fraction of its recent level by which the felt force must drop to be noticed.
        weber_fraction: f64 [SHARE] for (WITH_A_THRESHOLD) = 0.15,
        /// Minimum reaction time.
        reaction_min_s: f64 [NON_NEGATIVE] for (WITH_A_THRESHOLD) = 0.15,
        /// Maximum reaction time.
        reaction_max_s: f64 [NON_NEGATIVE] for (WITH_A_THRESHOLD) = 0.25,
        /// Time constant of the recent level of the felt force.
        memory_s: f64 [POSITIVE] for (WITH_A_THRESHOLD) = 0.05,
        /// Minimum level of the felt force at which a drop is noticed.
        min_force_n: f64 at "perception.reflex_least_force_n" [NON_NEGATIVE] for (WITH_A_THRESHOLD) = 0.3,
        /// Duration of the pause.
        pause_s: f64 [NON_NEGATIVE] for (WHEN_REACTING) = 0.5,
    }
    where weber_fraction: |s| s.weber_fraction > 0.0 && s.weber_fraction < 1.0, "between 0 and 1";
    where reaction_max_s: |s| s.reaction_max_s >= s.reaction_min_s, "at least perception.reflex_reaction_min_s";
}

impl ReflexSettings {
    pub fn reacts(&self) -> bool {
        self.reflex != Reflex::None
    }

    pub fn validate_where_reacting(&self) -> Result<(), InvalidValue> {
        if self.reacts() { self.validate() } else { Ok(()) }
    }
}

/// The motion pauses one reaction time after
///
/// ```text
/// level_k = F_h + exp(-T/τ) (level_{k-1} - F_h)
/// noticed:  F_h < (1 - w) level_{k-1},  level_{k-1} >= minimum force,  no reaction pending
/// ```
/// or after a psychometric decision.
#[derive(Debug, Clone)]
pub(super) struct Reaction<L: Lane> {
    keep: L,
    noticed_ratio: L,
    min_force: L,
    pause_ticks: L,
    withdraw_step: L,
    withdraw_m: L,
    reaction_ticks: [L; DRAWN],
    level: L,
    /// Infinite without a pending reaction.
    due: L,
    reactions: L,
    clock: L,
    withdrawn: L,
    withdrawn_before: L,
    noticed: L::Mask,
    noticing: Option<Noticing<L>>,
    cue: L,
}

impl<L: Lane> Reaction<L> {
    pub(super) fn new(
        settings: &ReflexSettings,
        perception: &Perception,
        (seed, first_stream): (u64, u64),
        tick_s: f64,
    ) -> Self {
        let ticks = |duration_s: f64| nearest_ticks(duration_s, tick_s) as f64;
        let (withdraw_m, speed) = match settings.reflex {
            Reflex::None | Reflex::Stop => (0.0, 0.0),
            Reflex::Withdraw { distance_m, speed_m_per_s } => (distance_m, speed_m_per_s),
        };
        let mut reaction_ticks = [L::zero(); DRAWN];
        for lane in 0..L::WIDTH {
            let stream = first_stream + lane as u64;
            if let Some(perception) = perception.settings() {
                let drawn = perception.reaction_ticks::<DRAWN>(seed, stream, tick_s);
                for (all, drawn) in reaction_ticks.iter_mut().zip(drawn) {
                    *all = all.with_lane(lane, drawn);
                }
                continue;
            }
            let mut rng = ChaCha8Rng::seed_from_u64(seed ^ DOMAIN);
            rng.set_stream(stream);
            for drawn in &mut reaction_ticks {
                let spread = settings.reaction_max_s - settings.reaction_min_s;
                let reaction_s = settings.reaction_min_s + spread * rng.random::<f64>();
                *drawn = drawn.with_lane(lane, ticks(reaction_s));
            }
        }
        Self {
            keep: L::splat(libm::exp(-tick_s / settings.memory_s)),
            noticed_ratio: L::splat(1.0 - settings.weber_fraction),
            min_force: L::splat(settings.min_force_n),
            pause_ticks: L::splat(if settings.reacts() { ticks(settings.pause_s) } else { 0.0 }),
            withdraw_step: L::splat(speed * tick_s),
            withdraw_m: L::splat(withdraw_m),
            reaction_ticks,
            level: L::splat(f64::NEG_INFINITY),
            due: L::splat(f64::INFINITY),
            reactions: L::zero(),
            clock: L::zero(),
            withdrawn: L::zero(),
            withdrawn_before: L::zero(),
            noticed: L::Mask::splat(false),
            noticing: perception.settings().map(|perception| Noticing::new(perception, seed, first_stream, tick_s)),
            cue: L::zero(),
        }
    }

    #[inline(always)]
    pub(super) fn step(&mut self, tick: u64, felt: L, withdraws: L::Mask) -> (L, L) {
        let (zero, one, never) = (L::zero(), L::splat(1.0), L::splat(f64::INFINITY));
        let now = L::splat(tick as f64);
        let first = self.level.lt(L::splat(f64::MIN));
        let idle = self.due.ge(never);
        let fallen = felt.lt(self.noticed_ratio * self.level) & self.level.ge(self.min_force);
        let cue = self.cue.gt(L::splat(0.5));
        let notices = match &mut self.noticing {
            Some(noticing) => {
                let notices = idle & noticing.step(now, felt, cue, withdraws);
                noticing.use_cue(notices);
                notices
            }
            None => idle & fallen & !first,
        };
        self.noticed = notices;
        if notices.any() {
            self.notice(notices, now);
        }
        let followed = felt + self.keep * (self.level - felt);
        let acts = now.gt(self.due) & now.le(self.due + self.pause_ticks);
        let is_over = now.gt(self.due + self.pause_ticks) & self.due.lt(never);
        self.level = L::select(first | is_over, felt, followed);
        if let Some(noticing) = &mut self.noticing {
            noticing.restart(is_over, now, felt);
        }
        self.due = L::select(is_over, never, self.due);
        self.clock = self.clock + L::select(acts, zero, one);
        let withdrawn_next = (self.withdrawn + self.withdraw_step).min(self.withdrawn_before + self.withdraw_m);
        self.withdrawn = L::select(acts, withdrawn_next, self.withdrawn);
        self.withdrawn_before = L::select(is_over, self.withdrawn, self.withdrawn_before);
        (self.clock, self.withdrawn)
    }

    #[inline(always)]
    pub(super) fn cue(&mut self, is_on: L::Mask) {
        self.cue = L::select(is_on, L::splat(1.0), L::zero());
    }

    #[inline(always)]
    pub(super) fn has_noticed(&self) -> L::Mask {
        self.noticed
    }

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

trocar_core::lane::gather!(Reaction {
    keep,
    noticed_ratio,
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
    noticing,
    cue,
} masks { noticed });

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

    /// The time of the motion and the withdrawal at each tick of a force.
    fn react_to(settings: &ReflexSettings, seed: u64, force: impl Fn(u64) -> f64) -> Vec<(f64, f64)> {
        let mut reaction = Reaction::<f64>::new(settings, &Perception::None, (seed, 0), 1e-3);
        (1..3000).map(|tick| reaction.step(tick, force(tick - 1), false)).collect()
    }

    fn drop_at(tick: u64) -> impl Fn(u64) -> f64 {
        move |k| if k < tick { 2.0 } else { 1.0 }
    }

    #[test]
    fn a_drop_causes_a_pause_after_a_reaction_time_and_the_motion_then_continues() {
        for seed in 0..50 {
            let reaction = react_to(&settings(), seed, drop_at(1000));
            let paused: Vec<usize> = (1..reaction.len()).filter(|&k| reaction[k].0 == reaction[k - 1].0).collect();
            assert_eq!(paused.len(), 400, "one pause of 0.4 s");
            assert!((1150..=1252).contains(&paused[0]), "{}", paused[0]);
            assert!(paused.windows(2).all(|pair| pair[1] == pair[0] + 1));
            assert_eq!(reaction.last().expect("reaction").0, 2999.0 - 400.0);
        }
    }

    #[test]
    fn without_a_drop_there_is_no_reaction() {
        for force in [&(|_| 2.0) as &dyn Fn(u64) -> f64, &|k| 2.0 - 0.05 * (k % 3) as f64, &|k| 1e-3 * k as f64] {
            assert_eq!(react_to(&settings(), 1, force).last().expect("reaction").0, 2999.0);
        }
        assert_eq!(
            react_to(&settings(), 1, |k| 0.1 * drop_at(1000)(k)).last().expect("reaction").0,
            2999.0,
            "too faint"
        );
    }

    #[test]
    fn a_withdrawal_has_the_configured_distance_and_speed() {
        let reflex = Reflex::Withdraw { distance_m: 0.004, speed_m_per_s: 0.05 };
        let reaction = react_to(&ReflexSettings { reflex, ..settings() }, 1, drop_at(1000));
        let fastest = reaction.windows(2).map(|pair| pair[1].1 - pair[0].1).fold(0.0, f64::max);
        assert!((fastest - 5e-5).abs() < 1e-15, "{fastest}");
        assert!((reaction.last().expect("reaction").1 - 0.004).abs() < 1e-12);
    }

    #[test]
    fn each_reaction_draws_a_new_reaction_time() {
        let mut reaction = Reaction::<f64>::new(&settings(), &Perception::None, (3, 0), 1e-3);
        let drawn = reaction.reaction_ticks;
        let (mut noticed_at, mut waits, mut before) = (None, vec![], 0.0);
        for tick in 1..12_000 {
            // A drop every 2 s.
            let (clock, _) = reaction.step(tick, if tick % 2000 < 1000 { 2.0 } else { 1.0 }, false);
            if reaction.has_noticed() {
                noticed_at = Some(tick);
            }
            if let Some(noticed) = noticed_at.filter(|_| clock == before) {
                waits.push((tick - noticed) as f64 - 1.0);
                noticed_at = None;
            }
            before = clock;
        }
        assert_eq!(waits, drawn[..6]);
        assert!(waits.windows(2).any(|pair| pair[0] != pair[1]));
    }
}
