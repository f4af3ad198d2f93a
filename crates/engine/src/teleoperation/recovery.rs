use trocar_core::lane::{Lane, Mask};
use trocar_core::safety::Fade;
use trocar_core::time::nearest_ticks;

trocar_core::choice! {
    /// Let the slave catch up with the hand after an outage, keep the offset, or stop.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Recovery at "channel.recovery" = Ramp {
        "ramp" => Ramp,
        "hold" => Hold,
        "give-up" => GiveUp,
    }
}

trocar_core::settings! {
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct RecoverySettings in "channel.recovery_" {
        /// Time without a sample that counts as an outage.
        outage_s: f64 at "channel.outage_s" [NON_NEGATIVE] = 0.1,
        policy: Recovery,
        /// Maximum speed of the slave's reference while it catches up with the hand.
        speed_m_per_s: f64 [POSITIVE] for Recovery::Ramp = 0.03,
        /// Maximum rate of the feedback force while it returns to the received force.
        force_rate_n_per_s: f64 [POSITIVE] = 50.0,
        /// Time without a sample after which the slave counts as dead and the feedback force decays.
        dead_s: f64 at "channel.dead_s" [NON_NEGATIVE] => "ten times channel.outage_s" 10.0 * outage_s,
        /// Duration in which the feedback force of a dead slave decays, and in which it returns with the slave.
        dead_decay_s: f64 at "channel.dead_decay_s" [POSITIVE] = 0.2,
    }
}

impl RecoverySettings {
    pub(super) fn of_forces(&self) -> Self {
        let policy = if self.policy == Recovery::Hold { Recovery::Ramp } else { self.policy };
        Self { policy, ..*self }
    }
}

/// `y = target + gap`, held while lost, approached by at most a step per tick while recovering. The gap is the
/// offset after an outage under [`Recovery::Hold`], else 0.
#[derive(Debug, Clone)]
pub(super) struct Receiver<L: Lane> {
    policy: Recovery,
    outage_ticks: L,
    expected_tick: L,
    step: L,
    keeps_pace: bool,
    dead_ticks: L,
    presence: Fade<L>,
    /// The target, its average distance per tick, and the largest such average.
    received: L,
    pace: L,
    max_pace: L,
    silent: L,
    has_begun: L::Mask,
    is_lost: L::Mask,
    is_recovering: L::Mask,
    gap: L,
    last: L,
    tick: L,
    outages: L,
    longest: L,
    given_up_at: L,
}

const NEVER: f64 = -1.0;

impl<L: Lane> Receiver<L> {
    pub(super) fn new(settings: &RecoverySettings, speed: f64, tick_s: f64, initial: L) -> Self {
        let nowhere = L::Mask::splat(false);
        Self {
            policy: settings.policy,
            outage_ticks: L::splat(nearest_ticks(settings.outage_s, tick_s).max(1) as f64),
            expected_tick: L::splat(f64::INFINITY),
            step: L::splat(speed * tick_s),
            keeps_pace: false,
            dead_ticks: L::splat(f64::INFINITY),
            presence: Fade::new(tick_s, tick_s, 1.0),
            received: initial,
            pace: L::zero(),
            max_pace: L::zero(),
            silent: L::zero(),
            has_begun: nowhere,
            is_lost: nowhere,
            is_recovering: nowhere,
            gap: L::zero(),
            last: initial,
            tick: L::zero(),
            outages: L::zero(),
            longest: L::zero(),
            given_up_at: L::splat(NEVER),
        }
    }

    /// A link that is down from the start counts as an outage.
    pub(super) fn expecting_within(mut self, ticks: u64) -> Self {
        self.expected_tick = L::splat(ticks as f64);
        self
    }

    /// Recovers no faster than the target has moved so far, so tissue that resists speed resists no more than before.
    pub(super) fn keeping_pace(self, keeps_pace: bool) -> Self {
        Self { keeps_pace, ..self }
    }

