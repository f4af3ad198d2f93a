//! Joins signals of different clocks, such as those of two topics of a log.
//!
//! The times are those of the fastest signal, within the time that all signals cover. The other signals are
//! interpolated linearly.

use super::Array;
use super::name::Vector;
use crate::Joined;

pub(super) struct Timed {
    pub(super) name: String,
    pub(super) time_s: Vec<f64>,
    pub(super) values: Vec<f64>,
}

/// `None` if both have one clock, or nothing in the file says otherwise.
pub(super) fn other_clock(arrays: &[Array], time: &Vector, signal: &Vector) -> Option<Clock> {
    let (of_time, of_signal) = (&arrays[time.array], &arrays[signal.array]);
    if let (Some(clock), Some(other)) = (of_time.clock, of_signal.clock) {
        if clock == other {
            return None;
        }
        let same =
            |array: &Array| array.clock == Some(other) && array.is_shared_time && array.aliases == of_time.aliases;
        let shared = arrays.iter().position(same).filter(|_| of_time.is_shared_time);
        return Some(shared.map_or_else(|| Clock::NotShared(arrays[clock].name.clone()), Clock::Times));
    }
    let (folder, name) = split(&of_time.name);
    let (other, _) = split(&of_signal.name);
    if folder == other {
        return None;
    }
    let sibling = |array: &Array| split(&array.name) == (other, name) && array.len() == signal.len;
    arrays.iter().position(sibling).map(Clock::Times)
}

pub(super) enum Clock {
    /// The index of the array with its times.
    Times(usize),
    /// The given time is not shared; this one is.
    NotShared(String),
}

fn split(path: &str) -> (&str, &str) {
    path.rfind(['/', '.', '!']).map_or(("", path), |at| (&path[..at], &path[at + 1..]))
}

type Table = (Vec<f64>, Vec<Vec<f64>>, Vec<Joined>);

pub(super) fn join(signals: &[Timed]) -> Option<Table> {
    let ends = |signal: &Timed| Some((*signal.time_s.first()?, *signal.time_s.last()?));
    let ends = signals.iter().map(ends).collect::<Option<Vec<_>>>()?;
    let from_s = ends.iter().map(|end| end.0).fold(f64::NEG_INFINITY, f64::max);
    let to_s = ends.iter().map(|end| end.1).fold(f64::INFINITY, f64::min);
    let within = |signal: &&Timed| signal.time_s.iter().filter(|time_s| (from_s..=to_s).contains(*time_s)).count();
    let fastest = signals.iter().max_by_key(within)?;
    let time_s: Vec<f64> = fastest.time_s.iter().copied().filter(|time_s| (from_s..=to_s).contains(time_s)).collect();
    if time_s.len() < 2 {
        return None;
    }
    let columns = signals.iter().map(|signal| interpolated(signal, &time_s)).collect();
    let has_own = |signal: &&Timed| signal.time_s != fastest.time_s;
    let report = |signal: &Timed| {
        let [_, median_s, longest_s] = crate::samples::intervals(&signal.time_s);
        let cut_s = (ends.iter().map(|end| end.1).fold(f64::NEG_INFINITY, f64::max)
            - ends.iter().map(|end| end.0).fold(f64::INFINITY, f64::min))
            - (to_s - from_s);
        let (signal, to) = (signal.name.clone(), fastest.name.clone());
        Joined { signal, to, median_interval_s: median_s, longest_interval_s: longest_s, cut_s }
    };
    let reports = signals.iter().filter(has_own).map(report).collect();
    Some((time_s, columns, reports))
}

fn interpolated(signal: &Timed, time_s: &[f64]) -> Vec<f64> {
    let (times, values) = (&signal.time_s, &signal.values);
    let mut left = 0;
    let at = |time_s: &f64| {
        while left + 2 < times.len() && times[left + 1] <= *time_s {
            left += 1;
        }
        let (from_s, to_s) = (times[left], times[left + 1]);
        let share = ((time_s - from_s) / (to_s - from_s)).clamp(0.0, 1.0);
        // A time of the signal gives its exact value.
        if share == 0.0 {
            values[left]
        } else if share == 1.0 {
            values[left + 1]
        } else {
            values[left] + (values[left + 1] - values[left]) * share
        }
    };
    time_s.iter().map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn timed(name: &str, from_s: f64, interval_s: f64, count: usize) -> Timed {
        let time_s: Vec<f64> = (0..count).map(|k| from_s + interval_s * k as f64).collect();
        // The value equals the time, so that a shift shows.
        Timed { name: name.into(), values: time_s.clone(), time_s }
    }

    #[test]
    fn the_slower_signal_is_interpolated_at_the_times_of_the_faster_one() {
        let (time_s, columns, reports) = join(&[timed("x", 0.5, 0.25, 5), timed("f", 0.0, 0.125, 17)]).expect("joined");
        assert_eq!((time_s.first(), time_s.last(), time_s.len()), (Some(&0.5), Some(&1.5), 9));
        assert!(columns.iter().all(|column| *column == time_s));
        let expected = Joined {
            signal: "x".into(),
            to: "f".into(),
            median_interval_s: 0.25,
            longest_interval_s: 0.25,
            cut_s: 1.0,
        };
        assert_eq!(reports, [expected]);
        assert!(join(&[timed("x", 0.0, 0.1, 5), timed("f", 5.0, 0.1, 5)]).is_none());
    }

    #[test]
    fn a_group_with_a_time_of_the_same_name_has_its_own_clock() {
        let array = |name: &str, len: usize| Array::new(name, vec![len]);
        let arrays = [array("/a/time", 4), array("/a/x", 4), array("/b/time", 9), array("/b/f", 9), array("/c/f", 4)];
        let vector = |index: usize| Vector::whole(index, &arrays[index]);
        assert!(other_clock(&arrays, &vector(0), &vector(1)).is_none());
        assert!(matches!(other_clock(&arrays, &vector(0), &vector(3)), Some(Clock::Times(2))));
        assert!(other_clock(&arrays, &vector(0), &vector(4)).is_none());
    }
}
