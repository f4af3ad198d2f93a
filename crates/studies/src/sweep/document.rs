use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value as Json;

use super::answer;
use super::drawn_cases::DrawnCases;
use super::{Axis, Design, Findings, HeatMap, Influence, Influences, Spread, Summary};
use trocar_base::warning::Warning;
use trocar_document::{
    Cell, DataTable, Digits, Document, Figure, Number, Section, Shown, Study, Table, Values, Verdict, counted, json_of,
    readable,
};
use trocar_figures::{self as figures, AxisView, FigureError, HeatView, InfluenceBar};
use trocar_metrics::Unit;
use trocar_scenario::unit_of;

#[derive(Debug, Clone, Copy)]
pub struct SweepReport<'a> {
    pub design: &'a Design,
    pub hash: &'a str,
    pub findings: &'a Findings,
    pub cases: Option<&'a DrawnCases>,
}

impl Study for SweepReport<'_> {
    fn document(&self) -> Document<'_> {
        let Self { design, findings, .. } = *self;
        let mut document = Document {
            name: "summary",
            title: design.name.clone(),
            verdict: verdict(design, findings),
            warnings: findings.warnings.clone(),
            sections: vec![metrics(design, findings)],
            data: vec![summary_columns(findings)],
            json: self.json(),
            ..Document::default()
        };
        if !design.axes.is_empty() {
            document.sections.push(influences(design, findings));
            document.figure("tornado", tornado(design, findings));
            document.data.push(tornado_columns(design, findings));
        }
        // The maps show the answer.
        let mut maps = Section::new("maps", "Maps over two axes").shown(Shown::InReports);
        for map in &findings.heat_maps {
            let name = format!("heat_{}", design.columns[map.column].name);
            maps.figure(name.clone());
            document.figure(name.clone(), heat_map(design, map));
            document.data.push(map_columns(design, map, name));
        }
        if !maps.blocks.is_empty() {
            document.sections.insert(0, maps);
        }
        if let Some(cases) = self.cases {
            let charts = cases.charts(design);
            if !charts.is_empty() {
                let mut section = Section::new("axes", "Metrics over each axis").shown(Shown::InReports);
                section.text(cases.about(findings.cases));
                for (name, figure) in charts {
                    section.figure(name.clone());
                    document.figure(name, Ok::<_, FigureError>(figure));
                }
                document.sections.push(section);
            }
        }
        document
    }
}

/// `summary.json` of a sweep: all findings except the cases.
#[derive(Debug, Serialize, JsonSchema)]
pub struct SweepFile<'a> {
    /// Version of trocar.
    trocar_version: &'static str,
    /// Name of the sweep.
    sweep: &'a str,
    /// SHA-256 of the folder's `sweep.toml`, which contains all inputs of the sweep.
    sweep_sha256: &'a str,
    /// Number of cases.
    cases: u64,
    /// Number of points, each with one case per seed.
    points: Option<u64>,
    /// Number of seeds of each point.
    seeds: u64,
    /// Number of cases that diverged.
    diverged: u64,
    /// Number of cases with a failed integration.
    failed: u64,
    /// The distribution of each metric.
    metrics: &'a [Summary],
    /// The influence of the axes on the metrics in focus.
    influences: Vec<MetricInfluences<'a>>,
    /// The warnings about the sweep.
    warnings: &'a [Warning],
}

/// The influence of each axis on a metric.
#[derive(Debug, Serialize, JsonSchema)]
struct MetricInfluences<'a> {
    /// Key of the metric.
    metric: &'a str,
    /// The influence of each axis, in descending order.
    of_axes: &'a [Influence],
    /// R² of the rank regression.
    rank_r_squared: Option<f64>,
    /// Number of ranked cases.
    ranked: u64,
}

impl SweepReport<'_> {
    fn json(&self) -> Json {
        let Self { design, hash, findings, .. } = *self;
        let of_metric = |influences| {
            let &Influences { column, ref of_axes, rank_r_squared, ranked } = influences;
            MetricInfluences { metric: &design.columns[column].name, of_axes, rank_r_squared, ranked }
        };
        json_of(&SweepFile {
            trocar_version: env!("CARGO_PKG_VERSION"),
            sweep: &design.name,
            sweep_sha256: hash,
            cases: findings.cases,
            points: design.points(),
            seeds: design.seeds,
            diverged: findings.diverged,
            failed: findings.failed,
            metrics: &findings.summaries,
            influences: findings.influences.iter().map(of_metric).collect(),
            warnings: &findings.warnings,
        })
    }
}