    pub(super) fn fading(self, settings: &RecoverySettings, tick_s: f64) -> Self {
        Self {
            dead_ticks: L::splat(nearest_ticks(settings.dead_s, tick_s).max(1) as f64),
            presence: Fade::new(settings.dead_decay_s, tick_s, 1.0),
            ..self
        }
    }

    #[inline(always)]
    pub(super) fn presence(&self) -> L {
        self.presence.share()
    }

    #[inline(always)]
    fn note_pace(&mut self, target: L, ticks: L) {
        let moved = (target - self.received).abs();
        self.received = target;
        self.pace = self.pace + (moved - ticks * self.pace) / (ticks + self.outage_ticks);
        self.max_pace = self.max_pace.max(self.pace);
    }

    #[inline(always)]
    pub(super) fn update(&mut self, target: L, is_fresh: L::Mask, given_up: Option<L>) -> L {
        if (is_fresh & !(self.is_lost | self.is_recovering)).all() {
            return self.receive(target);
        }
        self.recover(target, is_fresh, given_up)
    }

    #[inline(always)]
    pub(super) fn withhold(&mut self, part: L) {
        self.last = L::select(self.is_lost, self.last - part, self.last);
    }

    /// Fast path: no lane is lost or recovering.
    #[inline(always)]
    fn receive(&mut self, target: L) -> L {
        if self.keeps_pace {
            self.note_pace(target, self.silent + L::splat(1.0));
        }
        self.has_begun = L::Mask::splat(true);
        self.silent = L::zero();
        self.presence.update(L::Mask::splat(true));
        self.tick = self.tick + L::splat(1.0);
        self.last = match self.policy {
            Recovery::Hold => target + self.gap,
            Recovery::Ramp | Recovery::GiveUp => target,
        };
        self.last
    }

    #[inline(always)]
    fn recover(&mut self, target: L, is_fresh: L::Mask, given_up: Option<L>) -> L {
        let (zero, one) = (L::zero(), L::splat(1.0));
        self.has_begun = self.has_begun | is_fresh | self.tick.ge(self.expected_tick);
        let mut step = self.step;
        if self.keeps_pace {
            let before = (self.received, self.pace, self.max_pace);
            self.note_pace(target, self.silent + one);
            self.received = L::select(is_fresh, self.received, before.0);
            self.pace = L::select(is_fresh, self.pace, before.1);
            self.max_pace = L::select(is_fresh, self.max_pace, before.2);
            step = step.min(self.max_pace);
        }
        let silent = L::select(is_fresh | !self.has_begun, zero, self.silent + one);
        let is_out = silent.ge(self.outage_ticks);
        let begins = is_out & !self.is_lost;
        let ends = self.is_lost & is_fresh;
        self.outages = L::select(begins, self.outages + one, self.outages);
        self.longest = L::select(is_out, self.longest.max(silent), self.longest);
        self.silent = silent;
        self.presence.update(!silent.ge(self.dead_ticks));

        let goal = match self.policy {
            Recovery::Hold => {
                self.gap = L::select(ends, self.last - target, self.gap);
                self.is_lost = is_out;
                target + self.gap
            }
            Recovery::Ramp => {
                self.is_lost = is_out;
                self.is_recovering = (self.is_recovering | ends) & !is_out;
                target
            }
            Recovery::GiveUp => {
                self.given_up_at = L::select(begins, self.tick, self.given_up_at);
                self.is_lost = self.is_lost | begins;
                self.is_recovering = self.is_lost;
                L::select(self.is_lost, given_up.unwrap_or(self.last), target)
            }
        };
        let limited = self.last + (goal - self.last).clamp(-step, step);
        let has_arrived = (goal - self.last).abs().le(step);
        let is_held = self.is_lost & !self.is_recovering;
        let live = L::select(is_held, self.last, goal);
        self.last = L::select(self.is_recovering & !has_arrived, limited, live);
        if self.policy == Recovery::Ramp {
            self.is_recovering = self.is_recovering & !has_arrived;
        }
        self.tick = self.tick + one;
        self.last
    }

