//! Eight lanes compute the same as single numbers.

#![cfg(target_arch = "x86_64")]

use super::super::{Avx2, Avx512, InstructionSet};
use trocar_core::lane::{Lane, Mask};

const A: [f64; 8] = [1.5, -2.0, 0.0, -0.0, 1e300, f64::NAN, f64::INFINITY, 0.1];
const B: [f64; 8] = [-0.5, -2.0, -0.0, 3.0, -1e300, 1.0, 2.0, f64::NAN];

fn lanes<L: Lane>(of: [f64; 8]) -> L {
    L::from_lanes(|lane| of[lane])
}

fn two<L: Lane>(name: &str, wide: impl Fn(L, L) -> L, one: impl Fn(f64, f64) -> f64) {
    let result = wide(lanes(A), lanes(B));
    for lane in 0..8 {
        let (got, expected) = (result.lane(lane), one(A[lane], B[lane]));
        let is_same = got.to_bits() == expected.to_bits() || got.is_nan() && expected.is_nan();
        assert!(is_same, "{name} of {} and {}: {got} instead of {expected}", A[lane], B[lane]);
    }
}

fn truth<L: Lane>(name: &str, wide: impl Fn(L, L) -> L::Mask, one: impl Fn(f64, f64) -> bool) {
    let mask = wide(lanes(A), lanes(B));
    let expected: [bool; 8] = std::array::from_fn(|lane| one(A[lane], B[lane]));
    let got: [bool; 8] = std::array::from_fn(|lane| mask.lane(lane));
    assert_eq!(got, expected, "{name}");
    assert_eq!((mask.any(), mask.all()), (expected.contains(&true), !expected.contains(&false)), "{name}");
    let negated: [bool; 8] = std::array::from_fn(|lane| (!mask).lane(lane));
    assert_eq!(negated, expected.map(|truth| !truth), "{name}");
}

fn compare<L: Lane>() {
    assert_eq!(L::WIDTH, 8);
    two::<L>("sum", |a, b| a + b, |a, b| a + b);
    two::<L>("difference", |a, b| a - b, |a, b| a - b);
    two::<L>("product", |a, b| a * b, |a, b| a * b);
    two::<L>("quotient", |a, b| a / b, |a, b| a / b);
    two::<L>("negation", |a, _| -a, |a, _| -a);
    two::<L>("magnitude", |a, _| a.abs(), |a, _| Lane::abs(a));
    two::<L>("root", |_, b| b.abs().sqrt(), |_, b| Lane::sqrt(Lane::abs(b)));
    two::<L>("minimum", |a, b| a.min(b), Lane::min);
    two::<L>("maximum", |a, b| a.max(b), Lane::max);
    two::<L>("choice", |a, b| L::select(a.lt(b), a, b), |a, b| if a < b { a } else { b });
    two::<L>("limits", |a, b| a.clamp(L::splat(-1.0), b), |a, b| Lane::clamp(a, -1.0, b));
    truth::<L>("less", |a, b| a.lt(b), |a, b| a < b);
    truth::<L>("at most", |a, b| a.le(b), |a, b| a <= b);
    truth::<L>("greater", |a, b| a.gt(b), |a, b| a > b);
    truth::<L>("at least", |a, b| a.ge(b), |a, b| a >= b);
    truth::<L>("both", |a, b| a.lt(b) & a.le(b), |a, b| a < b);
    truth::<L>("one of both", |a, b| a.lt(b) | b.lt(a), |a, b| a < b || b < a);
    truth::<L>("neither", |a, b| a.lt(b) & b.lt(a), |_, _| false);
    truth::<L>("always", |_, _| L::Mask::splat(true), |_, _| true);
    for place in 0..8 {
        let mut changed = lanes::<L>(B).with_lane(place, 7.0);
        let of = |value: L| -> [f64; 8] { std::array::from_fn(|lane| value.lane(lane)) };
        let expected: [f64; 8] = std::array::from_fn(|lane| if lane == place { 7.0 } else { B[lane] });
        assert_eq!(of(changed).map(f64::to_bits), expected.map(f64::to_bits));
        changed.set_lane(place, 9.0);
        assert_eq!(changed.lane(place), 9.0);
    }
    assert_eq!(format!("{:?}", L::splat(1.5)), format!("{:?}", [1.5; 8]));
    assert_eq!(format!("{:?}", L::Mask::splat(true)), format!("{:?}", [true; 8]));
}

#[test]
fn every_operation_of_eight_lanes_equals_the_operation_of_each_number() {
    if InstructionSet::Avx2.is_available() {
        compare::<Avx2>();
    }
    if InstructionSet::Avx512.is_available() {
        compare::<Avx512>();
    }
}

#[test]
fn the_widest_instruction_set_is_the_first_that_is_available() {
    assert!(InstructionSet::Baseline.is_available(), "every machine has it");
    let first = InstructionSet::ALL.into_iter().find(|set| set.is_available());
    assert_eq!(Some(InstructionSet::widest()), first);
    // A machine with the wider instructions also has the narrower ones.
    assert!(!InstructionSet::Avx512.is_available() || InstructionSet::Avx2.is_available());
}
