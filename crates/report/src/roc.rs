//! Operating characteristics as text, CSV, JSON and a figure.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use serde_json::json;

use super::figures::{self, CharacteristicView};
use super::pictures::{PictureError, keep};
use super::tables::quoted;
use super::wrap::wrapped;
use super::{Folder, Table};
use trocar_document::shortest;
use trocar_document::{counted, plain, show, significant};
use trocar_metrics::Unit;
use trocar_studies::roc::{Characteristics, Condition, Curve, Point};

/// Share of detected ruptures at which false-alarm rates are compared.
const STATED_DETECTION: f64 = 0.995;

/// False alarms per hour at which detections are compared.
const STATED_FALSE_ALARMS_PER_HOUR: f64 = 1.0;

/// Returns the tables: each detector at its own threshold, at the stated operating points, and by condition.
#[must_use]
pub fn roc_text(roc: &Characteristics) -> String {
    let mut text = heading(roc);
    text.push_str("\nat the detector's own threshold\n");
    let mut table =
        Table::new(["detector", "threshold", "detected in time", "by rupture", "delay", "late", "false alarms"]);
    for curve in &roc.all {
        let Some(point) = curve.at_own_threshold() else { continue };
        let each: Vec<String> = point.detection_of_each.iter().map(|share| percent(*share)).collect();
        table.row([
            curve.detector.to_owned(),
            format!("{}{}", significant(curve.own_threshold), of_unit(curve.unit)),
            detected(point),
            if each.is_empty() { "—".into() } else { each.join(", ") },
            delay(point),
            format!("{}", point.late),
            rate(point),
        ]);
    }
    let _ = writeln!(text, "{table}");
    text.push_str(&misses(roc));
    text.push_str("at the best threshold\n");
    let stated = 100.0 * STATED_DETECTION;
    let mut table = Table::new([
        "detector",
        &format!("false-alarm rate at {stated} % detected"),
        &format!("delay at {stated} % detected"),
        "detected at 1 false alarm/h",
        "delay at 1 false alarm/h",
        "most detected at any threshold",
    ]);
    for curve in &roc.all {
        let at_detection = curve.at_detection(STATED_DETECTION);
        let at_rate = curve.at_false_alarms_per_hour(STATED_FALSE_ALARMS_PER_HOUR);
        let best = curve.points.iter().max_by_key(|point| point.detected);
        table.row([
            curve.detector.to_owned(),
            at_detection.map_or("never reached".into(), rate),
            at_detection.map_or("—".into(), delay),
            at_rate.map_or("—".into(), |point| unresolved(point).unwrap_or_else(|| detected(point))),
            at_rate.filter(|point| unresolved(point).is_none()).map_or("—".into(), delay),
            best.and_then(|point| point.detection).map_or("—".into(), percent),
        ]);
    }
    let _ = write!(text, "{table}\n{}", best_thresholds(roc));
    if let Some(baselines) = baselines(roc) {
        let _ = write!(text, "\n{baselines}");
    }
    if roc.conditions.len() > 1 {
        let _ = write!(
            text,
            "\ndetected in time, and false-alarm rate, at the detector's own threshold\n{}",
            by_condition(roc)
        );
    }
    wrapped(&text, 0)
}

/// Returns why each detector at its own threshold misses ruptures; empty without a missed one.
fn misses(roc: &Characteristics) -> String {
    let own = || roc.all.iter().filter_map(|curve| Some((curve, curve.at_own_threshold()?)));
    let reasons: BTreeSet<&String> = own().flat_map(|(_, point)| point.missed.keys()).collect();
    if reasons.is_empty() {
        return String::new();
    }
    let header = reasons.iter().map(|reason| reason.replace('-', " "));
    let mut table = Table::new(["missed".to_owned()].into_iter().chain(header));
    for (curve, point) in own() {
        let counts = reasons.iter().map(|reason| point.missed.get(*reason).unwrap_or(&0).to_string());
        table.row([curve.detector.to_owned()].into_iter().chain(counts));
    }
    format!("why ruptures have no alarm, at the detector's own threshold\n{table}\n")
}

/// Returns the best threshold of each detector at the stated operating points, next to its own.
fn best_thresholds(roc: &Characteristics) -> Table {
    let mut table = Table::new([
        "threshold".to_owned(),
        "its own".to_owned(),
        format!("at {} % detected", 100.0 * STATED_DETECTION),
        format!("at {STATED_FALSE_ALARMS_PER_HOUR} false alarm/h"),
    ]);
    for curve in &roc.all {
        let threshold = |value: f64| format!("{}{}", significant(value), of_unit(curve.unit));
        let of = |point: Option<&Point>| point.map_or("—".into(), |point| threshold(point.threshold));
        table.row([
            curve.detector.to_owned(),
            threshold(curve.own_threshold),
            of(curve.at_detection(STATED_DETECTION)),
            of(curve
                .at_false_alarms_per_hour(STATED_FALSE_ALARMS_PER_HOUR)
                .filter(|point| unresolved(point).is_none())),
        ]);
    }
    table
}

