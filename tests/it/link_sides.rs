//! The two sides as two processes. In virtual time they give the signals of a run bit for bit; in real time on this
//! machine, their logs reproduce their signals.

use std::collections::BTreeMap;
use std::process::{Child, Command, Stdio};

use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

use crate::support::test_folder::TestFolder;
use trocar::channel::{Delay, Schedule};
use trocar::run::{run, trace_table};
use trocar::scenario::{Scenario, Source};
use trocar_link::{Calling, Greeted, Key, MasterEnd, PACKET_BYTES, SlaveEnd, Waiting, fingerprint, first_difference};
use trocar_report::ColumnFormat;

/// Layers, a reacting hand, noise and augmentation. The rupture is detected within the simulated time.
const BASE: &str = "name = \"x\"\nbase = \"builtin:layers/skin-augmented\"\n\
    [operator]\ntremor_amplitude_m = 1e-4\n[perception]\nreflex = \"withdraw\"\n[simulation]\nduration_s = 2.5\n";

fn scenario(more: &str) -> Scenario {
    let text = format!("{BASE}{more}");
    Scenario::load(&Source::Text { name: "x".into(), text: text.into() }, &[]).expect("loads")
}

fn greeted(scenario: &Scenario, key: &Key) -> (Greeted, Greeted) {
    let scenario = fingerprint(scenario);
    let (mut master, mut slave) =
        (Calling::new(key.clone(), [1; 16], scenario), Waiting::new(key.clone(), [2; 16], scenario));
    master.take(&slave.take(&master.hello(0), 0).expect("a reply"), 0);
    master.take(&slave.take(&master.start(0, 0).expect("a slave"), 0).expect("ready"), 0);
    (master.greeted(0).expect("ready"), slave.greeted().expect("started").clone())
}

/// For each message of a direction, the number of ticks after which it arrives.
type Delays = Vec<Option<u64>>;

/// Returns the delays, forward and backward, of the samples that the scenario's channel uses in a simulation. A sample
/// that arrives after a later one counts as lost.
fn of_channel(scenario: &Scenario) -> [Delays; 2] {
    // The random streams of the two directions.
    let [forward, backward] = [*b"\0forward", *b"backward"].map(u64::from_be_bytes);
    let directions = [
        (scenario.forward.whole, &scenario.forward_schedule, forward),
        (scenario.backward.whole, &scenario.backward_schedule, backward),
    ];
    directions.map(|(ticks, schedule, stream)| {
        let (tick_s, random) = (scenario.grid.tick_s(), (scenario.seed ^ stream, 0));
        let line = Delay::new(ticks, [-1.0]);
        let mut line = line.irregular(&scenario.irregularity, schedule, tick_s, [-1.0], random);
        let mut delays = vec![None; scenario.grid.ticks() as usize];
        for now in 0..scenario.grid.ticks() {
            let [sent] = line.exchange([now as f64]).sample;
            if sent >= 0.0 {
                delays[sent as usize].get_or_insert(now - sent as u64);
            }
        }
        delays
    })
}

/// Runs both ends in virtual time, with these delays between them. `disturb` sees each packet in transit.
fn in_virtual_time(
    scenario: &Scenario,
    key: &Key,
    [forward, backward]: &[Delays; 2],
    mut disturb: impl FnMut(u64, &[u8; PACKET_BYTES], &mut MasterEnd, &mut SlaveEnd),
) -> (MasterEnd, SlaveEnd) {
    let (of_master, of_slave) = greeted(scenario, key);
    let mut master = MasterEnd::new(scenario, of_master.session).expect("builds");
    let mut slave = SlaveEnd::new(scenario, of_slave.session).expect("builds");
    // The packets in transit to the slave and to the master, by the tick of their arrival and of their sending.
    let (mut to_slave, mut to_master) = (BTreeMap::new(), BTreeMap::new());
    for tick in 0..scenario.grid.ticks() {
        let now_ns = (tick as f64 * scenario.grid.tick_s() * 1e9).round() as i64;
        let packet = master.send(now_ns);
        if let Some(delay) = forward[tick as usize] {
            to_slave.insert((tick + delay, tick), packet);
        }
        while let Some(packet) = next_due(&mut to_slave, tick) {
            disturb(tick, &packet, &mut master, &mut slave);
            slave.take(&packet, now_ns);
        }
        let packet = slave.step(now_ns).expect("steps");
        if let Some(delay) = backward[tick as usize] {
            to_master.insert((tick + delay, tick), packet);
        }
        while let Some(packet) = next_due(&mut to_master, tick) {
            disturb(tick, &packet, &mut master, &mut slave);
            master.take(&packet, now_ns);
        }
        master.step().expect("steps");
    }
    assert!(master.has_ended() && slave.has_ended());
    (master, slave)
}

