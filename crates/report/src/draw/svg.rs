//! Texts stay texts for search and editing.

use std::fmt::Write as _;

use plotters::prelude::SVGBackend;

use super::layout::Sheet;
use super::{DrawError, UNITS};

pub(super) fn document(sheet: &Sheet<'_>) -> Result<String, DrawError> {
    let mut drawn = String::new();
    let (width, height) = sheet.size();
    sheet.draw_on(SVGBackend::with_string(&mut drawn, (width, height)))?;
    // The backend has no points as units, no line ends, and no crisp edges against seams.
    let (_, body) = drawn.split_once('\n').unwrap_or_default();
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{}pt\" height=\"{}pt\" viewBox=\"0 0 {width} {height}\" \
         stroke-linejoin=\"round\" stroke-linecap=\"round\">\n\
         <style>rect{{shape-rendering:crispEdges}}</style>\n\
         <rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n",
        f64::from(width) / UNITS,
        f64::from(height) / UNITS
    );
    join(body, &mut svg);
    Ok(svg)
}

fn join(body: &str, svg: &mut String) {
    let mut style = "";
    for line in body.lines() {
        let points =
            line.strip_prefix("<polyline ").and_then(|line| line.strip_suffix(" \"/>")?.split_once(" points=\""));
        let next = points.map_or("", |(next, _)| next);
        if !style.is_empty() && next != style {
            svg.push_str("\"/>\n");
        }
        let _ = match points {
            Some((_, points)) if next == style => write!(svg, "M{points}"),
            Some((_, points)) => write!(svg, "<path {next} d=\"M{points}"),
            // A text has no spaces around it.
            None if line.starts_with("<text") || !line.starts_with('<') => write!(svg, "{line}"),
            None => writeln!(svg, "{line}"),
        };
        style = next;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dashes_are_one_path() {
        let line = |width: u32, points: &str| format!("<polyline stroke-width=\"{width}\" points=\"{points} \"/>\n");
        let body = [line(1, "0,0 1,0"), line(1, "2,0 3,0"), line(2, "0,1 1,1"), "</svg>\n".to_owned()].concat();
        let mut svg = String::new();
        join(&body, &mut svg);
        let path = |width: u32, data: &str| format!("<path stroke-width=\"{width}\" d=\"{data}\"/>\n");
        assert_eq!(svg, [path(1, "M0,0 1,0M2,0 3,0"), path(2, "M0,1 1,1"), "</svg>\n".to_owned()].concat());
    }
}
