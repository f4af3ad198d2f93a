//! The animation as an animated PNG, for a talk. It has the parts and the colours of `assets/animation.js`.

use png::{BlendOp, ColorType, Compression, DisposeOp, Encoder, EncodingError, Filter};
use tiny_skia::{Color, FillRule, LineCap, Paint, PathBuilder, Pixmap, Rect, Stroke, StrokeDash, Transform};

use super::{Animation, Panel};
use crate::figures::{letters, opaque, text_width};

/// Size of the picture in pixels.
const WIDTH: u32 = 960;
const HEIGHT: u32 = 400;

/// Only every third frame is painted, so that the file stays small.
const EVERY: usize = 3;

/// Time for which a loop rests at its last frame, in ms.
const REST_MS: u16 = 1500;

/// Heights of the line of names and of the line of the clock.
const HEAD: f32 = 40.0;
const FOOT: f32 = 34.0;

/// Places in a panel: force bar, rail of the hand, left end of the tissue; margin above and below the depths.
const BAR: f32 = 14.0;
const BAR_WIDTH: f32 = 18.0;
const HAND: f32 = 74.0;
const TISSUE: f32 = 112.0;
const MARGIN: f32 = 26.0;

/// Half the width of the needle, and the length of its bevel.
const NEEDLE: f32 = 3.5;
const BEVEL: f32 = 14.0;

type Rgb = [u8; 3];
const PAGE: Rgb = [255, 255, 255];
const INK: Rgb = [26, 26, 26];
const QUIET: Rgb = [85, 91, 102];
const LINE: Rgb = [201, 206, 214];
const CLASSICAL: Rgb = [0, 114, 178];
const AUGMENTED: Rgb = [200, 82, 0];
const HAND_GREEN: Rgb = [0, 122, 90];
const PULLS: Rgb = [176, 87, 138];
const FROZEN: Rgb = [230, 159, 0];
const TISSUES: [Rgb; 2] = [[246, 227, 211], [239, 208, 184]];
const TISSUE_LINE: Rgb = [168, 112, 76];

impl Animation {
    /// Returns the animation as an animated PNG that plays in a loop.
    ///
    /// # Errors
    /// [`EncodingError`].
    pub fn png(&self) -> Result<Vec<u8>, EncodingError> {
        let last = self.time_s.len() - 1;
        let frames: Vec<usize> = (0..last).step_by(EVERY).chain([last]).collect();
        let mut bytes = vec![];
        let mut encoder = Encoder::new(&mut bytes, WIDTH, HEIGHT);
        encoder.set_color(ColorType::Rgb);
        encoder.set_compression(Compression::Balanced);
        // Areas of one colour need no choice of a filter for each row, which would take longer than painting.
        encoder.set_filter(Filter::Up);
        encoder.set_animated(frames.len() as u32, 0)?;
        encoder.set_blend_op(BlendOp::Source)?;
        encoder.set_dispose_op(DisposeOp::None)?;
        let mut writer = encoder.write_header()?;
        let mut before: Option<Pixmap> = None;
        for &frame in &frames {
            let now = self.paint(frame);
            let next_s = self.time_s[(frame + EVERY).min(last)].0;
            let shown_ms = (1e3 * self.slowness * (next_s - self.time_s[frame].0)).round() as u16;
            writer.set_frame_delay(if frame == last { REST_MS } else { shown_ms }, 1000)?;
            // Only the part that changes is stored.
            let (from, to) = before.as_ref().map_or(((0, 0), (WIDTH, HEIGHT)), |before| changed(before, &now));
            writer.reset_frame_position()?;
            writer.set_frame_dimension(to.0 - from.0, to.1 - from.1)?;
            writer.set_frame_position(from.0, from.1)?;
            writer.write_image_data(&opaque(&part(&now, from, to)))?;
            before = Some(now);
        }
        writer.finish()?;
        Ok(bytes)
    }

