use super::{EstimationView, RunView};
use trocar_document::figure::{Entry, Events, Sample, Shade, extent, union};

/// The intervals of events, shaded as `event`, and the intervals of re-engaging.
pub fn modes(time_s: &[f64], mode: &[u8], event: Shade) -> Vec<(f64, f64, Shade)> {
    let mut shades = Vec::new();
    let mut start = 0;
    for same in mode.chunk_by(|a, b| a == b) {
        let end = (start + same.len()).min(mode.len() - 1);
        let shade = match same[0] {
            1 => Some(event),
            2 => Some(Shade::Reengaging),
            _ => None,
        };
        shades.extend(shade.map(|shade| (time_s[start], time_s[end], shade)));
        start += same.len();
    }
    shades
}

const BEFORE_S: f64 = 0.4;
const AFTER_S: f64 = 1.6;

pub(super) fn of_run(run: &RunView<'_>) -> Events {
    let shades = modes(run.time_s, run.mode, run.event);
    Events { shades, ruptures: run.rupture_times_s.to_vec(), alarms: run.alarm_times_s.to_vec() }
}

pub(super) fn of_estimation(view: &EstimationView<'_>) -> Events {
    Events { shades: Vec::new(), ruptures: view.rupture_times_s.to_vec(), alarms: view.alarm_times_s.to_vec() }
}

pub(super) fn window(runs: &[RunView<'_>], requested: Option<(f64, f64)>) -> (f64, f64) {
    let record =
        runs.iter().fold(None, |all, run| union(all, extent(run.time_s.iter().copied()))).unwrap_or((0.0, 1.0));
    if let Some((from, to)) = requested
        && from.is_finite()
        && to.is_finite()
        && from < to
    {
        return (from, to);
    }
    let first = runs
        .iter()
        .flat_map(|run| run.rupture_times_s.iter())
        .copied()
        .filter(|time| (record.0..=record.1).contains(time))
        .min_by(f64::total_cmp);
    first.map_or(record, |time| ((time - BEFORE_S).max(record.0), (time + AFTER_S).min(record.1)))
}

pub(super) fn entries(events: &[&Events], window: (f64, f64)) -> Vec<Entry> {
    let inside = |time: &f64| (window.0..=window.1).contains(time);
    let mut entries = Vec::new();
    for shade in Shade::ALL {
        let shown = |s: &(f64, f64, _)| s.2 == shade && s.0 < window.1 && s.1 > window.0;
        if events.iter().any(|e| e.shades.iter().any(shown)) {
            entries.push((Sample::Shade(shade.color()), shade.name().to_owned()));
        }
    }
    if events.iter().any(|e| e.ruptures.iter().any(inside)) {
        entries.push((Sample::Rupture, String::from("rupture")));
    }
    if events.iter().any(|e| e.alarms.iter().any(inside)) {
        entries.push((Sample::Alarm, String::from("alarm")));
    }
    entries
}
