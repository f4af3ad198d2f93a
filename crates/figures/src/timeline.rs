//! Many recordings over one time axis.

use super::FigureError;
use super::events::entries;
use trocar_document::figure::{Axis, Events, Figure, Panel, Row, Sample, Shade, X_TICKS, extent};

pub const MAX_ROWS: usize = 120;

#[derive(Clone, Debug)]
pub struct TimelineRow<'a> {
    pub name: &'a str,
    /// Of the first sample.
    pub from_s: f64,
    pub duration_s: f64,
    /// Start, end and phase of each interval, in order.
    pub shades: Vec<(f64, f64, Shade)>,
    /// Labelled.
    pub rupture_times_s: Vec<f64>,
    pub alarm_times_s: Vec<f64>,
}

/// Draws a row per recording, at most [`MAX_ROWS`], with shaded phases and marks for labelled ruptures and alarms.
pub fn timeline(rows: &[TimelineRow<'_>]) -> Result<Figure<'static>, FigureError> {
    if rows.is_empty() {
        return Err(FigureError::Empty { figure: "timeline" });
    }
    let rows = &rows[..rows.len().min(MAX_ROWS)];
    let ends = rows.iter().flat_map(|row| [row.from_s, row.from_s + row.duration_s]);
    let time = Axis::exact(extent(ends).unwrap_or((0.0, 0.0)), X_TICKS);
    let blank = Axis::exact((0.0, 1.0), 0);
    let events: Vec<Events> = rows
        .iter()
        .map(|row| Events {
            shades: row.shades.clone(),
            ruptures: row.rupture_times_s.clone(),
            alarms: row.alarm_times_s.clone(),
        })
        .collect();
    let mut legend = entries(&events.iter().collect::<Vec<_>>(), (f64::NEG_INFINITY, f64::INFINITY));
    for (_, name) in legend.iter_mut().filter(|(sample, _)| matches!(sample, Sample::Rupture)) {
        *name = "labelled rupture".to_owned();
    }
    let panel = |events| Panel { events, ..Panel::over_time(time.clone(), blank.clone(), "Events") };
    let rows = rows.iter().zip(events);
    let rows = rows.map(|(row, events)| Row { title: Some(row.name.to_owned()), ..Row::of(16.0, panel(events)) });
    Ok(Figure { name: String::new(), legend, rows: rows.collect() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shown;

    fn row(name: &str, duration_s: f64) -> TimelineRow<'_> {
        TimelineRow {
            name,
            from_s: 0.0,
            duration_s,
            shades: vec![(0.0, 1.0, Shade::Insertion), (1.0, 2.0, Shade::Withdrawal)],
            rupture_times_s: vec![0.5, f64::NAN],
            alarm_times_s: vec![0.51, 1e300],
        }
    }

    #[test]
    fn every_recording_has_a_row_and_the_legend_names_the_marks_in_use() {
        let rows = [row("first", 2.0), row("second", 0.0), row("third", f64::NAN)];
        let text = shown(&timeline(&rows).expect("drawn"));
        for text in ["first", "second", "third", "insertion", "withdrawal", "labelled rupture", "alarm"] {
            assert!(text.contains(text), "{text}");
        }
        assert!(!text.contains("hold"));
    }

    #[test]
    fn the_number_of_rows_is_bounded() {
        let rows: Vec<_> = (0..MAX_ROWS + 50).map(|_| row("x", 2.0)).collect();
        assert_eq!(timeline(&rows).expect("drawn").rows.len(), MAX_ROWS);
        assert!(matches!(timeline(&[]), Err(FigureError::Empty { .. })));
    }
}
