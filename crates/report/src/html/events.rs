//! Events on a timeline and in a table.

use serde::Serialize;

use trocar_document::figure::Shade;
use trocar_document::figure::{Axis, X_TICKS};
use trocar_document::significant;

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
