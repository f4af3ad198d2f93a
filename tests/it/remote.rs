//! The two sides as two processes: in virtual time they give the signals of a run, bit for bit; in real time on this machine, what they
//! log gives them again.

use std::process::{Child, Command, Stdio};

use crate::support::test_folder::TestFolder;
use trocar::channel::Schedule;
use trocar::run::run;
use trocar::scenario::{Scenario, Source};
use trocar_report::{ColumnFormat, write_trace_columns};
use trocar_sim::remote::{
    Calling, Greeted, Key, MasterEnd, PACKET_BYTES, Proxy, Role, SlaveEnd, Waiting, fingerprint, first_difference,
};

/// Layers, a hand that reacts, noise, and augmentation: a rupture is detected within the time.
const BASE: &str = "name = \"x\"\nbase = \"builtin:layers/skin-augmented\"\n\
    [operator]\nreflex = \"withdraw\"\ntremor_amplitude_m = 1e-4\n[simulation]\nduration_s = 2.5\n";

fn scenario(more: &str) -> Scenario {
    let text = format!("{BASE}{more}");
    Scenario::load(&Source::Text { name: "x".into(), text: text.into() }, &[]).expect("loads")
}

/// A session of both sides.
fn greeted(scenario: &Scenario, key: &Key) -> (Greeted, Greeted) {
    let scenario = fingerprint(scenario);
    let (mut master, mut slave) =
        (Calling::new(key.clone(), [1; 16], scenario), Waiting::new(key.clone(), [2; 16], scenario));
    master.take(&slave.take(&master.hello(0), 0).expect("a reply"), 0);
    master.take(&slave.take(&master.start(0, 0).expect("a slave"), 0).expect("ready"), 0);
    (master.greeted(0).expect("ready"), slave.greeted().expect("started").clone())
}

/// Runs both ends in virtual time, with the scenario's channel between them. `disturb` sees each packet on its way.
fn in_virtual_time(
    scenario: &Scenario,
    key: &Key,
    mut disturb: impl FnMut(u64, &[u8; PACKET_BYTES], &mut MasterEnd, &mut SlaveEnd),
) -> (MasterEnd, SlaveEnd) {
    let (of_master, of_slave) = greeted(scenario, key);
    let mut master = MasterEnd::new(scenario, of_master.session).expect("builds");
    let mut slave = SlaveEnd::new(scenario, of_slave.session).expect("builds");
    let mut proxy = Proxy::new(scenario);
    let mut deliver = |proxy: &mut Proxy, now_ns, tick, master: &mut MasterEnd, slave: &mut SlaveEnd| {
        while let Some((to, packet)) = proxy.next_due(now_ns) {
            disturb(tick, &packet, master, slave);
            match to {
                Role::Master => master.take(&packet, now_ns),
                Role::Slave => slave.take(&packet, now_ns),
            };
        }
    };
    for tick in 0..scenario.grid.ticks() {
        let now_ns = (tick as f64 * scenario.grid.tick_s() * 1e9).round() as i64;
        proxy.take(Role::Master, &master.send(now_ns), now_ns);
        deliver(&mut proxy, now_ns, tick, &mut master, &mut slave);
        proxy.take(Role::Slave, &slave.step(now_ns).expect("steps"), now_ns);
        deliver(&mut proxy, now_ns, tick, &mut master, &mut slave);
        master.step().expect("steps");
    }
    assert!(master.has_ended() && slave.has_ended());
    (master, slave)
}

/// Checks that both ends have the signals of a run.
fn assert_is_run(scenario: &Scenario, (master, slave): &(MasterEnd, SlaveEnd)) {
    let trace = run(scenario.clone()).expect("runs").trace;
    let both = [(MasterEnd::COLUMNS, master.trace()), (SlaveEnd::COLUMNS, slave.trace())];
    for (columns, of_side) in both {
        let mut log = vec![];
        write_trace_columns(of_side, "side", columns, ColumnFormat::Csv, &mut log).expect("written");
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
            let ends = in_virtual_time(&scenario, &Key::of_loopback(), |_, _, _, _| ());
            assert_is_run(&scenario, &ends);
            let (master, slave) = ends;
            // The meter has the energies as they arrive: a promise holds for them, too.
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
        // Down from the start; each recovery.
        "[channel]\ndelay_s = 0.01\noutages_s = [0.0, 0.3, 1.5, 1.8]\nrecovery = \"hold\"\n",
        "[channel]\ndelay_s = 0.3\njitter_s = 0.1\noutages_s = [1.5, 2.2]\nrecovery = \"give-up\"\n",
        "[channel]\ndelay_s = 0.003\n[estimator]\nforgetting = \"exponential\"\n",
        "[channel]\ndelay_s = 0.004\n[sensor]\nposition_resolution_m = 1e-6\n[slave]\ncompliance_m_per_n = 1e-4\n",
        "[channel]\ndelay_s = 0.004\n[actuator]\nmaster_lag_s = 2e-3\nslave_lag_s = 1e-3\nmaster_force_limit_n = 20.0\n",
    ] {
        // Limits of the motors need controllers on the tick.
        let control = if parts.contains("[actuator]") { "control = \"sampled\"\n" } else { "" };
        let scenario = scenario(&parts.replacen("[channel]", &format!("{control}[channel]"), 1));
        let ends = in_virtual_time(&scenario, &Key::of_loopback(), |_, _, _, _| ());
        assert_is_run(&scenario, &ends);
    }
}