fn next_due(waiting: &mut BTreeMap<(u64, u64), [u8; PACKET_BYTES]>, tick: u64) -> Option<[u8; PACKET_BYTES]> {
    let first = waiting.first_entry()?;
    (first.key().0 <= tick).then(|| first.remove())
}

fn assert_is_run(scenario: &Scenario, (master, slave): &(MasterEnd, SlaveEnd)) {
    let trace = run(scenario.clone()).expect("runs").trace;
    let both = [(MasterEnd::COLUMNS, master.trace()), (SlaveEnd::COLUMNS, slave.trace())];
    for (columns, of_side) in both {
        let mut log = vec![];
        let table = trace_table(of_side, |name| columns.contains(&name));
        ColumnFormat::Csv.write(&table, &mut log).expect("written");
        let log = String::from_utf8(log).expect("text");
        let compared = first_difference("log", &log, &trace).expect("a log");
        assert_eq!(compared, (scenario.grid.ticks(), None), "{}", scenario.echo());
    }
}

const CHANNEL: &str =
    "[channel]\ndelay_s = 0.02\njitter_s = 0.005\nloss = 0.05\noutages_s = [1.0, 1.2]\noutage_s = 0.05\n";

#[test]
fn both_ends_give_the_signals_of_a_run_for_every_scheme_and_architecture() {
    let kinds = ["position-force", "local-force", "position-position", "four-channel"];
    for scheme in ["none", "time-domain", "wave-variables", "energy-tank"] {
        for kind in kinds {
            if scheme == "wave-variables" && kinds[2..].contains(&kind) {
                continue;
            }
            let parts = format!("{CHANNEL}[passivity]\nscheme = \"{scheme}\"\n[controller]\nkind = \"{kind}\"\n");
            let scenario = scenario(&parts);
            let ends = in_virtual_time(&scenario, &Key::of_loopback(), &of_channel(&scenario), |_, _, _, _| ());
            assert_is_run(&scenario, &ends);
            let (master, slave) = ends;
            // The meter gets the energies as they arrive; the promise also holds for these.
            for meter in [master.meter(), slave.meter()] {
                assert!(meter.promised_j.is_none_or(|promised_j| meter.generated_j <= promised_j), "{scheme} {kind}");
            }
            assert_eq!(master.meter().promised_j.is_some(), scheme != "none");
        }
    }
}

#[test]
fn both_ends_give_the_signals_of_a_run_for_other_links_and_machines() {
    for parts in [
        "[channel]\ndelay_s = 0.0\nloss = 1e-3\n",
        // An outage from the start; each recovery.
        "[channel]\ndelay_s = 0.01\noutages_s = [0.0, 0.3, 1.5, 1.8]\nrecovery = \"hold\"\n",
        "[channel]\ndelay_s = 0.3\njitter_s = 0.1\noutages_s = [1.5, 2.2]\nrecovery = \"give-up\"\n",
        "[channel]\ndelay_s = 0.003\n[estimator]\nforgetting = \"exponential\"\n",
        "[channel]\ndelay_s = 0.004\n[sensor]\nposition_resolution_m = 1e-6\n[slave]\ncompliance_m_per_n = 1e-4\n",
        "[channel]\ndelay_s = 0.004\n[actuator]\nmaster_lag_s = 2e-3\nslave_lag_s = 1e-3\nmaster_force_limit_n = 20.0\n",
    ] {
        // Motor limits need sampled control.
        let control = if parts.contains("[actuator]") { "control = \"sampled\"\n" } else { "" };
        let scenario = scenario(&parts.replacen("[channel]", &format!("{control}[channel]"), 1));
        let ends = in_virtual_time(&scenario, &Key::of_loopback(), &of_channel(&scenario), |_, _, _, _| ());
        assert_is_run(&scenario, &ends);
    }
}

