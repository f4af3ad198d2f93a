use schemars::JsonSchema;
use serde::Serialize;

use super::{
    Comparison, ComparisonTable, Fact, NoiseCheck, Row, SchemeRow, SeedStudy, Spread, rows, verdict, verdict_over_seeds,
};
use crate::animation::animation_with_pictures;
use crate::run::{REDUCED, Run, RunFile, RunReport, about, event_shade, outcome, seeds_without_effect, windows};
use trocar_base::warning::Warning;
use trocar_document::{Cell, DataTable, Digits, Document, Number, Section, Shown, Study, Table, Values, json_of, show};
use trocar_figures::{self as figures, EstimationView, RunView};
use trocar_metrics::{Metrics, Outcome, RuptureMetrics, Scope, Unit};

const SHOWN_RUPTURES: usize = 2;

const MAX_NAMED: usize = 3;

const MAX_RUNS: usize = 8;

const OVER_SEEDS: [&str; 11] = [
    "slave_travel_m",
    "unintended_travel_m",
    "excess_advance_m",
    "return_jump_m",
    "horizon_advance_m",
    "felt_peak_n",
    "felt_drop_n",
    "noticed",
    "detection_delay_s",
    "missed_ruptures",
    "false_alarms",
];

#[derive(Debug, Clone, Copy)]
pub struct ComparisonReport<'a> {
    pub comparison: &'a Comparison,
    /// Only for the pair of the paper.
    pub facts: Option<&'a [Fact]>,
    pub seeds: Option<&'a SeedStudy>,
}

impl Study for ComparisonReport<'_> {
    fn document(&self) -> Document<'_> {
        self.into_document(None)
    }
}

impl<'a> ComparisonReport<'a> {
    pub(super) fn into_document(self, schemes: Option<&[SchemeRow]>) -> Document<'a> {
        let runs: Vec<&'a Run> = self.comparison.runs.iter().collect();
        let names: Vec<&str> = runs.iter().map(|run| run.scenario.name.as_str()).collect();
        let title = if names.len() > MAX_NAMED { format!("{} scenarios", names.len()) } else { names.join(" and ") };
        let mut document = Document {
            name: "comparison",
            title,
            verdict: self.seeds.map_or_else(|| verdict(&runs), |study| verdict_over_seeds(study, &runs)),
            warnings: self.warnings(),
            sections: self.sections(&runs),
            data: std::iter::once(columns(self.comparison)).chain(self.seeds.map(seed_columns)).collect(),
            json: json_of(&ComparisonFile {
                trocar_version: env!("CARGO_PKG_VERSION"),
                runs: runs.iter().copied().map(RunFile::of).collect(),
                warnings: self.warnings(),
                table: self.comparison.table(),
                noise: &self.comparison.noise,
                paper_facts: self.facts,
                seeds: self.seeds,
                schemes,
            }),
            ..Document::default()
        };
        let drawn: Vec<&'a Run> = runs.into_iter().filter(|run| !run.trace.is_empty()).collect();
        let views: Vec<_> = drawn.iter().map(|run| RunReport::of(run).view()).collect();
        document.sketch = figures::sketch(&views).ok();
        document.animation = animation_with_pictures(&drawn);
        let estimations: Vec<_> = drawn.iter().take(MAX_RUNS).map(|run| RunReport::of(run).estimation()).collect();
        add_figures(&mut document, &views, estimations);
        document
    }

    fn warnings(&self) -> Vec<Warning> {
        let scenarios = self.comparison.runs.iter().map(|run| &run.scenario);
        let of_seeds = seeds_without_effect(scenarios, self.seeds.map_or(1, |study| study.seeds));
        of_seeds.into_iter().chain(self.comparison.warnings()).collect()
    }

    fn sections(&self, runs: &[&Run]) -> Vec<Section> {
        let [short, all] = metric_tables(runs, &self.comparison.noise);
        let mut main =
            Section::new("main", if self.seeds.is_some() { "Main metrics of the first seed" } else { "Main metrics" });
        for run in runs.iter().filter(|run| run.metrics.outcome != Outcome::Completed) {
            main.text(outcome(run));
        }
        main.table(short);
        let most = runs.iter().map(|run| run.metrics.ruptures.len()).max().unwrap_or(0);
        if most > SHOWN_RUPTURES {
            main.text(format!("The first {SHOWN_RUPTURES} of {most} ruptures; --all shows the others."));
        }
        let mut signals = Section::new("signals", "Signals").shown(Shown::InReports);
        if runs.len() > MAX_RUNS {
            signals.text(format!("The charts show the first {MAX_RUNS} of {} runs.", runs.len()));
        }
        let with_most = runs.iter().max_by_key(|run| run.metrics.ruptures.len());
        signals.figures(["signals"], with_most.map_or(vec![], |run| windows(&run.metrics.ruptures)));
        signals.text(REDUCED);
        let mut events = Section::new("events", "Events").shown(Shown::InReports);
        match events_table(runs) {
            Some(table) => events.table(table),
            None => events.text("No rupture and no alarm."),
        }
        let mut metrics = Section::new("metrics", "All metrics").shown(Shown::WithAll);
        metrics.table(all);
        let mut sections: Vec<Section> = self.seeds.map(seeds_section).into_iter().collect();
        sections.extend([main, signals, events, metrics]);
        sections.extend(self.facts.map(|facts| facts_section(facts, Shown::WithAll)));
        let mut runs_section = Section::new("about", "The runs").shown(Shown::InReports);
        runs.iter().for_each(|run| runs_section.text(about(run)));
        sections.push(runs_section);
        sections
    }
}

