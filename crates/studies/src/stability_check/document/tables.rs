use super::json::all;
use crate::stability_check::{Check, EventLimit};
use trocar_document::{Cell, Digits, Number, Shown, Table, significant};
use trocar_scenario::unit_of;
use trocar_stability::{
    Analysis, LIMITED, LeftOut, Limit, LoopLimit, Parameter, PortPoint, StabilityMap, is_passive_impedance,
};

const SHOWN_HZ: [f64; 4] = [0.5, 1.0, 5.0, 10.0];

const SHOWN_UNCONFIRMED: usize = 20;

const SHOWN_SENSITIVITIES: usize = 3;

pub(super) fn unreached(limit: &LoopLimit) -> String {
    let bound = limit.part.bound.map_or_else(|| "—".to_owned(), significant);
    let unit = unit_of(limit.part.key).map_or_else(String::new, |unit| format!(" {unit}"));
    format!(
        "never reached in contact or out of it: {}, {}{unit}: at most {bound}{unit} for motions of the hand no farther and no faster than the scenario's",
        limit.part,
        significant(limit.limit),
    )
}

pub(super) fn loop_table(analysis: &Analysis) -> Table {
    let (mode, margins) = (&analysis.mode, &analysis.margins);
    let jitter_s = analysis.jitter_margin_ticks.map(|ticks| ticks as f64 * analysis.settings.tick_s);
    let jitter_s = if analysis.is_jitter_unlimited() { Some(f64::INFINITY) } else { jitter_s };
    let hertz = |value: Option<f64>| Cell::si(value, "Hz");
    let times = |value: f64| Number::si(value, "times");
    let degrees = |value: f64| Number { factor: 1.0_f64.to_degrees(), unit: "°".into(), ..Number::si(value, "") };
    let columns = [("quantity", "loop"), ("value", "value"), ("frequency_hz", "at")];
    let mut table = Table::new("loop", "Properties of the closed loop", columns);
    let radius = Number::si(mode.spectral_radius, "").digits(Digits::Decimals(6));
    table.explained(
        ["spectral radius".into(), radius.into(), Cell::empty()],
        "The magnitude of the slowest pole per tick; below 1 the motion decays.",
    );
    table.explained(
        [
            "dominant mode: damping ratio".into(),
            Number::si(mode.damping_ratio, "").into(),
            hertz(Some(mode.frequency_hz)),
        ],
        "The damping ratio of the slowest mode; below 0 the mode grows.",
    );
    table.explained(
        ["dominant mode: growth".into(), Number::si(mode.growth_per_s, "1/s").into(), Cell::empty()],
        "The growth rate of the slowest mode; below 0 the mode decays.",
    );
    table.explained(
        ["gain margin".into(), margin(margins.gain, times), hertz(margins.gain_frequency_hz)],
        "The factor by which the gain of the loop can change before the loop becomes unstable.",
    );
    table.explained(
        ["phase margin".into(), margin(margins.phase_rad, degrees), hertz(margins.phase_frequency_hz)],
        "The phase lag that can be added before the loop becomes unstable.",
    );
    table.explained(
        ["delay margin (round trip)".into(), margin(margins.delay_s, Number::milliseconds), Cell::empty()],
        "The round-trip delay that can be added before the loop becomes unstable.",
    );
    table.explained(
        ["jitter margin (each way)".into(), margin(jitter_s, Number::milliseconds), Cell::empty()],
        "The jitter that can be added to the delays of both directions; stability is then proved for every order of the delays (small gain).",
    );
    table
}

/// `—` for an unstable loop.
fn margin(value: Option<f64>, number: impl Fn(f64) -> Number) -> Cell {
    match value {
        None => Cell::Undefined,
        Some(f64::INFINITY) => "unlimited".into(),
        Some(value) => number(value).into(),
    }
}

pub(super) fn limits_line(analysis: &Analysis) -> String {
    let of_limit = |limit: &Limit| {
        let unit = unit_of(limit.parameter.key()).unwrap_or_default();
        let caption = limit.parameter.caption().split(" (").next().unwrap_or_default().to_lowercase();
        format!("{caption} {} (here {})", largest(limit, &unit), Number::si(limit.value, unit.as_str()))
    };
    let limits: Vec<String> = analysis.limits.iter().map(of_limit).collect();
    format!("Largest stable values, each with all else unchanged: {}.", limits.join(", "))
}

