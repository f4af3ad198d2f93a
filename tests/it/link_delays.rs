//! Delays of fractions of a tick agree with exact solutions that do not share the engine's step.

use crate::support::{difference, scenario};
use nalgebra::{DMatrix, DVector};
use trocar::engine::Trace;
use trocar::lti::{Continuous, StateSpace};
use trocar::plant::{ArmParameters, ControlTiming, MasterParameters, SlaveParameters, master_system, slave_system};
use trocar::run::run;

const TICK_S: f64 = 1e-3;
const TICKS: usize = 1500;

fn trace(settings: &[&str]) -> Trace {
    let base = [
        "operator.kind=ramp",
        "operator.speed_m_per_s=0.02",
        "tissue.kind=kelvin-voigt",
        "simulation.duration_s=1.5",
        "estimator.contact_m=1",
    ];
    let scenario = scenario("paper/classical", &[&base[..], settings].concat());
    run(scenario).expect("runs").trace
}

/// Returns `exp(A t)` and `∫₀ᵗ exp(A s) ds` by a Taylor series in small steps, independent of the holds of `lti`.
fn flow(a: &DMatrix<f64>, t: f64) -> (DMatrix<f64>, DMatrix<f64>) {
    const HALVINGS: i32 = 12;
    let n = a.nrows();
    let h = t / 2f64.powi(HALVINGS);
    let (mut phi, mut integral) = (DMatrix::identity(n, n), DMatrix::zeros(n, n));
    let mut term = DMatrix::identity(n, n);
    for k in 1..12 {
        integral += &term * (h / f64::from(k));
        term = a * &term * (h / f64::from(k));
        phi += &term;
    }
    for _ in 0..HALVINGS {
        integral = &integral + &phi * &integral;
        phi = &phi * &phi;
    }
    (phi, integral)
}

/// A plant between breakpoints, with held inputs and without the engine.
struct Side {
    system: StateSpace<Continuous>,
    state: DVector<f64>,
}

impl Side {
    fn go(&mut self, t: f64, inputs: &[f64]) {
        let (phi, integral) = flow(self.system.a(), t);
        let push = self.system.b() * DVector::from_column_slice(inputs);
        self.state = phi * &self.state + integral * push;
    }
}

#[test]
fn a_delay_of_a_fraction_of_a_tick_shifts_the_step_response_of_the_channel() {
    // With a stepped reference, the slave follows its closed form after 3.7 ticks, within a microsecond.
    let slave = slave_system(&SlaveParameters::default(), ControlTiming::Continuous).expect("valid");
    let (share, whole) = (0.7, 3);
    let trace = trace(&["channel.forward_delay_s=0.0037", "scaling.force=0"]);
    // The motion of the master arrives 3.7 ticks later, held between samples.
    let mut side = Side { state: DVector::zeros(3), system: slave };
    let mut expected = vec![];
    for k in 0..TICKS {
        expected.push(side.state[0]);
        let sample = |k: Option<usize>| k.map_or(0.0, |k| trace.master_position_m[k]);
        side.go(share * TICK_S, &[sample(k.checked_sub(whole + 1))]);
        side.go((1.0 - share) * TICK_S, &[sample(k.checked_sub(whole))]);
    }
    let error = difference(&trace.slave_position_m, &expected, 1);
    assert!(error < 1e-9, "{error:e}");
}

#[test]
fn the_closed_loop_with_delays_of_3_7_and_1_25_ticks_agrees_with_its_parts() {
    is_that_of_its_parts(0.0);
}

#[test]
fn a_compliant_slave_also_reads_a_delayed_sample_on_arrival() {
    is_that_of_its_parts(5e-4);
    // Delays of 2.1 and 2.6 ticks must not both act as 3.
    let with = |delay: &str| trace(&[&format!("channel.delay_s={delay}"), "slave.compliance_m_per_n=5e-4"]);
    let [early, late, whole] = ["0.0021", "0.0026", "0.003"].map(with);
    for (a, b) in [(&early, &late), (&late, &whole)] {
        assert!(difference(&a.slave_position_m, &b.slave_position_m, 1) > 1e-6);
    }
}

