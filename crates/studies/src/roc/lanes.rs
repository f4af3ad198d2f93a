//! Lanes of eight thresholds, which a detector evaluates together.

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use trocar_core::lane::{Lane, Mask, by_index};

pub(super) const LANES: usize = 8;

#[derive(Debug, Clone, Copy)]
pub(super) struct ThresholdLanes(pub(super) [f64; LANES]);

/// The bits of a lane are all set or all clear.
#[derive(Debug, Clone, Copy)]
pub(super) struct ThresholdMask([u64; LANES]);

impl ThresholdLanes {
    #[inline(always)]
    fn with(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        Self(by_index!(LANES, 0.0, |i| f(self.0[i], other.0[i])))
    }
    #[inline(always)]
    fn compare(self, other: Self, f: impl Fn(f64, f64) -> bool) -> ThresholdMask {
        ThresholdMask(by_index!(LANES, 0, |i| if f(self.0[i], other.0[i]) { u64::MAX } else { 0 }))
    }
}

macro_rules! arithmetic {
    ($($name:ident $method:ident),*) => {$(
        impl $name for ThresholdLanes {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                self.with(other, $name::$method)
            }
        }
    )*};
}
arithmetic!(Add add, Sub sub, Mul mul, Div div);

impl Neg for ThresholdLanes {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(by_index!(LANES, 0.0, |i| -self.0[i]))
    }
}
impl BitAnd for ThresholdMask {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self(by_index!(LANES, 0, |i| self.0[i] & other.0[i]))
    }
}
impl BitOr for ThresholdMask {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Self(by_index!(LANES, 0, |i| self.0[i] | other.0[i]))
    }
}
impl Not for ThresholdMask {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self(by_index!(LANES, 0, |i| !self.0[i]))
    }
}
impl Mask for ThresholdMask {
    #[inline(always)]
    fn splat(value: bool) -> Self {
        Self([if value { u64::MAX } else { 0 }; LANES])
    }
    #[inline(always)]
    fn any(self) -> bool {
        self.0 != [0; LANES]
    }
    #[inline(always)]
    fn all(self) -> bool {
        self.0 == [u64::MAX; LANES]
    }
    #[inline(always)]
    fn lane(self, index: usize) -> bool {
        self.0[index] != 0
    }
}
impl Lane for ThresholdLanes {
    type Mask = ThresholdMask;
    const WIDTH: usize = LANES;
    #[inline(always)]
    fn splat(value: f64) -> Self {
        Self([value; LANES])
    }
    #[inline(always)]
    fn lane(self, index: usize) -> f64 {
        self.0[index]
    }
    #[inline(always)]
    fn with_lane(mut self, index: usize, value: f64) -> Self {
        self.0[index] = value;
        self
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(by_index!(LANES, 0.0, |i| self.0[i].abs()))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(by_index!(LANES, 0.0, |i| self.0[i].sqrt()))
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.with(other, Lane::min)
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.with(other, Lane::max)
    }
    #[inline(always)]
    fn lt(self, other: Self) -> ThresholdMask {
        self.compare(other, |a, b| a < b)
    }
    #[inline(always)]
    fn le(self, other: Self) -> ThresholdMask {
        self.compare(other, |a, b| a <= b)
    }
    #[inline(always)]
    fn select(mask: ThresholdMask, chosen: Self, otherwise: Self) -> Self {
        Self(by_index!(LANES, 0.0, |i| {
            let (yes, no) = (chosen.0[i].to_bits() & mask.0[i], otherwise.0[i].to_bits() & !mask.0[i]);
            f64::from_bits(yes | no)
        }))
    }
}
