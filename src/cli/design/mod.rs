mod bars;
mod help;

use clap::Args;

use self::bars::Bars;
use super::error::Failure;
use super::finish::Finish;
use super::warnings::Warnings;
use super::{OutputArgs, interrupt, report as page};
use trocar_document::Study as _;
use trocar_report::html::{Again, command_line};
use trocar_report::{Folder, OutputError, write_file};
use trocar_scenario::Source;
use trocar_studies::design::{Design, DesignError, Problem, Stage, State};
use trocar_studies::run::seeds_without_effect;

/// All inputs, and the state of the search.
const DESIGN: &str = "design.toml";
const SEARCH: &str = "search.json";

/// Find the settings that are best for a group of patients.
#[derive(Debug, Args)]
#[command(after_long_help = help::text(), mut_arg("out", |arg| arg.help("Folder for the files; it contains one folder per design")))]
pub(super) struct DesignArgs {
    /// The design file
    #[arg(value_name = "FILE")]
    file: String,
    /// Override a key of the base scenario, as in --set simulation.duration_s=7 (repeatable; the last value applies)
    #[arg(long = "set", value_name = "SECTION.KEY=VALUE")]
    settings: Vec<String>,
    /// Number of threads [default: one per processor]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Replace the search of another design in the same folder
    #[arg(long)]
    overwrite: bool,
    /// Also write report.html: one self-contained page with the front, the tables and the settings
    #[arg(long)]
    report: bool,
    #[command(flatten)]
    output: OutputArgs,
}

pub(super) fn run(args: &DesignArgs) -> Result<(), Failure> {
    let threads = args.threads.map_or_else(rayon::current_num_threads, usize::from);
    match rayon::ThreadPoolBuilder::new().num_threads(threads).build() {
        Ok(pool) => pool.install(|| design(args)),
        Err(_) => design(args),
    }
}

fn design(args: &DesignArgs) -> Result<(), Failure> {
    let problem = Problem::load(&Source::parse(&args.file), &args.settings)?;
    let folder = args.output.destination().open("design", &problem.name)?;
    let warnings = Warnings::new(&args.output);
    warnings.print(&unused_seeds(&problem)?);
    let mut state = stored(args, &folder, &problem)?;
    write_file(&folder.path.join(DESIGN), problem.canonical().as_bytes())?;
    let follower = Bars::new(&folder, args.output.quiet);
    let designed = Design::of(&problem, &mut state, interrupt::stop_flag(), &follower);
    follower.clear();
    let design = designed.map_err(|error| failed(error, &folder, &problem))?;
    let study = design.study(&problem, &state);
    let document = study.document();
    let again = || Again {
        command: "trocar design",
        files: vec![(DESIGN.to_owned(), problem.canonical().to_owned())],
        note: "Run this command in the folder of the design's file.",
        line: command_line(
            ["design".to_owned(), page::shown(&args.file)]
                .into_iter()
                .chain(page::set_flags(&args.settings))
                .chain(["--report".to_owned()]),
        ),
    };
    folder.write(DESIGN, problem.canonical().as_bytes())?;
    Finish { output: &args.output, folder, all: false, report: args.report.then(again) }.document(&document)?;
    warnings.finish()
}

/// An interrupted design says what was kept.
fn failed(error: DesignError<OutputError>, folder: &Folder, problem: &Problem) -> Failure {
    let kept = match error {
        DesignError::Run(error) => return error.into(),
        DesignError::Keep(error) => return error.into(),
        DesignError::Stopped(Stage::Generation(generation)) => {
            format!("{} of {} generations are", generation - 1, problem.search.generations)
        }
        DesignError::Stopped(Stage::Certificates) => "the search and the certificates so far are".to_owned(),
        DesignError::Stopped(Stage::OtherPatients) => "the search is".to_owned(),
    };
    Failure::interrupted(&format!("{kept} kept in {}; run the same command to continue", folder.path.display()))
}

/// The warning that several seeds give identical runs.
fn unused_seeds(problem: &Problem) -> Result<Vec<trocar_base::warning::Warning>, Failure> {
    let scenario = problem.example()?;
    Ok(if scenario.has_random_numbers() {
        vec![]
    } else {
        seeds_without_effect(&[scenario], problem.validation.seeds.max(problem.training.seeds))
    })
}

/// The stored state of the search, or that before its first generation. The search of another design is an error.
fn stored(args: &DesignArgs, folder: &Folder, problem: &Problem) -> Result<State, Failure> {
    let read = |name: &str| std::fs::read_to_string(folder.path.join(name)).ok();
    let canonical = problem.canonical();
    match read(DESIGN).filter(|existing| existing != canonical) {
        Some(existing) if !args.overwrite && read(SEARCH).is_some() => {
            let difference = trocar_studies::sweep::difference(&existing, canonical);
            return Err(Failure::input(format!(
                "{} holds the search of another design, or of the same one before a change:\n{difference}give another \
                 --out, or --overwrite to replace it",
                folder.path.display()
            )));
        }
        Some(_) => {
            // The search goes first, so that an interruption is harmless.
            let _ = std::fs::remove_file(folder.path.join(SEARCH));
        }
        None => {}
    }
    let state = read(SEARCH).and_then(|text| State::stored(&text, problem));
    if let Some(state) = state.as_ref().filter(|state| state.generations > 0 && !args.output.quiet) {
        anstream::eprintln!(
            "continuing after generation {} of {}, from {}",
            state.generations,
            problem.search.generations,
            folder.path.join(SEARCH).display()
        );
    }
    Ok(state.unwrap_or_else(|| State::new(problem)))
}
