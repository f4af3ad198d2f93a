//! The command line: accepted arguments, defaults, errors and exit codes.

use clap::CommandFactory as _;

use super::error::{DetectError, LinkError};
use super::*;
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

fn code(error: &CliError) -> String {
    format!("{:?}", error.report())
}

#[test]
fn invalid_input_ends_with_2_a_failure_with_1_and_an_interruption_with_130() {
    let missing = || std::io::Error::from(std::io::ErrorKind::NotFound);
    let text = || "x".to_owned();
    let input = [
        CliError::Scenario(scenario_error()),
        CliError::Setting(InvalidValue { name: "x", value: 1.0, requirement: "below 0", item: None }),
        CliError::SameName { name: text(), first: text(), second: text() },
        CliError::OnlySynthetic,
        CliError::Exists { path: text() },
        CliError::LongSweep { cases: 9, about: text() },
        CliError::NoCase { case: 9, cases: 3 },
        CliError::Axis { axis: text(), reason: text() },
        CliError::Unknown { word: text(), nearest: None },
        CliError::NoLibrary { path: text(), source: missing() },
        CliError::Detect(DetectError::EmptyFolder { path: text() }),
        CliError::Link(LinkError::Address { address: text(), source: missing() }),
        CliError::Stability(StabilityError::Parameter(InvalidValue {
            name: "x",
            value: 1.0,
            requirement: "y",
            item: None,
        })),
    ];
    for error in &input {
        assert!(error.is_input() && code(error) == format!("{:?}", ExitCode::from(2)), "{error:?}");
    }
    let failures = [
        CliError::Warnings { count: 1 },
        CliError::Pack(missing()),
        CliError::Print(missing()),
        CliError::Link(LinkError::Differs),
        CliError::Link(LinkError::NotReady),
        CliError::Link(LinkError::NotReplayed),
        CliError::Link(LinkError::NoReply { address: text(), wait_s: 5 }),
    ];
    for error in &failures {
        assert!(!error.is_input() && code(error) == format!("{:?}", ExitCode::FAILURE), "{error:?}");
    }
    let interrupted = CliError::Interrupted { kept: None };
    assert!(!interrupted.is_input());
    assert_eq!(code(&interrupted), format!("{:?}", ExitCode::from(130)));
}

#[test]
fn an_error_states_the_number_and_the_remedy() {
    let message = |error: CliError| error.to_string();
    let same = |first: &str, second: &str| {
        message(CliError::SameName { name: "a".into(), first: first.into(), second: second.into() })
    };
    assert!(same("x.toml", "x.toml").ends_with("x.toml is given twice; remove one"));
    assert!(same("x.toml", "y.toml").contains("x.toml and y.toml; change the name"));
    assert_eq!(message(CliError::Interrupted { kept: None }), "interrupted: nothing was written");
    assert_eq!(message(CliError::Interrupted { kept: Some("3 cases".into()) }), "interrupted: 3 cases");
    assert!(message(CliError::Warnings { count: 1 }).starts_with("1 warning, "));
    assert!(message(CliError::Warnings { count: 2 }).starts_with("2 warnings, "));
    let unknown =
        |nearest: Option<&str>| message(CliError::Unknown { word: "x".into(), nearest: nearest.map(str::to_owned) });
    assert!(unknown(Some("y")).ends_with("; did you mean y?") && !unknown(None).contains("mean"));
    assert!(message(CliError::NoCase { case: 9, cases: 3 }).contains("no case 9: it has 3 cases"));
    assert!(
        message(CliError::LongSweep { cases: 12, about: "2 h".into() })
            .starts_with("12 cases take about 2 h; add --yes")
    );
}

#[test]
fn a_wrapped_error_is_reported_like_the_commands_own_error() {
    let error: CliError = trocar_studies::roc::RocError::Scenario(scenario_error()).into();
    assert!(matches!(error, CliError::Scenario(_)));
    let error: CliError = SweepError::File(scenario_error()).into();
    assert!(matches!(error, CliError::Scenario(_)));
    let source = Box::new(trocar_studies::run::RunError::Scenario(scenario_error()));
    let error: CliError = SweepError::Case { case: 3, values: "a = 1".into(), source }.into();
    let CliError::Scenario(error) = error else { panic!("{error:?}") };
    assert!(error.message.starts_with("case 3 (a = 1): "), "{}", error.message);
    let error: CliError =
        trocar_studies::stability_check::CheckError::Run(trocar_studies::run::RunError::Scenario(scenario_error()))
            .into();
    assert!(error.is_input(), "{error:?}");
    let error: CliError = trocar_studies::fmu::UnitError::Scenario(scenario_error()).into();
    assert!(matches!(error, CliError::Scenario(_)));
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
    assert!(error.is_input() && error.to_string().contains("-3"), "{error}");
}
