//! The summary of a side of a link.

use super::counters::Counters;
use super::endpoint::Trip;
use super::ends::Meter;
use super::lateness::LatenessSummary;
use super::packet::Role;
use schemars::JsonSchema;
use serde::Serialize;
use trocar_base::quantiles::quantile_of;
use trocar_engine::channel::Schedule;

/// The distribution of values; `None` without values.
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
    /// Computes the distribution of values, and reorders them.
    #[must_use]
    pub fn of(values: &mut [f64]) -> Self {
        Self { median: quantile_of(values, 0.5), p99: quantile_of(values, 0.99), worst: quantile_of(values, 1.0) }
    }
}

/// The travel times of messages in s.
#[derive(Debug, Clone, Default)]
pub struct Trips {
    one_way_s: Vec<f64>,
    round_s: Vec<f64>,
}

impl Trips {
    /// Creates an empty list with capacity for a number of messages.
    #[must_use]
    pub fn new(messages: u64) -> Self {
        let empty = || Vec::with_capacity(messages as usize);
        Self { one_way_s: empty(), round_s: empty() }
    }

    /// Adds a message.
    pub fn add(&mut self, trip: &Trip) {
        self.one_way_s.push(trip.one_way_s);
        self.round_s.extend(trip.round_s);
    }
}

/// The final report of a side of a link.
#[derive(Debug, Clone)]
pub struct SideSummary {
    /// The name of the scenario.
    pub scenario: String,
    /// The side.
    pub role: Role,
    /// Number of completed ticks, and of ticks in the scenario.
    pub ticks: (u64, u64),
    /// Length of a tick in s.
    pub tick_s: f64,
    /// Counters of packets and messages.
    pub counters: Counters,
    /// Number of messages of the other side that had not arrived at the end.
    pub lost: u64,
    /// The delay of messages to this side in ticks, as in `channel.delays_file`.
    pub delay_ticks: Spread,
    /// The time from sending to arrival in s, by the clocks of both sides.
    pub one_way_s: Spread,
    /// The round-trip time in s.
    pub round_s: Spread,
    /// The accuracy of the clock agreement in s: half of the shortest round trip of the greeting.
    pub clock_s: f64,
    /// The lateness of the ticks.
    pub lateness: LatenessSummary,
    /// The priority from the scheduler.
    pub priority: String,
    /// The energies of both ports.
    pub meter: Meter,
    /// Times of ruptures in s, only on the slave's side.
    pub ruptures_s: Vec<f64>,
    /// Times of accepted alarms in s, only on the slave's side.
    pub alarms_s: Vec<f64>,
    /// Number of times that nothing came from the other side for three outages.
    pub silences: u64,
    /// Time of the other side's last message in s, if nothing has come since; `None` if it lives.
    pub silent_since_s: Option<f64>,
    /// Number of times that the other side was started anew and joined this side.
    pub restarts: u64,
    /// First tick with messages: above 0 if this side was started anew and joined the other side.
    pub first_tick: u64,
}

impl SideSummary {
    /// Returns the number of lost messages, and the distribution of the delays of all others in ticks.
    #[must_use]
    pub fn delays(delays: &[u32]) -> (u64, Spread) {
        let mut arrived: Vec<f64> =
            delays.iter().filter(|delay| **delay != Schedule::LOST).map(|delay| f64::from(*delay)).collect();
        ((delays.len() - arrived.len()) as u64, Spread::of(&mut arrived))
    }

    /// Returns the distributions of the one-way and the round-trip times in s.
    #[must_use]
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