fn verdict(design: &Design, findings: &Findings) -> Verdict {
    let axes: Vec<&str> = design.axes.iter().map(|axis| &*axis.key.path).collect();
    let mut sentences: Vec<String> = design.question.iter().cloned().collect();
    sentences.extend(answer::sentences(findings));
    sentences.push(format!(
        "{}, {} ({}) with {} each, over {}.",
        counted(findings.cases, "case"),
        counted(design.points().unwrap_or(0), "point"),
        design.scheme.word(),
        counted(design.seeds, "seed"),
        if axes.is_empty() { "no axis".to_owned() } else { axes.join(", ") },
    ));
    if findings.diverged > 0 || findings.failed > 0 {
        let (diverged, failed) = (findings.diverged, findings.failed);
        sentences.push(format!("{} diverged, {failed} could not be integrated.", counted(diverged, "case")));
    }
    let unchanged = findings.summaries.iter().filter(|summary| summary.is_unchanged(findings.cases));
    let unchanged: Vec<&str> = unchanged.map(|summary| summary.label.as_str()).collect();
    if !unchanged.is_empty() {
        sentences.push(format!("The same in every case: {}.", unchanged.join(", ")));
    }
    Verdict { sentences, left_out: vec![] }
}

fn metrics(design: &Design, findings: &Findings) -> Section {
    let columns = [
        ("metric", "metric"),
        ("defined", "cases with value"),
        ("median", "median [95 %]"),
        ("central", "5 % to 95 %"),
        ("range", "min to max"),
        ("mean", "mean ± 95 %"),
    ];
    let mut table = Table::new("metrics", "Metrics over all cases, and their meaning", columns);
    for (summary, column) in findings.summaries.iter().zip(&design.columns) {
        table.explained(summary_row(summary), column.meaning);
    }
    let mut section = Section::new("metrics", "Metrics");
    section.table(table);
    section.text(
        "Intervals in brackets and after ± are 95 % confidence intervals of the median and the mean. “Cases with value” counts the cases \
         in which the metric is defined.",
    );
    section
}

fn summary_row(summary: &Summary) -> [Cell; 6] {
    let (name, defined) = (Cell::from(&*summary.label), Cell::count(summary.defined));
    let undefined = || Cell::Undefined;
    let Some(spread) = &summary.spread else {
        return [name, defined, undefined(), undefined(), undefined(), undefined()];
    };
    let (factor, unit) = readable(summary.unit);
    let number = |value: f64| {
        let is_whole = summary.unit == Unit::Count && value.fract() == 0.0;
        let digits = if is_whole { Digits::All } else { Digits::Four };
        Number { value, factor, unit: unit.into(), digits }
    };
    // A single value has no interval.
    if summary.defined == 1 {
        return [name, defined, number(spread.median).into(), undefined(), undefined(), undefined()];
    }
    let bare = |value: f64| Number { unit: "".into(), ..number(value) };
    let Spread { min, quantile_5, median, quantile_95, max, median_low, median_high, .. } = *spread;
    [
        name,
        defined,
        format!("{} [{}, {}]{unit}", bare(median), bare(median_low), bare(median_high)).into(),
        format!("{} to {}", bare(quantile_5), number(quantile_95)).into(),
        format!("{} to {}", bare(min), number(max)).into(),
        Cell::PlusMinus(number(spread.mean).digits(Digits::Four), spread.mean_ci95_half_width),
    ]
}

fn influences(design: &Design, findings: &Findings) -> Section {
    let columns = [
        ("axis", "influence of each axis"),
        ("first_order_sobol", "first-order Sobol index"),
        ("rank_regression", "rank regression"),
        ("rank_r_squared", "R²"),
    ];
    let share = |value: Option<f64>| Cell::of(value, Unit::Share);
    let mut table = Table::new("influences", "Influence of each axis", columns);
    for of_metric in &findings.influences {
        let metric = Cell::from(&*design.columns[of_metric.column].label);
        table.row([metric, Cell::empty(), Cell::empty(), share(of_metric.rank_r_squared)]);
        for influence in &of_metric.of_axes {
            let slope = influence
                .rank_regression
                .map_or(Cell::Undefined, |slope| Number::si(slope, "").digits(Digits::Signed(3)).into());
            table.row([Cell::from(format!("  {}", influence.axis)), share(influence.epsilon_squared), slope]);
        }
    }
    let mut section = Section::new("influences", "Influences");
    section.table(table);
    section.figure("tornado");
    if !design.correlations.is_empty() {
        section.text("Axes that vary together share their influence: the index of each includes that of the others.");
    }
    section
}

fn tornado(design: &Design, findings: &Findings) -> Result<Figure<'static>, FigureError> {
    let bars = |of_metric: &Influences| {
        let summary = &findings.summaries[of_metric.column];
        match answer::constancy(summary) {
            // Shares of a negligible variance would look like large influences.
            Some(range) => {
                vec![InfluenceBar {
                    title: format!("{}: hardly changes{range}", summary.label),
                    share: None,
                    slope: None,
                }]
            }
            None => of_metric.of_axes.iter().map(|influence| influence.bar(summary)).collect(),
        }
    };
    let bars: Vec<InfluenceBar> = findings.influences.iter().flat_map(bars).collect();
    figures::tornado(&design.name, &bars)
}

