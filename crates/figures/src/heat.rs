use super::FigureError;
use trocar_document::figure::{Axis, Color, Entry, Figure, Panel, Row, Sample, X_TICKS, Y_TICKS, extent};
use trocar_document::{decimals, significant};

/// Five evenly spaced colours of viridis (van der Walt and Smith 2015), from low to high values. The lightness is
/// uniform, so the colours differ in grey and for the common forms of colour blindness.
const SCALE: [(u8, u8, u8); 5] =
    [(0x44, 0x01, 0x54), (0x3b, 0x52, 0x8b), (0x21, 0x91, 0x8c), (0x5e, 0xc9, 0x62), (0xfd, 0xe7, 0x25)];

const LEAST_RANGE: f64 = 0.05;

const STEPS: usize = 6;

#[derive(Clone, Copy, Debug)]
pub struct AxisView<'a> {
    pub name: &'a str,
    /// True if the axis is logarithmic. Its values are then positive.
    pub log: bool,
}

#[derive(Clone, Debug)]
pub struct HeatView<'a> {
    pub name: &'a str,
    /// Quantity and unit.
    pub caption: &'a str,
    pub axes: [AxisView<'a>; 2],
    /// Horizontal centres, ascending.
    pub x: Vec<f64>,
    /// Vertical centres, ascending.
    pub y: Vec<f64>,
    /// Row by row. A cell with NaN stays white.
    pub means: &'a [f64],
}

