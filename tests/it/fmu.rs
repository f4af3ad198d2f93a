//! Functional mock-up units (FMUs): an instance gives the commands of the Rust controller and the signals of a run,
//! and reports errors. `python/tests/test_fmu.py` runs the packed FMUs with FMPy.

use std::path::PathBuf;

use trocar::rig::{HapticController, Sample, Settings};
use trocar::run::run;
use trocar::scenario::{Scenario, Source};
use trocar_fmu::{Instance, InstanceError};
use trocar_studies::fmu::{Causality, Model, Scalar, Type, Unit, Variable, Version};

use crate::support::{file, table, test_folder::TestFolder};

/// An unpacked FMU without a library.
struct Unpacked {
    folder: TestFolder,
    token: String,
    variables: Vec<Variable>,
}

impl Unpacked {
    fn of(text: &str, model: Model, version: Version) -> Self {
        let source = Source::Text { name: "scenario".into(), text: text.into() };
        let unit = Unit::new(&source, &[], (model, version), vec![]).expect("a unit");
        let folder = TestFolder::new();
        for (path, content) in unit.files {
            folder.file(&path, content);
        }
        let description = folder.text("modelDescription.xml");
        let attribute = if version == Version::Two { "guid=\"" } else { "instantiationToken=\"" };
        let token =
            description.split(attribute).nth(1).and_then(|rest| rest.split('"').next()).expect("a token").to_owned();
        let variables = model.variables(&Scenario::load(&source, &[]).expect("loads"));
        Self { folder, token, variables }
    }

    fn resources(&self) -> PathBuf {
        self.folder.path("resources")
    }

    fn instance(&self) -> Instance {
        Instance::load(&self.resources(), &self.token).expect("its own token")
    }

    fn reference(&self, name: &str) -> u32 {
        self.variables
            .iter()
            .find(|variable| variable.name == name)
            .unwrap_or_else(|| panic!("{name} is a variable"))
            .reference
    }

    fn set(&self, instance: &mut Instance, name: &str, value: Scalar) {
        instance.set(self.reference(name), "any", value).expect("can be set");
    }

    /// Returns the bits of the outputs with a name.
    fn bits(&self, instance: &Instance, name: &str) -> u64 {
        match instance.get(self.reference(name), "any").expect("a variable") {
            Scalar::Real(value) => value.to_bits(),
            Scalar::Integer(value) => value as u64,
            Scalar::Boolean(value) => u64::from(value),
        }
    }
}

/// Runs a step from the present time.
fn advance(instance: &mut Instance, step_s: f64) -> Result<(), InstanceError> {
    instance.step(instance.time_s().unwrap_or(0.0), step_s)
}

/// The outputs of a rig's FMU.
const COMMANDS: [&str; 12] = [
    "slave_reference_m",
    "master_force_n",
    "allowed_force_step_n",
    "stiffness_n_per_m",
    "damping_n_s_per_m",
    "predicted_force_n",
    "residual_n",
    "distance",
    "decision",
    "mode",
    "alarm",
    "faulty_samples",
];

/// Compares a rig's FMU with the Rust controller, sample by sample. Returns the number of alarms.
fn assert_same_commands(unit: &Unpacked, settings: &Settings, samples: &[Sample]) -> u64 {
    let mut instance = unit.instance();
    instance.initialise().expect("its own parameters");
    let mut controller = HapticController::new(settings).expect("valid");
    let mut alarms = 0;
    for (k, sample) in samples.iter().enumerate() {
        let Sample { master_position_m, slave_position_m, slave_velocity_m_per_s, force_n } = *sample;
        unit.set(&mut instance, "sample.master_position_m", Scalar::Real(master_position_m));
        unit.set(&mut instance, "sample.slave_position_m", Scalar::Real(slave_position_m));
        unit.set(&mut instance, "sample.slave_velocity_m_per_s", Scalar::Real(slave_velocity_m_per_s));
        unit.set(&mut instance, "sample.force_n", Scalar::Real(force_n));
        advance(&mut instance, settings.tick_s).expect("a tick");
        let command = controller.step(sample);
        let expected = [
            command.slave_reference_m.to_bits(),
            command.master_force_n.to_bits(),
            command.allowed_force_step_n.to_bits(),
            command.stiffness_n_per_m.to_bits(),
            command.damping_n_s_per_m.to_bits(),
            command.predicted_force_n.to_bits(),
            command.residual_n.to_bits(),
            command.distance.to_bits(),
            command.decision.to_bits(),
            u64::from(command.mode.code()),
            u64::from(command.alarm),
            u64::from(command.faulty_samples),
        ];
        let found = COMMANDS.map(|name| unit.bits(&instance, &format!("command.{name}")));
        assert_eq!(found, expected, "sample {k}: {command:?}");
        alarms += u64::from(command.alarm);
    }
    alarms
}

