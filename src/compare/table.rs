//! The metrics of several runs, row by row.

use serde::Serialize;

use super::NoiseCheck;
use crate::metrics::{Metrics, Outcome, RuptureMetrics};

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
    /// Its unit.
    pub unit: Unit,
    /// Its values in SI; none where undefined.
    pub values: Vec<Option<f64>>,
}

/// Every row of the table; those in noise where it was looked at.
#[must_use]
pub fn rows(runs: &[&Metrics], noise: &[NoiseCheck]) -> Vec<Row> {
    let of = |metric: &str, unit: Unit, value: &dyn Fn(&Metrics) -> Option<f64>| Row {
        metric: metric.to_owned(),
        unit,
        values: runs.iter().map(|metrics| value(metrics)).collect(),
    };
    let mut rows = vec![of("diverged at", Unit::Second, &|m| match m.outcome {
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
        of("missed ruptures", Unit::Count, &|m| count(m.missed_ruptures)),
        of("false alarms", Unit::Count, &|m| count(m.false_alarms)),
        of("alarms ignored during events", Unit::Count, &|m| count(m.ignored_alarms)),
        of("mean |prediction error|", Unit::Newton, &|m| m.mean_absolute_residual_n),
        of("least tissue force", Unit::Newton, &|m| m.least_tissue_force_n),
        of("greatest tissue force", Unit::Newton, &|m| m.greatest_tissue_force_n),
        of("tracking RMSE in teleoperation", Unit::Metre, &|m| m.tracking_rmse_m),
        of("final tracking error", Unit::Share, &|m| m.final_tracking_error),
        of("largest motion while frozen", Unit::Metre, &|m| {
            m.events.iter().map(|event| event.frozen_motion_m).reduce(f64::max)
        }),
        of("peak slave speed re-engaging", Unit::MetrePerSecond, &|m| m.peak_reengaging_speed_m_per_s),
        of("force step beyond its law", Unit::Newton, &|m| Some(m.feedback_step_excess_n.max(0.0))),
        of("time augmented", Unit::Second, &|m| Some(m.mode_times.augmented_s)),
        of("time re-engaging", Unit::Second, &|m| Some(m.mode_times.reengaging_s)),
        of("mode switches", Unit::Count, &|m| count(m.mode_switches)),
        of("energy from the hand", Unit::Joule, &|m| m.operator_energy_j),
        of("energy into the tissue", Unit::Joule, &|m| m.tissue_energy_j),
    ]);
    let mut link_rows = vec![
        of("link: outages", Unit::Count, &|m| m.link.and_then(|link| count(link.outages))),
        of("link: longest outage", Unit::Second, &|m| m.link.map(|link| link.longest_outage_s)),
        of("link: given up at", Unit::Second, &|m| m.link.and_then(|link| link.given_up_s)),
        of("link: energy dissipated at the master", Unit::Joule, &|m| m.link.map(|link| link.master_dissipated_j)),
        of("link: energy kept from the slave", Unit::Joule, &|m| m.link.map(|link| link.slave_refused_j)),
    ];
    // Where no link has anything to tell, its rows would only be read past.
    link_rows.retain(|row| row.values.iter().flatten().any(|value| *value != 0.0));
    rows.extend(link_rows);
    if noise.is_empty() {
        return rows;
    }
    let noisy = |metric: &str, value: &dyn Fn(&NoiseCheck) -> u64| Row {
        metric: metric.to_owned(),
        unit: Unit::Count,
        values: noise.iter().map(|check| count(value(check))).collect(),
    };
    rows.extend([
        noisy("in noise: missed ruptures", &|n| n.missed_ruptures),
        noisy("in noise: false alarms", &|n| n.false_alarms),
        noisy("in noise, derivative CUSUM: missed ruptures", &|n| n.derivative_missed_ruptures),
        noisy("in noise, derivative CUSUM: false alarms", &|n| n.derivative_false_alarms),
    ]);
    rows.push(Row {
        metric: "in noise, derivative: false samples at best".to_owned(),
        unit: Unit::Count,
        values: noise.iter().map(|check| check.derivative_exceedances.map(|samples| samples as f64)).collect(),
    });
    rows
}

/// What happened after one rupture.
fn rupture_rows(runs: &[&Metrics], index: usize) -> Vec<Row> {
    let of = |metric: &str, unit: Unit, value: &dyn Fn(&RuptureMetrics) -> Option<f64>| Row {
        metric: format!("rupture {}: {metric}", index + 1),
        unit,
        values: runs.iter().map(|metrics| metrics.ruptures.get(index).and_then(value)).collect(),
    };
    vec![
        of("detection delay", Unit::Second, &|r| r.detection_delay_s),
        of("slave overshoot", Unit::Metre, &|r| r.slave_overshoot_m),
        of("slave travel at 0.3 s", Unit::Metre, &|r| r.slave_travel_m),
        of("master travel", Unit::Metre, &|r| r.master_travel_m),
        of("fed-back force down to 5 %", Unit::Second, &|r| r.feedback_fall_s),
        of("felt force down to 5 %", Unit::Second, &|r| r.felt_fall_s),
        of("peak rate of the felt force", Unit::NewtonPerSecond, &|r| r.peak_force_rate_n_per_s),
        of("felt contrast", Unit::Share, &|r| r.felt_contrast),
    ]
}
