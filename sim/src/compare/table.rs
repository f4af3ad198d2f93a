//! The metrics of several runs, row by row.

use serde::Serialize;

use super::NoiseCheck;
use crate::metrics::{Metrics, Outcome, RuptureMetrics, meaning};

/// The unit in which people read a quantity; the value itself stays in SI.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Unit {
    /// Metres, read in mm.
    Metre,
    /// Metres per second, read in mm/s.
    MetrePerSecond,
    /// Seconds, read in ms.
    Second,
    /// Newtons.
    Newton,
    /// Newtons per second.
    NewtonPerSecond,
    /// Joules, read in mJ.
    Joule,
    /// A share of 1, read in %.
    Share,
    /// A number as it is: a ratio, an angle in rad, a frequency in Hz.
    Number,
    /// A number of things.
    Count,
}

impl Unit {
    /// The SI unit in which values are; `"1"` for numbers without one.
    #[must_use]
    pub fn si(self) -> &'static str {
        match self {
            Self::Metre => "m",
            Self::MetrePerSecond => "m/s",
            Self::Second => "s",
            Self::Newton => "N",
            Self::NewtonPerSecond => "N/s",
            Self::Joule => "J",
            Self::Share | Self::Number | Self::Count => "1",
        }
    }
}

/// One metric, a value per scenario.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// What it is.
    pub metric: String,
    /// What it means, in a sentence.
    #[serde(skip)]
    pub meaning: &'static str,
    /// Its unit.
    pub unit: Unit,
    /// Its values in SI; none where undefined.
    pub values: Vec<Option<f64>>,
}

const IN_NOISE_MISSED: &str = "Ruptures missed when the scenario is run again with 0.025 N of added force noise.";
const IN_NOISE_FALSE: &str = "False alarms in that noise.";
const DERIVATIVE_MISSED: &str = "Ruptures missed in that noise by a CUSUM over the force's derivative, for comparison.";
const DERIVATIVE_FALSE: &str = "False alarms of that derivative detector.";
const DERIVATIVE_SAMPLES: &str =
    "Samples away from ruptures at which the derivative is beyond the highest threshold that still finds all of them.";

/// Every row of the table; those in noise where it was looked at.
#[must_use]
pub fn rows(runs: &[&Metrics], noise: &[NoiseCheck]) -> Vec<Row> {
    let of = |metric: &str, unit: Unit, meaning: &'static str, value: &dyn Fn(&Metrics) -> Option<f64>| Row {
        metric: metric.to_owned(),
        meaning,
        unit,
        values: runs.iter().map(|metrics| value(metrics)).collect(),
    };
    let mut rows = vec![of("diverged at", Unit::Second, meaning::DIVERGED, &|m| match m.outcome {
        Outcome::Completed => None,
        Outcome::Diverged { time_s } => Some(time_s),
    })];
    rows.retain(|row| row.values.iter().any(Option::is_some));
    let ruptures = runs.iter().map(|metrics| metrics.ruptures.len()).max().unwrap_or(0);
    for index in 0..ruptures {
        rows.extend(rupture_rows(runs, index));
    }
    let count = |n: u64| Some(n as f64);
    rows.extend([
        of("missed ruptures", Unit::Count, meaning::MISSED_RUPTURES, &|m| count(m.missed_ruptures)),
        of("false alarms", Unit::Count, meaning::FALSE_ALARMS, &|m| count(m.false_alarms)),
        of("alarms ignored during events", Unit::Count, meaning::IGNORED_ALARMS, &|m| count(m.ignored_alarms)),
        of("mean |prediction error|", Unit::Newton, meaning::MEAN_RESIDUAL, &|m| m.mean_absolute_residual_n),
        of("least tissue force", Unit::Newton, meaning::MIN_TISSUE_FORCE, &|m| m.least_tissue_force_n),
        of("greatest tissue force", Unit::Newton, meaning::MAX_TISSUE_FORCE, &|m| m.greatest_tissue_force_n),
        of("tracking RMSE in teleoperation", Unit::Metre, meaning::TRACKING_RMSE, &|m| m.tracking_rmse_m),
        of("final tracking error", Unit::Share, meaning::FINAL_TRACKING_ERROR, &|m| m.final_tracking_error),
        of("largest motion while frozen", Unit::Metre, meaning::FROZEN_MOTION, &|m| {
            m.events.iter().map(|event| event.frozen_motion_m).reduce(f64::max)
        }),
        of("peak slave speed re-engaging", Unit::MetrePerSecond, meaning::PEAK_REENGAGING_SPEED, &|m| {
            m.peak_reengaging_speed_m_per_s
        }),
        of("force step beyond its law", Unit::Newton, meaning::FEEDBACK_STEP_EXCESS, &|m| {
            Some(m.feedback_step_excess_n.max(0.0))
        }),
        of("time augmented", Unit::Second, meaning::AUGMENTED_TIME, &|m| Some(m.mode_times.augmented_s)),
        of("time re-engaging", Unit::Second, meaning::REENGAGING_TIME, &|m| Some(m.mode_times.reengaging_s)),
        of("mode switches", Unit::Count, meaning::MODE_SWITCHES, &|m| count(m.mode_switches)),
        of("energy from the hand", Unit::Joule, meaning::OPERATOR_ENERGY, &|m| m.operator_energy_j),
        of("energy into the tissue", Unit::Joule, meaning::TISSUE_ENERGY, &|m| m.tissue_energy_j),
    ]);
    let mut link_rows = vec![
        of("link: outages", Unit::Count, meaning::LINK_OUTAGES, &|m| m.link.and_then(|link| count(link.outages))),
        of("link: longest outage", Unit::Second, meaning::LINK_LONGEST_OUTAGE, &|m| {
            m.link.map(|link| link.longest_outage_s)
        }),
        of("link: given up at", Unit::Second, meaning::LINK_GIVEN_UP, &|m| m.link.and_then(|link| link.given_up_s)),
        of("link: energy dissipated at the master", Unit::Joule, meaning::LINK_MASTER_DISSIPATED, &|m| {
            m.link.map(|link| link.master_dissipated_j)
        }),
        of("link: energy kept from the slave", Unit::Joule, meaning::LINK_SLAVE_REFUSED, &|m| {
            m.link.map(|link| link.slave_refused_j)
        }),
    ];
    // Where no link has anything to tell, its rows would only be read past.
    link_rows.retain(|row| row.values.iter().flatten().any(|value| *value != 0.0));
    rows.extend(link_rows);
    if noise.is_empty() {
        return rows;
    }
    let noisy = |metric: &str, meaning: &'static str, value: &dyn Fn(&NoiseCheck) -> u64| Row {
        metric: metric.to_owned(),
        meaning,
        unit: Unit::Count,
        values: noise.iter().map(|check| count(value(check))).collect(),
    };
    rows.extend([
        noisy("in noise: missed ruptures", IN_NOISE_MISSED, &|n| n.missed_ruptures),
        noisy("in noise: false alarms", IN_NOISE_FALSE, &|n| n.false_alarms),
        noisy("in noise, derivative CUSUM: missed ruptures", DERIVATIVE_MISSED, &|n| n.derivative_missed_ruptures),
        noisy("in noise, derivative CUSUM: false alarms", DERIVATIVE_FALSE, &|n| n.derivative_false_alarms),
    ]);
    rows.push(Row {
        metric: "in noise, derivative: false samples at best".to_owned(),
        meaning: DERIVATIVE_SAMPLES,
        unit: Unit::Count,
        values: noise.iter().map(|check| check.derivative_exceedances.map(|samples| samples as f64)).collect(),
    });
    rows
}

