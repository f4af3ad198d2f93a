use super::stability::LoopOfCase;
use trocar_metrics::{Declaration, Metric, Metrics, RunMetric, Scope, Unit};
use trocar_scenario::nearest_of;

type LoopMetric = Metric<fn(&LoopOfCase<'_>) -> Option<f64>>;

#[derive(Debug, Clone, Copy)]
enum Measure {
    Run(RunMetric),
    Loop(&'static LoopMetric),
}

#[derive(Debug, Clone)]
pub struct Column {
    /// For example `rupture_1_detection_delay_s`.
    pub name: String,
    /// For example `rupture 1: detection delay`.
    pub label: String,
    pub meaning: &'static str,
    pub unit: Unit,
    measure: Measure,
}

const DEFAULTS: [&str; 13] = [
    "detected_ruptures",
    "missed_ruptures",
    "false_alarms",
    "max_slave_overshoot_m",
    "min_felt_contrast",
    "mean_absolute_residual_n",
    "max_tissue_force_n",
    "tracking_rmse_m",
    "tissue_energy_j",
    "rupture_1_detection_delay_s",
    "rupture_1_slave_overshoot_m",
    "rupture_1_slave_travel_m",
    "rupture_1_feedback_fall_s",
];

impl Column {
    fn new(measure: Measure) -> Self {
        let (declaration, name, label) = match measure {
            Measure::Run(metric) => (metric.declaration(), metric.key(), metric.label()),
            Measure::Loop(metric) => {
                let declaration = &metric.declaration;
                (declaration, declaration.key(1), declaration.full_label(1))
            }
        };
        Self { name, label, meaning: declaration.meaning, unit: declaration.unit, measure }
    }

    pub fn named(name: &str) -> Option<Self> {
        let of_loop = || LoopOfCase::METRICS.iter().find(|metric| metric.declaration.key(1) == name);
        let of_run = RunMetric::named(name).map(Measure::Run);
        of_run.or_else(|| of_loop().map(Measure::Loop)).map(Self::new)
    }

    pub fn defaults() -> Vec<Self> {
        DEFAULTS.iter().filter_map(|name| Self::named(name)).collect()
    }

    pub fn declarations() -> impl Iterator<Item = &'static Declaration> {
        let of_loop = LoopOfCase::METRICS.iter().map(|metric| &metric.declaration);
        RunMetric::all().map(|metric| metric.declaration()).chain(of_loop)
    }

    pub fn names() -> impl Iterator<Item = String> {
        Self::declarations().map(|declaration| declaration.key(1))
    }

    pub fn nearest(name: &str) -> Option<String> {
        nearest_of(name, Self::names())
    }

    pub fn is_of_loop(&self) -> bool {
        matches!(self.measure, Measure::Loop(_))
    }

    /// Needs the trace of a run.
    pub fn is_of_ports(&self) -> bool {
        matches!(self.measure, Measure::Run(metric) if metric.declaration().scope == Scope::Port)
    }

    /// SI units; `None` if undefined or not finite, except an infinite margin of the loop.
    pub fn value(&self, metrics: &Metrics, of_case: Option<&LoopOfCase<'_>>) -> Option<f64> {
        let value = match self.measure {
            Measure::Run(metric) => metric.read(metrics),
            Measure::Loop(_) => return of_case.and_then(|of_case| self.value_of_loop(of_case)),
        };
        value.filter(|value| value.is_finite())
    }

    /// `None` for other metrics. A margin can be infinite.
    pub fn value_of_loop(&self, of_case: &LoopOfCase<'_>) -> Option<f64> {
        let Measure::Loop(metric) = self.measure else { return None };
        (metric.read)(of_case).filter(|value| value.is_finite() || *value == f64::INFINITY)
    }

    pub fn is_count(&self) -> bool {
        self.unit == Unit::Count
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_found_and_similar_names_are_suggested() {
        assert!(Column::names().all(|name| Column::named(&name).is_some_and(|column| column.name == name)));
        assert!(Column::declarations().all(|metric| metric.meaning.ends_with('.') && metric.meaning.len() > 20));
        assert_eq!(Column::defaults().len(), DEFAULTS.len());
        assert!(Column::named("stability_x").is_none());
        assert_eq!(Column::nearest("false_alarm").as_deref(), Some("false_alarms"));
        assert_eq!(Column::nearest("zzz"), None);
    }
}
