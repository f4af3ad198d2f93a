use std::net::{SocketAddr, UdpSocket};
use std::sync::atomic::{AtomicBool, Ordering};

use super::end::{End, either};
use super::pace::{Clock, send, take_all};
use super::peer::Peer;
use super::{MasterArgs, SideArgs, SlaveArgs, address, priority};
use crate::cli::error::Failure;
use crate::cli::{interrupt, terminal};
use trocar_document::{Study as _, TextFile, to_json};
use trocar_link::{
    Calling, Direction, Greeted, Key, Lateness, MasterEnd, Role, SideSummary, Silence, SlaveEnd, Trips, Waiting,
    delays_csv, fingerprint,
};
use trocar_report::{Destination, Folder, document_text, write_document};
use trocar_scenario::{Scenario, Source};
use trocar_studies::run::{RunError, trace_table};

/// Interval between packets of a greeting.
const GREETING_NS: i64 = 20_000_000;
/// The shortest round trip is used.
const REPLIES: u32 = 10;
/// Time from the last reply to tick 0, or to the first tick of a side that joins, in ns.
const LEAD_NS: i64 = 300_000_000;
const SECOND_NS: i64 = 1_000_000_000;

struct Side<'a> {
    args: &'a SideArgs,
    role: Role,
    key: Key,
    scenario: Scenario,
    socket: UdpSocket,
    clock: Clock,
    stop: &'static AtomicBool,
    folder: Folder,
}

pub(super) fn master(args: &MasterArgs) -> Result<(), Failure> {
    let scenario = load(&args.side)?;
    let slave = address::resolved(&args.to)?;
    let key = address::key(args.side.key_file.as_deref(), slave)?;
    if has_channel(&scenario) {
        return Err(Failure::input(
            "the delays, jitter, loss and outages of [channel] act in simulations only: set them to 0, and delay the \
             packets with tc netem",
        ));
    }
    // Refuse an invalid scenario before anything is sent.
    scenario.master_side()?;
    let any_port = match slave {
        SocketAddr::V4(_) if slave.ip().is_loopback() => "127.0.0.1:0",
        SocketAddr::V4(_) => "0.0.0.0:0",
        SocketAddr::V6(_) => "[::]:0",
    };
    let folder = folder(&args.side, &scenario, Role::Master)?;
    let socket = address::bound(address::resolved(any_port)?)?;
    let stop = interrupt::stop_flag();
    let side = Side { args: &args.side, role: Role::Master, key, scenario, socket, clock: Clock::new(), stop, folder };
    let greeted = side.call(slave, args)?;
    side.run(&greeted, slave)
}

pub(super) fn slave(args: &SlaveArgs) -> Result<(), Failure> {
    let scenario = load(&args.side)?;
    let listen = address::resolved(&args.listen)?;
    let key = address::key(args.side.key_file.as_deref(), listen)?;
    scenario.slave_side()?;
    let folder = folder(&args.side, &scenario, Role::Slave)?;
    let socket = address::bound(listen)?;
    let at = socket.local_addr().unwrap_or(listen);
    if !args.side.quiet {
        anstream::eprintln!("waiting for the master at {at}; Ctrl-C ends");
    }
    let side = Side {
        args: &args.side,
        role: Role::Slave,
        key,
        scenario,
        socket,
        clock: Clock::new(),
        stop: interrupt::stop_flag(),
        folder,
    };
    let (greeted, master) = side.wait()?;
    side.run(&greeted, master)
}

fn load(args: &SideArgs) -> Result<Scenario, Failure> {
    Ok(Scenario::load(&Source::parse(&args.scenario), &args.settings)?)
}

fn folder(args: &SideArgs, scenario: &Scenario, role: Role) -> Result<Folder, Failure> {
    let name = format!("{}/{}", scenario.name, role.word());
    Ok(Destination::new(&args.out).open("link", &name)?)
}