/// What happened after one rupture.
fn rupture_rows(runs: &[&Metrics], index: usize) -> Vec<Row> {
    let of = |metric: &str, unit: Unit, meaning: &'static str, value: &dyn Fn(&RuptureMetrics) -> Option<f64>| Row {
        metric: format!("rupture {}: {metric}", index + 1),
        meaning,
        unit,
        values: runs.iter().map(|metrics| metrics.ruptures.get(index).and_then(value)).collect(),
    };
    vec![
        of("detection delay", Unit::Second, meaning::DETECTION_DELAY, &|r| r.detection_delay_s),
        of("slave overshoot", Unit::Metre, meaning::SLAVE_OVERSHOOT, &|r| r.slave_overshoot_m),
        of("slave travel at 0.3 s", Unit::Metre, meaning::SLAVE_TRAVEL, &|r| r.slave_travel_m),
        of("master travel", Unit::Metre, meaning::MASTER_TRAVEL, &|r| r.master_travel_m),
        of("fed-back force down to 5 %", Unit::Second, meaning::FEEDBACK_FALL, &|r| r.feedback_fall_s),
        of("felt force down to 5 %", Unit::Second, meaning::FELT_FALL, &|r| r.felt_fall_s),
        of("peak rate of the felt force", Unit::NewtonPerSecond, meaning::PEAK_FORCE_RATE, &|r| {
            r.peak_force_rate_n_per_s
        }),
        of("felt contrast", Unit::Share, meaning::FELT_CONTRAST, &|r| r.felt_contrast),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::measure;
    use crate::scenario::{Scenario, Source};

    #[test]
    fn every_row_says_in_a_sentence_of_its_own_what_it_means() {
        let load = |name: &str| Scenario::load(&Source::Builtin(name.into()), &[]).expect("a scenario");
        let scenarios = ["augmented.toml", "17_outage_at_the_rupture.toml"].map(load);
        let metrics = scenarios.each_ref().map(|scenario| measure(scenario).expect("a run"));
        let noise = [super::super::check_in_noise(&scenarios[0]).expect("a run")];
        let rows = rows(&metrics.iter().collect::<Vec<_>>(), &noise);
        assert!(rows.iter().any(|row| row.metric.starts_with("link: ")), "the rows of links are judged too");
        for row in rows {
            assert!(row.meaning.ends_with('.') && row.meaning.len() > 20, "{}: {:?}", row.metric, row.meaning);
        }
    }
}
