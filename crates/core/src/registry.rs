//! The registry of a role: its built-in parts, their words in scenarios, and static dispatch over them.

/// Declares the built-in parts of a role, one row each: the word in scenarios, the kind, its settings in parentheses if it
/// alone has them, and the path of the part.
///
/// ```
/// # use trocar_core::lane::Lane;
/// mod spring {
///     trocar_core::settings! {
///         /// A spring.
///         #[derive(Debug, Clone, Copy, PartialEq)]
///         pub struct SpringSettings in "toy." {
///             /// Its stiffness.
///             stiffness_n_per_m: f64 [POSITIVE] = 100.0,
///         }
///     }
///     #[derive(Debug, Clone)]
///     pub struct Spring<L>(pub L);
///     trocar_core::lane::gather!(Spring { 0 } stored);
/// }
/// mod nothing {
///     #[derive(Debug, Clone)]
///     pub struct Nothing<L>(pub core::marker::PhantomData<L>);
///     trocar_core::lane::gather_nothing!(Nothing);
/// }
/// use spring::SpringSettings;
///
/// /// What all parts of the role do.
/// trait Toy<L: Lane> {
///     fn force_n(&self, position_m: L) -> L;
/// }
/// impl<L: Lane> Toy<L> for spring::Spring<L> {
///     fn force_n(&self, position_m: L) -> L {
///         self.0 * position_m
///     }
/// }
/// impl<L: Lane> Toy<L> for nothing::Nothing<L> {
///     fn force_n(&self, _position_m: L) -> L {
///         L::zero()
///     }
/// }
///
/// /// What the registry needs besides.
/// trait BuiltIn {
///     type Settings;
///     const NAME: &'static str;
///     fn build(settings: &Self::Settings) -> Self;
/// }
/// impl<L: Lane> BuiltIn for spring::Spring<L> {
///     type Settings = SpringSettings;
///     const NAME: &'static str = "a spring";
///     fn build(settings: &SpringSettings) -> Self {
///         Self(L::splat(settings.stiffness_n_per_m))
///     }
/// }
/// impl<L> BuiltIn for nothing::Nothing<L> {
///     type Settings = ();
///     const NAME: &'static str = "nothing";
///     fn build(_settings: &()) -> Self {
///         Self(core::marker::PhantomData)
///     }
/// }
///
/// trocar_core::registry! {
///     /// The toy.
///     #[derive(Debug, Clone, Copy, PartialEq)]
///     pub enum ToySettings at "toy.kind" = Spring;
///     /// Any of the built-in toys.
///     pub enum AnyToy<L> by (each, of_kind) stored;
///
///     "spring" => Spring(SpringSettings) = spring::Spring,
///     "none" => Nothing = nothing::Nothing,
/// }
///
/// impl<L: Lane> Toy<L> for AnyToy<L> {
///     fn force_n(&self, position_m: L) -> L {
///         each!(self, toy => toy.force_n(position_m))
///     }
/// }
/// impl<L: Lane> AnyToy<L> {
///     fn new(settings: &ToySettings) -> Self {
///         of_kind!(settings, Part(own) => Part::build(own).into())
///     }
/// }
/// let toy = AnyToy::<f64>::new(&ToySettings::DEFAULT);
/// assert_eq!(toy.force_n(0.02), 2.0);
/// assert_eq!(of_kind!(ToySettings::Nothing, Part => Part::<f64>::NAME), "nothing");
/// assert_eq!(of_kind!([WORD, Part] => (WORD, Part::<f64>::NAME)), [("spring", "a spring"), ("none", "nothing")]);
/// ```
///
/// expands to the [`choice!`](crate::choice!) of the words, `enum ToySettings { Spring(SpringSettings), Nothing }`, and to
///
/// ```text
/// pub enum AnyToy<L> {
///     Spring(spring::Spring<L>),
///     Nothing(nothing::Nothing<L>),
/// }
/// impl<L: Lane> From<spring::Spring<L>> for AnyToy<L> { … }      // one for each part
/// gather_variants!(AnyToy { Spring, Nothing } stored);
/// macro_rules! each { … }
/// macro_rules! of_kind { … }
/// ```
///
/// The two local macros are a `match` with an arm for each part. The calls above expand to
///
/// ```text
/// match self {                                                    // each!(self, toy => toy.force_n(position_m))
///     AnyToy::Spring(toy) => toy.force_n(position_m),
///     AnyToy::Nothing(toy) => toy.force_n(position_m),
/// }
/// match settings {                                                // of_kind!(settings, Part(own) => …)
///     ToySettings::Spring(own) => { use spring::Spring as Part; Part::build(own).into() }
///     ToySettings::Nothing => { use nothing::Nothing as Part; let own = &(); Part::build(own).into() }
/// }
/// match ToySettings::Nothing {                                    // of_kind!(…, Part => Part::<f64>::NAME)
///     ToySettings::Spring { .. } => { use spring::Spring as Part; Part::<f64>::NAME }
///     ToySettings::Nothing { .. } => { use nothing::Nothing as Part; Part::<f64>::NAME }
/// }
/// [                                                               // of_kind!([WORD, Part] => …)
///     { use spring::Spring as Part; const WORD: &str = "spring"; (WORD, Part::<f64>::NAME) },
///     { use nothing::Nothing as Part; const WORD: &str = "none"; (WORD, Part::<f64>::NAME) },
/// ]
/// ```
///
/// Without words and `at`, the kinds are an ordinary enum. `stored` also implements [`Stored`](crate::lane::Stored).
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
    // `$d` stands for the `$` of the two local macros.
    (
        @parts ($d:tt) $Kind:ident
        $(#[doc = $any_about:literal])*
        $vis:vis enum $Any:ident<$L:ident $(: $Bound:ident)?> by ($each:ident, $of_kind:ident) $($stored:ident)?;
        $($word:literal => $Name:ident $(($Settings:ident))? = $($part:ident)::+,)*
    ) => {
        $(#[doc = $any_about])*
        #[derive(Debug, Clone)]
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
            ($d settings:expr, $d Part:ident($d own:ident) => $d body:expr) => {
                match $d settings {
                    $($Kind::$Name $(($crate::registry!(@first $d own $Settings)))? => {
                        use $($part)::+ as $d Part;
                        $crate::registry!(@unless_given $d own $($Settings)?);
                        $d body
                    })*
                }
            };
        }
    };
    (@first $own:ident $Settings:ident) => { $own };
    (@unless_given $own:ident $Settings:ident) => {};
    (@unless_given $own:ident) => { let $own = &(); };
}

/// Defines a local macro, named by the caller, that runs an expression on the field of an enum's variant.
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
///
/// The call expands to
///
/// ```text
/// match Number::Whole(3) {
///     Number::Whole(number) => f64::from(number),
///     Number::Real(number) => f64::from(number),
/// }
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