#[test]
fn foreign_old_and_mutated_packets_change_nothing() {
    let scenario = scenario(CHANNEL);
    let key = Key::new(&[3; 32]).expect("long enough");
    let (other, _) = greeted(&scenario, &Key::new(&[4; 32]).expect("long enough"));
    let mut foreign = MasterEnd::new(&scenario, other.session).expect("builds");
    let mut seen: Vec<[u8; PACKET_BYTES]> = vec![];
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let ends = in_virtual_time(&scenario, &key, &of_channel(&scenario), |tick, packet, master, slave| {
        let of_foreign = foreign.send(0);
        let mut give = |bytes: &[u8]| {
            master.take(bytes, 0);
            slave.take(bytes, 0);
        };
        for round in 0..4 {
            let mut bytes = [0; 2 * PACKET_BYTES];
            random.fill(&mut bytes);
            let length = random.random_range(0..bytes.len());
            give(&bytes[..length]);
            // Noise with the head of a packet.
            bytes[..12].copy_from_slice(&packet[..12]);
            give(&bytes[..PACKET_BYTES]);
            let mut changed = *packet;
            for _ in 0..=round % 4 {
                changed[random.random_range(0..PACKET_BYTES)] ^= 1 << random.random_range(0..8);
            }
            if changed != *packet {
                give(&changed);
            }
            give(&packet[..random.random_range(0..PACKET_BYTES)]);
            if !seen.is_empty() {
                give(&seen[random.random_range(0..seen.len())]);
            }
        }
        give(&of_foreign);
        if tick > foreign.tick() {
            foreign.step().expect("steps");
        }
        seen.push(*packet);
    });
    assert_is_run(&scenario, &ends);
    for counters in [ends.0.counters(), ends.1.counters()] {
        let dropped = [counters.malformed, counters.foreign, counters.replayed];
        assert!(dropped.into_iter().all(|count| count > 2_000), "{counters:?}");
    }
}

#[test]
fn every_lost_message_is_counted() {
    let scenario = scenario("");
    // Two messages of seven overtake each other, and one of ten is lost.
    let delay = |tick: u64| (!tick.is_multiple_of(10)).then_some(5 * u64::from(tick.is_multiple_of(7)));
    let delays: Delays = (0..scenario.grid.ticks()).map(delay).collect();
    let both = [delays.clone(), delays];
    let (master, slave) = in_virtual_time(&scenario, &Key::of_loopback(), &both, |_, _, _, _| ());
    for (from, to) in [
        (master.counters(), (slave.counters(), slave.delays())),
        (slave.counters(), (master.counters(), master.delays())),
    ] {
        let (counters, delays) = to;
        let lost = delays.iter().filter(|delay| **delay == Schedule::LOST).count() as u64;
        assert_eq!((from.sent, counters.received + lost), (scenario.grid.ticks(), scenario.grid.ticks()));
        assert!(counters.overtaken > 100 && lost > 200, "{counters:?}");
    }
}

