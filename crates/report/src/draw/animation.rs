use plotters::coord::Shift;
use plotters::drawing::{DrawingArea, IntoDrawingArea};
use plotters::prelude::DrawingBackend;
use png::{BlendOp, ColorType, Compression, DisposeOp, Encoder, Filter};
use tiny_skia::Pixmap;

use super::bitmap::{Bitmap, opaque};
use super::pen::{Drawn, Pen, Text};
use super::{Backend, DrawError};
use trocar_document::animation::{Anchor, Animation, Role, Shape};
use trocar_document::figure::{Color, Shade, Stroke};

const WIDTH: u32 = 960;
const HEIGHT: u32 = 400;

/// Units of the drawing per pixel.
const UNITS: f64 = 10.0;

/// Pixels per unit of length in a scene.
const SCALE: f64 = 1.25;

/// Only every third frame is painted, for a small file.
const EVERY: usize = 3;

/// Of the last frame in a loop.
const REST_MS: u16 = 1500;

const HEAD: f64 = 40.0;

const PAGE: Color = Color(255, 255, 255);
const INK: Color = Color(26, 26, 26);
const QUIET: Color = Color(85, 91, 102);
const LINE: Color = Color(201, 206, 214);
const CLASSICAL: Color = Color(0, 114, 178);
const AUGMENTED: Color = Color(200, 82, 0);
const HAND: Color = Color(0, 122, 90);
const PULLS: Color = Color(176, 87, 138);
const FROZEN: Color = Color(230, 159, 0);
const TISSUE_EVEN: Color = Color(246, 227, 211);
const TISSUE_ODD: Color = Color(239, 208, 184);
const TISSUE_LINE: Stroke = Stroke::solid(Color(168, 112, 76), 2.0);

/// The style of a role: an area's colour and outline, a line, or a text's size, weight (true: bold) and colour.
enum Style {
    Area(Color),
    Outlined(Color, Stroke),
    Line(Stroke),
    Text(f64, bool, Color),
}

fn style(role: Role, scheme: Color) -> Style {
    match role {
        Role::TissueEven => Style::Outlined(TISSUE_EVEN, TISSUE_LINE),
        Role::TissueOdd => Style::Outlined(TISSUE_ODD, TISSUE_LINE),
        Role::Tear => Style::Area(PAGE),
        Role::Needle => Style::Area(scheme),
        Role::Clamp => Style::Area(FROZEN),
        Role::Brake => Style::Outlined(PAGE, Stroke::solid(FROZEN, 2.5)),
        Role::Barrier => Style::Line(Stroke::solid(FROZEN, 4.0)),
        Role::Vibration => Style::Line(Stroke::solid(HAND, 2.0)),
        Role::Hand | Role::Force => Style::Area(HAND),
        Role::Pull => Style::Area(PULLS),
        Role::Track => Style::Area(LINE),
        Role::Level => Style::Line(Stroke::dashed(HAND, 1.5, &[2.0, 4.0])),
        Role::Bracket => Style::Line(Stroke::solid(scheme, 2.5)),
        Role::Rail => Style::Line(Stroke::solid(LINE, 4.0)),
        Role::Grip => Style::Line(Stroke::solid(PAGE, 2.0)),
        Role::Ruler => Style::Line(Stroke::solid(QUIET, 1.25)),
        Role::Label => Style::Text(13.0, false, INK),
        Role::Newtons => Style::Text(14.0, false, INK),
        Role::Overshoot => Style::Text(17.0, true, scheme),
    }
}

