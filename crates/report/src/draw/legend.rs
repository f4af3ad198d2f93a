use plotters::prelude::DrawingBackend;

use super::fonts;
use super::pen::{Drawn, LINE, Pen, TEXT, Text};
use trocar_document::animation::Anchor;
use trocar_document::figure::{Entry, Point, RUPTURE, Sample};

const SAMPLE: f64 = 18.0;
const SAMPLE_GAP: f64 = 4.0;
const ENTRY_GAP: f64 = 12.0;

pub(super) struct Flow {
    entries: Vec<(Point, Sample, Vec<String>)>,
    pub(super) height: f64,
}

/// Lays out entries in lines of at most `max_width`. A longer entry has separate lines.
pub(super) fn flow(entries: &[Entry], max_width: f64) -> Flow {
    let (mut x, mut y) = (0.0, 0.0);
    let mut placed = Vec::new();
    for (sample, text) in entries {
        let is_bold = matches!(sample, Sample::Title);
        let lines = fonts::lines(text, TEXT, is_bold, (max_width - sample_width(sample)).max(TEXT));
        let widest = lines.iter().map(|line| fonts::width(line, TEXT, is_bold)).fold(0.0, f64::max);
        let width = sample_width(sample) + widest;
        if x > 0.0 && (x + width > max_width || lines.len() > 1) {
            (x, y) = (0.0, y + LINE);
        }
        let below = lines.len().saturating_sub(1) as f64 * LINE;
        placed.push(((x, y), *sample, lines));
        y += below;
        x = if below > 0.0 { max_width } else { x + width + ENTRY_GAP };
    }
    Flow { height: if placed.is_empty() { 0.0 } else { y + LINE + 1.0 }, entries: placed }
}

fn sample_width(sample: &Sample) -> f64 {
    match sample {
        Sample::Title => 0.0,
        Sample::Line(_) => SAMPLE + SAMPLE_GAP,
        Sample::Shade(_) => 12.0 + SAMPLE_GAP,
        Sample::Dot(_) | Sample::Alarm | Sample::Rupture => 7.0 + SAMPLE_GAP,
    }
}

impl Flow {
    pub(super) fn draw<B: DrawingBackend>(&self, pen: &Pen<'_, B>, origin: Point) -> Drawn<B> {
        for ((x, y), sample, lines) in &self.entries {
            let (left, middle) = (origin.0 + x, origin.1 + y + 0.5 * LINE);
            let centre = (left + 3.5, middle);
            match sample {
                Sample::Title => {}
                Sample::Line(line) => pen.line(&[(left, middle), (left + SAMPLE, middle)], &pen.as_drawn(line))?,
                Sample::Dot(dot) => pen.line(&[centre], dot)?,
                Sample::Shade(color) => {
                    let (right, top, bottom) = (left + 12.0, middle - 3.5, middle + 3.5);
                    pen.fill(&[(left, top), (right, top), (right, bottom), (left, bottom)], *color)?;
                }
                Sample::Alarm => pen.alarm((pen.units(centre.0), pen.units(middle - 3.0)))?,
                Sample::Rupture => pen.line(&[(centre.0, middle - 4.5), (centre.0, middle + 4.5)], &RUPTURE)?,
            }
            for (index, line) in lines.iter().enumerate() {
                let at = (left + sample_width(sample), middle + LINE * index as f64);
                let is_bold = matches!(sample, Sample::Title);
                pen.text(&Text { is_bold, ..Text::new(line, at, Anchor::Start) })?;
            }
        }
        Ok(())
    }
}
