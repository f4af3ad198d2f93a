use std::fmt;
use std::str::FromStr;

const POINTS_PER_INCH: f64 = 72.0;
const MM_PER_INCH: f64 = 25.4;
const MIN_WIDTH_IN: f64 = 2.5;
const MAX_WIDTH_IN: f64 = 20.0;

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum FigureFormat {
    Svg,
    /// At 300 dots per inch.
    Png,
    Pdf,
}

impl FigureFormat {
    pub const ALL: [Self; 3] = [Self::Png, Self::Svg, Self::Pdf];
}

impl fmt::Display for FigureFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Svg => "svg",
            Self::Png => "png",
            Self::Pdf => "pdf",
        })
    }
}

/// From 2.5 in to 20 in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FigureWidth {
    inches: f64,
}

impl Default for FigureWidth {
    /// A page with two columns, 7.16 in.
    fn default() -> Self {
        Self { inches: 7.16 }
    }
}

impl FigureWidth {
    pub(crate) fn points(self) -> f64 {
        POINTS_PER_INCH * self.inches
    }
}

impl FromStr for FigureWidth {
    type Err = String;

    /// Parses a number with a unit: in, mm or cm.
    fn from_str(text: &str) -> Result<Self, String> {
        let units = [("in", 1.0), ("mm", 1.0 / MM_PER_INCH), ("cm", 10.0 / MM_PER_INCH)];
        let parsed = units.into_iter().find_map(|(unit, inches)| {
            let number: f64 = text.trim().strip_suffix(unit)?.trim_end().parse().ok()?;
            Some(inches * number)
        });
        let inches = parsed.ok_or("write a number with its unit: 3.5in, 89mm or 8.9cm")?;
        if (MIN_WIDTH_IN..=MAX_WIDTH_IN).contains(&inches) {
            Ok(Self { inches })
        } else {
            Err(format!("must be from {MIN_WIDTH_IN} to {MAX_WIDTH_IN} in (63.5 to 508 mm)"))
        }
    }
}

#[derive(Clone, Debug, PartialEq)]
pub struct FigureStyle {
    pub width: FigureWidth,
    pub formats: Vec<FigureFormat>,
}

impl Default for FigureStyle {
    /// SVG and PNG with the width of a page.
    fn default() -> Self {
        Self { width: FigureWidth::default(), formats: vec![FigureFormat::Svg, FigureFormat::Png] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn widths_have_units_and_limits() {
        let points = |text: &str| text.parse::<FigureWidth>().map(FigureWidth::points);
        assert_eq!(points("3.5in"), Ok(252.0));
        assert!(points("88.9 mm").is_ok_and(|points| (points - 252.0).abs() < 1e-9));
        assert_eq!(points("8.89cm").map(f64::round), Ok(252.0));
        for wrong in ["3.5", "in", "2in", "600mm", "NaN in", "-3in"] {
            assert!(points(wrong).is_err(), "{wrong}");
        }
    }
}
