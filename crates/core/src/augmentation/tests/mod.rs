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
fn an_event_freezes_reengages_and_ends() {
    let commands = Timeline::new(settings()).alarm_at(100).run(2000, |_| 4.0);
    // In 0.5 s of freeze the hand moves ahead by 5 mm + 0.1 mm; closing this gap at 20 mm/s takes 255 ms.
    assert_eq!(modes(&commands), [(0, 0), (100, 1), (600, 2), (856, 0)]);
}

#[test]
fn a_large_residual_prolongs_the_freeze_to_max_hold() {
    let commands = Timeline::new(settings()).alarm_at(100).above_until(5000).run(2000, |_| 4.0);
    assert_eq!(modes(&commands)[2], (1100, 2));
}

#[test]
fn the_hysteresis_waits_for_quiet() {
    let commands = Timeline::new(settings()).alarm_at(100).above_until(700).run(2000, |_| 4.0);
    assert_eq!(modes(&commands)[2], (749, 2), "50 ms of quiet after g fell");
}

#[test]
fn no_alarm_is_taken_during_an_event_or_in_the_refractory_period() {
    let timeline = Timeline::new(settings()).alarm_at(100).alarm_at(300).alarm_at(700).alarm_at(1000).alarm_at(1056);
    let commands = timeline.run(1200, |_| 4.0);
    assert_eq!(modes(&commands), [(0, 0), (100, 1), (600, 2), (856, 0), (1056, 1)]);
}

#[test]
fn a_ramp_never_moves_the_reference_faster_than_hand_speed_plus_catch_up_speed() {
    let commands = Timeline::new(settings()).alarm_at(100).run(2000, |_| 4.0);
    let step = |pair: &[Command<f64>]| (pair[1].slave_reference_m - pair[0].slave_reference_m).abs();
    let fastest = commands[101..].windows(2).map(step).fold(0.0, f64::max);
    assert!(fastest <= 0.03 * TICK_S * (1.0 + 1e-9), "{fastest}");
}

#[test]
fn a_clutch_keeps_the_gap_and_a_snap_closes_it_at_once() {
    let with = |reengage| Timeline::new(AugmentationSettings { reengage, ..settings() }).alarm_at(100);
    let clutch = with(Reengage::Clutch).run(2000, |_| 4.0);
    let gap = 0.01 * 1.999 - clutch[1999].slave_reference_m;
    assert!((gap - 5.1e-3).abs() < 1e-9, "{gap}");
    let snap = with(Reengage::Snap).run(2000, |_| 4.0);
    let jump = snap[600].slave_reference_m - snap[599].slave_reference_m;
    assert!((jump - 5.1e-3).abs() < 1e-9, "{jump}");
}

#[test]
fn the_slave_is_frozen_at_the_configured_position() {
    let at = |freeze| {
        let commands = Timeline::new(AugmentationSettings { freeze, ..settings() }).alarm_at(100).run(400, |_| 4.0);
        (commands[100].slave_reference_m, commands[399].slave_reference_m)
    };
    let (measured, reference) = (0.01 * 0.1 - 1e-4, 0.01 * 0.099);
    assert_eq!(at(Freeze::Measured), (measured, measured));
    let (first, last) = at(Freeze::Reference);
    assert!((first - reference).abs() < 1e-15 && first == last);
}

#[test]
fn the_slave_moves_as_far_as_a_speed_limit_a_region_or_no_hold_allows() {
    let at = |hold| {
        let commands = Timeline::new(AugmentationSettings { hold, ..settings() }).alarm_at(100).run(500, |_| 4.0);
        (commands[100].slave_reference_m, commands[499].slave_reference_m)
    };
    let anchor = 0.01 * 0.1 - 1e-4;
    let (first, last) = at(HoldSettings::SpeedLimit(SpeedLimitSettings { speed_m_per_s: 0.004 }));
    // The first step begins at the anchor; the hand is faster than the limit.
    assert!((first - (anchor + 4e-6)).abs() < 1e-15, "{first}");
    assert!((last - (anchor + 400.0 * 4e-6)).abs() < 1e-12, "{last}");
    let (first, last) = at(HoldSettings::ForbiddenRegion(ForbiddenRegionSettings { margin_m: 0.001 }));
    assert!((first - 0.01 * 0.1).abs() < 1e-15 && (last - (anchor + 0.001)).abs() < 1e-15, "{first} {last}");
    assert_eq!(at(HoldSettings::Following), (0.01 * 0.1, 0.01 * 0.499));
}

