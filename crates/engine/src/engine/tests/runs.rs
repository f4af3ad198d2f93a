//! Complete runs with built-in parts.

use std::sync::Arc;

use super::super::{
    Any, Engine, ExactPlants, MasterSide, Plants, ScheduledAlarms, SideEngine, SlaveSide, Trace, Wiring,
};
use crate::channel::Delay;
use crate::operator::{HumanOperator, Motion, Ramp};
use crate::plant::{ArmParameters, ControlTiming, MasterParameters, MasterStep, SlaveParameters, SlaveStep};
use crate::sensor::{AnySensor, SensorSettings};
use crate::teleoperation::{
    ControllerSettings, Lines, Link, LinkSettings, Machines, PassivitySettings, Received, RecoverySettings, Scheme,
};
use crate::tissue::{AnyTissue, KelvinVoigt, KelvinVoigtSettings};
use trocar_core::augmentation::{AugmentationSettings, Supervisor};
use trocar_core::chain::Chain;
use trocar_core::detector::{CusumDetector, DetectorSettings};
use trocar_core::estimation::{AnyEstimator, RlsSettings};
use trocar_core::time::TickGrid;

const TICK_S: f64 = 1e-3;

/// A hand that moves at 20 mm/s to 20 mm, in a spring and a damper, with delays each way in ticks, a scheme, a
/// stiffness, and scheduled alarms.
#[derive(Clone, Copy)]
struct Case {
    ticks: u64,
    delays: [u64; 2],
    scheme: Scheme,
    stiffness_n_per_m: f64,
    alarm_at: Option<u64>,
}

const CASE: Case = Case { ticks: 4000, delays: [0, 0], scheme: Scheme::None, stiffness_n_per_m: 300.0, alarm_at: None };

impl Case {
    fn plants(&self) -> ExactPlants<f64> {
        let (master, arm, slave) = (MasterParameters::default(), ArmParameters::default(), SlaveParameters::default());
        let master = MasterStep::new(&master, &arm, ControlTiming::Continuous, TICK_S).expect("valid");
        ExactPlants::new(&master, &self.slave(&slave), 0.0, 0.0)
    }

    fn slave(&self, slave: &SlaveParameters) -> SlaveStep {
        SlaveStep::new(slave, ControlTiming::Continuous, TICK_S).expect("valid")
    }

    fn parts(&self) -> Any<f64> {
        let slave = SlaveParameters::default();
        let (drag, inertia) = slave.slow_motion().expect("valid");
        let machines = Machines {
            master_mass_kg: MasterParameters::DEFAULT.mass_kg,
            master_damping_n_s_per_m: MasterParameters::DEFAULT.damping_n_s_per_m,
            proportional_gain: slave.proportional_gain,
            velocity_gain: slave.velocity_gain,
            slave_drag: drag,
            slave_inertia: inertia,
            compliance_m_per_n: 0.0,
            position_scale: 1.0,
            force_scale: 1.0,
        };
        let settings = LinkSettings {
            controller: ControllerSettings::DEFAULT,
            machines,
            recovery: RecoverySettings::DEFAULT,
            passivity: PassivitySettings { scheme: self.scheme, ..PassivitySettings::DEFAULT },
        };
        let [forward, backward] = self.delays;
        let lines = Lines {
            forward: Delay::new(forward, [0.0; 4]),
            backward: Delay::new(backward, [0.0; 5]),
            forward_payload: Delay::new(forward, [0.0; 4]),
            backward_payload: Delay::new(backward, [0.0; 4]),
        };
        let link = Link::new(&settings, lines, &self.slave(&slave), TICK_S, 0.0).expect("valid");
        let detector = DetectorSettings::default();
        let spring = KelvinVoigtSettings { stiffness_n_per_m: self.stiffness_n_per_m, ..Default::default() };
        super::super::Parts {
            operator: HumanOperator::new(Motion::Ramp(Ramp::new(0.0, 0.02, 0.02, TICK_S).expect("finite"))),
            tissue: AnyTissue::from(KelvinVoigt::new(&spring).expect("valid")),
            sensor: AnySensor::new(&SensorSettings::default(), TICK_S, (1, 0)).expect("valid"),
            chain: Chain {
                contact_m: 0.0,
                estimator: AnyEstimator::new(&RlsSettings::DEFAULT),
                detector: ScheduledAlarms::new(
                    CusumDetector::new(&detector, TICK_S),
                    self.alarm_at.into_iter().collect::<Arc<[u64]>>(),
                ),
            },
            supervisor: Supervisor::new(&AugmentationSettings::default(), detector.cusum.threshold, TICK_S, 0.0),
            link,
            safety: None,
            master_reading: None,
        }
    }

