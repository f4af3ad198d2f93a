//! The engine and the estimator agree with trajectories of an independent implementation (`tests/reference`).

use crate::support::{ClosedLoop, difference, drive, table};
use trocar::engine::{ExactPlants, IntegratedPlants, Trace};
use trocar::estimation::{Estimator, Rls, RlsSettings};
use trocar::plant::{
    ArmParameters, ControlTiming, Coupling, Damping, MasterParameters, MasterStep, SlaveParameters, SlaveStep,
};
use trocar::time::TickGrid;

const TICK_S: f64 = 1e-3;

fn exact(damping: Damping, timing: ControlTiming) -> ExactPlants<f64> {
    let master = MasterStep::new(&MasterParameters::default(), &ArmParameters::default(), timing, TICK_S);
    let slave = SlaveStep::new(&SlaveParameters { damping, ..SlaveParameters::default() }, timing, TICK_S);
    ExactPlants::new(&master.expect("valid"), &slave.expect("valid"), 0.0, 0.0)
}

fn integrated(damping: Damping, timing: ControlTiming, coupling: Coupling) -> IntegratedPlants {
    let master = MasterParameters { coupling, ..MasterParameters::default() };
    let slave = SlaveParameters { damping, ..SlaveParameters::default() };
    IntegratedPlants::new((&master, &ArmParameters::default(), &slave), timing, TICK_S, 0.0, 0.0)
}

#[test]
fn oracle_the_master_side_agrees_with_the_reference() {
    for (name, input) in [
        ("master_force_step", (|_| (0.0, 1.0, 0.0)) as fn(usize) -> (f64, f64, f64)),
        ("master_position_ramp", |k| (5e-6 * k as f64, 0.0, 0.0)),
    ] {
        let reference = table(&format!("tests/reference/{name}.csv"));
        let ticks = reference["time_s"].len();
        let computed = drive(exact(Damping::Velocity, ControlTiming::Continuous), ticks, input);
        for (column, computed) in
            ["master_position_m", "master_velocity_m_per_s", "operator_force_n"].iter().zip(&computed)
        {
            let error = difference(computed, &reference[*column], 1);
            assert!(error < 1e-9, "{name} {column}: {error:e}");
        }
    }
}

#[test]
fn oracle_the_slave_side_agrees_with_the_reference() {
    for (name, damping) in [("slave_step", Damping::Velocity), ("slave_step_as_printed", Damping::AsPrinted)] {
        let reference = table(&format!("tests/reference/{name}.csv"));
        let ticks = reference["time_s"].len();
        let computed = drive(exact(damping, ControlTiming::Continuous), ticks, |_| (0.0, 0.0, 1e-3));
        for (column, computed) in ["slave_position_m", "slave_velocity_m_per_s"].iter().zip(&computed[3..]) {
            let error = difference(computed, &reference[*column], 1);
            assert!(error < 1e-9, "{name} {column}: {error:e}");
        }
    }
}

#[test]
fn oracle_the_closed_loop_agrees_with_the_reference() {
    let kv200 = |delay_ticks| ClosedLoop {
        stiffness_n_per_m: 200.0,
        damping_n_s_per_m: 5.0,
        force_scale: 1.0,
        position_scale: 1.0,
        delay_ticks,
    };
    let scaled = ClosedLoop {
        stiffness_n_per_m: 300.0,
        damping_n_s_per_m: 0.0,
        force_scale: 2.0,
        position_scale: 0.5,
        delay_ticks: 0,
    };
    for (name, insertion) in [
        ("closed_loop_kv200_5", kv200(0)),
        ("closed_loop_kv200_5_delay5", kv200(5)),
        ("closed_loop_kv300_0_force2_position05", scaled),
    ] {
        let mut trace = Trace::new(TickGrid::new(TICK_S, 3.0).expect("valid"));
        insertion.engine(exact(Damping::Velocity, ControlTiming::Continuous)).run(&mut trace).expect("runs");
        let reference = table(&format!("tests/reference/{name}.csv"));
        assert_eq!(reference.len(), 10);
        for (column, expected) in &reference {
            let index =
                trocar::engine::COLUMNS.iter().position(|known| known == column).expect("a column of the trace");
            let error = difference(trace.numbers()[index], expected, 10);
            assert!(error < 1e-9, "{name} {column}: {error:e}");
        }
    }
}