/// `comparison.json`: the summaries, the table, the detection in noise, and the optional parts.
#[derive(Debug, Serialize, JsonSchema)]
pub struct ComparisonFile<'a> {
    /// Version of trocar.
    trocar_version: &'static str,
    /// The summary of each run, in the order of the scenarios.
    runs: Vec<RunFile<'a>>,
    /// The warnings about the runs.
    warnings: Vec<Warning>,
    table: ComparisonTable,
    /// The detection of each scenario with added noise.
    noise: &'a [NoiseCheck],
    /// Statements of the paper, for the pair of the paper; `None` for other scenarios.
    paper_facts: Option<&'a [Fact]>,
    /// The same scenarios over many seeds, with `--seeds`.
    #[serde(skip_serializing_if = "Option::is_none")]
    seeds: Option<&'a SeedStudy>,
    /// Each passivity scheme, with `trocar strategies --schemes`.
    #[serde(skip_serializing_if = "Option::is_none")]
    schemes: Option<&'a [SchemeRow]>,
}

/// `estimations` belong to the first runs.
pub fn add_figures<'a>(document: &mut Document<'a>, runs: &[RunView<'a>], estimations: Vec<EstimationView<'a>>) {
    document.figure("comparison", figures::comparison(runs, None));
    document.figure("overlay", figures::overlay(runs, None));
    let ends_s = runs.iter().filter_map(|run| run.time_s.last().copied());
    let signals: Vec<_> = runs.iter().cloned().zip(estimations).take(MAX_RUNS).collect();
    document.figure("signals", figures::signals(&signals, (0.0, ends_s.fold(0.0, f64::max))));
}

pub(crate) fn metric_tables(runs: &[&Run], noise: &[NoiseCheck]) -> [Table; 2] {
    let rows = rows(&runs.iter().map(|run| &run.metrics).collect::<Vec<&Metrics>>(), noise);
    let mut columns = vec![("metric".to_owned(), "metric".to_owned())];
    columns.extend(runs.iter().map(|run| (run.scenario.name.clone(), run.scenario.name.clone())));
    if runs.len() == 2 {
        columns.push(("change".into(), "change".into()));
    }
    let mut short = Table::new("main", "Values of each run", columns.clone());
    let mut all = Table::new("metrics", "Metrics and their meaning", columns);
    for row in &rows {
        if is_main(row) {
            short.row(row.cells());
        }
        all.explained(row.cells(), row.declaration.meaning);
    }
    [short, all]
}

fn is_main(row: &Row) -> bool {
    let is_later = row.declaration.scope == Scope::Rupture && row.number > SHOWN_RUPTURES;
    row.declaration.shown.is_main() && !is_later
}

