/// Declares the built-in parts of a role: words, kinds, settings (in parentheses) and paths.
///
/// ```text
/// registry! {
///     /// What holds the slave during an event.
///     #[derive(Debug, Clone, Copy, PartialEq)]
///     pub enum HoldSettings at "augmentation.hold" = Frozen;
///     /// Any of the built-in holds.
///     pub enum AnyHold<L> by (each, of_kind) stored;
///
///     "freeze" => Frozen = freeze::Frozen,
///     "speed-limit" => SpeedLimit(SpeedLimitSettings) = speed_limit::SpeedLimit,
/// }
/// ```
///
/// declares the [`choice!`](crate::choice!) `HoldSettings` and
///
/// ```text
/// pub enum AnyHold<L> { Frozen(freeze::Frozen<L>), SpeedLimit(speed_limit::SpeedLimit<L>) }
/// ```
///
/// with `From`, `Gather` and (`stored`) `Stored`, and two macros, named in `by (…)`:
///
/// ```text
/// each!(self, hold => hold.reference_m(now))
///     match self { AnyHold::Frozen(hold) => hold.reference_m(now), … }
/// of_kind!(kind, Part => Part::<f64>::NAME)
///     match kind { HoldSettings::Frozen { .. } => { use freeze::Frozen as Part; Part::<f64>::NAME } … }
/// of_kind!(settings, Part(kind_settings) => Part::build(kind_settings).into())  // the settings of the kind, or &()
/// of_kind!([WORD, Part] => (WORD, Part::<f64>::NAME))                           // an array over all kinds
/// ```
///
/// Without `at` and words, the kinds are an ordinary enum.
#[macro_export]
macro_rules! registry {
    (
        $(#[doc = $about:literal])*
        #[derive($($derive:ident),*)]
        $kind_vis:vis enum $Kind:ident at $path:literal = $default:ident $(no $without:ident)?;
        $(#[doc = $any_about:literal])*
        $vis:vis enum $Any:ident<$L:ident $(: $Bound:ident)?> by ($each:ident, $of_kind:ident) $($stored:ident)?;
        $(
            $(#[doc = $doc:literal])*
            $word:literal => $Name:ident $(($Settings:ident))? = $($part:ident)::+,
        )*
    ) => {
        $crate::choice! {
            $(#[doc = $about])*
            #[derive($($derive),*)]
            $kind_vis enum $Kind at $path = $default $(no $without)? {
                $($(#[doc = $doc])* $word => $Name $(($Settings))?,)*
            }
        }

        $crate::registry! {
            @parts ($) $Kind
            $(#[doc = $any_about])*
            $vis enum $Any<$L $(: $Bound)?> by ($each, $of_kind) $($stored)?;
            $($word => $Name $(($Settings))? = $($part)::+,)*
        }
    };
    (
        $(#[$about:meta])*
        $kind_vis:vis enum $Kind:ident;
        $(#[doc = $any_about:literal])*
        $vis:vis enum $Any:ident<$L:ident $(: $Bound:ident)?> by ($each:ident, $of_kind:ident) $($stored:ident)?;
        $(
            $(#[doc = $doc:literal])*
            $Name:ident = $($part:ident)::+,
        )*
    ) => {
        $(#[$about])*
        $kind_vis enum $Kind {
            $($(#[doc = $doc])* $Name,)*
        }

        $crate::registry! {
            @parts ($) $Kind
            $(#[doc = $any_about])*
            $vis enum $Any<$L $(: $Bound)?> by ($each, $of_kind) $($stored)?;
            $("" => $Name = $($part)::+,)*
        }
    };
    (
        @parts ($d:tt) $Kind:ident
        $(#[doc = $any_about:literal])*
        $vis:vis enum $Any:ident<$L:ident $(: $Bound:ident)?> by ($each:ident, $of_kind:ident) $($stored:ident)?;
        $($word:literal => $Name:ident $(($Settings:ident))? = $($part:ident)::+,)*
    ) => {
        $(#[doc = $any_about])*
        #[derive(Debug, Clone)]
        #[allow(clippy::large_enum_variant, reason = "a part is stored once per scenario, and the core has no heap")]
        $vis enum $Any<$L $(: $Bound)?> {
            $(#[doc = concat!("`", stringify!($($part)::+), "`.")] $Name($($part)::+<$L>),)*
        }

        $(impl<$L: $crate::lane::Lane> From<$($part)::+<$L>> for $Any<$L> {
            fn from(part: $($part)::+<$L>) -> Self {
                Self::$Name(part)
            }
        })*

        $crate::gather_variants!($Any { $($Name),* } $($stored)?);

        $crate::variants!($each of $Any { $($Name),* });

        #[allow(unused_macros, unused_macro_rules, reason = "no role needs all forms")]
        macro_rules! $of_kind {
            ([$d WORD:ident, $d Part:ident] => $d body:expr) => {
                [$({ use $($part)::+ as $d Part; const $d WORD: &str = $word; $d body }),*]
            };
            ($d kind:expr, $d Part:ident => $d body:expr) => {
                match $d kind {
                    $($Kind::$Name { .. } => { use $($part)::+ as $d Part; $d body })*
                }
            };
            ($d settings:expr, $d Part:ident($d kind_settings:ident) => $d body:expr) => {
                match $d settings {
                    $($Kind::$Name $(($crate::registry!(@first $d kind_settings $Settings)))? => {
                        use $($part)::+ as $d Part;
                        $crate::registry!(@unless_given $d kind_settings $($Settings)?);
                        $d body
                    })*
                }
            };
        }
    };
    (@first $kind_settings:ident $Settings:ident) => { $kind_settings };
    (@unless_given $kind_settings:ident $Settings:ident) => {};
    (@unless_given $kind_settings:ident) => { let $kind_settings = &(); };
}

/// Defines a local macro that runs an expression on the field of an enum's variant.
///
/// ```
/// enum Number {
///     Whole(u8),
///     Real(f64),
/// }
/// trocar_core::variants!(each of Number { Whole, Real });
///
/// assert_eq!(each!(Number::Whole(3), number => f64::from(number)), 3.0);
/// ```
#[macro_export]
macro_rules! variants {
    ($each:ident of $Enum:ident { $($Variant:ident),* $(,)? }) => {
        $crate::variants!(@define ($) $each $Enum $($Variant)*);
    };
    (@define ($d:tt) $each:ident $Enum:ident $($Variant:ident)*) => {
        macro_rules! $each {
            ($d value:expr, $d field:ident => $d body:expr) => {
                match $d value {
                    $($Enum::$Variant($d field) => $d body,)*
                }
            };
        }
    };
}
