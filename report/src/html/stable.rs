//! The page of a stability analysis.

use super::chart::{Chart, ChartAxis, Columns, Level, Series};
use super::compared::without_paths;
use super::map::Map;
use super::page::{Block, Drawn, HtmlError, Page, Row, Section, warned};
use crate::Table;
use crate::absolute::{absolute_text, bounded_line};
use crate::digits::Few;
use crate::figures::{AbsoluteView, WallsView, ZWidthView};
use crate::population::{population_lines, population_table};
use crate::stability_text::{
    checked, limit_table, loop_lines, port_passivity, port_table, sampled, unreached, verdict,
};
use crate::switching::{event_table, seconds, switching_lines};
use crate::z_width::z_width_text;
use crate::{absolute, z_width};
use trocar_sim::stability::{Analysis, LIMITED, Parameter, PortPoint, StabilityMap, Switching};
use trocar_sim::stability_check::{Check, StabilityStudy};

/// Maximum displayed value of Llewellyn's parameter. Every higher value is absolutely stable.
const MAX_LLEWELLYN: f64 = 3.0;

/// Lower limit of the growth axis.
const MIN_GROWTH: f64 = 1e-4;

/// The stability analysis of a scenario.
#[derive(Clone, Copy, Debug)]
pub struct StabilityPage<'a> {
    /// The results.
    pub study: &'a StabilityStudy,
    /// The resolved scenario.
    pub toml: &'a str,
    /// The command that reproduces it.
    pub line: &'a str,
}

/// Returns the page of a stability analysis.
///
/// # Errors
/// [`HtmlError`].
pub fn stability_html(page: &StabilityPage<'_>) -> Result<String, HtmlError> {
    let StabilityStudy { name, analysis, map, switching, check, .. } = page.study;
    let check = check.as_ref();
    let mut drawn = Drawn::default();
    let (of_map, is_thinned) = Map::of_stability(analysis, map, check);
    drawn.maps.insert("stability".into(), of_map);
    let mut shown = vec![Block::Map { name: "stability".into() }];
    let counted =
        format!("{} by {} points, {:.1} % of them stable", map.x.count, map.y.count, 100.0 * map.stable_share());
    let thinned = if is_thinned { "; the map shows an even selection, stability_map.csv has all" } else { "" };
    shown.push(Block::text(format!("{counted}{thinned}. The boundary is computed on every edge between two points.")));
    shown.extend(check.into_iter().flat_map(|check| checked_blocks(map, check)));
    let mut sections = vec![
        Section { id: "metrics", title: "Closed loop", blocks: vec![loop_block(analysis)] },
        Section { id: "map", title: "Stability map", blocks: shown },
        Section { id: "limits", title: "Limits and sensitivities", blocks: limits(analysis) },
    ];
    if let Some(population) = &page.study.population {
        let lines = population_lines(population).into_iter().map(|line| Block::text(sentence(&line)));
        let table = Block::table("Limits over the population [95 % interval]", &population_table(population));
        sections.push(Section { id: "population", title: "Population", blocks: lines.chain([table]).collect() });
    }
    if !analysis.ports.is_empty() {
        drawn.charts.insert("ports", port_charts(&analysis.ports));
        let text = port_passivity(analysis);
        let blocks = vec![
            Block::table("Two-port of the teleoperator", &port_table(analysis)),
            Block::text(sentence(&text)),
            Block::text(sentence(&bounded_line(analysis, &page.study.bounded))),
            Block::text(sentence(&sampled(analysis))),
            Block::Charts { name: "ports", windows: vec![], key: vec![] },
        ];
        sections.push(Section { id: "ports", title: "Ports over frequency", blocks });
    }
    if let Some(absolute) = &page.study.absolute {
        drawn.charts.insert("absolute", absolute_charts(&absolute::view(name, analysis, absolute)));
        let blocks = vec![
            Block::text(sentence(&absolute_text(absolute))),
            Block::Charts { name: "absolute", windows: vec![], key: vec![] },
        ];
        sections.push(Section { id: "absolute", title: "Absolute stability", blocks });
    }
    if let Some(z_width) = &page.study.z_width {
        drawn.charts.insert("z_width", vec![walls_chart(&z_width::view(name, z_width))]);
        let lines = z_width_text(z_width);
        let charts = Block::Charts { name: "z_width", windows: vec![], key: vec![] };
        let blocks = lines.lines().map(|line| Block::text(sentence(line))).chain([charts]).collect();
        sections.push(Section { id: "z_width", title: "Z-width", blocks });
    }
    let events = match switching {
        Err(reason) => vec![Block::text(format!("{reason}."))],
        Ok(switching) => {
            drawn.charts.insert("switching", vec![growth(switching)]);
            let mut blocks: Vec<Block> =
                switching_lines(page.study, switching).lines().map(|line| Block::text(sentence(line))).collect();
            blocks.push(Block::table("The end of one event, by re-engagement policy", &event_table(&switching.events)));
            blocks.push(Block::Charts { name: "switching", windows: vec![], key: vec![] });
            blocks
        }
    };
    sections.push(Section { id: "events", title: "Events", blocks: events });
    let file = Block::File { name: format!("{name}.toml"), text: without_paths(page.toml) };
    sections.push(Section { id: "scenario", title: "Scenario", blocks: vec![file] });
    let note = "Save the scenario above under its name, then run this command in the same folder.".to_owned();
    let commands = vec![Block::Command { line: page.line.to_owned(), note }];
    sections.push(Section { id: "again", title: "Reproduce", blocks: commands });
    let unmodelled = format!("Not in the linear model: {}.", page.study.unmodelled.join("; "));
    let unreached = page.study.unreached.iter().map(|limit| sentence(&unreached(limit)));
    Page {
        command: "trocar stability",
        heading: name.clone(),
        lead: [sentence(&verdict(page.study)), unmodelled]
            .into_iter()
            .chain(unreached)
            .chain(warned(&page.study.warnings()))
            .collect(),
        sections,
        drawn,
    }
    .render()
}

