use std::collections::BTreeMap;

use super::trials::{Fall, Trial};
use trocar_metrics::RUPTURE_WINDOW_S;

/// Times are sums of rounded decimals.
const ROUNDING_S: f64 = 1e-9;

/// Integer counts, independent of the order of the cases.
///
/// The first alarm within [`RUPTURE_WINDOW_S`] after a label, and before the next one, matches this rupture: a
/// detection if in time, otherwise late. Every other alarm is false.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Tally {
    pub cases: u64,
    pub clean_cases: u64,
    /// Indexed by the rupture in the case.
    pub ruptures: Vec<u64>,
    pub detected: Vec<u64>,
    pub late: u64,
    pub false_alarms: u64,
    /// Time outside the windows after labels; for a trial, the time in contact.
    pub quiet_ns: u64,
    pub delays_ns: BTreeMap<u64, u64>,
    /// Counted only at the threshold of the settings.
    pub missed: BTreeMap<String, u64>,
}

#[derive(Debug, Clone)]
pub(super) struct Labels {
    labels: Vec<Label>,
    tick_s: f64,
    quiet_ns: u64,
}

#[derive(Debug, Clone, Copy)]
struct Label {
    time_s: f64,
    within_s: f64,
    /// Alarms during the fall are not false.
    fall_s: f64,
    /// A rupture that noise hides is neither missed nor detected, and its alarms are not false.
    counts: bool,
}

impl Labels {
    pub(super) fn new(ruptures_s: Vec<f64>, samples: usize, tick_s: f64, within_s: f64) -> Self {
        let label = |time_s| Label { time_s, within_s, fall_s: 0.0, counts: true };
        let mut labels = Self { labels: ruptures_s.into_iter().map(label).collect(), tick_s, quiet_ns: 0 };
        let quiet = (0..samples).filter(|&sample| labels.matched(sample).is_none()).count();
        labels.quiet_ns = (quiet as f64 * tick_s * 1e9).round() as u64;
        labels
    }

    /// Alarms may come until `within_s`, or three samples, after the fall.
    pub(super) fn of_trial(trial: &Trial, within_s: f64) -> Self {
        let slack_s = within_s.max(3.0 * trial.tick_s);
        let label = |fall: &Fall| Label {
            time_s: fall.start_s,
            within_s: fall.duration_s + slack_s,
            fall_s: fall.duration_s + slack_s,
            counts: trial.is_above_noise(fall),
        };
        Self {
            labels: trial.falls.iter().map(label).collect(),
            tick_s: trial.tick_s,
            quiet_ns: (trial.contact_s * 1e9).round() as u64,
        }
    }

    pub(super) fn rupture_s(&self, rupture: usize) -> f64 {
        self.labels[rupture].time_s
    }

    pub(super) fn tick_s(&self) -> f64 {
        self.tick_s
    }

    fn matched(&self, sample: usize) -> Option<(usize, f64)> {
        let time_s = sample as f64 * self.tick_s;
        let rupture = self.labels.partition_point(|label| label.time_s <= time_s + ROUNDING_S).checked_sub(1)?;
        let delay_s = (time_s - self.labels[rupture].time_s).max(0.0);
        (delay_s <= RUPTURE_WINDOW_S + ROUNDING_S).then_some((rupture, delay_s))
    }
}

impl Tally {
    /// Returns the indices of the ruptures without an alarm.
    pub(super) fn count(&mut self, alarms: &[usize], labels: &Labels) -> Vec<usize> {
        let count = labels.labels.len();
        let counting = labels.labels.iter().filter(|label| label.counts).count();
        if self.ruptures.len() < count {
            self.ruptures.resize(count, 0);
            self.detected.resize(count, 0);
        }
        for (ruptures, label) in self.ruptures.iter_mut().zip(&labels.labels) {
            *ruptures += u64::from(label.counts);
        }
        let (mut next, mut in_time, mut others) = (0, 0, 0);
        let mut missed = vec![];
        for &sample in alarms {
            match labels.matched(sample) {
                Some((rupture, delay_s)) if rupture < next && delay_s <= labels.labels[rupture].fall_s => {}
                Some((rupture, delay_s)) if rupture >= next => {
                    missed.extend(next..rupture);
                    next = rupture + 1;
                    if !labels.labels[rupture].counts {
                        continue;
                    }
                    *self.delays_ns.entry((delay_s * 1e9).round() as u64).or_default() += 1;
                    if delay_s <= labels.labels[rupture].within_s + ROUNDING_S {
                        self.detected[rupture] += 1;
                        in_time += 1;
                    } else {
                        self.late += 1;
                        others += 1;
                    }
                }
                Some(_) | None => {
                    self.false_alarms += 1;
                    others += 1;
                }
            }
        }
        self.cases += 1;
        self.clean_cases += u64::from(in_time == counting && others == 0);
        self.quiet_ns += labels.quiet_ns;
        missed.extend(next..count);
        missed.retain(|rupture| labels.labels[*rupture].counts);
        missed
    }

