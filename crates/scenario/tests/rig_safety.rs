//! The safety stage of a rig on the samples of the shipped scenarios.

use trocar_core::rig::{HapticController, Sample};
use trocar_core::safety::FaultCause;
use trocar_engine::engine::{Observer, Signals};
use trocar_scenario::{Scenario, Source};

struct Tape(Vec<Sample>);

impl Observer<f64> for Tape {
    fn observe(&mut self, signals: &Signals<f64>) {
        self.0.push(Sample {
            master_position_m: signals.master_position_m,
            slave_position_m: signals.slave_position_m,
            slave_velocity_m_per_s: signals.slave_velocity_m_per_s,
            force_n: signals.measured_force_n,
        });
    }
}

/// Most ticks at which the largest speed of the reference may act: where the slave lags far behind the hand, a freeze
/// at the measured slave is a step of the reference.
const STEP_TICKS: u64 = 25;

#[test]
fn the_default_limits_act_only_where_a_shipped_scenario_asks_for_a_jump() {
    let mut scenarios = 0;
    for (name, _) in trocar_scenario::shipped_questions() {
        let Ok(scenario) = Scenario::load(&Source::parse(&format!("builtin:{name}")), &[]) else { continue };
        let Ok(mut controller) = HapticController::new(&scenario.rig_settings()) else { continue };
        let mut tape = Tape(vec![]);
        scenario.build().expect("builds").run(&mut tape).expect("runs");
        let last = tape.0.iter().map(|sample| controller.step(sample)).last().expect("samples");
        let counts = controller.safety_counts();
        assert_eq!((counts.force_rate, counts.lead, counts.alignments), (0, 0, 0), "{name}: {counts:?}");
        // The limit of the master's motor is that of the rig.
        assert_eq!(counts.force > 0, scenario.actuators.master_force_n.is_some(), "{name}: {counts:?}");
        // This tissue has a plateau, and its sensor has no noise; the scenario that swings ends before it.
        let is_stuck = name.starts_with("paper/depth-") && name != "paper/depth-swing.toml";
        assert_eq!(last.fault, is_stuck.then_some(FaultCause::StuckForce), "{name}");
        let snaps = name == "strategies/snap.toml";
        assert!(counts.reference_speed <= if snaps { 100 } else { STEP_TICKS }, "{name}: {counts:?}");
        assert!(!snaps || counts.reference_speed > STEP_TICKS, "the snap is a jump");
        scenarios += 1;
    }
    assert!(scenarios > 30, "{scenarios}");
}
