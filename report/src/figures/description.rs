//! A figure as data, from which other programs draw it: the Python package with matplotlib.

use serde_json::{Value as Json, json};

use super::axis::Axis;
use super::figure::Figure;
use super::legend::{Entry, Sample};
use super::panel::{Panel, RESOLVED};
use super::style::{Color, Stroke};

fn color(Color(red, green, blue): Color) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}

fn stroke(stroke: &Stroke) -> Json {
    json!({ "color": color(stroke.color), "width": stroke.width, "dashes": stroke.dashes })
}

fn entry((sample, text): &Entry) -> Json {
    let (kind, style) = match sample {
        Sample::Title => ("title", Json::Null),
        Sample::Line(line) => ("line", stroke(line)),
        Sample::Dot(dot) => ("dot", stroke(dot)),
        Sample::Ring(ring) => ("ring", stroke(ring)),
        Sample::Shade(shade) => ("shade", json!({ "color": color(*shade) })),
        Sample::Alarm => ("alarm", Json::Null),
        Sample::Rupture => ("rupture", Json::Null),
    };
    json!({ "kind": kind, "style": style, "text": text })
}

/// Splits points into the columns x and y. A place that is not finite is `null`, a gap.
fn columns(points: impl IntoIterator<Item = (f64, f64)>) -> [Vec<f64>; 2] {
    let (x, y) = points.into_iter().unzip();
    [x, y]
}

fn axis(axis: &Axis, caption: &str) -> Json {
    json!({ "low": axis.low, "high": axis.high, "log": axis.log, "has_ticks": axis.has_ticks(), "caption": caption })
}

fn panel(panel: &Panel<'_>) -> Json {
    let events = &panel.events;
    json!({
        "x": axis(&panel.x, &panel.x_caption),
        "y": axis(&panel.y, &panel.y_caption),
        "legend": panel.legend.iter().map(entry).collect::<Vec<_>>(),
        "shades": events.shades.iter().map(|(from, to, shade)| json!([from, to, color(*shade)])).collect::<Vec<_>>(),
        "ruptures": events.ruptures,
        "alarms": events.alarms,
        "fills": panel.fills.iter().map(|(outline, fill)| {
            json!({ "points": columns(outline.iter().copied()), "color": color(*fill) })
        }).collect::<Vec<_>>(),
        "lines": panel.traces.iter().map(|trace| {
            json!({ "points": columns(panel.samples(trace, RESOLVED)), "style": stroke(&trace.stroke) })
        }).chain(panel.curves.iter().map(|(points, line)| {
            json!({ "points": columns(points.iter().copied()), "style": stroke(line) })
        })).collect::<Vec<_>>(),
        "levels": panel.levels.iter().map(|(level, line)| {
            json!({ "at": panel.y.place(*level), "style": stroke(line) })
        }).collect::<Vec<_>>(),
        "notes": panel.notes.iter().map(|((x, y), text)| json!([x, y, text])).collect::<Vec<_>>(),
        "is_bare": panel.is_bare,
    })
}

impl Figure<'_> {
    /// The figure as data: `name`, `legend`, and `rows` of `panels` with their axes, lines, fills, levels, notes and events. Places are
    /// in the coordinates of the axes, which are exponents of ten for a logarithmic one. A line with one point is a dot; `null` is a
    /// gap. Long lines are reduced to the minima and maxima of 5000 intervals.
    #[must_use]
    pub fn description(&self) -> Json {
        let row = |row: &super::figure::Row<'_>| {
            json!({
                "title": row.title,
                "height": row.height,
                "panels": row.panels.iter().map(panel).collect::<Vec<_>>(),
            })
        };
        json!({
            "name": self.name,
            "legend": self.legend.iter().map(entry).collect::<Vec<_>>(),
            "rows": self.rows.iter().map(row).collect::<Vec<_>>(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::{EstimationView, parameters};

    #[test]
    fn a_description_has_the_data_of_the_figure() {
        let time_s: Vec<f64> = (0..2000).map(|k| 1e-3 * f64::from(k)).collect();
        let stiffness: Vec<f64> = time_s.iter().map(|time_s| 200.0 + 50.0 * (3.0 * time_s).sin()).collect();
        let (zero, one) = (vec![0.0; 2000], vec![1.0; 2000]);
        let view = EstimationView {
            name: "a run",
            time_s: &time_s,
            measured_force_n: &zero,
            residual_n: &zero,
            stiffness_n_per_m: &stiffness,
            damping_n_s_per_m: &one,
            standard_errors: Some([&one, &one]),
            extra_parameter: None,
            decision: &zero,
            threshold: 1.0,
            decision_unit: "",
            rupture_times_s: &[0.5],
            alarm_times_s: &[0.52],
        };
        let description = parameters(&view).expect("a figure").description();
        assert_eq!(description["name"], "a run");
        let panel = &description["rows"][0]["panels"][0];
        assert_eq!(
            (panel["y"]["caption"].as_str(), panel["x"]["log"].as_bool()),
            (Some("Stiffness (N/m)"), Some(false))
        );
        assert_eq!((panel["ruptures"][0].as_f64(), panel["alarms"][0].as_f64()), (Some(0.5), Some(0.52)));
        assert!(panel["fills"][0]["color"].as_str().is_some_and(|color| color.starts_with('#') && color.len() == 7));
        // Fewer samples than intervals: all are there.
        let [x, y] = [0, 1].map(|k| panel["lines"][0]["points"][k].as_array().expect("a column"));
        assert_eq!((x.len(), y.len()), (2000, 2000));
        assert!(y.iter().zip(&stiffness).all(|(drawn, value)| drawn.as_f64() == Some(*value)));
    }
}
