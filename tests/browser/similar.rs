//! Perceptual comparison of screenshots by the mean colours of small blocks. The smoothing of letters and lines
//! differs between machines, but hardly changes a mean.

use std::path::Path;

/// Width and height of a block, in pixels.
const BLOCK: usize = 16;

/// Difference of a mean colour, on the scale of 255, above which a block has changed.
const CHANGED: f64 = 24.0;

const MAX_SHARE: f64 = 0.05;

/// Compares a screenshot with the file of this name. `BLESS=1` writes the file.
pub fn assert_similar(name: &str, screenshot: &[u8]) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/browser/screens").join(format!("{name}.png"));
    if std::env::var_os("BLESS").is_some() {
        std::fs::create_dir_all(path.parent().expect("a folder")).expect("created");
        std::fs::write(&path, screenshot).expect("written");
    }
    let expected = std::fs::read(&path).expect("a screenshot; BLESS=1 writes it");
    let share = changed_share(&expected, screenshot);
    if share > MAX_SHARE {
        let now = std::env::temp_dir().join(format!("{name}.png"));
        std::fs::write(&now, screenshot).expect("written");
        panic!("{name}: {:.1} % of the blocks differ from {}; see {}", 100.0 * share, path.display(), now.display());
    }
}

/// Returns the fraction of differing blocks; 1 for pictures of different sizes.
pub fn changed_share(one: &[u8], other: &[u8]) -> f64 {
    let ((size, one), (other_size, other)) = (blocks(one), blocks(other));
    if size != other_size {
        return 1.0;
    }
    let differs = |(a, b): &(&[f64; 3], &[f64; 3])| a.iter().zip(*b).any(|(a, b)| (a - b).abs() > CHANGED);
    one.iter().zip(&other).filter(differs).count() as f64 / one.len() as f64
}

/// Returns the size of a picture and the mean colours of its blocks.
fn blocks(bytes: &[u8]) -> ((u32, u32), Vec<[f64; 3]>) {
    let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().expect("a PNG file");
    let mut pixels = vec![0; reader.output_buffer_size().expect("a small picture")];
    let info = reader.next_frame(&mut pixels).expect("a picture");
    let channels = info.color_type.samples();
    let (width, height) = (info.width as usize, info.height as usize);
    let mut means = vec![];
    for top in (0..height).step_by(BLOCK) {
        for left in (0..width).step_by(BLOCK) {
            let (rows, columns) = (top..(top + BLOCK).min(height), left..(left + BLOCK).min(width));
            let count = (rows.len() * columns.len()) as f64;
            let mut mean = [0.0; 3];
            for at in rows.flat_map(|row| columns.clone().map(move |column| (row * width + column) * channels)) {
                for (mean, value) in mean.iter_mut().zip(&pixels[at..at + 3]) {
                    *mean += f64::from(*value) / count;
                }
            }
            means.push(mean);
        }
    }
    ((info.width, info.height), means)
}
