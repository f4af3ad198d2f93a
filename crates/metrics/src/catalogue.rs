//! The declaration of metrics.
//!
//! A metric is declared once, in a `metrics!` table: its key, label, unit, sentence, better direction, visibility in
//! tables and reader. Each scope has its table beside its numbers: a run's in `summary.rs`, a rupture's in
//! `rupture.rs`. Structs, JSON, comparison tables, sweep columns and documentation are generated from the declarations.

use schemars::{JsonSchema, Schema};
use serde::Serialize;
use serde_json::Value as Json;

use super::Unit;

/// Which values of a metric are better, other things being equal.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Better {
    /// Smaller ones.
    Lower,
    /// Larger ones.
    Higher,
    /// It is descriptive only.
    Neither,
}

impl Better {
    /// Its name in files.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Lower => "lower",
            Self::Higher => "higher",
            Self::Neither => "neither",
        }
    }
}

/// Where the tables of runs and of comparisons show a metric. A sweep stores every metric that its file lists.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shown {
    /// In every table, including the short table of a comparison.
    Main,
    /// As `Main`, if a run defines it.
    MainWhereDefined,
    /// In every table except the short one.
    Always,
    /// As `Always`, if a run defines it.
    WhereDefined,
    /// Above all others, if a run defines it.
    First,
    /// If it is not 0 in one of the runs.
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
    /// The control loop of a case of a sweep.
    Loop,
    /// The run's detection with noise added.
    Noise,
}

impl Scope {
    /// Its name in files.
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

    /// The prefix of keys; `number`, from 1, counts ruptures and events.
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

    /// The prefix of labels.
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
    /// Its scope.
    pub scope: Scope,
    /// Its key without the prefix of its scope, with the unit at the end: `detection_delay_s`.
    pub name: &'static str,
    /// An earlier name, which sweep files may still use.
    pub former_name: Option<&'static str>,
    /// Its label in tables, without the prefix of its scope.
    pub label: &'static str,
    /// Its unit.
    pub unit: Unit,
    /// Whether its sign varies, so that a relative change of it has no meaning.
    pub is_signed: bool,
    /// Which values are better.
    pub better: Better,
    /// Where tables show it.
    pub shown: Shown,
    /// Its meaning, in a sentence.
    pub meaning: &'static str,
}

impl Shown {
    /// Whether the short table of a comparison has it.
    #[must_use]
    pub fn is_main(self) -> bool {
        matches!(self, Self::Main | Self::MainWhereDefined)
    }
}

impl Declaration {
    /// Its name in files; `number`, from 1, counts ruptures and events.
    #[must_use]
    pub fn key(&self, number: usize) -> String {
        self.scope.key_prefix(number) + self.name
    }

    /// Its label in tables.
    #[must_use]
    pub fn full_label(&self, number: usize) -> String {
        self.scope.label_prefix(number) + self.label
    }

    /// Whether a name without prefix is its current or former name.
    pub(crate) fn is_called(&self, name: &str) -> bool {
        self.name == name || self.former_name == Some(name)
    }
}

/// A metric and its reader.
#[derive(Debug, Clone, Copy)]
pub struct Metric<Read> {
    /// Its declaration.
    pub declaration: Declaration,
    /// Its value in SI units; `None` if undefined.
    pub read: Read,
}

/// A field that is itself a metric.
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

/// Returns a transform of the schema of a scope's numbers: it adds the unit to the description of each metric.
pub fn with_units<Read>(metrics: &'static [Metric<Read>]) -> impl FnMut(&mut Schema) {
    move |schema| {
        let Some(properties) = schema.get_mut("properties") else { return };
        for Declaration { name, unit, .. } in metrics.iter().map(|metric| &metric.declaration) {
            let description = properties.get_mut(name).and_then(|property| property.get_mut("description"));
            if let (Some(Json::String(description)), false) = (description, unit.si() == "1") {
                description.push_str(&format!(" In {}.", unit.si()));
            }
        }
    }
}

/// Declares the metrics of a scope, and with `pub struct` the fields that they are read from.
///
/// An entry is a doc comment of one line, which is the metric's sentence, and
/// `name: Type = "label", Unit signed, Better [Shown] was "former_name" => |of| read;`. Without `: Type` it is not a field
/// and needs `=> read`; without `= "label"` it is a field and not a metric; `signed`, `[Shown]`, `was` and `=> read` may be
/// left out. The struct derives its JSON Schema, in which each metric has its unit.
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
        #[schemars(transform = $crate::catalogue::with_units(Self::METRICS))]
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

    #[test]
    fn words_are_those_of_json() {
        for scope in [Scope::Run, Scope::Rupture, Scope::Event, Scope::Link, Scope::Port, Scope::Loop, Scope::Noise] {
            assert_eq!(serde_json::to_value(scope).expect("a word"), scope.word());
        }
        for better in [Better::Lower, Better::Higher, Better::Neither] {
            assert_eq!(serde_json::to_value(better).expect("a word"), better.word());
        }
    }

    #[test]
    fn a_metric_answers_to_its_name_and_to_its_former_one() {
        assert_eq!(
            ["detection_delay_s", "delay_s", "delay"].map(|name| DECLARATION.is_called(name)),
            [true, true, false]
        );
        let new = Declaration { former_name: None, ..DECLARATION };
        assert!(!new.is_called("delay_s"));
    }

    #[test]
    fn the_short_table_has_the_main_metrics() {
        let shown =
            [Shown::Main, Shown::MainWhereDefined, Shown::Always, Shown::WhereDefined, Shown::First, Shown::Never];
        assert_eq!(shown.map(Shown::is_main), [true, true, false, false, false, false]);
    }

    #[test]
    fn a_field_is_a_number_or_undefined() {
        assert_eq!(
            [2.5.value(), 3_u64.value(), Some(4.5).value(), None::<u64>.value()],
            [Some(2.5), Some(3.0), Some(4.5), None]
        );
    }
}
