//! Closed forms, round trips and identities of `trocar::lti`.

use crate::support::closed_forms::{Lag, MassDamper};
use nalgebra::{DMatrix, DVector, dvector};
use proptest::prelude::*;
use trocar::lti::{
    Complex64, Continuous, InputHold, Polynomial, StateSpace, TransferFunction, exact_step, exponential, feedback,
    logarithm, parallel, realise, series, step_response, step_response_discrete, tustin, undo_tustin,
    undo_zero_order_hold, zero_order_hold,
};

const TICK_S: f64 = 1e-3;

#[test]
fn the_response_of_the_master_to_a_held_force_agrees_with_the_closed_form() {
    let held = exact_step(&MassDamper::MASTER.system(), TICK_S, &[InputHold::Held]).expect("finite");
    let force = dvector![2.5];
    let mut x = DVector::zeros(2);
    for k in 1..=2000 {
        x = held.advance(&x, &force, &force).expect("sizes agree");
        let (position, velocity) = MassDamper::MASTER.under_constant_force(2.5, f64::from(k) * TICK_S);
        assert!((x[0] - position).abs() < 1e-12 && (x[1] - velocity).abs() < 1e-12);
    }
}

#[test]
fn the_response_of_the_master_to_a_ramped_force_agrees_with_the_closed_form() {
    let linear = exact_step(&MassDamper::MASTER.system(), 0.02, &[InputHold::Linear]).expect("finite");
    let force = |k: u32| dvector![3.0 * 0.02 * f64::from(k)];
    let mut x = DVector::zeros(2);
    for k in 0..100 {
        x = linear.advance(&x, &force(k), &force(k + 1)).expect("sizes agree");
        let (position, velocity) = MassDamper::MASTER.under_ramped_force(3.0, 0.02 * f64::from(k + 1));
        assert!((x[0] - position).abs() < 1e-12 && (x[1] - velocity).abs() < 1e-12);
    }
}

#[test]
fn the_step_response_of_a_lag_agrees_with_the_closed_form() {
    let lag = Lag { time_constant_s: 0.03 };
    let response = step_response(&lag.system(), 0, 0.01, 50).expect("finite");
    let discrete = zero_order_hold(&lag.system(), 0.01).expect("finite");
    assert_eq!(step_response_discrete(&discrete, 0, 50).expect("one input"), response);
    for (t, y) in response.time_s.iter().zip(response.outputs.row(0).iter()) {
        assert!((y - lag.after_unit_step(*t)).abs() < 1e-14);
    }
}

#[test]
fn the_hold_of_the_master_can_be_inverted() {
    let master = MassDamper::MASTER.system();
    let back = undo_zero_order_hold(&zero_order_hold(&master, TICK_S).expect("finite")).expect("principal");
    assert!((back.a() - master.a()).amax() < 1e-9);
    assert!((back.b() - master.b()).amax() < 1e-9);
}

/// Returns a stable system of three states: A = R - (λ_max of its symmetric part + margin) I, so that every pole has
/// Re < 0.
fn stable_system() -> impl Strategy<Value = StateSpace<Continuous>> {
    (prop::collection::vec(-5.0..5.0f64, 9), prop::collection::vec(-3.0..3.0f64, 14), 0.1..5.0f64).prop_map(
        |(r, rest, margin)| {
            let r = DMatrix::from_row_slice(3, 3, &r);
            let a = &r - DMatrix::identity(3, 3) * (r.symmetric_part().symmetric_eigenvalues().max() + margin);
            StateSpace::continuous(
                a,
                DMatrix::from_row_slice(3, 2, &rest[..6]),
                DMatrix::from_row_slice(2, 3, &rest[6..12]),
                DMatrix::from_row_slice(2, 2, &[rest[12], 0.0, 0.0, rest[13]]),
            )
            .expect("well formed")
        },
    )
}

fn transfer_function() -> impl Strategy<Value = TransferFunction> {
    (prop::collection::vec(-4.0..4.0f64, 1..4), prop::collection::vec(-4.0..4.0f64, 2..4)).prop_map(|(n, mut d)| {
        d.insert(0, 1.0);
        TransferFunction::new(&n, &d).expect("well formed")
    })
}

fn right_half_plane_point() -> impl Strategy<Value = Complex64> {
    (5.0..15.0f64, -10.0..10.0f64).prop_map(|(re, im)| Complex64::new(re, im))
}

fn close(a: &DMatrix<f64>, b: &DMatrix<f64>, tolerance: f64) -> bool {
    (a - b).amax() <= tolerance * (1.0 + b.amax())
}

