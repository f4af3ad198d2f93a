//! The declaration of metrics.
//!
//! A `metrics!` table declares each metric once, beside the numbers of its scope; structs, JSON, comparison tables,
//! sweep columns and documentation are generated from it.

use serde::Serialize;

use super::Unit;

/// The values of a metric that are better, other things being equal.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Better {
    /// Smaller values.
    Lower,
    /// Larger values.
    Higher,
    /// Neither: the metric is descriptive.
    Neither,
}

impl Better {
    pub fn word(self) -> &'static str {
        match self {
            Self::Lower => "lower",
            Self::Higher => "higher",
            Self::Neither => "neither",
        }
    }
}

/// Tables of runs and comparisons in which a metric appears. Sweeps store every listed metric.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shown {
    /// Also in a comparison's short table.
    Main,
    /// In every table, if any run defines it.
    MainWhereDefined,
    /// Except in the short table.
    Always,
    /// Except in the short table, if any run defines it.
    WhereDefined,
    /// Above all other metrics, if any run defines it.
    First,
    /// If it is not 0 in a run.
    WhereNonZero,
    Never,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Scope {
    Run,
    Rupture,
    Event,
    Link,
    /// The ports between hand, link and needle.
    Port,
    /// The control loop of one case of a sweep.
    Loop,
    /// The run's detection with added noise.
    Noise,
}

