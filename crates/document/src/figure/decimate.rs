//! The minimum and maximum of each visible interval, so that all surfaces show the same peaks.

use std::ops::Range;

/// The first and last row, and per interval the rows of the minimum, the maximum and a non-finite value: at most about
/// `6 * intervals` rows. The time within `detailed` (s) has about `2 * intervals` intervals, the rest `intervals`.
pub(crate) fn kept(time_s: &[f64], column: &[f64], detailed: &[(f64, f64)], intervals: usize) -> Vec<usize> {
    let rows = column.len().min(time_s.len());
    let is_detailed = |row: usize| detailed.iter().any(|(from, to)| (*from..=*to).contains(&time_s[row]));
    let count = if detailed.is_empty() { 0 } else { (0..rows).filter(|row| is_detailed(*row)).count() };
    let intervals = intervals.max(1);
    let (fine, coarse) = (count.div_ceil(2 * intervals).max(1), (rows - count).div_ceil(intervals).max(1));
    let mut kept = vec![];
    let mut start = 0;
    while start < rows {
        let at_start = is_detailed(start);
        let max_end = (start + if at_start { fine } else { coarse }).min(rows);
        let changes = |row: &usize| is_detailed(*row) != at_start;
        let end = if detailed.is_empty() { max_end } else { (start + 1..max_end).find(changes).unwrap_or(max_end) };
        let mut found = [(start == 0).then_some(0); 4];
        found[1..].copy_from_slice(&extremes(start..end, column));
        found.sort_unstable();
        for row in found.into_iter().flatten() {
            if kept.last() != Some(&row) {
                kept.push(row);
            }
        }
        start = end;
    }
    if rows > 0 && kept.last() != Some(&(rows - 1)) {
        kept.push(rows - 1);
    }
    kept
}

fn extremes(rows: Range<usize>, column: &[f64]) -> [Option<usize>; 3] {
    let mut found = [None; 3];
    let (mut min, mut max) = (f64::INFINITY, f64::NEG_INFINITY);
    for (row, &value) in rows.clone().zip(&column[rows]) {
        if !value.is_finite() {
            found[2] = found[2].or(Some(row));
            continue;
        }
        if value < min {
            (min, found[0]) = (value, Some(row));
        }
        if value > max {
            (max, found[1]) = (value, Some(row));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn time(rows: usize) -> Vec<f64> {
        (0..rows).map(|row| row as f64 * 1e-3).collect()
    }

    #[test]
    fn a_spike_is_kept_and_the_rest_is_thinned() {
        let mut column = vec![0.0; 100_000];
        column[61_234] = 9.0;
        column[7] = -9.0;
        let kept = kept(&time(100_000), &column, &[], 500);
        assert!(kept.contains(&61_234) && kept.contains(&7), "{kept:?}");
        assert!((500..=2_002).contains(&kept.len()), "{}", kept.len());
        assert!(kept.is_sorted() && kept.first() == Some(&0) && kept.last() == Some(&99_999));
    }

    #[test]
    fn short_intervals_around_events_keep_every_sample() {
        let column: Vec<f64> = (0..10_000).map(|row| f64::from(row % 7)).collect();
        let kept = kept(&time(10_000), &column, &[(4.9995, 5.1005)], 200);
        assert!((5_000..=5_100).all(|row| kept.contains(&row)));
        assert!(kept.len() < 1_000, "{}", kept.len());
    }

    #[test]
    fn gaps_remain_and_empty_columns_are_allowed() {
        let mut column = vec![1.0; 1_000];
        column[500] = f64::NAN;
        assert!(kept(&time(1_000), &column, &[], 10).contains(&500));
        assert!(kept(&[], &[], &[], 10).is_empty());
        assert_eq!(kept(&[0.0], &[1.0], &[], 10), [0]);
    }
}