fn recorded(path: &str, torque: &str) -> Vec<Sample> {
    let columns = table(path);
    let slave = &columns["xs_rad"];
    let master = columns.get("xm_rad").unwrap_or(slave);
    let sample = |k: usize| Sample {
        master_position_m: 0.075 * master[k],
        slave_position_m: 0.075 * slave[k],
        slave_velocity_m_per_s: 0.075 * columns["vs_rad_s"][k],
        force_n: columns[torque][k] / 0.075,
    };
    (0..slave.len()).map(sample).collect()
}

#[test]
fn a_rigs_unit_gives_the_commands_of_rust_on_recordings() {
    for (path, torque, contact_m, alarms) in [
        ("scenarios/recordings/own_ctrl_pop.csv", "env_out_Nm_derived", 6.3e-3, 1),
        ("tests/data/teleop_1dof/m2_f_spring.csv", "tau_e_Nm", -9e-3, 0),
        ("tests/data/teleop_1dof/m2_d_free_motion.csv", "tau_e_Nm", 0.0, 0),
    ] {
        let text = format!(
            "simulation.tick_s = 5e-4\nestimator.contact_m = {contact_m}\noperator.kind = \"ramp\"\ntissue.kind = \"kelvin-voigt\"\n"
        );
        let unit = Unpacked::of(&text, Model::Rig, Version::Three);
        let source = Source::Text { name: "same".into(), text: text.into() };
        let settings = Scenario::load(&source, &[]).expect("loads").rig_settings();
        assert_eq!(assert_same_commands(&unit, &settings, &recorded(path, torque)), alarms, "{path}");
    }
}

#[test]
fn a_rigs_unit_gives_the_commands_of_rust_on_the_augmented_insertion() {
    let unit = Unpacked::of("base = \"builtin:paper/augmented\"\n", Model::Rig, Version::Two);
    let scenario = Scenario::load(&Source::parse("paper/augmented"), &[]).expect("loads");
    let settings = scenario.rig_settings();
    let trace = run(scenario).expect("runs").trace;
    let sample = |k: usize| Sample {
        master_position_m: trace.master_position_m[k],
        slave_position_m: trace.slave_position_m[k],
        slave_velocity_m_per_s: trace.slave_velocity_m_per_s[k],
        force_n: trace.measured_force_n[k],
    };
    let samples: Vec<Sample> = (0..trace.len()).map(sample).collect();
    assert!(assert_same_commands(&unit, &settings, &samples) >= 2);
}

/// A run of half a second through a surface.
const SHORT: &str = "base = \"builtin:layers/skin-augmented\"\nsimulation.duration_s = 0.5\n";

/// An insertion through the skin.
const LAYERED: &str = "base = \"builtin:layers/skin-augmented\"\nsimulation.duration_s = 4.0\n";

#[test]
fn a_simulations_unit_with_the_scenarios_operator_equals_the_run() {
    let unit = Unpacked::of(SHORT, Model::Simulation, Version::Three);
    let source = Source::Text { name: "same".into(), text: SHORT.into() };
    let trace = run(Scenario::load(&source, &[]).expect("loads")).expect("runs").trace;
    let mut instance = unit.instance();
    instance.initialise().expect("its own parameters");
    for k in 0..trace.len() {
        assert!(!instance.has_ended(), "tick {k}");
        advance(&mut instance, 1e-3).expect("a tick");
        assert_eq!(unit.bits(&instance, "slave_position_m"), trace.slave_position_m[k].to_bits(), "tick {k}");
        assert_eq!(unit.bits(&instance, "feedback_force_n"), trace.feedback_force_n[k].to_bits(), "tick {k}");
        assert_eq!(unit.bits(&instance, "mode"), u64::from(trace.mode[k]), "tick {k}");
    }
    assert!(instance.has_ended());
    let error = advance(&mut instance, 1e-3).expect_err("the scenario ends").to_string();
    assert!(error.contains("500 ticks") && error.contains("simulation.duration_s"), "{error}");
}

