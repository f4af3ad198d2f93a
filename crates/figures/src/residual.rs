//! The distribution of the prediction error, as in figure 11 of the paper.

use super::decision::short;
use super::{EstimationView, FigureError};
use trocar_base::quantiles::robust_std;
use trocar_document::figure::{
    Axis, COMPUTED, Figure, GREY, LIMIT, Panel, Row, Sample, Series, Stroke, X_TICKS, extent,
};

const MAX_HALF_WIDTH: f64 = 8.0;
const BINS: usize = 96;

/// Draws the density of the prediction error e on a logarithmic axis, with the zero-mean Gaussian of the robust
/// standard deviation, 1.4826 times the median absolute deviation, which ruptures hardly change. Errors beyond 8 σ are
/// outside the figure but count in the density.
pub fn residual_histogram(view: &EstimationView<'_>) -> Result<Figure<'static>, FigureError> {
    view.check("residual")?;
    let named = |sigma| format!("zero-mean Gaussian, σ = 1.4826·MAD = {} N", short(sigma));
    let gaussians: Vec<(f64, String)> =
        histogram(view.residual_n).1.sigma.map(|sigma| (sigma, named(sigma))).into_iter().collect();
    Ok(distribution(view.name, view.residual_n, &gaussians))
}

/// Draws the density of a prediction error (N) on a logarithmic axis, with named zero-mean Gaussians of given standard
/// deviations (N).
pub fn distribution(name: &str, residual_n: &[f64], gaussians: &[(f64, String)]) -> Figure<'static> {
    let (residuals, Histogram { half, bin, densities, .. }) = histogram(residual_n);
    let single = 1.0 / (residuals.len().max(1) as f64 * bin);
    let peak = densities.iter().copied().fold(single, f64::max);
    let y = Axis::log10((0.5 * single, 3.0 * peak));
    let shade = GREY.pale(0.45);
    let outside = residuals.iter().filter(|e| e.abs() >= half).count();
    let omitted = match outside {
        0 => String::new(),
        count => format!(", {count} of them beyond ±{} N, not drawn", short(half)),
    };
    let curve_x: Vec<f64> = (0..=400).map(|k| -half + 2.0 * half * f64::from(k) / 400.0).collect();
    let lines = [COMPUTED, LIMIT];
    let curve = |((sigma, _), line): (&(f64, String), Stroke)| {
        let y: Vec<f64> = curve_x.iter().map(|e| gaussian(*e, *sigma)).collect();
        Series::new(curve_x.clone(), y, line)
    };
    let names = gaussians.iter().zip(lines).map(|((_, name), line)| (Sample::Line(line), name.clone()));
    let of_samples = (Sample::Shade(shade), format!("e, {} samples{omitted}", residuals.len()));
    let panel = Panel {
        fills: vec![(outline(&densities, half, bin, &y), shade)],
        series: gaussians.iter().zip(lines).map(curve).collect(),
        ..Panel::new(Axis::exact((-half, half), X_TICKS), "Prediction error e (N)", y, "Density (1/N)")
    };
    let legend = std::iter::once(of_samples).chain(names).collect();
    Figure { name: name.to_owned(), legend, rows: vec![Row::of(180.0, panel)] }
}

/// A prediction error's distribution: densities (1/N) in bins of width `bin` (N) from `-half` to `half` (N), and the
/// robust σ (N), if defined.
struct Histogram {
    half: f64,
    bin: f64,
    densities: Vec<f64>,
    sigma: Option<f64>,
}

fn histogram(residual_n: &[f64]) -> (Vec<f64>, Histogram) {
    let residuals: Vec<f64> = residual_n.iter().copied().filter(|e| e.is_finite()).collect();
    let sigma = robust_spread(&residuals);
    let (low, high) = extent(residuals.iter().copied()).unwrap_or((0.0, 0.0));
    let largest = low.abs().max(high.abs());
    let half = match sigma {
        Some(sigma) => (1.05 * largest).clamp(4.0 * sigma, MAX_HALF_WIDTH * sigma),
        None if largest > 0.0 => 1.2 * largest,
        None => 1.0,
    };
    let bin = 2.0 * half / BINS as f64;
    let densities = densities(&residuals, half, bin);
    (residuals, Histogram { half, bin, densities, sigma })
}

fn robust_spread(values: &[f64]) -> Option<f64> {
    robust_std(&[values]).filter(|spread| *spread > 1e-12 && *spread < 1e12)
}

fn densities(values: &[f64], half: f64, bin: f64) -> Vec<f64> {
    let mut counts = vec![0_u64; BINS];
    for value in values.iter().filter(|v| v.abs() < half) {
        let index = ((value + half) / bin) as usize;
        counts[index.min(BINS - 1)] += 1;
    }
    let each = 1.0 / (values.len().max(1) as f64 * bin);
    counts.into_iter().map(|count| count as f64 * each).collect()
}

fn outline(densities: &[f64], half: f64, bin: f64, y: &Axis) -> Vec<(f64, f64)> {
    let floor = y.low;
    let mut points = vec![(-half, floor)];
    for (k, &density) in densities.iter().enumerate() {
        let top = y.place(density).max(floor);
        points.push((-half + bin * k as f64, top));
        points.push((-half + bin * (k + 1) as f64, top));
    }
    points.push((half, floor));
    points
}

fn gaussian(e: f64, sigma: f64) -> f64 {
    (-0.5 * (e / sigma).powi(2)).exp() / (sigma * (2.0 * std::f64::consts::PI).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_robust_spread_ignores_outliers() {
        let mut values: Vec<f64> = (-500..=500).map(|k| f64::from(k) * 1e-3).collect();
        values.extend([1e9, -1e12, 55.0]);
        let spread = robust_spread(&values).expect("a spread");
        assert!((spread - 1.4826 * 0.25).abs() < 2e-3, "{spread}");
        assert_eq!(robust_spread(&[]), None);
        assert_eq!(robust_spread(&[0.1; 9]), None);
    }

    #[test]
    fn densities_integrate_to_one() {
        let values: Vec<f64> = (0..1000).map(|k| f64::from(k) * 1e-3 - 0.5).collect();
        let bin = 2.0 / BINS as f64;
        let total: f64 = densities(&values, 1.0, bin).iter().sum();
        assert!((total * bin - 1.0).abs() < 1e-12);
    }
}