fn facts_section(facts: &[Fact], shown: Shown) -> Section {
    let mut section = Section::new("paper", "Comparison with the paper").shown(shown);
    section.text(
        "Statements of the paper (Barbé, Bayle, de Mathelin and Gangi, In Vivo Model Estimation and Haptic Characterization of Needle \
         Insertions) and the results of this comparison.",
    );
    section.table(facts_table(facts));
    section
}

pub(crate) fn facts_table(facts: &[Fact]) -> Table {
    let columns = [
        ("statement", "statement (rupture 1 unless stated)"),
        ("paper", "paper"),
        ("required", "required"),
        ("result", "result"),
        ("holds", ""),
    ];
    let mut table = Table::new("facts", "Statements of the paper", columns).of_text();
    for fact in facts {
        table.row([fact.what, fact.paper, fact.asked, &fact.ours, if fact.holds { "✓" } else { "✗" }]);
    }
    table
}

fn seeds_section(study: &SeedStudy) -> Section {
    let mut section = Section::new("seeds", "Over many seeds");
    section.table(seeds_table(study));
    let varies = |spread: &Spread| spread.low < spread.high;
    if !study.rows.iter().flat_map(|row| &row.spreads).flatten().any(varies) {
        section.text("No metric depends on the seed: the scenarios have no random noise, tremor or reaction time.");
    }
    section
}

/// Median and central 95 % interval; for a pair also the ratio of second to first, seed by seed.
pub(crate) fn seeds_table(study: &SeedStudy) -> Table {
    let over = format!("over {} seeds", study.seeds);
    let columns =
        [("metric", &*over), ("median", "median"), ("low", "2.5 %"), ("high", "97.5 %"), ("defined", "seeds")];
    let caption = format!("Over {} seeds: medians, central 95 % intervals, seeds with a value", study.seeds);
    let mut table = Table::new("seeds", caption, columns);
    for row in study.rows.iter().filter(|row| OVER_SEEDS.contains(&row.name)) {
        let of_unit = Number::new(0.0, row.unit);
        let unit = if of_unit.unit.is_empty() { String::new() } else { format!(" ({})", of_unit.unit.trim_start()) };
        table.row([format!("{}{unit}", row.label)]);
        let bare = |value: f64| {
            let is_whole = row.unit == Unit::Count && value.fract() == 0.0;
            let digits = if is_whole { Digits::All } else { Digits::Four };
            Number { value, unit: "".into(), ..of_unit.clone() }.digits(digits)
        };
        for (name, spread) in study.scenarios.iter().zip(&row.spreads) {
            table.row(spread_cells(name, spread.as_ref(), bare));
        }
        if let (true, [_, Some(ratio)]) = (study.scenarios.len() == 2, &row.ratios[..]) {
            table.row(spread_cells("second / first", Some(ratio), |value| Number::si(value, "")));
        }
    }
    table
}

fn spread_cells(name: &str, spread: Option<&Spread>, number: impl Fn(f64) -> Number) -> [Cell; 5] {
    let name = Cell::from(format!("  {name}"));
    let Some(spread) = spread else {
        return [name, Cell::Undefined, Cell::Undefined, Cell::Undefined, Cell::count(0)];
    };
    let [median, low, high] = [spread.median, spread.low, spread.high].map(|value| Cell::from(number(value)));
    [name, median, low, high, Cell::count(spread.defined)]
}

fn columns(comparison: &Comparison) -> DataTable<'static> {
    let table = comparison.table();
    let rows = || table.rows.iter();
    let mut data = DataTable::new("comparison")
        .texts("metric", rows().map(|row| row.metric.clone()))
        .texts("unit", rows().map(|row| row.unit.si()));
    for (index, name) in table.scenarios.iter().enumerate() {
        data = data.optional(name.clone(), rows().map(|row| row.values[index]));
    }
    data
}