    fn grid(&self) -> TickGrid {
        TickGrid::new(TICK_S, TICK_S * self.ticks as f64).expect("a grid")
    }

    fn engine(&self) -> Engine<ExactPlants<f64>, Any<f64>> {
        Engine { grid: self.grid(), plants: self.plants(), parts: self.parts() }
    }

    fn side(&self) -> SideEngine {
        let plants: Box<dyn Plants<f64> + Send> = Box::new(self.plants());
        Engine { grid: self.grid(), plants, parts: self.parts() }
    }

    fn trace(&self) -> Trace {
        let mut trace = Trace::new(self.grid());
        self.engine().run(&mut trace).expect("a run");
        trace
    }
}

#[test]
fn a_hand_at_rest_in_a_spring_settles_where_arm_and_tissue_are_in_balance() {
    let trace = CASE.trace();
    assert_eq!(trace.len(), 4000);
    // K_a (x_d - x_h) = K x_h, with the static stiffness of the arm.
    let arm = ArmParameters::default().static_stiffness_n_per_m();
    let master_m = arm * 0.02 / (arm + 300.0);
    let last = |column: &[f64]| column[column.len() - 1];
    assert!((last(&trace.master_position_m) - master_m).abs() < 1e-8, "{}", last(&trace.master_position_m));
    assert!((last(&trace.slave_position_m) - master_m).abs() < 1e-8);
    for force in [&trace.operator_force_n, &trace.tissue_force_n, &trace.feedback_force_n, &trace.measured_force_n] {
        assert!((last(force) - 300.0 * master_m).abs() < 1e-5, "{}", last(force));
    }
    assert!((last(&trace.desired_position_m) - 0.02).abs() < 1e-12);
    // The spring holds K x²/2; the needle's work also covers the loss in the damper.
    let stored = 0.5 * 300.0 * master_m * master_m;
    let work = last(&trace.needle_energy_j);
    assert!(work > stored && work < 1.1 * stored, "{work} {stored}");
    assert!(last(&trace.hand_energy_j) > last(&trace.master_energy_j), "the master dissipates");
}

#[test]
fn a_delayed_link_delays_the_slave_by_its_ticks() {
    let reference = |delays| Case { delays, ..CASE }.trace().slave_reference_m;
    let late = Case { delays: [7, 3], ..CASE }.trace();
    for tick in 7..2000 {
        assert_eq!(late.slave_reference_m[tick], late.master_position_m[tick - 7], "{tick}");
        assert_eq!(late.feedback_force_n[tick], late.measured_force_n[tick - 3], "{tick}");
    }
    assert_ne!(reference([0, 0]), reference([7, 3]));
}

#[test]
fn an_alarm_freezes_the_slave_in_a_run() {
    let trace = Case { alarm_at: Some(500), ..CASE }.trace();
    let frozen = trace.slave_reference_m[500];
    assert!((500..1000).all(|tick| trace.slave_reference_m[tick] == frozen));
    assert!(trace.master_position_m[999] > trace.master_position_m[500] + 1e-3, "the hand goes on");
    assert_ne!(trace.slave_reference_m[1500], frozen);
    assert_eq!((trace.mode[499], trace.mode[500], trace.mode[999], trace.mode[1000]), (0, 1, 1, 2));
}

