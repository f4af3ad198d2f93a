use std::collections::BTreeSet;

use schemars::JsonSchema;
use serde::Serialize;

use super::{Characteristics, Condition, Curve, Point};
use trocar_base::warning::Warning;
use trocar_document::{
    Cell, DataTable, Digits, Document, Number, Section, Table, Verdict, counted, json_of, plain, significant,
};
use trocar_figures::{CharacteristicView, FigureError};
use trocar_metrics::Unit;

const STATED_DETECTION: f64 = 0.995;

const STATED_FALSE_ALARMS_PER_HOUR: f64 = 1.0;

/// One per minute, which a short study can resolve.
const BASELINE_FALSE_ALARMS_PER_HOUR: f64 = 60.0;

/// `roc.json`: detection, delay and false alarms by threshold.
#[derive(Debug, Serialize, JsonSchema)]
pub struct RocFile<'a> {
    /// Version of trocar.
    trocar_version: &'static str,
    /// Number of seeds of each condition.
    seeds: u64,
    /// True if the study ended before all cases were evaluated.
    stopped: bool,
    /// The warnings about the study.
    warnings: Vec<Warning>,
    characteristics: &'a Characteristics,
}

impl Characteristics {
    pub fn document(&self, seeds: u64) -> Document<'_> {
        let is_stopped = self.cases < self.cases_planned;
        let runs = match is_stopped {
            true => format!("stopped after {} of {} runs", self.cases, self.cases_planned),
            false => counted(self.cases, "run"),
        };
        let conditions = match self.conditions.len() {
            1 => String::new(),
            conditions => format!(" in {conditions} conditions"),
        };
        let mut document = Document {
            name: "roc",
            title: format!("{runs}{conditions}"),
            verdict: Verdict { sentences: self.counts().into_iter().chain(self.best()).collect(), left_out: vec![] },
            warnings: self.warnings(),
            sections: self.sections(),
            data: vec![self.points()],
            json: json_of(&RocFile {
                trocar_version: env!("CARGO_PKG_VERSION"),
                seeds,
                stopped: is_stopped,
                warnings: self.warnings(),
                characteristics: self,
            }),
            ..Document::default()
        };
        document.figure("roc", self.figure());
        document
    }

    fn observed(&self) -> (f64, u64) {
        let point = self.all.first().and_then(|curve| curve.points.first());
        point.map_or((0.0, 0), |point| (point.hours, point.ruptures))
    }

    fn counts(&self) -> Vec<String> {
        let (hours, ruptures) = self.observed();
        vec![
            format!("{} and {} without a rupture.", counted(ruptures, "rupture"), observed(hours)),
            format!("An alarm within {} ms counts as in time.", plain(1e3 * self.within_s)),
        ]
    }

    fn best(&self) -> Option<String> {
        let detection = |point: &Point| point.detection.unwrap_or(0.0);
        let most = self.own_points().map(|(_, point)| detection(point)).max_by(f64::total_cmp)?;
        let of_most = || self.own_points().filter(|(_, point)| detection(point) == most);
        let fewest = of_most().map(|(_, point)| point.false_alarms).min()?;
        let best: Vec<&str> =
            of_most().filter(|(_, point)| point.false_alarms == fewest).map(|(curve, _)| &*curve.detector).collect();
        let alarms = if fewest == 0 { "no false alarm".to_owned() } else { counted(fewest, "false alarm") };
        let (names, share) = (best.join(", "), share(most));
        Some(match best.len() {
            1 => format!(
                "{names} detects the largest share of ruptures in time at its own threshold: {share}, with {alarms}."
            ),
            count => format!(
                "{count} of {} detect the same largest share of ruptures in time at their own thresholds, {share}, \
                 with {alarms}: {names}.",
                counted(self.own_points().count() as u64, "detector")
            ),
        })
    }

    fn sections(&self) -> Vec<Section> {
        let titled = |id, title: &'static str, line: &str, table: Table| {
            let mut section = Section::new(id, title);
            section.text(line);
            section.table(table);
            section
        };
        let line = "at the detector's own threshold";
        let mut first = titled("own", "At the detector's own threshold", line, self.own_table());
        first.figure("roc");
        let mut sections = vec![first];
        if let Some(misses) = self.misses_table() {
            let line = "why ruptures have no alarm, at the detector's own threshold";
            sections.push(titled("misses", "Misses", line, misses));
        }
        let mut best = titled("best", "At the best threshold", "at the best threshold", self.best_table());
        best.table(self.thresholds_table());
        sections.push(best);
        let baselines = self.baselines();
        if !baselines.is_empty() {
            let mut section = Section::new("baselines", "Baselines");
            baselines.into_iter().for_each(|line| section.text(line));
            sections.push(section);
        }
        if self.conditions.len() > 1 {
            let line = "detected in time, and false-alarm rate, at the detector's own threshold";
            sections.push(titled("conditions", "Conditions", line, self.conditions_table()));
        }
        sections
    }

    fn own_table(&self) -> Table {
        let columns = [
            ("detector", "detector"),
            ("threshold", "threshold"),
            ("detection", "detected in time"),
            ("detection_of_each", "by rupture"),
            ("delay_s", "delay"),
            ("late", "late"),
            ("false_alarms_per_hour", "false alarms"),
        ];
        let mut table = Table::new("own", "At the detector's own threshold", columns);
        for (curve, point) in self.own_points() {
            let each: Vec<String> = point.detection_of_each.iter().map(|of| share(*of).to_string()).collect();
            table.row([
                (&*curve.detector).into(),
                threshold(curve.own_threshold, curve.unit),
                detected(point),
                if each.is_empty() { Cell::Undefined } else { each.join(", ").into() },
                delay(point),
                Cell::count(point.late),
                rate(point),
            ]);
        }
        table
    }

    fn own_points(&self) -> impl Iterator<Item = (&Curve, &Point)> {
        self.all.iter().filter_map(|curve| Some((curve, curve.at_own_threshold()?)))
    }

    fn misses_table(&self) -> Option<Table> {
        let built_in = || self.own_points().filter(|(curve, _)| !curve.is_user_defined);
        let reasons: BTreeSet<&String> = built_in().flat_map(|(_, point)| point.missed.keys()).collect();
        let columns = reasons.iter().map(|reason| (reason.as_str(), reason.replace('-', " ")));
        let columns = [("detector", "missed".to_owned())].into_iter().chain(columns);
        let mut table = Table::new("misses", "Why ruptures have no alarm, at the detector's own threshold", columns);
        for (curve, point) in built_in() {
            let counts = reasons.iter().map(|reason| Cell::count(*point.missed.get(*reason).unwrap_or(&0)));
            table.row([(&*curve.detector).into()].into_iter().chain(counts));
        }
        (!reasons.is_empty()).then_some(table)
    }

    fn best_table(&self) -> Table {
        let stated = 100.0 * STATED_DETECTION;
        let columns = [
            ("detector", "detector".to_owned()),
            ("false_alarms_per_hour", format!("false-alarm rate at {stated} % detected")),
            ("delay_at_detection_s", format!("delay at {stated} % detected")),
            ("detection", "detected at 1 false alarm/h".to_owned()),
            ("delay_at_rate_s", "delay at 1 false alarm/h".to_owned()),
            ("most_detected", "most detected at any threshold".to_owned()),
        ];
        let mut table = Table::new("best", "At the best threshold", columns);
        for curve in &self.all {
            let at_detection = curve.at_detection(STATED_DETECTION);
            let at_rate = curve.at_false_alarms_per_hour(STATED_FALSE_ALARMS_PER_HOUR);
            let best = curve.points.iter().max_by_key(|point| point.detected).and_then(|point| point.detection);
            table.row([
                (&*curve.detector).into(),
                at_detection.map_or("never reached".into(), rate),
                at_detection.map_or(Cell::Undefined, delay),
                at_rate.map_or(Cell::Undefined, |point| unresolved(point).map_or_else(|| detected(point), Cell::from)),
                at_rate.filter(|point| unresolved(point).is_none()).map_or(Cell::Undefined, delay),
                best.map_or(Cell::Undefined, |best| share(best).into()),
            ]);
        }
        table
    }

    fn thresholds_table(&self) -> Table {
        let columns = [
            ("detector", "threshold".to_owned()),
            ("own", "its own".to_owned()),
            ("at_detection", format!("at {} % detected", 100.0 * STATED_DETECTION)),
            ("at_rate", format!("at {STATED_FALSE_ALARMS_PER_HOUR} false alarm/h")),
        ];
        let mut table = Table::new("thresholds", "Thresholds", columns);
        for curve in &self.all {
            let of =
                |point: Option<&Point>| point.map_or(Cell::Undefined, |point| threshold(point.threshold, curve.unit));
            let at_rate = curve.at_false_alarms_per_hour(STATED_FALSE_ALARMS_PER_HOUR);
            table.row([
                (&*curve.detector).into(),
                threshold(curve.own_threshold, curve.unit),
                of(curve.at_detection(STATED_DETECTION)),
                of(at_rate.filter(|point| unresolved(point).is_none())),
            ]);
        }
        table
    }

    fn baselines(&self) -> Vec<String> {
        let best = |curve: &Curve| {
            let point = curve.at_false_alarms_per_hour(BASELINE_FALSE_ALARMS_PER_HOUR);
            point.and_then(|point| point.detection).unwrap_or(0.0)
        };
        let (baselines, others): (Vec<&Curve>, Vec<&Curve>) = self.all.iter().partition(|curve| curve.is_baseline);
        if baselines.is_empty() || others.is_empty() {
            return vec![];
        }
        let mut lines = vec!["With at most 1 false alarm a minute, each at its best threshold:".to_owned()];
        for baseline in &baselines {
            let beaten = others.iter().filter(|other| best(other) < best(baseline));
            let beaten: Vec<String> =
                beaten.map(|other| format!("{} ({})", other.detector, share(best(other)))).collect();
            if !beaten.is_empty() {
                lines.push(format!(
                    "The baseline {} ({}) detects more than {}.",
                    baseline.detector,
                    share(best(baseline)),
                    beaten.join(", ")
                ));
            }
        }
        if lines.len() == 1 {
            return vec![
                "With at most 1 false alarm a minute, no baseline detects more than another detector.".to_owned(),
            ];
        }
        lines
    }

    fn conditions_table(&self) -> Table {
        let detectors = self.all.iter().map(|curve| (&*curve.detector, &*curve.detector));
        let columns = [("condition", "condition")].into_iter().chain(detectors);
        let mut table = Table::new("conditions", "By condition", columns);
        for condition in &self.conditions {
            let of = |curve: &Curve| {
                let point = curve.at_own_threshold()?;
                let detection = point.detection.map_or("—".into(), |detection| share(detection).to_string());
                Some(format!("{detection}, {}", short_rate(point)))
            };
            let cells = condition.curves.iter().map(|curve| of(curve).map_or(Cell::Undefined, Cell::from));
            table.row([named(condition).into()].into_iter().chain(cells));
        }
        table
    }

    fn points(&self) -> DataTable<'_> {
        let all = self.all.iter().map(|curve| (None, curve));
        let each = self.conditions.iter().flat_map(|one| one.curves.iter().map(move |curve| (Some(one), curve)));
        let rows: Vec<(Option<&Condition>, &Curve, &Point)> = all
            .chain(each)
            .flat_map(|(condition, curve)| curve.points.iter().map(move |point| (condition, curve, point)))
            .collect();
        let points = || rows.iter().map(|row| row.2);
        let conditions = || rows.iter().map(|row| row.0);
        let rates = || points().map(|point| point.false_alarms_per_minute_interval);
        DataTable::new("roc")
            .texts("signal", conditions().map(|condition| condition.map_or("all", |condition| &condition.signal)))
            .optional("noise_std_n", conditions().map(|condition| Some(condition?.noise_std_n)))
            .optional("drop_n", conditions().map(|condition| condition?.drop_n))
            .optional("sharpness_s", conditions().map(|condition| condition?.sharpness_s))
            .optional("depth_m", conditions().map(|condition| condition?.depth_m))
            .texts("detector", rows.iter().map(|row| &*row.1.detector))
            .texts("unit", rows.iter().map(|row| row.1.unit))
            .numbers("threshold", points().map(|point| point.threshold))
            .numbers("drift", rows.iter().map(|row| row.1.drift))
            .whole("cases", points().map(|point| point.cases))
            .whole("clean_cases", points().map(|point| point.clean_cases))
            .whole("ruptures", points().map(|point| point.ruptures))
            .whole("detected", points().map(|point| point.detected))
            .whole("late", points().map(|point| point.late))
            .optional("detection", points().map(|point| point.detection))
            .optional("detection_low", points().map(|point| Some(point.detection_interval?.0)))
            .optional("detection_high", points().map(|point| Some(point.detection_interval?.1)))
            .optional("delay_median_s", points().map(|point| point.delay_median_s))
            .optional("delay_5_s", points().map(|point| point.delay_5_s))
            .optional("delay_95_s", points().map(|point| point.delay_95_s))
            .whole("false_alarms", points().map(|point| point.false_alarms))
            .numbers("hours", points().map(|point| point.hours))
            .optional("false_alarms_per_minute", points().map(|point| point.false_alarms_per_minute))
            .optional("false_alarms_per_minute_low", rates().map(|interval| Some(interval?.0)))
            .optional("false_alarms_per_minute_high", rates().map(|interval| Some(interval?.1)))
    }

    fn figure(&self) -> Result<trocar_document::Figure<'_>, FigureError> {
        let views: Vec<CharacteristicView<'_>> = self.all.iter().map(characteristic_view).collect();
        let (hours, _) = self.observed();
        let min_per_minute = if hours > 0.0 { 1.0 / (60.0 * hours) } else { 1.0 };
        let mut names: Vec<&str> = self.conditions.iter().map(|condition| condition.signal.as_str()).collect();
        names.dedup();
        trocar_figures::characteristic(&names.join(", "), &views, min_per_minute)
    }
}

