//! The clock of a side, and its waiting.

use std::net::{SocketAddr, UdpSocket};
use std::time::{Duration, Instant};

use trocar_link::PACKET_BYTES;

/// Before a tick, the last part of the waiting keeps the processor: a sleep ends too late by about half of this.
const SPIN_NS: i64 = 120_000;
/// The longest sleep, so that arrivals get their time.
const NAP_NS: i64 = 200_000;
/// The most packets taken at once: a flood of packets cannot stop the ticks.
const MAX_AT_ONCE: usize = 64;

/// A clock in ns.
#[derive(Debug, Clone, Copy)]
pub(super) struct Clock(Instant);

impl Clock {
    pub(super) fn new() -> Self {
        Self(Instant::now())
    }

    pub(super) fn now_ns(self) -> i64 {
        i64::try_from(self.0.elapsed().as_nanos()).unwrap_or(i64::MAX)
    }

    /// Waits until a time (ns), and calls `meanwhile` often. Returns the time.
    pub(super) fn wait_until(self, due_ns: i64, mut meanwhile: impl FnMut()) -> i64 {
        loop {
            meanwhile();
            let now_ns = self.now_ns();
            let left_ns = due_ns - now_ns;
            if left_ns <= 0 {
                return now_ns;
            }
            if left_ns > SPIN_NS {
                std::thread::sleep(Duration::from_nanos((left_ns - SPIN_NS).min(NAP_NS).unsigned_abs()));
            } else {
                std::hint::spin_loop();
            }
        }
    }
}

/// Takes the packets that have come. A longer one is cut, and so of another length than a packet.
pub(super) fn take_all(socket: &UdpSocket, mut take: impl FnMut(&[u8], SocketAddr)) {
    let mut bytes = [0; PACKET_BYTES + 1];
    for _ in 0..MAX_AT_ONCE {
        // An error of an earlier packet is that of a network that loses packets.
        let Ok((length, from)) = socket.recv_from(&mut bytes) else { return };
        take(&bytes[..length], from);
    }
}

/// Sends a packet. One that cannot be sent is lost, as on its way.
pub(super) fn send(socket: &UdpSocket, packet: &[u8], to: SocketAddr) {
    let _ = socket.send_to(packet, to);
}