    fn paint(&self, frame: usize) -> Pixmap {
        let mut sheet = Sheet::new(WIDTH, HEIGHT);
        let wide = (WIDTH as f32 - 16.0) / self.panels.len().max(1) as f32;
        for (index, panel) in self.panels.iter().enumerate() {
            let left = 8.0 + index as f32 * wide;
            let colour = if panel.scheme == "augmented" { AUGMENTED } else { CLASSICAL };
            sheet.text((left + 6.0, 26.0), (18.0, true, colour), 0.0, &panel.name);
            let state = panel.state(frame, self.time_s[frame].0);
            if state == "frozen" {
                sheet.rect((left + wide - 90.0, 9.0), (78.0, 24.0), FROZEN);
            }
            sheet.text((left + wide - 20.0, 26.0), (15.0, state != "teleoperation", INK), 1.0, state);
            let mut drawing = Sheet::new((wide - 12.0) as u32, HEIGHT - (HEAD + FOOT) as u32);
            self.paint_panel(&mut drawing, panel, frame, colour);
            sheet.place((left as usize + 4, HEAD as usize), &drawing);
        }
        let after_ms = (1e3 * (self.time_s[frame].0 - self.origin_s.0)).round();
        let side = if after_ms < 0.0 { "before" } else { "after" };
        let clock = format!("{} ms {side} the {}", after_ms.abs(), self.origin);
        let foot = HEIGHT as f32 - 10.0;
        sheet.text((14.0, foot), (15.0, false, INK), 0.0, &clock);
        sheet.text((WIDTH as f32 - 14.0, foot), (13.0, false, QUIET), 1.0, &self.title);
        sheet.pixmap
    }

    fn paint_panel(&self, sheet: &mut Sheet, panel: &Panel, frame: usize, colour: Rgb) {
        let (width, height) = (sheet.pixmap.width() as f32, sheet.pixmap.height() as f32);
        let [from_mm, to_mm] = self.range_mm.map(|mm| mm.0);
        let per_mm = (height - 2.0 * MARGIN) / (to_mm - from_mm) as f32;
        let y = |mm: f64| MARGIN + (mm - from_mm) as f32 * per_mm;
        let needle = TISSUE + 0.42 * (width - TISSUE);
        let tip = y(panel.tip_mm[frame].0);
        for (index, layer) in panel.layers.iter().enumerate() {
            let depth = y(panel.tops_mm[frame][index].0);
            let top = Top { flat: y(layer.top_mm.0), dip: depth, needle, width };
            sheet.fill(|path| top.outline(path, Some(height)), TISSUES[index % 2]);
            sheet.stroke(|path| top.outline(path, None), TISSUE_LINE, 2.0, None);
            if layer.torn_s.is_some_and(|torn| torn.0 <= self.time_s[frame].0) && tip > depth {
                let (wide, deep) = (NEEDLE + 7.0, (tip - depth).min(16.0));
                sheet.fill(|path| tear(path, (needle, depth), (wide, deep)), PAGE);
            }
        }
        let mut free = f32::MIN;
        let tops = panel.layers.iter().map(|layer| y(layer.top_mm.0));
        for (layer, next) in panel.layers.iter().zip(tops.skip(1).chain([height])) {
            let top = y(layer.top_mm.0).max(0.0);
            // The label of a thin layer stands above it.
            let at = if next - top < 18.0 { top - 5.0 } else { top + 15.0 };
            if at > free && at < height - 6.0 && next > 0.0 {
                sheet.text((width - 8.0, at), (13.0, false, INK), 1.0, &layer.label);
                free = at + 15.0;
            }
        }
        let hand = y(panel.hand_mm[frame].0);
        sheet.stroke(|path| line(path, (HAND, hand), (needle, hand)), HAND_GREEN, 1.5, Some([2.0, 4.0]));
        if let Some(rupture) = panel.rupture.as_ref().filter(|rupture| rupture.time_s.0 <= self.time_s[frame].0) {
            let reached_mm = rupture.reached_mm[frame].0;
            let (low, high, x) = (y(rupture.from_mm.0), y(rupture.from_mm.0 + reached_mm), needle + 26.0);
            let bracket = |path: &mut PathBuilder| {
                path.move_to(x - 9.0, low);
                path.line_to(x, low);
                path.line_to(x, high);
                path.line_to(x - 9.0, high);
            };
            sheet.stroke(bracket, colour, 2.5, None);
            let is_last = rupture.reached_mm.last().is_some_and(|last| last.0 == reached_mm);
            let text = if is_last { rupture.text.clone() } else { format!("{reached_mm:.1} mm") };
            sheet.text((x + 7.0, 0.5 * (low + high) + 6.0), (17.0, true, colour), 0.0, &text);
        }
        let outline = |path: &mut PathBuilder| {
            path.move_to(needle - NEEDLE, 0.0);
            path.line_to(needle + NEEDLE, 0.0);
            path.line_to(needle + NEEDLE, tip - BEVEL);
            path.line_to(needle - NEEDLE, tip);
            path.close();
        };
        sheet.fill(outline, colour);
        if panel.mode[frame] == 1 {
            for side in [-1.0, 1.0] {
                sheet.rect((needle + side * (NEEDLE + 8.0) - 7.0, 3.0), (14.0, 17.0), FROZEN);
            }
        }
        sheet.stroke(|path| line(path, (HAND, MARGIN - 8.0), (HAND, height - MARGIN)), LINE, 4.0, None);
        sheet.rect((HAND - 19.0, hand - 10.0), (38.0, 20.0), HAND_GREEN);
        sheet.text((HAND, height - 8.0), (13.0, false, INK), 0.5, "hand");
        let (felt_n, tall) = (panel.felt_n[frame].0, height - 2.0 * MARGIN);
        let share = (felt_n.abs() / self.max_force_n.0).min(1.0) as f32;
        sheet.rect((BAR, MARGIN), (BAR_WIDTH, tall), LINE);
        let force = if felt_n < 0.0 { PULLS } else { HAND_GREEN };
        sheet.rect((BAR, MARGIN + (1.0 - share) * tall), (BAR_WIDTH, share * tall), force);
        // Adding zero takes the sign from a zero.
        let shown_n = (100.0 * felt_n).round() / 100.0 + 0.0;
        sheet.text((4.0, MARGIN - 8.0), (14.0, false, INK), 0.0, &format!("{shown_n:.2} N"));
        sheet.text((4.0, height - 8.0), (13.0, false, INK), 0.0, "force");
    }
}

