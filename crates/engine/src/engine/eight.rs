use core::fmt::{self, Debug, Formatter};
use core::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use trocar_core::lane::{LANES, Lane, Mask};

macro_rules! intrinsic {
    ($arch:ident::$name:ident($($argument:expr),*)) => {
        // SAFETY: `trocar-studies` creates these numbers only for packs of runs, after a check that the machine has
        // the instructions. The intrinsics have no other condition.
        unsafe { $arch::$name($($argument),*) }
    };
}

macro_rules! eight {
    ($(#[$doc:meta])* $Number:ident, $Truth:ident, $arch:ident, $count:literal: $($part:literal)*) => {
        $(#[$doc])*
        #[derive(Clone, Copy)]
        #[repr(C, align(64))]
        pub struct $Number([$arch::Vector; $count]);

        #[derive(Clone, Copy)]
        pub struct $Truth([$arch::Truth; $count]);

        #[allow(unsafe_code, unused_unsafe, reason = "intrinsics; such a number is built only after a check for the instructions")]
        const _: () = {
            impl $Number {
                #[inline(always)]
                fn array(self) -> [f64; LANES] {
                    // SAFETY: the parts consist of exactly eight doubles.
                    unsafe { core::mem::transmute(self.0) }
                }
                #[inline(always)]
                fn from_array(lanes: [f64; LANES]) -> Self {
                    // SAFETY: the parts consist of exactly eight doubles, and any bits are a valid double.
                    Self(unsafe { core::mem::transmute::<[f64; LANES], [$arch::Vector; $count]>(lanes) })
                }
            }
            impl Add for $Number {
                type Output = Self;
                #[inline(always)]
                fn add(self, other: Self) -> Self {
                    Self([$(intrinsic!($arch::add(self.0[$part], other.0[$part]))),*])
                }
            }
            impl Sub for $Number {
                type Output = Self;
                #[inline(always)]
                fn sub(self, other: Self) -> Self {
                    Self([$(intrinsic!($arch::sub(self.0[$part], other.0[$part]))),*])
                }
            }
            impl Mul for $Number {
                type Output = Self;
                #[inline(always)]
                fn mul(self, other: Self) -> Self {
                    Self([$(intrinsic!($arch::mul(self.0[$part], other.0[$part]))),*])
                }
            }
            impl Div for $Number {
                type Output = Self;
                #[inline(always)]
                fn div(self, other: Self) -> Self {
                    Self([$(intrinsic!($arch::div(self.0[$part], other.0[$part]))),*])
                }
            }
            impl Neg for $Number {
                type Output = Self;
                #[inline(always)]
                fn neg(self) -> Self {
                    Self([$(intrinsic!($arch::neg(self.0[$part]))),*])
                }
            }
            impl BitAnd for $Truth {
                type Output = Self;
                #[inline(always)]
                fn bitand(self, other: Self) -> Self {
                    Self([$(intrinsic!($arch::and(self.0[$part], other.0[$part]))),*])
                }
            }
            impl BitOr for $Truth {
                type Output = Self;
                #[inline(always)]
                fn bitor(self, other: Self) -> Self {
                    Self([$(intrinsic!($arch::or(self.0[$part], other.0[$part]))),*])
                }
            }
            impl Not for $Truth {
                type Output = Self;
                #[inline(always)]
                fn not(self) -> Self {
                    Self([$(intrinsic!($arch::not(self.0[$part]))),*])
                }
            }
            impl Mask for $Truth {
                #[inline(always)]
                fn splat(value: bool) -> Self {
                    Self([intrinsic!($arch::truth(value)); $count])
                }
                #[inline(always)]
                fn any(self) -> bool {
                    let mut bits = 0;
                    $(bits |= intrinsic!($arch::bits(self.0[$part]));)*
                    bits != 0
                }
                #[inline(always)]
                fn all(self) -> bool {
                    !(!self).any()
                }
                #[inline(always)]
                fn lane(self, index: usize) -> bool {
                    let each = LANES / $count;
                    intrinsic!($arch::bits(self.0[index / each])) >> (index % each) & 1 == 1
                }
            }
            impl Lane for $Number {
                type Mask = $Truth;
                const WIDTH: usize = LANES;

                #[inline(always)]
                fn splat(value: f64) -> Self {
                    Self([intrinsic!($arch::splat(value)); $count])
                }
                #[inline(always)]
                fn lane(self, index: usize) -> f64 {
                    self.array()[index]
                }
                #[inline(always)]
                fn with_lane(self, index: usize, value: f64) -> Self {
                    let mut lanes = self.array();
                    lanes[index] = value;
                    Self::from_array(lanes)
                }
                #[inline(always)]
                fn set_lane(&mut self, index: usize, value: f64) {
                    // SAFETY: the parts consist of exactly eight doubles.
                    let lanes: &mut [f64; LANES] = unsafe { &mut *core::ptr::from_mut(&mut self.0).cast() };
                    lanes[index] = value;
                }
                #[inline(always)]
                fn from_lanes(mut lane: impl FnMut(usize) -> f64) -> Self {
                    let mut lanes = [0.0; LANES];
                    for (index, value) in lanes.iter_mut().enumerate() {
                        *value = lane(index);
                    }
                    Self::from_array(lanes)
                }
                #[inline(always)]
                fn abs(self) -> Self {
                    Self([$(intrinsic!($arch::abs(self.0[$part]))),*])
                }
                #[inline(always)]
                fn sqrt(self) -> Self {
                    Self([$(intrinsic!($arch::sqrt(self.0[$part]))),*])
                }
                #[inline(always)]
                fn min(self, other: Self) -> Self {
                    Self([$(intrinsic!($arch::min(self.0[$part], other.0[$part]))),*])
                }
                #[inline(always)]
                fn max(self, other: Self) -> Self {
                    Self([$(intrinsic!($arch::max(self.0[$part], other.0[$part]))),*])
                }
                #[inline(always)]
                fn lt(self, other: Self) -> $Truth {
                    $Truth([$(intrinsic!($arch::lt(self.0[$part], other.0[$part]))),*])
                }
                #[inline(always)]
                fn le(self, other: Self) -> $Truth {
                    $Truth([$(intrinsic!($arch::le(self.0[$part], other.0[$part]))),*])
                }
                #[inline(always)]
                fn select(mask: $Truth, chosen: Self, otherwise: Self) -> Self {
                    Self([$(intrinsic!($arch::select(mask.0[$part], chosen.0[$part], otherwise.0[$part]))),*])
                }
            }
        };

        impl Debug for $Number {
            fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
                self.array().fmt(f)
            }
        }
        impl Debug for $Truth {
            fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
                let lanes: [bool; LANES] = core::array::from_fn(|index| self.lane(index));
                lanes.fmt(f)
            }
        }
    };
}

