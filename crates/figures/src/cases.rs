use trocar_document::figure::{
    Axis, COMPUTED, Figure, Panel, Row, SKY, Sample, Series, Stroke, X_TICKS, Y_TICKS, extent,
};

const CASE: Stroke = Stroke::solid(SKY, 2.5);

pub struct CasesView<'a> {
    pub x_caption: String,
    pub is_log: bool,
    pub y_caption: String,
    /// Value of the axis and of the metric in each case.
    pub cases: &'a [(f64, f64)],
    pub medians: &'a [(f64, f64)],
}

/// Draws each case as a dot, and a line through the medians.
pub fn cases(view: &CasesView<'_>) -> Figure<'static> {
    let range = extent(view.cases.iter().map(|case| case.0)).unwrap_or((0.0, 1.0));
    let x = if view.is_log { Axis::log10(range) } else { Axis::padded(range, X_TICKS) };
    let y = Axis::padded(extent(view.cases.iter().map(|case| case.1)).unwrap_or((0.0, 1.0)), Y_TICKS);
    // Gaps between the cases prevent connecting lines.
    let dots = view.cases.iter().flat_map(|(at, value)| [(x.place(*at), *value), (x.place(*at), f64::NAN)]);
    let (dot_x, dot_y): (Vec<f64>, Vec<f64>) = dots.unzip();
    let (median_x, median_y): (Vec<f64>, Vec<f64>) =
        view.medians.iter().map(|(at, value)| (x.place(*at), *value)).unzip();
    let panel = Panel {
        series: vec![Series::new(dot_x, dot_y, CASE), Series::new(median_x, median_y, COMPUTED)],
        legend: vec![(Sample::Dot(CASE), "cases".to_owned()), (Sample::Line(COMPUTED), "median".to_owned())],
        ..Panel::new(x, view.x_caption.as_str(), y, view.y_caption.as_str())
    };
    Figure { name: String::new(), legend: vec![], rows: vec![Row::of(130.0, panel)] }
}
