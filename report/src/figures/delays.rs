//! How the delays of detections are distributed.

use plotters::style::Color;

use super::axis::{Axis, X_TICKS, Y_TICKS};
use super::grid::{Grid, Row, Sample};
use super::panel::Panel;
use super::style::{MAIN, SKY};
use super::{Figure, FigureError};

/// Bars at most.
const BINS: usize = 40;

/// Number of detections by their delay after the labelled rupture, and the share of them that has come by then.
///
/// # Errors
/// [`FigureError::Empty`] without a delay (s, at least 0).
pub fn delay_histogram(delays_s: &[f64]) -> Result<Figure, FigureError> {
    let mut delays_ms: Vec<f64> = delays_s.iter().filter(|delay| delay.is_finite()).map(|delay| 1e3 * delay).collect();
    delays_ms.sort_by(f64::total_cmp);
    let Some(&greatest) = delays_ms.last() else { return Err(FigureError::Empty { figure: "delays" }) };
    let (counts, bin) = bins(&delays_ms, greatest);
    let most = counts.iter().copied().max().unwrap_or(1);
    // Detections are whole.
    let count_axis = Axis::from_zero(most as f64, Y_TICKS.min(most));
    let shade = SKY.mix(0.75);
    let mut outline = vec![(0.0, 0.0)];
    for (index, &count) in counts.iter().enumerate() {
        outline.push((bin * index as f64, count as f64));
        outline.push((bin * (index + 1) as f64, count as f64));
    }
    outline.push((bin * counts.len() as f64, 0.0));

    // The share steps up at each delay.
    let count = delays_ms.len() as f64;
    let (mut x, mut y) = (vec![0.0], vec![0.0]);
    for (index, &delay) in delays_ms.iter().enumerate() {
        x.extend([delay, delay]);
        y.extend([100.0 * index as f64 / count, 100.0 * (index + 1) as f64 / count]);
    }
    x.push(bin * counts.len() as f64);
    y.push(100.0);

    let axis = Axis::exact((0.0, bin * counts.len() as f64), X_TICKS);
    let upper = Panel {
        fills: vec![(outline, shade)],
        x_caption: "Delay (ms)",
        ..Panel::over_time(axis.clone(), count_axis, "Detections")
    };
    let lower = Panel {
        traces: vec![super::panel::Trace { x: &x, y: &y, scale: 1.0, stroke: MAIN }],
        x_caption: "Delay (ms)",
        ..Panel::over_time(axis, Axis::from_zero(100.0, Y_TICKS), "Share (%)")
    };
    Grid {
        legends: vec![vec![
            (Sample::Shade(shade), format!("delays of {} detections", delays_ms.len())),
            (Sample::Line(MAIN), "share that has come".to_owned()),
        ]],
        common: vec![],
        rows: vec![
            Row { title: None, height: 360.0, panels: vec![upper] },
            Row { title: None, height: 300.0, panels: vec![lower] },
        ],
    }
    .draw()
}

/// Counts in bins from 0 on, each open above, and the bins' width: a round number.
pub(crate) fn bins(delays_ms: &[f64], greatest: f64) -> (Vec<usize>, f64) {
    let wanted = (greatest / (BINS as f64 - 1.0)).max(1e-3);
    let power = 10.0_f64.powf(wanted.log10().floor());
    let bin = [1.0, 2.0, 5.0, 10.0].into_iter().map(|round| round * power).find(|&bin| bin >= wanted).unwrap_or(wanted);
    let index = |delay: f64| ((delay / bin + 1e-9).max(0.0) as usize).min(BINS - 1);
    let mut counts = vec![0; index(greatest) + 1];
    for &delay in delays_ms {
        counts[index(delay)] += 1;
    }
    (counts, bin)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_delay_is_counted_once_in_round_bins() {
        let delays = [0.0, 0.5, 3.0, 3.0, 17.2];
        let (counts, bin) = bins(&delays, 17.2);
        assert_eq!((counts.iter().sum::<usize>(), bin), (5, 0.5));
        assert_eq!((counts[0], counts[1], counts[6], counts[34], counts.len()), (1, 1, 2, 1, 35));
        for greatest in [0.0, 1e-9, 0.3, 499.9, 1e7] {
            assert!(bins(&[greatest], greatest).0.len() <= BINS);
        }
    }

    #[test]
    fn a_histogram_needs_a_delay() {
        assert!(matches!(delay_histogram(&[]), Err(FigureError::Empty { .. })));
        assert!(delay_histogram(&[0.0]).is_ok());
    }
}
