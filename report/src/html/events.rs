//! Events on a line of time, and what they were.

use serde::Serialize;

use super::chart::{ChartShade, Mark};
use super::digits::Fine;
use crate::Table;
use crate::number::{show, significant};
use trocar_sim::engine::Trace;
use trocar_sim::metrics::Unit;
use trocar_sim::run::Run;

/// Marks on the line of time, and captions, at most: a page has an end.
const MAX_MARKS: usize = 200;

/// Lanes over one axis of time.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Timeline {
    /// For those who do not see it.
    pub(super) alt: String,
    pub(super) ticks: Vec<Tick>,
    pub(super) lanes: Vec<Lane>,
    /// What shades and marks mean: their class, and the words.
    pub(super) key: Vec<(&'static str, &'static str)>,
}

/// A number on the axis.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Tick {
    /// Where, in per cent of the width.
    pub(super) at: String,
    pub(super) label: String,
}

/// What happened in one run.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Lane {
    pub(super) name: String,
    pub(super) shades: Vec<Bar>,
    pub(super) marks: Vec<Point>,
}

/// An interval.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Bar {
    pub(super) at: String,
    pub(super) width: String,
    pub(super) name: &'static str,
    pub(super) title: String,
}

/// An instant.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Point {
    pub(super) at: String,
    pub(super) kind: &'static str,
    pub(super) title: String,
}

/// What a lane is made of, in s.
#[derive(Clone, Debug)]
pub(super) struct Happenings {
    pub(super) name: String,
    pub(super) shades: Vec<ChartShade>,
    pub(super) marks: Vec<Mark>,
}

impl Timeline {
    /// Lanes from `from_s` to `to_s`.
    pub(super) fn of(lanes: &[Happenings], (from_s, to_s): (f64, f64), key: Vec<(&'static str, &'static str)>) -> Self {
        let span = if to_s > from_s { to_s - from_s } else { 1.0 };
        let share = |time_s: f64| format!("{:.3}", (100.0 * (time_s - from_s) / span).clamp(0.0, 100.0));
        let seconds = |time_s: f64| format!("{time_s:.3} s");
        let lane = |lane: &Happenings| Lane {
            name: lane.name.clone(),
            shades: lane
                .shades
                .iter()
                .take(MAX_MARKS)
                .map(|shade| Bar {
                    at: share(shade.from.0),
                    width: share(from_s + shade.to.0 - shade.from.0),
                    name: shade.name,
                    title: format!("{}, {} to {}", shade.name, seconds(shade.from.0), seconds(shade.to.0)),
                })
                .collect(),
            marks: lane
                .marks
                .iter()
                .take(MAX_MARKS)
                .map(|mark| Point {
                    at: share(mark.at.0),
                    kind: mark.kind,
                    title: format!("{}, {}", mark.label, seconds(mark.at.0)),
                })
                .collect(),
        };
        let count = |kind: &str| lanes.iter().flat_map(|lane| &lane.marks).filter(|mark| mark.kind == kind).count();
        Self {
            alt: format!(
                "{} ruptures and {} alarms between {} and {}; the table has the times",
                count("rupture"),
                count("alarm"),
                seconds(from_s),
                seconds(to_s)
            ),
            ticks: round_steps(from_s, to_s)
                .map(|time_s| Tick { at: share(time_s), label: significant_plain(time_s) })
                .collect(),
            lanes: lanes.iter().map(lane).collect(),
            key,
        }
    }
}

/// Round numbers between two, about six of them.
fn round_steps(from: f64, to: f64) -> impl Iterator<Item = f64> {
    let wanted = ((to - from) / 6.0).max(1e-9);
    let power = 10.0_f64.powf(wanted.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|round| round * power).into_iter().find(|step| *step >= wanted);
    let step = step.unwrap_or(wanted);
    let first = (from / step).ceil();
    (0..20).map(move |k| (first + f64::from(k)) * step).take_while(move |at| *at <= to + 1e-9 * step)
}

