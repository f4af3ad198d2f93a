//! A tissue in an imported FMU: an FMU written in C gives the bits of the built-in model, errors of an FMU are
//! reported, and nothing in it is executed before a run. `python/tests/test_fmu.py` runs FMUs that trocar and other
//! programs export.

use std::io::Cursor;
use std::path::Path;

use trocar::engine::Trace;
use trocar::run::run;
use trocar::scenario::{Scenario, Source};
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

use crate::support::test_folder::TestFolder;
use crate::support::unit::{Fault, container, description, library, place, unit, unit_with};

/// Returns an insertion of 0.4 s with the given `[tissue]` and following sections.
fn insertion(tissue: &str) -> String {
    format!(
        "name = \"insertion\"\nsimulation.duration_s = 0.4\noperator = {{ kind = \"ramp\", start_m = -5e-4, end_m = 0.02, speed_m_per_s = 0.03 }}\n\
         estimator.contact_m = 1e-3\n[tissue]\n{tissue}"
    )
}

const BUILT_IN: &str =
    "kind = \"kelvin-voigt\"\nstiffness_n_per_m = 350.0\ndamping_n_s_per_m = 4.0\ncontact_m = 1e-3\n";

const OF_UNIT: &str = "kind = \"fmu\"\n[tissue.fmu]\nfile = \"tissue.fmu\"\nposition = \"x\"\nvelocity = \"v\"\nforce = \"f\"\n\
                       parameters = \"k = 350; b=4.0; contact = 1e-3\"\n";

fn trace(folder: &TestFolder, text: &str) -> Trace {
    folder.file("scenario.toml", text);
    let scenario = Scenario::load(&Source::Disk(folder.path("scenario.toml")), &[]).expect("loads");
    run(scenario).expect("runs").trace
}

fn bits(column: &[f64]) -> Vec<u64> {
    column.iter().map(|value| value.to_bits()).collect()
}

/// Checks that two runs are identical, bit for bit.
fn assert_same(found: &Trace, expected: &Trace) {
    assert!(expected.tissue_force_n.iter().any(|force_n| *force_n > 1.0), "the needle enters");
    assert_eq!(bits(&found.slave_position_m), bits(&expected.slave_position_m));
    assert_eq!(bits(&found.tissue_force_n), bits(&expected.tissue_force_n));
    assert_eq!(bits(&found.measured_force_n), bits(&expected.measured_force_n));
    assert_eq!(bits(&found.feedback_force_n), bits(&expected.feedback_force_n));
}

#[test]
fn a_unit_in_c_gives_the_same_bits_as_the_built_in_model() {
    let folder = TestFolder::new();
    for variant in [
        "",
        "[simulation]\nengine = \"dop853\"\n",
        "[sensor]\nforce_noise_std_n = 0.02\n",
        "[channel]\ndelay_s = 2.5e-3\n",
        "[simulation]\ncontrol = \"sampled\"\n[actuator]\nmaster_force_limit_n = 3.0\n",
    ] {
        let scenario_of = |tissue: &str| {
            let text = insertion(tissue);
            // The sections before `[tissue]`.
            let (head, tissue) = text.split_once("[tissue]").expect("a section");
            format!("{}{variant}[tissue]{tissue}", head.replace("simulation.duration_s = 0.4\n", "")).replacen(
                "[simulation]\n",
                "[simulation]\nduration_s = 0.4\n",
                1,
            )
        };
        let shorter = |text: String| {
            text + if variant.contains("[simulation]") { "" } else { "\n[simulation]\nduration_s = 0.4\n" }
        };
        let expected = trace(&folder, &shorter(scenario_of(BUILT_IN)));
        for fmi in [2, 3] {
            folder.file("tissue.fmu", unit(fmi, Fault::None));
            assert_same(&trace(&folder, &shorter(scenario_of(OF_UNIT))), &expected);
        }
    }
}

#[test]
fn the_tissue_of_a_unit_moves_with_breathing_like_the_built_in_tissue() {
    let folder = TestFolder::new();
    folder.file("tissue.fmu", unit(3, Fault::None));
    let moving = |tissue: &str| insertion(&tissue.replacen('\n', "\nbreathing_amplitude_m = 2e-3\n", 1));
    assert_same(&trace(&folder, &moving(OF_UNIT)), &trace(&folder, &moving(BUILT_IN)));
}

