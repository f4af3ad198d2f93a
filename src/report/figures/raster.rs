//! An anti-aliased bitmap: filled rectangles and polygons, round-jointed lines, discs, and its PNG.
//!
//! It stands in for plotters' bitmap backend, whose wide lines have ragged joints and whose encoder is slow.

use plotters_backend::BackendColor;

use super::FigureError;

/// An RGB image; coordinates are in pixels from the top left corner.
pub(super) struct Raster {
    width: usize,
    height: usize,
    rgb: Vec<u8>,
    /// Coverage of the shape being drawn, so that where a line crosses itself it is not blended twice; all zero between shapes.
    coverage: Vec<u8>,
}

impl Raster {
    /// A white image.
    pub(super) fn new(width: usize, height: usize) -> Self {
        Self { width, height, rgb: vec![255; width * height * 3], coverage: vec![0; width * height] }
    }

    /// Blends `color` over one pixel; nothing happens outside the image.
    pub(super) fn blend(&mut self, x: i32, y: i32, color: BackendColor, coverage: f32) {
        if x < 0 || y < 0 || x as usize >= self.width || y as usize >= self.height {
            return;
        }
        let at = (y as usize * self.width + x as usize) * 3;
        let pixel = &mut self.rgb[at..at + 3];
        let over = mixed([pixel[0], pixel[1], pixel[2]], color, coverage);
        pixel.copy_from_slice(&over);
    }

    /// Fills a rectangle, its edges rounded to whole pixels.
    pub(super) fn rectangle(&mut self, from: (f32, f32), to: (f32, f32), color: BackendColor) {
        let (left, right) = self.columns(from.0.round(), to.0.round() - 1.0);
        let (top, bottom) = self.rows(from.1.round(), to.1.round() - 1.0);
        let (r, g, b) = color.rgb;
        // Most pixels of a row are alike: blend each run of equal ones once.
        let mut known = ([r, g, b], [r, g, b]);
        for y in top..bottom {
            let row = y * self.width;
            let (start, end) = ((row + left) * 3, (row + right) * 3);
            for pixel in self.rgb[start..end].chunks_exact_mut(3) {
                if pixel != known.0 {
                    known.0.copy_from_slice(pixel);
                    known.1 = mixed(known.0, color, 1.0);
                }
                pixel.copy_from_slice(&known.1);
            }
        }
    }

    /// Draws a line through `points` with round joints and ends.
    pub(super) fn line(&mut self, points: &[(f32, f32)], width: f32, color: BackendColor) {
        let radius = width.max(1.0) / 2.0;
        let reach = radius + 1.0;
        let mut touched = Bounds::EMPTY;
        for pair in points.windows(2) {
            let (a, b) = (pair[0], pair[1]);
            let (dx, dy) = (b.0 - a.0, b.1 - a.1);
            let length_squared = dx * dx + dy * dy;
            let (top, bottom) = self.rows(a.1.min(b.1) - reach, a.1.max(b.1) + reach);
            for y in top..bottom {
                let cy = y as f32 + 0.5;
                let (x0, x1) = row_span(a, (dx, dy), cy, reach);
                let (left, right) = self.columns(x0 - reach, x1 + reach);
                touched.add(left, right, y);
                for x in left..right {
                    let cx = x as f32 + 0.5;
                    let along = if length_squared > 0.0 {
                        (((cx - a.0) * dx + (cy - a.1) * dy) / length_squared).clamp(0.0, 1.0)
                    } else {
                        0.0
                    };
                    let (ox, oy) = (cx - a.0 - along * dx, cy - a.1 - along * dy);
                    let inside = radius + 0.5 - (ox * ox + oy * oy).sqrt();
                    self.cover(x, y, inside);
                }
            }
        }
        self.composite(&touched, color);
    }

    /// Fills a disc.
    pub(super) fn disc(&mut self, center: (f32, f32), radius: f32, color: BackendColor) {
        self.line(&[center, center], 2.0 * radius, color);
    }

    /// Fills a polygon (even-odd rule), four scan lines to the pixel.
    pub(super) fn polygon(&mut self, points: &[(f32, f32)], color: BackendColor) {
        const SCANS: usize = 4;
        let Some(&last) = points.last() else { return };
        let low = points.iter().fold(f32::INFINITY, |m, p| m.min(p.1));
        let high = points.iter().fold(f32::NEG_INFINITY, |m, p| m.max(p.1));
        let (top, bottom) = self.rows(low, high);
        let mut crossings = Vec::new();
        let mut row = vec![0.0_f32; self.width];
        for y in top..bottom {
            row.fill(0.0);
            for scan in 0..SCANS {
                let sy = y as f32 + (scan as f32 + 0.5) / SCANS as f32;
                crossings.clear();
                let mut before = last;
                for &p in points {
                    if (before.1 <= sy) != (p.1 <= sy) {
                        let part = (sy - before.1) / (p.1 - before.1);
                        crossings.push(before.0 + part * (p.0 - before.0));
                    }
                    before = p;
                }
                crossings.sort_by(f32::total_cmp);
                for pair in crossings.chunks_exact(2) {
                    let (left, right) = self.columns(pair[0], pair[1]);
                    for (x, sum) in row[left..right].iter_mut().enumerate() {
                        let edge = (left + x) as f32;
                        let part = pair[1].min(edge + 1.0) - pair[0].max(edge);
                        *sum += part.clamp(0.0, 1.0) / SCANS as f32;
                    }
                }
            }
            for (x, &sum) in row.iter().enumerate() {
                if sum > 0.0 {
                    self.blend(x as i32, y as i32, color, sum);
                }
            }
        }
    }