#[test]
fn replays_foreign_keys_and_noise_on_the_line_change_nothing() {
    let scenario = scenario(CHANNEL);
    let key = Key::new(&[3; 32]).expect("long enough");
    // The packets of a session with another key, and of another session with the same.
    let (other, _) = greeted(&scenario, &Key::new(&[4; 32]).expect("long enough"));
    let mut foreign = MasterEnd::new(&scenario, other.session).expect("builds");
    let mut seen: Vec<[u8; PACKET_BYTES]> = vec![];
    let ends = in_virtual_time(&scenario, &key, |tick, packet, master, slave| {
        if tick % 10 == 0 {
            let mut changed = *packet;
            changed[tick as usize % PACKET_BYTES] ^= 1;
            let old = seen.get(seen.len() / 2).copied().unwrap_or(changed);
            for bytes in [&changed[..], &old, &foreign.send(0), &packet[..tick as usize % PACKET_BYTES]] {
                master.take(bytes, 0);
                slave.take(bytes, 0);
            }
            foreign.step().expect("steps");
        }
        seen.push(*packet);
    });
    assert_is_run(&scenario, &ends);
    let dropped = [ends.0.counters(), ends.1.counters()];
    for counters in dropped {
        assert!(counters.malformed > 100 && counters.foreign > 500 && counters.replayed > 50, "{counters:?}");
    }
}

#[test]
fn no_message_is_lost_uncounted() {
    let scenario = scenario(CHANNEL);
    let (master, slave) = in_virtual_time(&scenario, &Key::of_loopback(), |_, _, _, _| ());
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
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[test]
fn what_a_link_in_real_time_logs_is_simulated_again() {
    let folder = TestFolder::new();
    folder.file("x.toml", format!("{BASE}{CHANNEL}").replace("duration_s = 2.5", "duration_s = 1.0"));
    folder.file("key", [7; 32]);
    let start = |arguments: &[&str]| {
        let mut command = Command::new(assert_cmd::cargo::cargo_bin("trocar"));
        command.current_dir(folder.path("")).args(["link"]).args(arguments).args(["x.toml", "--key-file", "key"]);
        command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("starts")
    };
    let mut slave = start(&["slave", "--listen", "127.0.0.1:0"]);
    let mut line = String::new();
    let mut told = std::io::BufReader::new(slave.stderr.take().expect("a pipe"));
    std::io::BufRead::read_line(&mut told, &mut line).expect("a line");
    let mut slave = Running(slave);
    let address = line.split_whitespace().find_map(|word| word.strip_suffix(';')).expect("an address").to_owned();
    let mut master = Running(start(&["master", "--proxy", "--to", &address]));
    assert!(master.0.wait().expect("ends").success() && slave.0.wait().expect("ends").success());

    for side in ["master", "slave"] {
        let summary: serde_json::Value =
            serde_json::from_str(&folder.text(&format!("out/x/{side}/summary.json"))).expect("JSON");
        let count = |name: &str| summary["messages"][name].as_u64().expect("a number");
        assert_eq!((summary["ticks"].as_u64(), count("sent")), (Some(1000), 1000));
        assert_eq!(count("received") + count("lost"), 1000);
        assert!(summary["lateness_s"]["worst"].is_number());
    }
    let told = folder.good(&["link", "replay", "out/x"]);
    assert_eq!(told.matches("1000 ticks, the replay is the same bit for bit").count(), 2, "{told}");
    // A run of the scenario that it wrote is that replay; a changed log is found.
    folder.good(&["run", "out/x/replay.toml", "--out", "again", "--quiet"]);
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
fn what_cannot_be_linked_is_refused() {
    let folder = TestFolder::new();
    folder.file("x.toml", format!("{BASE}{CHANNEL}")).file("short", "secret");
    folder.refused(&["link", "master", "x.toml"], &["act with --proxy only"]);
    folder.refused(&["link", "slave", "x.toml", "--listen", "0.0.0.0:0"], &["--key-file"]);
    folder.refused(&["link", "slave", "x.toml", "--key-file", "short"], &["short: the key has 6 bytes"]);
    folder.refused(&["link", "slave", "x.toml", "--key-file", "none"], &["none: "]);
    folder.refused(&["link", "slave", "x.toml", "--listen", "here"], &["give a host and a port"]);
    folder.refused(
        &["link", "master", "x.toml", "--proxy", "--to", "192.0.2.1:7711", "--key-file", "x.toml"],
        &["on this machine"],
    );
    let dop853 = ["link", "slave", "x.toml", "--listen", "127.0.0.1:0", "--set", "simulation.engine=dop853"];
    folder.refused(&dop853, &["integrates both machines together", "\"exact\""]);
    folder.refused(&["link", "replay", "x"], &["give the folder of a link"]);
    let alone = folder.trocar(&["link", "master", "x.toml", "--proxy", "--wait-s", "1", "--to", "127.0.0.1:9"]);
    assert_eq!(alone.code, 1);
    assert!(alone.err.contains("no slave replied at 127.0.0.1:9 within 1 s"), "{}", alone.err);
}