#[test]
fn a_longer_step_holds_the_force() {
    let folder = TestFolder::new();
    folder.file("tissue.fmu", unit(2, Fault::None));
    let held = trace(&folder, &insertion(&(OF_UNIT.to_owned() + "step_s = \"5ms\"\n")));
    for (k, force_n) in held.tissue_force_n.iter().enumerate() {
        let depth_m = held.slave_position_m[k - k % 5] - 1e-3;
        let damped_n = 4.0 * held.slave_velocity_m_per_s[k - k % 5];
        let expected_n = if depth_m > 0.0 { 350.0 * depth_m + damped_n } else { 0.0 };
        assert_eq!(force_n.to_bits(), expected_n.to_bits(), "tick {k}");
    }
    folder.refused(
        &["run", "scenario.toml", "--set", "tissue.fmu.step_s=2.5e-3"],
        &["tissue.fmu.step_s is 0.0025", "whole number of ticks"],
    );
    let text = description(2)
        .replace("modelIdentifier=\"tissue\"", "modelIdentifier=\"tissue\" fixedInternalStepSize=\"2e-3\"");
    folder.file("tissue.fmu", unit_with(&text, 2, &library(2, Fault::None)));
    folder.refused(&["run", "scenario.toml"], &["its internal step is 0.002 s, and 0.005 s is not a whole multiple"]);
}

#[test]
fn ruptures_and_the_force_on_the_shaft_come_from_the_outputs() {
    let folder = TestFolder::new();
    for fmi in [2, 3] {
        folder.file("tissue.fmu", unit(fmi, Fault::None));
        let with = |more: &str| {
            insertion(&OF_UNIT.replace("1e-3\"", &format!("1e-3; depth = 3e-3{more}\"\nruptured = \"open\"")))
        };
        let load = |text: String| {
            folder.file("scenario.toml", text);
            Scenario::load(&Source::Disk(folder.path("scenario.toml")), &[]).expect("loads")
        };
        let found = run(load(with("") + "[sensor]\nat_tip = true\n")).expect("runs");
        let trace = &found.trace;
        let first = trace.slave_position_m.iter().position(|position_m| *position_m - 1e-3 > 3e-3).expect("reached");
        let ruptures: Vec<f64> = found.metrics.ruptures.iter().map(|rupture| rupture.time_s).collect();
        assert_eq!(ruptures, [trace.time_s[first]], "once, though the output stays true");
        // A first-order lag of 10 ms behind the needle, in ten steps per tick.
        let mut state = 0.0;
        for (k, position_m) in trace.slave_position_m.iter().enumerate() {
            for _ in 0..10 {
                state += 1e-4 * (position_m - state) / 0.01;
            }
            assert_eq!(trace.measured_force_n[k], trace.tissue_force_n[k] - state, "tick {k}");
        }
        assert!(run(load(with("; layers = 0"))).expect("runs").metrics.ruptures.is_empty());
    }
}

#[test]
fn a_unit_that_fails_in_a_run_ends_it_with_its_message() {
    let folder = TestFolder::new();
    folder.file("scenario.toml", insertion(OF_UNIT));
    for (fmi, fault, phrases) in [
        (2, Fault::Error, ["at 0.05 s", "doStep failed with the status error: the mesh is inverted at element 17"]),
        (3, Fault::Error, ["at 0.05 s", "doStep failed with the status error: the mesh is inverted at element 17"]),
        (2, Fault::NotANumber, ["at 0.05 s", "the unit gives a force of NaN N"]),
        (3, Fault::Fatal, ["at 0.05 s", "status fatal"]),
        (3, Fault::End, ["at 0.05 s", "asks to end the simulation"]),
        (2, Fault::NoInstance, ["at 0 s", "cannot be instantiated"]),
        (3, Fault::RefusedParameter, ["at 0 s", "\"k\" cannot be set to 350: the stiffness is frozen"]),
    ] {
        folder.file("tissue.fmu", unit(fmi, fault));
        let outcome = folder.trocar(&["run", "scenario.toml", "--out", "out"]);
        assert_eq!(outcome.code, 1, "{}", outcome.err);
        for phrase in phrases.into_iter().chain(["insertion: ", "tissue.fmu: "]) {
            assert!(outcome.err.contains(phrase), "no {phrase:?} in {}", outcome.err);
        }
        assert!(!outcome.err.contains('\x1b'), "{:?}", outcome.err);
        assert!(!folder.path("out/insertion/trace.csv").exists());
    }
}