impl Scope {
    pub fn word(self) -> &'static str {
        match self {
            Self::Run => "run",
            Self::Rupture => "rupture",
            Self::Event => "event",
            Self::Link => "link",
            Self::Port => "port",
            Self::Loop => "loop",
            Self::Noise => "noise",
        }
    }

    pub(crate) fn key_prefix(self, number: usize) -> String {
        match self {
            Self::Run => String::new(),
            Self::Rupture | Self::Event => format!("{}_{number}_", self.word()),
            Self::Link => "link_".into(),
            Self::Port => "port_".into(),
            Self::Loop => "stability_".into(),
            Self::Noise => "in_noise_".into(),
        }
    }

    pub(crate) fn label_prefix(self, number: usize) -> String {
        match self {
            Self::Run => String::new(),
            Self::Rupture | Self::Event => format!("{} {number}: ", self.word()),
            Self::Link => "link: ".into(),
            Self::Port => "port: ".into(),
            Self::Loop => "stability: ".into(),
            Self::Noise => "in noise: ".into(),
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Declaration {
    pub scope: Scope,
    /// Without its scope's prefix, with the unit: `detection_delay_s`.
    pub name: &'static str,
    pub label: &'static str,
    pub unit: Unit,
    /// The sign varies, so a relative change has no meaning.
    pub is_signed: bool,
    pub better: Better,
    pub shown: Shown,
    pub meaning: &'static str,
}

impl Shown {
    pub fn is_main(self) -> bool {
        matches!(self, Self::Main | Self::MainWhereDefined)
    }
}

impl Declaration {
    pub fn key(&self, number: usize) -> String {
        self.scope.key_prefix(number) + self.name
    }

    pub fn full_label(&self, number: usize) -> String {
        self.scope.label_prefix(number) + self.label
    }
}

#[derive(Debug, Clone, Copy)]
pub struct Metric<Read> {
    pub declaration: Declaration,
    /// In SI units; `None` if undefined.
    pub read: Read,
}

pub trait MetricValue {
    fn value(&self) -> Option<f64>;
}

impl MetricValue for f64 {
    fn value(&self) -> Option<f64> {
        Some(*self)
    }
}

impl MetricValue for u64 {
    fn value(&self) -> Option<f64> {
        Some(*self as f64)
    }
}

impl<T: MetricValue> MetricValue for Option<T> {
    fn value(&self) -> Option<f64> {
        self.as_ref().and_then(MetricValue::value)
    }
}

/// Declares the metrics of a scope and, with `pub struct`, the fields from which they are read.
///
/// An entry is a one-line doc comment and `name: Type = "label", Unit signed, Better [Shown] => |of| read;`. Without
/// `: Type` it declares no field and needs `=> read`; without `= "label"` the field is no metric. `signed`, `[Shown]`
/// and `=> read` are optional. A struct with a JSON Schema transforms it by `schema::with_units`.
#[doc(hidden)]
#[macro_export]
macro_rules! metrics {
    (
        $(#[$attribute:meta])*
        pub struct $owner:ident in $scope:ident {
            $(
                #[doc = $meaning:literal]
                $name:ident $(: $type:ty)? $(= $label:literal, $unit:ident $($signed:ident)?, $better:ident $([$shown:ident])?
                $(=> $read:expr)?)? ;
            )*
        }
    ) => {
        $(#[$attribute])*
        pub struct $owner {
            $($(#[doc = $meaning] pub $name: $type,)?)*
        }

        $crate::metrics! {
            impl $scope for $owner {
                $($(#[doc = $meaning] $name = $label, $unit $($signed)?, $better $([$shown])? $(=> $read)?;)?)*
            }
        }
    };
    (
        impl $scope:ident for $owner:ty {
            $(
                #[doc = $meaning:literal]
                $name:ident = $label:literal, $unit:ident $($signed:ident)?, $better:ident $([$shown:ident])? $(=> $read:expr)?;
            )*
        }
    ) => {
        impl $owner {
            pub const METRICS: &'static [$crate::Metric<fn(&$owner) -> Option<f64>>] = &[$(
                $crate::Metric {
                    declaration: $crate::Declaration {
                        scope: $crate::Scope::$scope,
                        name: stringify!($name),
                        label: $label,
                        unit: $crate::Unit::$unit,
                        is_signed: $crate::metrics!(@signed $($signed)?),
                        better: $crate::Better::$better,
                        shown: $crate::metrics!(@shown $($shown)?),
                        meaning: $meaning.trim_ascii(),
                    },
                    read: $crate::metrics!(@read $name $($read)?),
                },
            )*];
        }
    };
    (@signed) => { false };
    (@signed signed) => { true };
    (@shown) => { $crate::Shown::Always };
    (@shown $shown:ident) => { $crate::Shown::$shown };
    (@read $name:ident) => { |of| $crate::catalogue::MetricValue::value(&of.$name) };
    (@read $name:ident $read:expr) => { $read };
}

#[cfg(test)]
mod tests {
    use super::*;

    const DECLARATION: Declaration = Declaration {
        scope: Scope::Rupture,
        name: "detection_delay_s",
        label: "detection delay",
        unit: Unit::Second,
        is_signed: false,
        better: Better::Lower,
        shown: Shown::Main,
        meaning: "",
    };

    #[test]
    fn the_key_and_the_label_have_the_prefix_of_their_scope() {
        let of = |scope| {
            let declaration = Declaration { scope, ..DECLARATION };
            (declaration.key(2), declaration.full_label(2))
        };
        let named = |key: &str, label: &str| (key.to_owned(), label.to_owned());
        assert_eq!(of(Scope::Run), named("detection_delay_s", "detection delay"));
        assert_eq!(of(Scope::Rupture), named("rupture_2_detection_delay_s", "rupture 2: detection delay"));
        assert_eq!(of(Scope::Event), named("event_2_detection_delay_s", "event 2: detection delay"));
        assert_eq!(of(Scope::Link), named("link_detection_delay_s", "link: detection delay"));
        assert_eq!(of(Scope::Port), named("port_detection_delay_s", "port: detection delay"));
        assert_eq!(of(Scope::Loop), named("stability_detection_delay_s", "stability: detection delay"));
        assert_eq!(of(Scope::Noise), named("in_noise_detection_delay_s", "in noise: detection delay"));
    }

    #[test]
    fn the_words_of_scopes_match_their_json() {
        for scope in [Scope::Run, Scope::Rupture, Scope::Event, Scope::Link, Scope::Port, Scope::Loop, Scope::Noise] {
            assert_eq!(serde_json::to_value(scope).expect("a word"), scope.word());
        }
        for better in [Better::Lower, Better::Higher, Better::Neither] {
            assert_eq!(serde_json::to_value(better).expect("a word"), better.word());
        }
    }
}
