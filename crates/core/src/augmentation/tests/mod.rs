use super::*;
use proptest::prelude::*;

const TICK_S: f64 = 1e-3;
const THRESHOLD: f64 = 2.0;

/// A supervisor with a hand that moves at 10 mm/s, a force, and alarms at given ticks.
struct Timeline {
    supervisor: Supervisor<f64>,
    alarms: Vec<u64>,
    above_until: u64,
    hand_speed: f64,
}

impl Timeline {
    fn new(settings: AugmentationSettings) -> Self {
        let supervisor = Supervisor::new(&settings, THRESHOLD, TICK_S, 0.0);
        Self { supervisor, alarms: vec![], above_until: 0, hand_speed: 0.01 }
    }
    fn alarm_at(mut self, tick: u64) -> Self {
        self.alarms.push(tick);
        self
    }
    /// Keeps `g` above the threshold until this tick.
    fn above_until(mut self, tick: u64) -> Self {
        self.above_until = tick;
        self
    }
    fn hand(&self, tick: u64) -> f64 {
        self.hand_speed * tick as f64 * TICK_S
    }
    fn run(mut self, ticks: u64, force: impl Fn(u64) -> f64) -> Vec<Command<f64>> {
        let step = |tick| {
            let hand_m = self.hand(tick);
            let input = SupervisorInput {
                tick,
                alarm: self.alarms.contains(&tick),
                decision: if tick < self.above_until { 10.0 * THRESHOLD } else { 0.0 },
                hand_m,
                slave_m: hand_m - 1e-4,
                force_n: force(tick),
            };
            self.supervisor.update(&input, force(tick), self.hand_speed)
        };
        (0..ticks).map(step).collect()
    }
}

fn modes(commands: &[Command<f64>]) -> Vec<(usize, u8)> {
    let mut changes = vec![];
    for (tick, command) in commands.iter().enumerate() {
        let mode = command.mode.lane(0).code();
        if changes.last().is_none_or(|&(_, last)| last != mode) {
            changes.push((tick, mode));
        }
    }
    changes
}

fn settings() -> AugmentationSettings {
    AugmentationSettings {
        reengage: Reengage::Ramp(RampSettings { catch_up_speed_m_per_s: 0.02 }),
        ..Default::default()
    }
}

#[test]
fn an_event_freezes_while_g_is_large_and_quiet_time_has_not_passed_reengages_and_ends() {
    // The tick until which g is above the threshold, and the ticks of the release and of the end.
    for (above_until, released, ended) in [
        // In 0.5 s of freeze the hand moves ahead by 5 mm + 0.1 mm; closing this gap at 20 mm/s takes 255 ms.
        (0, 600, 856),
        // 50 ms of quiet after g fell; 6.59 mm take 330 ms.
        (700, 749, 1080),
        // The maximum of a freeze; 10.1 mm take 505 ms, and a tick more by rounding.
        (5000, 1100, 1607),
    ] {
        let commands = Timeline::new(settings()).alarm_at(100).above_until(above_until).run(2000, |_| 4.0);
        assert_eq!(modes(&commands), [(0, 0), (100, 1), (released, 2), (ended, 0)], "{above_until}");
    }
}

#[test]
fn during_an_event_the_slave_moves_as_far_from_its_anchor_as_the_hold_allows() {
    let speed = HoldSettings::SpeedLimit(SpeedLimitSettings { speed_m_per_s: 0.004 });
    let region = HoldSettings::ForbiddenRegion(ForbiddenRegionSettings { margin_m: 0.001 });
    let (measured, hand) = (0.01 * 0.1 - 1e-4, 0.01 * 0.1);
    // The references at the alarm and 399 ms later. The hand is faster than the limit of the speed.
    for (freeze, hold, first_m, last_m) in [
        (Freeze::Measured, HoldSettings::Frozen, measured, measured),
        (Freeze::Reference, HoldSettings::Frozen, 0.01 * 0.099, 0.01 * 0.099),
        (Freeze::Measured, speed, measured + 4e-6, measured + 400.0 * 4e-6),
        (Freeze::Measured, region, hand, measured + 0.001),
    ] {
        let settings = AugmentationSettings { freeze, hold, ..settings() };
        let commands = Timeline::new(settings).alarm_at(100).run(500, |_| 4.0);
        let [first, last] = [100, 499].map(|tick: usize| commands[tick].slave_reference_m);
        assert!((first - first_m).abs() < 1e-15 && (last - last_m).abs() < 1e-12, "{hold:?}: {first} {last}");
    }
}

#[test]
fn without_a_hold_there_is_no_gap_to_close() {
    let settings = AugmentationSettings { hold: HoldSettings::Following, reengage: Reengage::Clutch, ..settings() };
    let commands = Timeline::new(settings).alarm_at(100).run(2000, |_| 4.0);
    assert!(commands.iter().enumerate().all(|(k, c)| (c.slave_reference_m - 0.01 * k as f64 * TICK_S).abs() < 1e-15));
}

#[test]
fn a_ramp_until_load_stops_where_the_force_rises_and_keeps_the_remaining_gap() {
    let reengage = Reengage::RampUntilLoad(RampUntilLoadSettings { approach_speed_m_per_s: 0.02, stop_rise_n: 0.5 });
    let timeline = || Timeline::new(AugmentationSettings { reengage, ..settings() }).alarm_at(100);
    let free = timeline().run(2000, |_| 1.0);
    assert!((free[1999].slave_reference_m - 0.01 * 1.999).abs() < 1e-12, "without load it closes the gap");
    // The load rises 150 ms after the release, and falls again.
    let loaded = timeline().run(2000, |tick| if (750..800).contains(&tick) { 2.0 } else { 1.0 });
    let gap = |tick: usize| 0.01 * tick as f64 * TICK_S - loaded[tick].slave_reference_m;
    assert!((gap(1999) - gap(750)).abs() < 1e-12 && gap(750) > 2e-3, "{} {}", gap(750), gap(1999));
    assert_eq!(modes(&loaded)[3].1, 0);
}

proptest! {
    #[test]
    fn the_fed_back_force_never_steps_by_more_than_its_law_allows(
        forces in prop::collection::vec(-6.0..6.0f64, 700),
        alarms in prop::collection::vec(0u64..700, 0..6),
        blend_s in 0.0..0.2f64,
        law in 0..3,
        shape in 0.0..1.0f64,
    ) {
        let time_constant_s = 0.001 + 0.05 * shape;
        let force = match law {
            0 => ForceLawSettings::Amplify(AmplifySettings { gain: 1.0 + 4.0 * shape }),
            1 => ForceLawSettings::Damp(DampSettings { damping_n_s_per_m: 200.0 * shape, time_constant_s }),
            _ => ForceLawSettings::Decay(DecaySettings { ratio: shape, time_constant_s }),
        };
        let automaton = AutomatonSettings { min_hold_s: 0.05, max_hold_s: 0.1, refractory_s: 0.0, ..Default::default() };
        let mut timeline = Timeline::new(AugmentationSettings { force, blend_s, automaton, ..settings() });
        timeline.alarms = alarms;
        let commands = timeline.run(700, |tick| forces[tick as usize]);
        for pair in commands.windows(2) {
            let step = (pair[1].feedback_force_n - pair[0].feedback_force_n).abs();
            prop_assert!(step <= pair[1].allowed_step_n + 1e-9, "{pair:?}");
        }
    }
}

mod event;
