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

/// The distribution of some values; `None` without values.
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
    /// Of some values, which it reorders.
    #[must_use]
    pub fn of(values: &mut [f64]) -> Self {
        Self { median: quantile_of(values, 0.5), p99: quantile_of(values, 0.99), worst: quantile_of(values, 1.0) }
    }
}

/// The times of messages on their way, in s.
#[derive(Debug, Clone, Default)]
pub struct Trips {
    one_way_s: Vec<f64>,
    round_s: Vec<f64>,
}

impl Trips {
    /// An empty list with room for a number of messages.
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

/// What a side of a link tells at its end.
#[derive(Debug, Clone)]
pub struct SideSummary {
    /// The scenario's name.
    pub scenario: String,
    /// The side.
    pub role: Role,
    /// Ticks done, and ticks of the scenario.
    pub ticks: (u64, u64),
    /// Length of a tick in s.
    pub tick_s: f64,
    /// Numbers of packets.
    pub counters: Counters,
    /// Messages of the other side that had not arrived by the end.
    pub lost: u64,
    /// The delay of messages to this side, in ticks: what `channel.delays_file` has.
    pub delay_ticks: Spread,
    /// The time from sending to arrival in s, by the clocks of both sides.
    pub one_way_s: Spread,
    /// The time there and back in s.
    pub round_s: Spread,
    /// Half of the shortest round trip of the greeting in s: to this the clocks agree.
    pub clock_s: f64,
    /// How late the ticks were.
    pub lateness: LatenessSummary,
    /// What the scheduler gave.
    pub priority: String,
    /// The energies of both ports.
    pub meter: Meter,
    /// Times of ruptures in s; only the slave's side has them.
    pub ruptures_s: Vec<f64>,
    /// Times of alarms on which the supervisor acted, in s; only the slave's side has them.
    pub alarms_s: Vec<f64>,
    /// Messages that a proxy in this process has dropped: from the master, from the slave.
    pub proxy_lost: Option<[u64; 2]>,
}

impl SideSummary {
    /// Messages lost of the other side's ticks, and the spread of the delays in ticks of all others.
    #[must_use]
    pub fn delays(delays: &[u32]) -> (u64, Spread) {
        let mut arrived: Vec<f64> =
            delays.iter().filter(|delay| **delay != Schedule::LOST).map(|delay| f64::from(*delay)).collect();
        ((delays.len() - arrived.len()) as u64, Spread::of(&mut arrived))
    }

    /// The spreads of the times one way and there and back, in s.
    #[must_use]
    pub fn times(mut trips: Trips) -> (Spread, Spread) {
        (Spread::of(&mut trips.one_way_s), Spread::of(&mut trips.round_s))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_never_came_is_lost_and_not_late() {
        let (lost, spread) = SideSummary::delays(&[2, Schedule::LOST, 3, 2, Schedule::LOST]);
        assert_eq!((lost, spread.median, spread.worst), (2, Some(2.0), Some(3.0)));
        let nothing = SideSummary::delays(&[Schedule::LOST]);
        assert_eq!(nothing, (1, Spread::default()));
    }
}
