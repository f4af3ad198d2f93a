//! The transfer functions of the appendix, as printed and in their physical reading, have the poles of an independent
//! computation.

use nalgebra::dmatrix;
use trocar::lti::{
    Complex64, Continuous, Error, Interconnection, Signal, StateSpace, TransferFunction, append, realise,
    realise_with_derivative,
};

const TOLERANCE: f64 = 1e-6;
const CANCEL: f64 = 1e-6;

const K_A: f64 = 733.0;
const B_A: f64 = 37.3;
const K_H: f64 = 14998.0;
const B_H: f64 = 178.0;
const M_H: f64 = 1.88;
const K_I: f64 = 12.0;
const K_P: f64 = 1300.0;
const K_V: f64 = 15.0;

const PHYSICAL_MASTER: [(f64, f64); 5] = [
    (-162.41280488, 0.0),
    (-43.71857234, -68.79047016),
    (-43.71857234, 68.79047016),
    (-21.02629518, 0.0),
    (-12.62462369, 0.0),
];

fn tf(numerator: &[f64], denominator: &[f64]) -> TransferFunction {
    TransferFunction::new(numerator, denominator).expect("well formed")
}

fn minimal(function: &TransferFunction) -> TransferFunction {
    function.minimal(CANCEL).expect("the roots converge")
}

fn assert_poles(found: &[Complex64], expected: &[(f64, f64)]) {
    assert_eq!(found.len(), expected.len(), "{found:?}");
    for (pole, (re, im)) in found.iter().zip(expected) {
        assert!((pole - Complex64::new(*re, *im)).norm() < TOLERANCE, "{pole} should be {re}{im:+}i");
    }
}

/// Eq. 28.
fn master() -> TransferFunction {
    tf(&[1.0], &[0.245, 4.1, 0.0])
}

/// Eq. 30.
fn slave() -> TransferFunction {
    tf(&[7.778, 656.0], &[1.0, 104.1, 1.131e-4, 0.0])
}

/// Returns `loading` and `reach` of eq. 32-35, as printed: `F_h = loading · (reach · X_d - X_h)`, with `loading = s Z_a / (1 +
/// Z_a G_h)` and `reach = Z_h G_h`.
fn arm() -> (TransferFunction, TransferFunction) {
    let s = tf(&[1.0, 0.0], &[1.0]);
    let one = tf(&[1.0], &[1.0]);
    let z_a = tf(&[B_A, K_A], &[1.0, 0.0]);
    let z_h = tf(&[B_H, K_H], &[1.0, 0.0]);
    let g_h = tf(&[1.0, 0.0], &[M_H, B_H, K_H]);
    let around = &one + &(&z_a * &g_h);
    let loading = &(&s * &z_a) * &around.inverse().expect("not zero");
    (minimal(&loading), minimal(&(&z_h * &g_h)))
}

#[test]
fn oracle_the_slave_with_velocity_damping_has_the_computed_poles() {
    // Eq. 31 with the damping on the velocity: U_s = K_p (X_ref - X_e) - K_v s X_e.
    let back = tf(&[K_V, K_P], &[1.0]);
    let closed = &slave().feedback(&back).expect("regular") * &tf(&[K_P], &[1.0]);
    let expected = [(-109.79934886, 0.0), (-55.48532557, -68.47096846), (-55.48532557, 68.47096846)];
    assert_poles(&closed.poles().expect("converges"), &expected);
    assert!((closed.dc_gain().expect("finite") - 1.0).abs() < 1e-12);
    let realised = realise_with_derivative(&closed).expect("relative degree 2");
    assert_poles(&realised.poles().expect("converges"), &expected);
}

#[test]
fn paper_slave_as_printed_is_barely_damped() {
    let closed = &slave().feedback(&tf(&[K_P + K_V], &[1.0])).expect("regular") * &tf(&[K_P], &[1.0]);
    assert_poles(
        &closed.poles().expect("converges"),
        &[(-93.44011474, 0.0), (-5.32994263, -95.93539974), (-5.32994263, 95.93539974)],
    );
    assert!((closed.dc_gain().expect("finite") - 1300.0 / 1315.0).abs() < 1e-12);
}

#[test]
fn paper_arm_is_improper_and_static_stiffness_is_two_springs_in_series() {
    let (loading, reach) = arm();
    assert_eq!(loading.relative_degree(), Some(-1));
    assert_eq!(realise(&loading), Err(Error::Improper { numerator_degree: 3, denominator_degree: 2 }));
    let stiffness = minimal(&(&loading * &reach)).dc_gain().expect("finite");
    assert!((stiffness - K_A * K_H / (K_A + K_H)).abs() < 1e-9);
}