#[test]
fn an_operator_with_a_given_position_follows_it() {
    let unit = Unpacked::of(SHORT, Model::Simulation, Version::Two);
    let mut instance = unit.instance();
    instance.initialise().expect("its own parameters");
    unit.set(&mut instance, "person.is_led", Scalar::Boolean(true));
    unit.set(&mut instance, "person.position_m", Scalar::Real(-0.01));
    advance(&mut instance, 0.4).expect("400 ticks");
    let desired = instance.get(unit.reference("desired_position_m"), "any").expect("an output");
    assert_eq!(desired, Scalar::Real(-0.01));
}

#[test]
fn derived_values_follow_a_changed_parameter_and_an_unchanged_parameter_has_no_effect() {
    let unit = Unpacked::of("base = \"builtin:paper/augmented\"\n", Model::Rig, Version::Three);
    let (mut plain, mut all_set, mut wider) = (unit.instance(), unit.instance(), unit.instance());
    for variable in unit.variables.iter().filter(|variable| variable.causality == Causality::Parameter) {
        all_set.set(variable.reference, "any", variable.start).expect("its start");
    }
    unit.set(&mut wider, "detector.rupture_std_n", Scalar::Real(0.4));
    unit.set(&mut wider, "rig.force_limit_n", Scalar::Real(2.0));
    let source = Source::parse("paper/augmented");
    let scenario = Scenario::load(&source, &["detector.rupture_std_n=0.4".into()]).expect("loads");
    let mut settings = scenario.rig_settings();
    settings.limits.force_n = 2.0;
    let mut controllers = [
        HapticController::new(&Scenario::load(&source, &[]).expect("loads").rig_settings()).expect("valid"),
        HapticController::new(&settings).expect("valid"),
    ];
    for instance in [&mut plain, &mut all_set, &mut wider] {
        instance.initialise().expect("in range");
    }
    for k in 0..500 {
        let depth = 1e-5 * f64::from(k);
        let force_n = if k < 400 { 300.0 * depth + 1.5 } else { 0.5 };
        let sample =
            Sample { master_position_m: depth, slave_position_m: depth, slave_velocity_m_per_s: 0.01, force_n };
        let [expected, of_wider] = controllers.each_mut().map(|controller| controller.step(&sample));
        for (instance, expected) in [(&mut plain, &expected), (&mut all_set, &expected), (&mut wider, &of_wider)] {
            for (name, value) in [
                ("sample.master_position_m", depth),
                ("sample.slave_position_m", depth),
                ("sample.slave_velocity_m_per_s", 0.01),
                ("sample.force_n", force_n),
            ] {
                unit.set(instance, name, Scalar::Real(value));
            }
            advance(instance, 1e-3).expect("a tick");
            assert_eq!(unit.bits(instance, "command.decision"), expected.decision.to_bits(), "sample {k}");
            assert_eq!(unit.bits(instance, "command.faulty_samples"), u64::from(expected.faulty_samples), "sample {k}");
        }
        assert!(k < 300 || of_wider.faulty_samples > 0 || force_n < 2.0, "the limit is the changed one");
    }
}

#[test]
fn a_tissues_unit_gives_the_forces_of_the_run() {
    let unit = Unpacked::of(LAYERED, Model::Tissue, Version::Three);
    let source = Source::Text { name: "same".into(), text: LAYERED.into() };
    let found = run(Scenario::load(&source, &[]).expect("loads")).expect("runs");
    let trace = &found.trace;
    let mut instance = unit.instance();
    instance.initialise().expect("its own parameters");
    let mut ruptures = vec![];
    for k in 0..trace.len() {
        unit.set(&mut instance, "needle.position_m", Scalar::Real(trace.slave_position_m[k]));
        unit.set(&mut instance, "needle.velocity_m_per_s", Scalar::Real(trace.slave_velocity_m_per_s[k]));
        advance(&mut instance, 1e-3).expect("a tick");
        assert_eq!(unit.bits(&instance, "reaction.force_n"), trace.tissue_force_n[k].to_bits(), "tick {k}");
        if unit.bits(&instance, "reaction.ruptured") == 1 {
            ruptures.push(trace.time_s[k]);
        }
    }
    let expected: Vec<f64> = found.metrics.ruptures.iter().map(|rupture| rupture.time_s).collect();
    assert!(!expected.is_empty());
    assert_eq!(ruptures, expected);
    let names: Vec<&str> = unit.variables.iter().map(|variable| &*variable.name).collect();
    assert!(names.contains(&"tissue.layer.skin.stiffness_n_per_m") && !names.contains(&"scaling.force"), "{names:?}");
}

