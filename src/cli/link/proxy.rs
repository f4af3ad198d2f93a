//! Applies the channel of the scenario between two sides on this machine.

use std::net::{Ipv4Addr, SocketAddr, UdpSocket};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;

use super::address::bound;
use super::pace::{Clock, send, take_all};
use super::priority;
use crate::cli::error::LinkError;
use trocar_link::{Proxy, Role};
use trocar_scenario::Scenario;

/// Interval between checks of the sockets, in ns.
const LOOK_NS: i64 = 50_000;

pub(super) struct Running {
    /// The address to which the master sends.
    pub(super) address: SocketAddr,
    is_over: Arc<AtomicBool>,
    thread: JoinHandle<[u64; 2]>,
}

impl Running {
    /// Starts a proxy to a slave, with real-time priority if wanted.
    pub(super) fn start(scenario: &Scenario, slave: SocketAddr, is_realtime: bool) -> Result<Self, LinkError> {
        let here = SocketAddr::from((Ipv4Addr::LOCALHOST, 0));
        let (front, back) = (bound(here)?, bound(here)?);
        let address = front.local_addr().map_err(|source| LinkError::Bind { address: here.to_string(), source })?;
        let is_over = Arc::new(AtomicBool::new(false));
        let (proxy, flag) = (Proxy::new(scenario), is_over.clone());
        let thread = std::thread::spawn(move || {
            // The summary already reports the priority granted to the ticks, and this thread gets the same.
            let _ = priority::ask(is_realtime);
            forward(proxy, (&front, &back), slave, &flag)
        });
        Ok(Self { address, is_over, thread })
    }

    /// Ends the proxy. Returns the numbers of dropped messages of the master and of the slave.
    pub(super) fn end(self) -> Option<[u64; 2]> {
        self.is_over.store(true, Ordering::Relaxed);
        self.thread.join().ok()
    }
}

fn forward(
    mut proxy: Proxy,
    (front, back): (&UdpSocket, &UdpSocket),
    slave: SocketAddr,
    is_over: &AtomicBool,
) -> [u64; 2] {
    let clock = Clock::new();
    let mut master = None;
    while !is_over.load(Ordering::Relaxed) {
        let now_ns = clock.now_ns();
        take_all(front, |bytes, from| {
            master = Some(from);
            proxy.take(Role::Master, bytes, now_ns);
        });
        take_all(back, |bytes, _| proxy.take(Role::Slave, bytes, now_ns));
        while let Some((to, packet)) = proxy.next_due(now_ns) {
            match (to, master) {
                (Role::Slave, _) => send(back, &packet, slave),
                (Role::Master, Some(master)) => send(front, &packet, master),
                (Role::Master, None) => {}
            }
        }
        std::thread::sleep(std::time::Duration::from_nanos(LOOK_NS.unsigned_abs()));
    }
    proxy.lost()
}
