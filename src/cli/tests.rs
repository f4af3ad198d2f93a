//! The command line: accepted arguments, defaults, errors and exit codes.

use clap::CommandFactory as _;

use super::error::Kind;
use super::*;
use trocar_base::warning::{Code, Warning};
use trocar_core::error::InvalidValue;
use trocar_stability::StabilityError;
use trocar_studies::sweep::SweepError;

fn parsed(words: &[&str]) -> Command {
    let all = std::iter::once(&"trocar").chain(words);
    Cli::try_parse_from(all).unwrap_or_else(|error| panic!("{words:?}: {error}")).command
}

fn refused(words: &[&str]) -> String {
    let all = std::iter::once(&"trocar").chain(words);
    match Cli::try_parse_from(all) {
        Ok(_) => panic!("{words:?} is accepted"),
        Err(error) => error.to_string(),
    }
}

#[test]
fn the_definition_of_the_command_line_is_consistent() {
    Cli::command().debug_assert();
}

#[test]
fn invalid_arguments_are_refused_with_a_hint() {
    assert!(refused(&["comparee"]).contains("'compare'"));
    assert!(refused(&["run", "a.toml", "--quite"]).contains("'--quiet'"));
    assert!(refused(&["run", "a.toml", "--format", "cvs"]).contains("csv"));
    assert!(refused(&["run", "a.toml", "--figure-width", "wide"]).contains("--figure-width"));
    assert!(refused(&["sweep", "a.toml", "--threads", "0"]).contains("1..=1024"));
}

#[test]
fn a_schema_has_one_kind() {
    assert!(matches!(parsed(&["schema", "roc"]), Command::Schema(_)));
    assert!(refused(&["schema", "rok"]).contains("'roc'"));
}

fn scenario_error() -> ScenarioError {
    let settings = ["no.such_key=1".to_owned()];
    Scenario::load(&Source::parse("paper/classical"), &settings).expect_err("an unknown key")
}

fn failure(words: &[&str]) -> Failure {
    execute(parsed(words)).expect_err("a failure")
}

fn long_sweep() -> Failure {
    let Command::Sweep(args) = parsed(&["sweep", "a.toml"]) else { panic!("a sweep") };
    sweep::announce(&args, 7200.0, 12).expect_err("more than an hour")
}

fn denied(count: usize) -> Failure {
    let command = OutputArgs::augment_args(clap::Command::new("x"));
    let matches = command.get_matches_from(["x", "--quiet", "--deny-warnings"]);
    let warnings = warnings::Warnings::new(&OutputArgs::from_arg_matches(&matches).expect("valid"));
    warnings.print(&vec![Warning::new(Code::GuessedColumns, "x"); count]);
    warnings.finish().expect_err("--deny-warnings")
}

fn code(error: &Failure) -> String {
    format!("{:?}", error.report())
}

#[test]
fn invalid_input_ends_with_2_a_failure_with_1_and_an_interruption_with_130() {
    let setting = || InvalidValue { name: "x", value: 1.0, requirement: "below 0", item: None };
    let input = [
        scenario_error().into(),
        setting().into(),
        failure(&["run", "paper/classical", "paper/classical"]),
        failure(&["roc", "paper/classical", "--drop-n", "1"]),
        failure(&["init", "Cargo.toml"]),
        long_sweep(),
        failure(&["sweep", "scenarios/sweeps/small.toml", "--case", "1000000"]),
        failure(&["stability", "--x", "x"]),
        failure(&["explain", "x"]),
        failure(&["export", "fmu", "paper/augmented", "--library", "no/such"]),
        failure(&["detect", "src"]),
        failure(&["link", "master", "paper/augmented", "--to", "x"]),
        StabilityError::Parameter(setting()).into(),
    ];
    for error in &input {
        assert!(error.kind == Kind::Input && code(error) == format!("{:?}", ExitCode::from(2)), "{error:?}");
    }
    let failures = [denied(1), terminal::failed(std::io::ErrorKind::NotFound.into())];
    for error in &failures {
        assert!(error.kind == Kind::Work && code(error) == format!("{:?}", ExitCode::FAILURE), "{error:?}");
    }
    let interrupted = Failure::interrupted("nothing was written");
    assert_eq!(interrupted.kind, Kind::Interrupted);
    assert_eq!(code(&interrupted), format!("{:?}", ExitCode::from(130)));
}

#[test]
fn an_error_states_the_number_and_the_remedy() {
    let message = |words: &[&str]| failure(words).to_string();
    let same = |second: &str| message(&["run", "paper/classical", second]);
    assert!(same("paper/classical").ends_with("paper/classical is given twice; remove one"));
    let path = "scenarios/paper/classical.toml";
    assert!(same(path).contains(&format!("paper/classical and {path}; change the name")));
    assert_eq!(Failure::interrupted("3 cases").to_string(), "interrupted: 3 cases");
    assert!(denied(1).to_string().starts_with("1 warning, "));
    assert!(denied(2).to_string().starts_with("2 warnings, "));
    assert!(message(&["explain", "detector.treshold"]).ends_with("; did you mean detector.threshold?"));
    assert!(!message(&["explain", "qqqqqqqq"]).contains("mean"));
    let no_case = message(&["sweep", "scenarios/sweeps/small.toml", "--case", "1000000"]);
    assert!(no_case.contains("no case 1000000: it has "), "{no_case}");
    assert!(long_sweep().to_string().starts_with("12 cases take about 2.0 h; add --yes"));
}

#[test]
fn a_wrapped_error_is_reported_like_the_commands_own_error() {
    use trocar_studies::run::RunError;
    let wrapped: [Failure; 4] = [
        trocar_studies::roc::RocError::Scenario(scenario_error()).into(),
        SweepError::File(scenario_error()).into(),
        trocar_studies::stability_check::CheckError::Run(RunError::Scenario(scenario_error())).into(),
        trocar_studies::fmu::UnitError::Scenario(scenario_error()).into(),
    ];
    for error in &wrapped {
        assert!(error.kind == Kind::Input && error.scenario() == Some(&scenario_error()), "{error:?}");
    }
    let source = Box::new(RunError::Scenario(scenario_error()));
    let error = Failure::from(SweepError::Case { case: 3, values: "a = 1".into(), source });
    let message = &error.scenario().expect("with its place").message;
    assert!(message.starts_with("case 3 (a = 1): "), "{message}");
}

#[test]
fn scenarios_with_the_same_name_are_refused_and_an_error_names_its_file() {
    let load = |paths: &[&str], settings: &[&str]| {
        let settings = settings.iter().map(|setting| (*setting).to_owned()).collect();
        let paths: Vec<String> = paths.iter().map(|path| (*path).to_owned()).collect();
        ScenarioArgs { settings }.load(&paths)
    };
    let loaded = load(&["paper/classical", "paper/augmented"], &[]).expect("shipped scenarios");
    assert_eq!(loaded.iter().map(|scenario| scenario.name.as_str()).collect::<Vec<_>>(), ["classical", "augmented"]);
    let error = load(&["paper/classical", "paper/augmented", "paper/classical"], &[]).expect_err("twice");
    assert_eq!(
        error.to_string(),
        "two scenarios have the name \"classical\" and would write into the same folder: paper/classical is given twice; remove one"
    );
    let error = load(&["paper/classical", "no/such.toml"], &[]).expect_err("no file");
    assert!(error.to_string().contains("no/such.toml"), "{error}");
    let error = load(&["paper/classical"], &["scaling.force=2", "scaling.force=-3"]).expect_err("the last one applies");
    assert!(error.kind == Kind::Input && error.to_string().contains("-3"), "{error}");
}