#[test]
fn oracle_estimator_and_cusum_agree_on_the_real_recording() {
    let recording = table("scenarios/recordings/own_ctrl_pop.csv");
    let settings = RlsSettings {
        initial_gain: 1e4,
        reset_threshold: 5.2e-3,
        dead_zone_n: 0.03,
        normalisation: 0.0,
        ..RlsSettings::default()
    };
    let mut rls = Rls::<f64>::new(&settings);
    let mut decision = 0.0_f64;
    let mut computed: [Vec<f64>; 4] = Default::default();
    let columns = ["xs_rad", "vs_rad_s", "env_out_Nm_derived"].map(|name| recording[name].iter());
    let [angles, speeds, torques] = columns;
    for ((angle, speed), torque) in angles.zip(speeds).zip(torques) {
        let estimate = rls.update(torque / 0.075, 0.075 * angle - 6.30e-3, 0.075 * speed);
        decision = (decision + estimate.residual_n.powi(2) - 2.02e-2).max(0.0);
        let row = [estimate.residual_n, estimate.stiffness_n_per_m, estimate.damping_n_s_per_m, decision];
        for (column, value) in computed.iter_mut().zip(row) {
            column.push(value);
        }
    }
    let reference = table("tests/reference/rls_cusum_pop.csv");
    let rows: Vec<usize> = reference["time_s"].iter().map(|t| (t / 5e-4).round() as usize).collect();
    for (column, computed) in
        ["residual_n", "stiffness_n_per_m", "damping_n_s_per_m", "decision_uncapped"].iter().zip(&computed)
    {
        let kept: Vec<f64> = rows.iter().map(|&row| computed[row]).collect();
        let error = difference(&kept, &reference[*column], 1);
        assert!(error < 1e-9, "{column}: {error:e}");
    }
}

#[test]
fn oracle_a_slave_of_degree_two_rests_at_the_exact_position() {
    for damping in [Damping::Velocity, Damping::AsPrinted] {
        let slave = SlaveParameters {
            numerator: vec![6.0],
            denominator: vec![1.0, 100.0, 50.0],
            damping,
            ..SlaveParameters::default()
        };
        let (master, arm) = (MasterParameters::default(), ArmParameters::default());
        let timing = ControlTiming::Continuous;
        let master_step = MasterStep::new(&master, &arm, timing, TICK_S).expect("valid");
        let slave_step = SlaveStep::new(&slave, timing, TICK_S).expect("valid");
        let input = |_| (0.01, 0.0, 0.01);
        let exact = drive(ExactPlants::new(&master_step, &slave_step, 0.01, 0.01), 300, input);
        let integrated = drive(IntegratedPlants::new((&master, &arm, &slave), timing, TICK_S, 0.01, 0.01), 300, input);
        let error = difference(&exact[3], &integrated[3], 1);
        assert!(error < 1e-9, "{damping:?}: {error:e}");
        assert!(difference(&exact[3], &vec![exact[3][0]; 300], 1) < 1e-9, "at rest it stays");
    }
}

#[test]
fn oracle_numerical_integration_agrees_with_the_exact_step() {
    let input = |k: usize| {
        let t = k as f64 * TICK_S;
        (0.01 * t, 2.0 * (7.0 * t).sin(), 0.01 * t + 1e-3 * (11.0 * t).cos())
    };
    for damping in [Damping::Velocity, Damping::AsPrinted] {
        for timing in [ControlTiming::Continuous, ControlTiming::Sampled] {
            let exact = drive(exact(damping, timing), 500, input);
            let integrated = drive(integrated(damping, timing, Coupling::Physical), 500, input);
            for (name, (a, b)) in ["x_h", "v_h", "F_h", "x_e", "v_e"].iter().zip(exact.iter().zip(&integrated)) {
                let error = difference(a, b, 1);
                assert!(error < 1e-8, "{damping:?} {timing:?} {name}: {error:e}");
            }
        }
    }
}