    pub fn add(&mut self, other: &Self) {
        self.cases += other.cases;
        self.clean_cases += other.clean_cases;
        self.late += other.late;
        self.false_alarms += other.false_alarms;
        self.quiet_ns += other.quiet_ns;
        for (mine, theirs) in [(&mut self.ruptures, &other.ruptures), (&mut self.detected, &other.detected)] {
            mine.resize(mine.len().max(theirs.len()), 0);
            mine.iter_mut().zip(theirs).for_each(|(mine, theirs)| *mine += theirs);
        }
        for (&delay, &count) in &other.delays_ns {
            *self.delays_ns.entry(delay).or_default() += count;
        }
        for (reason, &count) in &other.missed {
            *self.missed.entry(reason.clone()).or_default() += count;
        }
    }

    pub fn delay_quantile_s(&self, share: f64) -> Option<f64> {
        let all: u64 = self.delays_ns.values().sum();
        let needed = ((share * all as f64).ceil() as u64).max(1);
        let mut counted = 0;
        for (&delay, &count) in &self.delays_ns {
            counted += count;
            if counted >= needed {
                return Some(delay as f64 / 1e9);
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Counts the alarms of a case of 10 s at 1 kHz with ruptures at 2 s and 2.3 s, in time within 10 ms.
    fn of(alarms: &[usize]) -> Tally {
        let mut tally = Tally::default();
        tally.count(alarms, &Labels::new(vec![2.0, 2.3], 10_000, 1e-3, 0.010));
        tally
    }

    #[test]
    fn the_first_alarm_after_a_label_is_its_detection_and_the_others_are_false() {
        let tally = of(&[1999, 2003, 2004, 2310, 2801]);
        assert_eq!((tally.detected.as_slice(), tally.late, tally.false_alarms), ([1, 1].as_slice(), 0, 3));
        assert_eq!(tally.delays_ns.into_iter().collect::<Vec<_>>(), [(3_000_000, 1), (10_000_000, 1)]);
        assert_eq!(of(&[2003, 2310]).clean_cases, 1);
    }

    #[test]
    fn a_late_alarm_is_neither_a_detection_nor_false() {
        let tally = of(&[2011, 2800]);
        assert_eq!((tally.detected.as_slice(), tally.late, tally.false_alarms), ([0, 0].as_slice(), 2, 0));
        assert_eq!(tally.clean_cases, 0);
    }

    #[test]
    fn the_windows_after_labels_are_not_quiet_time() {
        // The windows extend from 2.0 s to 2.8 s, including both ends.
        assert_eq!(of(&[]).quiet_ns, (10_000 - 801) * 1_000_000);
    }

    #[test]
    fn quantiles_are_observed_delays() {
        let mut tally = Tally::default();
        assert_eq!(tally.delay_quantile_s(0.5), None);
        tally.delays_ns = (1..=20).map(|ms| (ms * 1_000_000, 1)).collect();
        assert_eq!(
            [0.05, 0.5, 0.95, 1.0].map(|share| tally.delay_quantile_s(share)),
            [1e-3, 0.01, 0.019, 0.02].map(Some)
        );
    }

    #[test]
    fn tallies_add_up_in_any_order() {
        let (mut a, mut b) = (of(&[2003, 5000]), of(&[2011]));
        let (first, second) = (a.clone(), b.clone());
        a.add(&second);
        b.add(&first);
        assert_eq!(a, b);
        assert_eq!((a.cases, a.false_alarms, a.late), (2, 1, 1));
    }
}
