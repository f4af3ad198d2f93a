//! General masters: three descriptions of one machine, the appendix' master, the second engine, and closed forms of
//! friction under the arm.

use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

use super::super::{ControlledMaster, LimitedPlants, Plants, TissueForce};
use crate::plant::{
    ActuatorLimits, ArmParameters, GeneralMaster, MasterModel, MasterModelSettings, MasterParameters, SlaveParameters,
};

const TICK_S: f64 = 1e-3;
const START_M: f64 = 0.012;
const NONE: ActuatorLimits = ActuatorLimits::NONE;

fn with<T>(parameters: &MasterParameters, model: &MasterModelSettings, build: fn(&GeneralMaster<'_>) -> T) -> T {
    build(&GeneralMaster { parameters, model, arm: &ArmParameters::default() })
}

fn exact(master: &GeneralMaster<'_>) -> ControlledMaster {
    ControlledMaster::exact(master, &NONE, TICK_S, START_M).expect("valid")
}

fn integrated(master: &GeneralMaster<'_>) -> ControlledMaster {
    ControlledMaster::integrated(master, &NONE, TICK_S, START_M).expect("valid")
}

fn mass(coulomb_friction_n: f64, constant_force_n: f64) -> MasterModelSettings {
    MasterModelSettings {
        model: MasterModel::MassDamper,
        coulomb_friction_n,
        constant_force_n,
        ..MasterModelSettings::default()
    }
}

fn inputs(tick: u32) -> (f64, f64) {
    let t = TICK_S * f64::from(tick);
    let force_n = if tick < 60 { 0.0 } else { 1.5 + (40.0 * t).sin() };
    (START_M + 0.004 * (9.0 * t).sin() + 0.003 * t, force_n)
}

/// Position, velocity and hand force from tick to tick.
fn trace(mut master: ControlledMaster, ticks: u32) -> Vec<[f64; 3]> {
    let mut motions = vec![];
    for tick in 0..ticks {
        let output = master.output();
        motions.push([output.position_m, output.velocity_m_per_s, output.hand_force_n]);
        let ((now_m, force_n), (next_m, _)) = (inputs(tick), inputs(tick + 1));
        master.step([now_m, next_m], force_n).expect("a step");
    }
    motions
}

fn difference(a: &[[f64; 3]], b: &[[f64; 3]]) -> [f64; 3] {
    assert!(a.iter().flatten().chain(b.iter().flatten()).all(|value| value.is_finite()));
    std::array::from_fn(|i| a.iter().zip(b).map(|(a, b)| (a[i] - b[i]).abs()).fold(0.0, f64::max))
}

#[track_caller]
fn assert_alike(a: &[[f64; 3]], b: &[[f64; 3]], bounds: [f64; 3]) {
    let found = difference(a, b);
    assert!((0..3).all(|i| found[i] <= bounds[i]), "{found:?}");
}

#[test]
fn a_mass_without_friction_moves_as_the_appendix_master_under_sampled_control() {
    let parameters = MasterParameters::default();
    let general = trace(with(&parameters, &mass(0.0, 0.0), exact), 400);
    let machines = (&parameters, &ArmParameters::default(), &SlaveParameters::default());
    let mut plants = LimitedPlants::<f64>::new(machines, &NONE, TICK_S, START_M, START_M).expect("valid");
    let mut appendix = vec![];
    for tick in 0..400 {
        let output = plants.master();
        appendix.push([output.position_m, output.velocity_m_per_s, output.hand_force_n]);
        let ((now_m, force_n), (next_m, _)) = (inputs(tick), inputs(tick + 1));
        plants.step(now_m, next_m, force_n, START_M, 0.0, TissueForce::zero()).expect("a step");
    }
    assert_alike(&general, &appendix, [1e-12, 1e-10, 1e-9]);
}

#[test]
fn ten_random_machines_move_alike_in_every_description_and_in_the_second_engine() {
    let mut random = ChaCha8Rng::seed_from_u64(591);
    for case in 0..10 {
        let (mass_kg, damping) = (random.random_range(0.1..1.0), random.random_range(0.5..6.0));
        let parameters = MasterParameters { mass_kg, damping_n_s_per_m: damping, ..MasterParameters::default() };
        let constant_force_n = random.random_range(-2.0..2.0);
        let base = mass(0.0, constant_force_n);
        // In every second case a spring to the frame, which a mass with friction does not describe.
        let stiffness = if case % 2 == 0 { 0.0 } else { random.random_range(10.0..100.0) };
        let function = MasterModelSettings {
            model: MasterModel::TransferFunction,
            numerator: vec![1.0],
            denominator: vec![mass_kg, damping, stiffness],
            ..base.clone()
        };
        // Scaled states: micrometres and cm/s.
        let matrices = MasterModelSettings {
            model: MasterModel::StateSpace,
            a: vec![0.0, 1e4, -1e-4 * stiffness / mass_kg, -damping / mass_kg],
            b: vec![0.0, 0.0, 1e2 / mass_kg, 1e2 / mass_kg],
            c: vec![1e-6, 0.0],
            ..base.clone()
        };
        let first = trace(with(&parameters, &function, exact), 400);
        assert_alike(&first, &trace(with(&parameters, &matrices, exact), 400), [1e-12, 1e-10, 1e-9]);
        for model in [&function, &matrices] {
            assert_alike(&first, &trace(with(&parameters, model, integrated), 400), [1e-11, 1e-9, 1e-8]);
        }
        if case % 2 == 0 {
            assert_alike(&first, &trace(with(&parameters, &base, exact), 400), [1e-12, 1e-10, 1e-9]);
        }
        // At the start nothing moves, and the motor carries the constant force.
        assert!(first[..5].iter().all(|[_, velocity, hand_n]| velocity.abs() < 0.2 && hand_n.abs() < 0.6), "{case}");
    }
}

#[test]
fn friction_agrees_with_the_second_engine_at_a_tenth_of_the_tick() {
    let parameters = MasterParameters::default();
    for (limit_n, constant_n) in [(0.3, 0.0), (0.8, -0.5), (2.0, 0.0)] {
        let model = mass(limit_n, constant_n);
        let (a, b) =
            (trace(with(&parameters, &model, exact), 1500), trace(with(&parameters, &model, integrated), 1500));
        let still = a.iter().filter(|[_, velocity, _]| *velocity == 0.0).count();
        assert!(still > 5, "{limit_n}: it never sticks");
        // A stop is found to a tenth of the tick there, so the error is of that order.
        let [position_m, velocity, force_n] = difference(&a, &b);
        assert!(position_m < 2e-6 && velocity < 2e-3 && force_n < 0.05, "{position_m} {velocity} {force_n}");
    }
}

#[test]
fn friction_holds_the_master_until_the_force_of_the_hand_exceeds_it() {
    // A slow hand on a stiff arm: the master starts when k (x_d - x_h) reaches the friction, with the static stiffness k.
    let parameters = MasterParameters { force_integral_gain: 0.0, ..MasterParameters::default() };
    let limit_n = 1.0;
    let mut master = with(&parameters, &mass(limit_n, 0.0), exact);
    let speed_m_per_s = 1e-4;
    let stiffness = ArmParameters::default().static_stiffness_n_per_m();
    let mut started_s = None;
    for tick in 0..20_000 {
        let t = TICK_S * f64::from(tick);
        master.step([START_M + speed_m_per_s * t, START_M + speed_m_per_s * (t + TICK_S)], 0.0).expect("a step");
        let output = master.output();
        if output.velocity_m_per_s != 0.0 {
            started_s = Some(t + TICK_S);
            break;
        }
        assert!(output.hand_force_n <= limit_n && (output.position_m - START_M).abs() < 1e-15, "{output:?}");
    }
    let expected_s = limit_n / stiffness / speed_m_per_s;
    let started_s = started_s.expect("it starts");
    // The arm's damper lags behind by b / k; both its dampers together are below 0.06 s.
    assert!((started_s - expected_s).abs() < 0.06, "{started_s} against {expected_s}");
}

#[test]
fn a_constant_force_is_carried_by_the_motor_with_an_integral_and_by_the_hand_without() {
    for (gain, hand_n) in [(12.0, 0.0), (0.0, 1.5)] {
        let parameters = MasterParameters { force_integral_gain: gain, ..MasterParameters::default() };
        let mut master = with(&parameters, &mass(0.0, -1.5), exact);
        let start = master.output();
        for _ in 0..200 {
            master.step([START_M; 2], 0.0).expect("a step");
        }
        let output = master.output();
        assert!((output.hand_force_n - hand_n).abs() < 1e-9, "{output:?}");
        assert!((output.position_m - start.position_m).abs() < 1e-12, "{output:?}");
        let expected_m = START_M - hand_n / ArmParameters::default().static_stiffness_n_per_m();
        assert!((output.position_m - expected_m).abs() < 1e-12, "{output:?}");
    }
}

#[test]
fn the_motor_of_a_general_master_saturates() {
    let parameters = MasterParameters::default();
    let limits = ActuatorLimits { master_force_n: Some(0.5), ..NONE };
    let model = mass(0.0, 0.0);
    let master = GeneralMaster { parameters: &parameters, model: &model, arm: &ArmParameters::default() };
    let mut limited = ControlledMaster::exact(&master, &limits, TICK_S, START_M).expect("valid");
    for _ in 0..3000 {
        limited.step([START_M; 2], 4.0).expect("a step");
    }
    // At rest the hand feels what the motor can give.
    assert!((limited.output().hand_force_n - 0.5).abs() < 1e-9, "{:?}", limited.output());
}
