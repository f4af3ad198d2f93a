//! One side of a link, in real time.

use std::net::{SocketAddr, UdpSocket};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};

use super::pace::{Clock, send, take_all};
use super::pointer::Pointer;
use super::proxy::Running;
use super::{MasterArgs, SideArgs, SlaveArgs, address, priority};
use crate::cli::error::{CliError, LinkError};
use crate::cli::{interrupt, terminal};
use trocar_document::{Study as _, TextFile, to_json};
use trocar_engine::engine::EngineError;
use trocar_link::{
    Calling, Direction, Greeted, Key, Lateness, MasterEnd, PACKET_BYTES, Role, SideSummary, Silence, SilenceChange,
    SlaveEnd, Trips, Waiting, delays_csv, fingerprint,
};
use trocar_report::{Folder, document_text, write_document};
use trocar_scenario::{Scenario, Source};
use trocar_studies::run::{RunError, trace_table};

/// Interval between packets of a greeting, in ns.
const GREETING_NS: i64 = 20_000_000;
/// Number of replies; the shortest round trip among them is used.
const REPLIES: u32 = 10;
/// Time from the last reply to tick 0, in ns.
const LEAD_NS: i64 = 300_000_000;
const SECOND_NS: i64 = 1_000_000_000;

/// The end of the link on either side.
enum End {
    Master(Box<MasterEnd>),
    Slave(Box<SlaveEnd>),
}

macro_rules! either {
    ($end:expr, $one:ident => $result:expr) => {
        match $end {
            End::Master($one) => $result,
            End::Slave($one) => $result,
        }
    };
}

impl End {
    fn new(role: Role, scenario: &Scenario, greeted: &Greeted) -> Result<Self, CliError> {
        let session = greeted.session.clone();
        Ok(match role {
            Role::Master => Self::Master(Box::new(MasterEnd::new(scenario, session)?)),
            Role::Slave => Self::Slave(Box::new(SlaveEnd::new(scenario, session)?)),
        })
    }

    /// Returns the packet for the beginning of a tick, from the side that sends before it receives.
    fn send(&mut self, now_ns: i64) -> Option<[u8; PACKET_BYTES]> {
        match self {
            Self::Master(end) => Some(end.send(now_ns)),
            Self::Slave(_) => None,
        }
    }

    /// Computes the rest of a tick. Returns the packet of the side that sends after it has received.
    fn step(&mut self, now_ns: i64) -> Result<Option<[u8; PACKET_BYTES]>, EngineError> {
        match self {
            Self::Master(end) => end.step().map(|()| None),
            Self::Slave(end) => end.step(now_ns).map(Some),
        }
    }
}

struct Side<'a> {
    args: &'a SideArgs,
    role: Role,
    scenario: Scenario,
    socket: UdpSocket,
    clock: Clock,
    stop: &'static AtomicBool,
    /// The operator at the page, if the pointer leads the master.
    pointer: Option<Pointer>,
}

pub(super) fn master(args: &MasterArgs) -> Result<(), CliError> {
    let scenario = load(&args.side)?;
    let slave = address::resolved(&args.to)?;
    let key = address::key(args.side.key_file.as_deref(), slave)?;
    if args.proxy && !slave.ip().is_loopback() {
        return Err(LinkError::ProxyElsewhere { address: args.to.clone() }.into());
    }
    if !args.proxy && has_channel(&scenario) {
        return Err(LinkError::ChannelWithoutProxy.into());
    }
    // Refuse an invalid scenario before anything is sent.
    scenario.master_side()?;
    let any_port = match slave {
        SocketAddr::V4(_) if slave.ip().is_loopback() => "127.0.0.1:0",
        SocketAddr::V4(_) => "0.0.0.0:0",
        SocketAddr::V6(_) => "[::]:0",
    };
    let socket = address::bound(address::resolved(any_port)?)?;
    let stop = interrupt::stop_flag();
    let pointer = if args.pointer { Some(Pointer::open(&scenario, args)?) } else { None };
    if let Some(pointer) = &pointer {
        pointer.wait(stop)?;
    }
    let proxy = if args.proxy { Some(Running::start(&scenario, slave, args.side.realtime)?) } else { None };
    let to = proxy.as_ref().map_or(slave, |proxy| proxy.address);
    let side = Side { args: &args.side, role: Role::Master, scenario, socket, clock: Clock::new(), stop, pointer };
    let greeted = side.call(key, to, args)?;
    side.run(&greeted, to, proxy)
}

