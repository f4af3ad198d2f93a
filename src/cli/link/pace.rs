use std::net::{SocketAddr, UdpSocket};
use std::time::{Duration, Instant};

use trocar_link::PACKET_BYTES;

/// The last part of a wait before a tick is a busy wait, because a sleep overruns by about half of this time.
const SPIN_NS: i64 = 120_000;
/// The longest sleep, so that arrivals get accurate time stamps.
const NAP_NS: i64 = 200_000;
/// Packets taken at once, so that a flood cannot stop the ticks.
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

    /// Waits until a time (ns) and calls `meanwhile` often. Returns the current time.
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

/// A longer packet is truncated to one byte above the valid length, so that it is rejected.
pub(super) fn take_all(socket: &UdpSocket, mut take: impl FnMut(&[u8], SocketAddr)) {
    let mut bytes = [0; PACKET_BYTES + 1];
    for _ in 0..MAX_AT_ONCE {
        // Treats an error of an earlier packet as a lost packet.
        let Ok((length, from)) = socket.recv_from(&mut bytes) else { return };
        take(&bytes[..length], from);
    }
}

/// A packet that cannot be sent counts as lost.
pub(super) fn send(socket: &UdpSocket, packet: &[u8], to: SocketAddr) {
    let _ = socket.send_to(packet, to);
}
