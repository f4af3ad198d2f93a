mod finish;
mod help;
mod merge;
mod stored;

use std::path::Path;

use clap::{Args, Subcommand};
use rayon::prelude::*;

use self::finish::{Whole, finish, report};
use self::stored::Stored;
use super::error::Failure;
use super::warnings::Warnings;
use super::{OutputArgs, interrupt, progress, report as page, terminal};
use trocar_document::{json_of, to_json};
use trocar_report::html::command_line;
use trocar_report::{Destination, Folder, write_file};
use trocar_scenario::{Scenario, Source};
use trocar_studies::run::seeds_without_effect;
use trocar_studies::sweep::{
    CASES, Execution, LoopOfCase, Manifest, Part, Plan, Progress, Rows, SWEEP, Shard, execute,
};

const WRITER: &str = "sweep";

/// In s, above which a sweep requires `--yes`.
const MAX_UNASKED_S: f64 = 3600.0;

/// Run a sweep, or join the parts of one.
#[derive(Debug, Args)]
#[command(args_conflicts_with_subcommands = true, after_long_help = help::text(), mut_arg("out", |arg| arg.help(super::OUT_PER_SWEEP)))]
pub(super) struct SweepArgs {
    #[command(subcommand)]
    command: Option<SweepCommand>,
    /// The sweep file
    #[arg(required = true, value_name = "FILE")]
    file: Option<String>,
    /// Override a key of the base scenario, as in --set simulation.duration_s=3 (repeatable; the last value applies)
    #[arg(long = "set", value_name = "SECTION.KEY=VALUE")]
    settings: Vec<String>,
    /// Run only the I-th of N parts, as in 3/8; `trocar sweep merge` joins the parts
    #[arg(long, value_name = "I/N")]
    shard: Option<Shard>,
    /// Number of threads [default: one per processor]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Replace the results of another sweep in the same folder
    #[arg(long)]
    overwrite: bool,
    /// Start a sweep that is estimated to take more than an hour
    #[arg(long)]
    yes: bool,
    /// Run every case separately; slower, with identical results. By default, cases that differ only in
    /// detector.threshold share a run if the threshold does not change it
    #[arg(long)]
    no_sharing: bool,
    /// Print a case as a scenario file, without running the sweep
    #[arg(long, value_name = "NUMBER")]
    case: Option<u64>,
    /// Also write report.html: one self-contained page with the metrics and their meaning, the influence of each
    /// axis, and the metrics in focus over the axes; for a sweep in shards, use --report with `merge`
    #[arg(long, conflicts_with = "shard")]
    report: bool,
    #[command(flatten)]
    output: OutputArgs,
}

#[derive(Debug, Subcommand)]
enum SweepCommand {
    /// Verify and join the parts of a sharded sweep
    ///
    /// The files are identical to those of a sweep without shards. Parts of another sweep, missing cases and
    /// duplicate cases are errors.
    Merge(merge::MergeArgs),
}

pub(super) fn run(args: &SweepArgs) -> Result<(), Failure> {
    match (&args.command, &args.file) {
        (Some(SweepCommand::Merge(args)), _) => merge::run(args),
        (None, Some(file)) => sweep(args, file),
        (None, None) => Ok(()),
    }
}

fn sweep(args: &SweepArgs, file: &str) -> Result<(), Failure> {
    let plan = Plan::load(&Source::parse(file), &args.settings)?;
    let cases = plan.design.cases();
    if let Some(case) = args.case {
        if case >= cases {
            return Err(Failure::input(format!("the sweep has no case {case}: it has {cases} cases, numbered from 0")));
        }
        return terminal::print(&plan.scenario(case)?.echo());
    }
    let shard = args.shard.unwrap_or(Shard::WHOLE);
    let destination = args.output.destination();
    let of_sweep = destination.path.join(&plan.design.name);
    let folder = if shard.is_whole() {
        destination.open(WRITER, &plan.design.name)?
    } else {
        Destination { path: of_sweep.clone(), ..destination }.open(WRITER, &shard.folder())?
    };
    let layout = plan.layout(shard);
    let first = cases.min(layout.packs.start * trocar_studies::sweep::PACK_CASES);
    let manifest =
        Manifest { sweep_sha256: plan.hash(), cases, part: (first, first + layout.part_cases()), is_complete: false };
    if args.overwrite {
        stored::remove_another(&folder.path, plan.canonical())?;
    }
    let stored = Stored::of(&folder.path, plan.canonical(), &manifest.sweep_sha256)?;
    // The data of the charts are not stored, so a complete sweep without a report runs again, with identical results.
    let lacks_report = args.report && !stored.has_report();
    if stored.is_complete() && !lacks_report {
        if shard.is_whole() {
            // The previous process ended before it removed the packs.
            drop_packs(&folder);
        }
        return report(&folder, &args.output, "already complete");
    }
    if !args.output.quiet {
        stored.print_differences();
    }
    let warnings = Warnings::new(&args.output);
    let ends = [plan.scenario(0)?, plan.scenario(cases.saturating_sub(1))?];
    let is_quiet = ends.iter().all(|scenario| !scenario.has_random_numbers());
    let printed = if is_quiet { seeds_without_effect(&ends[..1], plan.design.seeds) } else { vec![] };
    warnings.print(&printed);
    let part_cases = manifest.part.1 - manifest.part.0;
    announce(args, estimate_s(args, &plan, part_cases), part_cases)?;
    write_file(&folder.path.join(SWEEP), plan.canonical().as_bytes())?;
    let part = Part::open(&folder.path.join(CASES), layout)?;
    // From here on this process owns the folder.
    stored.begin(&folder.path, &manifest)?;
    let (done, all) = (run_part(args, &plan, &part)?, part.layout().part_cases());
    if done < all {
        let kept =
            format!("{done} of {all} cases are kept in {}; run the same command to continue", folder.path.display());
        return Err(Failure::interrupted(&kept));
    }
    if !shard.is_whole() {
        return shard_done(args, &of_sweep, &manifest);
    }
    let (design, canonical) = (&plan.design, plan.canonical());
    let line = (args.report || stored.has_report()).then(|| {
        let words = ["sweep".to_owned(), page::shown(file)].into_iter().chain(page::set_flags(&args.settings));
        command_line(words.chain(["--report".to_owned()]))
    });
    let whole = Whole { design, canonical, manifest, rows: Rows(vec![part]), report: line, printed };
    finish(&folder, whole, &args.output, &warnings)?;
    drop_packs(&folder);
    warnings.finish()
}