    /// The image as a PNG. Fast compression: lines on white compress well at any setting.
    pub(super) fn png(&self) -> Result<Vec<u8>, FigureError> {
        let mut bytes = Vec::with_capacity(1 << 17);
        let mut encoder = png::Encoder::new(&mut bytes, self.width as u32, self.height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_compression(png::Compression::Fast);
        encoder.set_filter(png::FilterType::Up);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&self.rgb)?;
        writer.finish()?;
        Ok(bytes)
    }

    fn cover(&mut self, x: usize, y: usize, inside: f32) {
        if inside > 0.0 {
            let cell = &mut self.coverage[y * self.width + x];
            *cell = (*cell).max((inside.min(1.0) * 255.0 + 0.5) as u8);
        }
    }

    fn composite(&mut self, touched: &Bounds, color: BackendColor) {
        for y in touched.top..touched.bottom {
            for x in touched.left..touched.right {
                let covered = std::mem::take(&mut self.coverage[y * self.width + x]);
                if covered > 0 {
                    self.blend(x as i32, y as i32, color, f32::from(covered) / 255.0);
                }
            }
        }
    }

    fn columns(&self, from: f32, to: f32) -> (usize, usize) {
        clipped(from, to, self.width)
    }

    fn rows(&self, from: f32, to: f32) -> (usize, usize) {
        clipped(from, to, self.height)
    }
}

/// `color` over `under`.
fn mixed(under: [u8; 3], color: BackendColor, coverage: f32) -> [u8; 3] {
    let alpha = (color.alpha as f32 * coverage).clamp(0.0, 1.0);
    let (r, g, b) = color.rgb;
    let mut over = [r, g, b];
    for (over, under) in over.iter_mut().zip(under) {
        let under = f32::from(under);
        *over = (under + (f32::from(*over) - under) * alpha + 0.5) as u8;
    }
    over
}

/// The pixels `from..=to` touches, clipped to `size`.
fn clipped(from: f32, to: f32, size: usize) -> (usize, usize) {
    let start = from.floor().max(0.0) as usize;
    let end = (to.floor() + 1.0).max(0.0) as usize;
    (start.min(size), end.min(size).max(start.min(size)))
}

/// The horizontal extent of the part of a segment within `reach` rows of `y`.
fn row_span(a: (f32, f32), d: (f32, f32), y: f32, reach: f32) -> (f32, f32) {
    let (s, t) = if d.1.abs() > 1e-6 {
        let (s, t) = ((y - reach - a.1) / d.1, (y + reach - a.1) / d.1);
        (s.clamp(0.0, 1.0), t.clamp(0.0, 1.0))
    } else {
        (0.0, 1.0)
    };
    let (x0, x1) = (a.0 + s * d.0, a.0 + t * d.0);
    (x0.min(x1), x0.max(x1))
}

/// The pixels a shape may have touched.
struct Bounds {
    left: usize,
    right: usize,
    top: usize,
    bottom: usize,
}

impl Bounds {
    const EMPTY: Self = Self { left: usize::MAX, right: 0, top: usize::MAX, bottom: 0 };

    fn add(&mut self, left: usize, right: usize, y: usize) {
        self.left = self.left.min(left);
        self.right = self.right.max(right);
        self.top = self.top.min(y);
        self.bottom = self.bottom.max(y + 1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BLACK: BackendColor = BackendColor { alpha: 1.0, rgb: (0, 0, 0) };

    fn ink(raster: &Raster) -> f32 {
        raster.rgb.iter().step_by(3).map(|&v| 1.0 - f32::from(v) / 255.0).sum()
    }

    #[test]
    fn shapes_cover_their_area() {
        let mut raster = Raster::new(40, 40);
        raster.line(&[(10.0, 20.5), (30.0, 20.5)], 3.0, BLACK);
        assert!((ink(&raster) - 67.0).abs() < 2.0, "{}", ink(&raster));
        let mut raster = Raster::new(40, 40);
        raster.polygon(&[(10.0, 10.0), (30.0, 10.0), (20.0, 30.0)], BLACK);
        assert!((ink(&raster) - 200.0).abs() < 2.0, "{}", ink(&raster));
    }

    #[test]
    fn shapes_outside_are_clipped() {
        let mut raster = Raster::new(8, 8);
        raster.line(&[(-1e7, -1e7), (1e7, 1e7)], 3.0, BLACK);
        raster.disc((-50.0, 3.0), 4.0, BLACK);
        raster.polygon(&[(-9.0, -9.0), (99.0, -9.0), (99.0, 99.0)], BLACK);
        raster.rectangle((5.0, 5.0), (-5.0, -5.0), BLACK);
        assert!(raster.png().is_ok());
    }
}
