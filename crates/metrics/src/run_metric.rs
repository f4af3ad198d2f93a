use super::{Declaration, EventMetrics, LinkMetrics, Metrics, PortMetrics, RuptureMetrics};

const MAX_NUMBERED: usize = 64;

#[derive(Debug, Clone, Copy)]
enum Reader {
    Run(fn(&Metrics) -> Option<f64>),
    Rupture(fn(&RuptureMetrics) -> Option<f64>),
    Event(fn(&EventMetrics) -> Option<f64>),
    Link(fn(&LinkMetrics) -> Option<f64>),
    Port(fn(&PortMetrics) -> Option<f64>),
}

#[derive(Debug, Clone, Copy)]
pub struct RunMetric {
    declaration: &'static Declaration,
    /// From 1.
    number: usize,
    reader: Reader,
}

impl RunMetric {
    fn of_run() -> impl Iterator<Item = Self> {
        Metrics::METRICS.iter().map(|m| Self { declaration: &m.declaration, number: 1, reader: Reader::Run(m.read) })
    }

    fn of_link() -> impl Iterator<Item = Self> {
        LinkMetrics::METRICS.iter().map(|m| Self {
            declaration: &m.declaration,
            number: 1,
            reader: Reader::Link(m.read),
        })
    }

    fn of_ports() -> impl Iterator<Item = Self> {
        PortMetrics::METRICS.iter().map(|m| Self {
            declaration: &m.declaration,
            number: 1,
            reader: Reader::Port(m.read),
        })
    }

    pub fn of_rupture(number: usize) -> impl Iterator<Item = Self> {
        RuptureMetrics::METRICS.iter().map(move |m| Self {
            declaration: &m.declaration,
            number,
            reader: Reader::Rupture(m.read),
        })
    }

    fn of_event(number: usize) -> impl Iterator<Item = Self> {
        EventMetrics::METRICS.iter().map(move |m| Self {
            declaration: &m.declaration,
            number,
            reader: Reader::Event(m.read),
        })
    }

    pub fn of_whole_run() -> impl Iterator<Item = Self> {
        Self::of_run().chain(Self::of_link()).chain(Self::of_ports())
    }

    /// Ruptures and events have the number 1.
    pub fn all() -> impl Iterator<Item = Self> {
        Self::of_whole_run().chain(Self::of_rupture(1)).chain(Self::of_event(1))
    }

    /// The whole run's, then each rupture's and event's.
    pub fn of_run_with(ruptures: usize, events: usize) -> impl Iterator<Item = Self> {
        let of_ruptures = (1..=ruptures).flat_map(Self::of_rupture);
        Self::of_whole_run().chain(of_ruptures).chain((1..=events).flat_map(Self::of_event))
    }

    /// A key such as `rupture_2_detection_delay_s`.
    pub fn named(key: &str) -> Option<Self> {
        if let Some((number, name)) = numbered(key, "rupture_") {
            return Self::of_rupture(number).find(|metric| metric.declaration.name == name);
        }
        if let Some((number, name)) = numbered(key, "event_") {
            return Self::of_event(number).find(|metric| metric.declaration.name == name);
        }
        let of_link = |name| Self::of_link().find(|metric| metric.declaration.name == name);
        let of_port = |name| Self::of_ports().find(|metric| metric.declaration.name == name);
        Self::of_run()
            .find(|metric| metric.declaration.name == key)
            .or_else(|| key.strip_prefix("link_").and_then(of_link))
            .or_else(|| key.strip_prefix("port_").and_then(of_port))
    }

    pub fn declaration(&self) -> &'static Declaration {
        self.declaration
    }

    /// From 1; 1 for other metrics.
    pub fn number(&self) -> usize {
        self.number
    }

    pub fn key(&self) -> String {
        self.declaration.key(self.number)
    }

    pub fn label(&self) -> String {
        self.declaration.full_label(self.number)
    }

    /// In SI units; `None` if undefined.
    pub fn read(&self, metrics: &Metrics) -> Option<f64> {
        match self.reader {
            Reader::Run(read) => read(metrics),
            Reader::Rupture(read) => metrics.ruptures.get(self.number - 1).and_then(read),
            Reader::Event(read) => metrics.events.get(self.number - 1).and_then(read),
            Reader::Link(read) => metrics.link.as_ref().and_then(read),
            Reader::Port(read) => metrics.ports.as_ref().and_then(read),
        }
    }
}

/// `rupture_2_time_s` into 2 and `time_s`.
fn numbered<'a>(key: &'a str, prefix: &str) -> Option<(usize, &'a str)> {
    let (number, name) = key.strip_prefix(prefix)?.split_once('_')?;
    let is_plain = number.bytes().all(|digit| digit.is_ascii_digit()) && !number.starts_with('0');
    let number = number.parse().ok().filter(|number| is_plain && (1..=MAX_NUMBERED).contains(number))?;
    Some((number, name))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn every_metric_has_a_unique_key_label_and_description() {
        let all: Vec<RunMetric> = RunMetric::all().collect();
        let keys: BTreeSet<String> = all.iter().map(RunMetric::key).collect();
        let labels: BTreeSet<String> = all.iter().map(RunMetric::label).collect();
        assert_eq!((keys.len(), labels.len()), (all.len(), all.len()));
        for metric in all {
            let Declaration { meaning, .. } = metric.declaration();
            assert!(meaning.ends_with('.') && meaning.len() > 20, "{}: {meaning:?}", metric.key());
            let found = RunMetric::named(&metric.key()).map(|found| found.key());
            assert_eq!(found, Some(metric.key()));
        }
        for wrong in ["rupture_0_time_s", "rupture_01_time_s", "rupture_+1_time_s", "rupture_99_time_s", "rupture_1_x"]
        {
            assert!(RunMetric::named(wrong).is_none(), "{wrong}");
        }
        assert!(RunMetric::named("rupture_12_felt_fall_s").is_some());
    }
}
