//! The inputs of each part of a tick, by parts that record their calls.

use std::cell::RefCell;
use std::ops::ControlFlow;
use std::rc::Rc;

use super::super::{
    IntegrationError, MasterOutput, Observer, Parts, Plants, Signals, SlaveOutput, TissueForce, Wiring,
};
use crate::operator::Operator;
use crate::sensor::Sensor;
use crate::teleoperation::{AtMaster, AtSlave, Connection, LinkReport};
use crate::tissue::{Reaction, Tissue};
use trocar_core::augmentation::{AugmentationSettings, Modes, Supervisor};
use trocar_core::chain::{Chain, Measurement};
use trocar_core::detector::{Decision, Detector, DetectorInput};
use trocar_core::estimation::{Estimate, Estimator};

/// Calls of the parts, in order.
type Calls = Rc<RefCell<Vec<String>>>;

struct Marking(Calls);

impl Marking {
    fn call(&self, text: String) {
        self.0.borrow_mut().push(text);
    }
}

impl Operator<f64> for Marking {
    fn desired_position_m(&mut self, tick: u64, felt_n: f64) -> f64 {
        self.call(format!("desired at {tick}, felt {felt_n}"));
        7.5
    }
    fn intended_position_m(&self, desired_m: f64) -> f64 {
        desired_m + 0.25
    }
    fn master(&mut self, position_m: f64) {
        self.call(format!("master at {position_m}"));
    }
    fn cue(&mut self, is_on: bool) {
        self.call(format!("cue {is_on}"));
    }
    fn notices(&self) -> bool {
        true
    }
}

impl Tissue<f64> for Marking {
    fn react(&mut self, tick: u64, position_m: f64, velocity_m_per_s: f64) -> Reaction<f64> {
        self.call(format!("tissue at {tick}, {position_m}, {velocity_m_per_s}"));
        Reaction { force_n: 20.0, ruptured: true }
    }
    fn shaft_force_n(&self) -> f64 {
        4.0
    }
}

/// A sensor at the tip or at the base that adds an offset to each of its channels.
struct MarkingSensor(bool, Calls);

impl Sensor<f64> for MarkingSensor {
    fn read(&mut self, force_n: f64, position_m: f64, velocity_m_per_s: f64) -> Measurement<f64> {
        self.1.borrow_mut().push(format!("sensor {force_n}"));
        Measurement { force_n: force_n + 1.0, position_m: position_m + 0.5, velocity_m_per_s: velocity_m_per_s + 0.25 }
    }
    fn excludes_shaft(&self) -> bool {
        self.0
    }
}

impl Estimator<f64> for Marking {
    fn update(&mut self, force_n: f64, depth_m: f64, velocity_m_per_s: f64) -> Estimate<f64> {
        self.call(format!("estimator {force_n}, {depth_m}, {velocity_m_per_s}"));
        Estimate {
            predicted_force_n: 31.0,
            residual_n: 32.0,
            correction: [33.0, 34.0],
            stiffness_n_per_m: 35.0,
            damping_n_s_per_m: 36.0,
            extra_parameter: 37.0,
        }
    }
    fn skip(&mut self) {}
}

impl Detector<f64> for Marking {
    fn update(&mut self, input: &DetectorInput<f64>) -> Decision<f64> {
        self.call(format!("detector {}, {}", input.residual_n, input.force_n));
        Decision { distance: 41.0, decision: 42.0, alarm: false }
    }
}

impl Connection<f64> for Marking {
    fn position_scale(&self) -> f64 {
        1.0
    }
    fn force_scale(&self) -> f64 {
        1.0
    }
    fn to_slave(&mut self, master: &AtMaster<f64>, slave: &AtSlave<f64>) -> f64 {
        self.call(format!("to slave {}, {}, {}", master.position_m, master.velocity_m_per_s, master.hand_force_n));
        self.call(format!("  from slave {}, {}, {}", slave.position_m, slave.velocity_m_per_s, slave.force_n));
        51.0
    }
    fn limit_reference(&mut self, reference_m: f64, _slave: &AtSlave<f64>) -> f64 {
        self.call(format!("limit reference {reference_m}"));
        reference_m + 0.5
    }
    fn to_master(&mut self, modes: Modes<f64>, _slave: &AtSlave<f64>, _master: &AtMaster<f64>) -> (Modes<f64>, f64) {
        self.call("to master".into());
        (modes, 61.0)
    }
    fn limit(&mut self, force_n: f64, _master: &AtMaster<f64>) -> f64 {
        self.call(format!("limit {force_n}"));
        force_n + 0.5
    }
    fn deflection_m(&self, tissue_force_n: f64) -> f64 {
        0.001 * tissue_force_n
    }
    fn report(&self, index: usize) -> Option<LinkReport> {
        self.call(format!("report {index}"));
        None
    }
}

