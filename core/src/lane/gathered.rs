//! What saves writing [`Gather`](super::Gather) out for every struct of a tick and loops.

/// A part of each of eight things: what `map` gives, in a tenth of the code, of which there is much.
#[doc(hidden)]
#[macro_export]
macro_rules! of_each {
    ($all:expr, |$one:pat_param| $part:expr) => {{
        let all: [_; $crate::lane::LANES] = $all;
        let [a, b, c, d, e, f, g, h] = all;
        $crate::of_each!(@parts $one, $part; a b c d e f g h)
    }};
    (@parts $one:pat_param, $part:expr; $($of:ident)*) => {
        [$({ let $one = $of; $part }),*]
    };
}
/// `Gather` for a struct: its numbers, its masks (`bool` over `f64`), what has to be the same, and enums of which the kind
/// alone matters in the tick.
#[doc(hidden)]
#[macro_export]
macro_rules! gather {
    ($Type:ident $([$N:ident])? { $($field:ident),* $(,)? }
        $(masks { $($mask:ident),* })? $(same { $($same:ident),* })? $(kinds { $($kind:ident),* })?) => {
        impl $(<const $N: usize>)? $crate::lane::Gather for $Type<f64 $(, $N)?> {
            type Of<L: $crate::lane::Lane> = $Type<L $(, $N)?>;

            fn gather<L: $crate::lane::Lane>(all: [&Self; $crate::lane::LANES]) -> Option<Self::Of<L>> {
                let alike = true
                    $($(&& all.iter().all(|one| one.$same == all[0].$same))*)?
                    $($(&& all.iter().all(|one| {
                        core::mem::discriminant(&one.$kind) == core::mem::discriminant(&all[0].$kind)
                    }))*)?;
                if !alike {
                    return None;
                }
                Some($Type {
                    $($field: $crate::lane::Gather::gather::<L>($crate::of_each!(all, |one| &one.$field))?,)*
                    $($($mask: $crate::lane::gather_mask::<L>($crate::of_each!(all, |one| one.$mask)),)*)?
                    $($($same: all[0].$same.clone(),)*)?
                    $($($kind: all[0].$kind.clone(),)*)?
                })
            }
        }
    };
}

/// `Gather` for an enum of which all have to be the same variant, each with one thing in it, or nothing.
#[doc(hidden)]
#[macro_export]
macro_rules! gather_variants {
    ($Type:ident $([$N:ident])? { $($Variant:ident),* $(,)? } $(empty { $($Empty:ident),* })?) => {
        impl $(<const $N: usize>)? $crate::lane::Gather for $Type<f64 $(, $N)?> {
            type Of<L: $crate::lane::Lane> = $Type<L $(, $N)?>;

            fn gather<L: $crate::lane::Lane>(all: [&Self; $crate::lane::LANES]) -> Option<Self::Of<L>> {
                match all[0] {
                    $(Self::$Variant(_) => {
                        let inner = $crate::of_each!(all, |one| {
                            let Self::$Variant(inner) = one else { return None };
                            inner
                        });
                        $crate::lane::Gather::gather::<L>(inner).map($Type::$Variant)
                    })*
                    $($(Self::$Empty => {
                        all.iter().all(|one| matches!(one, Self::$Empty)).then(|| $Type::$Empty)
                    })*)?
                }
            }
        }
    };
}

/// An array of lanes by its index, in the tick's own loop: `array::from_fn` is a function, and its closure another, that are
/// compiled without the instruction set of the run which they are part of.
#[doc(hidden)]
#[macro_export]
macro_rules! by_index {
    ($N:expr, |$i:ident| $value:expr) => {{
        let mut all = [L::zero(); $N];
        #[allow(clippy::needless_range_loop, reason = "the value may need the index for something else")]
        for $i in 0..$N {
            all[$i] = $value;
        }
        all
    }};
}