fn has_channel(scenario: &Scenario) -> bool {
    let delays = [scenario.forward, scenario.backward];
    delays.iter().any(|delay| delay.whole > 0 || delay.share > 0.0)
        || !scenario.irregularity.is_none()
        || !scenario.forward_schedule.is_empty()
        || !scenario.backward_schedule.is_empty()
}

pub(super) fn nonce() -> Result<[u8; 16], Failure> {
    let mut nonce = [0; 16];
    getrandom::fill(&mut nonce).map_err(|error| {
        Failure::input(format!("random numbers of the system: {error}: choose another address or port"))
    })?;
    Ok(nonce)
}

/// Tick 0, or a later one of a link that runs.
fn first_ns(start_ns: i64, now_ns: i64) -> i64 {
    if start_ns >= now_ns { start_ns } else { now_ns + LEAD_NS }
}

fn not_ready() -> Failure {
    Failure::work("the slave does not answer any more: start both sides again")
}

impl Side<'_> {
    fn call(&self, to: SocketAddr, args: &MasterArgs) -> Result<(Greeted, i64), Failure> {
        let mut calling = Calling::new(self.key.clone(), nonce()?, fingerprint(&self.scenario));
        let give_up_ns = self.clock.now_ns() + i64::from(args.wait_s) * SECOND_NS;
        while calling.replies() < REPLIES {
            let now_ns = self.clock.now_ns();
            if calling.differs() {
                return Err(Failure::work(
                    "the slave has another scenario, other settings or another version of trocar: give both sides the same",
                ));
            }
            if now_ns > give_up_ns {
                return Err(Failure::work(format!(
                    "no slave replied at {} within {} s: start it, with the same --key-file if there is one",
                    args.to, args.wait_s
                )));
            }
            self.check_interrupt()?;
            send(&self.socket, &calling.hello(now_ns), to);
            self.listen(now_ns + GREETING_NS, &mut calling);
        }
        let first_ns = self.clock.now_ns() + LEAD_NS;
        let start_ns = calling.begun_ns().unwrap_or(first_ns);
        while calling.greeted(start_ns).is_none() {
            let now_ns = self.clock.now_ns();
            if now_ns > first_ns - GREETING_NS {
                return Err(not_ready());
            }
            self.check_interrupt()?;
            if let Some(start) = calling.start(now_ns, start_ns) {
                send(&self.socket, &start, to);
            }
            self.listen(now_ns + GREETING_NS, &mut calling);
        }
        let greeted = calling.greeted(start_ns).ok_or_else(not_ready)?;
        Ok((greeted, first_ns))
    }

    fn listen(&self, until_ns: i64, calling: &mut Calling) {
        self.clock.wait_until(until_ns, || {
            take_all(&self.socket, |bytes, _| {
                calling.take(bytes, self.clock.now_ns());
            });
        });
    }

    /// Returns the result, the time of the first tick (ns) and the master's address.
    fn wait(&self) -> Result<((Greeted, i64), SocketAddr), Failure> {
        let mut waiting = Waiting::new(self.key.clone(), nonce()?, fingerprint(&self.scenario));
        let (mut begins, mut has_warned) = (None::<(i64, SocketAddr)>, false);
        loop {
            let now_ns = self.clock.now_ns();
            let until_ns = begins.map_or(now_ns + GREETING_NS, |(first_ns, _)| {
                // Answer repetitions of the start until shortly before the first tick.
                (first_ns - GREETING_NS).min(now_ns + GREETING_NS)
            });
            if let (Some(greeted), Some((first_ns, master))) = (waiting.greeted(), begins)
                && until_ns <= now_ns
            {
                return Ok(((greeted.clone(), first_ns), master));
            }
            self.check_interrupt()?;
            self.clock.wait_until(until_ns, || {
                take_all(&self.socket, |bytes, from| {
                    if let Some(answer) = waiting.take(bytes, self.clock.now_ns()) {
                        send(&self.socket, &answer, from);
                    }
                    if let Some(greeted) = waiting.greeted() {
                        // Replayed packets from elsewhere change nothing.
                        begins.get_or_insert_with(|| (first_ns(greeted.start_ns, self.clock.now_ns()), from));
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

    fn check_interrupt(&self) -> Result<(), Failure> {
        if self.stop.load(Ordering::Relaxed) {
            return Err(Failure::interrupted("nothing was written"));
        }
        Ok(())
    }

    fn run(self, begins: &(Greeted, i64), to: SocketAddr) -> Result<(), Failure> {
        let (greeted, first_ns) = begins;
        let mut end = End::new(self.role, &self.scenario, greeted)?;
        let grid = self.scenario.grid;
        let tick_ns = grid.tick_s() * 1e9;
        let failed = |source| RunError::Engine { name: self.scenario.name.clone(), source };
        let first_tick = ((first_ns - greeted.start_ns) as f64 / tick_ns).ceil() as u64;
        if first_tick >= grid.ticks() {
            let peer = self.role.other().word();
            return Err(Failure::work(format!(
                "the run of the {peer} ends too soon to join it: start both sides again"
            )));
        }
        either!(&mut end, one => one.skip_to(first_tick)).map_err(failed)?;
        // The slave's ticks are half a tick later, so that neither side races the other's packet.
        let offset_ns = if self.role == Role::Slave { 0.5 * tick_ns } else { 0.0 };
        let mut lateness = Lateness::new(grid.ticks());
        let priority = priority::ask(self.args.realtime);
        let clock = self.clock;
        let mut peer = Peer {
            socket: &self.socket,
            clock,
            key: &self.key,
            scenario: fingerprint(&self.scenario),
            recovery: self.scenario.link.recovery,
            role: self.role,
            start_ns: greeted.start_ns,
            to,
            trips: Trips::new(grid.ticks()),
            silence: Silence::new(&self.scenario, (1e9 * grid.time_s(first_tick)) as i64),
            rejoin: None,
            restarts: 0,
        };
        for tick in first_tick..grid.ticks() {
            if self.stop.load(Ordering::Relaxed) {
                break;
            }
            let due_ns = greeted.start_ns + (offset_ns + tick as f64 * tick_ns).round() as i64;
            let began_ns = clock.wait_until(due_ns, || peer.take(&mut end));
            lateness.add((began_ns - due_ns) as f64 * 1e-9);
            if let Some(packet) = end.send(peer.now_ns()) {
                peer.send(&packet);
            }
            peer.take(&mut end);
            peer.check()?;
            if let Some(packet) = end.step(peer.now_ns()).map_err(failed)? {
                peer.send(&packet);
            }
        }
        let outcome = peer.outcome(first_tick);
        let Peer { trips, silence, restarts, .. } = peer;
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
            restarts,
            first_tick,
        };
        self.write(&end, &summary)?;
        if self.stop.load(Ordering::Relaxed) {
            return Err(Failure::interrupted("the ticks so far were written"));
        }
        outcome
    }

    fn write(&self, end: &End, summary: &SideSummary) -> Result<(), Failure> {
        let (columns, direction) = match self.role {
            Role::Master => (MasterEnd::COLUMNS, Direction::Backward),
            Role::Slave => (SlaveEnd::COLUMNS, Direction::Forward),
        };
        // A replay needs the CSV format.
        let samples = self.args.format.with_csv().formats().to_vec();
        let trace = trace_table(either!(end, one => one.trace()), |name| columns.contains(&name));
        let mut document = summary.document();
        document.data.push(trace);
        let mut file = |name: &'static str, text: String| document.files.push(TextFile { name: name.into(), text });
        file("delays.csv", delays_csv(&[(direction, either!(end, one => one.delays()))], &self.scenario.grid));
        file("scenario.toml", self.scenario.echo());
        write_document(&self.folder.with_samples(samples), &document)?;
        self.folder.commit()?;
        if self.args.json {
            terminal::print(&to_json(&document.json))?;
        } else if !self.args.quiet {
            let files = self.folder.path.display();
            terminal::print(&format!("{}files: {files}\n", document_text(&document, false)))?;
        }
        Ok(())
    }
}