eight! {
    Avx2, Avx2Truth, avx2, 2: 0 1
}

eight! {
    Avx512, Avx512Truth, avx512, 1: 0
}

macro_rules! intrinsics {
    ($module:ident: $Vector:ty, $Truth:ty;
     $($name:ident($($argument:ident: $type:ty),*) -> $result:ty: $body:expr;)*) => {
        #[allow(unsafe_code, unused_unsafe, reason = "intrinsics, which require an instruction set")]
        mod $module {
            use core::arch::x86_64::*;

            pub(super) type Vector = $Vector;
            pub(super) type Truth = $Truth;

            $(
                #[inline(always)]
                pub(super) unsafe fn $name($($argument: $type),*) -> $result {
                    // SAFETY: the caller ensures the instruction set.
                    unsafe { $body }
                }
            )*
        }
    };
}

intrinsics! {
    avx2: __m256d, __m256d;
    add(a: Vector, b: Vector) -> Vector: _mm256_add_pd(a, b);
    sub(a: Vector, b: Vector) -> Vector: _mm256_sub_pd(a, b);
    mul(a: Vector, b: Vector) -> Vector: _mm256_mul_pd(a, b);
    div(a: Vector, b: Vector) -> Vector: _mm256_div_pd(a, b);
    neg(a: Vector) -> Vector: _mm256_xor_pd(a, _mm256_set1_pd(-0.0));
    abs(a: Vector) -> Vector: _mm256_andnot_pd(_mm256_set1_pd(-0.0), a);
    sqrt(a: Vector) -> Vector: _mm256_sqrt_pd(a);
    min(a: Vector, b: Vector) -> Vector: _mm256_min_pd(a, b);
    max(a: Vector, b: Vector) -> Vector: _mm256_max_pd(a, b);
    lt(a: Vector, b: Vector) -> Truth: _mm256_cmp_pd::<_CMP_LT_OQ>(a, b);
    le(a: Vector, b: Vector) -> Truth: _mm256_cmp_pd::<_CMP_LE_OQ>(a, b);
    splat(a: f64) -> Vector: _mm256_set1_pd(a);
    select(mask: Truth, a: Vector, b: Vector) -> Vector: _mm256_blendv_pd(b, a, mask);
    and(a: Truth, b: Truth) -> Truth: _mm256_and_pd(a, b);
    or(a: Truth, b: Truth) -> Truth: _mm256_or_pd(a, b);
    not(a: Truth) -> Truth: _mm256_xor_pd(a, truth(true));
    truth(a: bool) -> Truth: _mm256_castsi256_pd(_mm256_set1_epi64x(-i64::from(a)));
    bits(a: Truth) -> u32: _mm256_movemask_pd(a) as u32;
}

intrinsics! {
    avx512: __m512d, __mmask8;
    add(a: Vector, b: Vector) -> Vector: _mm512_add_pd(a, b);
    sub(a: Vector, b: Vector) -> Vector: _mm512_sub_pd(a, b);
    mul(a: Vector, b: Vector) -> Vector: _mm512_mul_pd(a, b);
    div(a: Vector, b: Vector) -> Vector: _mm512_div_pd(a, b);
    neg(a: Vector) -> Vector: _mm512_xor_pd(a, _mm512_set1_pd(-0.0));
    abs(a: Vector) -> Vector: _mm512_andnot_pd(_mm512_set1_pd(-0.0), a);
    sqrt(a: Vector) -> Vector: _mm512_sqrt_pd(a);
    min(a: Vector, b: Vector) -> Vector: _mm512_min_pd(a, b);
    max(a: Vector, b: Vector) -> Vector: _mm512_max_pd(a, b);
    lt(a: Vector, b: Vector) -> Truth: _mm512_cmp_pd_mask::<_CMP_LT_OQ>(a, b);
    le(a: Vector, b: Vector) -> Truth: _mm512_cmp_pd_mask::<_CMP_LE_OQ>(a, b);
    splat(a: f64) -> Vector: _mm512_set1_pd(a);
    select(mask: Truth, a: Vector, b: Vector) -> Vector: _mm512_mask_blend_pd(mask, b, a);
    and(a: Truth, b: Truth) -> Truth: a & b;
    or(a: Truth, b: Truth) -> Truth: a | b;
    not(a: Truth) -> Truth: !a;
    truth(a: bool) -> Truth: if a { u8::MAX } else { 0 };
    bits(a: Truth) -> u32: u32::from(a);
}
