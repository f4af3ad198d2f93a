//! The controller of the rig gives the commands of the simulation on its samples, and handles bad samples.

use crate::support::scenario;
use trocar::augmentation::Mode;
use trocar::engine::{Observer, Signals};
use trocar::lane::Lane;
use trocar::rig::{Command, HapticController, Sample, Settings, VelocitySource};
use trocar::run::{RunReport, run};
use trocar::scenario::Scenario;

#[derive(Default)]
struct Tape(Vec<Signals<f64>>);

impl Observer<f64> for Tape {
    fn observe(&mut self, signals: &Signals<f64>) {
        self.0.push(*signals);
    }
}

fn tape(scenario: &Scenario) -> Vec<Signals<f64>> {
    let mut tape = Tape::default();
    scenario.build().expect("builds").run(&mut tape).expect("runs");
    tape.0
}

fn sample(signals: &Signals<f64>, resolution_m: f64) -> Sample {
    let read = |position: f64| {
        if resolution_m > 0.0 { position.round_to(resolution_m, 1.0 / resolution_m) } else { position }
    };
    Sample {
        master_position_m: signals.master_position_m,
        slave_position_m: read(signals.slave_position_m),
        slave_velocity_m_per_s: signals.slave_velocity_m_per_s,
        force_n: signals.measured_force_n,
    }
}

fn bits(numbers: [f64; 9]) -> [u64; 9] {
    numbers.map(f64::to_bits)
}

/// Replays a run through the controller and compares each command with the tick's. Returns the number of events.
fn replay(name: &str, settings: &[&str]) -> usize {
    let scenario = scenario(name, settings);
    let mut controller = HapticController::new(&scenario.rig_settings()).expect("valid");
    let mut events = 0;
    for signals in tape(&scenario) {
        let command = controller.step(&sample(&signals, scenario.sensor.position_resolution_m));
        let ours = [
            command.slave_reference_m,
            command.master_force_n,
            command.allowed_force_step_n,
            f64::from(command.mode.code()),
            command.stiffness_n_per_m,
            command.damping_n_s_per_m,
            command.residual_n,
            command.distance,
            command.decision,
        ];
        let theirs = [
            signals.slave_reference_m,
            signals.feedback_force_n,
            signals.allowed_force_step_n,
            signals.mode.codes(),
            signals.stiffness_n_per_m,
            signals.damping_n_s_per_m,
            signals.residual_n,
            signals.distance,
            signals.decision,
        ];
        assert_eq!(bits(ours), bits(theirs), "{name} {settings:?} at tick {}: {ours:?} {theirs:?}", signals.tick);
        assert_eq!((command.alarm, command.alarm_taken), (signals.alarm, signals.alarm_taken));
        assert!(!command.faults.any());
        events += usize::from(command.alarm_taken);
    }
    events
}

#[test]
fn the_same_samples_give_the_commands_of_the_simulation_bit_for_bit() {
    assert_eq!(replay("classical", &[]), 2);
    assert_eq!(replay("augmented", &[]), 2);
    assert_eq!(replay("augmented", &["augmentation.reengage=clutch", "augmentation.force_law=amplify"]), 2);
    // A rig limits the speed of a snap by default.
    let snap = ["augmentation.reengage=snap", "augmentation.freeze=reference", "safety.acts=nowhere"];
    assert_eq!(replay("augmented", &snap), 2);
    assert_eq!(replay("augmented", &["scaling.force=0.7", "scaling.position=1.3", "sensor.force_noise_std_n=0.02"]), 2);
    for distance in ["mean-change", "variance-change", "parameter-change", "force-derivative"] {
        replay("augmented", &[&format!("detector.distance={distance}")]);
    }
    assert!(replay("layers/skin-augmented", &[]) > 0);
    assert!(replay("paper/real-augmented", &[]) > 0);
}