/// The top of a layer, which dips at the needle; in pixels.
struct Top {
    flat: f32,
    dip: f32,
    needle: f32,
    width: f32,
}

impl Top {
    /// Draws the line of the top, or the outline of the layer down to a height.
    fn outline(&self, path: &mut PathBuilder, down_to: Option<f32>) {
        let Self { flat, dip, needle, width } = *self;
        let reach = (26.0 + 0.7 * (dip - flat)).min(0.95 * (needle - TISSUE));
        let half = NEEDLE + 1.0;
        path.move_to(TISSUE, flat);
        path.line_to(needle - half - reach, flat);
        path.cubic_to(needle - half - 0.45 * reach, flat, needle - half - 0.2 * reach, dip, needle - half, dip);
        path.line_to(needle + half, dip);
        path.cubic_to(
            needle + half + 0.2 * reach,
            dip,
            needle + half + 0.45 * reach,
            flat,
            needle + half + reach,
            flat,
        );
        path.line_to(width, flat);
        if let Some(bottom) = down_to {
            path.line_to(width, bottom);
            path.line_to(TISSUE, bottom);
            path.close();
        }
    }
}

/// Draws the opening of a torn layer around the needle.
fn tear(path: &mut PathBuilder, (x, y): (f32, f32), (wide, deep): (f32, f32)) {
    path.move_to(x - wide, y - 1.0);
    path.quad_to(x - NEEDLE - 1.0, y, x - NEEDLE, y + deep);
    path.line_to(x + NEEDLE, y + deep);
    path.quad_to(x + NEEDLE + 1.0, y, x + wide, y - 1.0);
    path.close();
}

fn line(path: &mut PathBuilder, from: (f32, f32), to: (f32, f32)) {
    path.move_to(from.0, from.1);
    path.line_to(to.0, to.1);
}

/// White paper with shapes and texts.
struct Sheet {
    pixmap: Pixmap,
}

impl Sheet {
    fn new(width: u32, height: u32) -> Self {
        let mut pixmap = Pixmap::new(width.max(1), height.max(1)).expect("neither side is 0 or enormous");
        pixmap.fill(Color::WHITE);
        Self { pixmap }
    }

