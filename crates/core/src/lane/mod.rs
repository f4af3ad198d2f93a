//! The number type of a tick: one scenario (`f64`) or several in parallel lanes.
//!
//! The same bits on every machine: no fused multiply-add, no reassociation, no transcendental function.

mod gather;
mod gathered;
mod stored;

#[cfg(feature = "alloc")]
#[doc(hidden)]
pub use gather::same_list;
#[doc(hidden)]
pub use gather::{Gather, LANES, gather_mask};

pub use stored::Stored;
pub(crate) use stored::store_code;

#[doc(hidden)]
pub use crate::{by_index, gather, gather_nothing, gather_variants, of_each, of_one_variant};

use core::fmt::Debug;
use core::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

/// A truth value per lane.
pub trait Mask: Copy + Debug + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self> + Send + Sync {
    /// Equal in every lane.
    fn splat(value: bool) -> Self;
    /// True in at least one lane.
    fn any(self) -> bool;
    /// True in every lane.
    fn all(self) -> bool;
    /// The value of a lane.
    fn lane(self, index: usize) -> bool;
}

/// A number per lane.
pub trait Lane:
    Copy
    + Debug
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// The truth values.
    type Mask: Mask;
    /// Number of lanes.
    const WIDTH: usize;

    /// Equal in every lane.
    fn splat(value: f64) -> Self;
    /// The number of a lane, below [`Lane::WIDTH`].
    fn lane(self, index: usize) -> f64;
    /// Replaces the number of a lane.
    fn with_lane(self, index: usize, value: f64) -> Self;
    /// Sets the number of a lane.
    #[inline(always)]
    fn set_lane(&mut self, index: usize, value: f64) {
        *self = self.with_lane(index, value);
    }
    /// Computes each lane from its index.
    #[inline(always)]
    fn from_lanes(mut lane: impl FnMut(usize) -> f64) -> Self {
        (0..Self::WIDTH).fold(Self::splat(0.0), |all, index| all.with_lane(index, lane(index)))
    }
    /// The absolute value.
    fn abs(self) -> Self;
    /// NaN for a negative number.
    fn sqrt(self) -> Self;
    /// `other` where `self` is NaN.
    fn min(self, other: Self) -> Self;
    /// `other` where `self` is NaN.
    fn max(self, other: Self) -> Self;
    /// False for NaN.
    fn lt(self, other: Self) -> Self::Mask;
    /// False for NaN.
    fn le(self, other: Self) -> Self::Mask;
    /// `chosen` where the mask is true, else `otherwise`.
    fn select(mask: Self::Mask, chosen: Self, otherwise: Self) -> Self;

    /// 0 in every lane.
    #[inline(always)]
    fn zero() -> Self {
        Self::splat(0.0)
    }

    /// False for NaN.
    #[inline(always)]
    fn gt(self, other: Self) -> Self::Mask {
        other.lt(self)
    }

    /// False for NaN.
    #[inline(always)]
    fn ge(self, other: Self) -> Self::Mask {
        other.le(self)
    }

    /// Limits to `[low, high]`.
    #[inline(always)]
    fn clamp(self, low: Self, high: Self) -> Self {
        self.max(low).min(high)
    }

    /// To a multiple of `step`, halves to even; unchanged from 2⁵¹ steps on. Adding and subtracting 1.5·2⁵² gives the
    /// same result at every width.
    #[inline(always)]
    fn round_to(self, step: Self, inverse_step: Self) -> Self {
        let shift = Self::splat(6_755_399_441_055_744.0);
        let steps = self * inverse_step;
        let rounded = (steps + shift) - shift;
        Self::select(steps.abs().lt(Self::splat(2_251_799_813_685_248.0)), rounded * step, self)
    }
}

impl Mask for bool {
    #[inline(always)]
    fn splat(value: bool) -> Self {
        value
    }
    #[inline(always)]
    fn any(self) -> bool {
        self
    }
    #[inline(always)]
    fn all(self) -> bool {
        self
    }
    #[inline(always)]
    fn lane(self, _index: usize) -> bool {
        self
    }
}

impl Lane for f64 {
    type Mask = bool;
    const WIDTH: usize = 1;

    #[inline(always)]
    fn splat(value: f64) -> Self {
        value
    }
    #[inline(always)]
    fn lane(self, _index: usize) -> f64 {
        self
    }
    #[inline(always)]
    fn with_lane(self, _index: usize, value: f64) -> Self {
        value
    }
    #[inline(always)]
    fn abs(self) -> Self {
        self.abs()
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        // Correctly rounded, like the instruction.
        libm::sqrt(self)
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        if self < other { self } else { other }
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        if self > other { self } else { other }
    }
    #[inline(always)]
    fn lt(self, other: Self) -> bool {
        self < other
    }
    #[inline(always)]
    fn le(self, other: Self) -> bool {
        self <= other
    }
    #[inline(always)]
    fn select(mask: bool, chosen: Self, otherwise: Self) -> Self {
        if mask { chosen } else { otherwise }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_agrees_with_the_standard_library() {
        for (value, step) in [(0.123_456, 1e-3), (-2.5, 1.0), (3.5, 1.0), (1e-9, 1e-6), (-0.0149, 0.01), (7.0e15, 0.5)]
        {
            let expected = if value / step > 2e15 { value } else { f64::round_ties_even(value * (1.0 / step)) * step };
            assert_eq!(Lane::round_to(value, step, 1.0 / step), expected, "{value} in steps of {step}");
        }
    }

    #[test]
    fn a_comparison_with_nan_is_false() {
        assert!(!Lane::lt(f64::NAN, 1.0) && !Lane::le(1.0, f64::NAN) && !Lane::gt(f64::NAN, 1.0));
        assert_eq!(Lane::max(f64::NAN, 1.0), 1.0);
    }
}