/// One rectangle per cell.
pub fn heat_map(view: &HeatView<'_>) -> Result<Figure<'static>, FigureError> {
    super::check("heat map", view.caption, view.x.len() * view.y.len(), &[("means", view.means.len())])?;
    let (min, max) = wide(extent(view.means.iter().copied()).unwrap_or((0.0, 0.0)));
    let color = |value: f64| color(if max > min { (value - min) / (max - min) } else { 0.5 });
    let [x_axis, y_axis] = &view.axes;
    let (x_edges, y_edges) = (edges(&view.x, x_axis.log), edges(&view.y, y_axis.log));
    let (mut fills, mut measurements) = (vec![], vec![]);
    for (row, means) in view.means.chunks(view.x.len()).enumerate() {
        for (column, mean) in means.iter().enumerate().filter(|(_, mean)| mean.is_finite()) {
            let (left, right, low, high) = (x_edges[column], x_edges[column + 1], y_edges[row], y_edges[row + 1]);
            fills.push((vec![(left, low), (right, low), (right, high), (left, high)], color(*mean)));
            measurements.push(significant(*mean));
        }
    }
    let axis = |edges: &[f64], log: bool, ticks: usize| {
        let ends = (edges[0], edges[edges.len() - 1]);
        if log { Axis::log10((10_f64.powf(ends.0), 10_f64.powf(ends.1))) } else { Axis::exact(ends, ticks) }
    };
    let (x, y) = (axis(&x_edges, x_axis.log, X_TICKS), axis(&y_edges, y_axis.log, Y_TICKS));
    let steps = if max > min { STEPS } else { 1 };
    let values: Vec<f64> = (0..steps).map(|k| min + (max - min) * k as f64 / (STEPS - 1) as f64).collect();
    let steps = values.iter().zip(alike(&values)).map(|(value, number)| (Sample::Shade(color(*value)), number));
    let caption: Entry = (Sample::Title, view.caption.to_owned());
    let panel = Panel {
        fills,
        measurements,
        legend: std::iter::once(caption).chain(steps).collect(),
        ..Panel::new(x, x_axis.name, y, y_axis.name)
    };
    Ok(Figure { name: view.name.to_owned(), legend: vec![], rows: vec![Row::of(205.0, panel)] })
}

/// Widens a small range to [`LEAST_RANGE`] of its larger end, so negligible differences have negligible differences in
/// colour.
fn wide((min, max): (f64, f64)) -> (f64, f64) {
    let least = LEAST_RANGE * min.abs().max(max.abs());
    if max > min && max - min < least {
        let middle = min + 0.5 * (max - min);
        return (middle - 0.5 * least, middle + 0.5 * least);
    }
    (min, max)
}

fn edges(centres: &[f64], log: bool) -> Vec<f64> {
    let centres: Vec<f64> = centres.iter().map(|centre| if log { centre.log10() } else { *centre }).collect();
    let Some((&first, &last)) = centres.first().zip(centres.last()) else { return vec![] };
    if centres.len() == 1 {
        let half = if first == 0.0 { 0.5 } else { 0.1 * first.abs() };
        return vec![first - half, first + half];
    }
    let between = centres.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
    let mut edges: Vec<f64> = std::iter::once(0.0).chain(between).chain([0.0]).collect();
    let end = edges.len() - 1;
    edges[0] = 2.0 * first - edges[1];
    edges[end] = 2.0 * last - edges[end - 1];
    edges
}

/// Formats evenly spaced numbers with equally many decimals, enough to distinguish them and for three digits of the
/// largest; scientific notation for very small and very large ones.
fn alike(values: &[f64]) -> Vec<String> {
    let (first, last) = (values.first().copied().unwrap_or(0.0), values.last().copied().unwrap_or(0.0));
    let largest = first.abs().max(last.abs());
    let step = (last - first).abs() / values.len().saturating_sub(1).max(1) as f64;
    if largest > 0.0 && !(1e-4..1e6).contains(&largest) {
        return values.iter().map(|value| significant(*value)).collect();
    }
    let of_step = if step > 0.0 { (1.0 - step.log10().floor()).clamp(0.0, 12.0) as usize } else { 0 };
    let count = of_step.max(decimals(largest, 3));
    values.iter().map(|value| format!("{value:.count$}")).collect()
}

fn color(share: f64) -> Color {
    let place = share.clamp(0.0, 1.0) * (SCALE.len() - 1) as f64;
    let below = (place as usize).min(SCALE.len() - 2);
    let rest = place - below as f64;
    let mix = |a: u8, b: u8| (f64::from(a) + rest * (f64::from(b) - f64::from(a))).round() as u8;
    let ((r, g, b), (r2, g2, b2)) = (SCALE[below], SCALE[below + 1]);
    Color(mix(r, r2), mix(g, g2), mix(b, b2))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn view<'a>(means: &'a [f64], y: &[f64]) -> HeatView<'a> {
        let axes = [AxisView { name: "x", log: false }, AxisView { name: "y", log: true }];
        HeatView { name: "sweep", caption: "what", axes, x: vec![0.0, 1.0, 2.0], y: y.to_vec(), means }
    }

    #[test]
    fn cells_meet_halfway_and_have_the_colours_of_their_values() {
        assert_eq!(edges(&[0.0, 1.0, 3.0], false), [-0.5, 0.5, 2.0, 4.0]);
        assert_eq!(edges(&[1.0, 100.0], true), [-1.0, 1.0, 3.0]);
        let figure = heat_map(&view(&[0.0, 1.0, 2.0, f64::NAN, 3.0, 4.0], &[1.0, 10.0])).expect("drawn");
        let text = crate::shown(&figure);
        for end in ["#440154", "#fde725"] {
            assert!(text.contains(end), "{end}");
        }
        assert!(text.contains("\"what\""));
    }

    #[test]
    fn a_negligible_difference_has_nearly_one_colour() {
        let (min, max) = wide((101.196, 101.256));
        assert!((max - min - 0.05 * 101.256).abs() < 1e-9 && min < 101.196 && max > 101.256);
        assert_eq!(wide((0.0, 1e-9)), (0.0, 1e-9));
        assert_eq!(wide((2.0, 2.0)), (2.0, 2.0));
        // Without the wider range the outer cells would have the end colours of the scale.
        let text = crate::shown(&heat_map(&view(&[101.196, 101.2, 101.256], &[1.0])).expect("drawn"));
        let middle = crate::shown(&heat_map(&view(&[0.0, 0.0, 2.0 * 101.226], &[1.0])).expect("drawn"));
        for end in ["#440154", "#fde725"] {
            assert!(text.matches(end).count() < middle.matches(end).count(), "{end}: {text}");
        }
    }

    #[test]
    fn numbers_of_the_legend_differ() {
        assert_eq!(alike(&[101.20, 101.22, 101.24]), ["101.200", "101.220", "101.240"]);
        assert_eq!(alike(&[0.0, 0.85, 1.7, 2.55]), ["0.00", "0.85", "1.70", "2.55"]);
        assert_eq!(alike(&[9.0, 10.0, 11.0]), ["9.0", "10.0", "11.0"]);
        assert_eq!(alike(&[1.0]), ["1.00"]);
        assert_eq!(alike(&[0.0, 2e-7]), ["0", "2.0e-7"]);
    }

    #[test]
    fn unusual_values_are_drawn() {
        for means in [[f64::NAN; 3], [1.0; 3], [1e300, -1e300, f64::INFINITY]] {
            heat_map(&view(&means, &[1.0])).expect("drawn");
        }
        assert!(matches!(heat_map(&view(&[], &[])), Err(FigureError::Empty { .. })));
        assert!(matches!(heat_map(&view(&[1.0], &[1.0])), Err(FigureError::Length { .. })));
    }
}