#[test]
fn an_unsuitable_unit_is_refused_before_the_run() {
    let folder = TestFolder::new();
    folder.file("scenario.toml", insertion(OF_UNIT));
    let plain = library(2, Fault::None);
    let with = |from: &str, to: &str| {
        let text = description(2);
        assert!(text.contains(from), "{from}");
        unit_with(&text.replace(from, to), 2, &plain)
    };
    let xml = description(2);
    let cases: Vec<(Vec<u8>, &[&str])> = vec![
        (b"spam".to_vec(), &["is not an FMU: it is not a zip container"]),
        (unit(2, Fault::None)[..2000].to_vec(), &["not a zip container"]),
        (container(&[("model/modelDescription.xml", xml.as_bytes())]), &["has no modelDescription.xml"]),
        (container(&[("modelDescription.xml", b"\xff")]), &["is not UTF-8"]),
        (with("<ModelVariables>", "<ModelVariable>"), &["modelDescription.xml: "]),
        (with("fmiVersion=\"2.0\"", "fmiVersion=\"1.0\""), &["is of FMI \"1.0\"", "2.0 or 3.0"]),
        (with("<CoSimulation modelIdentifier=\"tissue\"/>", "<ModelExchange/>"), &["is not for co-simulation"]),
        (with("=\"tissue\"", "=\"../tissue\""), &["modelIdentifier"]),
        (with("guid=", "id="), &["there is no guid"]),
        (with("valueReference=\"3\"", "valueReference=\"-3\""), &["f has no valueReference"]),
        (
            container(&[("modelDescription.xml", xml.as_bytes()), ("binaries/c64/tissue.prg", b"")]),
            &["no library for this machine, binaries/", ", but for c64"],
        ),
        (
            with("name=\"f\"", "name=\"g\""),
            &["has no variable \"f\"; each output: g, open, reaction.shaft_force_n", "scenario.toml:11"],
        ),
        (with("name=\"x\"", "name=\"z\""), &["has no variable \"x\"; each input: z, v, y, w"]),
        (with("\"3\" causality=\"output\"", "\"3\" causality=\"local\""), &["\"f\" is not an output"]),
        (with("unit=\"m\" start=\"0\"", "unit=\"mm\" start=\"0\""), &["\"x\" is in mm, and must be in m"]),
        (with("<Real unit=\"N\"/>", "<Real unit=\"m\"/>"), &["\"f\" is in m, and must be in N"]),
        (
            with("<Real unit=\"m\" start=\"0\"/>", "<Integer start=\"0\"/>"),
            &["\"x\" is not a single number of the type Real"],
        ),
        (with("name=\"b\"", "name=\"c\""), &["has no variable \"b\"; each parameter: k, c"]),
        (with("<Real start=\"200\"/>", "<Integer start=\"200\"/>").to_vec(), &[]),
        (with("<Real start=\"200\"/>", "<Boolean start=\"0\"/>"), &["has the type Boolean, and cannot be 350"]),
        (with("<Real start=\"200\"/>", "<String start=\"200\"/>"), &["is not a single number or truth value"]),
        (unit_with(&xml, 2, b"not a library"), &[]),
    ];
    for (content, phrases) in cases.iter().filter(|(_, phrases)| !phrases.is_empty()) {
        folder.file("tissue.fmu", content);
        folder.refused(&["run", "scenario.toml"], phrases);
        folder.refused(&["check", "scenario.toml"], &[phrases[0]]);
    }
    folder.refused(&["run", "scenario.toml", "--set", "tissue.fmu.file=none.fmu"], &["none.fmu: cannot be read"]);
    folder.refused(
        &["run", "scenario.toml", "--set", "tissue.fmu.file=builtin:in_vivo_like.csv"],
        &["not a file on disk"],
    );
    folder.file("tissue.fmu", unit(2, Fault::None));
    for (written, phrase) in [
        ("k", "must be name = number"),
        ("k = soft", "must be name = number"),
        ("k = nan", "cannot be NaN"),
        ("layers = 1.5", "cannot be 1.5"),
        ("f = 1", "cannot be set"),
        ("name = 1", "is not a single number"),
    ] {
        folder.refused(&["run", "scenario.toml", "--set", &format!("tissue.fmu.parameters=\"{written}\"")], &[phrase]);
    }
    let without = insertion("kind = \"fmu\"\n");
    folder.file("scenario.toml", without);
    folder.refused(&["run", "scenario.toml"], &["tissue.fmu.file is missing", "scenario.toml:6"]);
}