    /// Copies another sheet, of which all is visible, to a place within this one.
    fn place(&mut self, (x, y): (usize, usize), other: &Self) {
        let [width, other_width] = [&self.pixmap, &other.pixmap].map(|pixmap| pixmap.width() as usize * 4);
        for (to, row) in self.pixmap.data_mut().chunks_exact_mut(width).skip(y).zip(rows(&other.pixmap)) {
            to[4 * x..4 * x + other_width].copy_from_slice(row);
        }
    }

    fn fill(&mut self, draw: impl FnOnce(&mut PathBuilder), colour: Rgb) {
        let mut path = PathBuilder::new();
        draw(&mut path);
        if let Some(path) = path.finish() {
            self.pixmap.fill_path(&path, &paint(colour), FillRule::Winding, Transform::identity(), None);
        }
    }

    fn rect(&mut self, (x, y): (f32, f32), (width, height): (f32, f32), colour: Rgb) {
        if let Some(rect) = Rect::from_xywh(x, y, width, height) {
            self.fill(|path| path.push_rect(rect), colour);
        }
    }

    fn stroke(&mut self, draw: impl FnOnce(&mut PathBuilder), colour: Rgb, width: f32, dash: Option<[f32; 2]>) {
        let mut path = PathBuilder::new();
        draw(&mut path);
        let dash = dash.and_then(|dash| StrokeDash::new(dash.to_vec(), 0.0));
        let stroke = Stroke { width, line_cap: LineCap::Butt, dash, ..Stroke::default() };
        if let Some(path) = path.finish() {
            self.pixmap.stroke_path(&path, &paint(colour), &stroke, Transform::identity(), None);
        }
    }

    /// Writes a text with its baseline at a place. `align` is the share of its width that is left of the place.
    fn text(&mut self, (x, y): (f32, f32), (em, bold, colour): (f32, bool, Rgb), align: f32, text: &str) {
        let (outline, units) = letters(text, bold);
        let (size, width) = (em / units, text_width(text, f64::from(em), bold) as f32);
        let place = Transform::from_row(size, 0.0, 0.0, -size, x - align * width, y);
        if let Some(outline) = outline {
            self.pixmap.fill_path(&outline, &paint(colour), FillRule::Winding, place, None);
        }
    }
}

fn paint([r, g, b]: Rgb) -> Paint<'static> {
    let mut paint = Paint::default();
    paint.set_color_rgba8(r, g, b, 255);
    paint
}

/// Returns the smallest rectangle with all changes: its first column and row, and those after its last ones.
fn changed(before: &Pixmap, now: &Pixmap) -> ((u32, u32), (u32, u32)) {
    let (mut from, mut to) = ((WIDTH, HEIGHT), (0, 0));
    for (y, (before, now)) in (0..).zip(rows(before).zip(rows(now))) {
        // Most rows are equal, which takes one comparison.
        if before == now {
            continue;
        }
        let (before, now) = (before.as_chunks::<4>().0, now.as_chunks::<4>().0);
        let differs = |(a, b): (&[u8; 4], &[u8; 4])| a != b;
        let first = before.iter().zip(now).position(differs).unwrap_or(0) as u32;
        let last = before.iter().zip(now).rposition(differs).unwrap_or(0) as u32;
        (from, to) = ((from.0.min(first), from.1.min(y)), (to.0.max(last + 1), y + 1));
    }
    if to.0 == 0 { ((0, 0), (1, 1)) } else { (from, to) }
}

/// The pixels of a rectangle.
fn part(pixmap: &Pixmap, from: (u32, u32), to: (u32, u32)) -> Vec<u8> {
    let columns = 4 * from.0 as usize..4 * to.0 as usize;
    let within = rows(pixmap).skip(from.1 as usize).take((to.1 - from.1) as usize);
    within.map(|row| &row[columns.clone()]).collect::<Vec<_>>().concat()
}

/// The rows of a picture, four bytes a pixel.
fn rows(pixmap: &Pixmap) -> impl Iterator<Item = &[u8]> {
    pixmap.data().chunks_exact(4 * pixmap.width() as usize)
}
