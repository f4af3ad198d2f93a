use schemars::JsonSchema;
use serde::Serialize;

use super::{LinearLoops, Person, REACHED_SHARE, StrategyRow, StrategyStudy, WINDOWS_S};
use crate::compare::Sensitivity;
use trocar_document::figure::extent;
use trocar_document::{
    Cell, DataTable, Digits, Document, Number, Section, Study, Table, Verdict, counted, json_of, show, significant,
};
use trocar_figures::{StrategyView, strategies as strategies_figure};
use trocar_metrics::Unit;

impl Study for StrategyStudy {
    fn document(&self) -> Document<'_> {
        let mut section = Section::new("strategies", "Strategies");
        section.figure("strategies");
        section.table(table(self));
        section.text(format!(
            "reached: ruptures relative to those without a strategy. * Pareto front: no other strategy whose runs settle and that \
             reaches at least {} % of the ruptures has at most this excess and at least this share of noticed ruptures. event, force \
             and \"excess by it\" are the costs of a false alarm: the duration of its event, the change of the feedback force, and the \
             excess at its end.",
            100.0 * REACHED_SHARE
        ));
        section.text(about(self));
        section.text(correlations(self));
        let mut document = Document {
            name: "strategies",
            title: self.name.clone(),
            verdict: verdict(self),
            sections: vec![section],
            data: vec![columns(self)],
            json: json_of(&StrategiesFile {
                trocar_version: env!("CARGO_PKG_VERSION"),
                windows_s: WINDOWS_S,
                study: self,
            }),
            ..Document::default()
        };
        let view = |row: &'_ StrategyRow| StrategyView {
            name: row.strategy,
            reached: row.reached_share,
            noticed: row.noticed.share(),
            excess_m: row.mean_excess_m,
            high_excess_m: row.high_excess_m,
            final_excess_m: row.final_excess_m,
            is_compared: row.is_compared(),
            is_on_front: row.is_on_front,
        };
        let views: Vec<StrategyView<'_>> = self.rows.iter().map(view).collect();
        document.figure("strategies", strategies_figure(&self.name, &views));
        document
    }
}

/// `strategies.json`: every strategy over all patients, persons and seeds.
#[derive(Debug, Serialize, JsonSchema)]
pub struct StrategiesFile<'a> {
    /// Version of trocar.
    trocar_version: &'static str,
    /// The windows after a rupture over which the excess is measured, in s.
    windows_s: [f64; WINDOWS_S.len()],
    study: &'a StrategyStudy,
}

fn verdict(study: &StrategyStudy) -> Verdict {
    let compared = || study.rows.iter().filter(|row| row.is_compared());
    let mut sentences = vec![];
    let none = &study.rows[0];
    let least = compared().filter_map(|row| Some((row, row.mean_excess_m?))).min_by(|a, b| a.1.total_cmp(&b.1));
    let most = compared().filter_map(|row| Some((row, row.noticed.share()?))).max_by(|a, b| a.1.total_cmp(&b.1));
    let excess = |row: &StrategyRow| show(row.mean_excess_m, Unit::Metre);
    let noticed = |row: &StrategyRow| show(row.noticed.share(), Unit::Share);
    if let (Some((least, _)), Some((most, _))) = (least, most) {
        let excess = match least.strategy == none.strategy {
            true => format!("none has a smaller mean excess than the scheme without a strategy ({})", excess(none)),
            false => {
                format!(
                    "{} has the smallest mean excess ({}, {} without a strategy)",
                    least.strategy,
                    excess(least),
                    excess(none)
                )
            }
        };
        sentences.push(format!(
            "Of the {} strategies that reach at least {} % of the ruptures, {excess}; the ruptures are noticed most often with {} ({}, {} \
             without a strategy).",
            compared().count(),
            100.0 * REACHED_SHARE,
            most.strategy,
            noticed(most),
            noticed(none),
        ));
    }
    let short: Vec<&StrategyRow> =
        study.rows.iter().filter(|row| none.ruptures > 0 && !row.reaches_the_ruptures()).collect();
    if !short.is_empty() {
        let names: Vec<&str> = short.iter().map(|row| row.strategy).collect();
        let range = |values: &[f64], unit: Unit| {
            let (low, high) = extent(values.iter().copied()).unwrap_or_default();
            let (low, high) = (show(Some(low), unit), show(Some(high), unit));
            if low == high { low } else { format!("{low} to {high}") }
        };
        let shares: Vec<f64> = short.iter().filter_map(|row| row.reached_share).collect();
        let ends_m: Vec<f64> = short.iter().filter_map(|row| row.final_excess_m).collect();
        let end = if ends_m.is_empty() {
            String::new()
        } else {
            format!(", and the needle ends at {} from the intended depth", range(&ends_m, Unit::Metre))
        };
        sentences.push(format!(
            "With {} only {} of the ruptures happen{end}: their excess cannot be compared with that of the others.",
            names.join(", "),
            range(&shares, Unit::Share)
        ));
    }
    if none.ruptures == 0 {
        sentences.push("No layer ruptures without a strategy: nothing can be compared.".into());
    }
    let unsettled: Vec<String> = study
        .rows
        .iter()
        .filter(|row| row.verdict != super::Verdict::Settles)
        .map(|row| format!("{} {}", row.strategy, row.verdict.word()))
        .collect();
    if !unsettled.is_empty() {
        sentences.push(format!("{}.", unsettled.join(", ")));
    }
    let LinearLoops { count, stable, .. } = study.linear_loops;
    if stable < count {
        let all = format!("The loop between events is stable for {stable} of {count} patients and persons.");
        sentences.insert(0, all);
    }
    Verdict { sentences, left_out: vec!["\"settles\" is a result of these runs, not a proof".to_owned()] }
}

