//! The declaration of metrics.
//!
//! A `metrics!` table declares each metric once: key, label, unit, description, better direction, visibility and
//! reader. Each scope has its table beside its numbers: a run's in `summary.rs`, a rupture's in `rupture.rs`. Structs,
//! JSON, comparison tables, sweep columns and documentation are generated from them.

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
    /// The name used in files.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Lower => "lower",
            Self::Higher => "higher",
            Self::Neither => "neither",
        }
    }
}

/// Where the tables of runs and comparisons show a metric. Sweeps store every listed metric.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shown {
    /// In every table, including the short table of a comparison.
    Main,
    /// In every table, if any run defines the metric.
    MainWhereDefined,
    /// In every table except the short one.
    Always,
    /// In every table except the short one, if any run defines the metric.
    WhereDefined,
    /// Above all other metrics, if any run defines it.
    First,
    /// If the metric is not 0 in at least one run.
    WhereNonZero,
    /// In no table.
    Never,
}

/// What a metric describes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Scope {
    /// The run.
    Run,
    /// One rupture of the run.
    Rupture,
    /// One augmented event of the run.
    Event,
    /// The link between master and slave.
    Link,
    /// The ports between hand, link and needle.
    Port,
    /// The control loop of one case of a sweep.
    Loop,
    /// The run's detection with added noise.
    Noise,
}

impl Scope {
    /// The name used in files.
    #[must_use]
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

    /// Prefix of keys; `number`, from 1, identifies a rupture or event.
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

/// The declaration of a metric.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Declaration {
    /// The scope.
    pub scope: Scope,
    /// The key without the prefix of its scope, with the unit at the end: `detection_delay_s`.
    pub name: &'static str,
    /// A former name, which sweep files may still use.
    pub former_name: Option<&'static str>,
    /// The label in tables, without the prefix of its scope.
    pub label: &'static str,
    /// The unit.
    pub unit: Unit,
    /// True if the sign varies, so that a relative change has no meaning.
    pub is_signed: bool,
    /// The better direction.
    pub better: Better,
    /// The tables that show it.
    pub shown: Shown,
    /// The meaning, in one sentence.
    pub meaning: &'static str,
}

impl Shown {
    /// True if the short table of a comparison contains the metric.
    #[must_use]
    pub fn is_main(self) -> bool {
        matches!(self, Self::Main | Self::MainWhereDefined)
    }
}

impl Declaration {
    /// The name used in files; `number`, from 1, identifies a rupture or event.
    #[must_use]
    pub fn key(&self, number: usize) -> String {
        self.scope.key_prefix(number) + self.name
    }

    /// The label in tables.
    #[must_use]
    pub fn full_label(&self, number: usize) -> String {
        self.scope.label_prefix(number) + self.label
    }

    pub(crate) fn is_called(&self, name: &str) -> bool {
        self.name == name || self.former_name == Some(name)
    }
}

/// A metric and its reader.
#[derive(Debug, Clone, Copy)]
pub struct Metric<Read> {
    /// The declaration.
    pub declaration: Declaration,
    /// Reads the value in SI units; `None` if undefined.
    pub read: Read,
}

/// A field that is a metric by itself.
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
/// An entry is a doc comment of one line and `name: Type = "label", Unit signed, Better [Shown] was "former_name" =>
/// |of| read;`. Without `: Type` the entry declares no field and needs `=> read`. Without `= "label"` it declares a
/// field that is not a metric. `signed`, `[Shown]`, `was` and `=> read` are optional. A struct with a JSON
/// Schema transforms it by `schema::with_units`.
#[doc(hidden)]
#[macro_export]
macro_rules! metrics {
    (
        $(#[$attribute:meta])*
        pub struct $owner:ident in $scope:ident {
            $(
                #[doc = $meaning:literal]
                $name:ident $(: $type:ty)? $(= $label:literal, $unit:ident $($signed:ident)?, $better:ident $([$shown:ident])?
                $(was $former:literal)? $(=> $read:expr)?)? ;
            )*
        }
    ) => {
        $(#[$attribute])*
        pub struct $owner {
            $($(#[doc = $meaning] pub $name: $type,)?)*
        }

        $crate::metrics! {
            impl $scope for $owner {
                $($(#[doc = $meaning] $name = $label, $unit $($signed)?, $better $([$shown])? $(was $former)? $(=> $read)?;)?)*
            }
        }
    };
    (
        impl $scope:ident for $owner:ty {
            $(
                #[doc = $meaning:literal]
                $name:ident = $label:literal, $unit:ident $($signed:ident)?, $better:ident $([$shown:ident])? $(was $former:literal)? $(=> $read:expr)?;
            )*
        }
    ) => {
        impl $owner {
            /// The metrics of this scope, in the order of tables.
            pub const METRICS: &'static [$crate::Metric<fn(&$owner) -> Option<f64>>] = &[$(
                $crate::Metric {
                    declaration: $crate::Declaration {
                        scope: $crate::Scope::$scope,
                        name: stringify!($name),
                        former_name: $crate::metrics!(@former $($former)?),
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
    (@former) => { None };
    (@former $former:literal) => { Some($former) };
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
        former_name: Some("delay_s"),
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
}