fn seed_columns(study: &SeedStudy) -> DataTable<'static> {
    let all = || study.rows.iter().flat_map(|row| (0..study.scenarios.len()).map(move |index| (row, index)));
    let spread = |of: fn(&Spread) -> f64| {
        all().map(|(row, index)| row.spreads[index].as_ref().map(of)).collect::<Vec<Option<f64>>>()
    };
    let ratio = |of: fn(&Spread) -> f64| {
        all().map(|(row, index)| row.ratios[index].as_ref().map(of)).collect::<Vec<Option<f64>>>()
    };
    let defined = all().map(|(row, index)| row.spreads[index].map_or(0, |spread| spread.defined));
    DataTable::new("seeds")
        .texts("metric", all().map(|(row, _)| row.metric.clone()))
        .texts("unit", all().map(|(row, _)| row.unit.si()))
        .texts("scenario", all().map(|(_, index)| study.scenarios[index].clone()))
        .with("defined", Values::Whole(defined.collect()))
        .optional("median", spread(|spread| spread.median))
        .optional("low_2.5", spread(|spread| spread.low))
        .optional("high_97.5", spread(|spread| spread.high))
        .optional("median_low", spread(|spread| spread.median_low))
        .optional("median_high", spread(|spread| spread.median_high))
        .optional("ratio_median", ratio(|spread| spread.median))
        .optional("ratio_low_2.5", ratio(|spread| spread.low))
        .optional("ratio_high_97.5", ratio(|spread| spread.high))
}

fn named(index: usize, rupture: &RuptureMetrics) -> String {
    let layer = rupture.layer.as_ref().map_or(String::new(), |layer| format!(" ({layer})"));
    format!("rupture {}{layer}", index + 1)
}

fn fate(rupture: &RuptureMetrics) -> String {
    match (rupture.detection_delay_s, &rupture.miss) {
        (Some(delay_s), _) => format!("detected after {}", show(Some(delay_s), Unit::Second)),
        (None, Some(miss)) => format!("missed: {miss}"),
        (None, None) => "the run ends too soon to decide".into(),
    }
}

pub(crate) fn events_table(runs: &[&Run]) -> Option<Table> {
    let mut rows: Vec<(f64, [String; 3])> = vec![];
    for run in runs {
        let mut add = |time_s: f64, event: String, outcome: String| {
            rows.push((time_s, [run.scenario.name.clone(), event, outcome]));
        };
        let ms = |seconds| show(Some(seconds), Unit::Second);
        let mm = |metres| show(Some(metres), Unit::Metre);
        for (index, rupture) in run.metrics.ruptures.iter().enumerate() {
            let excess = rupture.excess_advance_m.map_or(String::new(), |m| format!(", excess advance {}", mm(m)));
            let noticed = match (rupture.noticed, rupture.noticed_after_s) {
                (Some(_), Some(seconds)) => format!(", noticed after {}", ms(seconds)),
                (Some(_), None) => ", not noticed".to_owned(),
                (None, _) => String::new(),
            };
            add(rupture.time_s, named(index, rupture), format!("{}{excess}{noticed}", fate(rupture)));
        }
        for alarm in &run.metrics.alarms {
            let outcome = if alarm.matched { "matches a rupture" } else { "false alarm" };
            add(alarm.time_s, "alarm".into(), outcome.into());
        }
        for event in &run.metrics.events {
            let motion = format!("the slave moves at most {}", mm(event.frozen_motion_m));
            let duration = event.augmented_s.map_or("until the end".into(), |s| format!("for {}", ms(s)));
            add(
                event.start_s,
                event_shade(run.scenario.augmentation.hold).name().into(),
                format!("{duration}, {motion}"),
            );
            let Some(augmented_s) = event.augmented_s else { continue };
            let duration = event.reengaging_s.map_or("until the end".into(), |s| format!("for {}", ms(s)));
            add(event.start_s + augmented_s, "re-engaging".into(), duration);
            if let Some(reengaging_s) = event.reengaging_s {
                add(event.start_s + augmented_s + reengaging_s, "re-engaged".into(), "teleoperation".into());
            }
        }
    }
    rows.sort_by(|a, b| a.0.total_cmp(&b.0));
    let columns = [("time", "time"), ("scenario", "scenario"), ("event", "event"), ("outcome", "outcome")];
    let mut table = Table::new("events", "Events in order of time", columns).of_text();
    for (time_s, [scenario, event, outcome]) in rows {
        let time = Number::si(time_s, "s").digits(Digits::Decimals(3));
        table.row([time.into(), Cell::Text(scenario), Cell::Text(event), Cell::Text(outcome)]);
    }
    (!table.rows.is_empty()).then_some(table)
}
