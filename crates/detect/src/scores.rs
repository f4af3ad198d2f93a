use schemars::JsonSchema;
use serde::Serialize;

#[derive(Debug, Clone, Default, PartialEq)]
pub struct Tally {
    pub recordings: usize,
    pub ruptures: usize,
    pub alarms: usize,
    /// From rupture to alarm.
    pub delays_s: Vec<f64>,
    pub recorded_s: f64,
    pub contact_s: f64,
}

impl Tally {
    pub fn add(&mut self, other: &Self) {
        self.recordings += other.recordings;
        self.ruptures += other.ruptures;
        self.alarms += other.alarms;
        self.delays_s.extend(&other.delays_s);
        self.recorded_s += other.recorded_s;
        self.contact_s += other.contact_s;
    }
}

/// The scores of a tally. `None` means undefined: the precision without alarms, the recall without ruptures, a rate per
/// minute without recorded time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct Scores {
    /// Number of labelled recordings.
    pub recordings: usize,
    /// Number of labelled ruptures.
    pub ruptures: usize,
    /// Number of alarms.
    pub alarms: usize,
    /// Number of detected ruptures.
    pub found: usize,
    /// Number of missed ruptures.
    pub missed: usize,
    /// Number of alarms without a rupture.
    pub false_alarms: usize,
    /// Share of the alarms that match a rupture.
    pub precision: Option<f64>,
    /// Share of the ruptures that are detected.
    pub recall: Option<f64>,
    /// Harmonic mean of precision and recall, `2 found / (alarms + ruptures)`.
    pub f1: Option<f64>,
    /// Median delay, in s; for an even number, the mean of the two middle values.
    pub median_delay_s: Option<f64>,
    /// Minimum delay, in s.
    pub min_delay_s: Option<f64>,
    /// Maximum delay, in s.
    pub max_delay_s: Option<f64>,
    /// Recorded time, in s.
    pub recorded_s: f64,
    /// Recorded time in contact, in s.
    pub contact_s: f64,
    /// False alarms per minute of recorded time.
    pub false_alarms_per_minute: Option<f64>,
    /// False alarms per minute in contact. All alarms are in contact, because an alarm requires it.
    pub false_alarms_per_contact_minute: Option<f64>,
}

impl Scores {
    pub fn of(tally: &Tally) -> Self {
        let found = tally.delays_s.len();
        let false_alarms = tally.alarms.saturating_sub(found);
        let share = |part: f64, whole: f64| (whole > 0.0).then(|| part / whole);
        let mut delays_s = tally.delays_s.clone();
        delays_s.sort_by(f64::total_cmp);
        let middle = delays_s.len() / 2;
        let median_delay_s = match delays_s.len() {
            0 => None,
            odd if odd % 2 == 1 => Some(delays_s[middle]),
            _ => Some(0.5 * (delays_s[middle - 1] + delays_s[middle])),
        };
        Self {
            recordings: tally.recordings,
            ruptures: tally.ruptures,
            alarms: tally.alarms,
            found,
            missed: tally.ruptures.saturating_sub(found),
            false_alarms,
            precision: share(found as f64, tally.alarms as f64),
            recall: share(found as f64, tally.ruptures as f64),
            f1: share(2.0 * found as f64, (tally.alarms + tally.ruptures) as f64),
            median_delay_s,
            min_delay_s: delays_s.first().copied(),
            max_delay_s: delays_s.last().copied(),
            recorded_s: tally.recorded_s,
            contact_s: tally.contact_s,
            false_alarms_per_minute: share(60.0 * false_alarms as f64, tally.recorded_s),
            false_alarms_per_contact_minute: share(60.0 * false_alarms as f64, tally.contact_s),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scores_follow_their_definitions() {
        let mut tally = Tally {
            recordings: 1,
            ruptures: 4,
            alarms: 5,
            delays_s: vec![0.006, 0.002],
            recorded_s: 30.0,
            contact_s: 20.0,
        };
        let scores = Scores::of(&tally);
        assert_eq!((scores.found, scores.missed, scores.false_alarms), (2, 2, 3));
        assert_eq!((scores.precision, scores.recall, scores.f1), (Some(0.4), Some(0.5), Some(4.0 / 9.0)));
        assert_eq!((scores.min_delay_s, scores.median_delay_s), (Some(0.002), Some(0.004)));
        assert_eq!(scores.false_alarms_per_minute, Some(6.0));
        assert_eq!(scores.false_alarms_per_contact_minute, Some(9.0));
        tally.add(&Tally {
            recordings: 1,
            ruptures: 1,
            alarms: 1,
            delays_s: vec![0.03],
            recorded_s: 30.0,
            contact_s: 0.0,
        });
        let scores = Scores::of(&tally);
        assert_eq!((scores.recordings, scores.found, scores.median_delay_s), (2, 3, Some(0.006)));
        assert_eq!(scores.false_alarms_per_minute, Some(3.0));
    }

    #[test]
    fn undefined_scores_are_none() {
        let scores = Scores::of(&Tally::default());
        assert_eq!((scores.precision, scores.recall, scores.f1, scores.median_delay_s), (None, None, None, None));
        assert_eq!((scores.false_alarms_per_minute, scores.false_alarms_per_contact_minute), (None, None));
        let silent = Scores::of(&Tally { ruptures: 2, recorded_s: 1.0, ..Tally::default() });
        assert_eq!((silent.precision, silent.recall, silent.f1), (None, Some(0.0), Some(0.0)));
        assert_eq!(silent.false_alarms_per_minute, Some(0.0), "a rate of 0, because there is recorded time");
    }
}
