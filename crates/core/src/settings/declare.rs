/// Declares the settings of a part.
///
/// ```
/// trocar_core::settings! {
///     /// When an event begins and ends.
///     #[derive(Debug, Clone, Copy, PartialEq)]
///     pub struct Freeze in "augmentation." {
///         /// Shortest freeze.
///         ///
///         /// In s. Only readers of the code see text after the first paragraph.
///         min_hold_s: f64 [NON_NEGATIVE] = 0.5,
///         /// Longest freeze.
///         max_hold_s: f64 [NON_NEGATIVE] = 1.0,
///     }
///     where max_hold_s: |s| s.max_hold_s >= s.min_hold_s, "at least augmentation.min_hold_s";
/// }
/// assert_eq!(Freeze::KEYS[1].path, "augmentation.max_hold_s");
/// assert_eq!(Freeze::KEYS[1].meaning, "Longest freeze.");
/// assert!(Freeze { min_hold_s: 2.0, ..Freeze::DEFAULT }.validate().is_err());
/// ```
///
/// generates the struct, `DEFAULT`, `Default`, `KEYS`, `validate` and `read`. A key is the prefix and the field's name,
/// or the literal after `at`.
///
/// | declaration | holds |
/// |---|---|
/// | `name: f64 [RANGE] = 0.5` | a number; `RANGE`: of [`Range`](crate::settings::Range), or an expression |
/// | `name: f64 [SIGN] = 1.0`, `name: Option<f64> [RANGE]` | 1 or -1, a number or none |
/// | `name: f64 [RANGE] => "ten thresholds" 10.0 * threshold` | derived from the fields before it by the stated rule |
/// | `name: u64 [1..] = 1`, also `usize`; `name: bool = true`; `name: Vec<f64> = [0.0, 1.0]` | a whole number and its minimum, a switch, a list |
/// | `name: String = "time_s"`, `name: Option<String>`, `name: Option<String> [FILE]` | a text, a path |
/// | `name: Option<f64> [RANGE] => "ten intervals"`, `name: String => "the file's name"` | derived by the reader |
/// | `name: Other`, `name: Other [kinds last]` | settings or a choice, whose kinds' keys may follow all fields |
///
/// - `for Motion::Any | Inserting`, `for (...)`: the kinds, or an [`ActsFor`](crate::settings::ActsFor), for which a key
///   acts.
/// - `given (threshold: f64)` after the prefix: inputs of the defaults, for `read` and `name: Other (threshold)`; with
///   `= 2.0` also `default_for`.
/// - `no DEFAULT`: a field has no default. `no const`: only `Default`.
/// - `where field: |s| ..., "at least ...";` and `then Self::check;` check fields.
#[macro_export]
macro_rules! settings {
    (
        $(#[doc = $about:literal])*
        #[derive($($derive:ident),*)]
        $vis:vis struct $name:ident in $prefix:literal
            $(given ($($given:ident : $given_ty:ty $(= $stand_in:expr)?),+))? $(no $without:ident)?
        {
            $(
                $(#[doc = $doc:literal])*
                $field:ident : $ty:ident $(<$arg:ident>)? $(at $key:literal)? $([$($range:tt)+])? $(($($with:expr),+))?
                $(for $choice:ident :: $kind:ident $(| $other_kind:ident)*)? $(for ($acts_for:expr))?
                $(= $default:expr)? $(=> $rule:literal $($derived:expr)?)?
            ),* $(,)?
        }
        $(where $related:ident : $holds:expr, $requirement:literal;)*
        $(then $then:path;)?
    ) => {
        $(#[doc = $about])*
        #[derive($($derive),*)]
        $vis struct $name {
            $(
                $(#[doc = $doc])*
                pub $field: $ty $(<$arg>)?,
            )*
        }

        impl $name {
            /// The keys, in order.
            pub const KEYS: &'static [$crate::settings::Key] = {
                const GROUPS: &[&[$crate::settings::Key]] = &[
                    $($crate::settings!(@acting
                        {$($choice $kind $($other_kind)*)?} {$($acts_for)?} $crate::settings!(@keys
                        ($crate::settings!(@path $prefix $field $($key)?)) ($($doc)*)
                        {$ty $(<$arg>)?} {$($($range)+)?} {$(= $default)? $(=> $rule)?}
                    )),)*
                    $($crate::settings!(@kinds {$ty} {$($($range)+)?}),)*
                ];
                &$crate::settings::joined::<{ $crate::settings::count(GROUPS) }>(GROUPS)
            };

            /// Checks the ranges of the fields and the conditions between them.
            pub fn validate(&self) -> Result<(), $crate::error::InvalidValue> {
                $($crate::settings!(@check
                    ($crate::settings!(@path $prefix $field $($key)?)) (&self.$field)
                    {$ty $(<$arg>)?} {$($($range)+)?}
                );)*
                #[allow(non_camel_case_types, dead_code, reason = "the fields by their own names")]
                enum Field { $($field),* }
                let _key = |field| match field {
                    $(Field::$field => $crate::settings!(@path $prefix $field $($key)?),)*
                };
                $({
                    let holds: fn(&Self) -> bool = $holds;
                    #[allow(clippy::unnecessary_cast, reason = "not each setting is an f64")]
                    let value = self.$related as f64;
                    $crate::error::require(_key(Field::$related), value, holds(self), $requirement)?;
                })*
                $($then(self)?;)?
                Ok(())
            }

            /// Reads the settings.
            pub fn read<S: $crate::settings::KeySource>(
                source: &mut S $($(, $given: $given_ty)+)?
            ) -> Result<Self, S::Error> {
                $(let $field = $crate::settings!(@read
                    source ($crate::settings!(@path $prefix $field $($key)?))
                    {$ty $(<$arg>)?} {$($($range)+)?} {$(($($with),+))?} {$($(=> $derived)?)?}
                );)*
                Ok(Self { $($field),* })
            }
        }

        $crate::settings!(@default $name {$(given $({$given $given_ty $(= $stand_in)?})+)? $(no $without)?} {
            $($field {$ty $(<$arg>)?} {$(= $default)? $($(=> $derived)?)?})*
        });
    };

    (@path $prefix:literal $field:ident) => { concat!($prefix, stringify!($field)) };
    (@path $prefix:literal $field:ident $key:literal) => { $key };

    (@meaning $($doc:literal)*) => {{
        const LINES: &[&str] = &[$($doc),*];
        const SENTENCE: &$crate::settings::Sentence<{ $crate::settings::sentence_len(LINES) }> =
            &$crate::settings::sentence(LINES);
        SENTENCE.as_str()
    }};

    (@range $range:ident) => { $crate::settings::Range::$range };
    (@range $($range:tt)+) => { $($range)+ };

    (@acting {} {} $keys:expr) => { $keys };
    (@acting {$choice:ident $($kind:ident)+} {} $keys:expr) => {
        $crate::settings!(@acting {} {
            $crate::settings::ActsFor::new($choice::KEY.path, &[$($choice::$kind.word()),+])
        } $keys)
    };
    (@acting {} {$acts_for:expr} $keys:expr) => {{
        const GROUPS: &[&[$crate::settings::Key]] = &[$keys];
        const COUNT: usize = $crate::settings::count(GROUPS);
        &$crate::settings::acting::<COUNT>(GROUPS, $acts_for)
    }};

    (@keys ($path:expr) ($($doc:literal)*) {f64} {SIGN} {= $default:expr}) => {
        &[$crate::settings::Key::sign($path, $default, $crate::settings!(@meaning $($doc)*))]
    };
    (@keys ($path:expr) ($($doc:literal)*) {f64} {$($range:tt)+} {= $default:expr}) => {
        &[$crate::settings::Key::number(
            $path, $crate::settings!(@range $($range)+), $default, $crate::settings!(@meaning $($doc)*)
        )]
    };
    (@keys ($path:expr) ($($doc:literal)*) {f64} {SIGN} {=> $rule:literal}) => {
        $crate::settings!(@keys ($path) ($($doc)*) (Sign) (Derived($rule)))
    };
    (@keys ($path:expr) ($($doc:literal)*) {f64} {$($range:tt)+} {=> $rule:literal}) => {
        &[$crate::settings::Key::derived(
            $path, $crate::settings!(@range $($range)+), $rule, $crate::settings!(@meaning $($doc)*)
        )]
    };
    (@keys ($path:expr) ($($doc:literal)*) {Option<f64>} {$($range:tt)+} {=> $rule:literal}) => {
        $crate::settings!(@keys ($path) ($($doc)*) {f64} {$($range)+} {=> $rule})
    };
    (@keys ($path:expr) ($($doc:literal)*) {String} {} {= $default:expr}) => {
        $crate::settings!(@keys ($path) ($($doc)*) (Text) (Value($crate::settings::Constant::Text($default))))
    };
    (@keys ($path:expr) ($($doc:literal)*) {String} {} {=> $rule:literal}) => {
        $crate::settings!(@keys ($path) ($($doc)*) (Text) (Derived($rule)))
    };
    (@keys ($path:expr) ($($doc:literal)*) {Option<String>} {} {}) => {
        $crate::settings!(@keys ($path) ($($doc)*) (Text) (Unset))
    };
    (@keys ($path:expr) ($($doc:literal)*) {Option<String>} {FILE} {}) => {
        $crate::settings!(@keys ($path) ($($doc)*) (File) (Unset))
    };
    (@keys ($path:expr) ($($doc:literal)*) ($kind:ident) ($($fallback:tt)+)) => {
        &[$crate::settings::Key::new(
            $path,
            $crate::settings::Kind::$kind,
            $crate::settings::Fallback::$($fallback)+,
            $crate::settings!(@meaning $($doc)*),
        )]
    };
    (@keys ($path:expr) ($($doc:literal)*) {Option<f64>} {$($range:tt)+} {}) => {
        &[$crate::settings::Key::optional(
            $path, $crate::settings!(@range $($range)+), $crate::settings!(@meaning $($doc)*)
        )]
    };
    (@keys ($path:expr) ($($doc:literal)*) {u64} {$min:literal ..} {= $default:expr}) => {
        &[$crate::settings::Key::whole($path, $min, $default, $crate::settings!(@meaning $($doc)*))]
    };
    (@keys ($path:expr) ($($doc:literal)*) {usize} {$min:literal ..} {= $default:expr}) => {
        &[$crate::settings::Key::whole($path, $min, $default as u64, $crate::settings!(@meaning $($doc)*))]
    };
    (@keys ($path:expr) ($($doc:literal)*) {bool} {} {= $default:expr}) => {
        &[$crate::settings::Key::flag($path, $default, $crate::settings!(@meaning $($doc)*))]
    };
    (@keys ($path:expr) ($($doc:literal)*) {Vec<f64>} {} {= $default:expr}) => {
        &[$crate::settings::Key::numbers($path, &$default, $crate::settings!(@meaning $($doc)*))]
    };
    (@keys ($path:expr) ($($doc:literal)*) {$other:ident} {kinds last} {}) => { &[$other::KEY] };
    (@keys ($path:expr) ($($doc:literal)*) {$other:ident} {} {}) => { $other::KEYS };
    (@kinds {$other:ident} {kinds last}) => { $other::KIND_KEYS };
    (@kinds {$other:ident} {$($range:tt)*}) => { &[] };

    (@check ($path:expr) ($value:expr) {f64} {SIGN}) => {
        $crate::error::require($path, *$value, *$value == 1.0 || *$value == -1.0, "1 or -1")?;
    };
    (@check ($path:expr) ($value:expr) {f64} {$($range:tt)+}) => {
        $crate::settings!(@range $($range)+).check($path, *$value)?;
    };
    (@check ($path:expr) ($value:expr) {Option<f64>} {$($range:tt)+}) => {
        if let Some(value) = $value {
            $crate::settings!(@range $($range)+).check($path, *value)?;
        }
    };
    (@check ($path:expr) ($value:expr) {u64} {$min:literal ..}) => {
        let requirement = concat!("a whole number of at least ", $min);
        $crate::error::require($path, *$value as f64, ($min..).contains($value), requirement)?;
    };
    (@check ($path:expr) ($value:expr) {usize} {$min:literal ..}) => {
        let requirement = concat!("a whole number of at least ", $min);
        $crate::error::require($path, *$value as f64, ($min..).contains($value), requirement)?;
    };
    (@check ($path:expr) ($value:expr) {bool} {}) => {};
    (@check ($path:expr) ($value:expr) {String} {}) => {};
    (@check ($path:expr) ($value:expr) {Option<String>} {$($file:ident)?}) => {};
    (@check ($path:expr) ($value:expr) {Vec<f64>} {}) => {
        for value in $value {
            $crate::settings::Range::ANY.check($path, *value)?;
        }
    };
    (@check ($path:expr) ($value:expr) {$other:ident} {$($last:ident)*}) => { $other::validate($value)?; };

    (@read $source:ident ($path:expr) {f64} {$($range:tt)+} {} {}) => { $source.number($path)? };
    (@read $source:ident ($path:expr) {f64} {$($range:tt)+} {} {=> $derived:expr}) => {
        $source.number_or($path, || $derived)
    };
    (@read $source:ident ($path:expr) {Option<f64>} {$($range:tt)+} {} {}) => { $source.optional_number($path) };
    (@read $source:ident ($path:expr) {u64} {$($range:tt)+} {} {}) => { $source.whole($path)? };
    (@read $source:ident ($path:expr) {usize} {$($range:tt)+} {} {}) => { $source.whole($path)? as usize };
    (@read $source:ident ($path:expr) {bool} {} {} {}) => { $source.flag($path)? };
    (@read $source:ident ($path:expr) {String} {} {} {}) => { $source.word($path)?.to_owned() };
    (@read $source:ident ($path:expr) {Option<String>} {$($file:ident)?} {} {}) => {
        $source.optional_word($path).map(str::to_owned)
    };
    (@read $source:ident ($path:expr) {Vec<f64>} {} {} {}) => { $source.numbers($path)?.to_vec() };
    (@read $source:ident ($path:expr) {$other:ident} {$($last:ident)*} {$(($($with:expr),+))?} {}) => {
        $other::read($source $($(, $with)+)?)?
    };

    (@default $name:ident {} {$($field:ident {$($ty:tt)+} {$($default:tt)*})*}) => {
        impl $name {
            /// The default settings.
            pub const DEFAULT: Self = {
                $(let $field = $crate::settings!(@value {$($ty)+} {$($default)*});)*
                Self { $($field),* }
            };
        }

        impl Default for $name {
            fn default() -> Self {
                Self::DEFAULT
            }
        }
    };
    (@default $name:ident {given $({$given:ident $given_ty:ty = $stand_in:expr})+}
        {$($field:ident {$($ty:tt)+} {$($default:tt)*})*}
    ) => {
        impl $name {
            /// The default settings.
            pub const DEFAULT: Self = Self::default_for($($stand_in),+);

            /// The defaults for other inputs.
            #[must_use]
            pub const fn default_for($($given: $given_ty),+) -> Self {
                $(let $field = $crate::settings!(@value {$($ty)+} {$($default)*});)*
                Self { $($field),* }
            }
        }

        impl Default for $name {
            fn default() -> Self {
                Self::DEFAULT
            }
        }
    };
    (@default $name:ident {no const} {$($field:ident {$($ty:tt)+} {$($default:tt)*})*}) => {
        impl Default for $name {
            fn default() -> Self {
                $(let $field = $crate::settings!(@made {$($ty)+} {$($default)*});)*
                Self { $($field),* }
            }
        }
    };
    (@default $name:ident {$($none:tt)+} {$($fields:tt)*}) => {};
    (@value {$($ty:tt)+} {= $default:expr}) => { $default };
    (@value {$($ty:tt)+} {=> $derived:expr}) => { $derived };
    (@value {Option<$arg:ident>} {}) => { None };
    (@value {$other:ident} {}) => { $other::DEFAULT };
    (@made {Vec<f64>} {= $default:expr}) => { Vec::from($default) };
    (@made {String} {= $default:expr}) => { String::from($default) };
    (@made {$other:ident} {}) => { $other::default() };
    (@made {$($ty:tt)+} {$($default:tt)*}) => { $crate::settings!(@value {$($ty)+} {$($default)*}) };
}

/// Declares the kinds of a choice.
///
/// ```
/// trocar_core::choice! {
///     /// Let the feedback force decay, or scale its variation.
///     #[derive(Debug, Clone, Copy, PartialEq)]
///     pub enum Law at "augmentation.force_law" = Decay {
///         /// Towards a fraction of the force at the alarm.
///         "decay" => Decay in "augmentation.decay_" {
///             /// Final fraction.
///             ratio: f64 [SHARE] = 0.0,
///         },
///         /// Unchanged.
///         "none" => None,
///     }
/// }
/// assert_eq!(Law::KEYS[1].path, "augmentation.decay_ratio");
/// assert_eq!(Law::KEYS[1].acts_for.expect("one kind").words(), ["decay"]);
/// assert_eq!(Law::DEFAULT.word(), "decay");
/// ```
///
/// generates the enum, `DEFAULT`, `Default`, `WORDS`, `ALL` if all kinds are empty, `word`, `validate`, `read`, `KEY`,
/// `KIND_KEYS` and `KEYS`. A kind is empty, or has fields as in [`settings!`](crate::settings!) or other settings in
/// parentheses.
#[macro_export]
macro_rules! choice {
    (
        $(#[doc = $about:literal])*
        #[derive($($derive:ident),*)]
        $vis:vis enum $name:ident at $path:literal = $default:ident $(no $without:ident)? {
            $(
                $(#[doc = $variant_doc:literal])*
                $word:literal => $variant:ident $(($payload:ident))? $(in $prefix:literal {
                    $(
                        $(#[doc = $doc:literal])*
                        $field:ident : $ty:ident $(<$arg:ident>)? $(at $key:literal)? $([$($range:tt)+])? = $value:expr
                    ),* $(,)?
                })?
            ),* $(,)?
        }
    ) => {
        $(#[doc = $about])*
        #[derive($($derive),*)]
        $vis enum $name {
            $(
                $(#[doc = $variant_doc])*
                #[doc = concat!("`", $word, "` in scenarios.")]
                $variant $(($payload))? $({
                    $(
                        $(#[doc = $doc])*
                        $field: $ty $(<$arg>)?,
                    )*
                })?,
            )*
        }

        $crate::choice!(@all $name $({$variant $(($payload))? $({$prefix})?})*);

        impl $name {
            /// The words, in order.
            pub const WORDS: &'static [&'static str] = &[$($word),*];

            /// The key of the choice.
            pub const KEY: $crate::settings::Key = $crate::settings::Key::choice(
                $path,
                Self::WORDS,
                {
                    $(
                        #[allow(non_upper_case_globals, dead_code, reason = "the kinds by their own names")]
                        const $variant: &str = $word;
                    )*
                    $default
                },
                $crate::settings!(@meaning $($about)*),
            );

            /// The keys of the kinds; each acts only for kinds that have it.
            pub const KIND_KEYS: &'static [$crate::settings::Key] = {
                const GROUPS: &[&[$crate::settings::Key]] = &[$({
                    const GROUPS: &[&[$crate::settings::Key]] = &[
                        $($payload::KEYS,)?
                        $($($crate::settings!(@keys
                            ($crate::settings!(@path $prefix $field $($key)?)) ($($doc)*)
                            {$ty $(<$arg>)?} {$($($range)+)?} {= $value}
                        ),)*)?
                    ];
                    const COUNT: usize = $crate::settings::count(GROUPS);
                    const ACTS_FOR: $crate::settings::ActsFor =
                        $crate::settings::ActsFor::new($path, &[$word]);
                    &$crate::settings::acting::<COUNT>(GROUPS, ACTS_FOR)
                }),*];
                &$crate::settings::distinct::<{ $crate::settings::count_distinct(GROUPS) }>(GROUPS)
            };

            /// The key of the choice and the keys of its kinds.
            pub const KEYS: &'static [$crate::settings::Key] = {
                const GROUPS: &[&[$crate::settings::Key]] = &[&[$name::KEY], $name::KIND_KEYS];
                &$crate::settings::joined::<{ $crate::settings::count(GROUPS) }>(GROUPS)
            };

            /// The word of the kind.
            #[must_use]
            pub const fn word(&self) -> &'static str {
                match self {
                    $(Self::$variant { .. } => $word,)*
                }
            }

            /// Checks the ranges of the fields.
            pub fn validate(&self) -> Result<(), $crate::error::InvalidValue> {
                $($(
                    if let Self::$variant(settings) = self {
                        $payload::validate(settings)?;
                    }
                )?)*
                $($(
                    if let Self::$variant { $($field),* } = self {
                        $($crate::settings!(@check
                            ($crate::settings!(@path $prefix $field $($key)?)) ($field) {$ty $(<$arg>)?} {$($($range)+)?}
                        );)*
                    }
                )?)*
                Ok(())
            }

            /// Reads the choice.
            pub fn read<S: $crate::settings::KeySource>(source: &mut S) -> Result<Self, S::Error> {
                let given = source.word($path)?;
                let given = Self::WORDS.iter().position(|word| *word == given);
                let mut _index = 0;
                $(
                    if given == Some(_index) {
                        return Ok(Self::$variant {
                            $(0: $payload::read(source)?)?
                            $($($field: $crate::settings!(@read
                                source ($crate::settings!(@path $prefix $field $($key)?))
                                {$ty $(<$arg>)?} {$($($range)+)?} {} {}
                            )),*)?
                        });
                    }
                    _index += 1;
                )*
                Err(source.unknown_word($path))
            }
        }

        $crate::choice!(@default $name $default {$(no $without)?} {
            $({$variant $(($payload))? {$($($field: $value),*)?}})*
        });
    };

    (@default $name:ident $default:ident {} {$({$variant:ident $(($payload:ident))? {$($fields:tt)*}})*}) => {
        impl $name {
            /// The default kind.
            pub const DEFAULT: Self = {
                $(
                    #[allow(non_upper_case_globals, dead_code, reason = "the kinds by their own names")]
                    const $variant: $name = $name::$variant { $(0: $payload::DEFAULT)? $($fields)* };
                )*
                $default
            };
        }

        impl Default for $name {
            fn default() -> Self {
                Self::DEFAULT
            }
        }
    };
    (@default $name:ident $default:ident {no const} {$({$variant:ident ($payload:ident) {}})*}) => {
        impl Default for $name {
            fn default() -> Self {
                $(
                    #[allow(non_snake_case, dead_code, reason = "the kinds by their own names")]
                    fn $variant() -> $name {
                        $name::$variant($payload::default())
                    }
                )*
                $default()
            }
        }
    };

    (@all $name:ident $({$variant:ident})*) => {
        impl $name {
            /// Every kind.
            pub const ALL: [Self; Self::WORDS.len()] = [$(Self::$variant),*];
        }
    };
    (@all $name:ident $($kind:tt)*) => {};
}