fn near(a: Complex64, b: Complex64) -> bool {
    (a - b).norm() <= 1e-8 * (1.0 + b.norm())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn a_zero_order_hold_can_be_inverted(system in stable_system(), tick_s in 1e-3..0.1f64) {
        let back = undo_zero_order_hold(&zero_order_hold(&system, tick_s).expect("finite")).expect("principal");
        prop_assert!(close(back.a(), system.a(), 1e-8), "{}{}", back.a(), system.a());
        prop_assert!(close(back.b(), system.b(), 1e-8));
    }

    #[test]
    fn a_hold_keeps_the_steady_state(system in stable_system(), tick_s in 1e-2..0.1f64) {
        let discrete = zero_order_hold(&system, tick_s).expect("finite");
        let (held, steady) = (discrete.dc_gain().expect("stable"), system.dc_gain().expect("stable"));
        prop_assert!(close(&held, &steady, 1e-7));
    }

    #[test]
    fn the_tustin_transform_can_be_inverted(system in stable_system(), tick_s in 1e-3..0.1f64, warped in any::<bool>()) {
        let prewarp = warped.then_some(10.0);
        let there = tustin(&system, tick_s, prewarp).expect("regular");
        prop_assert!(there.is_stable().expect("converges"));
        let back = undo_tustin(&there, prewarp).expect("regular");
        for (found, wanted) in [(back.a(), system.a()), (back.b(), system.b()), (back.c(), system.c()), (back.d(), system.d())] {
            prop_assert!(close(found, wanted, 1e-9));
        }
    }

    #[test]
    fn a_step_with_equal_samples_is_a_held_step(system in stable_system(), tick_s in 1e-3..0.5f64) {
        let held = exact_step(&system, tick_s, &[InputHold::Held; 2]).expect("finite");
        let linear = exact_step(&system, tick_s, &[InputHold::Linear, InputHold::Held]).expect("finite");
        prop_assert!(close(&(&linear.gamma_now + &linear.gamma_next), &held.gamma_now, 1e-13));
        prop_assert_eq!(linear.gamma_next.column(1).amax(), 0.0);
    }

    #[test]
    fn two_half_ticks_equal_one_tick(system in stable_system(), tick_s in 1e-3..0.5f64) {
        let whole = exponential(&(system.a() * tick_s)).expect("finite");
        let half = exponential(&(system.a() * (tick_s / 2.0))).expect("finite");
        prop_assert!(close(&(&half * &half), &whole, 1e-13));
        prop_assert!(close(&exponential(&logarithm(&half).expect("principal")).expect("finite"), &half, 1e-12));
    }

    #[test]
    fn a_change_of_states_keeps_the_response(system in stable_system(), s in right_half_plane_point()) {
        let t = DMatrix::from_row_slice(3, 3, &[2.0, 1.0, 0.0, 0.0, 1.0, -1.0, 1.0, 0.0, 3.0]);
        let (before, after) = (system.evaluate(s).expect("regular"), system.transform(&t).expect("regular").evaluate(s).expect("regular"));
        prop_assert!(before.iter().zip(after.iter()).all(|(a, b)| near(*a, *b)));
    }

    #[test]
    fn the_product_of_the_roots_gives_the_polynomial(roots in prop::collection::vec(-10.0..10.0f64, 0..4), pairs in prop::collection::vec((-5.0..5.0f64, 0.1..9.0f64), 0..3), leading in 0.1..10.0f64) {
        let mut all: Vec<Complex64> = roots.iter().map(|re| Complex64::new(*re, 0.0)).collect();
        all.extend(pairs.iter().flat_map(|(re, im)| [Complex64::new(*re, *im), Complex64::new(*re, -im)]));
        let polynomial = Polynomial::from_roots(leading, &all).expect("finite");
        let found = polynomial.roots().expect("converges");
        prop_assert_eq!(found.len(), all.len());
        let again = Polynomial::from_roots(leading, &found).expect("finite");
        let scale: f64 = polynomial.coefficients().iter().fold(0.0, |m, c| m.max(c.abs()));
        for (a, b) in again.coefficients().iter().zip(polynomial.coefficients()) {
            prop_assert!((a - b).abs() <= 1e-9 * scale, "{:?} for {:?}", again, polynomial);
        }
    }

    #[test]
    fn joined_systems_agree_with_joined_transfer_functions(g in transfer_function(), h in transfer_function(), s in right_half_plane_point()) {
        let (a, b) = (realise(&g).expect("proper"), realise(&h).expect("proper"));
        let value = |system: &StateSpace<Continuous>| system.evaluate(s).expect("not a pole")[(0, 0)];
        prop_assert!(near(value(&series(&a, &b).expect("one by one")), (&g * &h).evaluate(s)));
        prop_assert!(near(value(&parallel(&a, &b).expect("one by one")), (&g + &h).evaluate(s)));
        // A loop gain of exactly -1 at infinite frequency is an error on both sides; its probability is 0 here.
        if let Ok(closed) = feedback(&a, &b) {
            let wanted = g.feedback(&h).expect("regular").evaluate(s);
            prop_assume!(wanted.norm() < 1e3);
            prop_assert!(near(value(&closed), wanted));
        }
    }
}
