//! The pages of a run and of a comparison.

use super::command::command_line;
use super::events::{self, Timeline};
use super::page::{Block, Drawn, HtmlError, Page, Row, Section, Window, warned};
use crate::answer::answer;
use crate::comparison::{facts_table, is_main, row_cells};
use crate::finding::finding;
use crate::pictures::page_signals;
use crate::seeds::seeds_table;
use crate::tables::outcome;
use crate::{Animation, Table};
use trocar_document::show;
use trocar_studies::compare::{Comparison, Fact, SeedStudy};
use trocar_studies::run::Run;

/// Displayed time before and after a rupture, in s.
const BEFORE_S: f64 = 0.2;
const AFTER_S: f64 = 1.0;

/// Maximum number of scenarios in the heading.
const MAX_NAMED: usize = 3;

/// Maximum number of runs in the charts.
const MAX_RUNS: usize = 8;

/// Maximum number of ruptures with a button.
const MAX_WINDOWS: usize = 6;

/// Returns the page of a run.
///
/// # Errors
/// [`HtmlError`].
pub fn run_html(run: &Run) -> Result<String, HtmlError> {
    let rows = trocar_studies::compare::rows(&[&run.metrics], &[]);
    let name = run.scenario.name.as_str();
    let line = command_line(["run", &format!("{name}.toml"), "--report"]);
    let sections = vec![
        main_metrics(&[name], &rows),
        charts_section(&[run]),
        events_section(&[run]),
        metrics(&[name], &rows),
        reproduction(line, &[run]),
        scenarios_section(&[run]),
    ];
    let page =
        Page { command: "trocar run", heading: name.to_owned(), lead: lead(&[run]), sections, drawn: drawn(&[run])? };
    page.render()
}

/// Returns the page of a comparison. `line` is the command that reproduces it; without it, the command names the scenarios.
///
/// # Errors
/// [`HtmlError`].
pub fn comparison_html(
    comparison: &Comparison,
    facts: Option<&[Fact]>,
    study: Option<&SeedStudy>,
    line: Option<String>,
) -> Result<String, HtmlError> {
    let runs: Vec<&Run> = comparison.runs.iter().collect();
    let table = comparison.table();
    let names: Vec<&str> = table.scenarios.iter().map(String::as_str).collect();
    let mut sections = vec![
        main_metrics(&names, &table.rows),
        charts_section(&runs),
        events_section(&runs),
        metrics(&names, &table.rows),
    ];
    if let Some(study) = study {
        let blocks = vec![
            Block::text(
                "For each scenario: the median and the ends of the central 95 % interval over the seeds, and the number of seeds with a value.",
            ),
            Block::table(format!("Over {} seeds", study.seeds), &seeds_table(study)),
        ];
        sections.push(Section { id: "seeds", title: "Over many seeds", blocks });
    }
    if let Some(facts) = facts {
        let about = "Statements of the paper (Barbé, Bayle, de Mathelin and Gangi, In Vivo Model Estimation and Haptic \
                     Characterization of Needle Insertions) and the results of this comparison.";
        let blocks = vec![Block::text(about), Block::table("Statements of the paper", &facts_table(facts))];
        sections.push(Section { id: "paper", title: "Comparison with the paper", blocks });
    }
    let own = || {
        let files = names.iter().map(|name| format!("{name}.toml"));
        let seeds = study.map_or(vec![], |study| vec!["--seeds".to_owned(), study.seeds.to_string()]);
        command_line(["compare".to_owned()].into_iter().chain(files).chain(seeds).chain(["--report".to_owned()]))
    };
    sections.push(match line {
        Some(line) => Section {
            id: "again",
            title: "Reproduce",
            blocks: vec![Block::Command { line, note: "trocar includes these scenarios.".into() }],
        },
        None => reproduction(own(), &runs),
    });
    sections.push(scenarios_section(&runs));
    let heading = if names.len() > MAX_NAMED { format!("{} scenarios", names.len()) } else { names.join(" and ") };
    let page = Page { command: "trocar compare", heading, lead: lead(&runs), sections, drawn: drawn(&runs)? };
    page.render()
}

/// Returns the introduction: the answer, what is found over all ruptures, and the warnings.
fn lead(runs: &[&Run]) -> Vec<String> {
    let warnings = runs.iter().flat_map(|run| warned(&run.warnings()));
    [answer(runs), finding(runs)].into_iter().chain(warnings).collect()
}

/// Returns a sentence about a run: outcome, tick, seed and supervisor.
fn about(run: &Run) -> String {
    let scenario = &run.scenario;
    format!(
        "{}; tick {}, seed {}, the supervisor {}.",
        outcome(run),
        show(Some(scenario.grid.tick_s()), trocar_metrics::Unit::Second),
        scenario.seed,
        if scenario.augmentation.enabled { "freezes the slave at ruptures" } else { "does nothing" },
    )
}

/// Returns the metrics of the short table, without their meaning.
fn main_metrics(names: &[&str], rows: &[trocar_studies::compare::Row]) -> Section {
    let main: Vec<_> = rows.iter().filter(|row| is_main(row)).cloned().collect();
    let table = rows_table("Values of each run", names, &main, |_| "");
    Section { id: "main", title: "Main metrics", blocks: vec![table] }
}