pub(super) fn limit_table(analysis: &Analysis) -> Table {
    let columns = [
        ("parameter", "parameter"),
        ("value", "value"),
        ("largest_stable", "maximum stable"),
        ("sensitivities", "most sensitive to (% per %)"),
    ];
    let mut table = Table::new("limits", "Limits", columns).of_text();
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
        let unit = unit_of(key).unwrap_or_default();
        table.row([
            Cell::from(key),
            Number::si(limit.value, unit.as_str()).into(),
            largest(limit, &unit),
            strongest.join(", ").into(),
        ]);
    }
    table
}

pub(super) fn event_limit_table(limits: &[EventLimit]) -> Table {
    let columns = [("parameter", "parameter of events"), ("value", "value"), ("certified", "certified")];
    let mut table = Table::new("event_limits", "Limits of the certificate of events", columns).of_text();
    for limit in limits {
        let unit = unit_of(limit.key).unwrap_or_default();
        let number = |value: f64| Number::si(value, unit.as_str());
        let certified = match (limit.certified, limit.is_largest) {
            (None, _) => "none".to_owned(),
            (Some(found), is_largest) => {
                let word = if is_largest { "up to" } else { "from" };
                let beyond = if limit.is_beyond_search { " (the end of the search)" } else { "" };
                format!("{word} {}{beyond}", number(found))
            }
        };
        table.row([Cell::from(limit.key), number(limit.value).into(), certified.into()]);
    }
    table
}

fn largest(limit: &Limit, unit: &str) -> Cell {
    let number = |value: f64| Number::si(value, unit);
    let value: Cell = match limit.largest() {
        None => "none".into(),
        Some(largest) if largest.is_infinite() => format!("above {}", number(limit.search.high)).into(),
        Some(largest) => number(largest).into(),
    };
    if !limit.is_not_all() {
        return value;
    }
    let ranges = limit.stable.iter().map(|(from, to)| format!("{} to {}", significant(*from), number(*to)));
    format!("{value} (stable: {})", ranges.collect::<Vec<_>>().join(", ")).into()
}

pub(super) fn sensitivity_table(analysis: &Analysis) -> Table {
    let is_known = |limit: &Parameter| analysis.sensitivities.iter().any(|s| s.limit == *limit);
    let limited: Vec<Parameter> = LIMITED.into_iter().filter(is_known).collect();
    let columns = limited.iter().map(|limit| (limit.key(), format!("limit of {}", limit.key())));
    let columns = std::iter::once(("parameter", "parameter".to_owned())).chain(columns);
    let mut table =
        Table::new("sensitivities", "Sensitivities of the limits (% per %)", columns).shown(Shown::InReports);
    let of = |limit: Parameter, parameter: Parameter| {
        let found = analysis.sensitivities.iter().find(|s| s.limit == limit && s.parameter == parameter);
        let relative = found.and_then(|s| s.relative);
        relative.map_or(Cell::Undefined, |relative| Number::si(relative, "").digits(Digits::Signed(3)).into())
    };
    for parameter in Parameter::all() {
        if analysis.sensitivities.iter().any(|s| s.parameter == parameter) {
            let cells = limited.iter().map(|limit| of(*limit, parameter));
            table.row(std::iter::once(Cell::from(parameter.key())).chain(cells));
        }
    }
    table
}

pub(super) fn port_table(analysis: &Analysis) -> Table {
    let columns = [
        ("frequency_hz", "ports (|Z| in N·s/m)"),
        ("free_n_s_per_m", "|Z| in free motion"),
        ("tissue_n_s_per_m", "|Z| in tissue"),
        ("ideal_n_s_per_m", "|Z| ideal"),
        ("llewellyn", "η"),
        ("is_absolutely_stable", "absolutely stable"),
        ("is_passive", "passive"),
    ];
    let mut table = Table::new("ports", "Two-port of the teleoperator", columns);
    let plain = |value: f64| Cell::from(Number::si(value, ""));
    for shown_hz in SHOWN_HZ {
        let distance = |point: &&PortPoint| (point.frequency_hz / shown_hz).ln().abs();
        let Some(point) = analysis.ports.iter().min_by(|a, b| distance(a).total_cmp(&distance(b))) else { continue };
        let llewellyn = point.hybrid.llewellyn();
        table.row([
            Number::si(point.frequency_hz, "Hz").into(),
            plain(point.hybrid.h[0][0].norm()),
            plain(point.transmitted.norm()),
            plain(point.ideal.norm()),
            // Llewellyn's parameter is infinite if one direction of the two-port is cut.
            if llewellyn == f64::INFINITY { "∞".into() } else { plain(llewellyn) },
            Cell::Flag(point.is_absolutely_stable),
            Cell::Flag(point.is_passive),
        ]);
    }
    table.row([
        "at every frequency".into(),
        Cell::empty(),
        Cell::empty(),
        Cell::empty(),
        Cell::empty(),
        Cell::flag(all(&analysis.ports, |point| point.is_absolutely_stable)),
        Cell::flag(all(&analysis.ports, |point| point.is_passive)),
    ]);
    table
}