/// Without digits that say nothing.
fn significant_plain(value: f64) -> String {
    let text = format!("{value:.4}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text.is_empty() || text == "-0" { "0".into() } else { text.to_owned() }
}

/// The intervals in which a trace is frozen or finding back.
pub(super) fn modes(trace: &Trace) -> Vec<ChartShade> {
    let mut shades = vec![];
    let mut start = 0;
    for same in trace.mode.chunk_by(|a, b| a == b) {
        let end = (start + same.len()).min(trace.time_s.len().saturating_sub(1));
        let name = match same[0] {
            1 => Some("augmented"),
            2 => Some("reengaging"),
            _ => None,
        };
        if let Some(name) = name {
            shades.push(ChartShade { from: Fine(trace.time_s[start]), to: Fine(trace.time_s[end]), name });
        }
        start += same.len();
    }
    shades
}

/// What happened in a run, in order of time.
pub(super) fn happenings(run: &Run) -> Happenings {
    let ruptures = run.metrics.ruptures.iter().enumerate().map(|(index, rupture)| Mark {
        at: Fine(rupture.time_s),
        kind: "rupture",
        label: format!("rupture {}", index + 1),
    });
    let alarms = run.metrics.alarms.iter().map(|alarm| Mark {
        at: Fine(alarm.time_s),
        kind: "alarm",
        label: if alarm.matched { "alarm".into() } else { "false alarm".into() },
    });
    let mut marks: Vec<Mark> = ruptures.chain(alarms).collect();
    marks.sort_by(|a, b| a.at.0.total_cmp(&b.at.0));
    Happenings { name: run.scenario.name.clone(), shades: modes(&run.trace), marks }
}

/// What marks and shades of runs mean.
pub(super) const RUN_KEY: [(&str, &str); 4] = [
    ("rupture", "a layer gives way"),
    ("alarm", "alarm"),
    ("augmented", "frozen, the felt drop exaggerated"),
    ("reengaging", "finding back to the hand"),
];

/// The events of runs: what happened when, and what came of it.
pub(super) fn events_table(runs: &[&Run]) -> Table {
    let mut table = Table::new(["time", "scenario", "event", "what came of it"]).flush_left();
    let mut rows: Vec<(f64, [String; 3])> = vec![];
    for run in runs {
        let mut add = |time_s: f64, event: String, outcome: String| {
            rows.push((time_s, [run.scenario.name.clone(), event, outcome]));
        };
        let ms = |seconds| show(Some(seconds), Unit::Second);
        let mm = |metres| show(Some(metres), Unit::Metre);
        for (index, rupture) in run.metrics.ruptures.iter().enumerate() {
            let found = rupture.detection_delay_s.map_or("missed".into(), |s| format!("detected after {}", ms(s)));
            let lurch = rupture.slave_overshoot_m.map_or(String::new(), |m| format!(", the needle lurches {}", mm(m)));
            add(rupture.time_s, format!("rupture {}", index + 1), format!("{found}{lurch}"));
        }
        for alarm in &run.metrics.alarms {
            let outcome = if alarm.matched { "announces a rupture" } else { "announces none: a false alarm" };
            add(alarm.time_s, "alarm".into(), outcome.into());
        }
        for event in &run.metrics.events {
            let moved = format!("the needle moves {} at most", mm(event.frozen_motion_m));
            let lasted = event.augmented_s.map_or("to the end".into(), |s| format!("for {}", ms(s)));
            add(event.start_s, "frozen".into(), format!("{lasted}, {moved}"));
            let Some(augmented_s) = event.augmented_s else { continue };
            let took = event.reengaging_s.map_or("not done at the end".into(), |s| format!("takes {}", ms(s)));
            add(event.start_s + augmented_s, "re-engaging".into(), took);
            if let Some(reengaging_s) = event.reengaging_s {
                add(event.start_s + augmented_s + reengaging_s, "re-engaged".into(), "follows the hand again".into());
            }
        }
    }
    rows.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (time_s, cells) in rows {
        table.row([vec![format!("{time_s:.3} s")], cells.to_vec()].concat());
    }
    table
}

/// The times around events that are shown in more detail, in s.
pub(super) fn close(marks: &[Mark]) -> Vec<(f64, f64)> {
    const BEFORE_S: f64 = 0.1;
    const AFTER_S: f64 = 0.6;
    marks.iter().take(MAX_MARKS).map(|mark| (mark.at.0 - BEFORE_S, mark.at.0 + AFTER_S)).collect()
}

/// How long, in a word.
pub(super) fn lasted(seconds: f64) -> String {
    format!("{} s", significant(seconds))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_round_and_within() {
        assert_eq!(round_steps(0.0, 17.0).collect::<Vec<_>>(), [0.0, 5.0, 10.0, 15.0]);
        assert_eq!(round_steps(1.2, 1.9).map(significant_plain).collect::<Vec<_>>(), ["1.2", "1.4", "1.6", "1.8"]);
    }

    #[test]
    fn what_happens_lies_where_its_time_is() {
        let marks = vec![Mark { at: Fine(2.5), kind: "alarm", label: "alarm".into() }];
        let shades = vec![ChartShade { from: Fine(2.5), to: Fine(3.0), name: "augmented" }];
        let lane = Happenings { name: "a".into(), shades, marks };
        let timeline = Timeline::of(&[lane], (0.0, 10.0), RUN_KEY.to_vec());
        let drawn = &timeline.lanes[0];
        assert_eq!((drawn.shades[0].at.as_str(), drawn.shades[0].width.as_str()), ("25.000", "5.000"));
        assert_eq!(drawn.marks[0].at, "25.000");
        assert!(timeline.alt.starts_with("0 ruptures and 1 alarms between 0.000 s and 10.000 s"));
    }
}