/// Compares a loop with its parts between the arrivals of samples. The tissue moves the slave by `compliance` (m/N).
fn is_that_of_its_parts(compliance: f64) {
    let trace = trace(&[
        "channel.forward_delay_s=0.0037",
        "channel.backward_delay_s=0.00125",
        &format!("slave.compliance_m_per_n={compliance}"),
    ]);
    let master = master_system(&MasterParameters::default(), &ArmParameters::default(), ControlTiming::Continuous);
    let slave = slave_system(&SlaveParameters::default(), ControlTiming::Continuous).expect("valid");
    let mut master = Side { system: master.expect("valid"), state: DVector::zeros(5) };
    let mut slave = Side { system: slave, state: DVector::zeros(3) };
    let (mut hand, mut force) = (vec![], vec![]);
    let (mut x_h, mut x_e) = (vec![], vec![]);
    // Within a tick the desired position is a ramp, which needs one more state.
    let mut augmented = DMatrix::zeros(6, 6);
    augmented.view_mut((0, 0), (5, 5)).copy_from(master.system.a());
    augmented.view_mut((0, 5), (5, 1)).copy_from(&master.system.b().column(0));
    let desired = |k: usize| (0.02 * TICK_S * k as f64).min(0.02);
    for k in 0..TICKS {
        hand.push(master.state[0]);
        x_h.push(master.state[0]);
        x_e.push(slave.state[0]);
        let (depth, velocity) = (slave.state[0], slave.state[1]);
        force.push(if depth > 0.0 { 200.0 * depth + 5.0 * velocity } else { 0.0 });
        let late = |samples: &[f64], ticks: usize| k.checked_sub(ticks).map_or(0.0, |k| samples[k]);
        for (part, ticks) in [(0.7, 4), (0.3, 3)] {
            slave.go(part * TICK_S, &[late(&hand, ticks) - compliance * force[k]]);
        }
        let speed = (desired(k + 1) - desired(k)) / TICK_S;
        let mut at = desired(k);
        for (part, ticks) in [(0.25, 2), (0.75, 1)] {
            let t = part * TICK_S;
            let (phi, integral) = flow(&augmented, t);
            let mut state = DVector::zeros(6);
            state.rows_mut(0, 5).copy_from(&master.state);
            state[5] = at;
            let mut push = DVector::zeros(6);
            let b = master.system.b();
            push.rows_mut(0, 5).copy_from(&(b.column(1) * speed + b.column(2) * late(&force, ticks)));
            push[5] = speed;
            let next = phi * state + integral * push;
            master.state.copy_from(&next.rows(0, 5));
            at += speed * t;
        }
    }
    for (name, computed, expected) in
        [("master", &trace.master_position_m, &x_h), ("slave", &trace.slave_position_m, &x_e)]
    {
        let error = difference(computed, expected, 1);
        assert!(error < 1e-9, "{name}: {error:e}");
    }
    assert!(x_e[TICKS - 1] > 0.01, "the loop is closed on tissue: {}", x_e[TICKS - 1]);
}

#[test]
fn the_integrated_engine_agrees_and_sampled_controllers_wait_for_their_tick() {
    let delays = ["channel.forward_delay_s=0.0023", "channel.backward_delay_s=0.0006"];
    for compliance in ["slave.compliance_m_per_n=0", "slave.compliance_m_per_n=5e-4"] {
        let exact = trace(&[&delays[..], &[compliance]].concat());
        let integrated = trace(&[&delays[..], &[compliance, "simulation.engine=dop853"]].concat());
        for (a, b) in exact.numbers()[..10].iter().zip(&integrated.numbers()[..10]) {
            assert!(difference(a, b, 1) < 1e-8);
        }
    }
    let sampled = |forward: &str, backward: &str| trace(&["simulation.control=sampled", forward, backward]);
    assert_eq!(
        sampled(delays[0], delays[1]).slave_position_m,
        sampled("channel.forward_delay_s=0.003", "channel.backward_delay_s=0.001").slave_position_m
    );
}

#[test]
fn a_whole_delay_is_the_limit_of_fractional_ones() {
    let with = |delay: &str| trace(&[&format!("channel.forward_delay_s={delay}")]).slave_position_m;
    let whole = with("0.003");
    for near in ["0.003000001", "0.002999999"] {
        assert!(difference(&with(near), &whole, 1) < 1e-6, "{near}");
    }
}