#[test]
fn oracle_the_master_closed_by_algebra_has_the_computed_poles() {
    // X_h = G_m (F_h - U_m), U_m = F_ed + K_i/s (F_ed - F_h), so X_h = G_m (1 + K_i/s) (F_h - F_ed).
    let (loading, _) = arm();
    let controlled = &master() * &(&tf(&[1.0], &[1.0]) + &tf(&[K_I], &[1.0, 0.0]));
    let around = &loading * &controlled;
    // Both G_m (1 + K_i/s) and the arm's part contain an s, so cancel before closing the loop.
    let loop_only = minimal(&around).feedback(&tf(&[1.0], &[1.0])).expect("regular");
    assert_poles(&minimal(&loop_only).poles().expect("converges"), &PHYSICAL_MASTER);
}

#[test]
fn paper_master_as_printed_is_unstable() {
    // X_h = G_m U_m, without an action of the hand on the master: X_h = G_m (F_ed + K_i/s (F_ed - F_h)).
    let (loading, _) = arm();
    let around = &(&loading * &master()) * &tf(&[-K_I], &[1.0, 0.0]);
    let poles = minimal(&around.feedback(&tf(&[1.0], &[1.0])).expect("regular")).poles().expect("converges");
    let unstable: Vec<_> = poles.iter().filter(|pole| pole.re > 0.0).collect();
    assert_eq!(unstable.len(), 1, "{poles:?}");
    assert!((unstable[0] - 41.961).norm() < 5e-4, "{poles:?}");
}

/// Returns the master side like the plant builds it: x_h, v_h, x_a, v_a and the force integral, joined by static
/// gains.
fn master_side() -> StateSpace<Continuous> {
    let blocks = append(&[
        &realise_with_derivative(&master()).expect("relative degree 2"),
        &realise_with_derivative(&tf(&[1.0], &[M_H, 0.0, 0.0])).expect("relative degree 2"),
        &realise(&tf(&[K_I], &[1.0, 0.0])).expect("proper"),
        // F_h from (x_a - x_h, v_a - v_h): a block without states.
        &StateSpace::gain(dmatrix![K_A, B_A], Continuous).expect("finite"),
    ])
    .expect("all continuous");
    let [x_h, v_h, x_a, v_a, integral, f_h] = [0, 1, 2, 3, 4, 5].map(Signal::Output);
    let [x_d, v_d, f_ed] = [0, 1, 2].map(Signal::External);
    Interconnection::new(&blocks, 3)
        .feed(0, &[(1.0, f_h), (-1.0, f_ed), (-1.0, integral)])
        .and_then(|w| w.feed(1, &[(K_H, x_d), (-K_H, x_a), (B_H, v_d), (-B_H, v_a), (-1.0, f_h)]))
        .and_then(|w| w.feed(2, &[(1.0, f_ed), (-1.0, f_h)]))
        .and_then(|w| w.feed(3, &[(1.0, x_a), (-1.0, x_h)]))
        .and_then(|w| w.feed(4, &[(1.0, v_a), (-1.0, v_h)]))
        .and_then(|w| w.read(&[(1.0, x_h)])?.read(&[(1.0, v_h)])?.read(&[(1.0, f_h)]))
        .and_then(|w| w.close(&blocks))
        .expect("no algebraic loop")
}

#[test]
fn oracle_the_connected_master_side_has_the_computed_poles() {
    let system = master_side();
    assert_eq!((system.states(), system.inputs(), system.outputs()), (5, 3, 3));
    assert_poles(&system.poles().expect("converges"), &PHYSICAL_MASTER);
    assert!(system.is_stable().expect("converges"));
    assert_eq!(system.c().row(0), dmatrix![1.0, 0.0, 0.0, 0.0, 0.0].row(0));
    assert_eq!(system.a().row(0), dmatrix![0.0, 1.0, 0.0, 0.0, 0.0].row(0));
}

#[test]
fn the_connection_and_the_algebra_agree_on_the_force() {
    // F_h / X_d = loading reach / (1 + loading G_m (1 + K_i/s)); the input is x_d' = s x_d.
    let (loading, reach) = arm();
    let system = master_side();
    for s in [Complex64::new(1.0, 3.0), Complex64::new(-7.0, 40.0), Complex64::new(20.0, -5.0)] {
        let controlled = master().evaluate(s) * (1.0 + K_I / s);
        let wanted = loading.evaluate(s) * reach.evaluate(s) / (1.0 + loading.evaluate(s) * controlled);
        let h = system.evaluate(s).expect("not a pole");
        let found = h[(2, 0)] + s * h[(2, 1)];
        assert!((found / wanted - 1.0).norm() < 1e-10, "{found} for {wanted}");
    }
}