fn heat_map(design: &Design, map: &HeatMap) -> Result<Figure<'static>, FigureError> {
    let column = &design.columns[map.column];
    let (factor, unit) = readable(column.unit);
    let seeds = (design.seeds > 1).then(|| format!("{} seeds", design.seeds));
    let is_other = |(index, _): &(usize, &Axis)| ![map.x_axis, map.y_axis].contains(index);
    let others: Vec<String> =
        design.axes.iter().enumerate().filter(is_other).map(|(_, axis)| axis.key.path.to_string()).collect();
    let others = match others.len() {
        0 => None,
        1 | 2 => Some(others.join(" and ")),
        more => Some(format!("the {more} other axes")),
    };
    let all: Vec<String> = seeds.into_iter().chain(others).collect();
    let over = if all.is_empty() { String::new() } else { format!(" (mean over {})", all.join(" and ")) };
    let label = &column.label;
    let caption = if unit.is_empty() { format!("{label}{over}") } else { format!("{label} in{unit}{over}") };
    let named = [map.x_axis, map.y_axis].map(|axis| {
        let path = design.axes[axis].key.path.as_ref();
        unit_of(path).map_or_else(|| path.to_owned(), |unit| format!("{path} ({unit})"))
    });
    let axis = |name, axis: usize| AxisView { name, log: design.axes[axis].is_log() };
    let means: Vec<f64> = map.cells.iter().map(|cell| factor * cell.mean.unwrap_or(f64::NAN)).collect();
    let x: Vec<f64> = map.cells.iter().take(map.x_count).map(|cell| cell.x).collect();
    let y: Vec<f64> = map.cells.iter().step_by(map.x_count.max(1)).map(|cell| cell.y).collect();
    let axes = [axis(&named[0], map.x_axis), axis(&named[1], map.y_axis)];
    figures::heat_map(&HeatView { name: &design.name, caption: &caption, axes, x, y, means: &means })
}

fn summary_columns(findings: &Findings) -> DataTable<'_> {
    let summaries = || findings.summaries.iter();
    type Read = fn(&Spread) -> f64;
    let columns: [(&str, Read); 14] = [
        ("least", |s| s.min),
        ("quantile_2_5", |s| s.quantile_2_5),
        ("quantile_5", |s| s.quantile_5),
        ("quantile_25", |s| s.quantile_25),
        ("median", |s| s.median),
        ("quantile_75", |s| s.quantile_75),
        ("quantile_95", |s| s.quantile_95),
        ("quantile_97_5", |s| s.quantile_97_5),
        ("greatest", |s| s.max),
        ("median_low", |s| s.median_low),
        ("median_high", |s| s.median_high),
        ("mean", |s| s.mean),
        ("mean_ci95_half_width", |s| s.mean_ci95_half_width),
        ("standard_deviation", |s| s.standard_deviation),
    ];
    let mut data = DataTable::new("summary")
        .texts("metric", summaries().map(|summary| summary.metric.as_str()))
        .texts("unit", summaries().map(|summary| summary.unit.si()))
        .with("defined", Values::Whole(summaries().map(|summary| summary.defined).collect()));
    for (name, read) in columns {
        data = data.optional(name, summaries().map(|summary| summary.spread.as_ref().map(read)));
    }
    data
}

fn tornado_columns<'a>(design: &'a Design, findings: &'a Findings) -> DataTable<'a> {
    let rows = || findings.influences.iter().flat_map(|of| of.of_axes.iter().map(move |influence| (of, influence)));
    DataTable::new("tornado")
        .texts("metric", rows().map(|(of, _)| design.columns[of.column].name.as_str()))
        .texts("axis", rows().map(|(_, influence)| influence.axis.as_str()))
        .optional("first_order_sobol", rows().map(|(_, influence)| influence.epsilon_squared))
        .optional("rank_regression", rows().map(|(_, influence)| influence.rank_regression))
        .optional("rank_r_squared", rows().map(|(of, _)| of.rank_r_squared))
        .with("ranked", Values::Whole(rows().map(|(of, _)| of.ranked).collect()))
}

fn map_columns<'a>(design: &'a Design, map: &'a HeatMap, name: String) -> DataTable<'a> {
    let [x, y] = [map.x_axis, map.y_axis].map(|axis| design.axes[axis].key.path.to_string());
    let cells = || map.cells.iter();
    DataTable::new(name)
        .numbers(x, cells().map(|cell| cell.x))
        .numbers(y, cells().map(|cell| cell.y))
        .with("defined", Values::Whole(cells().map(|cell| cell.defined).collect()))
        .optional(design.columns[map.column].name.as_str(), cells().map(|cell| cell.mean))
        .optional("mean_ci95_half_width", cells().map(|cell| cell.mean_ci95_half_width))
}