pub(super) fn slave(args: &SlaveArgs) -> Result<(), CliError> {
    let scenario = load(&args.side)?;
    let listen = address::resolved(&args.listen)?;
    let key = address::key(args.side.key_file.as_deref(), listen)?;
    scenario.slave_side()?;
    let socket = address::bound(listen)?;
    let at = socket.local_addr().unwrap_or(listen);
    if !args.side.quiet {
        anstream::eprintln!("waiting for the master at {at}; Ctrl-C ends");
    }
    let side = Side {
        args: &args.side,
        role: Role::Slave,
        scenario,
        socket,
        clock: Clock::new(),
        stop: interrupt::stop_flag(),
        pointer: None,
    };
    let (greeted, master) = side.wait(key)?;
    side.run(&greeted, master, None)
}

fn load(args: &SideArgs) -> Result<Scenario, CliError> {
    Ok(Scenario::load(&Source::parse(&args.scenario), &args.settings)?)
}

/// Returns true if the channel of a scenario has any effect.
fn has_channel(scenario: &Scenario) -> bool {
    let delays = [scenario.forward, scenario.backward];
    delays.iter().any(|delay| delay.whole > 0 || delay.share > 0.0)
        || !scenario.irregularity.is_none()
        || !scenario.forward_schedule.is_empty()
        || !scenario.backward_schedule.is_empty()
}

fn nonce() -> Result<[u8; 16], LinkError> {
    let mut nonce = [0; 16];
    getrandom::fill(&mut nonce).map_err(|error| LinkError::Bind {
        address: "random numbers of the system".into(),
        source: std::io::Error::other(error.to_string()),
    })?;
    Ok(nonce)
}

fn interrupted() -> CliError {
    CliError::Interrupted { kept: None }
}