/// A process that ends with the test.
pub(crate) struct Running(pub(crate) Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Returns a started side and the address that it prints.
fn started(mut side: Child) -> (Running, String) {
    let mut line = String::new();
    let mut printed = std::io::BufReader::new(side.stderr.take().expect("a pipe"));
    std::io::BufRead::read_line(&mut printed, &mut line).expect("a line");
    let address = line.split_whitespace().find_map(|word| word.strip_suffix(';')).expect("an address").to_owned();
    (Running(side), address)
}

#[test]
fn the_log_of_a_link_in_real_time_can_be_simulated() {
    let folder = TestFolder::new();
    folder.file("x.toml", BASE.replace("duration_s = 2.5", "duration_s = 1.0"));
    folder.file("key", [7; 32]);
    let start = |arguments: &[&str]| {
        let mut command = Command::new(assert_cmd::cargo::cargo_bin("trocar"));
        command.current_dir(folder.path("")).args(["link"]).args(arguments).args(["x.toml", "--key-file", "key"]);
        command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("starts")
    };
    let (mut slave, address) = started(start(&["slave", "--listen", "127.0.0.1:0"]));
    let mut master = Running(start(&["master", "--to", &address]));
    assert!(master.0.wait().expect("ends").success() && slave.0.wait().expect("ends").success());

    for side in ["master", "slave"] {
        let summary: serde_json::Value =
            serde_json::from_str(&folder.text(&format!("out/x/{side}/summary.json"))).expect("JSON");
        let count = |name: &str| summary["messages"][name].as_u64().expect("a number");
        assert_eq!((summary["ticks"].as_u64(), count("sent")), (Some(1000), 1000));
        assert_eq!(count("received") + count("lost"), 1000);
        assert!(summary["lateness_s"]["worst"].is_number());
    }
    let printed = folder.good(&["link", "replay", "out/x"]);
    assert_eq!(printed.matches("1000 ticks, the replay is the same bit for bit").count(), 2, "{printed}");
    // A run of the written scenario equals the replay; a changed log is detected.
    folder.good(&["run", "out/x/replay/replay.toml", "--out", "again", "--quiet"]);
    let log = folder.text("out/x/master/trace.csv");
    let (head, last) = log.trim_end().rsplit_once('\n').expect("rows");
    let again = folder.text("again/replay/trace.csv");
    assert!(again.lines().last().expect("a row").starts_with(&last[..last.find(',').expect("columns")]));
    folder.file("out/x/master/trace.csv", format!("{head}\n{}", last.replacen("0.999,", "0.999,1", 1)));
    let outcome = folder.trocar(&["link", "replay", "out/x"]);
    assert_eq!(outcome.code, 1, "{}", outcome.err);
    assert!(
        outcome.out.contains("master: the replay differs at tick 999 (0.999 s): desired_position_m"),
        "{}",
        outcome.out
    );
}

#[test]
fn invalid_links_are_refused() {
    let folder = TestFolder::new();
    folder.file("x.toml", format!("{BASE}{CHANNEL}")).file("short", "secret");
    folder.file("dry.toml", BASE);
    let dop853 = ["slave", "x.toml", "--listen", "127.0.0.1:0", "--set", "simulation.engine=dop853"];
    let refusals: [(&[&str], &[&str]); 8] = [
        (&["master", "x.toml"], &["act in simulations only", "tc netem"]),
        (&["slave", "x.toml", "--listen", "0.0.0.0:0"], &["--key-file"]),
        (&["slave", "x.toml", "--key-file", "short"], &["short: the key has 6 bytes"]),
        (&["slave", "x.toml", "--key-file", "none"], &["none: "]),
        (&["slave", "x.toml", "--listen", "here"], &["give a host and a port"]),
        (&["master", "dry.toml", "--to", "192.0.2.1:7711"], &["--key-file"]),
        (&dop853, &["integrates both machines together", "\"exact\""]),
        (&["replay", "x"], &["give the folder of a link"]),
    ];
    for (arguments, phrases) in refusals {
        folder.refused(&[&["link"], arguments].concat(), phrases);
    }
    let alone = folder.trocar(&["link", "master", "dry.toml", "--wait-s", "1", "--to", "127.0.0.1:9"]);
    assert_eq!(alone.code, 1);
    assert!(alone.err.contains("no slave replied at 127.0.0.1:9 within 1 s"), "{}", alone.err);
}
