//! Events on a timeline and in a table.

use serde::Serialize;

use crate::Table;
use crate::figures::description::{Axis, X_TICKS};
use crate::figures::{Shade, modes};
use trocar_document::{show, significant};
use trocar_metrics::{RuptureMetrics, Unit};
use trocar_studies::run::Run;

/// Maximum number of marks and of shades on the timeline.
const MAX_MARKS: usize = 200;

/// Lanes over one time axis.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Timeline {
    /// Text alternative for screen readers.
    pub(super) alt: String,
    pub(super) ticks: Vec<Tick>,
    pub(super) lanes: Vec<EventRow>,
    /// The name of a rupture.
    pub(super) rupture: &'static str,
    /// The key of the shades: the colour of each and its name.
    pub(super) key: Vec<(String, &'static str)>,
}

/// A tick of the axis.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Tick {
    /// Position in per cent of the width.
    pub(super) at: String,
    pub(super) label: String,
}

/// The events of one run or recording.
#[derive(Clone, Debug, Serialize)]
pub(super) struct EventRow {
    pub(super) name: String,
    pub(super) shades: Vec<Bar>,
    pub(super) marks: Vec<Point>,
}

/// A shaded interval.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Bar {
    pub(super) at: String,
    pub(super) width: String,
    pub(super) color: String,
    pub(super) title: String,
}

/// A mark.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Point {
    pub(super) at: String,
    pub(super) kind: &'static str,
    pub(super) title: String,
}

/// A rupture or an alarm.
#[derive(Clone, Debug)]
pub(super) struct Mark {
    pub(super) at_s: f64,
    /// `rupture` or `alarm`.
    pub(super) kind: &'static str,
    pub(super) label: String,
    /// What became of it.
    pub(super) fate: String,
}

/// The events of a lane. Times are in s.
#[derive(Clone, Debug)]
pub(super) struct LaneEvents {
    pub(super) name: String,
    pub(super) shades: Vec<(f64, f64, Shade)>,
    pub(super) marks: Vec<Mark>,
}

impl Timeline {
    /// Returns the timeline of lanes from `from_s` to `to_s`.
    pub(super) fn of(lanes: &[LaneEvents], (from_s, to_s): (f64, f64), rupture: &'static str) -> Self {
        let mut shades: Vec<Shade> = vec![];
        for (.., shade) in lanes.iter().flat_map(|lane| &lane.shades) {
            if !shades.contains(shade) {
                shades.push(*shade);
            }
        }
        let span = if to_s > from_s { to_s - from_s } else { 1.0 };
        let share = |time_s: f64| format!("{:.3}", (100.0 * (time_s - from_s) / span).clamp(0.0, 100.0));
        let at_s = |time_s: f64| format!("{time_s:.3} s");
        let lane = |lane: &LaneEvents| EventRow {
            name: lane.name.clone(),
            shades: lane
                .shades
                .iter()
                .take(MAX_MARKS)
                .map(|&(from, to, shade)| Bar {
                    at: share(from),
                    width: share(from_s + to - from),
                    color: shade.css(),
                    title: format!("{}, {} to {}", shade.name(), at_s(from), at_s(to)),
                })
                .collect(),
            marks: lane
                .marks
                .iter()
                .take(MAX_MARKS)
                .map(|mark| Point {
                    at: share(mark.at_s),
                    kind: mark.kind,
                    title: [format!("{}, {}", mark.label, at_s(mark.at_s)), mark.fate.clone()]
                        .join(if mark.fate.is_empty() { "" } else { ": " }),
                })
                .collect(),
        };
        let count = |kind: &str| lanes.iter().flat_map(|lane| &lane.marks).filter(|mark| mark.kind == kind).count();
        Self {
            alt: format!(
                "{} ruptures and {} alarms between {} and {}; the table lists the times",
                count("rupture"),
                count("alarm"),
                at_s(from_s),
                at_s(to_s)
            ),
            ticks: Axis::exact((from_s, to_s), X_TICKS)
                .all_ticks()
                .into_iter()
                .map(|(time_s, label)| Tick { at: share(time_s), label })
                .collect(),
            lanes: lanes.iter().map(lane).collect(),
            rupture,
            key: shades.into_iter().map(|shade| (shade.css(), shade.name())).collect(),
        }
    }
}

/// Returns the name of a rupture: its number and the layer.
fn named(index: usize, rupture: &RuptureMetrics) -> String {
    let layer = rupture.layer.as_ref().map_or(String::new(), |layer| format!(" ({layer})"));
    format!("rupture {}{layer}", index + 1)
}

