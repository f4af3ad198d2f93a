//! Which of many samples a page keeps: in each stretch of time the least and the greatest of every column, and nearly every
//! sample where something happens.

/// Rows of columns over time, ascending: the first and the last, and in each stretch those where a column has its least or its
/// greatest value, or is no number. The time within `close` (s) is cut into about twice `stretches` of them, all the rest into
/// `stretches`, so that about `6 * columns.len() * stretches` rows are kept at most.
pub(super) fn kept(time_s: &[f64], columns: &[&[f64]], close: &[(f64, f64)], stretches: usize) -> Vec<usize> {
    let rows = columns.iter().map(|column| column.len()).fold(time_s.len(), usize::min);
    let is_close = |row: usize| close.iter().any(|(from, to)| (*from..=*to).contains(&time_s[row]));
    let near = (0..rows).filter(|row| is_close(*row)).count();
    let stretches = stretches.max(1);
    let (fine, coarse) = (near.div_ceil(2 * stretches).max(1), (rows - near).div_ceil(stretches).max(1));
    let mut is_kept = vec![false; rows];
    let mut start = 0;
    while start < rows {
        let here = is_close(start);
        let most = (start + if here { fine } else { coarse }).min(rows);
        let end = (start + 1..most).find(|row| is_close(*row) != here).unwrap_or(most);
        for column in columns {
            for row in extremes(column, start, end).into_iter().flatten() {
                is_kept[row] = true;
            }
        }
        start = end;
    }
    for end in [is_kept.first_mut().map(|_| 0), rows.checked_sub(1)].into_iter().flatten() {
        is_kept[end] = true;
    }
    (0..rows).filter(|row| is_kept[*row]).collect()
}

/// Where a column has its least and its greatest value between two rows, and where it first is no number.
fn extremes(column: &[f64], start: usize, end: usize) -> [Option<usize>; 3] {
    let mut found = [None; 3];
    for row in start..end {
        let value = column[row];
        if !value.is_finite() {
            found[2] = found[2].or(Some(row));
            continue;
        }
        if found[0].is_none_or(|least: usize| value < column[least]) {
            found[0] = Some(row);
        }
        if found[1].is_none_or(|greatest: usize| value > column[greatest]) {
            found[1] = Some(row);
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
    fn a_spike_survives_and_the_rest_is_thinned() {
        let mut column = vec![0.0; 100_000];
        column[61_234] = 9.0;
        column[7] = -9.0;
        let kept = kept(&time(100_000), &[&column], &[], 500);
        assert!(kept.contains(&61_234) && kept.contains(&7), "{kept:?}");
        assert!((500..=2_002).contains(&kept.len()), "{}", kept.len());
        assert!(kept.is_sorted() && kept.first() == Some(&0) && kept.last() == Some(&99_999));
    }

    #[test]
    fn what_is_close_keeps_every_sample_where_there_are_few() {
        let column: Vec<f64> = (0..10_000).map(|row| f64::from(row % 7)).collect();
        let kept = kept(&time(10_000), &[&column], &[(4.9995, 5.1005)], 200);
        assert!((5_000..=5_100).all(|row| kept.contains(&row)));
        assert!(kept.len() < 1_000, "{}", kept.len());
    }

    #[test]
    fn gaps_stay_gaps_and_nothing_is_nothing() {
        let mut column = vec![1.0; 1_000];
        column[500] = f64::NAN;
        assert!(kept(&time(1_000), &[&column], &[], 10).contains(&500));
        assert!(kept(&[], &[&[]], &[], 10).is_empty());
        assert_eq!(kept(&[0.0], &[&[1.0]], &[], 10), [0]);
    }
}
