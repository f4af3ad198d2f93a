//! The table, the files and the figure of a study of strategies.

use std::fmt::Write as _;

use serde_json::json;

use super::figures::{StrategyView, strategies as strategies_figure};
use super::pictures::{PictureError, keep};
use super::wrap::wrapped;
use super::{Folder, Table};
use trocar_document::shortest;
use trocar_document::{counted, show, significant};
use trocar_metrics::Unit;
use trocar_studies::compare::{LinearLoops, Person, Sensitivity, StrategyRow, StrategyStudy, WINDOWS_S};

/// Returns a table with a line per strategy, and notes on its reading.
#[must_use]
pub fn strategies_text(study: &StrategyStudy) -> String {
    let heading = [
        "strategy",
        "",
        "excess",
        "5 % above",
        "final excess",
        "noticed",
        "after",
        "d' nothing",
        "d' false alarm",
        "event",
        "force",
        "excess by it",
        "runs",
    ];
    let mut table = Table::new(heading);
    for row in &study.rows {
        let d_prime = |sensitivity: Option<Sensitivity>| {
            sensitivity.map_or("—".into(), |of| format!("{:.1} ± {:.1}", of.d_prime, 1.96 * of.std_error))
        };
        let cost = row.false_alarm;
        table.row([
            row.strategy.to_owned(),
            if row.is_on_front { "*".to_owned() } else { String::new() },
            show(row.mean_excess_m, Unit::Metre),
            show(row.high_excess_m, Unit::Metre),
            show(row.final_excess_m, Unit::Metre),
            show(row.noticed.share(), Unit::Share),
            show(row.noticed_after_s, Unit::Second),
            d_prime(row.against_nothing),
            d_prime(row.against_false_alarms),
            show(cost.map(|cost| cost.event_s), Unit::Second),
            show(cost.map(|cost| cost.force_n), Unit::Newton),
            show(cost.map(|cost| cost.excess_m), Unit::Metre),
            row.verdict.word().to_owned(),
        ]);
    }
    let persons = study.persons.join(", ");
    let mut notes = format!(
        "{}: {}, {}, {} ({persons}).",
        study.name,
        counted(study.patients, "patient"),
        counted(study.seeds, "seed"),
        counted(study.persons.len() as u64, "person"),
    );
    if study.persons.iter().filter_map(|name| Person::named(name)).any(|person| person.group.is_some()) {
        notes.push_str(" Each patient has another member of a group.");
    }
    if let Some([low, median, high]) = study.velocities_m_per_s.map(|all| all.map(|velocity| 1e3 * velocity)) {
        let _ = write!(
            notes,
            " Without a strategy the master moves at {low:.1} to {high:.1} mm/s at 90 % of the ruptures (median {median:.1} mm/s)."
        );
    }
    let LinearLoops { count, stable, min_gain_margin } = study.linear_loops;
    if count > 0 {
        let stable =
            if stable == count { "stable for all".to_owned() } else { format!("stable for {stable} of {count}") };
        let margin =
            min_gain_margin.map_or_else(String::new, |gain| format!(", smallest gain margin {}", significant(gain)));
        let _ = write!(notes, " Linear loop between events: {stable}{margin}.");
    }
    notes.push_str(
        "\n* Pareto front: no other strategy whose runs settle has at most this excess and at least this share of noticed ruptures. \
         event, force and \"excess by it\" are the costs of a false alarm: the duration of its event, the change of the feedback force, and the excess at its end. \"settles\" is a result of these runs, not a proof.\n",
    );
    let correlations = WINDOWS_S.iter().zip(&study.rank_correlations);
    let correlations: Vec<String> = correlations
        .filter_map(|(window_s, correlation)| {
            correlation.map(|correlation| format!("{correlation:.3} for {window_s} s"))
        })
        .collect();
    if !correlations.is_empty() {
        let _ = writeln!(
            notes,
            "Rank correlation of the excess with that of the 2 s after a rupture: {}.",
            correlations.join(", ")
        );
    }
    format!("{table}\n{}", wrapped(&notes, 0))
}

/// Returns the study as JSON.
#[must_use]
pub fn strategies_json(study: &StrategyStudy) -> String {
    let all = json!({
        "trocar_version": env!("CARGO_PKG_VERSION"),
        "windows_s": WINDOWS_S,
        "study": study,
    });
    super::to_json(&all)
}

/// Returns `strategies.csv`: a row per strategy, in SI units. An undefined value is an empty cell.
#[must_use]
pub fn strategies_csv(study: &StrategyStudy) -> String {
    type Read = fn(&StrategyRow) -> Option<f64>;
    let columns: [(&str, Read); 20] = [
        ("runs", |row| Some(row.runs as f64)),
        ("diverged", |row| Some(row.diverged as f64)),
        ("ruptures", |row| Some(row.ruptures as f64)),
        ("missed_ruptures", |row| Some(row.missed_ruptures as f64)),
        ("false_alarms", |row| Some(row.false_alarms as f64)),
        ("mean_excess_m", |row| row.mean_excess_m),
        ("high_excess_m", |row| row.high_excess_m),
        ("depth_at_return_m", |row| row.depth_at_return_m),
        ("unintended_cut_m", |row| row.unintended_cut_m),
        ("final_excess_m", |row| row.final_excess_m),
        ("noticed_share", |row| row.noticed.share()),
        ("noticed_after_s", |row| row.noticed_after_s),
        ("d_prime_nothing", |row| row.against_nothing.map(|of| of.d_prime)),
        ("d_prime_nothing_std_error", |row| row.against_nothing.map(|of| of.std_error)),
        ("d_prime_false_alarm", |row| row.against_false_alarms.map(|of| of.d_prime)),
        ("d_prime_false_alarm_std_error", |row| row.against_false_alarms.map(|of| of.std_error)),
        ("false_alarm_event_s", |row| row.false_alarm.map(|cost| cost.event_s)),
        ("false_alarm_force_n", |row| row.false_alarm.map(|cost| cost.force_n)),
        ("false_alarm_excess_m", |row| row.false_alarm.map(|cost| cost.excess_m)),
        ("is_on_front", |row| Some(f64::from(u8::from(row.is_on_front)))),
    ];
    let names: Vec<&str> = columns.iter().map(|(name, _)| *name).collect();
    let mut text = format!("strategy,{},verdict\n", names.join(","));
    for row in &study.rows {
        let values: Vec<String> = columns.iter().map(|(_, read)| read(row).map_or(String::new(), shortest)).collect();
        let _ = writeln!(text, "{},{},{}", row.strategy, values.join(","), row.verdict.word());
    }
    text
}

/// Draws `strategies.svg` and `strategies.png`: excess against noticed share, with the Pareto front. Without a strategy that has
/// both, nothing is drawn; returns whether it was.
///
/// # Errors
/// [`PictureError`] if the figure cannot be drawn or written.
pub fn strategies_picture(folder: &Folder, study: &StrategyStudy) -> Result<bool, PictureError> {
    let view = |row: &StrategyRow| {
        let (excess_m, noticed) = row.mean_excess_m.zip(row.noticed.share())?;
        Some(StrategyView { name: row.strategy, excess_m, noticed, is_on_front: row.is_on_front })
    };
    let views: Vec<StrategyView<'_>> = study.rows.iter().filter_map(view).collect();
    if views.is_empty() {
        return Ok(false);
    }
    keep(folder, "strategies", &strategies_figure(&study.name, &views)?)?;
    Ok(true)
}
