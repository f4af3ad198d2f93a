//! A lane type that counts its operations.

use std::cell::Cell;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use trocar::lane::{Lane, Mask};

/// Numbers of operations. An operation on all lanes counts once.
#[derive(Debug, Clone, Copy, Default)]
pub struct Counts {
    /// Additions and subtractions.
    pub add: u64,
    pub mul: u64,
    pub div: u64,
    /// Minima and maxima.
    pub extreme: u64,
    /// Absolute values and changes of sign.
    pub sign: u64,
    pub select: u64,
    pub mask: u64,
}

thread_local! {
    static COUNTS: Cell<Counts> = Cell::default();
}

impl Counts {
    /// Returns the counts of this thread since the last call, and resets them.
    pub fn take() -> Self {
        COUNTS.take()
    }
}

fn count(one: impl FnOnce(&mut Counts)) {
    let mut counts = COUNTS.get();
    one(&mut counts);
    COUNTS.set(counts);
}

#[derive(Debug, Clone, Copy)]
pub struct Counted<const N: usize>([f64; N]);

#[derive(Debug, Clone, Copy)]
pub struct Truth<const N: usize>([bool; N]);

impl<const N: usize> Counted<N> {
    fn with(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        Self(std::array::from_fn(|i| f(self.0[i], other.0[i])))
    }

    fn compare(self, other: Self, f: impl Fn(&f64, &f64) -> bool) -> Truth<N> {
        count(|counts| counts.select += 1);
        Truth(std::array::from_fn(|i| f(&self.0[i], &other.0[i])))
    }
}

macro_rules! operator {
    ($($Trait:ident, $method:ident, $counter:ident;)*) => {$(
        impl<const N: usize> $Trait for Counted<N> {
            type Output = Self;
            fn $method(self, other: Self) -> Self {
                count(|counts| counts.$counter += 1);
                self.with(other, |a, b| a.$method(b))
            }
        }
    )*};
}

operator! {
    Add, add, add;
    Sub, sub, add;
    Mul, mul, mul;
    Div, div, div;
}

impl<const N: usize> Neg for Counted<N> {
    type Output = Self;
    fn neg(self) -> Self {
        count(|counts| counts.sign += 1);
        Self(self.0.map(f64::neg))
    }
}

impl<const N: usize> Lane for Counted<N> {
    type Mask = Truth<N>;
    const WIDTH: usize = N;

    fn splat(value: f64) -> Self {
        Self([value; N])
    }
    fn lane(self, index: usize) -> f64 {
        self.0[index]
    }
    fn with_lane(mut self, index: usize, value: f64) -> Self {
        self.0[index] = value;
        self
    }
    fn abs(self) -> Self {
        count(|counts| counts.sign += 1);
        Self(self.0.map(f64::abs))
    }
    fn sqrt(self) -> Self {
        count(|counts| counts.div += 1);
        Self(self.0.map(f64::sqrt))
    }
    fn min(self, other: Self) -> Self {
        count(|counts| counts.extreme += 1);
        self.with(other, <f64 as Lane>::min)
    }
    fn max(self, other: Self) -> Self {
        count(|counts| counts.extreme += 1);
        self.with(other, <f64 as Lane>::max)
    }
    fn lt(self, other: Self) -> Truth<N> {
        self.compare(other, PartialOrd::lt)
    }
    fn le(self, other: Self) -> Truth<N> {
        self.compare(other, PartialOrd::le)
    }
    fn select(mask: Truth<N>, chosen: Self, otherwise: Self) -> Self {
        count(|counts| counts.select += 1);
        Self(std::array::from_fn(|i| if mask.0[i] { chosen.0[i] } else { otherwise.0[i] }))
    }
}

impl<const N: usize> Truth<N> {
    fn with(self, other: Self, f: impl Fn(bool, bool) -> bool) -> Self {
        count(|counts| counts.mask += 1);
        Self(std::array::from_fn(|i| f(self.0[i], other.0[i])))
    }
}

impl<const N: usize> BitAnd for Truth<N> {
    type Output = Self;
    fn bitand(self, other: Self) -> Self {
        self.with(other, |a, b| a & b)
    }
}

impl<const N: usize> BitOr for Truth<N> {
    type Output = Self;
    fn bitor(self, other: Self) -> Self {
        self.with(other, |a, b| a | b)
    }
}

impl<const N: usize> Not for Truth<N> {
    type Output = Self;
    fn not(self) -> Self {
        self.with(self, |a, _| !a)
    }
}

impl<const N: usize> Mask for Truth<N> {
    fn splat(value: bool) -> Self {
        Self([value; N])
    }
    fn any(self) -> bool {
        count(|counts| counts.mask += 1);
        self.0.contains(&true)
    }
    fn all(self) -> bool {
        count(|counts| counts.mask += 1);
        !self.0.contains(&false)
    }
    fn lane(self, index: usize) -> bool {
        self.0[index]
    }
}
