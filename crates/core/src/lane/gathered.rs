/// Compiles to a tenth of the code of `map`.
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
/// `Gather` for a struct from its numbers, `masks`, equal fields (`same`), and enums of which only the variant counts
/// (`kinds`); with `stored` also `Stored`.
#[doc(hidden)]
#[macro_export]
macro_rules! gather {
    ($Type:ident $([$N:ident])? { $($field:ident),* $(,)? }
        $(masks { $($mask:ident),* })? $(same { $($same:ident),* })? $(kinds { $($kind:ident),* })? stored) => {
        $crate::gather!($Type $([$N])? { $($field),* } $(masks { $($mask),* })? $(same { $($same),* })? $(kinds { $($kind),* })?);

        impl $(<const $N: usize>)? $crate::lane::Stored for $Type<f64 $(, $N)?> {
            fn numbers(&mut self, with: &mut dyn FnMut(&mut u64)) {
                $($crate::lane::Stored::numbers(&mut self.$field, with);)*
                $($($crate::lane::Stored::numbers(&mut self.$mask, with);)*)?
                $($($crate::lane::Stored::numbers(&mut self.$same, with);)*)?
            }
        }
    };
    ($Type:ident $([$N:ident])? { $($field:ident),* $(,)? }
        $(masks { $($mask:ident),* })? $(same { $($same:ident),* })? $(kinds { $($kind:ident),* })?) => {
        impl $(<const $N: usize>)? $crate::lane::Gather for $Type<f64 $(, $N)?> {
            type Of<L: $crate::lane::Lane> = $Type<L $(, $N)?>;

            fn gather<L: $crate::lane::Lane>(all: [&Self; $crate::lane::LANES]) -> Option<Self::Of<L>> {
                let equal = true
                    $($(&& all.iter().all(|one| one.$same == all[0].$same))*)?
                    $($(&& all.iter().all(|one| {
                        core::mem::discriminant(&one.$kind) == core::mem::discriminant(&all[0].$kind)
                    }))*)?;
                if !equal {
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

/// Returns `None` from the enclosing function if the variants differ.
#[doc(hidden)]
#[macro_export]
macro_rules! of_one_variant {
    ($all:expr, $Type:ident { $($Variant:ident),* $(,)? }, |$fields:ident| $gathered:expr) => {
        match $all[0] {
            $($Type::$Variant(_) => {
                let $fields = $crate::of_each!($all, |one| {
                    let $Type::$Variant(field) = one else { return None };
                    field
                });
                $gathered.map($Type::$Variant)
            })*
        }
    };
}

/// `Gather`, and with `stored` also `Stored`, for an enum of one-field variants.
#[doc(hidden)]
#[macro_export]
macro_rules! gather_variants {
    ($Type:ident $([$N:ident])? { $($Variant:ident),* $(,)? } stored) => {
        $crate::gather_variants!($Type $([$N])? { $($Variant),* });

        impl $(<const $N: usize>)? $crate::lane::Stored for $Type<f64 $(, $N)?> {
            fn numbers(&mut self, with: &mut dyn FnMut(&mut u64)) {
                match self {
                    $(Self::$Variant(part) => $crate::lane::Stored::numbers(part, with),)*
                }
            }
        }
    };
    ($Type:ident $([$N:ident])? { $($Variant:ident),* $(,)? }) => {
        impl $(<const $N: usize>)? $crate::lane::Gather for $Type<f64 $(, $N)?> {
            type Of<L: $crate::lane::Lane> = $Type<L $(, $N)?>;

            fn gather<L: $crate::lane::Lane>(all: [&Self; $crate::lane::LANES]) -> Option<Self::Of<L>> {
                $crate::of_one_variant!(all, $Type { $($Variant),* }, |fields| $crate::lane::Gather::gather::<L>(fields))
            }
        }
    };
}

#[doc(hidden)]
#[macro_export]
macro_rules! gather_nothing {
    ($Type:ident) => {
        impl $crate::lane::Gather for $Type<f64> {
            type Of<L: $crate::lane::Lane> = $Type<L>;

            fn gather<L: $crate::lane::Lane>(_all: [&Self; $crate::lane::LANES]) -> Option<Self::Of<L>> {
                Some($Type(core::marker::PhantomData))
            }
        }

        impl $crate::lane::Stored for $Type<f64> {
            fn numbers(&mut self, _with: &mut dyn FnMut(&mut u64)) {}
        }
    };
}

/// A loop: the closure of `array::from_fn` would be compiled without the run's instruction set.
#[doc(hidden)]
#[macro_export]
macro_rules! by_index {
    ($N:expr, |$i:ident| $value:expr) => {
        $crate::by_index!($N, L::zero(), |$i| $value)
    };
    ($N:expr, $zero:expr, |$i:ident| $value:expr) => {{
        let mut all = [$zero; $N];
        #[allow(clippy::needless_range_loop, reason = "the value may need the index for something else")]
        for $i in 0..$N {
            all[$i] = $value;
        }
        all
    }};
}
