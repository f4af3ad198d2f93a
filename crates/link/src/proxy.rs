//! The scenario's channel between two real ends.

use std::collections::BTreeMap;

use super::packet::{Kind, PACKET_BYTES, Packet, Role};
use trocar_engine::channel::SampleDelays;
use trocar_scenario::Scenario;

/// Maximum number of packets on the way; further packets are lost.
const MAX_WAITING: usize = 100_000;

/// Delays and drops messages like the simulated channel of a scenario (delay, jitter, loss, outages and logged delays),
/// with the same random numbers. Greetings pass immediately.
#[derive(Debug)]
pub struct Proxy {
    tick_ns: f64,
    ticks: u64,
    delays: [SampleDelays; 2],
    /// Packets by due time in ns and number.
    waiting: BTreeMap<(i64, u64), (Role, [u8; PACKET_BYTES])>,
    number: u64,
    lost: [u64; 2],
}

impl Proxy {
    /// Creates the channel of a scenario.
    #[must_use]
    pub fn new(scenario: &Scenario) -> Self {
        Self {
            tick_ns: scenario.grid.tick_s() * 1e9,
            ticks: scenario.grid.ticks(),
            delays: scenario.sample_delays(),
            waiting: BTreeMap::new(),
            number: 0,
            lost: [0; 2],
        }
    }

    /// Receives a packet of a side at a time (ns).
    pub fn take(&mut self, from: Role, bytes: &[u8], now_ns: i64) {
        let Ok(packet) = <[u8; PACKET_BYTES]>::try_from(bytes) else { return };
        let delay_ticks = match Packet::read(bytes) {
            Some(Packet { kind: Kind::Message, tick, .. }) if tick < self.ticks => self.delay_ticks(from, tick),
            _ => Some(0),
        };
        match delay_ticks.filter(|_| self.waiting.len() < MAX_WAITING) {
            None => self.lost[from as usize] += 1,
            Some(ticks) => {
                let due_ns = now_ns.saturating_add((ticks as f64 * self.tick_ns).round() as i64);
                self.waiting.insert((due_ns, self.number), (from.other(), packet));
                self.number += 1;
            }
        }
    }

    /// Returns the delay of a tick's message; `None` if it is lost, or if a later message has passed.
    fn delay_ticks(&mut self, from: Role, tick: u64) -> Option<u64> {
        let delays = &mut self.delays[from as usize];
        while delays.tick() < tick {
            delays.next_ticks();
        }
        if delays.tick() == tick { delays.next_ticks() } else { None }
    }

    /// Returns the earliest packet that is due at a time (ns), and its destination.
    pub fn next_due(&mut self, now_ns: i64) -> Option<(Role, [u8; PACKET_BYTES])> {
        let first = self.waiting.first_entry()?;
        (first.key().0 <= now_ns).then(|| first.remove())
    }

    /// Returns the number of dropped messages of master and slave.
    #[must_use]
    pub fn lost(&self) -> [u64; 2] {
        self.lost
    }
}
