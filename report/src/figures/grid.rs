//! The layout of a figure: rows of panels, one legend per column, aligned axes in each column.

use plotters::element::Rectangle;
use plotters::style::{Color, RGBAColor};

use super::canvas::{self, Area};
use super::fonts::{Faces, faces};
use super::panel::{Panel, Place, X_LABELS, alarm_mark, stroke};
use super::style::{self, FIGURE_WIDTH, RUPTURE, Stroke, TEXT_EM, TITLE_EM, units};
use super::{Figure, FigureError};

const MARGIN: f64 = 20.0;
const RIGHT_MARGIN: f64 = 46.0;
const COLUMN_GAP: f64 = 30.0;
const LEGEND_LINE: f64 = 48.0;
const SAMPLE: f64 = 64.0;
const ENTRY_GAP: f64 = 30.0;
const TITLE: f64 = 54.0;
const GAP: f64 = 26.0;

/// The sample before the text of a legend entry.
#[derive(Clone)]
pub(super) enum Sample {
    Line(Stroke),
    Dot(Stroke),
    Shade(RGBAColor),
    Alarm,
    Rupture,
}

/// One entry of a legend.
pub(super) type Entry = (Sample, String);

/// One row of panels, from left to right.
pub(super) struct Row<'a> {
    pub(super) title: Option<&'a str>,
    /// Height of the axes, in pixels.
    pub(super) height: f64,
    pub(super) panels: Vec<Panel<'a>>,
}

/// A whole figure.
pub(super) struct Grid<'a> {
    /// The legend of each column.
    pub(super) legends: Vec<Vec<Entry>>,
    /// The legend of all columns.
    pub(super) common: Vec<Entry>,
    pub(super) rows: Vec<Row<'a>>,
}

/// The layout of a legend: each entry with its position, and the total height.
type Layout = (Vec<(f64, f64, Entry)>, f64);

impl Grid<'_> {
    /// Draws the figure.
    pub(super) fn draw(&self) -> Result<Figure, FigureError> {
        let faces = faces()?;
        let columns = self.rows.iter().map(|row| row.panels.len()).max().unwrap_or(0).max(1);
        let page = f64::from(FIGURE_WIDTH);
        let available = page - MARGIN - RIGHT_MARGIN - COLUMN_GAP * (columns - 1) as f64;
        let column = available / columns as f64;
        let lefts: Vec<f64> = (0..columns).map(|c| MARGIN + (column + COLUMN_GAP) * c as f64).collect();
        let labels: Vec<f64> = (0..columns).map(|c| self.label_width(c, faces)).collect();

        let mut legends = Vec::new();
        for (c, entries) in self.legends.iter().enumerate().take(columns) {
            legends.push((lefts[c] + labels[c], flow(entries, column - labels[c], faces)));
        }
        let legend_height = legends.iter().fold(0.0_f64, |height, (_, layout)| height.max(layout.1));
        let common = flow(&self.common, page - RIGHT_MARGIN - MARGIN - labels[0], faces);
        let top = MARGIN + legend_height + common.1 + 6.0;
        let body: f64 = self.rows.iter().map(|row| row.height + head_height(row)).sum();
        let labelled = (0..self.rows.len()).filter(|index| self.is_x_labelled(*index)).count();
        let height = top + body + X_LABELS * labelled as f64 + MARGIN;

        canvas::render(height.ceil() as i32, |area| {
            for (left, layout) in &legends {
                legend(area, layout, (*left, MARGIN))?;
            }
            legend(area, &common, (lefts[0] + labels[0], MARGIN + legend_height))?;
            let mut y = top;
            for (index, row) in self.rows.iter().enumerate() {
                if let Some(title) = row.title {
                    let title = faces.fit(title, TITLE_EM, true, page - 2.0 * MARGIN - labels[0]);
                    let at = (units(lefts[0] + labels[0]), units(y + 24.0));
                    area.draw_text(&title, &style::title(), at)?;
                }
                y += head_height(row);
                let x_labelled = self.is_x_labelled(index);
                let below = if x_labelled { X_LABELS } else { 0.0 };
                for (c, panel) in row.panels.iter().enumerate() {
                    let (width, height) = (units(column), units(row.height + below));
                    let place = Place { y_labels: labels[c], x_labelled };
                    let part = area.clone().shrink((units(lefts[c]), units(y)), (width, height));
                    panel.draw(&part, &place)?;
                }
                y += row.height + below;
            }
            Ok(())
        })
    }

    /// Whether a row has labels on its x axis: the last of those with one axis.
    fn is_x_labelled(&self, index: usize) -> bool {
        let caption = |index: usize| Some(self.rows.get(index)?.panels.first()?.x_caption);
        caption(index + 1).is_none() || caption(index + 1) != caption(index)
    }

    /// Returns the width of the caption and the widest tick label of a column.
    fn label_width(&self, column: usize, faces: &Faces) -> f64 {
        let panels = self.rows.iter().filter_map(|row| row.panels.get(column));
        let widest = panels
            .flat_map(|panel| panel.y.ticks.iter().map(|&tick| panel.y.label(tick)))
            .map(|label| faces.width(&label, TEXT_EM, false))
            .fold(0.0, f64::max);
        widest + TEXT_EM + 34.0
    }
}