impl Side<'_> {
    fn call(&self, key: Key, to: SocketAddr, args: &MasterArgs) -> Result<Greeted, CliError> {
        let mut calling = Calling::new(key, nonce()?, fingerprint(&self.scenario));
        let give_up_ns = self.clock.now_ns() + i64::from(args.wait_s) * SECOND_NS;
        while calling.replies() < REPLIES {
            let now_ns = self.clock.now_ns();
            if calling.differs() {
                return Err(LinkError::Differs.into());
            }
            if now_ns > give_up_ns {
                return Err(LinkError::NoReply { address: args.to.clone(), wait_s: args.wait_s }.into());
            }
            self.check_interrupt()?;
            send(&self.socket, &calling.hello(now_ns), to);
            self.listen(now_ns + GREETING_NS, &mut calling);
        }
        let start_ns = self.clock.now_ns() + LEAD_NS;
        while calling.greeted(start_ns).is_none() {
            let now_ns = self.clock.now_ns();
            if now_ns > start_ns - GREETING_NS {
                return Err(LinkError::NotReady.into());
            }
            self.check_interrupt()?;
            if let Some(start) = calling.start(now_ns, start_ns) {
                send(&self.socket, &start, to);
            }
            self.listen(now_ns + GREETING_NS, &mut calling);
        }
        calling.greeted(start_ns).ok_or_else(|| LinkError::NotReady.into())
    }

    fn listen(&self, until_ns: i64, calling: &mut Calling) {
        self.clock.wait_until(until_ns, || {
            take_all(&self.socket, |bytes, _| calling.take(bytes, self.clock.now_ns()));
        });
    }

    /// Performs the slave's greeting. Returns its result and the master's address.
    fn wait(&self, key: Key) -> Result<(Greeted, SocketAddr), CliError> {
        let mut waiting = Waiting::new(key, nonce()?, fingerprint(&self.scenario));
        let (mut master, mut has_warned) = (None, false);
        loop {
            let now_ns = self.clock.now_ns();
            let until_ns = waiting.greeted().map_or(now_ns + GREETING_NS, |greeted| {
                // Answer repetitions of the start until shortly before tick 0.
                (greeted.start_ns - GREETING_NS).min(now_ns + GREETING_NS)
            });
            if let (Some(greeted), Some(master)) = (waiting.greeted(), master)
                && until_ns <= now_ns
            {
                return Ok((greeted.clone(), master));
            }
            self.check_interrupt()?;
            self.clock.wait_until(until_ns, || {
                take_all(&self.socket, |bytes, from| {
                    if let Some(answer) = waiting.take(bytes, self.clock.now_ns()) {
                        send(&self.socket, &answer, from);
                    }
                    if waiting.greeted().is_some() {
                        // Keep the address that began the session, so that replayed packets from elsewhere change
                        // nothing.
                        master.get_or_insert(from);
                    }
                });
            });
            if waiting.differs() && !has_warned {
                has_warned = true;
                anstream::eprintln!(
                    "warning: a master with another scenario, other settings or another version of trocar has called"
                );
            }
        }
    }

    fn check_interrupt(&self) -> Result<(), CliError> {
        if self.stop.load(Ordering::Relaxed) { Err(interrupted()) } else { Ok(()) }
    }

    fn run(mut self, greeted: &Greeted, to: SocketAddr, proxy: Option<Running>) -> Result<(), CliError> {
        let led = self.pointer.as_ref().map(|pointer| pointer.lead(&self.scenario));
        let mut end = End::new(self.role, led.as_ref().unwrap_or(&self.scenario), greeted)?;
        let grid = self.scenario.grid;
        let tick_ns = grid.tick_s() * 1e9;
        // The slave's ticks are half a tick later, so that neither side races the other's packet.
        let offset_ns = if self.role == Role::Slave { 0.5 * tick_ns } else { 0.0 };
        let mut lateness = Lateness::new(grid.ticks());
        let mut trips = Trips::new(grid.ticks());
        let mut silence = Silence::new(&self.scenario, 0);
        let priority = priority::ask(self.args.realtime);
        let (clock, socket) = (self.clock, &self.socket);
        for tick in 0..grid.ticks() {
            if self.has_stopped() {
                break;
            }
            let mut take = |end: &mut End| {
                take_all(socket, |bytes, _| {
                    let now_ns = clock.now_ns() - greeted.start_ns;
                    if let Some(trip) = either!(end, one => one.take(bytes, now_ns)) {
                        trips.add(&trip);
                        self.report(silence.hear(now_ns));
                    }
                });
            };
            let due_ns = greeted.start_ns + (offset_ns + tick as f64 * tick_ns).round() as i64;
            let began_ns = clock.wait_until(due_ns, || take(&mut end));
            lateness.add((began_ns - due_ns) as f64 * 1e-9);
            if let Some(packet) = end.send(clock.now_ns() - greeted.start_ns) {
                send(socket, &packet, to);
            }
            take(&mut end);
            self.report(silence.check(clock.now_ns() - greeted.start_ns));
            if let Some(pointer) = &self.pointer {
                pointer.step();
            }
            let stepped = end.step(clock.now_ns() - greeted.start_ns);
            let stepped = stepped.map_err(|source| RunError::Engine { name: self.scenario.name.clone(), source });
            if let Some(packet) = stepped? {
                send(socket, &packet, to);
            }
            if let (Some(pointer), End::Master(end)) = (&mut self.pointer, &end) {
                pointer.show(end);
            }
        }
        let (one_way_s, round_s) = SideSummary::times(trips);
        let (lost, delay_ticks) = SideSummary::delays(either!(&end, one => one.delays()));
        let times_s = |ticks: &[u64]| ticks.iter().map(|tick| grid.time_s(*tick)).collect();
        let (ruptures_s, alarms_s) = match &end {
            End::Master(_) => (vec![], vec![]),
            End::Slave(end) => (times_s(end.ruptures()), times_s(end.alarms())),
        };
        let summary = SideSummary {
            scenario: self.scenario.name.clone(),
            role: self.role,
            ticks: (either!(&end, one => one.tick()), grid.ticks()),
            tick_s: grid.tick_s(),
            counters: either!(&end, one => one.counters()),
            lost,
            delay_ticks,
            one_way_s,
            round_s,
            clock_s: 0.5e-9 * greeted.round_ns as f64,
            lateness: lateness.summary(grid.tick_s()),
            priority,
            meter: either!(&end, one => one.meter()),
            ruptures_s,
            alarms_s,
            silences: silence.count(),
            silent_since_s: silence.since_ns().map(|ns| 1e-9 * ns as f64),
            proxy_lost: proxy.and_then(Running::end),
        };
        let files = self.write(&end, &summary)?;
        if let Some(pointer) = &self.pointer {
            pointer.end(&summary, &files);
        }
        if self.stop.load(Ordering::Relaxed) {
            return Err(CliError::Interrupted { kept: Some("the ticks so far were written".into()) });
        }
        match summary.silent_since_s {
            Some(since_s) => Err(LinkError::PeerLost { peer: self.role.other().word(), since_s }.into()),
            None => Ok(()),
        }
    }

    /// Prints that the other side is silent, and that it is back.
    fn report(&self, change: Option<SilenceChange>) {
        let peer = self.role.other().word();
        let recovery = &self.scenario.link.recovery;
        match (change, self.role) {
            (None, _) => {}
            (Some(SilenceChange::Silent(for_s)), Role::Master) => anstream::eprintln!(
                "warning: nothing has come from the {peer} for {for_s:.3} s: the force decays to 0 from {} s on",
                recovery.dead_s
            ),
            (Some(SilenceChange::Silent(for_s)), Role::Slave) => {
                anstream::eprintln!("warning: nothing has come from the {peer} for {for_s:.3} s: the reference holds")
            }
            (Some(SilenceChange::Back(after_s)), _) => anstream::eprintln!("the {peer} is back after {after_s:.3} s"),
        }
    }

    /// Returns true if Ctrl-C or the operator at the page has ended the link.
    fn has_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed) || self.pointer.as_ref().is_some_and(Pointer::has_ended)
    }

    fn write(&self, end: &End, summary: &SideSummary) -> Result<PathBuf, CliError> {
        let folder = Folder::new(&self.args.out).folder(&self.scenario.name).folder(self.role.word());
        let (columns, direction) = match self.role {
            Role::Master => (MasterEnd::COLUMNS, Direction::Backward),
            Role::Slave => (SlaveEnd::COLUMNS, Direction::Forward),
        };
        // A replay needs the CSV format.
        let samples = self.args.format.with_csv().formats().to_vec();
        let trace = trace_table(either!(end, one => one.trace()), |name| columns.contains(&name));
        let mut document = summary.document();
        document.data.push(trace.topic(self.role.word()));
        let mut file = |name: &'static str, text: String| document.files.push(TextFile { name: name.into(), text });
        file("delays.csv", delays_csv(&[(direction, either!(end, one => one.delays()))], &self.scenario.grid));
        match &self.pointer {
            None => file("scenario.toml", self.scenario.echo()),
            Some(_) => {
                file("link.toml", self.scenario.echo());
                file("scenario.toml", Pointer::logged(&self.scenario.name));
            }
        }
        write_document(&Folder { samples, ..folder.clone() }, &document)?;
        let files = folder.path;
        if self.args.json {
            terminal::print(&to_json(&document.json))?;
        } else if !self.args.quiet {
            terminal::print(&format!("{}files: {}\n", document_text(&document, false), files.display()))?;
        }
        Ok(files)
    }
}
