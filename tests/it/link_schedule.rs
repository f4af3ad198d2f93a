//! Outages and logged delays, from the scenario file to the trace, and invalid ones.

use crate::support::test_folder::TestFolder;
use trocar::engine::Trace;
use trocar::run::run;
use trocar::scenario::{Scenario, Source};

/// A hand at 20 mm/s and a slave in a soft tissue, without augmentation, for 1 s.
const BASE: &str = "name = \"x\"\noperator.kind = \"ramp\"\noperator.speed_m_per_s = 0.02\n\
    tissue = { kind = \"kelvin-voigt\", stiffness_n_per_m = 20.0 }\nsimulation.duration_s = 1.0\n\
    augmentation.enabled = false\n";

/// Loads the scenario in a folder with these keys of its channel.
fn load(folder: &TestFolder, channel: &str) -> Scenario {
    folder.file("x.toml", format!("{BASE}[channel]\n{channel}\n"));
    Scenario::load(&Source::Disk(folder.path("x.toml")), &[]).expect("loads")
}

fn traced(folder: &TestFolder, channel: &str) -> Trace {
    run(load(folder, channel)).expect("runs").trace
}

fn refuse(folder: &TestFolder, channel: &str, phrases: &[&str]) {
    folder.file("x.toml", format!("{BASE}[channel]\n{channel}\n"));
    folder.refused(&["check", "x.toml"], phrases);
}

/// Returns the slave's reference if each sample of the master takes a number of ticks and the latest arrived sample
/// applies. A sample that never arrives is lost.
fn held(trace: &Trace, ticks: impl Fn(usize) -> Option<usize>) -> Vec<f64> {
    let arrived = |now: usize| (0..=now).rev().find(|&sent| ticks(sent).is_some_and(|ticks| sent + ticks <= now));
    let position_m = |now| arrived(now).map_or(0.0, |sent| trace.master_position_m[sent]);
    (0..trace.len()).map(position_m).collect()
}

#[test]
fn samples_take_the_logged_delay() {
    let folder = TestFolder::new();
    // Late, lost, early enough to overtake, and lost until the end. There is no backward delay.
    folder.file(
        "logs/wifi.csv",
        "# from a rig\ntime_s,forward_delay_s,backward_delay_s\n0.1,0.0304,0\n0.3005,,0\n0.35,0.1,0\n0.4,0.0052,0\n0.9,lost,0\n",
    );
    let trace = traced(&folder, "delays_file = \"logs/wifi.csv\"\noutage_s = 1.0");
    let expected = held(&trace, |sent| match sent {
        0..=300 => Some(30),
        301..350 => None,
        350..400 => Some(100),
        400..900 => Some(5),
        _ => None,
    });
    assert_eq!(trace.slave_reference_m, expected);
    assert!(expected[950] > 0.015, "it moves: {}", expected[950]);
}

#[test]
fn a_trace_with_one_delay_equals_that_constant_delay() {
    let folder = TestFolder::new();
    folder.file("d.csv", "backward_delay_s;time_s;forward_delay_s\n0.02;0;0.03\n0.02;0.5;0.03\n");
    assert_eq!(
        traced(&folder, "delays_file = \"d.csv\""),
        traced(&folder, "forward_delay_s = 0.03\nbackward_delay_s = 0.02")
    );
    let uneven = "jitter_s = 0.01\nloss = 0.2\n";
    assert_eq!(
        traced(&folder, &format!("{uneven}delays_file = \"d.csv\"")),
        traced(&folder, &format!("{uneven}forward_delay_s = 0.03\nbackward_delay_s = 0.02"))
    );
}

#[test]
fn an_echo_finds_the_delays_again() {
    let folder = TestFolder::new();
    folder.file("logs/d.csv", "time_s,forward_delay_s,backward_delay_s\n0,0.03,0.02\n0.5,,0.03\n");
    let scenario = load(&folder, "delays_file = \"logs/d.csv\"\noutages_s = [0.7, 0.8]");
    let elsewhere = TestFolder::new();
    elsewhere.file("again.toml", scenario.echo());
    let echo = elsewhere.path("again.toml");
    let again = Scenario::load(&Source::Disk(echo), &[]).expect("its echo is good");
    assert_eq!(scenario.echo(), again.echo());
    assert_eq!(scenario.forward_schedule, again.forward_schedule);
    assert_eq!(scenario.backward_schedule, again.backward_schedule);
    assert_ne!(scenario.forward_schedule, scenario.backward_schedule);
}

#[test]
fn the_slave_stops_during_an_outage_and_returns_to_the_hand_at_its_speed() {
    let folder = TestFolder::new();
    let link = "forward_delay_s = 0.02\njitter_s = 0.003\noutages_s = [0.3, 0.6]";
    let ramp = format!("{link}\nrecovery_speed_m_per_s = 0.05");
    let trace = traced(&folder, &ramp);
    let reference = &trace.slave_reference_m;
    // No sample sent before 0.3 s arrives after 0.322 s, and no later sample arrives before 0.62 s.
    assert!(reference[322..620].iter().all(|&position| position == reference[322]));
    let there = (620..1000).find(|&tick| trace.master_position_m[600..tick].contains(&reference[tick])).expect("there");
    let steps: Vec<f64> = (620..=there).map(|tick| reference[tick] - reference[tick - 1]).collect();
    assert!(steps.iter().all(|&step| step <= 5e-5 * (1.0 + 1e-9)), "faster than 50 mm/s");
    // Catching up 6 mm on a hand at 20 mm/s takes 0.2 s at 50 mm/s.
    assert!((780..860).contains(&there), "{there}");
    assert_eq!(
        trace.slave_reference_m[..320],
        traced(&folder, &ramp.replace("[0.3, 0.6]", "[]")).slave_reference_m[..320]
    );

    let held = traced(&folder, &format!("{link}\nrecovery = \"hold\""));
    let gap_m = |tick: usize| held.master_position_m[tick - 22] - held.slave_reference_m[tick];
    assert!((gap_m(990) - 6e-3).abs() < 5e-4, "{} m stay between hand and slave", gap_m(990));
    let given_up = traced(&folder, &format!("{link}\nrecovery = \"give-up\"")).slave_reference_m;
    assert!(given_up[322..].iter().all(|&position| position == given_up[322]));
}

