use std::fmt::Write as _;

use crate::compare::NoiseCheck;
use crate::sweep::Column;
use trocar_engine::engine::{TRACE_COLUMNS, TRUST_COLUMNS};
use trocar_metrics::{Declaration, Scope};

pub fn declarations() -> impl Iterator<Item = &'static Declaration> {
    Column::declarations().chain(NoiseCheck::METRICS.iter().map(|metric| &metric.declaration))
}

/// Ruptures and events have the number 1.
pub fn metrics_markdown() -> String {
    let mut text = String::new();
    let mut last: Option<Scope> = None;
    for metric in declarations() {
        if last != Some(metric.scope) {
            let gap = if last.is_some() { "\n" } else { "" };
            let about = about(metric.scope);
            let _ =
                writeln!(text, "{gap}{about}\n\n| metric | label | unit | better | meaning |\n|---|---|---|---|---|");
            last = Some(metric.scope);
        }
        let label = metric.full_label(1).replace('|', "\\|");
        let (unit, better) = (metric.unit.si(), metric.better.word());
        let _ = writeln!(text, "| `{}` | {label} | {unit} | {better} | {} |", metric.key(1), metric.meaning);
    }
    text
}

fn about(scope: Scope) -> &'static str {
    match scope {
        Scope::Run => "Metrics of a run:",
        Scope::Link => "Metrics of the link:",
        Scope::Port => "Energies at the ports of a run, not in sweeps, and the balance of the parts between them:",
        Scope::Rupture => "Metrics of a rupture, with its number:",
        Scope::Event => "Metrics of an augmented event, with its number:",
        Scope::Loop => "Metrics of the control loop, in sweeps:",
        Scope::Noise => "Metrics of the detection in added noise, in comparisons:",
    }
}

pub fn trace_columns_markdown() -> String {
    let mut text = "| column | unit | meaning |\n|---|---|---|\n".to_owned();
    for column in TRACE_COLUMNS.iter().chain(&TRUST_COLUMNS) {
        let _ = writeln!(text, "| `{}` | {} | {} |", column.name, column.unit, column.meaning);
    }
    text
}
