//! A simple implementation of two lanes, for comparing code of any width with a single lane.

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use trocar::lane::{Lane, Mask};

#[derive(Debug, Clone, Copy)]
pub struct Pair(pub [f64; 2]);

#[derive(Debug, Clone, Copy)]
pub struct PairMask([bool; 2]);

impl Pair {
    fn with(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        Self([f(self.0[0], other.0[0]), f(self.0[1], other.0[1])])
    }
    fn compare(self, other: Self, f: impl Fn(f64, f64) -> bool) -> PairMask {
        PairMask([f(self.0[0], other.0[0]), f(self.0[1], other.0[1])])
    }
}

macro_rules! arithmetic {
    ($($name:ident $method:ident),*) => {$(
        impl $name for Pair {
            type Output = Self;
            fn $method(self, other: Self) -> Self {
                self.with(other, $name::$method)
            }
        }
    )*};
}
arithmetic!(Add add, Sub sub, Mul mul, Div div);

impl Neg for Pair {
    type Output = Self;
    fn neg(self) -> Self {
        Self(self.0.map(|v| -v))
    }
}
impl BitAnd for PairMask {
    type Output = Self;
    fn bitand(self, other: Self) -> Self {
        Self([self.0[0] & other.0[0], self.0[1] & other.0[1]])
    }
}
impl BitOr for PairMask {
    type Output = Self;
    fn bitor(self, other: Self) -> Self {
        Self([self.0[0] | other.0[0], self.0[1] | other.0[1]])
    }
}
impl Not for PairMask {
    type Output = Self;
    fn not(self) -> Self {
        Self(self.0.map(|v| !v))
    }
}
impl Mask for PairMask {
    fn splat(value: bool) -> Self {
        Self([value; 2])
    }
    fn any(self) -> bool {
        self.0[0] | self.0[1]
    }
    fn all(self) -> bool {
        self.0[0] & self.0[1]
    }
    fn lane(self, index: usize) -> bool {
        self.0[index]
    }
}
impl Lane for Pair {
    type Mask = PairMask;
    const WIDTH: usize = 2;
    fn splat(value: f64) -> Self {
        Self([value; 2])
    }
    fn lane(self, index: usize) -> f64 {
        self.0[index]
    }
    fn with_lane(mut self, index: usize, value: f64) -> Self {
        self.0[index] = value;
        self
    }
    fn abs(self) -> Self {
        Self(self.0.map(f64::abs))
    }
    fn sqrt(self) -> Self {
        Self(self.0.map(f64::sqrt))
    }
    fn min(self, other: Self) -> Self {
        self.with(other, Lane::min)
    }
    fn max(self, other: Self) -> Self {
        self.with(other, Lane::max)
    }
    fn lt(self, other: Self) -> PairMask {
        self.compare(other, |a, b| a < b)
    }
    fn le(self, other: Self) -> PairMask {
        self.compare(other, |a, b| a <= b)
    }
    fn select(mask: PairMask, chosen: Self, otherwise: Self) -> Self {
        let pick = |i: usize| if mask.0[i] { chosen.0[i] } else { otherwise.0[i] };
        Self([pick(0), pick(1)])
    }
}
