//! A stability analysis as text.

use std::fmt::Write as _;

use super::Table;
use super::absolute::bounded_line;
use super::loop_verdict::verdict_sentence;
use super::number::significant;
use super::stability::{all, word};
use super::wrap::wrapped;
use trocar_scenario::unit_of;
use trocar_stability::{Analysis, Limit, LoopLimit, Parameter, PortPoint, StabilityMap, is_passive_impedance};
use trocar_studies::stability_check::{Check, StabilityStudy};

/// Frequencies (Hz) of the printed impedances.
const SHOWN_HZ: [f64; 4] = [0.5, 1.0, 5.0, 10.0];

/// Maximum number of printed disagreements.
const SHOWN_DISAGREEMENTS: usize = 20;

/// Maximum number of listed parameters per limit.
const SHOWN_SENSITIVITIES: usize = 3;

/// Returns the analysis as text with tables.
#[must_use]
pub fn stability_text(study: &StabilityStudy) -> String {
    let StabilityStudy { name, analysis, map, check, .. } = study;
    let mut text = format!("{name}: {}\n", verdict_sentence(&study.verdict));
    let _ = writeln!(text, "not in the linear model: {}", study.verdict.unmodelled.join("; "));
    for limit in &study.verdict.unreached {
        let _ = writeln!(text, "{}", unreached(limit));
    }
    let _ = write!(text, "\n{}\n{}", loop_table(analysis), limit_table(analysis));
    let bounded = bounded_line(analysis, &study.bounded);
    let _ = write!(text, "\n{}\n{}{bounded}{}", port_table(analysis), port_passivity(analysis), sampled(analysis));
    let _ = write!(text, "\n{}\n", super::switching_text(study));
    let stable = 100.0 * map.stable_share();
    let _ = writeln!(
        text,
        "map: {} by {}, {} x {} points, {stable:.1} % stable",
        map.x.parameter.key(),
        map.y.parameter.key(),
        map.x.count,
        map.y.count,
    );
    if let Some(check) = check {
        text.push_str(&checked(map, check));
    }
    wrapped(&text, 2)
}

/// Returns the sentence about a limit that is never reached.
pub(super) fn unreached(limit: &LoopLimit) -> String {
    let bound = limit.part.bound.map_or_else(|| "—".to_owned(), significant);
    let unit = unit_of(limit.part.key).map_or_else(String::new, |unit| format!(" {unit}"));
    format!(
        "never reached in contact or out of it: {}, {}{unit}: at most {bound}{unit} for motions of the hand no farther and no faster than the scenario's",
        limit.part,
        significant(limit.limit),
    )
}

