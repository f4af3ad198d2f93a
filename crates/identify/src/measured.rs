use std::path::Path;

use trocar_base::warning::Warning;
use trocar_recording::{Column, Limits};

use crate::IdentifyError;
use crate::filter::{half, slope};
use crate::grid::{Grid, check};

pub(crate) const VELOCITY_HALF_S: f64 = 2.5e-3;

/// Factors convert to SI units.
#[derive(Debug, Clone, PartialEq)]
pub struct MachineColumns {
    pub time: Column,
    /// Scaled to the slave's side.
    pub master: Column,
    pub slave: Column,
    /// Positive when it resists the motion.
    pub force: Column,
    /// Positive when it pushes forwards.
    pub actuator: Option<Column>,
}

/// Evenly spaced.
#[derive(Debug, Clone, PartialEq)]
pub struct Measured {
    pub name: String,
    pub interval_s: f64,
    pub master_m: Vec<f64>,
    pub slave_m: Vec<f64>,
    pub force_n: Vec<f64>,
    pub actuator_n: Option<Vec<f64>>,
    pub(crate) master_velocity_m_per_s: Vec<f64>,
    pub(crate) master_acceleration_m_per_s2: Vec<f64>,
    pub(crate) start_velocity_m_per_s: f64,
    pub(crate) unfinished: Option<Warning>,
}

impl Measured {
    /// Resamples unevenly spaced samples at their median interval.
    pub fn open(path: &Path, columns: &MachineColumns, limits: &Limits) -> Result<Self, IdentifyError> {
        let MachineColumns { time, master, slave, force, actuator } = columns;
        let others = std::iter::once(master).chain(actuator);
        let Grid { name, interval_s, position_m, force_n, others, unfinished } =
            Grid::open(path, time, slave, force, others, limits)?;
        let mut others = others.into_iter();
        let (master_m, actuator_n) = (others.next().unwrap_or_default(), others.next());
        let slave_m = position_m;
        let measured = Self::new(&name, interval_s, master_m, slave_m, force_n, actuator_n)?;
        Ok(Self { unfinished, ..measured })
    }

    /// Takes columns in SI units.
    pub fn new(
        name: &str,
        interval_s: f64,
        master_m: Vec<f64>,
        slave_m: Vec<f64>,
        force_n: Vec<f64>,
        actuator_n: Option<Vec<f64>>,
    ) -> Result<Self, IdentifyError> {
        let recording = || name.to_owned();
        let others = [
            ("the slave's position", Some(&slave_m)),
            ("the master's position", Some(&master_m)),
            ("the force", Some(&force_n)),
            ("the actuator's force", actuator_n.as_ref()),
        ];
        let columns: Vec<(&'static str, &[f64])> =
            others.iter().filter_map(|(column, values)| Some((*column, values.as_ref()?.as_slice()))).collect();
        check(name, interval_s, &columns)?;
        for (side, flag, positions) in [("master", "--master", &master_m), ("slave", "--slave", &slave_m)] {
            let span_m = span(positions);
            // Smaller spans are rounding errors of double precision.
            if span_m < 1e-9 {
                return Err(IdentifyError::NoExcitation { recording: recording(), side, span_m, flag });
            }
        }
        let half = half(VELOCITY_HALF_S, interval_s);
        let master_velocity_m_per_s = slope(&master_m, half, interval_s);
        let master_acceleration_m_per_s2 = slope(&master_velocity_m_per_s, half, interval_s);
        let start_velocity_m_per_s = slope(&slave_m[..(2 * half + 1).max(3)], half, interval_s)[0];
        Ok(Self {
            name: recording(),
            interval_s,
            master_m,
            slave_m,
            force_n,
            actuator_n,
            master_velocity_m_per_s,
            master_acceleration_m_per_s2,
            start_velocity_m_per_s,
            unfinished: None,
        })
    }

    #[expect(clippy::len_without_is_empty, reason = "a recording is never empty")]
    pub fn len(&self) -> usize {
        self.slave_m.len()
    }

    /// 2-norm of the deviation from the mean; above 0.
    pub(crate) fn motion_m(&self) -> f64 {
        deviation(&self.slave_m)
    }

    pub fn fit_percent(&self, simulated_m: &[f64]) -> f64 {
        fit_percent(simulated_m, &self.slave_m, self.motion_m())
    }

    pub(crate) fn before(&self, end: usize) -> Self {
        let cut = |values: &[f64]| values[..end].to_vec();
        Self {
            name: self.name.clone(),
            interval_s: self.interval_s,
            master_m: cut(&self.master_m),
            slave_m: cut(&self.slave_m),
            force_n: cut(&self.force_n),
            actuator_n: self.actuator_n.as_deref().map(cut),
            master_velocity_m_per_s: cut(&self.master_velocity_m_per_s),
            master_acceleration_m_per_s2: cut(&self.master_acceleration_m_per_s2),
            start_velocity_m_per_s: self.start_velocity_m_per_s,
            unfinished: None,
        }
    }
}

pub(crate) fn span(values: &[f64]) -> f64 {
    let (low, high) =
        values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(*v), high.max(*v)));
    high - low
}

/// The 2-norm of the deviation from the mean.
pub(crate) fn deviation(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    values.iter().map(|value| (value - mean).powi(2)).sum::<f64>().sqrt()
}

/// `100 (1 - |simulated - measured| / variation)`, with the 2-norm.
pub(crate) fn fit_percent(simulated: &[f64], measured: &[f64], variation: f64) -> f64 {
    let squares = simulated.iter().zip(measured).map(|(simulated, measured)| (simulated - measured).powi(2));
    100.0 * (1.0 - squares.sum::<f64>().sqrt() / variation)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// Returns samples of functions of the time: master, slave and force.
    pub(crate) fn measured(interval_s: f64, samples: usize, at: impl Fn(f64) -> (f64, f64, f64)) -> Measured {
        let rows: Vec<(f64, f64, f64)> = (0..samples).map(|k| at(k as f64 * interval_s)).collect();
        let master_m: Vec<f64> = rows.iter().map(|row| row.0).collect();
        let half = half(VELOCITY_HALF_S, interval_s);
        let master_velocity_m_per_s = slope(&master_m, half, interval_s);
        Measured {
            name: "synthetic".into(),
            interval_s,
            master_acceleration_m_per_s2: slope(&master_velocity_m_per_s, half, interval_s),
            master_velocity_m_per_s,
            master_m,
            slave_m: rows.iter().map(|row| row.1).collect(),
            force_n: rows.iter().map(|row| row.2).collect(),
            actuator_n: None,
            start_velocity_m_per_s: 0.0,
            unfinished: None,
        }
    }

    #[test]
    fn a_recording_without_motion_or_with_columns_of_other_lengths_is_refused() {
        let moving: Vec<f64> = (0..400).map(|k| f64::from(k).sin()).collect();
        let new = |master: &[f64], slave: &[f64], force: &[f64]| {
            Measured::new("a.csv", 0.001, master.to_vec(), slave.to_vec(), force.to_vec(), None)
        };
        let message = |result: Result<Measured, IdentifyError>| result.expect_err("refused").to_string();
        assert!(message(new(&[0.0; 400], &moving, &moving)).contains("the master does not move"));
        assert!(message(new(&moving, &moving, &[0.0; 7])).contains("the force has 7 values and the time has 400"));
        assert!(message(new(&moving[..50], &moving[..50], &moving[..50])).contains("50 samples"));
        let mut wild = moving.clone();
        wild[3] = f64::NAN;
        assert!(message(new(&wild, &moving, &moving)).contains("NaN at sample 3"));
    }
}
