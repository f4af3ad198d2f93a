use crate::sweep::{Column, LoopOfCase};
use trocar_base::quantiles::quantile_of;
use trocar_metrics::{Declaration, EventMetrics, Metric, Metrics, RuptureMetrics, Scope, Unit};
use trocar_scenario::nearest_of;
use trocar_stability::MAX_GAIN_MARGIN;

/// Relative to the ruptures without augmentation.
pub(super) const REACHED: &str = "reached_share";

const REACHED_MEANING: &str = "Number of ruptures, relative to the number in the same runs without augmentation: a needle \
                               that stops before a layer does not rupture it.";

/// Each needs a certificate or a run for every candidate.
const TOO_SLOW: [&str; 3] = ["is_decay_certified", "certified_dwell_s", "is_stable_simulated"];

#[derive(Debug, Clone)]
enum Measure {
    One(Column),
    Ruptures(&'static Metric<fn(&RuptureMetrics) -> Option<f64>>),
    Events(&'static Metric<fn(&EventMetrics) -> Option<f64>>),
    Reached,
}

#[derive(Debug, Clone)]
pub struct Quantity {
    /// For example `rupture_excess_advance_m`.
    pub name: String,
    pub label: String,
    pub meaning: &'static str,
    pub unit: Unit,
    measure: Measure,
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub enum NoQuantity {
    /// The most similar name.
    Unknown(Option<String>),
    Refused(&'static str),
}

impl Quantity {
    pub fn named(name: &str) -> Result<Self, NoQuantity> {
        if name == REACHED {
            return Ok(Self {
                name: name.to_owned(),
                label: "ruptures reached".to_owned(),
                meaning: REACHED_MEANING,
                unit: Unit::Share,
                measure: Measure::Reached,
            });
        }
        let of_each = |declaration: &'static Declaration, word: &str, measure: Measure| Self {
            name: format!("{word}_{}", declaration.name),
            label: format!("{} of a{} {word}", declaration.label, if word == "event" { "n" } else { "" }),
            meaning: declaration.meaning,
            // A count of one rupture is the share of the ruptures.
            unit: if declaration.unit == Unit::Count { Unit::Share } else { declaration.unit },
            measure,
        };
        let of_rupture = name.strip_prefix("rupture_").and_then(|name| {
            let metric = RuptureMetrics::METRICS.iter().find(|metric| metric.declaration.name == name)?;
            Some(of_each(&metric.declaration, "rupture", Measure::Ruptures(metric)))
        });
        let of_event = || {
            let name = name.strip_prefix("event_")?;
            let metric = EventMetrics::METRICS.iter().find(|metric| metric.declaration.name == name)?;
            Some(of_each(&metric.declaration, "event", Measure::Events(metric)))
        };
        if let Some(quantity) = of_rupture.or_else(of_event) {
            return Ok(quantity);
        }
        let Some(column) = Column::named(name) else {
            return Err(NoQuantity::Unknown(nearest_of(name, Self::names())));
        };
        if column.is_of_ports() {
            return Err(NoQuantity::Refused("the energies at the ports need the trace of every run"));
        }
        if TOO_SLOW.iter().any(|slow| column.name.ends_with(slow)) {
            return Err(NoQuantity::Refused(
                "it takes too long for every candidate; write certified = true in a constraint",
            ));
        }
        let Column { name, label, meaning, unit, .. } = column.clone();
        Ok(Self { name, label, meaning, unit, measure: Measure::One(column) })
    }

    /// Ruptures and events have the number 1.
    pub fn names() -> impl Iterator<Item = String> {
        let of_each = RuptureMetrics::METRICS
            .iter()
            .map(|metric| format!("rupture_{}", metric.declaration.name))
            .chain(EventMetrics::METRICS.iter().map(|metric| format!("event_{}", metric.declaration.name)));
        let ports = |declaration: &&Declaration| declaration.scope != Scope::Port;
        let of_one = Column::declarations().filter(ports).map(|declaration| declaration.key(1));
        let slow = |name: &String| !TOO_SLOW.iter().any(|slow| name.ends_with(slow));
        of_each.chain(std::iter::once(REACHED.to_owned())).chain(of_one.filter(slow))
    }

    /// True for a value of the linear loop, which the seeds do not affect.
    pub fn is_of_loop(&self) -> bool {
        matches!(&self.measure, Measure::One(column) if column.is_of_loop())
    }

    pub fn is_relative(&self) -> bool {
        matches!(self.measure, Measure::Reached)
    }

    /// An infinite margin counts as the largest one, so that means stay finite.
    pub(super) fn of_loop(&self, of_case: &LoopOfCase<'_>) -> Option<f64> {
        let Measure::One(column) = &self.measure else { return None };
        column.value_of_loop(of_case).map(|value| value.min(MAX_GAIN_MARGIN))
    }

    /// `without` counts the ruptures in the same run without augmentation.
    pub(super) fn read(&self, metrics: &Metrics, without: u64, of_loop: Option<f64>) -> Values {
        let plain = |values: Vec<f64>| Values { weight: values.len() as f64, values };
        match &self.measure {
            Measure::One(column) if column.is_of_loop() => plain(of_loop.into_iter().collect()),
            Measure::One(column) => plain(column.value(metrics, None).into_iter().collect()),
            Measure::Ruptures(metric) => plain(metrics.ruptures.iter().filter_map(metric.read).collect()),
            Measure::Events(metric) => plain(metrics.events.iter().filter_map(metric.read).collect()),
            Measure::Reached => Values { values: vec![metrics.ruptures.len() as f64], weight: without as f64 },
        }
    }
}

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Values {
    pub(super) values: Vec<f64>,
    /// Divisor of the sum for a mean, usually the number of values.
    pub(super) weight: f64,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Aggregate {
    Mean,
    /// Share from 0 to 1.
    Quantile(f64),
}

impl Aggregate {
    pub fn word(self) -> String {
        match self {
            Self::Mean => "mean".to_owned(),
            Self::Quantile(0.0) => "minimum".to_owned(),
            Self::Quantile(1.0) => "maximum".to_owned(),
            Self::Quantile(0.5) => "median".to_owned(),
            Self::Quantile(share) => format!("{} % quantile", trocar_document::plain(100.0 * share)),
        }
    }
}

#[derive(Debug, Clone, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Samples {
    values: Vec<f64>,
    ends: Vec<usize>,
    /// Divisor of each run's sum.
    weights: Vec<f64>,
}

impl Samples {
    pub(super) fn push(&mut self, of_run: Values) {
        self.values.extend(of_run.values);
        self.ends.push(self.values.len());
        self.weights.push(of_run.weight);
    }

    pub(super) fn runs(&self) -> usize {
        self.ends.len()
    }

    pub(super) fn values(&self) -> &[f64] {
        &self.values
    }

    fn of_run(&self, run: usize) -> &[f64] {
        let start = run.checked_sub(1).map_or(0, |before| self.ends[before]);
        &self.values[start..self.ends[run]]
    }

    pub(super) fn sum(&self, run: usize) -> (f64, f64) {
        (self.of_run(run).iter().sum(), self.weights[run])
    }

    pub fn aggregate(&self, how: Aggregate) -> Option<f64> {
        self.aggregate_over(how, 0..self.runs())
    }

    /// The runs may repeat; `None` without values.
    pub(super) fn aggregate_over(&self, how: Aggregate, runs: impl IntoIterator<Item = usize>) -> Option<f64> {
        match how {
            Aggregate::Mean => {
                let add = |(sum, weight): (f64, f64), run: usize| {
                    let (of_run, weight_of_run) = self.sum(run);
                    (sum + of_run, weight + weight_of_run)
                };
                let (sum, weight) = runs.into_iter().fold((0.0, 0.0), add);
                (weight > 0.0).then(|| sum / weight)
            }
            Aggregate::Quantile(share) => {
                let mut values: Vec<f64> = runs.into_iter().flat_map(|run| self.of_run(run)).copied().collect();
                quantile_of(&mut values, share)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_is_a_quantity_and_wrong_ones_have_a_remedy() {
        assert!(Quantity::names().all(|name| Quantity::named(&name).is_ok_and(|found| found.name == name)));
        let named = |name: &str| Quantity::named(name).map(|quantity| quantity.unit);
        assert_eq!(named("rupture_excess_advance_m"), Ok(Unit::Metre));
        assert_eq!(named("rupture_noticed"), Ok(Unit::Share));
        assert_eq!(named("rupture_2_noticed"), Ok(Unit::Count));
        assert_eq!(named("stability_gain_margin"), Ok(Unit::Number));
        assert_eq!(named("rupture_excess_advance"), Err(NoQuantity::Unknown(Some("rupture_excess_advance_m".into()))));
        assert!(matches!(named("stability_is_decay_certified"), Err(NoQuantity::Refused(_))));
        let port = Column::names().find(|name| name.starts_with("port_")).expect("a metric of the ports");
        assert!(matches!(named(&port), Err(NoQuantity::Refused(_))));
    }

    #[test]
    fn a_mean_over_ruptures_weighs_every_rupture_and_a_share_its_reference() {
        let mut samples = Samples::default();
        samples.push(Values { values: vec![1.0, 3.0], weight: 2.0 });
        samples.push(Values { values: vec![], weight: 0.0 });
        samples.push(Values { values: vec![5.0], weight: 1.0 });
        assert_eq!(samples.aggregate(Aggregate::Mean), Some(3.0));
        assert_eq!(samples.aggregate(Aggregate::Quantile(1.0)), Some(5.0));
        assert_eq!(samples.aggregate_over(Aggregate::Mean, [1]), None);
        assert_eq!(samples.aggregate_over(Aggregate::Mean, [2, 2, 0]), Some(3.5));
        let mut share = Samples::default();
        share.push(Values { values: vec![2.0], weight: 4.0 });
        share.push(Values { values: vec![4.0], weight: 4.0 });
        assert_eq!(share.aggregate(Aggregate::Mean), Some(0.75));
    }
}
