//! The description of a figure, and its layout: rows of panels with aligned axes, legends above them.

use super::legend::{Entry, Flow, Sample, flow};
use super::page::{Anchor, LINE, Page, Text, centred};
use super::panel::{Panel, Place, RIGHT};
use super::{FigureError, FigureFormat, FigureWidth};

const MARGIN: f64 = 3.0;
const COLUMN_GAP: f64 = 8.0;
/// Minimum width of a column. Where there is less, panels are below each other.
const MIN_COLUMN: f64 = 170.0;
/// Gap between a legend and the axes below it, and above a row.
const GAP: f64 = 4.0;
const LETTER: f64 = 16.0;
/// Height that stays the same at any width.
const FIXED_HEIGHT: f64 = 40.0;

/// One row of panels, from left to right.
pub(super) struct Row<'a> {
    pub(super) title: Option<String>,
    /// Height of the axes at the width of a page.
    pub(super) height: f64,
    pub(super) panels: Vec<Panel<'a>>,
}

impl<'a> Row<'a> {
    pub(super) fn of(height: f64, panel: Panel<'a>) -> Self {
        Self { title: None, height, panels: vec![panel] }
    }
}

/// A figure: what it shows, apart from its size and the format of its file.
pub struct Figure<'a> {
    /// Name of the run.
    pub(super) name: String,
    /// The legend of all panels.
    pub(super) legend: Vec<Entry>,
    pub(super) rows: Vec<Row<'a>>,
}

impl Figure<'_> {
    /// Returns the file of the figure in a format, at a width.
    ///
    /// # Errors
    /// [`FigureError::Size`] for a figure that is too high for a bitmap, [`FigureError::Png`], [`FigureError::Font`] or
    /// [`FigureError::Deflate`] if it cannot be encoded.
    pub fn file(&self, format: FigureFormat, width: FigureWidth) -> Result<Vec<u8>, FigureError> {
        let page = self.page(width.points());
        match format {
            FigureFormat::Svg => Ok(page.svg().into_bytes()),
            FigureFormat::Png => page.png(),
            FigureFormat::Pdf => page.pdf(),
        }
    }

    /// Lays the figure out on a page of a width in points.
    pub(super) fn page(&self, width: f64) -> Page {
        let full = FigureWidth::default().points();
        let column_width = |count: usize| (width - 2.0 * MARGIN - COLUMN_GAP * (count as f64 - 1.0)) / count as f64;
        let most = self.rows.iter().map(|row| row.panels.len()).max().unwrap_or(1).max(1);
        let most = (1..=most).rev().find(|count| column_width(*count) >= MIN_COLUMN).unwrap_or(1);
        // A narrow figure is also lower.
        let shrink = 0.5 + 0.5 * (width / full).min(2.0);
        let rows: Vec<Shelf<'_>> = self.rows.iter().flat_map(|row| Shelf::of(row, most, shrink)).collect();
        // The axes below each other are aligned.
        let labels = |row: &Shelf<'_>, c: usize| {
            let alike = rows.iter().filter(|other| other.panels.len() == row.panels.len());
            alike.filter_map(|row| Some(row.panels.get(c)?.label_width(row.height))).fold(0.0, f64::max)
        };
        let is_lettered = rows.iter().map(|row| row.panels.len()).sum::<usize>() > 1
            && rows.iter().all(|row| row.title.is_none() || row.height > FIXED_HEIGHT);
        let mut letters = ('a'..='z').filter(|_| is_lettered);

        let mut page = Page::new(width);
        let mut y = MARGIN;
        let title = (!self.name.is_empty()).then(|| (Sample::Title, self.name.clone()));
        let entries: Vec<Entry> = title.into_iter().chain(self.legend.iter().cloned()).collect();
        // Legends show lines as they were drawn, hence after them.
        let head = flow(&entries, width - 2.0 * MARGIN);
        y += head.height;
        let mut legends = vec![(head, (MARGIN, MARGIN))];
        for (index, row) in rows.iter().enumerate() {
            if let Some(title) = row.title {
                let titled = [(Sample::Title, title.to_owned())];
                let title = flow(&titled, width - 2.0 * MARGIN);
                let below = y + title.height;
                legends.push((title, (MARGIN, y + 1.0)));
                y = below;
            }
            let column = column_width(row.panels.len());
            let labels: Vec<f64> = (0..row.panels.len()).map(|c| labels(row, c)).collect();
            // Space for the letter, where labels are narrow.
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
                if let Some(letter) = letters.next() {
                    let text = Text::new(format!("({letter})"), (edge, centred(y + 0.5 * LINE)), Anchor::Start);
                    page.text(Text { is_bold: true, ..text });
                }
                legends.push((legend, (edge + indent(c), y)));
                let axes = column - labels[c] - RIGHT;
                let place = Place { left: edge + labels[c], top, width: axes, height: row.height, edge, x_labelled };
                panel.draw(&mut page, &place);
                below = below.max(if x_labelled { panel.label_height(axes) } else { 0.0 });
            }
            y = top + row.height + below + GAP;
        }
        for (legend, origin) in legends {
            legend.draw(&mut page, origin);
        }
        page.height = y + MARGIN;
        page
    }
}

/// A row on its page: the panels that are side by side.
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

/// Whether a row has labels on its horizontal axis: the last of those with the same axis.
fn is_x_labelled(rows: &[Shelf<'_>], index: usize) -> bool {
    let axis = |index: usize| rows.get(index)?.panels.first().map(|panel| (&panel.x, &panel.x_caption));
    axis(index + 1).is_none() || axis(index + 1) != axis(index)
}