/// Returns a line as a sentence.
fn sentence(line: &str) -> String {
    let line = line.trim();
    let mut letters = line.chars();
    let first: String = letters.next().into_iter().flat_map(char::to_uppercase).collect();
    format!("{first}{}{}", letters.as_str(), if line.ends_with('.') { "" } else { "." })
}

fn loop_block(analysis: &Analysis) -> Block {
    let rows = loop_lines(analysis).into_iter().map(|(cells, meaning)| Row { cells: cells.to_vec(), meaning });
    let head = ["metric", "value", "at"].map(str::to_owned).to_vec();
    Block::Table { caption: "Properties of the closed loop".into(), head, rows: rows.collect(), is_text: false }
}

fn checked_blocks(map: &StabilityMap, check: &Check) -> Vec<Block> {
    let text = checked(map, check);
    vec![Block::text(sentence(text.lines().next().unwrap_or_default()))]
}

fn limits(analysis: &Analysis) -> Vec<Block> {
    let about = "The maximum stable value of each parameter, with all other parameters of the scenario; and the change of that limit \
                 in per cent if a parameter grows by one per cent.";
    let is_known = |limit: &Parameter| analysis.sensitivities.iter().any(|s| s.limit == *limit);
    let limited: Vec<Parameter> = LIMITED.into_iter().filter(is_known).collect();
    let mut heading = vec!["parameter".to_owned()];
    heading.extend(limited.iter().map(|limit| format!("limit of {}", limit.key())));
    let mut table = Table::new(heading);
    let of = |limit: Parameter, parameter: Parameter| {
        let found = analysis.sensitivities.iter().find(|s| s.limit == limit && s.parameter == parameter);
        found.and_then(|s| s.relative).map_or("—".to_owned(), |relative| format!("{relative:+.3}"))
    };
    for parameter in Parameter::all() {
        if analysis.sensitivities.iter().any(|s| s.parameter == parameter) {
            let cells = limited.iter().map(|limit| of(*limit, parameter));
            table.row([parameter.key().to_owned()].into_iter().chain(cells));
        }
    }
    vec![
        Block::text(about),
        Block::table("Limits", &limit_table(analysis)),
        Block::table("Sensitivities of the limits (% per %)", &table),
    ]
}

fn port_charts(ports: &[PortPoint]) -> Vec<Chart> {
    let column = |of: &dyn Fn(&PortPoint) -> f64| ports.iter().map(of).collect::<Vec<f64>>();
    let frequency = || ChartAxis::new("frequency", "Hz").log();
    let x = column(&|point| point.frequency_hz);
    let chart = |title: &str, y: ChartAxis, lines: Vec<(Series, Vec<f64>)>| {
        let (series, columns): (Vec<_>, Vec<_>) = lines.into_iter().unzip();
        let columns = vec![Columns::new(x.clone(), columns)];
        Chart { series, columns, ..Chart::new(title, frequency(), y) }
    };
    let positive = |value: f64| if value > 0.0 { value } else { f64::NAN };
    let impedance = chart(
        "Impedance",
        ChartAxis::new("impedance", "N·s/m").log(),
        vec![
            (Series::line("in tissue", "vermilion"), column(&|point| positive(point.transmitted.norm()))),
            (Series::line("ideal: the scaled tissue", "blue").dashed(), column(&|point| positive(point.ideal.norm()))),
            (Series::line("in free motion", "green"), column(&|point| positive(point.hybrid.h[0][0].norm()))),
        ],
    );
    let llewellyn = chart(
        "Llewellyn's parameter: absolutely stable from 1 on",
        ChartAxis::new("η", ""),
        vec![(Series::line("η", "black"), column(&|point| point.hybrid.llewellyn().clamp(-2.0, MAX_LLEWELLYN)))],
    );
    let cosine = chart(
        "Real part of the hand's impedance relative to its magnitude: below 0 the port is active",
        ChartAxis::new("Re Z / |Z|", ""),
        vec![
            (Series::line("in tissue", "vermilion"), column(&|p| p.transmitted.re / p.transmitted.norm())),
            (Series::line("in free motion", "green"), column(&|p| p.hybrid.h[0][0].re / p.hybrid.h[0][0].norm())),
        ],
    );
    let level = |mut chart: Chart, value: f64, low: f64, high: f64| {
        chart.extras.thresholds = vec![Level { value: Few(value) }];
        chart.range = Some([Few(low), Few(high)]);
        chart
    };
    let charts = [impedance, level(llewellyn, 1.0, -2.2, MAX_LLEWELLYN + 0.2), level(cosine, 0.0, -1.1, 1.1)];
    charts.map(Chart::described).to_vec()
}