impl Plants<f64> for Marking {
    fn master(&self) -> MasterOutput<f64> {
        MasterOutput { position_m: 1.0, velocity_m_per_s: 2.0, hand_force_n: 3.0 }
    }
    fn slave(&self) -> SlaveOutput<f64> {
        SlaveOutput { position_m: 5.0, velocity_m_per_s: 6.0 }
    }
    fn step(
        &mut self,
        desired: f64,
        next: f64,
        feedback: f64,
        reference: f64,
        deflection: f64,
        _: TissueForce<f64>,
    ) -> Result<(), IntegrationError> {
        self.call(format!("step {desired}, {next}, {feedback}, {}", reference - deflection));
        Ok(())
    }
}

struct Watching(Vec<Signals<f64>>, bool, Calls);

impl Observer<f64> for Watching {
    fn observe(&mut self, signals: &Signals<f64>) {
        self.2.borrow_mut().push("observer".into());
        self.0.push(*signals);
    }
    fn is_done(&self) -> bool {
        self.1
    }
}

type MarkingParts = Parts<f64, Marking, Marking, MarkingSensor, Marking, Marking, Marking>;

fn parts(at_tip: bool) -> (MarkingParts, Calls) {
    let calls = Calls::default();
    let part = || Marking(calls.clone());
    let settings = AugmentationSettings::default();
    let parts = Parts {
        operator: part(),
        tissue: part(),
        sensor: MarkingSensor(at_tip, calls.clone()),
        chain: Chain { contact_m: 0.125, estimator: part(), detector: part() },
        supervisor: Supervisor::new(&settings, 1.0, 1e-3, 0.0),
        link: part(),
        safety: None,
        master_reading: None,
    };
    (parts, calls)
}

#[test]
fn a_tick_senses_detects_commands_and_steps_in_this_order() {
    let (mut parts, calls) = parts(false);
    let (mut plants, mut observer) = (Marking(calls.clone()), Watching(vec![], false, calls.clone()));
    let ControlFlow::Continue(next) = parts.tick(9, 7.0, &mut plants, &mut observer) else { panic!("it goes on") };
    assert_eq!(next, 7.5);
    let expected = [
        "tissue at 9, 5, 6",
        "sensor 20",
        "estimator 21, 5.375, 6.25",
        "detector 32, 21",
        "to slave 1, 2, 3",
        "  from slave 5.5, 6.25, 21",
        "limit reference 51",
        "to master",
        "limit 61",
        "observer",
        "cue false",
        "master at 1",
        "desired at 10, felt 3",
        "step 7, 7.5, 61.5, 51.48",
    ];
    assert_eq!(*calls.borrow(), expected);
}

#[test]
fn the_signals_of_a_tick_contain_the_outputs_of_each_part() {
    let (mut parts, calls) = parts(false);
    let (mut plants, mut observer) = (Marking(calls.clone()), Watching(vec![], false, calls));
    let _ = parts.tick(9, 7.0, &mut plants, &mut observer);
    let s = observer.0[0];
    assert_eq!((s.tick, s.desired_position_m, s.intended_position_m), (9, 7.0, 7.25));
    assert_eq!((s.master_position_m, s.master_velocity_m_per_s, s.operator_force_n), (1.0, 2.0, 3.0));
    assert_eq!((s.slave_reference_m, s.slave_position_m, s.slave_velocity_m_per_s), (51.5, 5.0, 6.0));
    assert_eq!((s.tissue_force_n, s.measured_force_n, s.feedback_force_n), (20.0, 21.0, 61.5));
    assert_eq!((s.stiffness_n_per_m, s.damping_n_s_per_m, s.extra_parameter), (35.0, 36.0, 37.0));
    assert_eq!((s.residual_n, s.distance, s.decision), (32.0, 41.0, 42.0));
    assert_eq!((s.commanded_force_n, s.allowed_force_step_n), (61.0, 61.0));
    assert_eq!((s.ruptured, s.noticed, s.alarm, s.alarm_taken), (true, true, false, false));
}

#[test]
fn a_sensor_at_the_tip_does_not_measure_the_friction_on_the_shaft() {
    let (mut parts, calls) = parts(true);
    let (mut plants, mut observer) = (Marking(calls.clone()), Watching(vec![], false, calls.clone()));
    let _ = parts.tick(0, 7.0, &mut plants, &mut observer);
    assert_eq!(calls.borrow()[1], "sensor 16");
    assert_eq!((observer.0[0].tissue_force_n, observer.0[0].measured_force_n), (20.0, 17.0));
}

#[test]
fn an_observer_that_is_done_ends_the_run_before_the_machines_move() {
    let (mut parts, calls) = parts(false);
    let (mut plants, mut observer) = (Marking(calls.clone()), Watching(vec![], true, calls.clone()));
    assert!(matches!(parts.tick(0, 7.0, &mut plants, &mut observer), ControlFlow::Break(Ok(()))));
    assert_eq!(calls.borrow().last().map(String::as_str), Some("observer"));
}