fn about(study: &StrategyStudy) -> String {
    let mut studied = format!(
        "{}, {}, {} ({})",
        counted(study.patients, "patient"),
        counted(study.seeds, "seed"),
        counted(study.persons.len() as u64, "person"),
        study.persons.join(", "),
    );
    if study.persons.iter().filter_map(|name| Person::named(name)).any(|person| person.group.is_some()) {
        studied.push_str("; each patient has another member of a group");
    }
    let mut sentences = vec![format!("{studied}.")];
    if let Some([low, median, high]) = study.velocities_m_per_s.map(|all| all.map(|velocity| 1e3 * velocity)) {
        sentences.push(format!(
            "Without a strategy the master moves at {low:.1} to {high:.1} mm/s at 90 % of the ruptures (median {median:.1} mm/s)."
        ));
    }
    let LinearLoops { count, stable, min_gain_margin, unlimited } = study.linear_loops;
    if count > 0 {
        let stable =
            if stable == count { "stable for all".to_owned() } else { format!("stable for {stable} of {count}") };
        let margin = match min_gain_margin {
            Some(gain) => format!(", smallest gain margin {}", significant(gain)),
            None if unlimited > 0 => ", unlimited gain margin".to_owned(),
            None => String::new(),
        };
        sentences.push(format!("Linear loop between events: {stable}{margin}."));
    }
    sentences.join(" ")
}

fn table(study: &StrategyStudy) -> Table {
    let columns = [
        ("strategy", "strategy"),
        ("front", ""),
        ("reached_share", "reached"),
        ("missed_share", "missed"),
        ("noticed_share", "noticed"),
        ("mean_excess_m", "excess"),
        ("high_excess_m", "5 % above"),
        ("final_excess_m", "final excess"),
        ("noticed_after_s", "after"),
        ("d_prime_nothing", "d' nothing"),
        ("d_prime_false_alarm", "d' false alarm"),
        ("false_alarm_event_s", "event"),
        ("false_alarm_force_n", "force"),
        ("false_alarm_excess_m", "excess by it"),
        ("verdict", "runs"),
    ];
    let d_prime = |sensitivity: Option<Sensitivity>| {
        sensitivity.map_or(Cell::Undefined, |of| {
            Cell::PlusMinus(Number::si(of.d_prime, "").digits(Digits::Decimals(1)), 1.96 * of.std_error)
        })
    };
    let mut table = Table::new("strategies", "Strategies against a rupture", columns);
    for row in &study.rows {
        let cost = row.false_alarm;
        table.row([
            Cell::from(row.strategy),
            Cell::from(if row.is_on_front { "*" } else { "" }),
            Cell::of(row.reached_share, Unit::Share),
            Cell::of(missed_share(row), Unit::Share),
            Cell::of(row.noticed.share(), Unit::Share),
            Cell::of(row.mean_excess_m, Unit::Metre),
            Cell::of(row.high_excess_m, Unit::Metre),
            Cell::of(row.final_excess_m, Unit::Metre),
            Cell::of(row.noticed_after_s, Unit::Second),
            d_prime(row.against_nothing),
            d_prime(row.against_false_alarms),
            Cell::of(cost.map(|cost| cost.event_s), Unit::Second),
            Cell::of(cost.map(|cost| cost.force_n), Unit::Newton),
            Cell::of(cost.map(|cost| cost.excess_m), Unit::Metre),
            Cell::from(row.verdict.word()),
        ]);
    }
    table
}

fn missed_share(row: &StrategyRow) -> Option<f64> {
    (row.ruptures > 0).then(|| row.missed_ruptures as f64 / row.ruptures as f64)
}

fn correlations(study: &StrategyStudy) -> String {
    let correlations = WINDOWS_S.iter().zip(&study.rank_correlations);
    let text = |(window_s, correlation): (&f64, &Option<f64>)| {
        correlation.map(|correlation| format!("{correlation:.3} for {window_s} s"))
    };
    let correlations: Vec<String> = correlations.filter_map(text).collect();
    if correlations.is_empty() {
        return String::new();
    }
    format!("Rank correlation of the excess with that of the 2 s after a rupture: {}.", correlations.join(", "))
}

fn columns(study: &StrategyStudy) -> DataTable<'_> {
    type Read = fn(&StrategyRow) -> Option<f64>;
    let columns: [(&str, Read); 21] = [
        ("runs", |row| Some(row.runs as f64)),
        ("diverged", |row| Some(row.diverged as f64)),
        ("ruptures", |row| Some(row.ruptures as f64)),
        ("reached_share", |row| row.reached_share),
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
    let mut data = DataTable::new("strategies").texts("strategy", study.rows.iter().map(|row| row.strategy));
    for (name, read) in columns {
        data = data.optional(name, study.rows.iter().map(read));
    }
    data.texts("verdict", study.rows.iter().map(|row| row.verdict.word()))
}