/// Steps an FMU through `ticks` ticks from `first` on. Returns the bits of an output after each tick.
fn stepped(
    unit: &Unpacked,
    instance: &mut Instance,
    (input, output): (&str, &str),
    first: u32,
    ticks: u32,
) -> Vec<u64> {
    let each = (first..first + ticks).map(|k| {
        // A motion with ripples, so that each tick differs.
        unit.set(instance, input, Scalar::Real(1e-5 * f64::from(k) + 1e-6 * f64::from(k % 7)));
        advance(instance, 1e-3).expect("a tick");
        unit.bits(instance, output)
    });
    each.collect()
}

#[test]
fn a_restored_state_gives_the_same_outputs_again() {
    for (text, model, signals) in [
        (SHORT, Model::Rig, ("sample.slave_position_m", "command.stiffness_n_per_m")),
        (SHORT, Model::Simulation, ("person.position_m", "feedback_force_n")),
        (LAYERED, Model::Tissue, ("needle.position_m", "reaction.force_n")),
    ] {
        let unit = Unpacked::of(text, model, Version::Two);
        let mut instance = unit.instance();
        let fresh = instance.save();
        instance.initialise().expect("its own parameters");
        if model == Model::Simulation {
            unit.set(&mut instance, "person.is_led", Scalar::Boolean(true));
        }
        stepped(&unit, &mut instance, signals, 0, 200);
        let state = instance.save();
        let expected = stepped(&unit, &mut instance, signals, 200, 100);
        stepped(&unit, &mut instance, signals, 0, 50);
        for _ in 0..2 {
            instance.restore(&state).expect("restored");
            assert_eq!(stepped(&unit, &mut instance, signals, 200, 100), expected, "{model:?}");
        }
        instance.restore(&fresh).expect("restored");
        assert!(advance(&mut instance, 1e-3).is_err(), "not initialised");
    }
}

#[test]
fn a_step_continues_where_the_last_one_has_ended() {
    let unit = Unpacked::of(SHORT, Model::Simulation, Version::Two);
    let mut instance = unit.instance();
    instance.initialise().expect("its own parameters");
    assert_eq!(instance.time_s(), None);
    instance.step(2.0, 0.1).expect("the first communication point may be any");
    let error = instance.step(2.5, 1e-3).expect_err("a jump").to_string();
    assert!(error.contains("begins at 2.5 s") && error.contains("continue from there"), "{error}");
    let state = instance.save();
    instance.step(2.1, 0.1).expect("continues");
    instance.restore(&state).expect("restored");
    instance.step(2.1, 0.1).expect("continues from the restored state");
    // 300 ticks are left: the ticks before the end are done.
    let error = instance.step(2.2, 0.4).expect_err("beyond the end").to_string();
    assert!(error.contains("500 ticks"), "{error}");
    assert!(instance.has_ended() && instance.time_s().is_some_and(|time_s| (time_s - 2.5).abs() < 1e-9));
}

#[test]
fn a_stop_of_a_rigs_unit_holds_until_it_is_false_again() {
    let unit =
        Unpacked::of("estimator.contact_m = 0.0\nbase = \"builtin:paper/augmented\"\n", Model::Rig, Version::Two);
    let mut instance = unit.instance();
    instance.initialise().expect("its own parameters");
    let mut state_after = |stop: bool| {
        unit.set(&mut instance, "sample.stop", Scalar::Boolean(stop));
        advance(&mut instance, 1e-3).expect("a tick");
        unit.bits(&instance, "command.state")
    };
    assert_eq!([false, true, true, false].map(&mut state_after), [2, 0, 0, 2]);
}

