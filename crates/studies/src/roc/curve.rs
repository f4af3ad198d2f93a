use std::borrow::Cow;
use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Serialize;

use super::interval::{poisson, wilson};
use super::tally::Tally;

/// The performance of a detector at one threshold. Intervals are 95 % confidence intervals.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Point {
    /// γ, in the unit of the distance; NaN (`null` in JSON) for a user-defined detector without a threshold.
    #[schemars(with = "Option<f64>")]
    pub threshold: f64,
    /// Number of cases.
    pub cases: u64,
    /// Number of cases in which every rupture is detected in time, without a false alarm.
    pub clean_cases: u64,
    /// Number of ruptures.
    pub ruptures: u64,
    /// Number of ruptures detected in time.
    pub detected: u64,
    /// Share of detections in time for each rupture of a case, in order.
    pub detection_of_each: Vec<f64>,
    /// Number of ruptures detected too late.
    pub late: u64,
    /// Number of ruptures without an alarm within 0.5 s, by the reason of the miss; only at the threshold of the
    /// settings.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub missed: BTreeMap<String, u64>,
    /// Share of ruptures detected in time; `None` without ruptures.
    pub detection: Option<f64>,
    /// Interval of `detection` (Wilson).
    pub detection_interval: Option<(f64, f64)>,
    /// Median delay of all detections in s, including late ones; `None` without a detection.
    pub delay_median_s: Option<f64>,
    /// 5 % quantile of the delay in s.
    pub delay_5_s: Option<f64>,
    /// 95 % quantile of the delay in s.
    pub delay_95_s: Option<f64>,
    /// Number of false alarms.
    pub false_alarms: u64,
    /// Time outside the windows after ruptures, in h.
    pub hours: f64,
    /// False alarms per minute; `None` without a false alarm, when only a bound is known, or without time.
    pub false_alarms_per_minute: Option<f64>,
    /// Interval of the false-alarm rate per minute (exact, Poisson). Without a false alarm it extends from 0 to the
    /// one-sided bound.
    pub false_alarms_per_minute_interval: Option<(f64, f64)>,
}

impl Point {
    pub fn of(threshold: f64, tally: &Tally) -> Self {
        let ruptures = tally.ruptures.iter().sum();
        let detected = tally.detected.iter().sum();
        let minutes = tally.quiet_ns as f64 / 60e9;
        let has_time = minutes > 0.0;
        let (low, high) = poisson(tally.false_alarms);
        let shares = tally.ruptures.iter().zip(&tally.detected);
        Self {
            threshold,
            cases: tally.cases,
            clean_cases: tally.clean_cases,
            ruptures,
            detected,
            detection_of_each: shares.filter(|(all, _)| **all > 0).map(|(all, of)| *of as f64 / *all as f64).collect(),
            late: tally.late,
            missed: tally.missed.clone(),
            detection: (ruptures > 0).then(|| detected as f64 / ruptures as f64),
            detection_interval: wilson(detected, ruptures),
            delay_median_s: tally.delay_quantile_s(0.5),
            delay_5_s: tally.delay_quantile_s(0.05),
            delay_95_s: tally.delay_quantile_s(0.95),
            false_alarms: tally.false_alarms,
            hours: minutes / 60.0,
            false_alarms_per_minute: (has_time && tally.false_alarms > 0).then(|| tally.false_alarms as f64 / minutes),
            false_alarms_per_minute_interval: has_time.then(|| (low / minutes, high / minutes)),
        }
    }

    /// 0 without a false alarm.
    pub fn false_alarms_per_hour(&self) -> f64 {
        60.0 * self.false_alarms_per_minute.unwrap_or(0.0)
    }
}

/// The performance of a detector by threshold, ascending.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Curve {
    /// Name of the distance in scenarios, or of the user-defined detector.
    pub detector: Cow<'static, str>,
    /// True for a baseline: a simple detector without a model of the tissue.
    pub is_baseline: bool,
    /// True for a user-defined detector, whose misses have no known reason.
    #[serde(skip)]
    pub is_user_defined: bool,
    /// Unit of the threshold.
    pub unit: &'static str,
    /// Threshold of the settings, in that unit; NaN (`null` in JSON) for a user-defined detector without a threshold.
    #[schemars(with = "Option<f64>")]
    pub own_threshold: f64,
    /// Drift, in that unit; NaN (`null` in JSON) for a user-defined detector.
    #[schemars(with = "Option<f64>")]
    pub drift: f64,
    /// The performance at each threshold.
    pub points: Vec<Point>,
}