#[test]
fn a_forbidden_region_lets_the_needle_be_withdrawn() {
    let hold = HoldSettings::ForbiddenRegion(ForbiddenRegionSettings { margin_m: 0.0 });
    let mut timeline = Timeline::new(AugmentationSettings { hold, ..settings() }).alarm_at(100);
    timeline.hand_speed = -0.01;
    let commands = timeline.run(400, |_| 4.0);
    assert!((commands[399].slave_reference_m + 0.01 * 0.399).abs() < 1e-15);
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

#[test]
fn damping_is_added_to_the_measured_force_and_a_cue_changes_no_force() {
    let force = ForceLawSettings::Damp(DampSettings { damping_n_s_per_m: 50.0, time_constant_s: 0.01 });
    let commands = Timeline::new(AugmentationSettings { force, ..settings() }).alarm_at(100).run(400, |_| 4.0);
    let exact = 4.0 + 50.0 * 0.01 * (1.0 - (-101.0 * TICK_S / 0.01_f64).exp());
    assert!((commands[200].feedback_force_n - exact).abs() < 1e-9, "{}", commands[200].feedback_force_n);

    let none = ForceLawSettings::Damp(DampSettings { damping_n_s_per_m: 0.0, time_constant_s: 0.01 });
    let settings = AugmentationSettings { force: none, hold: HoldSettings::Following, cue: true, ..settings() };
    let timeline = Timeline::new(settings).alarm_at(100);
    let supervisor = timeline.supervisor.clone();
    let commands = timeline.run(800, |tick| 1e-3 * tick as f64);
    // Afterwards the feedback force is blended from the force at the end of the event.
    let during = commands.iter().enumerate().filter(|(_, c)| c.mode.is_augmented());
    assert!(during.clone().count() > 100 && during.into_iter().all(|(k, c)| c.feedback_force_n == 1e-3 * k as f64));
    assert_eq!(
        [Mode::Teleoperation, Mode::Augmented, Mode::Reengaging].map(|mode| supervisor.cue(Modes::splat(mode))),
        [false, true, false]
    );
}

#[test]
fn without_augmentation_the_scheme_is_the_classical_one() {
    let settings = AugmentationSettings { enabled: false, ..settings() };
    let commands = Timeline::new(settings).alarm_at(100).run(400, |tick| tick as f64);
    assert!(commands.iter().enumerate().all(|(k, c)| c.mode.is_teleoperation() && c.feedback_force_n == k as f64));
}

#[test]
fn decay_drops_faster_than_the_tissue_and_amplify_scales_the_drop() {
    let tissue = |tick: u64| if tick < 100 { 5.0 } else { 5.0 - 0.01 * (tick - 100) as f64 };
    let felt = |force| {
        let commands = Timeline::new(AugmentationSettings { force, ..settings() }).alarm_at(110).run(400, tissue);
        commands[160].feedback_force_n
    };
    let decayed = felt(ForceLawSettings::Decay(DecaySettings { ratio: 0.2, time_constant_s: 0.02 }));
    let anchor = 5.0 - 0.09;
    let exact = anchor * (0.2 + 0.8 * (-51.0 * TICK_S / 0.02_f64).exp());
    assert!((decayed - exact).abs() < 1e-12, "{decayed} {exact}");
    let amplified = felt(ForceLawSettings::Amplify(AmplifySettings { gain: 3.0 }));
    assert!((amplified - (anchor - 3.0 * 0.51)).abs() < 1e-12, "{amplified}");
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