/// Returns the height above a row's axes.
fn head_height(row: &Row<'_>) -> f64 {
    if row.title.is_some() { TITLE + GAP } else { GAP }
}

/// Lays out entries in lines of at most `max_width` pixels.
fn flow(entries: &[Entry], max_width: f64, faces: &Faces) -> Layout {
    let (mut x, mut y) = (0.0, 0.0);
    let mut placed = Vec::new();
    for (sample, text) in entries {
        let text = faces.fit(text, TEXT_EM, false, max_width - sample_width(sample));
        let width = sample_width(sample) + faces.width(&text, TEXT_EM, false);
        if x > 0.0 && x + width > max_width {
            x = 0.0;
            y += LEGEND_LINE;
        }
        placed.push((x, y, (sample.clone(), text)));
        x += width + ENTRY_GAP;
    }
    let height = if placed.is_empty() { 0.0 } else { y + LEGEND_LINE };
    (placed, height)
}

fn sample_width(sample: &Sample) -> f64 {
    match sample {
        Sample::Line(_) => SAMPLE + 14.0,
        Sample::Shade(_) => 48.0 + 12.0,
        Sample::Dot(_) | Sample::Alarm | Sample::Rupture => 24.0 + 10.0,
    }
}

fn legend(area: &Area<'_>, layout: &Layout, origin: (f64, f64)) -> Result<(), FigureError> {
    for (x, y, (sample, text)) in &layout.0 {
        let (left, middle) = (origin.0 + x, origin.1 + y + LEGEND_LINE / 2.0);
        match sample {
            Sample::Line(line) => {
                stroke(area, vec![vec![(left, middle), (left + SAMPLE, middle)]], line)?;
            }
            Sample::Dot(dot) => stroke(area, vec![vec![(left + 12.0, middle)]], dot)?,
            Sample::Shade(color) => {
                let corners = [(units(left), units(middle - 15.0)), (units(left + 48.0), units(middle + 15.0))];
                area.draw(&Rectangle::new(corners, color.filled()))?;
            }
            Sample::Alarm => alarm_mark(area, (left + 12.0, middle - 11.0))?,
            Sample::Rupture => {
                let at = left + 12.0;
                stroke(area, vec![vec![(at, middle - 19.0), (at, middle + 19.0)]], &RUPTURE)?;
            }
        }
        let at = (units(left + sample_width(sample)), units(middle - 0.38 * TEXT_EM));
        area.draw_text(text, &style::text(), at)?;
    }
    Ok(())
}
