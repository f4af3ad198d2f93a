//! Figures as SVG. Texts stay texts, so that they can be searched and edited.

use std::fmt::Write as _;

use super::fonts::FAMILY;
use super::page::{Anchor, Item, Page, Point, Text, is_rectangle};
use super::style::{Color, TEXT};

impl Page {
    /// Returns the SVG document. Its size is in points.
    pub(super) fn svg(&self) -> String {
        let (width, height) = (Decimal(self.width), Decimal(self.height));
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}pt\" height=\"{height}pt\" viewBox=\"0 0 {width} \
             {height}\" font-family=\"{FAMILY}\" font-size=\"{TEXT}\" stroke-linejoin=\"round\">\n\
             <rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n"
        );
        for item in &self.items {
            // Writing to a string does not fail.
            let _ = item.write(&mut svg);
        }
        svg.push_str("</svg>\n");
        svg
    }
}

impl Item {
    fn write(&self, svg: &mut String) -> std::fmt::Result {
        match self {
            Self::Lines(lines, stroke) => {
                let path: String = lines.iter().map(|line| path(line)).collect();
                let (color, width) = (hex(stroke.color), Decimal(stroke.width));
                write!(svg, "<path d=\"{path}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"{width}\"")?;
                match stroke.dashes {
                    [] => svg.push_str(" stroke-linecap=\"round\"/>\n"),
                    dashes => {
                        let dashes: Vec<String> = dashes.iter().map(|length| Decimal(*length).to_string()).collect();
                        writeln!(svg, " stroke-dasharray=\"{}\"/>", dashes.join(" "))?;
                    }
                }
            }
            Self::Area(outline, color) => {
                let edges = if is_rectangle(outline) { " shape-rendering=\"crispEdges\"" } else { "" };
                writeln!(svg, "<path d=\"{}Z\" fill=\"{}\"{edges}/>", path(outline), hex(*color))?;
            }
            Self::Dot((x, y), radius, color) => {
                let (x, y, radius, color) = (Decimal(*x), Decimal(*y), Decimal(*radius), hex(*color));
                writeln!(svg, "<circle cx=\"{x}\" cy=\"{y}\" r=\"{radius}\" fill=\"{color}\"/>")?;
            }
            Self::Text(text) => text.write(svg)?,
        }
        Ok(())
    }
}

impl Text {
    fn write(&self, svg: &mut String) -> std::fmt::Result {
        let (x, y) = (Decimal(self.at.0), Decimal(self.at.1));
        write!(svg, "<text x=\"{x}\" y=\"{y}\"")?;
        match self.anchor {
            Anchor::Start => {}
            Anchor::Middle => svg.push_str(" text-anchor=\"middle\""),
            Anchor::End => svg.push_str(" text-anchor=\"end\""),
        }
        if self.is_bold {
            svg.push_str(" font-weight=\"bold\"");
        }
        if self.is_upright {
            write!(svg, " transform=\"rotate(-90 {x} {y})\"")?;
        }
        let text = self.text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
        writeln!(svg, ">{text}</text>")
    }
}

/// Returns a path from point to point.
fn path(points: &[Point]) -> String {
    let mut path = String::with_capacity(12 * points.len());
    for (index, (x, y)) in points.iter().enumerate() {
        let command = match index {
            0 => "M",
            1 => "L",
            _ => " ",
        };
        let _ = write!(path, "{command}{} {}", Decimal(*x), Decimal(*y));
    }
    path
}

fn hex(Color(red, green, blue): Color) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}

/// A number with at most two decimals.
struct Decimal(f64);

impl std::fmt::Display for Decimal {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let hundredths = (100.0 * self.0).round() as i64;
        let (sign, hundredths) = (if hundredths < 0 { "-" } else { "" }, hundredths.unsigned_abs());
        match (hundredths / 100, hundredths % 100) {
            (whole, 0) => write!(out, "{sign}{whole}"),
            (whole, rest) if rest % 10 == 0 => write!(out, "{sign}{whole}.{}", rest / 10),
            (whole, rest) => write!(out, "{sign}{whole}.{rest:02}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        let numbers = [0.0, -0.001, 12.0, 1.5, -0.25, 3.049, 1e-9].map(|value| Decimal(value).to_string());
        assert_eq!(numbers, ["0", "0", "12", "1.5", "-0.25", "3.05", "0"]);
    }
}