/// Returns what became of a rupture: its delay, or why it was missed.
fn fate(rupture: &RuptureMetrics) -> String {
    match (rupture.detection_delay_s, &rupture.miss) {
        (Some(delay_s), _) => format!("detected after {}", show(Some(delay_s), Unit::Second)),
        (None, Some(miss)) => format!("missed: {miss}"),
        (None, None) => "the run ends too soon to decide".into(),
    }
}

/// Returns the events of a run, in order of time.
pub(super) fn of_run(run: &Run) -> LaneEvents {
    let ruptures = run.metrics.ruptures.iter().enumerate().map(|(index, rupture)| Mark {
        at_s: rupture.time_s,
        kind: "rupture",
        label: named(index, rupture),
        fate: fate(rupture),
    });
    let alarms = run.metrics.alarms.iter().map(|alarm| Mark {
        at_s: alarm.time_s,
        kind: "alarm",
        label: if alarm.matched { "alarm".into() } else { "false alarm".into() },
        fate: String::new(),
    });
    let mut marks: Vec<Mark> = ruptures.chain(alarms).collect();
    marks.sort_by(|a, b| a.at_s.total_cmp(&b.at_s));
    LaneEvents { name: run.scenario.name.clone(), shades: modes(&run.trace.time_s, &run.trace.mode), marks }
}

/// Returns the events of runs in order of time, each with its outcome.
pub(super) fn events_table(runs: &[&Run]) -> Table {
    let mut table = Table::new(["time", "scenario", "event", "outcome"]).flush_left();
    let mut rows: Vec<(f64, [String; 3])> = vec![];
    for run in runs {
        let mut add = |time_s: f64, event: String, outcome: String| {
            rows.push((time_s, [run.scenario.name.clone(), event, outcome]));
        };
        let ms = |seconds| show(Some(seconds), Unit::Second);
        let mm = |metres| show(Some(metres), Unit::Metre);
        for (index, rupture) in run.metrics.ruptures.iter().enumerate() {
            let excess = rupture.excess_advance_m.map_or(String::new(), |m| format!(", excess advance {}", mm(m)));
            let noticed = match (rupture.noticed, rupture.noticed_after_s) {
                (Some(_), Some(seconds)) => format!(", noticed after {}", ms(seconds)),
                (Some(_), None) => ", not noticed".to_owned(),
                (None, _) => String::new(),
            };
            add(rupture.time_s, named(index, rupture), format!("{}{excess}{noticed}", fate(rupture)));
        }
        for alarm in &run.metrics.alarms {
            let outcome = if alarm.matched { "matches a rupture" } else { "false alarm" };
            add(alarm.time_s, "alarm".into(), outcome.into());
        }
        for event in &run.metrics.events {
            let motion = format!("the slave moves at most {}", mm(event.frozen_motion_m));
            let duration = event.augmented_s.map_or("until the end".into(), |s| format!("for {}", ms(s)));
            add(event.start_s, "frozen".into(), format!("{duration}, {motion}"));
            let Some(augmented_s) = event.augmented_s else { continue };
            let duration = event.reengaging_s.map_or("until the end".into(), |s| format!("for {}", ms(s)));
            add(event.start_s + augmented_s, "re-engaging".into(), duration);
            if let Some(reengaging_s) = event.reengaging_s {
                add(event.start_s + augmented_s + reengaging_s, "re-engaged".into(), "teleoperation".into());
            }
        }
    }
    rows.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (time_s, cells) in rows {
        table.row([vec![format!("{time_s:.3} s")], cells.to_vec()].concat());
    }
    table
}

/// Returns a duration as text.
pub(super) fn seconds(seconds: f64) -> String {
    format!("{} s", significant(seconds))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn events_lie_at_their_times() {
        let marks = vec![Mark { at_s: 2.5, kind: "alarm", label: "alarm".into(), fate: "late".into() }];
        let shades = vec![(2.5, 3.0, Shade::Frozen)];
        let lane = LaneEvents { name: "a".into(), shades, marks };
        let timeline = Timeline::of(&[lane], (0.0, 10.0), "rupture");
        let drawn = &timeline.lanes[0];
        assert_eq!((drawn.shades[0].at.as_str(), drawn.shades[0].width.as_str()), ("25.000", "5.000"));
        assert_eq!((drawn.marks[0].at.as_str(), drawn.marks[0].title.as_str()), ("25.000", "alarm, 2.500 s: late"));
        assert_eq!(
            timeline.ticks.iter().map(|tick| tick.at.as_str()).collect::<Vec<_>>(),
            ["0.000", "20.000", "40.000", "60.000", "80.000", "100.000"]
        );
        assert!(timeline.alt.starts_with("0 ruptures and 1 alarms between 0.000 s and 10.000 s"));
    }
}
