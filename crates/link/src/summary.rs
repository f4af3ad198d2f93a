use super::counters::Counters;
use super::endpoint::Trip;
use super::ends::Meter;
use super::lateness::LatenessSummary;
use super::packet::Role;
use schemars::JsonSchema;
use serde::Serialize;
use trocar_base::quantiles::quantile_of;
use trocar_engine::channel::Schedule;

#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, JsonSchema)]
pub struct Spread {
    /// The median.
    pub median: Option<f64>,
    /// The 99 % quantile.
    pub p99: Option<f64>,
    /// The maximum.
    pub worst: Option<f64>,
}

impl Spread {
    pub fn of(values: &mut [f64]) -> Self {
        Self { median: quantile_of(values, 0.5), p99: quantile_of(values, 0.99), worst: quantile_of(values, 1.0) }
    }
}

#[derive(Debug, Clone, Default)]
pub struct Trips {
    one_way_s: Vec<f64>,
    round_s: Vec<f64>,
}

impl Trips {
    pub fn new(messages: u64) -> Self {
        let empty = || Vec::with_capacity(messages as usize);
        Self { one_way_s: empty(), round_s: empty() }
    }

    pub fn add(&mut self, trip: &Trip) {
        self.one_way_s.push(trip.one_way_s);
        self.round_s.extend(trip.round_s);
    }
}

#[derive(Debug, Clone)]
pub struct SideSummary {
    pub scenario: String,
    pub role: Role,
    pub ticks: (u64, u64),
    pub tick_s: f64,
    pub counters: Counters,
    /// Messages of the other side that had not arrived at the end.
    pub lost: u64,
    pub delay_ticks: Spread,
    pub one_way_s: Spread,
    pub round_s: Spread,
    pub clock_s: f64,
    pub lateness: LatenessSummary,
    pub priority: String,
    pub meter: Meter,
    pub ruptures_s: Vec<f64>,
    pub alarms_s: Vec<f64>,
    pub silences: u64,
    pub silent_since_s: Option<f64>,
    pub restarts: u64,
    pub first_tick: u64,
}

impl SideSummary {
    pub fn delays(delays: &[u32]) -> (u64, Spread) {
        let mut arrived: Vec<f64> =
            delays.iter().filter(|delay| **delay != Schedule::LOST).map(|delay| f64::from(*delay)).collect();
        ((delays.len() - arrived.len()) as u64, Spread::of(&mut arrived))
    }

    pub fn times(mut trips: Trips) -> (Spread, Spread) {
        (Spread::of(&mut trips.one_way_s), Spread::of(&mut trips.round_s))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_that_never_arrived_is_lost_and_not_late() {
        let (lost, spread) = SideSummary::delays(&[2, Schedule::LOST, 3, 2, Schedule::LOST]);
        assert_eq!((lost, spread.median, spread.worst), (2, Some(2.0), Some(3.0)));
        let nothing = SideSummary::delays(&[Schedule::LOST]);
        assert_eq!(nothing, (1, Spread::default()));
    }
}
