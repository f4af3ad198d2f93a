#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Match {
    pub alarm: usize,
    pub label: usize,
    /// At least 0.
    pub delay_s: f64,
}

/// Rounded to 1 ns, because the difference of two decimal times is not exact.
fn delay_s(alarm_s: f64, label_s: f64) -> f64 {
    // Turns -0 into 0.
    ((alarm_s - label_s) * 1e9).round() / 1e9 + 0.0
}

/// Matches alarms to labels one to one (both in s, ascending). An alarm matches a label at most `within_s` before it.
/// The result has the maximum number of matches and, among such matchings, the minimum sum of delays.
///
/// Two passes find the latest matchable labels and the earliest matchable alarms. Some matching joins both sets
/// (Mendelsohn and Dulmage 1958). As all windows have the same length, crossing pairs can exchange partners, so the
/// k-th alarm matches the k-th label.
pub fn match_alarms(alarms_s: &[f64], labels_s: &[f64], within_s: f64) -> Vec<Match> {
    let is_late = |alarm: usize, label: usize| delay_s(alarms_s[alarm], labels_s[label]) > within_s;
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

/// The fall may end after an alarm.
const FALL_BEFORE_S: f64 = 0.1;
const FALL_AFTER_S: f64 = 0.03;

/// Share of the residual.
const FALLEN_SHARE: f64 = 0.5;

/// False if the prediction changed instead of the force.
pub(super) fn follows_fall(force_n: &[f64], interval_s: f64, sample: usize, residual_n: f64) -> bool {
    let samples_in = |time_s: f64| (time_s / interval_s).round() as usize;
    let from = sample.saturating_sub(samples_in(FALL_BEFORE_S));
    let to = (sample + samples_in(FALL_AFTER_S) + 1).min(force_n.len());
    let (mut highest_n, mut fall_n) = (f64::NEG_INFINITY, 0.0_f64);
    for &force in &force_n[from.min(to)..to] {
        highest_n = highest_n.max(force);
        fall_n = fall_n.max(highest_n - force);
    }
    fall_n >= FALLEN_SHARE * residual_n.abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_alarm_follows_a_fall_of_the_force_or_has_another_cause() {
        // The force rises by 20 N/s, falls from 10 to 2 N in 20 ms at 0.5 s, and rises again.
        let force = |k: usize| match k {
            0..500 => 0.02 * k as f64,
            500..520 => 10.0 - 0.4 * (k - 500) as f64,
            _ => 2.0 + 0.02 * (k - 520) as f64,
        };
        let force_n: Vec<f64> = (0..1200).map(force).collect();
        let follows = |sample: usize| follows_fall(&force_n, 1e-3, sample, 1.5);
        assert!(
            follows(503) && follows(550) && follows(475),
            "the fall lies from 0.1 s before to 30 ms after the alarm"
        );
        assert!(!follows(440), "before the fall");
        assert!(!follows(640) && !follows(987), "long after it");
    }
    use proptest::prelude::*;

    fn pairs(alarms_s: &[f64], labels_s: &[f64]) -> Vec<(usize, usize)> {
        match_alarms(alarms_s, labels_s, 0.5).into_iter().map(|m| (m.alarm, m.label)).collect()
    }

    #[test]
    fn one_alarm_matches_one_label() {
        assert_eq!(pairs(&[1.0, 1.2], &[0.9]), [(0, 0)], "the second is false");
        assert_eq!(pairs(&[1.0], &[0.6, 0.9]), [(0, 1)], "the latest label");
        assert_eq!(pairs(&[0.45, 0.6], &[0.0, 0.4]), [(0, 0), (1, 1)], "two matches rather than the shorter one");
    }

    #[test]
    fn the_window_is_closed_and_an_alarm_before_its_label_is_false() {
        assert_eq!(pairs(&[1.0, 1.5], &[0.5, 1.5]), [(0, 0), (1, 1)]);
        assert_eq!(pairs(&[0.999], &[1.0]), []);
        assert_eq!(pairs(&[1.501], &[1.0]), []);
        // The same time, 5.52 s, as two programs compute it.
        assert_eq!(match_alarms(&[1.3 + 4.22], &[5.52], 0.5), [Match { alarm: 0, label: 0, delay_s: 0.0 }]);
        assert!(match_alarms(&[], &[1.0], 0.5).is_empty() && match_alarms(&[1.0], &[], 0.5).is_empty());
    }

    /// Returns by exhaustive search the maximum number of matches, and the minimum sum of delays in ms for this number.
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