/// Cases per thread that are timed.
const TRIED_PER_THREAD: u64 = 2;

/// Estimates the time in s of all cases from evenly spaced cases with their stability metrics, on as many threads as
/// the sweep. Reading the files of a scenario is not timed, because a sweep reads them once.
fn estimate_s(args: &SweepArgs, plan: &Plan, cases: u64) -> f64 {
    let threads = args.threads.map_or_else(rayon::current_num_threads, usize::from);
    let (all, tried) = (plan.design.cases(), cases.min(TRIED_PER_THREAD * threads as u64));
    // The sweep reports a failed case with its number.
    let scenario = |index: u64| plan.scenario(index * (all - 1) / tried.max(2).saturating_sub(1)).ok();
    let scenarios: Vec<Scenario> = (0..tried).filter_map(scenario).collect();
    let measure = |scenario: &Scenario| {
        if let Ok(metrics) = trocar_studies::run::measure(scenario) {
            let of_loop = LoopOfCase::new(scenario);
            for column in plan.design.columns.iter().filter(|column| column.is_of_loop()) {
                std::hint::black_box(column.value(&metrics, Some(&of_loop)));
            }
        }
    };
    let begin = std::time::Instant::now();
    let try_all = || scenarios.par_iter().for_each(measure);
    match rayon::ThreadPoolBuilder::new().num_threads(threads).build() {
        Ok(pool) => pool.install(try_all),
        Err(_) => try_all(),
    }
    begin.elapsed().as_secs_f64() * cases as f64 / tried.max(1) as f64
}

/// More than an hour requires `--yes`. The estimate is an upper bound, because vectorised cases take less time.
pub(super) fn announce(args: &SweepArgs, estimate_s: f64, cases: u64) -> Result<(), Failure> {
    let about = match estimate_s {
        short if short < 90.0 => format!("{:.0} s", short.ceil()),
        medium if medium < 5400.0 => format!("{:.0} min", medium / 60.0),
        long => format!("{:.1} h", long / 3600.0),
    };
    if estimate_s > MAX_UNASKED_S && !args.yes {
        return Err(Failure::input(format!(
            "{cases} cases take about {about}; add --yes to start, use fewer points or seeds, or run parts with --shard"
        )));
    }
    if !args.output.quiet {
        anstream::eprintln!("{cases} case{}, at most about {about}", if cases == 1 { "" } else { "s" });
    }
    Ok(())
}

fn drop_packs(folder: &Folder) {
    let _ = std::fs::remove_file(folder.path.join(CASES));
}

fn run_part(args: &SweepArgs, plan: &Plan, part: &Part) -> Result<u64, Failure> {
    let threads = args.threads.map_or_else(rayon::current_num_threads, usize::from);
    let all = usize::try_from(part.layout().part_cases()).unwrap_or(usize::MAX);
    let bar = progress::rated_bar(all, args.output.quiet);
    bar.set_message("cases");
    let begun = |done: u64| {
        bar.set_position(done);
        bar.reset_eta();
    };
    let watch = Progress { stop: interrupt::stop_flag(), begun: &begun, done: &|cases| bar.inc(cases) };
    let done = execute(plan, part, Execution { threads, shares_runs: !args.no_sharing }, &watch);
    bar.finish_and_clear();
    Ok(done?)
}

fn shard_done(args: &SweepArgs, of_sweep: &Path, manifest: &Manifest) -> Result<(), Failure> {
    if args.output.json {
        return terminal::print(&to_json(&json_of(manifest)));
    }
    let (first, end) = manifest.part;
    let folder = of_sweep.join("shard-*");
    let text = format!(
        "{} of {} cases complete; after all shards: trocar sweep merge {}\n",
        end - first,
        manifest.cases,
        folder.display()
    );
    if args.output.quiet { Ok(()) } else { terminal::print(&text) }
}