/// False alarms per hour at which baselines are compared: one a minute, which a short study resolves.
const BASELINE_FALSE_ALARMS_PER_HOUR: f64 = 60.0;

/// Returns which detectors each baseline beats: those that detect fewer ruptures, each at its best threshold. `None` without
/// baselines or others.
fn baselines(roc: &Characteristics) -> Option<String> {
    let best = |curve: &Curve| {
        let point = curve.at_false_alarms_per_hour(BASELINE_FALSE_ALARMS_PER_HOUR);
        point.and_then(|point| point.detection).unwrap_or(0.0)
    };
    let (baselines, others): (Vec<&Curve>, Vec<&Curve>) = roc.all.iter().partition(|curve| curve.is_baseline);
    if baselines.is_empty() || others.is_empty() {
        return None;
    }
    let mut text = String::new();
    for baseline in &baselines {
        let beaten = others.iter().filter(|other| best(other) < best(baseline));
        let beaten: Vec<String> =
            beaten.map(|other| format!("{} ({})", other.detector, percent(best(other)))).collect();
        if !beaten.is_empty() {
            let share = percent(best(baseline));
            let _ =
                writeln!(text, "The baseline {} ({share}) detects more than {}.", baseline.detector, beaten.join(", "));
        }
    }
    Some(if text.is_empty() {
        "With at most 1 false alarm a minute, no baseline detects more than another detector.\n".into()
    } else {
        format!("With at most 1 false alarm a minute, each at its best threshold:\n{text}")
    })
}

/// Returns why a point says nothing about the stated rate of false alarms; `None` if it does. Without a false alarm in less than
/// three hours, the 95 % confidence interval includes a rate of one per hour.
fn unresolved(point: &Point) -> Option<String> {
    let is_unresolved = point.false_alarms == 0 && point.hours * STATED_FALSE_ALARMS_PER_HOUR < 3.0;
    is_unresolved.then(|| format!("not resolvable: {} observed", observed(point.hours)))
}

/// Returns a duration in minutes, or in hours from one hour on.
fn observed(hours: f64) -> String {
    if hours < 1.0 { format!("{:.1} min", 60.0 * hours) } else { format!("{hours:.1} h") }
}

fn heading(roc: &Characteristics) -> String {
    let point = roc.all.first().and_then(|curve| curve.points.first());
    let (ruptures, hours) = point.map_or((0, 0.0), |point| (point.ruptures, point.hours));
    let stopped = if roc.cases < roc.cases_planned {
        format!("stopped after {} of {} cases\n", roc.cases, roc.cases_planned)
    } else {
        String::new()
    };
    format!(
        "{stopped}{}{}: {} and {} without a rupture. An alarm within {} ms counts as in time.\n",
        counted(roc.cases, "run"),
        match roc.conditions.len() {
            1 => String::new(),
            conditions => format!(" in {conditions} conditions"),
        },
        counted(ruptures, "rupture"),
        observed(hours),
        plain(1e3 * roc.within_s),
    )
}

fn by_condition(roc: &Characteristics) -> Table {
    let detectors = roc.all.iter().map(|curve| curve.detector.to_owned());
    let mut table = Table::new(std::iter::once("condition".to_owned()).chain(detectors));
    for condition in &roc.conditions {
        let of = |curve: &Curve| match curve.at_own_threshold() {
            Some(point) => format!("{}, {}", point.detection.map_or("—".into(), percent), short_rate(point)),
            None => "—".into(),
        };
        table.row(std::iter::once(named(condition)).chain(condition.curves.iter().map(of)));
    }
    table
}

/// Returns the name of a condition.
fn named(condition: &Condition) -> String {
    let mut name = format!("{} + {} N", condition.signal, condition.noise_std_n);
    let parts = [
        (condition.drop_n, 1.0, "N drop"),
        (condition.sharpness_s, 1e3, "ms fall"),
        (condition.depth_m, 1e3, "mm deep"),
    ];
    for (value, factor, what) in parts {
        if let Some(value) = value {
            let _ = write!(name, ", {} {what}", significant(factor * value));
        }
    }
    name
}

/// The unit after a number; nothing for a plain number.
pub(super) fn of_unit(unit: &str) -> String {
    if unit == "1" { String::new() } else { format!(" {unit}") }
}

fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}

fn detected(point: &Point) -> String {
    match (point.detection, point.detection_interval) {
        (Some(share), Some((low, high))) => {
            format!("{:.1} [{:.1}, {:.1}] %", 100.0 * share, 100.0 * low, 100.0 * high)
        }
        _ => "—".into(),
    }
}

fn delay(point: &Point) -> String {
    let (Some(median), Some(low), Some(high)) = (point.delay_median_s, point.delay_5_s, point.delay_95_s) else {
        return "—".into();
    };
    let ms = |seconds: f64| show(Some(seconds), Unit::Second).trim_end_matches(" ms").to_owned();
    format!("{} [{}, {}] ms", ms(median), ms(low), ms(high))
}

