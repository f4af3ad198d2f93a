//! The other side: its packets, its silence, and a process that takes its place.

use std::net::{SocketAddr, UdpSocket};

use super::end::{End, either};
use super::pace::{Clock, send, take_all};
use super::side::nonce;
use crate::cli::error::Failure;
use trocar_document::counted;
use trocar_engine::teleoperation::RecoverySettings;
use trocar_link::{Heard, Key, Rejoin, Role, Silence, SilenceChange, Trips};

pub(super) struct Peer<'a> {
    pub(super) socket: &'a UdpSocket,
    pub(super) clock: Clock,
    pub(super) key: &'a Key,
    pub(super) scenario: [u8; 32],
    pub(super) recovery: RecoverySettings,
    pub(super) role: Role,
    /// Tick 0 by this side's clock, in ns.
    pub(super) start_ns: i64,
    pub(super) to: SocketAddr,
    pub(super) trips: Trips,
    pub(super) silence: Silence,
    /// The greeting with a new process, while the other side is silent.
    pub(super) rejoin: Option<Rejoin>,
    /// New processes that have joined.
    pub(super) restarts: u64,
}

impl Peer<'_> {
    pub(super) fn now_ns(&self) -> i64 {
        self.clock.now_ns() - self.start_ns
    }

    pub(super) fn send(&self, packet: &[u8]) {
        send(self.socket, packet, self.to);
    }

    pub(super) fn take(&mut self, end: &mut End) {
        take_all(self.socket, |bytes, from| self.take_one(end, bytes, from));
    }

    fn take_one(&mut self, end: &mut End, bytes: &[u8], from: SocketAddr) {
        let now_ns = self.clock.now_ns();
        let heard = self.rejoin.as_mut().map_or_else(Heard::default, |rejoin| rejoin.take(bytes, now_ns));
        if let Some(answer) = heard.answer {
            send(self.socket, &answer, from);
        }
        if let Some(session) = heard.session {
            either!(end, one => one.rejoin(session));
            self.to = from;
        }
        if heard.is_known {
            return;
        }
        let now_ns = now_ns - self.start_ns;
        if let Some(trip) = either!(end, one => one.take(bytes, now_ns)) {
            self.trips.add(&trip);
            if let Some(SilenceChange::Back(after_s)) = self.silence.hear(now_ns) {
                self.is_back(after_s);
            }
        }
    }

    fn is_back(&mut self, after_s: f64) {
        let peer = self.role.other().word();
        if self.rejoin.take().is_some_and(|rejoin| rejoin.has_agreed()) {
            self.restarts += 1;
            anstream::eprintln!("a new process of the {peer} has joined after {after_s:.3} s");
        } else {
            anstream::eprintln!("the {peer} is back after {after_s:.3} s");
        }
    }

    /// Notices a silence, and looks for a new process while it lasts.
    pub(super) fn check(&mut self) -> Result<(), Failure> {
        let now_ns = self.clock.now_ns();
        if let Some(SilenceChange::Silent(for_s)) = self.silence.check(now_ns - self.start_ns) {
            self.report(for_s);
            self.greet()?;
        }
        if self.rejoin.as_ref().is_some_and(|rejoin| rejoin.is_overdue(now_ns)) {
            self.greet()?;
        }
        if let Some(packet) = self.rejoin.as_mut().and_then(|rejoin| rejoin.call(now_ns)) {
            self.send(&packet);
        }
        Ok(())
    }

    fn greet(&mut self) -> Result<(), Failure> {
        self.rejoin = Some(Rejoin::new(self.role, self.key.clone(), nonce()?, self.scenario, self.start_ns));
        Ok(())
    }

    fn report(&self, for_s: f64) {
        let peer = self.role.other().word();
        match self.role {
            Role::Master => anstream::eprintln!(
                "warning: nothing has come from the {peer} for {for_s:.3} s: the force decays to 0 from {} s on",
                self.recovery.dead_s
            ),
            Role::Slave => {
                anstream::eprintln!("warning: nothing has come from the {peer} for {for_s:.3} s: the reference holds")
            }
        }
    }

    /// Returns the error of a link that was not whole: the other side is silent at the end, or was started anew, or
    /// this side has joined at a later tick than 0.
    pub(super) fn outcome(&self, first_tick: u64) -> Result<(), Failure> {
        let peer = self.role.other().word();
        let problem = match (self.silence.since_ns(), self.restarts, first_tick) {
            (Some(since_ns), _, _) => {
                let since_s = 1e-9 * since_ns as f64;
                format!("nothing has come from the {peer} since {since_s:.3} s of the run: start both sides again")
            }
            (None, 0, 0) => return Ok(()),
            (None, 0, tick) => {
                format!("joined the {peer} at tick {tick} of its run: the ticks before had no messages")
            }
            (None, restarts, _) => {
                let times = counted(restarts, "time");
                format!("the {peer} was started anew during the run, {times}: its first process has ended early")
            }
        };
        Err(Failure::work(problem))
    }
}
