//! Which instants and intervals a figure marks, and how its legend names them.

use super::grid::{Entry, Sample};
use super::panel::Events;
use super::style::shade;
use super::{EstimationView, RunView};

/// Time shown before and after the first rupture, in seconds.
const BEFORE: f64 = 0.4;
const AFTER: f64 = 1.6;

/// The intervals of a run in which a mode is on, as shades.
pub(super) fn of_run(run: &RunView<'_>) -> Events {
    let mut shades = Vec::new();
    let mut start = 0;
    while start < run.mode.len() {
        let mode = run.mode[start];
        let length = run.mode[start..].iter().take_while(|&&m| m == mode).count();
        let end = (start + length).min(run.mode.len() - 1);
        if let Some(color) = shade(mode) {
            shades.push((run.time_s[start], run.time_s[end], color));
        }
        start += length;
    }
    Events { shades, ruptures: run.rupture_times_s.to_vec(), alarms: run.alarm_times_s.to_vec() }
}

/// The events of an estimation: no modes.
pub(super) fn of_estimation(view: &EstimationView<'_>) -> Events {
    Events { shades: Vec::new(), ruptures: view.rupture_times_s.to_vec(), alarms: view.alarm_times_s.to_vec() }
}

/// The window asked for, or the one around the first rupture, or the whole record.
pub(super) fn window(runs: &[RunView<'_>], asked: Option<(f64, f64)>) -> (f64, f64) {
    let record = runs
        .iter()
        .fold(None, |all, run| super::axis::union(all, super::axis::extent(run.time_s.iter().copied())))
        .unwrap_or((0.0, 1.0));
    if let Some((from, to)) = asked
        && from.is_finite()
        && to.is_finite()
        && from < to
    {
        return (from, to);
    }
    let first = runs
        .iter()
        .flat_map(|run| run.rupture_times_s)
        .copied()
        .filter(|time| (record.0..=record.1).contains(time))
        .min_by(f64::total_cmp);
    first.map_or(record, |time| ((time - BEFORE).max(record.0), (time + AFTER).min(record.1)))
}

/// Legend entries for what `events` show inside `window`, and for nothing else.
pub(super) fn entries(events: &[&Events], window: (f64, f64)) -> Vec<Entry> {
    let inside = |time: &f64| (window.0..=window.1).contains(time);
    let mut entries = Vec::new();
    for (mode, name) in [(1, "augmentation"), (2, "re-engagement")] {
        let Some(color) = shade(mode) else { continue };
        let shown = |s: &(f64, f64, _)| s.2 == color && s.0 < window.1 && s.1 > window.0;
        if events.iter().any(|e| e.shades.iter().any(shown)) {
            entries.push((Sample::Shade(color), name.to_owned()));
        }
    }
    if events.iter().any(|e| e.ruptures.iter().any(inside)) {
        entries.push((Sample::Rupture, String::from("rupture")));
    }
    if events.iter().any(|e| e.alarms.iter().any(inside)) {
        entries.push((Sample::Alarm, String::from("detection")));
    }
    entries
}
