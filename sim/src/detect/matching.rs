//! Which alarm announces which labelled rupture.

/// An alarm and the label that it announces, both by their place in the lists.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Match {
    /// Which alarm.
    pub alarm: usize,
    /// Which label.
    pub label: usize,
    /// From the label to the alarm in s, at least 0, to the nanosecond.
    pub delay_s: f64,
}

/// From a label to an alarm in s, to the nanosecond: the difference of two decimal times is no decimal.
fn delay_s(alarm_s: f64, label_s: f64) -> f64 {
    // Plus 0: a hair before the label is at it, not at -0.
    ((alarm_s - label_s) * 1e9).round() / 1e9 + 0.0
}

/// Matches alarms to labels one to one (both in s, ascending). An alarm can announce a label that lies at most `window_s`
/// (s, at least 0) before it; one that comes before its label announces nothing. Of all ways to match, one with the most
/// matches is taken, and of those one with the least sum of delays. In order of time.
///
/// # Why three passes suffice
/// The windows `[label, label + window_s]` are equally long, so a pass from the last label to the first, each taking the
/// latest alarm left in its window, finds as many matches as can be, with the latest labels that can all be matched; a
/// pass from the first alarm to the last, each taking the earliest label left, does so with the earliest alarms. The sets
/// of labels (alarms) that can be matched are the independent sets of a transversal matroid, so these are a base of the
/// greatest (least) sum; some matching joins the two bases (Mendelsohn and Dulmage 1958), and exchanging the partners of
/// two pairs that cross leaves both within the window and the sum as it was. Hence: the k-th of the one with the k-th of
/// the other.
#[must_use]
pub fn match_alarms(alarms_s: &[f64], labels_s: &[f64], window_s: f64) -> Vec<Match> {
    let is_late = |alarm: usize, label: usize| delay_s(alarms_s[alarm], labels_s[label]) > window_s;
    let is_early = |alarm: usize, label: usize| delay_s(alarms_s[alarm], labels_s[label]) < 0.0;

    let mut labels = vec![];
    let mut alarms_left = alarms_s.len();
    for label in (0..labels_s.len()).rev() {
        while alarms_left > 0 && is_late(alarms_left - 1, label) {
            alarms_left -= 1;
        }
        if alarms_left > 0 && !is_early(alarms_left - 1, label) {
            alarms_left -= 1;
            labels.push(label);
        }
    }
    labels.reverse();

    let mut alarms = vec![];
    let mut next_label = 0;
    for alarm in 0..alarms_s.len() {
        while next_label < labels_s.len() && is_late(alarm, next_label) {
            next_label += 1;
        }
        if next_label < labels_s.len() && !is_early(alarm, next_label) {
            next_label += 1;
            alarms.push(alarm);
        }
    }

    let pair =
        |(alarm, label): (usize, usize)| Match { alarm, label, delay_s: delay_s(alarms_s[alarm], labels_s[label]) };
    alarms.into_iter().zip(labels).map(pair).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn pairs(alarms_s: &[f64], labels_s: &[f64]) -> Vec<(usize, usize)> {
        match_alarms(alarms_s, labels_s, 0.5).into_iter().map(|m| (m.alarm, m.label)).collect()
    }

    #[test]
    fn one_alarm_announces_one_label() {
        assert_eq!(pairs(&[1.0, 1.2], &[0.9]), [(0, 0)], "the second is false");
        assert_eq!(pairs(&[1.0], &[0.6, 0.9]), [(0, 1)], "what has just happened");
        assert_eq!(pairs(&[0.45, 0.6], &[0.0, 0.4]), [(0, 0), (1, 1)], "two matches rather than the shorter one");
    }

    #[test]
    fn the_window_is_closed_and_an_alarm_before_its_label_is_false() {
        assert_eq!(pairs(&[1.0, 1.5], &[0.5, 1.5]), [(0, 0), (1, 1)]);
        assert_eq!(pairs(&[0.999], &[1.0]), []);
        assert_eq!(pairs(&[1.501], &[1.0]), []);
        // 5.52 in the recording's own time, written by two programs.
        assert_eq!(match_alarms(&[1.3 + 4.22], &[5.52], 0.5), [Match { alarm: 0, label: 0, delay_s: 0.0 }]);
        assert!(match_alarms(&[], &[1.0], 0.5).is_empty() && match_alarms(&[1.0], &[], 0.5).is_empty());
    }

    /// The most matches, and the least sum of delays in ms with as many, by trying everything.
    fn best(alarms: &[u32], labels: &[u32], window: u32) -> (usize, u32) {
        let Some((label, rest)) = labels.split_first() else { return (0, 0) };
        let mut all = vec![best(alarms, rest, window)];
        for (index, alarm) in alarms.iter().enumerate() {
            if (*label..=label + window).contains(alarm) {
                let mut others = alarms.to_vec();
                others.remove(index);
                let (count, sum) = best(&others, rest, window);
                all.push((count + 1, sum + alarm - label));
            }
        }
        all.into_iter().max_by_key(|&(count, sum)| (count, std::cmp::Reverse(sum))).unwrap_or_default()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]
        #[test]
        fn no_other_matching_is_better(
            mut alarms in prop::collection::vec(0_u32..30, 0..6),
            mut labels in prop::collection::vec(0_u32..30, 0..6),
            window in 0_u32..15,
        ) {
            alarms.sort_unstable();
            labels.sort_unstable();
            let seconds = |times: &[u32]| times.iter().map(|&ms| f64::from(ms) * 1e-3).collect::<Vec<_>>();
            let found = match_alarms(&seconds(&alarms), &seconds(&labels), f64::from(window) * 1e-3);
            let sum: f64 = found.iter().map(|m| m.delay_s).sum();
            prop_assert_eq!((found.len(), (sum * 1e3).round() as u32), best(&alarms, &labels, window));
            prop_assert!(found.windows(2).all(|p| p[0].alarm < p[1].alarm && p[0].label < p[1].label));
            for m in &found {
                let delay = alarms[m.alarm].checked_sub(labels[m.label]);
                prop_assert!(delay.is_some_and(|delay| delay <= window));
            }
        }
    }
}