fn metrics(names: &[&str], rows: &[trocar_studies::compare::Row]) -> Section {
    let table = rows_table("Metrics and their meaning", names, rows, |row| row.declaration.meaning);
    let note = Block::text("A dash marks an undefined value, such as the detection delay of a missed rupture.");
    Section { id: "metrics", title: "All metrics", blocks: vec![table, note] }
}

fn rows_table(
    caption: &str,
    names: &[&str],
    rows: &[trocar_studies::compare::Row],
    meaning: fn(&trocar_studies::compare::Row) -> &'static str,
) -> Block {
    let is_pair = names.len() == 2;
    let mut head = vec!["metric".to_owned()];
    head.extend(names.iter().map(|name| (*name).to_owned()));
    if is_pair {
        head.push("change".into());
    }
    let row = |row: &trocar_studies::compare::Row| Row { cells: row_cells(row), meaning: meaning(row) };
    Block::Table { caption: caption.into(), head, rows: rows.iter().map(row).collect(), is_text: false }
}

fn events_section(runs: &[&Run]) -> Section {
    let lanes: Vec<_> = runs.iter().map(|run| events::of_run(run)).collect();
    let ends = runs.iter().filter_map(|run| run.trace.time_s.last().copied());
    let timeline = Timeline::of(&lanes, (0.0, ends.fold(0.0, f64::max)), "rupture");
    let table: Table = events::events_table(runs);
    let table = match table.rows() {
        [_] => Block::text("No rupture and no alarm."),
        _ => Block::table("Events in order of time", &table),
    };
    Section { id: "events", title: "Events", blocks: vec![Block::Timeline(timeline), table] }
}

fn charts_section(runs: &[&Run]) -> Section {
    let first = runs.iter().max_by_key(|run| run.metrics.ruptures.len());
    let ruptures = first.map_or(&[][..], |run| run.metrics.ruptures.as_slice());
    let window = |(index, rupture): (usize, &trocar_metrics::RuptureMetrics)| Window {
        label: format!("rupture {}", index + 1),
        from: (rupture.time_s - BEFORE_S).max(0.0),
        to: rupture.time_s + AFTER_S,
    };
    let windows = ruptures.iter().take(MAX_WINDOWS).enumerate().map(window).collect();
    let mut blocks = vec![];
    if runs.len() > MAX_RUNS {
        blocks.push(Block::text(format!("The charts show the first {} of {} runs.", MAX_RUNS, runs.len())));
    }
    blocks.push(Block::Figures { name: "signals", windows });
    blocks.push(Block::text(
        "Long records are reduced to the minimum and maximum of short intervals; nearly every sample around ruptures and alarms \
         is kept. trace.csv has every tick.",
    ));
    Section { id: "signals", title: "Signals", blocks }
}

fn drawn(runs: &[&Run]) -> Result<Drawn, HtmlError> {
    let mut drawn = Drawn { animation: Animation::of(runs), ..Drawn::default() };
    drawn.figures.insert("signals", page_signals(&runs[..runs.len().min(MAX_RUNS)])?);
    Ok(drawn)
}

/// Returns the section with the resolved scenarios.
pub(super) fn scenarios_section(runs: &[&Run]) -> Section {
    let about =
        "Every key with its value, including defaults. Running this scenario gives identical results, bit for bit.";
    let file = |run: &&Run| Block::File {
        name: format!("{}.toml", run.scenario.name),
        text: without_paths(&run.scenario.echo()),
    };
    let each = runs.iter().map(|run| Block::text(self::about(run)));
    let blocks = [Block::text(about)].into_iter().chain(each).chain(runs.iter().map(file)).collect();
    Section { id: "scenario", title: "Scenario", blocks }
}

fn reproduction(line: String, runs: &[&Run]) -> Section {
    let has_files = runs.iter().any(|run| without_paths(&run.scenario.echo()) != run.scenario.echo());
    let recordings = if has_files { " and copy their recordings into the same folder" } else { "" };
    let note = format!("Save the scenarios above under their names{recordings}, then run this command there.");
    Section { id: "again", title: "Reproduce", blocks: vec![Block::Command { line, note }] }
}

/// Returns a resolved scenario without the folders of its files, so that no path of this machine is in it.
pub(super) fn without_paths(toml: &str) -> String {
    let line = |line: &str| {
        let file = ["file", "delays_file"].into_iter().find_map(|key| {
            let value = line.strip_prefix(key)?.strip_prefix(" = ")?;
            let value: toml::Value = toml::from_str::<toml::Table>(&format!("v = {value}")).ok()?.remove("v")?;
            let path = std::path::Path::new(value.as_str()?);
            let name = path.file_name().filter(|_| path.is_absolute())?;
            Some(format!("{key} = {}", toml::Value::String(name.to_string_lossy().into_owned())))
        });
        format!("{}\n", file.as_deref().unwrap_or(line))
    };
    toml.lines().map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_lose_their_folders_and_nothing_else_changes() {
        let toml = "name = \"a\"\n\n[recording]\nfile = \"/home/someone/a b.csv\"\nfile_sign = 1.0\n";
        assert_eq!(without_paths(toml), toml.replace("/home/someone/", ""));
        let shipped = "file = \"builtin:own.csv\"\n";
        assert_eq!(without_paths(shipped), shipped);
    }
}