#[test]
fn a_unit_reports_what_it_refuses() {
    let unit = Unpacked::of(SHORT, Model::Simulation, Version::Three);
    let mut instance = unit.instance();
    let error = advance(&mut instance, 1e-3).expect_err("not initialised").to_string();
    assert!(error.contains("initialised"), "{error}");
    let reference = unit.reference("scaling.force");
    let error = instance.set(reference, "Int64", Scalar::Integer(1)).expect_err("a number").to_string();
    assert_eq!(error, format!("there is no Int64 variable with the reference {reference}"));
    assert!(instance.get(99_999, "Float64").is_err());
    let mode = unit.reference("mode");
    let error = instance.set(mode, "Int64", Scalar::Integer(1)).expect_err("an output").to_string();
    assert_eq!(error, "mode cannot be set as it is an output");
    let architecture = unit.reference("controller.kind");
    let error = instance.set(architecture, "Int64", Scalar::Integer(-1)).expect_err("no word").to_string();
    assert!(error.starts_with("controller.kind is -1, must be from 0 to "), "{error}");
    instance.set(reference, "Float64", Scalar::Real(-1.0)).expect("checked at the initialisation");
    let error = instance.initialise().expect_err("out of range").to_string();
    assert!(error.contains("scaling.force"), "{error}");
    instance.reset();
    instance.initialise().expect("the defaults again");
    let error = instance.set(reference, "Float64", Scalar::Real(1.0)).expect_err("it runs").to_string();
    assert_eq!(error, "scaling.force cannot be set after the initialisation");
    let error = advance(&mut instance, 1.5e-3).expect_err("a tick and a half").to_string();
    assert!(error.contains("0.0015 s is not a whole number of ticks of 0.001 s"), "{error}");

    let error = Instance::load(&unit.resources(), "{another}").expect_err("foreign").to_string();
    assert!(error.contains("export the unit again"), "{error}");
    let error = Instance::load(&file("docs"), &unit.token).expect_err("no scenario").to_string();
    assert!(error.contains("no rig.toml, simulation.toml or tissue.toml"), "{error}");
}

#[test]
fn every_parameter_has_a_meaning_and_numbers_their_range() {
    for (model, at_least) in [(Model::Rig, 40), (Model::Simulation, 80)] {
        let unit = Unpacked::of("base = \"builtin:paper/augmented\"\n", model, Version::Three);
        let parameters: Vec<_> =
            unit.variables.iter().filter(|variable| variable.causality == Causality::Parameter).collect();
        assert!(parameters.len() > at_least, "{}", parameters.len());
        for Variable { name, kind, meaning, .. } in parameters {
            assert!(!meaning.is_empty() && *kind != Type::Real(None), "{name}: {kind:?}");
        }
    }
}

#[test]
fn the_unit_contains_the_files_of_the_scenario() {
    let folder = TestFolder::new();
    let recording = std::fs::read(file("scenarios/recordings/in_vivo_like.csv")).expect("shipped");
    folder.file("mine/force.csv", &recording);
    let text = "base = \"builtin:paper/classical\"\n[recording]\nfile = \"force.csv\"\n";
    folder.file("mine/scenario.toml", text);
    let source = Source::Disk(folder.path("mine/scenario.toml"));
    let unit = Unit::new(&source, &[], (Model::Simulation, Version::Three), vec![]).expect("a unit");
    let packed = unit.files.iter().find(|(path, _)| path == "resources/recording_file_force.csv");
    assert_eq!(packed.map(|(_, content)| content), Some(&recording));
    let elsewhere = TestFolder::new();
    for (path, content) in &unit.files {
        elsewhere.file(path, content);
    }
    drop(folder);
    let moved = Source::Disk(elsewhere.path("resources/simulation.toml"));
    assert!(Scenario::load(&moved, &[]).is_ok());
}

#[test]
fn the_command_reports_what_is_missing() {
    let folder = TestFolder::new();
    let outcome = folder.trocar(&["export", "fmu", "paper/augmented", "--library", "none.so"]);
    assert_eq!(outcome.code, 2);
    assert!(
        outcome.err.contains("none.so") && outcome.err.contains("run `cargo build --release`, which builds"),
        "{}",
        outcome.err
    );
    folder.file("library.so", "not a library, but the command does not run it");
    let arguments =
        ["export", "fmu", "paper/augmented", "--rig", "--fmi", "2", "--library", "library.so", "--out", "rig.fmu"];
    let out = folder.good(&arguments);
    assert_eq!(out, "rig.fmu: the controller of a rig, FMI 2.0, 6 files\n");
    assert!(std::fs::read(folder.path("rig.fmu")).expect("written").starts_with(b"PK"));
    let outcome = folder.trocar(&arguments);
    assert_eq!(outcome.code, 2, "it exists");
    let hunt = "--set=estimator.parameters=hunt-crossley";
    let outcome = folder.trocar(&["export", "fmu", "paper/augmented", "--rig", hunt, "--library", "library.so"]);
    assert_eq!(outcome.code, 2);
    assert!(outcome.err.contains("estimator.parameters") && outcome.err.contains("without --rig"), "{}", outcome.err);
}