impl Curve {
    /// `None` without the settings' threshold.
    pub fn at_own_threshold(&self) -> Option<&Point> {
        // `total_cmp` treats NaN as equal to itself.
        self.points.iter().find(|point| point.threshold.total_cmp(&self.own_threshold).is_eq())
    }

    /// Ordered by false alarms: the most detections for at most this number, then the shortest delay. Omits thresholds
    /// so low that the decision never settles.
    pub fn front(&self) -> Vec<&Point> {
        let mut points: Vec<&Point> = self.points.iter().collect();
        let delay = |point: &Point| point.delay_median_s.unwrap_or(f64::INFINITY);
        let better = |a: &Point, b: &Point| b.detected.cmp(&a.detected).then(delay(a).total_cmp(&delay(b)));
        points.sort_by(|a, b| a.false_alarms.cmp(&b.false_alarms).then(better(a, b)));
        let mut front: Vec<&Point> = vec![];
        for point in points {
            if front.last().is_none_or(|last| better(point, last).is_lt()) {
                front.push(point);
            }
        }
        front
    }

    /// The fewest false alarms with at least this share of the ruptures.
    pub fn at_detection(&self, share: f64) -> Option<&Point> {
        let sufficient = self.points.iter().filter(|point| point.detection.is_some_and(|detection| detection >= share));
        sufficient.min_by(|a, b| a.false_alarms.cmp(&b.false_alarms).then(b.detected.cmp(&a.detected)))
    }

    /// The most detections with at most this rate.
    pub fn at_false_alarms_per_hour(&self, rate: f64) -> Option<&Point> {
        let allowed = self.points.iter().filter(|point| point.false_alarms_per_hour() <= rate);
        allowed.max_by(|a, b| a.detected.cmp(&b.detected).then(b.false_alarms.cmp(&a.false_alarms)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tally(detected: u64, false_alarms: u64) -> Tally {
        Tally {
            cases: 100,
            ruptures: vec![100],
            detected: vec![detected],
            false_alarms,
            quiet_ns: 3_600_000_000_000,
            ..Tally::default()
        }
    }

    #[test]
    fn a_rate_without_false_alarms_is_bounded_and_not_zero() {
        let point = Point::of(1.0, &tally(0, 0));
        assert_eq!((point.false_alarms_per_minute, point.delay_median_s, point.hours), (None, None, 1.0));
        let (low, high) = point.false_alarms_per_minute_interval.expect("an hour");
        assert_eq!(low, 0.0);
        assert!((60.0 * high - 2.9957).abs() < 1e-3, "three an hour: {high}");
        let nothing = Point::of(1.0, &Tally::default());
        assert_eq!((nothing.detection, nothing.false_alarms_per_minute_interval), (None, None));
    }

    #[test]
    fn operating_points_are_the_best_that_keep_their_condition() {
        let of = |threshold, detected, false_alarms| Point::of(threshold, &tally(detected, false_alarms));
        let points = vec![of(1.0, 100, 7), of(2.0, 99, 1), of(3.0, 98, 1), of(4.0, 80, 0)];
        let curve = Curve {
            detector: "squared-residual".into(),
            is_baseline: false,
            is_user_defined: false,
            unit: "N²",
            own_threshold: 3.0,
            drift: 1.0,
            points,
        };
        let threshold = |point: Option<&Point>| point.map(|point| point.threshold);
        let front: Vec<f64> = curve.front().iter().map(|point| point.threshold).collect();
        assert_eq!(front, [4.0, 2.0, 1.0]);
        assert_eq!(threshold(curve.at_own_threshold()), Some(3.0));
        assert_eq!(threshold(curve.at_detection(0.995)), Some(1.0));
        assert_eq!(threshold(curve.at_detection(0.98)), Some(2.0));
        assert_eq!(threshold(curve.at_false_alarms_per_hour(1.0)), Some(2.0));
        assert_eq!(threshold(curve.at_false_alarms_per_hour(0.5)), Some(4.0));
    }
}
