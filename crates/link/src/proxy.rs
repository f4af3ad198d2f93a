//! The scenario's channel between two real ends.

use std::collections::BTreeMap;

use super::packet::{Kind, PACKET_BYTES, Packet, Role};
use trocar_engine::channel::SampleDelays;
use trocar_scenario::Scenario;

/// The most packets on their way; further ones are lost.
const MAX_WAITING: usize = 100_000;

/// Delays and drops messages as the simulated channel of a scenario does: delay, jitter, loss, outages and logged delays,
/// with the same random numbers. Greetings pass at once.
#[derive(Debug)]
pub struct Proxy {
    tick_ns: f64,
    ticks: u64,
    delays: [SampleDelays; 2],
    /// By the time at which they are due in ns, and by their number.
    waiting: BTreeMap<(i64, u64), (Role, [u8; PACKET_BYTES])>,
    number: u64,
    lost: [u64; 2],
}

impl Proxy {
    /// The channel of a scenario.
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

    /// Takes a packet of a side at a time (ns).
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

    /// The delay of the message of a tick; `None` if it is lost, or if a later one has been seen.
    fn delay_ticks(&mut self, from: Role, tick: u64) -> Option<u64> {
        let delays = &mut self.delays[from as usize];
        while delays.tick() < tick {
            delays.next_ticks();
        }
        if delays.tick() == tick { delays.next_ticks() } else { None }
    }

    /// A packet that is due at a time (ns), and the side that it is for; the earliest first.
    pub fn next_due(&mut self, now_ns: i64) -> Option<(Role, [u8; PACKET_BYTES])> {
        let first = self.waiting.first_entry()?;
        (first.key().0 <= now_ns).then(|| first.remove())
    }

    /// The messages that it has dropped of each side: master, slave.
    #[must_use]
    pub fn lost(&self) -> [u64; 2] {
        self.lost
    }
}
