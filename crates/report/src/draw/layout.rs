//! The layout of a figure: rows of panels with aligned axes, legends above them.

use plotters::prelude::DrawingBackend;

use super::FigureWidth;
use super::legend::{Flow, flow};
use super::panel::{Axes, Place, RIGHT, label_height, label_width};
use super::pen::{Drawn, LINE, Pen, Text};
use trocar_document::animation::Anchor;
use trocar_document::figure::{Entry, Figure, Panel, Point, Row, Sample};

const MARGIN: f64 = 3.0;
const COLUMN_GAP: f64 = 8.0;
/// Minimum width of a column; in narrower figures panels are stacked.
const MIN_COLUMN: f64 = 170.0;
const GAP: f64 = 4.0;
const LETTER: f64 = 16.0;
/// Row height that does not shrink with the width.
const FIXED_HEIGHT: f64 = 40.0;

pub(super) struct Sheet<'a> {
    pub(super) width: f64,
    pub(super) height: f64,
    panels: Vec<(&'a Panel<'a>, Place)>,
    letters: Vec<Text>,
    legends: Vec<(Flow, Point)>,
}

impl<'a> Sheet<'a> {
    pub(super) fn of(figure: &'a Figure<'a>, width: f64) -> Self {
        let full = FigureWidth::default().points();
        let column_width = |count: usize| (width - 2.0 * MARGIN - COLUMN_GAP * (count as f64 - 1.0)) / count as f64;
        let most = figure.rows.iter().map(|row| row.panels.len()).max().unwrap_or(1).max(1);
        let most = (1..=most).rev().find(|count| column_width(*count) >= MIN_COLUMN).unwrap_or(1);
        // A narrow figure is also lower.
        let shrink = 0.5 + 0.5 * (width / full).min(2.0);
        let rows: Vec<Shelf<'_>> = figure.rows.iter().flat_map(|row| Shelf::of(row, most, shrink)).collect();
        let labels = |row: &Shelf<'_>, c: usize| {
            let alike = rows.iter().filter(|other| other.panels.len() == row.panels.len());
            alike.filter_map(|row| Some(label_width(row.panels.get(c)?, row.height))).fold(0.0, f64::max)
        };
        let is_lettered = rows.iter().map(|row| row.panels.len()).sum::<usize>() > 1
            && rows.iter().all(|row| row.title.is_none() || row.height > FIXED_HEIGHT);
        let mut names = ('a'..='z').filter(|_| is_lettered);

        let title = (!figure.name.is_empty()).then(|| (Sample::Title, figure.name.clone()));
        let entries: Vec<Entry> = title.into_iter().chain(figure.legend.iter().cloned()).collect();
        let head = flow(&entries, width - 2.0 * MARGIN);
        let mut y = MARGIN + head.height;
        let (mut panels, mut letters, mut legends) = (vec![], vec![], vec![(head, (MARGIN, MARGIN))]);
        for (index, row) in rows.iter().enumerate() {
            if let Some(title) = row.title {
                let title = flow(&[(Sample::Title, title.to_owned())], width - 2.0 * MARGIN);
                let below = y + title.height;
                legends.push((title, (MARGIN, y + 1.0)));
                y = below;
            }
            let column = column_width(row.panels.len());
            let labels: Vec<f64> = (0..row.panels.len()).map(|c| labels(row, c)).collect();
            // Leave space for the letter if the labels are narrow.
            let indent = |c: usize| if is_lettered { labels[c].max(LETTER) } else { labels[c] };
            let legend = |(c, panel): (usize, &&Panel<'_>)| flow(&panel.legend, column - indent(c));
            let of_panels: Vec<Flow> = row.panels.iter().enumerate().map(legend).collect();
            let lettered = if is_lettered { LINE } else { 0.0 };
            let head = of_panels.iter().map(|legend| legend.height).fold(lettered, f64::max);
            let top = y + head + GAP;
            let x_labelled = is_x_labelled(&rows, index);
            let mut below: f64 = 0.0;
            for (c, (panel, legend)) in row.panels.iter().zip(of_panels).enumerate() {
                let edge = MARGIN + (column + COLUMN_GAP) * c as f64;
                if let Some(letter) = names.next() {
                    let text = Text::new(format!("({letter})"), (edge, y + 0.5 * LINE), Anchor::Start);
                    letters.push(Text { is_bold: true, ..text });
                }
                legends.push((legend, (edge + indent(c), y)));
                let axes = column - labels[c] - RIGHT;
                panels.push((
                    *panel,
                    Place { left: edge + labels[c], top, width: axes, height: row.height, edge, x_labelled },
                ));
                below = below.max(if x_labelled { label_height(panel, axes) } else { 0.0 });
            }
            y = top + row.height + below + GAP;
        }
        Self { width, height: y + MARGIN, panels, letters, legends }
    }

    /// Draws the sheet; legends last, because they show lines as drawn.
    pub(super) fn draw<B: DrawingBackend>(&self, pen: &Pen<'_, B>) -> Drawn<B> {
        self.letters.iter().try_for_each(|letter| pen.text(letter))?;
        self.panels.iter().try_for_each(|(panel, place)| Axes::new(pen, panel, place).draw())?;
        self.legends.iter().try_for_each(|(legend, origin)| legend.draw(pen, *origin))
    }
}

struct Shelf<'a> {
    title: Option<&'a str>,
    height: f64,
    panels: Vec<&'a Panel<'a>>,
}

impl<'a> Shelf<'a> {
    fn of(row: &'a Row<'a>, columns: usize, shrink: f64) -> Vec<Self> {
        let height = if row.height > FIXED_HEIGHT { shrink * row.height } else { row.height };
        let parts = row.panels.chunks(columns.max(1)).enumerate();
        let part = |(index, panels): (usize, &'a [Panel<'a>])| Self {
            title: row.title.as_deref().filter(|_| index == 0),
            height,
            panels: panels.iter().collect(),
        };
        parts.map(part).collect()
    }
}

fn is_x_labelled(rows: &[Shelf<'_>], index: usize) -> bool {
    let axis = |index: usize| rows.get(index)?.panels.first().map(|panel| (&panel.x, &panel.x_caption));
    axis(index + 1).is_none() || axis(index + 1) != axis(index)
}