#[test]
fn a_path_that_leads_out_of_the_container_is_not_written() {
    let folder = TestFolder::new();
    folder.file("scenario.toml", insertion(OF_UNIT));
    let marked = format!("trocar-zip-slip-{}", std::process::id());
    let outside = std::env::temp_dir().join(&marked);
    for path in
        [format!("../{marked}"), format!("resources/../../{marked}"), outside.display().to_string(), "..\\x".into()]
    {
        let content =
            container(&[("modelDescription.xml", description(3).as_bytes()), (&path, b"x"), (&place(3), b"x")]);
        folder.file("tissue.fmu", content);
        let outcome = folder.trocar(&["check", "scenario.toml"]);
        // Packing or unpacking removes the root of an absolute path, so that the path stays inside.
        assert!(
            outcome.code == 2 && outcome.err.contains("leads out of it") || path.starts_with('/'),
            "{path}: {}",
            outcome.err
        );
        assert!(!outside.exists(), "{path}");
    }
    let mut zip = ZipWriter::new(Cursor::new(vec![]));
    zip.add_symlink("resources", "/tmp", SimpleFileOptions::default()).expect("a link");
    folder.file("tissue.fmu", zip.finish().expect("finished").into_inner());
    folder.refused(&["check", "scenario.toml"], &["leads out of it"]);
}

#[test]
fn a_check_executes_nothing_and_a_run_reports_what_cannot_be_loaded() {
    let folder = TestFolder::new();
    folder.file("scenario.toml", insertion(OF_UNIT));
    folder.file("tissue.fmu", unit_with(&description(3), 3, b"not a library"));
    folder.good(&["check", "scenario.toml"]);
    folder.refused(&["run", "scenario.toml"], &["its library cannot be loaded", "scenario.toml:8"]);
    // The library has the functions of the other version of the standard.
    folder.file("tissue.fmu", unit_with(&description(3), 3, &library(2, Fault::None)));
    folder.refused(&["run", "scenario.toml"], &["its library has no function fmi3InstantiateCoSimulation"]);
}

#[test]
fn a_comparison_and_a_sweep_give_the_same_numbers_as_the_built_in_model() {
    let folder = TestFolder::new();
    let sweep = "base = \"scenario.toml\"\n[axes.scaling]\nforce = [0.5, 0.8, 1.0, 1.2]\n";
    folder.file("tissue.fmu", unit(3, Fault::None)).file("sweep.toml", sweep);
    let table = |tissue: &str| {
        folder.file("scenario.toml", insertion(tissue));
        folder.good(&["sweep", "sweep.toml", "--out", "swept", "--quiet", "--overwrite"]);
        folder.text("swept/sweep/cases.csv")
    };
    assert_eq!(table(OF_UNIT), table(BUILT_IN));
    folder
        .file("one.toml", insertion(OF_UNIT))
        .file("two.toml", insertion(OF_UNIT).replace("\"insertion\"", "\"two\""));
    let compared = folder.good(&["compare", "one.toml", "two.toml", "--json"]);
    assert!(compared.contains("\"two\""), "{compared}");
    // Lanes of one engine need an instance each, but a process may have only one.
    let single = description(3).replace(
        "modelIdentifier=\"tissue\"",
        "modelIdentifier=\"tissue\" canBeInstantiatedOnlyOncePerProcess=\"true\"",
    );
    folder.file("tissue.fmu", unit_with(&single, 3, &library(3, Fault::None)));
    folder.good(&["run", "one.toml", "two.toml", "--out", "out", "--quiet"]);
    let swept = folder.trocar(&["sweep", "sweep.toml", "--out", "again", "--quiet", "--threads", "1"]);
    assert_eq!(swept.code, 0, "{}", swept.err);
}

#[test]
fn stability_reports_that_it_leaves_out_the_tissue_of_a_unit() {
    let folder = TestFolder::new();
    folder.file("scenario.toml", insertion(OF_UNIT)).file("tissue.fmu", unit(3, Fault::None));
    let text = folder.good(&["stability", "scenario.toml"]);
    assert!(text.contains("stability unknown: the analysis leaves out a tissue"), "{text}");
}

#[test]
fn the_temporary_folder_is_removed() {
    let folder = TestFolder::new();
    folder.file("scenario.toml", insertion(OF_UNIT)).file("tissue.fmu", unit(2, Fault::None));
    std::fs::create_dir(folder.path("temporary")).expect("created");
    let temporary = folder.path("temporary");
    folder.command(&["run", "scenario.toml", "--quiet"]).env("TMPDIR", &temporary).assert().success();
    assert_eq!(crate::support::test_folder::files_below(&temporary), Vec::<std::path::PathBuf>::new());
    assert!(std::fs::read_dir(Path::new(&temporary)).expect("a folder").next().is_none());
}
