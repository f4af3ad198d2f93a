//! `trocar identify`: the files, and errors with their remedies.

use serde_json::Value as Json;

use crate::support::test_folder::TestFolder;

const COLUMNS: [&str; 8] = ["--time", "t", "--master", "m", "--slave", "s", "--force", "f"];

/// Writes a slave that follows its master 10 ms later, with a force that does not act on it.
fn machine(folder: &TestFolder, name: &str, row: impl Fn(usize, f64, f64, f64) -> String) {
    let rows = (0..1200).map(|k| {
        let place = |t: f64| 0.01 * (9.0 * t).sin();
        let t = k as f64 * 1e-3;
        let slave = place(t - 0.01);
        format!("{t:.3},{}\n", row(k, place(t), slave, 300.0 * slave.max(0.0)))
    });
    folder.file(name, std::iter::once("t,m,s,f\n".to_owned()).chain(rows).collect::<String>());
}

fn good(_: usize, master: f64, slave: f64, force: f64) -> String {
    format!("{master:.7},{slave:.7},{force:.5}")
}

#[test]
fn parameters_and_fits_are_printed_and_written() {
    let folder = TestFolder::new();
    machine(&folder, "train.csv", good);
    machine(&folder, "other.csv", good);
    let command =
        [&["identify", "train.csv", "--predict", "other.csv", "--no-figures", "--json"][..], &COLUMNS].concat();
    let printed: Json = serde_json::from_str(&folder.good(&command)).expect("JSON");
    let roles: Vec<&str> = (0..2).filter_map(|k| printed["fits"][k]["role"].as_str()).collect();
    assert_eq!(roles, ["training", "prediction"]);
    assert!(printed["fits"][1]["fit_percent"].as_f64().is_some_and(|fit| fit > 99.0), "{printed}");
    let gain = &printed["parameters"]["position_gain_n_per_m"];
    // The force does not move this slave, so that only ratios are known.
    assert_eq!((&printed["only_ratios"], &gain["unit"]), (&true.into(), &"N/m per kg".into()));
    let toml: toml::Table = folder.text("out/train/machine.toml").parse().expect("TOML");
    assert_eq!(toml["machine"]["slave"]["position_gain_n_per_m"].as_float(), gain["value"].as_f64());
}

#[test]
fn recordings_that_cannot_be_used_are_refused_with_a_remedy() {
    let folder = TestFolder::new();
    machine(&folder, "nan.csv", |k, m, s, f| if k == 7 { format!("{m:.7},nan,0") } else { good(k, m, s, f) });
    machine(&folder, "still.csv", |_, _, _, _| "0,0,0".into());
    machine(&folder, "uneven.csv", |k, m, s, f| if k == 9 { format!("{m:.7},{s:.7}") } else { good(k, m, s, f) });
    for (file, phrases) in [
        ("nan.csv", ["line 9", "remove the row"]),
        ("still.csv", ["the master does not move", "record a motion"]),
        ("uneven.csv", ["line 11", "complete or remove the row"]),
    ] {
        folder.refused(&[&["identify", file][..], &COLUMNS].concat(), &phrases);
    }
}

#[test]
fn a_master_in_millimetres_is_reported() {
    let folder = TestFolder::new();
    machine(&folder, "mm.csv", |k, m, s, f| good(k, 1e3 * m, s, f));
    let output = folder.trocar(&[&["identify", "mm.csv", "--no-figures", "--deny-warnings"][..], &COLUMNS].concat());
    assert!(output.err.contains("the slave's motion is 1.000e-3 times"), "{}", output.err);
}