/// Returns Llewellyn's parameter and the damping that a hand needs, over a parameter.
fn absolute_charts(view: &AbsoluteView) -> Vec<Chart> {
    let chart = |title: &str, y: ChartAxis, lines: Vec<(Series, &Vec<f64>)>, level: Option<f64>| {
        let (series, columns): (Vec<_>, Vec<_>) = lines.into_iter().map(|(series, y)| (series, y.clone())).unzip();
        let columns = vec![Columns::new(view.values.clone(), columns)];
        let mut chart = Chart { series, columns, ..Chart::new(title, ChartAxis::new(&view.caption, ""), y) };
        if let Some(level) = level {
            // The level is in view.
            let values = chart.columns.iter().flat_map(|columns| columns.y.iter().flatten()).map(|value| value.0);
            let (low, high) =
                values.filter(|value| value.is_finite()).fold((level, level), |(l, h), v| (l.min(v), h.max(v)));
            chart.extras.thresholds = vec![Level { value: Few(level) }];
            chart.range = Some([Few(low - 0.2), Few(high + 0.2)]);
        }
        chart.described()
    };
    vec![
        chart(
            "Smallest of Llewellyn's parameter: absolutely stable from 1 on",
            ChartAxis::new("η", ""),
            vec![(Series::line("η", "vermilion"), &view.llewellyn)],
            Some(1.0),
        ),
        chart(
            "Damping of the hand",
            ChartAxis::new("damping", "N·s/m"),
            vec![
                (Series::line("needed", "blue"), &view.needed),
                (Series::line("of the scenario's arm", "black").dashed(), &view.of_arm),
            ],
            None,
        ),
    ]
}

/// Returns the maximum stiffness of walls over their damping.
fn walls_chart(view: &ZWidthView) -> Chart {
    let column = |values: &[Option<f64>]| -> Vec<f64> {
        values.iter().map(|value| value.filter(|value| *value > 0.0 && value.is_finite()).unwrap_or(f64::NAN)).collect()
    };
    let of_walls = |walls: &WallsView, place: &str, colour| {
        [
            (Series::line(format!("stable {place}"), colour), column(&walls.stable)),
            (Series::line(format!("passive {place}"), colour).dashed(), column(&walls.passive)),
        ]
    };
    let mut lines = of_walls(&view.tissue, "in the tissue", "blue").to_vec();
    lines.extend(view.virtual_walls.iter().flat_map(|walls| of_walls(walls, "computed by the master", "green")));
    let (series, columns): (Vec<_>, Vec<_>) = lines.into_iter().unzip();
    let (x, y) = (ChartAxis::new("damping of the wall", "N·s/m"), ChartAxis::new("maximum stiffness", "N/m").log());
    let columns = vec![Columns::new(view.damping_n_s_per_m.clone(), columns)];
    Chart { series, columns, ..Chart::new("Z-width: the stiffest walls", x, y) }.described()
}

/// Returns the growth per event over the teleoperation between two events.
fn growth(switching: &Switching) -> Chart {
    let points = &switching.by_dwell;
    let positive = |value: f64| if value > 0.0 { value } else { f64::NAN };
    let x = points.iter().map(|point| seconds(switching, point.dwell_ticks));
    let columns = vec![
        points.iter().map(|point| point.certified.map_or(f64::NAN, positive)).collect(),
        points.iter().map(|point| positive(point.found)).collect(),
    ];
    let (x_axis, y_axis) =
        (ChartAxis::new("teleoperation between events", "s").log(), ChartAxis::new("growth", "").log());
    let mut chart = Chart::new("Growth per event: above 1 the motion grows", x_axis, y_axis);
    chart.series = vec![Series::line("certified bound", "blue"), Series::line("worst sequence found", "vermilion")];
    chart.columns = vec![Columns::new(x, columns)];
    chart.extras.thresholds = vec![Level { value: Few(1.0) }];
    let values = chart.columns.iter().flat_map(|columns| columns.y.iter().flatten());
    let ends =
        values.filter(|value| value.0.is_finite()).fold((1.0_f64, 1.0_f64), |(l, m), v| (l.min(v.0), m.max(v.0)));
    chart.range = Some([Few(ends.0.max(MIN_GROWTH) / 1.5), Few(1.5 * ends.1)]);
    chart.described()
}