#[test]
fn a_slave_with_an_outage_from_the_start_does_not_jump() {
    let folder = TestFolder::new();
    let trace = traced(&folder, "outages_s = [0.0, 0.5]\nrecovery_speed_m_per_s = 0.05");
    let reference = &trace.slave_reference_m;
    assert!(reference[..500].iter().all(|&position| position == 0.0) && trace.master_position_m[500] > 8e-3);
    let fastest = reference.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
    assert!(fastest <= 5e-5 * (1.0 + 1e-9), "{fastest}");
    assert_eq!(reference[999], trace.master_position_m[999], "it has returned at the end");
}

#[test]
fn invalid_outages_are_rejected_with_their_place() {
    let folder = TestFolder::new();
    for (outages, phrases) in [
        ("[0.3]", ["the outage at 0.3 s has no end", "write each outage as its start and its end"]),
        ("[0.1, 0.2, 0.3]", ["has 3 numbers", "write each outage as its start and its end"]),
        ("[0.3, 0.2]", ["from 0.3 to 0.2 s, must end after its start", "write each outage"]),
        ("[0.3, 0.5, 0.4, 0.6]", ["an outage from 0.4 s after one to 0.5 s, must ascend", "join those that overlap"]),
        ("[-0.1, 0.2]", ["has -0.1, must be at least 0", "count from the run's start"]),
        ("[0.1, nan]", ["channel.outages_s is [0.1, nan]", "a list of numbers"]),
        ("0.3", ["channel.outages_s is 0.3", "a list of numbers"]),
    ] {
        refuse(&folder, &format!("outages_s = {outages}"), &phrases);
        refuse(&folder, &format!("outages_s = {outages}"), &["x.toml:8:13"]);
    }
}

#[test]
fn invalid_delays_are_rejected_with_file_line_and_remedy() {
    let folder = TestFolder::new();
    let header = "time_s,forward_delay_s,backward_delay_s\n";
    for (rows, phrases) in [
        ("0,0,0\n1,-0.1,0\n", ["d.csv line 3, column 'forward_delay_s': a delay of -0.1 s", "leave the field empty"]),
        (
            "0,0,2000\n",
            ["line 2, column 'backward_delay_s': a delay of 2000 s, must be from 0 to 1000 s", "correct it"],
        ),
        ("0,gone,0\n", ["line 2, column 'forward_delay_s': 'gone' is not a number", "correct it or remove the row"]),
        ("0,0,nan\n", ["line 2, column 'backward_delay_s': 'nan' is not finite", "correct it or remove the row"]),
        ("0,0,0\n1,0,0\n0.5,0,0\n", ["line 4, column 'time_s': time decreases", "sort the rows by time"]),
        ("0,0,0\n", ["d.csv: holds a single sample", "at least two are needed"]),
        ("", ["d.csv: holds a header but no samples", "at least two are needed"]),
        ("1.7e9,0,0\n1.8e9,0,0\n", ["begin at 1700000000 s, after the run's end at 1 s", "from the run's start"]),
    ] {
        folder.file("d.csv", format!("{header}{rows}"));
        refuse(&folder, "delays_file = \"d.csv\"", &phrases);
        refuse(&folder, "delays_file = \"d.csv\"", &["x.toml:8:15"]);
    }
    folder.file("d.csv", "");
    refuse(&folder, "delays_file = \"d.csv\"", &["d.csv: holds no data"]);
    folder.file("d.csv", "time_s,forward_delay,backward_delay_s\n0,0,0\n1,0,0\n");
    refuse(&folder, "delays_file = \"d.csv\"", &["no column 'forward_delay_s'", "did you mean 'forward_delay'?"]);
    refuse(&folder, "delays_file = \"none.csv\"", &["none.csv: cannot be read", "x.toml:8:15"]);
    refuse(&folder, "delays_file = \".\"", &["is a directory, not a regular file"]);
    refuse(&folder, "delays_file = \"builtin:none.csv\"", &["there is no recording builtin:none.csv"]);
    refuse(&folder, "delays_file = \"\"", &["channel.delays_file is \"\"", "the path of a file"]);
}

#[test]
fn a_delays_file_excludes_a_constant_delay_and_its_size_is_limited() {
    let folder = TestFolder::new();
    folder.file("d.csv", "time_s,forward_delay_s,backward_delay_s\n0,0,0\n1,0,0\n2,0,0\n");
    for key in ["forward_delay_s", "backward_delay_s"] {
        let both = format!("delays_file = \"d.csv\"\n{key} = 0.01");
        let message = format!("channel.{key} is 0.01, but channel.delays_file gives the delays");
        refuse(&folder, &both, &[&message, &format!("leave out channel.{key}, or channel.delays_file"), "x.toml:9"]);
    }
    let limited = |limit: &str| format!("delays_file = \"d.csv\"\n[recording]\n{limit}");
    refuse(
        &folder,
        &limited("max_samples = 2"),
        &["d.csv line 4: more than 2 samples", "raise recording.max_samples", "x.toml:10:15"],
    );
    refuse(&folder, &limited("max_bytes = 20"), &["d.csv: is 0.0 MiB", "raise recording.max_bytes", "x.toml:10:13"]);
}