#[test]
fn two_sides_in_two_processes_equal_one_engine() {
    for (delays, scheme) in [([1, 1], Scheme::None), ([4, 2], Scheme::None), ([3, 5], Scheme::TimeDomain)] {
        let case = Case { ticks: 1500, delays, scheme, alarm_at: Some(600), ..CASE };
        let together = case.trace();
        let (mut master, mut slave) = (MasterSide::new(case.side(), [0.0; 5]), SlaveSide::new(case.side(), [0.0; 4]));
        let (mut of_master, mut of_slave) = (Trace::new(case.grid()), Trace::new(case.grid()));
        let (mut forward, mut forward_payload) = (Delay::new(delays[0], [0.0; 4]), Delay::new(delays[0], [0.0; 4]));
        let (mut backward, mut backward_payload) = (Delay::new(delays[1], [0.0; 5]), Delay::new(delays[1], [0.0; 4]));
        for tick in 0..1500 {
            assert!(!master.has_ended() && !slave.has_ended());
            assert_eq!((master.tick(), slave.tick()), (tick, tick));
            let sent = master.send();
            let (arrival, payload) = (forward.exchange(sent.sample), forward_payload.exchange(sent.payload));
            let received = Received { sample: arrival.sample, payload: payload.sample, is_fresh: arrival.is_fresh };
            let sent = slave.step(&received, &mut of_slave).expect("a step");
            let (arrival, payload) = (backward.exchange(sent.sample), backward_payload.exchange(sent.payload));
            let received = Received { sample: arrival.sample, payload: payload.sample, is_fresh: arrival.is_fresh };
            master.step(&received, &mut of_master).expect("a step");
        }
        assert!(master.has_ended() && slave.has_ended());
        assert_eq!(of_master.master_position_m, together.master_position_m, "{delays:?}");
        assert_eq!(of_master.operator_force_n, together.operator_force_n);
        assert_eq!(of_master.feedback_force_n, together.feedback_force_n);
        assert_eq!(of_master.desired_position_m, together.desired_position_m);
        assert_eq!(of_slave.slave_position_m, together.slave_position_m);
        assert_eq!(of_slave.slave_reference_m, together.slave_reference_m);
        assert_eq!(of_slave.mode, together.mode);
        assert_eq!((of_master.slave_position_m[700], of_slave.master_position_m[700]), (0.0, 0.0), "the other side");
        assert_eq!(master.promised_j().is_some(), scheme != Scheme::None);
        assert_eq!(master.promised_j(), slave.promised_j());
        // Energies of the ports, up to the last tick that each side has sent.
        let (e_m, e_s) = (together.master_energy_j[1499], together.needle_energy_j[1499]);
        assert!((master.energy_j() - e_m).abs() < 1e-9, "{} {e_m}", master.energy_j());
        assert!((slave.energy_j() - e_s).abs() < 1e-9, "{} {e_s}", slave.energy_j());
        assert!(format!("{master:?} {slave:?}").contains("MasterSide { tick: 1500"));
    }
}

#[test]
fn the_report_of_a_link_contains_the_energies_of_its_ports() {
    let case = Case { ticks: 800, delays: [2, 3], alarm_at: Some(300), ..CASE };
    let (mut engine, mut trace) = (case.engine(), Trace::new(case.grid()));
    engine.run(&mut trace).expect("a run");
    let report = engine.parts.link_report(0).expect("it is delayed");
    assert!((report.master_port_j - trace.master_energy_j[799]).abs() < 1e-12);
    assert!((report.slave_port_j - trace.needle_energy_j[799]).abs() < 1e-12);
    let excess = |tick: usize| trace.needle_energy_j[tick] - trace.master_energy_j[tick];
    let generated = (0..800).map(excess).fold(0.0, f64::max);
    assert!(generated > 0.0 && (report.generated_j - generated).abs() < 1e-12, "{} {generated}", report.generated_j);
    let ahead = trace.slave_position_m[799] - trace.master_position_m[799];
    assert!((report.left_behind_m - ahead.max(0.0)).abs() < 1e-15);
}
