//! The page of a stability analysis.

use super::compared::without_paths;
use super::page::{Block, Drawn, HtmlError, Page, Row, Section, warned};
use crate::Table;
use crate::absolute;
use crate::absolute::{absolute_text, bounded_line};
use crate::figures;
use crate::loop_verdict::verdict_sentence;
use crate::population::{population_lines, population_table};
use crate::stability::map_figure;
use crate::stability_text::{checked, limit_table, loop_lines, port_passivity, port_table, sampled, unreached};
use crate::switching::{event_table, switching_lines};
use crate::z_width::z_width_text;
use trocar_stability::{Analysis, LIMITED, Parameter, StabilityMap};
use trocar_studies::stability_check::{Check, StabilityStudy};

/// Number of intervals of a line.
const INTERVALS: usize = 1000;

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
    drawn.figures.insert("stability", vec![map_figure(page.study)?.for_page(INTERVALS)]);
    let mut shown = vec![Block::figures("stability")];
    let counted =
        format!("{} by {} points, {:.1} % of them stable", map.x.count, map.y.count, 100.0 * map.stable_share());
    shown.push(Block::text(format!("{counted}. The boundary is computed on every edge between two points.")));
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
        drawn.figures.insert("ports", vec![figures::ports(name, &analysis.ports)?.for_page(INTERVALS)]);
        let text = port_passivity(analysis);
        let blocks = vec![
            Block::table("Two-port of the teleoperator", &port_table(analysis)),
            Block::text(sentence(&text)),
            Block::text(sentence(&bounded_line(analysis, &page.study.bounded))),
            Block::text(sentence(&sampled(analysis))),
            Block::figures("ports"),
        ];
        sections.push(Section { id: "ports", title: "Ports over frequency", blocks });
    }
    if let Some(absolute) = &page.study.absolute {
        let figure = figures::absolute(&absolute::view(name, analysis, absolute))?;
        drawn.figures.insert("absolute", vec![figure.for_page(INTERVALS)]);
        let blocks = vec![Block::text(sentence(&absolute_text(absolute))), Block::figures("absolute")];
        sections.push(Section { id: "absolute", title: "Absolute stability", blocks });
    }
    if let Some(z_width) = &page.study.z_width {
        drawn.figures.insert("z_width", vec![figures::z_width(name, z_width)?.for_page(INTERVALS)]);
        let lines = z_width_text(z_width);
        let charts = Block::figures("z_width");
        let blocks = lines.lines().map(|line| Block::text(sentence(line))).chain([charts]).collect();
        sections.push(Section { id: "z_width", title: "Z-width", blocks });
    }
    let events = match switching {
        Err(reason) => vec![Block::text(format!("{reason}."))],
        Ok(switching) => {
            drawn.figures.insert("switching", vec![crate::switching::figure(name, switching)?.for_page(INTERVALS)]);
            let mut blocks: Vec<Block> =
                switching_lines(page.study, switching).lines().map(|line| Block::text(sentence(line))).collect();
            blocks.push(Block::table("The end of one event, by re-engagement policy", &event_table(&switching.events)));
            blocks.push(Block::figures("switching"));
            blocks
        }
    };
    sections.push(Section { id: "events", title: "Events", blocks: events });
    let file = Block::File { name: format!("{name}.toml"), text: without_paths(page.toml) };
    sections.push(Section { id: "scenario", title: "Scenario", blocks: vec![file] });
    let note = "Save the scenario above under its name, then run this command in the same folder.".to_owned();
    let commands = vec![Block::Command { line: page.line.to_owned(), note }];
    sections.push(Section { id: "again", title: "Reproduce", blocks: commands });
    let unmodelled = format!("Not in the linear model: {}.", page.study.verdict.unmodelled.join("; "));
    let unreached = page.study.verdict.unreached.iter().map(|limit| sentence(&unreached(limit)));
    Page {
        command: "trocar stability",
        heading: name.clone(),
        lead: [sentence(&verdict_sentence(&page.study.verdict)), unmodelled]
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