/// A row of the loop's table: quantity, value, frequency; and a sentence that explains the quantity.
pub(super) type LoopLine = ([String; 3], &'static str);

/// Llewellyn's parameter; infinite where one direction of the two-port is cut.
fn eta(value: f64) -> String {
    if value == f64::INFINITY { "∞".into() } else { significant(value) }
}

/// Returns the rows of the loop's table.
pub(super) fn loop_lines(analysis: &Analysis) -> Vec<LoopLine> {
    let (mode, margins) = (&analysis.mode, &analysis.margins);
    let shown = |value: Option<f64>, factor: f64, unit: &str| {
        value.map_or("—".into(), |value| format!("{}{unit}", significant(factor * value)))
    };
    let jitter = analysis.jitter_margin_ticks.map(|ticks| ticks as f64 * analysis.settings.tick_s);
    let jitter = shown(jitter, 1e3, " ms");
    let hertz = |frequency: Option<f64>| shown(frequency, 1.0, " Hz");
    vec![
        (
            ["spectral radius".into(), format!("{:.6}", mode.spectral_radius), String::new()],
            "The magnitude of the slowest pole per tick; below 1 the motion decays.",
        ),
        (
            [
                "dominant mode: damping ratio".into(),
                significant(mode.damping_ratio),
                format!("{} Hz", significant(mode.frequency_hz)),
            ],
            "The damping ratio of the slowest mode; below 0 the mode grows.",
        ),
        (
            ["dominant mode: growth".into(), format!("{} 1/s", significant(mode.growth_per_s)), String::new()],
            "The growth rate of the slowest mode; below 0 the mode decays.",
        ),
        (
            ["gain margin".into(), shown(margins.gain, 1.0, " times"), hertz(margins.gain_frequency_hz)],
            "The factor by which the gain of the loop can change before the loop becomes unstable.",
        ),
        (
            [
                "phase margin".into(),
                shown(margins.phase_rad.map(f64::to_degrees), 1.0, "°"),
                hertz(margins.phase_frequency_hz),
            ],
            "The phase lag that can be added before the loop becomes unstable.",
        ),
        (
            ["delay margin (round trip)".into(), shown(margins.delay_s, 1e3, " ms"), String::new()],
            "The round-trip delay that can be added before the loop becomes unstable.",
        ),
        (
            ["jitter margin (each way)".into(), jitter, String::new()],
            "The jitter that can be added to the delays both ways with every order of them proved to be stable (small gain).",
        ),
    ]
}

fn loop_table(analysis: &Analysis) -> Table {
    let mut table = Table::new(["loop", "value", "at"]);
    for (cells, _) in loop_lines(analysis) {
        table.row(cells);
    }
    table
}

pub(super) fn limit_table(analysis: &Analysis) -> Table {
    let mut table = Table::new(["parameter", "value", "maximum stable", "most sensitive to (% per %)"]);
    for limit in &analysis.limits {
        let mut strongest: Vec<(Parameter, f64)> = analysis
            .sensitivities
            .iter()
            .filter(|s| s.limit == limit.parameter)
            .filter_map(|s| Some((s.parameter, s.relative?)))
            .collect();
        strongest.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
        let strongest: Vec<String> = strongest
            .iter()
            .take(SHOWN_SENSITIVITIES)
            .map(|(parameter, relative)| format!("{} {relative:+.2}", parameter.key()))
            .collect();
        let key = limit.parameter.key();
        let unit = unit_of(key).map_or(String::new(), |unit| format!(" {unit}"));
        let value = format!("{}{unit}", significant(limit.value));
        table.row([key.into(), value, largest(limit, &unit), strongest.join(", ")]);
    }
    table.flush_left()
}

fn largest(limit: &Limit, unit: &str) -> String {
    let value = match limit.largest() {
        None => "none".into(),
        Some(largest) if largest.is_infinite() => format!("above {}{unit}", significant(limit.search.high)),
        Some(largest) => format!("{}{unit}", significant(largest)),
    };
    let ranges = limit.stable.iter().map(|(from, to)| format!("{} to {}{unit}", significant(*from), significant(*to)));
    if limit.is_not_all() { format!("{value} (stable: {})", ranges.collect::<Vec<_>>().join(", ")) } else { value }
}

pub(super) fn port_table(analysis: &Analysis) -> Table {
    let mut table = Table::new([
        "ports (|Z| in N·s/m)",
        "|Z| in free motion",
        "|Z| in tissue",
        "|Z| ideal",
        "η",
        "absolutely stable",
        "passive",
    ]);
    for shown_hz in SHOWN_HZ {
        let distance = |point: &&PortPoint| (point.frequency_hz / shown_hz).ln().abs();
        let Some(point) = analysis.ports.iter().min_by(|a, b| distance(a).total_cmp(&distance(b))) else { continue };
        let yes = |holds: bool| if holds { "yes" } else { "no" }.to_owned();
        table.row([
            format!("{} Hz", significant(point.frequency_hz)),
            significant(point.hybrid.h[0][0].norm()),
            significant(point.transmitted.norm()),
            significant(point.ideal.norm()),
            eta(point.hybrid.llewellyn()),
            yes(point.is_absolutely_stable),
            yes(point.is_passive),
        ]);
    }
    table.row([
        "at every frequency".to_owned(),
        String::new(),
        String::new(),
        String::new(),
        String::new(),
        yes_or_no(all(&analysis.ports, |point| point.is_absolutely_stable)),
        yes_or_no(all(&analysis.ports, |point| point.is_passive)),
    ]);
    table
}

fn yes_or_no(holds: Option<bool>) -> String {
    match holds {
        Some(true) => "yes",
        Some(false) => "no",
        None => "—",
    }
    .into()
}

/// Returns a line that says whether each port is passive at every frequency, with the other port terminated as in the scenario.
pub(super) fn port_passivity(analysis: &Analysis) -> String {
    let ports = &analysis.ports;
    format!(
        "hand port passive in free motion: {}, in tissue: {}; needle port passive with a fixed hand: {}\n",
        yes_or_no(all(ports, |point| is_passive_impedance(point.hybrid.h[0][0]))),
        yes_or_no(all(ports, |point| is_passive_impedance(point.transmitted))),
        yes_or_no(all(ports, |point| is_passive_impedance(point.hybrid.h[1][1]))),
    )
}

/// Returns a line about the sampled-data passivity condition.
pub(super) fn sampled(analysis: &Analysis) -> String {
    let Some(bound) = analysis.sampled else {
        return "sampled-data passivity: the condition does not apply (it needs a force that depends on the sampled position only)\n".into();
    };
    format!(
        "sampled-data passivity: needs {} N·s/m at the master, which has {}: {}\n",
        significant(bound.min_damping_n_s_per_m),
        significant(bound.damping_n_s_per_m),
        if bound.is_passive() { "passive" } else { "not passive" },
    )
}

/// Returns the comparison of the map with simulated runs, with a table of the disagreements.
pub(super) fn checked(map: &StabilityMap, check: &Check) -> String {
    let disagreeing = check.disagreements.iter().filter(|d| !d.is_near_boundary).count();
    let judged = check.judged;
    let mut text = match check.agreement() {
        None => "Simulation: no point is more than 0.5 % from the boundary.\n".into(),
        Some(_) if disagreeing == 0 => {
            format!("Simulation: all {judged} points more than 0.5 % from the boundary agree.\n")
        }
        Some(share) => format!(
            "Simulation: of {judged} points more than 0.5 % from the boundary, {:.3} % agree and {disagreeing} disagree.\n",
            100.0 * share
        ),
    };
    if check.disagreements.is_empty() {
        return text;
    }
    let mut table =
        Table::new([map.x.parameter.key(), map.y.parameter.key(), "analysis", "simulation", "near the boundary"]);
    for d in check.disagreements.iter().take(SHOWN_DISAGREEMENTS) {
        table.row([
            significant(d.x),
            significant(d.y),
            if d.analytic_stable { "stable" } else { "not stable" }.to_owned(),
            word(d.simulated).to_owned(),
            if d.is_near_boundary { "yes" } else { "no" }.to_owned(),
        ]);
    }
    let _ = write!(text, "\n{table}");
    let more = check.disagreements.len().saturating_sub(SHOWN_DISAGREEMENTS);
    if more > 0 {
        let _ = writeln!(text, "and {more} more, in stability.json");
    }
    text
}
