use super::FigureError;
use trocar_document::figure::{Axis, BLACK, Color, Figure, GREY, GUIDE, Panel, Point, Row, Sample, X_TICKS};

const MAX_BARS: usize = 100;

#[derive(Clone, Debug)]
pub struct InfluenceBar {
    pub title: String,
    /// First-order Sobol index, 0 to 1.
    pub share: Option<f64>,
    /// Standardised rank regression coefficient.
    pub slope: Option<f64>,
}

const SLOPE: Color = BLACK;
const SHARE: Color = GREY.pale(0.45);

/// Draws two bars per metric and axis: the rank regression coefficient above, the first-order Sobol index below.
pub fn tornado(name: &str, bars: &[InfluenceBar]) -> Result<Figure<'static>, FigureError> {
    let bar = |value: f64, (low, high): (f64, f64)| -> Vec<Point> {
        let value = value.clamp(-1.05, 1.05);
        vec![(0.0, low), (value, low), (value, high), (0.0, high)]
    };
    let row = |InfluenceBar { title, share, slope }: &InfluenceBar| {
        let slope = slope.map(|slope| (bar(slope, (0.5, 0.9)), SLOPE));
        let share = share.map(|share| (bar(share, (0.1, 0.5)), SHARE));
        let panel = Panel {
            fills: slope.into_iter().chain(share).collect(),
            curves: vec![(vec![(0.0, 0.0), (0.0, 1.0)], GUIDE)],
            ..Panel::new(Axis::exact((-1.05, 1.05), X_TICKS), "Influence", Axis::exact((0.0, 1.0), 0), "")
        };
        Row { title: Some(title.clone()), ..Row::of(14.0, panel) }
    };
    let rows: Vec<Row<'_>> = bars.iter().take(MAX_BARS).map(row).collect();
    if rows.is_empty() {
        return Err(FigureError::Empty { figure: "tornado" });
    }
    let legend = [
        (SLOPE, "standardised rank regression coefficient (to the right: increases with the axis)"),
        (SHARE, "first-order Sobol index"),
    ];
    Ok(Figure {
        name: name.to_owned(),
        legend: legend.map(|(color, text)| (Sample::Shade(color), text.to_owned())).into(),
        rows,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shown;

    #[test]
    fn every_bar_has_its_title() {
        let bar = |title: &str, share, slope| InfluenceBar { title: title.to_owned(), share, slope };
        let bars = [
            bar("overshoot, by scaling.force", Some(0.8), Some(-0.9)),
            bar("overshoot, by arm.grip", Some(0.1), None),
            bar("delay (hardly changes)", None, None),
        ];
        let text = shown(&tornado("sweep", &bars).expect("drawn"));
        for InfluenceBar { title, .. } in &bars {
            assert!(text.contains(&format!("\"{title}\"")), "{title}");
        }
        assert!(matches!(tornado("", &[]), Err(FigureError::Empty { .. })));
    }
}
