//! Detection probability and delay over the false-alarm rate.

use super::FigureError;
use trocar_document::counted;
use trocar_document::figure::{Axis, Figure, LINES, Panel, Point, Row, Sample, Series, Stroke, Y_TICKS};

const LABEL_HEIGHT: f64 = 0.1;

const PER_HOUR: f64 = 60.0;

/// A detector's points in order of the false-alarm rate. All columns have the same length.
#[derive(Clone, Debug)]
pub struct CharacteristicView<'a> {
    pub name: &'a str,
    /// False alarms per minute. A rate of 0 is drawn on the left edge.
    pub false_alarms_per_minute: Vec<f64>,
    /// Share of detected ruptures, 0 to 1; NaN if undefined.
    pub detection: Vec<f64>,
    /// Median delay in s; NaN if undefined.
    pub delay_median_s: Vec<f64>,
}

/// Draws the share of missed or late ruptures (above) and the median delay (below) over the false-alarm rate.
///
/// `min_per_minute` is the rate of a single false alarm in the whole observed time; the left edge is half of it.
pub fn characteristic(
    name: &str,
    views: &[CharacteristicView<'_>],
    min_per_minute: f64,
) -> Result<Figure<'static>, FigureError> {
    for view in views {
        let columns = [("detection", view.detection.len()), ("delay_median_s", view.delay_median_s.len())];
        super::check("characteristic", view.name, view.false_alarms_per_minute.len(), &columns)?;
    }
    if views.is_empty() {
        return Err(FigureError::Empty { figure: "characteristic" });
    }
    let floor = 0.5 * PER_HOUR * min_per_minute;
    let rates = || views.iter().flat_map(|view| view.false_alarms_per_minute.iter().map(|rate| PER_HOUR * rate));
    let highest = rates().filter(|rate| rate.is_finite()).fold(10.0 * floor, f64::max);
    let x_axis = Axis::log10((floor, 1.5 * highest));
    let places: Vec<Vec<f64>> = views
        .iter()
        .map(|view| {
            let places: Vec<f64> =
                view.false_alarms_per_minute.iter().map(|rate| x_axis.place((PER_HOUR * rate).max(floor))).collect();
            // Each step has a point at its start (except the first) and its end. The last ends at the edge.
            places
                .iter()
                .skip(1)
                .flat_map(|place| [*place; 2])
                .fold(places.first().copied().into_iter().collect(), push)
        })
        .map(|places: Vec<f64>| push(places, x_axis.high))
        .collect();
    let delays = views.iter().flat_map(|view| view.delay_median_s.iter().copied());
    let longest = delays.filter(|delay| delay.is_finite()).fold(0.0, f64::max);
    let panel = |y: Axis, y_caption: &str, series| Panel {
        series,
        ..Panel::new(x_axis.clone(), "False-alarm rate (1/h; left edge: no false alarm)", y, y_caption)
    };
    // Misses on a logarithmic axis, because detections hardly differ. The lower edge is half of the smallest share
    // above 0.
    let missed = |view: &CharacteristicView<'_>| view.detection.iter().map(|found| 1.0 - found).collect::<Vec<_>>();
    let shares = views.iter().flat_map(missed).filter(|share| *share > 1e-9);
    let least = 50.0 * shares.fold(1.0, f64::min);
    let raised = |share: f64| if share < 0.01 * least { 0.01 * least } else { share };
    let misses = views.iter().map(|view| twice(&missed(view)).into_iter().map(raised).collect());
    let detected = lines(&places, misses, 100.0);
    let delays = lines(&places, views.iter().map(|view| twice(&view.delay_median_s)), 1e3);
    let mut detection = panel(Axis::log10((least, 110.0)), "Missed or late (%; lower edge: none)", detected);
    let mut delay = panel(Axis::from_zero(1e3 * longest, Y_TICKS), "Median delay (ms)", delays);
    let names: Vec<&str> = views.iter().map(|view| view.name).collect();
    for panel in [&mut detection, &mut delay] {
        panel.notes = labels(panel, &names);
    }
    let legend = views.iter().zip(strokes()).map(|(view, line)| (Sample::Line(line), view.name.to_owned()));
    // Draw thin lines over wide ones, so that both are visible where detectors agree.
    for panel in [&mut detection, &mut delay] {
        panel.series.sort_by(|a, b| b.stroke.width.total_cmp(&a.stroke.width));
    }
    Ok(Figure {
        name: name.to_owned(),
        legend: legend.collect(),
        rows: vec![Row::of(165.0, detection), Row::of(115.0, delay)],
    })
}

fn strokes() -> impl Iterator<Item = Stroke> {
    LINES.into_iter().cycle()
}

fn lines(places: &[Vec<f64>], columns: impl Iterator<Item = Vec<f64>>, scale: f64) -> Vec<Series<'static>> {
    let line = |((x, y), stroke): ((&Vec<f64>, Vec<f64>), Stroke)| Series::new(x.clone(), y, stroke).times(scale);
    places.iter().zip(columns).zip(strokes()).map(line).collect()
}