fn characteristic_view(curve: &Curve) -> CharacteristicView<'_> {
    let front = curve.front();
    CharacteristicView {
        name: &curve.detector,
        false_alarms_per_minute: front.iter().map(|p| p.false_alarms_per_minute.unwrap_or(0.0)).collect(),
        detection: front.iter().map(|p| p.detection.unwrap_or(f64::NAN)).collect(),
        delay_median_s: front.iter().map(|p| p.delay_median_s.unwrap_or(f64::NAN)).collect(),
    }
}

/// Without a false alarm in three hours, the 95 % interval includes one per hour.
fn unresolved(point: &Point) -> Option<String> {
    let is_unresolved = point.false_alarms == 0 && point.hours * STATED_FALSE_ALARMS_PER_HOUR < 3.0;
    is_unresolved.then(|| format!("not resolvable: {} observed", observed(point.hours)))
}

fn observed(hours: f64) -> String {
    if hours < 1.0 { format!("{:.1} min", 60.0 * hours) } else { format!("{hours:.1} h") }
}

fn named(condition: &Condition) -> String {
    let parts = [
        (condition.drop_n, 1.0, "N drop"),
        (condition.sharpness_s, 1e3, "ms fall"),
        (condition.depth_m, 1e3, "mm deep"),
    ];
    let part = |(value, factor, what): (Option<f64>, f64, &str)| {
        value.map_or(String::new(), |value| format!(", {} {what}", significant(factor * value)))
    };
    format!("{} + {} N{}", condition.signal, condition.noise_std_n, parts.map(part).concat())
}

