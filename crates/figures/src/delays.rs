use super::FigureError;
use trocar_document::figure::{Axis, COMPUTED, Figure, GREY, Panel, Row, Sample, Series, X_TICKS, Y_TICKS};

const BINS: usize = 40;

/// Draws a histogram of the delays between labelled ruptures and their detections, with the cumulative share.
pub fn delay_histogram(delays_s: &[f64]) -> Result<Figure<'static>, FigureError> {
    let mut delays_ms: Vec<f64> = delays_s.iter().filter(|delay| delay.is_finite()).map(|delay| 1e3 * delay).collect();
    delays_ms.sort_by(f64::total_cmp);
    let Some(&max_ms) = delays_ms.last() else { return Err(FigureError::Empty { figure: "delays" }) };
    let (counts, bin) = bins(&delays_ms, max_ms);
    let max_count = counts.iter().copied().max().unwrap_or(1);
    let count_axis = Axis::from_zero(max_count as f64, Y_TICKS.min(max_count));
    let shade = GREY.pale(0.45);
    let mut outline = vec![(0.0, 0.0)];
    for (index, &count) in counts.iter().enumerate() {
        outline.push((bin * index as f64, count as f64));
        outline.push((bin * (index + 1) as f64, count as f64));
    }
    outline.push((bin * counts.len() as f64, 0.0));

    // The cumulative share has a step at each delay.
    let count = delays_ms.len() as f64;
    let (mut x, mut y) = (vec![0.0], vec![0.0]);
    for (index, &delay) in delays_ms.iter().enumerate() {
        x.extend([delay, delay]);
        y.extend([100.0 * index as f64 / count, 100.0 * (index + 1) as f64 / count]);
    }
    x.push(bin * counts.len() as f64);
    y.push(100.0);

    let axis = Axis::exact((0.0, bin * counts.len() as f64), X_TICKS);
    let upper =
        Panel { fills: vec![(outline, shade)], ..Panel::new(axis.clone(), "Delay (ms)", count_axis, "Detections") };
    let lower = Panel {
        series: vec![Series::new(x, y, COMPUTED)],
        ..Panel::new(axis, "Delay (ms)", Axis::from_zero(100.0, Y_TICKS), "Cumulative share (%)")
    };
    Ok(Figure {
        name: String::new(),
        legend: vec![
            (Sample::Shade(shade), format!("delays of {} detections", delays_ms.len())),
            (Sample::Line(COMPUTED), "cumulative share".to_owned()),
        ],
        rows: vec![Row::of(115.0, upper), Row::of(95.0, lower)],
    })
}

/// Counts in half-open bins from 0 on, and the round bin width.
fn bins(delays_ms: &[f64], max_ms: f64) -> (Vec<usize>, f64) {
    let min_width = (max_ms / (BINS as f64 - 1.0)).max(1e-3);
    let power = 10.0_f64.powf(min_width.log10().floor());
    let bin =
        [1.0, 2.0, 5.0, 10.0].into_iter().map(|round| round * power).find(|&bin| bin >= min_width).unwrap_or(min_width);
    let index = |delay: f64| ((delay / bin + 1e-9).max(0.0) as usize).min(BINS - 1);
    let mut counts = vec![0; index(max_ms) + 1];
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
        for max_ms in [0.0, 1e-9, 0.3, 499.9, 1e7] {
            assert!(bins(&[max_ms], max_ms).0.len() <= BINS);
        }
    }

    #[test]
    fn a_histogram_needs_a_delay() {
        assert!(matches!(delay_histogram(&[]), Err(FigureError::Empty { .. })));
        assert!(delay_histogram(&[0.0]).is_ok());
    }
}