/// Places the names above the lines in the middle of the axis; close lines share a label.
fn labels(panel: &Panel<'_>, names: &[&str]) -> Vec<(Point, String)> {
    let (x, y) = (&panel.x, &panel.y);
    let (middle, height) = (0.5 * (x.low + x.high), y.high - y.low);
    let mut groups: Vec<(f64, Vec<&str>)> = vec![];
    for (series, name) in panel.series.iter().zip(names) {
        let until = panel.samples(series, series.x.len(), &[]).take_while(|(place, _)| *place <= middle);
        let Some((_, at)) = until.last().filter(|(_, at)| at.is_finite()) else { continue };
        match groups.iter_mut().find(|(other, _)| (other - at).abs() < LABEL_HEIGHT * height) {
            Some((_, group)) => group.push(name),
            None => groups.push((at, vec![name])),
        }
    }
    let text = |group: &[&str]| match group {
        [one, two, others @ ..] if !others.is_empty() => {
            format!("{one}, {two} and {}", counted(others.len() as u64, "other"))
        }
        _ => group.join(", "),
    };
    groups.iter().map(|(at, group)| ((middle, at + 0.5 * LABEL_HEIGHT * height), text(group))).collect()
}

fn twice(values: &[f64]) -> Vec<f64> {
    values.iter().flat_map(|value| [*value; 2]).collect()
}

fn push(mut values: Vec<f64>, value: f64) -> Vec<f64> {
    values.push(value);
    values
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shown;

    fn view(name: &str, shift: f64) -> CharacteristicView<'_> {
        CharacteristicView {
            name,
            false_alarms_per_minute: vec![0.0, 1e-2, 1.0, 1e3],
            detection: vec![f64::NAN, 0.5, 0.9 - shift, 1.0],
            delay_median_s: vec![f64::NAN, f64::NAN, 4e-3, 2e-3],
        }
    }

    #[test]
    fn eight_detectors_have_eight_lines() {
        let views: Vec<_> = ["a", "b", "c", "d", "e", "f", "g", "h"].iter().map(|name| view(name, 0.0)).collect();
        let text = shown(&characteristic("study", &views, 1e-3).expect("a figure"));
        for name in ["a", "b", "c", "d", "e", "f", "g", "h"] {
            assert!(text.contains(&format!("\"{name}\"")), "{name}");
        }
        assert!(text.contains("Median delay (ms)"));
        let is_new = |(index, line): (usize, &Stroke)| !LINES[..index].contains(line);
        assert!(LINES.iter().enumerate().all(is_new));
    }

    #[test]
    fn misses_complement_detections_and_no_miss_is_drawn_on_the_lower_edge() {
        let figure = characteristic("study", &[view("a", 0.0)], 1e-3).expect("a figure");
        let panel = &figure.rows[0].panels[0];
        let placed: Vec<f64> = panel.samples(&panel.series[0], 100, &[]).map(|(_, y)| y).collect();
        let missed = placed.iter().map(|exponent| 10_f64.powf(*exponent)).collect::<Vec<_>>();
        assert!(placed[0].is_nan(), "undefined: {placed:?}");
        assert!(missed.iter().any(|percent| (percent - 50.0).abs() < 1e-9), "{missed:?}");
        assert!(missed.iter().any(|percent| (percent - 10.0).abs() < 1e-9), "{missed:?}");
        // Without misses, the value at the highest rate is half of the smallest share.
        assert!((missed[missed.len() - 1] - 5.0).abs() < 1e-9, "{missed:?}");
        assert!((panel.y.low - 5_f64.log10()).abs() < 1e-9);
        // 1e3 per minute are 6e4 per hour.
        assert!((panel.x.high - 9e4_f64.log10()).abs() < 1e-9);
    }

    #[test]
    fn lines_have_labels_above_them_and_equal_lines_share_a_label() {
        let worse = CharacteristicView { detection: vec![f64::NAN, 0.1, 0.3, 1.0], ..view("c", 0.0) };
        let views = [view("a", 0.0), view("b", 0.0), worse];
        let figure = characteristic("study", &views, 1e-3).expect("a figure");
        let notes = &figure.rows[0].panels[0].notes;
        let texts: Vec<&str> = notes.iter().map(|(_, text)| &**text).collect();
        assert_eq!(texts, ["a, b", "c"]);
        // The middle of 0.03 to 9e4 per hour lies after the rate of 1e-2 per minute, at which half of the ruptures are
        // missed.
        let panel = &figure.rows[0].panels[0];
        assert!((notes[0].0.1 - 50_f64.log10() - 0.05 * (panel.y.high - panel.y.low)).abs() < 1e-9, "{notes:?}");
    }

    #[test]
    fn empty_data_and_columns_of_unequal_lengths_are_errors() {
        assert!(matches!(characteristic("", &[], 1e-3), Err(FigureError::Empty { .. })));
        let short = CharacteristicView { detection: vec![1.0], ..view("a", 0.0) };
        assert!(matches!(characteristic("", &[short], 1e-3), Err(FigureError::Length { .. })));
    }
}