fn threshold(threshold: f64, unit: &str) -> Cell {
    Cell::si(Some(threshold).filter(|threshold| !threshold.is_nan()), unit)
}

fn share(share: f64) -> Number {
    Number::new(share, Unit::Share).digits(Digits::Decimals(1))
}

fn detected(point: &Point) -> Cell {
    match (point.detection, point.detection_interval) {
        (Some(detection), Some((low, high))) => Cell::Interval(share(detection), [low, high]),
        _ => Cell::Undefined,
    }
}

fn delay(point: &Point) -> Cell {
    match (point.delay_median_s, point.delay_5_s, point.delay_95_s) {
        (Some(median), Some(low), Some(high)) => Cell::Interval(Number::milliseconds(median), [low, high]),
        _ => Cell::Undefined,
    }
}

fn short(rate: f64) -> String {
    if rate >= 100.0 { format!("{rate:.0}") } else { format!("{rate:.2}") }
}

fn short_rate(point: &Point) -> String {
    match (point.false_alarms_per_minute, point.false_alarms_per_minute_interval) {
        (Some(rate), _) => format!("{}/h", short(60.0 * rate)),
        (None, Some((_, high))) => format!("< {}/h", short(60.0 * high)),
        (None, None) => "—".into(),
    }
}

fn rate(point: &Point) -> Cell {
    match (point.false_alarms_per_minute, point.false_alarms_per_minute_interval) {
        (Some(rate), Some((low, high))) => {
            format!("{} [{}, {}]/h", short(60.0 * rate), short(60.0 * low), short(60.0 * high)).into()
        }
        (None, Some(_)) => short_rate(point).into(),
        (_, None) => Cell::Undefined,
    }
}
