//! A side of a link that was killed is started anew, with the real program, and joins the other side.

use std::fs::File;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::Duration;

use super::link_sides::Running;
use crate::support::test_folder::TestFolder;

const SCENARIO: &str = "name = \"x\"\nbase = \"builtin:layers/skin-augmented\"\n\
    [channel]\noutage_s = 0.05\n[simulation]\nduration_s = 5.0\n";

/// Starts a side that writes its messages into the file `OUT-SIDE.txt`.
fn start(folder: &TestFolder, out: &str, arguments: &[&str]) -> Running {
    let printed = File::create(folder.path(&format!("{out}-{}.txt", arguments[0]))).expect("a file");
    let mut command = Command::new(assert_cmd::cargo::cargo_bin("trocar"));
    command.current_dir(folder.path("")).args(["link"]).args(arguments);
    command.args(["x.toml", "--key-file", "key", "--out", out]);
    Running(command.stdout(Stdio::null()).stderr(printed).spawn().expect("starts"))
}

/// Returns the address that a slave prints.
fn address(folder: &TestFolder) -> String {
    loop {
        let printed = folder.text("out-slave.txt");
        match printed.split_whitespace().find_map(|word| word.strip_suffix(';')) {
            Some(address) => return address.to_owned(),
            None => sleep(Duration::from_millis(10)),
        }
    }
}

fn json(folder: &TestFolder, name: &str) -> serde_json::Value {
    serde_json::from_str(&folder.text(name)).expect("JSON")
}

/// Returns a column of a trace.
fn column(folder: &TestFolder, name: &str, column: &str) -> Vec<f64> {
    let text = folder.text(name);
    let place = text.lines().next().expect("a head").split(',').position(|name| name == column).expect("a column");
    text.lines().skip(1).map(|row| row.split(',').nth(place).expect("a cell").parse().expect("a number")).collect()
}

/// Kills a side and starts it anew, with another folder for its files. Returns the exit codes of the survivor and of the
/// new process.
fn with_a_restart(is_master_dead: bool) -> (TestFolder, [Option<i32>; 2]) {
    let folder = TestFolder::new();
    folder.file("x.toml", SCENARIO).file("key", [7; 32]);
    let mut slave = start(&folder, "out", &["slave", "--listen", "127.0.0.1:0"]);
    let address = address(&folder);
    let to_slave = ["master", "--to", &address, "--wait-s", "30"];
    let mut master = start(&folder, "out", &to_slave);
    // The greeting takes half a second.
    sleep(Duration::from_millis(1500));
    let (survivor, new) = if is_master_dead {
        master.0.kill().expect("killed");
        sleep(Duration::from_millis(600));
        (slave, start(&folder, "second", &to_slave))
    } else {
        slave.0.kill().expect("killed");
        slave.0.wait().expect("ended");
        sleep(Duration::from_millis(600));
        (master, start(&folder, "second", &["slave", "--listen", &address]))
    };
    let codes = [survivor, new].map(|mut side| side.0.wait().expect("ends").code());
    (folder, codes)
}

#[test]
fn a_side_that_was_killed_is_started_anew_and_joins() {
    for is_master_dead in [true, false] {
        let (dead, alive) = if is_master_dead { ("master", "slave") } else { ("slave", "master") };
        let (folder, codes) = with_a_restart(is_master_dead);
        let (survivor, new) = (folder.text(&format!("out-{alive}.txt")), folder.text(&format!("second-{dead}.txt")));
        assert_eq!(codes, [Some(1); 2], "{survivor}{new}");
        assert!(new.contains(&format!("joined the {alive} at tick ")), "{new}{survivor}");
        assert!(survivor.contains(&format!("a new process of the {dead} has joined after")), "{survivor}");
        assert!(survivor.contains(&format!("the {dead} was started anew during the run, 1 time")), "{survivor}");

        let of_survivor = json(&folder, &format!("out/x/{alive}/summary.json"));
        let of_new = json(&folder, &format!("second/x/{dead}/summary.json"));
        let number = |of: &serde_json::Value, key: &str| of[key].as_u64().expect("a number");
        assert_eq!((number(&of_survivor, "restarts"), number(&of_survivor, "first_tick")), (1, 0));
        assert_eq!(number(&of_new, "restarts"), 0);
        let first_tick = number(&of_new, "first_tick");
        assert!((500..4000).contains(&first_tick), "{first_tick}");
        assert_eq!((number(&of_survivor, "ticks"), number(&of_new, "ticks")), (5000, 5000));
        for summary in [&of_survivor, &of_new] {
            assert_eq!(summary["warnings"][0]["code"], "peer-restarted", "{summary}");
        }
        // Each side has received most messages since then.
        for summary in [&of_survivor, &of_new] {
            let received = summary["messages"]["received"].as_u64().expect("a number");
            assert!(received * 10 > (5000 - first_tick) * 8, "{received} messages since tick {first_tick}");
        }

        let side = |role: &str| if role == alive { format!("out/x/{role}") } else { format!("second/x/{role}") };
        let reference_m = column(&folder, &format!("{}/trace.csv", side("slave")), "slave_reference_m");
        let force_n = column(&folder, &format!("{}/trace.csv", side("master")), "feedback_force_n");
        for (values, limit) in [(reference_m, 0.5 * 1e-3), (force_n, 2000.0 * 1e-3)] {
            assert_eq!(values.len(), 5000);
            let steps = values[first_tick as usize - 1..].windows(2).map(|pair| (pair[1] - pair[0]).abs());
            let largest = steps.fold(0.0, f64::max);
            assert!(largest > 0.0 && largest <= limit, "{alive}: {largest}, at most {limit}");
        }

        // The logs of such a link cannot be simulated again.
        std::fs::rename(folder.path(&format!("second/x/{dead}")), folder.path("new")).expect("moved");
        let _ = std::fs::remove_dir_all(folder.path(&format!("out/x/{dead}")));
        std::fs::rename(folder.path("new"), folder.path(&format!("out/x/{dead}"))).expect("moved");
        let replay = folder.trocar(&["link", "replay", "out/x"]);
        assert_eq!(replay.code, 1, "{}", replay.err);
        assert!(replay.err.contains("a side was started anew during this link"), "{}", replay.err);
    }
}