/// Returns a rate without meaningless digits.
fn short(rate: f64) -> String {
    if rate >= 100.0 { format!("{rate:.0}") } else { format!("{rate:.2}") }
}

/// Returns the false alarms per hour, or their upper bound without a false alarm.
fn short_rate(point: &Point) -> String {
    match (point.false_alarms_per_minute, point.false_alarms_per_minute_interval) {
        (Some(rate), _) => format!("{}/h", short(60.0 * rate)),
        (None, Some((_, high))) => format!("< {}/h", short(60.0 * high)),
        (None, None) => "—".into(),
    }
}

/// Returns the false alarms per hour with their interval, or their upper bound without a false alarm.
fn rate(point: &Point) -> String {
    let Some((low, high)) = point.false_alarms_per_minute_interval else { return "—".into() };
    match point.false_alarms_per_minute {
        None => format!("< {}/h", short(60.0 * high)),
        Some(rate) => format!("{} [{}, {}]/h", short(60.0 * rate), short(60.0 * low), short(60.0 * high)),
    }
}

/// Returns `roc.csv`: a row per condition, detector and threshold, first over all conditions. An undefined value is an empty
/// cell.
#[must_use]
pub fn roc_csv(roc: &Characteristics) -> String {
    let mut text = "signal,noise_std_n,drop_n,sharpness_s,depth_m,detector,unit,threshold,drift,cases,clean_cases,ruptures,\
                    detected,late,detection,detection_low,detection_high,delay_median_s,delay_5_s,delay_95_s,\
                    false_alarms,hours,false_alarms_per_minute,false_alarms_per_minute_low,false_alarms_per_minute_high\n"
        .to_owned();
    rows(&mut text, "all,,,,", &roc.all);
    let cell = |value: Option<f64>| value.map_or(String::new(), shortest);
    for condition in &roc.conditions {
        let Condition { signal, noise_std_n, drop_n, sharpness_s, depth_m, curves } = condition;
        let varied = [*drop_n, *sharpness_s, *depth_m].map(cell).join(",");
        rows(&mut text, &format!("{},{},{varied}", quoted(signal), shortest(*noise_std_n)), curves);
    }
    text
}

fn rows(text: &mut String, condition: &str, curves: &[Curve]) {
    for curve in curves {
        for point in &curve.points {
            let (low, high) = point.detection_interval.unzip();
            let (rate_low, rate_high) = point.false_alarms_per_minute_interval.unzip();
            let detection = [point.detection, low, high, point.delay_median_s, point.delay_5_s, point.delay_95_s];
            let rates = [point.false_alarms_per_minute, rate_low, rate_high];
            let join = |values: &[Option<f64>]| {
                let cells: Vec<String> = values.iter().map(|value| value.map_or(String::new(), shortest)).collect();
                cells.join(",")
            };
            let _ = writeln!(
                text,
                "{condition},{},{},{},{},{},{},{},{},{},{},{},{},{}",
                curve.detector,
                curve.unit,
                shortest(point.threshold),
                shortest(curve.drift),
                point.cases,
                point.clean_cases,
                point.ruptures,
                point.detected,
                point.late,
                join(&detection),
                point.false_alarms,
                shortest(point.hours),
                join(&rates),
            );
        }
    }
}

/// Returns `roc.json`: the settings and the characteristics.
#[must_use]
pub fn roc_json(roc: &Characteristics, seeds: u64) -> String {
    super::json::render(&json!({
        "trocar_version": env!("CARGO_PKG_VERSION"),
        "seeds": seeds,
        "stopped": roc.cases < roc.cases_planned,
        "warnings": roc.warnings(),
        "characteristics": roc,
    }))
}

/// Writes the figure `roc`: for each detector the best detection and delay against the false-alarm rate, over all conditions.
///
/// # Errors
/// [`PictureError`].
pub fn roc_picture(folder: &Folder, roc: &Characteristics) -> Result<(), PictureError> {
    let views: Vec<CharacteristicView<'_>> = roc
        .all
        .iter()
        .map(|curve| {
            let front = curve.front();
            CharacteristicView {
                name: curve.detector,
                false_alarms_per_minute: front.iter().map(|p| p.false_alarms_per_minute.unwrap_or(0.0)).collect(),
                detection: front.iter().map(|p| p.detection.unwrap_or(f64::NAN)).collect(),
                delay_median_s: front.iter().map(|p| p.delay_median_s.unwrap_or(f64::NAN)).collect(),
            }
        })
        .collect();
    let hours = roc.all.first().and_then(|curve| curve.points.first()).map_or(0.0, |point| point.hours);
    let min_per_minute = if hours > 0.0 { 1.0 / (60.0 * hours) } else { 1.0 };
    let mut names: Vec<&str> = roc.conditions.iter().map(|condition| condition.signal.as_str()).collect();
    names.dedup();
    let figure = figures::characteristic(&names.join(", "), &views, min_per_minute)?;
    keep(folder, "roc", &figure)
}
