//! Sizes, colours and line styles, in points (1/72 in).
//!
//! The colours by Okabe and Ito are distinguishable for the common forms of colour blindness; width and dashes
//! distinguish lines in grey print. A colour has one meaning in all figures:
//!
//! | colour | meaning |
//! |---|---|
//! | blue, dashed | classical teleoperation |
//! | vermilion | augmented teleoperation |
//! | sky blue, wide | tissue: its force on the needle |
//! | green, dotted | hand: the master and the felt force |
//! | black | estimator, detector and analysis; alarms |
//! | purple | limits and thresholds |
//! | orange, pale | frozen, held and re-engaging |
//! | grey, pale | an event without a hold |
//! | grey | ruptures, guides |
//!
//! With more lines of one kind, for example detectors, [`LINES`] continues with the other colours.

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Color(pub u8, pub u8, pub u8);

/// A page's theme has a light and a dark version of each.
pub const NAMES: [(&str, Color); 10] = [
    ("page", WHITE),
    ("grid", GRID),
    ("grey", GREY),
    ("black", BLACK),
    ("orange", ORANGE),
    ("sky", SKY),
    ("green", GREEN),
    ("blue", BLUE),
    ("vermilion", VERMILION),
    ("purple", PURPLE),
];

impl Color {
    pub fn hex(self) -> String {
        format!("#{:02x}{:02x}{:02x}", self.0, self.1, self.2)
    }

    /// Colours without a name are the same in every theme.
    pub fn css(self) -> String {
        if let Some((name, _)) = NAMES.iter().find(|(_, color)| *color == self) {
            return format!("var(--{name})");
        }
        let pale = |(name, color): &(&str, Self)| {
            let percent = (1..100).find(|percent| color.pale(f64::from(*percent) / 100.0) == self)?;
            Some(format!("color-mix(in srgb, var(--{name}) {percent}%, transparent)"))
        };
        NAMES[2..].iter().find_map(pale).unwrap_or_else(|| self.hex())
    }

    /// On white paper, with a coverage of 0 to 1.
    pub const fn pale(self, coverage: f64) -> Self {
        const fn mix(channel: u8, coverage: f64) -> u8 {
            (255.0 + coverage * (channel as f64 - 255.0) + 0.5) as u8
        }
        Self(mix(self.0, coverage), mix(self.1, coverage), mix(self.2, coverage))
    }
}

pub const WHITE: Color = Color(0xff, 0xff, 0xff);
pub const BLACK: Color = Color(0x1a, 0x1a, 0x1a);
pub const GREY: Color = Color(0x6e, 0x6e, 0x6e);
pub const GRID: Color = Color(0xe3, 0xe3, 0xe3);
pub const ORANGE: Color = Color(0xe6, 0x9f, 0x00);
pub const SKY: Color = Color(0x56, 0xb4, 0xe9);
pub const GREEN: Color = Color(0x00, 0x9e, 0x73);
pub const BLUE: Color = Color(0x00, 0x72, 0xb2);
pub const VERMILION: Color = Color(0xd5, 0x5e, 0x00);
pub const PURPLE: Color = Color(0xcc, 0x79, 0xa7);

/// Dashes are `(on, off, on, off …)`, empty for a solid line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stroke {
    pub color: Color,
    /// In points.
    pub width: f64,
    /// In points.
    pub dashes: &'static [f64],
}

impl Stroke {
    pub const fn solid(color: Color, width: f64) -> Self {
        Self { color, width, dashes: &[] }
    }

    pub const fn dashed(color: Color, width: f64, dashes: &'static [f64]) -> Self {
        Self { color, width, dashes }
    }
}

pub const FRAME: Stroke = Stroke::solid(BLACK, 0.6);
pub const MESH: Stroke = Stroke::solid(GRID, 0.5);
pub const TISSUE: Stroke = Stroke::solid(SKY, 2.4);
/// The master, and the felt force.
pub const HAND: Stroke = Stroke::dashed(GREEN, 1.3, &[1.5, 1.7]);
/// In the same axes as another run.
pub const HAND_OF_CLASSICAL: Stroke = Stroke::dashed(GREEN, 0.9, &[5.0, 2.5]);
pub const CLASSICAL: Stroke = Stroke::dashed(BLUE, 1.1, &[6.0, 1.8]);
pub const AUGMENTED: Stroke = Stroke::solid(VERMILION, 1.2);
pub const COMPUTED: Stroke = Stroke::solid(BLACK, 0.9);
pub const LIMIT: Stroke = Stroke::dashed(PURPLE, 1.1, &[7.0, 2.5, 1.2, 2.5]);
pub const GUIDE: Stroke = Stroke::solid(GREY, 0.6);
pub const RUPTURE: Stroke = Stroke::dashed(GREY, 0.8, &[2.2, 2.2]);

pub const LINES: [Stroke; 12] = [
    CLASSICAL,
    AUGMENTED,
    Stroke::dashed(BLACK, 1.0, &[1.4, 2.4]),
    Stroke::dashed(GREY, 1.6, &[9.0, 3.0, 1.5, 3.0]),
    Stroke::solid(PURPLE, 0.9),
    Stroke::dashed(ORANGE, 1.6, &[11.0, 4.5]),
    Stroke::dashed(GREEN, 1.3, &[3.5, 3.5]),
    Stroke::dashed(SKY, 2.0, &[3.0, 5.0]),
    Stroke::dashed(VERMILION, 0.8, &[2.0, 6.0]),
    Stroke::solid(BLUE, 0.6),
    Stroke::dashed(PURPLE, 2.2, &[1.5, 8.0]),
    Stroke::solid(BLACK, 0.5),
];

/// Fixed styles for the first classical and the first augmented run; the others follow [`LINES`].
pub fn of_runs(is_augmented: impl IntoIterator<Item = bool>) -> Vec<Stroke> {
    let mut seen = [false; 2];
    let mut others = LINES[2..].iter().cycle();
    let mut style = |is_augmented: bool| {
        if std::mem::replace(&mut seen[usize::from(is_augmented)], true) {
            *others.next().unwrap_or(&COMPUTED)
        } else if is_augmented {
            AUGMENTED
        } else {
            CLASSICAL
        }
    };
    is_augmented.into_iter().map(&mut style).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_colour_on_a_page_is_the_themes_colour_with_its_coverage() {
        assert_eq!(VERMILION.css(), "var(--vermilion)");
        assert_eq!(WHITE.css(), "var(--page)");
        assert_eq!(ORANGE.pale(0.34).css(), "color-mix(in srgb, var(--orange) 34%, transparent)");
        assert_eq!(GREY.pale(0.45).css(), "color-mix(in srgb, var(--grey) 45%, transparent)");
        assert_eq!(Color(0x44, 0x01, 0x54).css(), "#440154");
    }
}
