//! The scenario's channel between two real ends.

use super::packet::{Kind, PACKET_BYTES, Packet, Role};
use crate::channel::SampleDelays;
use crate::scenario::Scenario;

/// Delays and drops messages as the simulated channel of a scenario does: delay, jitter, loss, outages and logged delays,
/// with the same random numbers. Greetings pass at once.
#[derive(Debug)]
pub struct Proxy {
    tick_ns: f64,
    ticks: u64,
    delays: [SampleDelays; 2],
    waiting: Vec<Waiting>,
    lost: [u64; 2],
}

#[derive(Debug)]
struct Waiting {
    due_ns: i64,
    to: Role,
    packet: [u8; PACKET_BYTES],
}

impl Proxy {
    /// The channel of a scenario.
    #[must_use]
    pub fn new(scenario: &Scenario) -> Self {
        Self {
            tick_ns: scenario.grid.tick_s() * 1e9,
            ticks: scenario.grid.ticks(),
            delays: scenario.sample_delays(),
            waiting: vec![],
            lost: [0; 2],
        }
    }

    /// Takes a packet of a side at a time (ns).
    pub fn take(&mut self, from: Role, bytes: &[u8], now_ns: i64) {
        let Ok(packet) = <[u8; PACKET_BYTES]>::try_from(bytes) else { return };
        let delay_ns = match Packet::read(bytes) {
            Some(Packet { kind: Kind::Message, tick, .. }) if tick < self.ticks => {
                let Some(ticks) = self.delay_ticks(from, tick) else {
                    self.lost[from as usize] += 1;
                    return;
                };
                (ticks as f64 * self.tick_ns).round() as i64
            }
            _ => 0,
        };
        self.waiting.push(Waiting { due_ns: now_ns.saturating_add(delay_ns), to: from.other(), packet });
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
        let (place, first) = self.waiting.iter().enumerate().min_by_key(|(_, waiting)| waiting.due_ns)?;
        (first.due_ns <= now_ns).then(|| {
            let Waiting { to, packet, .. } = self.waiting.remove(place);
            (to, packet)
        })
    }

    /// The messages that it has dropped of each side: master, slave.
    #[must_use]
    pub fn lost(&self) -> [u64; 2] {
        self.lost
    }
}