#[test]
fn with_the_same_limits_in_the_simulation_a_rig_gives_its_commands_and_the_run_reports_the_limits() {
    let limits = [
        "safety.acts=everywhere",
        "safety.force_limit_n=3.0",
        "safety.force_rate_n_per_s=50.0",
        "safety.reference_speed_m_per_s=0.02",
        "augmentation.reengage=snap",
    ];
    assert!(replay("augmented", &limits) > 0);
    let limited = run(scenario("augmented", &limits)).expect("runs");
    let acting: Vec<_> =
        RunReport::of(&limited).warnings().into_iter().filter(|warning| warning.code.word() == "limit-acts").collect();
    assert_eq!(acting.len(), 3, "{acting:?}");
    assert!(limited.trace.feedback_force_n.iter().all(|force_n| force_n.abs() <= 3.0));
    let free = run(scenario("augmented", &["augmentation.reengage=snap"])).expect("runs");
    assert!(free.trace.feedback_force_n.iter().any(|force_n| *force_n > 3.0));
    assert!(RunReport::of(&free).warnings().iter().all(|warning| warning.code.word() != "limit-acts"));
}

#[test]
fn with_an_encoder_the_velocity_is_filtered_like_in_the_simulation() {
    assert!(replay("augmented", &["sensor.position_resolution_m=1e-5"]) > 0);
}

/// Returns the reading at tick `k` of a needle that moves at 10 mm/s into a tissue of 300 N/m.
fn insertion(k: u64) -> Sample {
    let depth = 1e-5 * k as f64;
    Sample {
        master_position_m: depth,
        slave_position_m: depth,
        slave_velocity_m_per_s: 0.01,
        force_n: 300.0 * depth + 0.1,
    }
}

fn controller() -> HapticController {
    HapticController::new(&Settings::default()).expect("valid")
}

#[test]
fn a_gap_raises_no_alarm_and_the_detector_works_afterwards() {
    let mut controller = controller();
    let drop = |k: u64, by_n: f64| Sample { force_n: insertion(k).force_n - by_n, ..insertion(k) };
    let mut alarms = vec![];
    let mut take = |k: u64, sample: Sample| {
        if controller.step(&sample).alarm {
            alarms.push(k);
        }
    };
    (0..1000).for_each(|k| take(k, insertion(k)));
    // The force falls while samples are missing, so nothing is detected.
    (1000..1200).for_each(|k| take(k, Sample::MISSING));
    (1200..1600).for_each(|k| take(k, drop(k, 1.0)));
    // The force falls again while samples arrive.
    (1600..1700).for_each(|k| take(k, drop(k, 2.0)));
    assert_eq!(alarms, [1600]);
}

#[test]
fn an_event_ends_even_without_samples() {
    let mut controller = controller();
    for k in 0..1000 {
        controller.step(&insertion(k));
    }
    let drop = controller.step(&Sample { force_n: 1.0, ..insertion(1000) });
    assert_eq!((drop.alarm_taken, drop.mode), (true, Mode::Augmented));
    let commands: Vec<Command> = (0..2000).map(|_| controller.step(&Sample::MISSING)).collect();
    assert_eq!(commands[400].mode, Mode::Augmented);
    assert_eq!(commands[1999].mode, Mode::Teleoperation);
    assert!(commands.iter().all(|command| command.slave_reference_m.is_finite() && command.master_force_n.is_finite()));
}

#[test]
fn before_the_first_good_sample_the_rig_is_at_rest() {
    let mut controller = HapticController::new(&Settings { start_m: 0.04, ..Settings::default() }).expect("valid");
    let command = controller.step(&Sample::MISSING);
    assert_eq!((command.slave_reference_m, command.master_force_n, command.faulty_samples), (0.04, 0.0, 1));
}

#[test]
fn an_unused_velocity_cannot_be_bad() {
    let velocity = VelocitySource::Filtered { resolution_m: 1e-6, acceleration_std_m_per_s2: 1.0 };
    let mut controller = HapticController::new(&Settings { velocity, ..Settings::default() }).expect("valid");
    let mut last = 0.0;
    for k in 0..2000 {
        let command = controller.step(&Sample { slave_velocity_m_per_s: f64::NAN, ..insertion(k) });
        assert!(!command.faults.any());
        last = command.slave_velocity_m_per_s;
    }
    assert!((last - 0.01).abs() < 1e-6, "{last}");
    // A gap of 2 mm disturbs neither the filter nor the estimate.
    for k in 2000..2200 {
        controller.step(&Sample { slave_position_m: f64::NAN, ..insertion(k) });
    }
    for k in 2200..2300 {
        let command = controller.step(&insertion(k));
        assert!((command.slave_velocity_m_per_s - 0.01).abs() < 1e-4, "{command:?}");
    }
}
