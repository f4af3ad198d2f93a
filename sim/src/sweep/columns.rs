//! The metrics that a sweep can keep of each case.

use super::stability::{LoopOfCase, OF_LOOP};
use crate::compare::Unit;
use crate::metrics::{EventMetrics, Metrics, Outcome, RuptureMetrics, meaning};
use crate::scenario::nearest_of;

/// Where a column's value comes from.
#[derive(Debug, Clone, Copy)]
enum Measure {
    Run(fn(&Metrics) -> Option<f64>),
    Rupture(usize, fn(&RuptureMetrics) -> Option<f64>),
    Event(usize, fn(&EventMetrics) -> Option<f64>),
    Loop(fn(&LoopOfCase<'_>) -> Option<f64>),
}

/// A metric that is kept: its name in files, its unit, and how it is read off a run.
#[derive(Debug, Clone)]
pub struct Column {
    /// As in `rupture_1_detection_delay_s`.
    pub name: String,
    /// What it means, in a sentence.
    pub meaning: &'static str,
    /// Its unit.
    pub unit: Unit,
    measure: Measure,
}

type OfRun = (&'static str, Unit, &'static str, fn(&Metrics) -> Option<f64>);
type OfRupture = (&'static str, Unit, &'static str, fn(&RuptureMetrics) -> Option<f64>);
type OfEvent = (&'static str, Unit, &'static str, fn(&EventMetrics) -> Option<f64>);

/// The most of what the ruptures of a run have.
fn most(metrics: &Metrics, value: fn(&RuptureMetrics) -> Option<f64>) -> Option<f64> {
    metrics.ruptures.iter().filter_map(value).reduce(f64::max)
}

fn count(number: u64) -> Option<f64> {
    Some(number as f64)
}

const OF_RUN: &[OfRun] = &[
    ("ruptures", Unit::Count, meaning::RUPTURES, |m| count(m.ruptures.len() as u64)),
    ("detected_ruptures", Unit::Count, meaning::DETECTED_RUPTURES, |m| {
        count(m.alarms.iter().filter(|alarm| alarm.matched).count() as u64)
    }),
    ("missed_ruptures", Unit::Count, meaning::MISSED_RUPTURES, |m| count(m.missed_ruptures)),
    ("undecided_ruptures", Unit::Count, meaning::UNDECIDED_RUPTURES, |m| count(m.undecided_ruptures)),
    ("false_alarms", Unit::Count, meaning::FALSE_ALARMS, |m| count(m.false_alarms)),
    ("ignored_alarms", Unit::Count, meaning::IGNORED_ALARMS, |m| count(m.ignored_alarms)),
    ("most_detection_delay_s", Unit::Second, "The longest detection delay of the run's ruptures.", |m| {
        most(m, |r| r.detection_delay_s)
    }),
    ("most_slave_overshoot_m", Unit::Metre, "The longest lurch of the needle after any of the run's ruptures.", |m| {
        most(m, |r| r.slave_overshoot_m)
    }),
    (
        "most_slave_travel_m",
        Unit::Metre,
        "The farthest that the needle has gone on 0.3 s after any of the run's ruptures.",
        |m| most(m, |r| r.slave_travel_m),
    ),
    ("least_felt_contrast", Unit::Share, "The least felt contrast of the run's ruptures.", |m| {
        m.ruptures.iter().filter_map(|r| r.felt_contrast).reduce(f64::min)
    }),
    ("events", Unit::Count, meaning::EVENTS, |m| count(m.events.len() as u64)),
    ("most_frozen_motion_m", Unit::Metre, meaning::FROZEN_MOTION, |m| {
        m.events.iter().map(|event| event.frozen_motion_m).reduce(f64::max)
    }),
    ("peak_reengaging_speed_m_per_s", Unit::MetrePerSecond, meaning::PEAK_REENGAGING_SPEED, |m| {
        m.peak_reengaging_speed_m_per_s
    }),
    ("feedback_step_excess_n", Unit::Newton, meaning::FEEDBACK_STEP_EXCESS, |m| Some(m.feedback_step_excess_n)),
    ("mean_absolute_residual_n", Unit::Newton, meaning::MEAN_RESIDUAL, |m| m.mean_absolute_residual_n),
    ("least_tissue_force_n", Unit::Newton, meaning::MIN_TISSUE_FORCE, |m| m.least_tissue_force_n),
    ("greatest_tissue_force_n", Unit::Newton, meaning::MAX_TISSUE_FORCE, |m| m.greatest_tissue_force_n),
    ("tracking_rmse_m", Unit::Metre, meaning::TRACKING_RMSE, |m| m.tracking_rmse_m),
    ("final_slave_position_m", Unit::Metre, meaning::FINAL_SLAVE_POSITION, |m| m.final_slave_position_m),
    ("final_tracking_error", Unit::Share, meaning::FINAL_TRACKING_ERROR, |m| m.final_tracking_error),
    ("teleoperation_s", Unit::Second, meaning::TELEOPERATION_TIME, |m| Some(m.mode_times.teleoperation_s)),
    ("augmented_s", Unit::Second, meaning::AUGMENTED_TIME, |m| Some(m.mode_times.augmented_s)),
    ("reengaging_s", Unit::Second, meaning::REENGAGING_TIME, |m| Some(m.mode_times.reengaging_s)),
    ("mode_switches", Unit::Count, meaning::MODE_SWITCHES, |m| count(m.mode_switches)),
    ("operator_energy_j", Unit::Joule, meaning::OPERATOR_ENERGY, |m| m.operator_energy_j),
    ("tissue_energy_j", Unit::Joule, meaning::TISSUE_ENERGY, |m| m.tissue_energy_j),
    ("diverged_s", Unit::Second, meaning::DIVERGED, |m| match m.outcome {
        Outcome::Completed => None,
        Outcome::Diverged { time_s } => Some(time_s),
    }),
    ("link_outages", Unit::Count, meaning::LINK_OUTAGES, |m| m.link.and_then(|link| count(link.outages))),
    ("link_longest_outage_s", Unit::Second, meaning::LINK_LONGEST_OUTAGE, |m| m.link.map(|link| link.longest_outage_s)),
    ("link_given_up_s", Unit::Second, meaning::LINK_GIVEN_UP, |m| m.link.and_then(|link| link.given_up_s)),
    ("link_master_port_energy_j", Unit::Joule, meaning::LINK_MASTER_PORT, |m| {
        m.link.map(|link| link.master_port_energy_j)
    }),
    ("link_slave_port_energy_j", Unit::Joule, meaning::LINK_SLAVE_PORT, |m| {
        m.link.map(|link| link.slave_port_energy_j)
    }),
    ("link_master_dissipated_j", Unit::Joule, meaning::LINK_MASTER_DISSIPATED, |m| {
        m.link.map(|link| link.master_dissipated_j)
    }),
    ("link_slave_refused_j", Unit::Joule, meaning::LINK_SLAVE_REFUSED, |m| m.link.map(|link| link.slave_refused_j)),
];

/// Those of one rupture, named `rupture_1_…`.
const OF_RUPTURE: &[OfRupture] = &[
    ("time_s", Unit::Second, meaning::RUPTURE_TIME, |r| Some(r.time_s)),
    ("detection_delay_s", Unit::Second, meaning::DETECTION_DELAY, |r| r.detection_delay_s),
    ("slave_overshoot_m", Unit::Metre, meaning::SLAVE_OVERSHOOT, |r| r.slave_overshoot_m),
    ("slave_travel_m", Unit::Metre, meaning::SLAVE_TRAVEL, |r| r.slave_travel_m),
    ("master_position_m", Unit::Metre, meaning::MASTER_POSITION, |r| Some(r.master_position_m)),
    ("master_travel_m", Unit::Metre, meaning::MASTER_TRAVEL, |r| r.master_travel_m),
    ("feedback_fall_s", Unit::Second, meaning::FEEDBACK_FALL, |r| r.feedback_fall_s),
    ("felt_fall_s", Unit::Second, meaning::FELT_FALL, |r| r.felt_fall_s),
    ("peak_force_rate_n_per_s", Unit::NewtonPerSecond, meaning::PEAK_FORCE_RATE, |r| r.peak_force_rate_n_per_s),
    ("felt_contrast", Unit::Share, meaning::FELT_CONTRAST, |r| r.felt_contrast),
];

/// Those of one augmented event, named `event_1_…`.
const OF_EVENT: &[OfEvent] = &[
    ("start_s", Unit::Second, meaning::EVENT_START, |e| Some(e.start_s)),
    ("augmented_s", Unit::Second, meaning::EVENT_AUGMENTED, |e| e.augmented_s),
    ("reengaging_s", Unit::Second, meaning::EVENT_REENGAGING, |e| e.reengaging_s),
    ("master_start_m", Unit::Metre, meaning::MASTER_START, |e| Some(e.master_start_m)),
    ("master_end_m", Unit::Metre, meaning::MASTER_END, |e| Some(e.master_end_m)),
    ("frozen_motion_m", Unit::Metre, meaning::FROZEN_MOTION, |e| Some(e.frozen_motion_m)),
    ("peak_reengaging_speed_m_per_s", Unit::MetrePerSecond, meaning::PEAK_REENGAGING_SPEED, |e| {
        e.peak_reengaging_speed_m_per_s
    }),
    ("entry_step_n", Unit::Newton, meaning::ENTRY_STEP, |e| Some(e.entry_step_n)),
    ("exit_step_n", Unit::Newton, meaning::EXIT_STEP, |e| e.exit_step_n),
];

/// What is kept where a sweep file does not say, and these of the first rupture.
const DEFAULTS: [&str; 9] = [
    "detected_ruptures",
    "missed_ruptures",
    "false_alarms",
    "most_slave_overshoot_m",
    "least_felt_contrast",
    "mean_absolute_residual_n",
    "greatest_tissue_force_n",
    "tracking_rmse_m",
    "tissue_energy_j",
];
const DEFAULTS_OF_RUPTURE: [&str; 4] = ["detection_delay_s", "slave_overshoot_m", "slave_travel_m", "feedback_fall_s"];

/// The highest number that a rupture or an event can be asked for by.
const MAX_NUMBERED: usize = 64;

impl Column {
    /// The column of a name; none if nothing is called so.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        let column = |unit, meaning, measure| Some(Self { name: name.to_owned(), meaning, unit, measure });
        if let Some((_, unit, meaning, of)) = OF_RUN.iter().find(|(known, ..)| *known == name) {
            return column(*unit, meaning, Measure::Run(*of));
        }
        if let Some((_, unit, meaning, of)) = OF_LOOP.iter().find(|(known, ..)| *known == name) {
            return column(*unit, meaning, Measure::Loop(*of));
        }
        if let Some((number, field)) = numbered(name, "rupture_") {
            let (_, unit, meaning, of) = OF_RUPTURE.iter().find(|(known, ..)| *known == field)?;
            return column(*unit, meaning, Measure::Rupture(number - 1, *of));
        }
        let (number, field) = numbered(name, "event_")?;
        let (_, unit, meaning, of) = OF_EVENT.iter().find(|(known, ..)| *known == field)?;
        column(*unit, meaning, Measure::Event(number - 1, *of))
    }

    /// What is kept where nothing is said.
    #[must_use]
    pub fn defaults() -> Vec<Self> {
        let of_rupture = DEFAULTS_OF_RUPTURE.map(|field| format!("rupture_1_{field}"));
        DEFAULTS.map(str::to_owned).into_iter().chain(of_rupture).filter_map(|name| Self::named(&name)).collect()
    }

    /// Every name, those of ruptures and events with the number 1.
    pub fn names() -> impl Iterator<Item = String> {
        let of_run = OF_RUN.iter().map(|(name, ..)| (*name).to_owned());
        let of_rupture = OF_RUPTURE.iter().map(|(name, ..)| format!("rupture_1_{name}"));
        let of_loop = OF_LOOP.iter().map(|(name, ..)| (*name).to_owned());
        of_run.chain(of_loop).chain(of_rupture).chain(OF_EVENT.iter().map(|(name, ..)| format!("event_1_{name}")))
    }

    /// The name most like another, if any is.
    #[must_use]
    pub fn nearest(name: &str) -> Option<String> {
        nearest_of(name, Self::names())
    }

    /// Whether it takes the case's loop.
    #[must_use]
    pub fn is_of_loop(&self) -> bool {
        matches!(self.measure, Measure::Loop(_))
    }

    /// Its value in SI; none where it is undefined, or no finite number.
    #[must_use]
    pub fn value(&self, metrics: &Metrics, of_case: Option<&LoopOfCase<'_>>) -> Option<f64> {
        let value = match self.measure {
            Measure::Run(of) => of(metrics),
            Measure::Rupture(index, of) => metrics.ruptures.get(index).and_then(of),
            Measure::Event(index, of) => metrics.events.get(index).and_then(of),
            Measure::Loop(of) => of_case.and_then(of),
        };
        value.filter(|value| value.is_finite())
    }

    /// Whether its values are whole numbers.
    #[must_use]
    pub fn is_count(&self) -> bool {
        self.unit == Unit::Count
    }
}

/// The number, from 1, and the field of a name such as `rupture_2_time_s`.
fn numbered<'a>(name: &'a str, prefix: &str) -> Option<(usize, &'a str)> {
    let (number, field) = name.strip_prefix(prefix)?.split_once('_')?;
    let is_plain = number.bytes().all(|digit| digit.is_ascii_digit()) && !number.starts_with('0');
    let number = number.parse().ok().filter(|number| is_plain && (1..=MAX_NUMBERED).contains(number))?;
    Some((number, field))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_found_and_near_ones_named() {
        assert!(Column::names().all(|name| Column::named(&name).is_some_and(|column| column.name == name)));
        let meaning = |name: String| Column::named(&name).map_or("", |column| column.meaning);
        assert!(Column::names().map(meaning).all(|meaning| meaning.ends_with('.') && meaning.len() > 20));
        assert_eq!(Column::defaults().len(), DEFAULTS.len() + DEFAULTS_OF_RUPTURE.len());
        assert!(Column::named("rupture_12_felt_fall_s").is_some());
        for wrong in ["rupture_0_time_s", "rupture_01_time_s", "rupture_+1_time_s", "rupture_99_time_s", "rupture_1_x"]
        {
            assert!(Column::named(wrong).is_none(), "{wrong}");
        }
        assert_eq!(Column::nearest("false_alarm").as_deref(), Some("false_alarms"));
        assert_eq!(Column::nearest("zzz"), None);
    }
}