pub(crate) fn animated_png(animation: &Animation) -> Result<Vec<u8>, DrawError> {
    // End with the metric; with the return of the needle the file would be twice as large.
    let last = animation.still;
    let frames: Vec<usize> = (0..last).step_by(EVERY).chain([last]).collect();
    let mut bytes = vec![];
    let mut encoder = Encoder::new(&mut bytes, WIDTH, HEIGHT);
    encoder.set_color(ColorType::Rgb);
    encoder.set_compression(Compression::Balanced);
    // With areas of one colour, choosing a filter per row would take longer than painting.
    encoder.set_filter(Filter::Up);
    encoder.set_animated(frames.len() as u32, 0)?;
    encoder.set_blend_op(BlendOp::Source)?;
    encoder.set_dispose_op(DisposeOp::None)?;
    let mut writer = encoder.write_header()?;
    let mut before: Option<Pixmap> = None;
    for &frame in &frames {
        let now = paint(animation, frame)?;
        let next_s = animation.time_s[(frame + EVERY).min(last)].0;
        let shown_ms = (1e3 * animation.slowness * (next_s - animation.time_s[frame].0)).round() as u16;
        writer.set_frame_delay(if frame == last { REST_MS } else { shown_ms }, 1000)?;
        // Store only the changed part.
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

fn paint(animation: &Animation, frame: usize) -> Result<Pixmap, DrawError> {
    let mut canvas = Bitmap::new(WIDTH, HEIGHT, 1.0 / UNITS).ok_or(DrawError::Size)?;
    let size = (WIDTH * UNITS as u32, HEIGHT * UNITS as u32);
    let area = Backend { canvas: &mut canvas, size }.into_drawing_area();
    draw(animation, &area, frame).map_err(|error| DrawError::Backend(error.to_string()))?;
    drop(area);
    Ok(canvas.pixmap)
}

fn draw<B: DrawingBackend>(animation: &Animation, area: &DrawingArea<B, Shift>, frame: usize) -> Drawn<B> {
    let pen = Pen::new(area, UNITS);
    let write = |(x, y): (f64, f64), (size, is_bold, color): (f64, bool, Color), anchor, text: &str| {
        pen.text(&Text { size, is_bold, color, ..Text::new(text, (x, y), anchor) })
    };
    let (width, foot) = (f64::from(WIDTH), f64::from(HEIGHT) - 16.0);
    let wide = (width - 16.0) / animation.panels.len().max(1) as f64;
    for (index, (panel, picture)) in animation.panels.iter().zip(&animation.pictures).enumerate() {
        let left = 8.0 + index as f64 * wide;
        let scheme = if panel.scheme == "augmented" { AUGMENTED } else { CLASSICAL };
        write((left + 6.0, 21.0), (18.0, true, scheme), Anchor::Start, &panel.name)?;
        let state = panel.states[frame];
        if [Shade::Frozen, Shade::Held, Shade::Event].map(Shade::name).contains(&state) {
            let (from, to) = (left + wide - 90.0, left + wide - 12.0);
            pen.fill(&[(from, 9.0), (to, 9.0), (to, 33.0), (from, 33.0)], FROZEN)?;
        }
        write((left + wide - 20.0, 21.0), (15.0, state != "teleoperation", INK), Anchor::End, state)?;
        let inner = [left + 4.0, HEAD, (wide - 12.0).min(SCALE * 800.0), SCALE * picture.size.1];
        let [left, top, width, height] = inner.map(|length| pen.units(length));
        draw_shapes(&area.clone().shrink((left, top), (width, height)), &picture.frames[frame], scheme)?;
    }
    write((14.0, foot), (15.0, false, INK), Anchor::Start, &animation.clocks[frame])?;
    write((width - 14.0, foot), (13.0, false, QUIET), Anchor::End, &animation.title)
}

fn draw_shapes<B: DrawingBackend>(area: &DrawingArea<B, Shift>, shapes: &[Shape], scheme: Color) -> Drawn<B> {
    let pen = Pen::new(area, UNITS * SCALE);
    for Shape { role, x, y, text } in shapes {
        let points: Vec<(f64, f64)> = x.iter().copied().zip(y.iter().copied()).collect();
        let Some(first) = points.first() else { continue };
        match (style(*role, scheme), text) {
            (Style::Area(color), _) => pen.fill(&points, color)?,
            (Style::Outlined(color, stroke), _) => {
                pen.fill(&points, color)?;
                pen.line(&[&points[..], &[*first]].concat(), &stroke)?;
            }
            (Style::Line(stroke), _) => pen.line(&points, &stroke)?,
            (Style::Text(size, is_bold, color), Some((anchor, text))) => {
                pen.text(&Text { size: size / SCALE, is_bold, color, ..Text::new(text, *first, *anchor) })?;
            }
            (Style::Text(..), None) => {}
        }
    }
    Ok(())
}

/// First column and row of the changes, and the ones after their end.
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

fn part(pixmap: &Pixmap, from: (u32, u32), to: (u32, u32)) -> Vec<u8> {
    let columns = 4 * from.0 as usize..4 * to.0 as usize;
    let within = rows(pixmap).skip(from.1 as usize).take((to.1 - from.1) as usize);
    within.map(|row| &row[columns.clone()]).collect::<Vec<_>>().concat()
}

fn rows(pixmap: &Pixmap) -> impl Iterator<Item = &[u8]> {
    pixmap.data().chunks_exact(4 * pixmap.width() as usize)
}

#[cfg(test)]
mod tests {
    use super::*;
    use trocar_scenario::{Scenario, Source};
    use trocar_studies::animation::animation_with_pictures;
    use trocar_studies::run::run;

    #[test]
    fn a_pair_of_runs_is_an_animated_picture_of_every_third_frame() {
        let shipped = |name: &str| run(Scenario::load(&Source::parse(name), &[]).expect("a scenario")).expect("a run");
        let runs = ["layers/through-the-skin", "layers/skin-augmented"].map(shipped);
        let animation = animation_with_pictures(&runs.each_ref()).expect("an animation");
        let png = animated_png(&animation).expect("a picture");
        let reader = png::Decoder::new(std::io::Cursor::new(&png)).read_info().expect("a PNG file");
        assert_eq!(reader.info().animation_control().map(|control| control.num_frames), Some(51));
        assert!(png.len() < 1_000_000, "{} bytes", png.len());
    }
}