    pub(super) fn outages(&self, index: usize) -> (f64, f64, Option<f64>) {
        let given_up = self.given_up_at.lane(index);
        (self.outages.lane(index), self.longest.lane(index), (given_up >= 0.0).then_some(given_up))
    }
}

trocar_core::lane::gather!(Receiver {
    outage_ticks, expected_tick, step, dead_ticks, presence, received, pace, max_pace, silent, gap, last, tick, outages, longest, given_up_at,
} masks { has_begun, is_lost, is_recovering } same { policy, keeps_pace });

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const TICK_S: f64 = 1e-3;

    /// Runs a receiver with a hand at 10 mm/s whose samples are missing from tick 100 to 399.
    fn through_an_outage(policy: Recovery) -> (Vec<f64>, Receiver<f64>) {
        let settings = RecoverySettings { policy, ..RecoverySettings::DEFAULT };
        let mut receiver = Receiver::new(&settings, settings.speed_m_per_s, TICK_S, 0.0);
        let mut held = 0.0;
        let mut out = vec![];
        for tick in 0..1000 {
            let is_fresh = !(100..400).contains(&tick);
            if is_fresh {
                held = 1e-5 * f64::from(tick);
            }
            out.push(receiver.update(held, is_fresh, None));
        }
        (out, receiver)
    }

    #[test]
    fn a_ramp_catches_up_with_the_hand_at_its_speed_and_no_faster() {
        let (out, receiver) = through_an_outage(Recovery::Ramp);
        assert!(out[99..400].iter().all(|&x| x == out[99]));
        let fastest = out.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
        assert!(fastest <= 3e-5 + 1e-18, "{fastest}");
        // 3 mm at 30 mm/s towards a hand that continues at 10 mm/s take 150 ms.
        assert!((out[548] - 5.48e-3).abs() > 1e-6 && (out[552] - 5.52e-3).abs() < 1e-15, "{}", out[552]);
        assert_eq!(receiver.outages(0), (1.0, 300.0, None));
    }

    #[test]
    fn a_receiver_that_keeps_pace_recovers_no_faster_than_its_target_moved() {
        let recover = |is_still: bool| {
            let mut receiver = Receiver::new(&RecoverySettings::DEFAULT, 0.03, TICK_S, 0.0).keeping_pace(true);
            let mut hand = 0.0;
            let out: Vec<f64> = (0..1500)
                .map(|tick| {
                    // 10 mm/s until the outage ends, or only during it; then the hand rests.
                    let moves = if is_still { (100..400).contains(&tick) } else { tick < 400 };
                    hand += if moves { 1e-5 } else { 0.0 };
                    receiver.update(hand, !(100..400).contains(&tick), None)
                })
                .collect();
            let fastest = out[400..].windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
            assert!((out[1499] - hand).abs() < 1e-15, "it arrives");
            fastest
        };
        assert!(recover(false) <= 1e-5 * (1.0 + 1e-12));
        // The motion during the outage counts too: otherwise the slave would never follow.
        let fastest = recover(true);
        assert!((5e-6..=1e-5).contains(&fastest), "{fastest}");
    }

    #[test]
    fn holding_keeps_the_offset() {
        let (out, _) = through_an_outage(Recovery::Hold);
        assert!((out[400] - out[99]).abs() < 1e-18);
        assert!((out[999] - (out[99] + 5.99e-3)).abs() < 1e-15);
    }

    #[test]
    fn a_receiver_that_gave_up_stops() {
        let (out, receiver) = through_an_outage(Recovery::GiveUp);
        assert!(out[200..].iter().all(|&x| x == out[99]));
        assert_eq!(receiver.outages(0).2, Some(199.0));
    }

    #[test]
    fn the_presence_fades_after_a_long_silence_and_returns_with_the_samples() {
        let settings = RecoverySettings { outage_s: 0.1, dead_s: 0.3, dead_decay_s: 0.2, ..RecoverySettings::DEFAULT };
        let mut receiver = Receiver::new(&settings, 50.0, TICK_S, 0.0).fading(&settings, TICK_S);
        let presence: Vec<f64> = (0..1500)
            .map(|tick| {
                receiver.update(2.0, !(100..1000).contains(&tick), None);
                receiver.presence()
            })
            .collect();
        assert!(presence[..399].iter().all(|share| *share == 1.0), "an outage that is shorter changes nothing");
        assert!((presence[499] - 0.495).abs() < 1e-9, "{}", presence[499]);
        assert_eq!((presence[600], presence[999]), (0.0, 0.0));
        assert!((presence[1099] - 0.5).abs() < 1e-9, "{}", presence[1099]);
        assert_eq!(presence[1205], 1.0);
    }

    #[test]
    fn a_link_that_is_dead_from_the_start_recovers_by_a_ramp_without_a_jump() {
        let settings = RecoverySettings::DEFAULT;
        let start = |expected_within| {
            let receiver = Receiver::new(&settings, settings.speed_m_per_s, TICK_S, 0.0);
            let mut receiver = receiver.expecting_within(expected_within);
            let out: Vec<f64> = (0..500).map(|tick| receiver.update(5e-3, tick >= 300, None)).collect();
            (out, receiver.outages(0))
        };
        let (out, outages) = start(20);
        assert!(out.windows(2).all(|pair| pair[1] - pair[0] <= 3e-5 + 1e-18) && out[499] == 5e-3, "{}", out[499]);
        assert_eq!(outages, (1.0, 280.0, None));
        // A link whose expected delay is that long is not down: the first sample is used unchanged.
        let (out, outages) = start(300);
        assert_eq!((out[300], outages), (5e-3, (0.0, 0.0, None)));
    }

    #[test]
    fn waiting_for_the_first_sample_is_not_an_outage() {
        let settings = RecoverySettings { policy: Recovery::GiveUp, ..RecoverySettings::DEFAULT };
        let mut receiver = Receiver::new(&settings, settings.speed_m_per_s, TICK_S, 0.5);
        for _ in 0..1000 {
            assert_eq!(receiver.update(0.5, false, None), 0.5);
        }
        assert_eq!(receiver.update(0.7, true, None), 0.7);
        assert_eq!(receiver.outages(0), (0.0, 0.0, None));
    }

    proptest! {
        #[test]
        fn recovery_never_exceeds_its_speed(
            // Alternating durations of outage and operation, and the hand's speed in each.
            phases in prop::collection::vec((1_usize..300, -0.1..0.1f64), 2..12), fresh_share in 0.2..1.0f64,
        ) {
            let settings = RecoverySettings::DEFAULT;
            let step = settings.speed_m_per_s * TICK_S;
            let mut receiver = Receiver::new(&settings, settings.speed_m_per_s, TICK_S, 0.0).expecting_within(0);
            let (mut hand, mut sample, mut out, mut silent, mut behind) = (0.0, 0.0, 0.0, 0_u64, false);
            let mut spread = 0.0_f64;
            for (index, (ticks, speed)) in phases.into_iter().enumerate() {
                for _ in 0..ticks {
                    hand += speed * TICK_S;
                    // A low-discrepancy sequence, which is reproducible and random enough here.
                    spread = (spread + 0.618_033_988_749_895).fract();
                    let is_fresh = index % 2 == 1 && spread < fresh_share;
                    sample = if is_fresh { hand } else { sample };
                    silent = if is_fresh { 0 } else { silent + 1 };
                    behind |= silent >= 100;
                    let next = receiver.update(sample, is_fresh, None);
                    if behind {
                        prop_assert!((next - out).abs() <= step * (1.0 + 1e-12) + 1e-18, "{} to {}", out, next);
                    } else {
                        prop_assert_eq!(next, sample);
                    }
                    prop_assert!(silent < 100 || next == out, "it moves during an outage");
                    behind &= next != sample || silent >= 100;
                    out = next;
                }
            }
        }
    }
}