/// The other port is terminated as in the scenario.
pub(super) fn port_passivity(analysis: &Analysis) -> String {
    let ports = &analysis.ports;
    format!(
        "hand port passive in free motion: {}, in tissue: {}; needle port passive with a fixed hand: {}",
        Cell::flag(all(ports, |point| is_passive_impedance(point.hybrid.h[0][0]))),
        Cell::flag(all(ports, |point| is_passive_impedance(point.transmitted))),
        Cell::flag(all(ports, |point| is_passive_impedance(point.hybrid.h[1][1]))),
    )
}

pub(super) fn sampled(analysis: &Analysis) -> String {
    let Some(bound) = analysis.sampled else {
        return "sampled-data passivity: the condition does not apply (it needs a force that depends on the sampled position only)".into();
    };
    format!(
        "sampled-data passivity: needs {} N·s/m at the master, which has {}: {}",
        significant(bound.min_damping_n_s_per_m),
        significant(bound.damping_n_s_per_m),
        if bound.is_passive() { "passive" } else { "not passive" },
    )
}

pub(super) fn map_line(map: &StabilityMap) -> String {
    format!(
        "map: {} by {}, {} x {} points, {:.1} % stable",
        map.x.parameter.key(),
        map.y.parameter.key(),
        map.x.count,
        map.y.count,
        100.0 * map.stable_share(),
    )
}

pub(super) fn checked_line(check: &Check, left_out: &[LeftOut]) -> String {
    let judged = check.judged;
    let points = format!("{judged} points more than 0.5 % from the boundary");
    let counted = match check.counts() {
        _ if judged == 0 => "no point is more than 0.5 % from the boundary".to_owned(),
        [_, 0, 0] => format!("all {points} agree"),
        [agreeing, disagreeing, 0] => format!("of {points}, {agreeing} agree and {disagreeing} disagree"),
        [agreeing, disagreeing, undecided] => {
            format!("of {points}, {agreeing} agree, {disagreeing} disagree and {undecided} are undecided")
        }
    };
    let parts: Vec<String> = left_out.iter().map(LeftOut::to_string).collect();
    let without = if parts.is_empty() { String::new() } else { format!(", without {}", parts.join(", ")) };
    format!("Simulation{without}: {counted}.")
}

pub(super) fn unconfirmed(map: &StabilityMap, check: &Check) -> Option<(Table, Option<String>)> {
    let columns = [
        (map.x.parameter.key(), map.x.parameter.key()),
        (map.y.parameter.key(), map.y.parameter.key()),
        ("analysis", "analysis"),
        ("simulation", "simulation"),
        ("is_near_boundary", "near the boundary"),
    ];
    let title = "Points at which the simulation disagrees or is undecided";
    let mut table = Table::new("disagreements", title, columns);
    for point in check.disagreements.iter().chain(&check.undecided).take(SHOWN_UNCONFIRMED) {
        table.row([
            Number::si(point.x, "").into(),
            Number::si(point.y, "").into(),
            Cell::from(if point.analytic_stable { "stable" } else { "not stable" }),
            point.simulated.word().into(),
            Cell::Flag(point.is_near_boundary),
        ]);
    }
    let all = check.disagreements.len() + check.undecided.len();
    let more = all.saturating_sub(SHOWN_UNCONFIRMED);
    let more = (more > 0).then(|| format!("and {more} more, in stability.json"));
    (all > 0).then_some((table, more))
}
