//! The document of one side of a link.

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value as Json;

use super::{Role, SideSummary, Spread};
use trocar_base::unit::Unit;
use trocar_base::warning::{Code, Warning};
use trocar_document::{Cell, Document, Number, Section, Study, Table, Verdict, counted, json_of, show};

impl Study for SideSummary {
    fn document(&self) -> Document<'_> {
        let (done, all) = self.ticks;
        let mut section = Section::new("side", "Messages and times");
        section.table(messages(self));
        section.table(times(self));
        section.text(format!(
            "scheduler: {}; {} began after the next was due",
            self.priority,
            counted(self.lateness.missed, "tick")
        ));
        section.text(format!("clocks of both sides agree to {}", show(Some(self.clock_s), Unit::Second)));
        if self.role == Role::Slave {
            section.text(format!("ruptures: {}", listed(&self.ruptures_s)));
            section.text(format!("alarms: {}", listed(&self.alarms_s)));
        }
        Document {
            name: "summary",
            title: format!("{} {}", self.scenario, self.role.word()),
            verdict: Verdict {
                sentences: vec![
                    format!("{done} of {all} ticks of {}.", show(Some(self.tick_s), Unit::Second)),
                    promise(self),
                ],
                left_out: vec![],
            },
            warnings: warnings(self),
            sections: vec![section],
            json: json(self),
            ..Document::default()
        }
    }
}

fn warnings(summary: &SideSummary) -> Vec<Warning> {
    let (this, other) = (summary.role.word(), summary.role.other().word());
    let mut warnings = vec![];
    if summary.restarts > 0 {
        let message =
            format!("the {other} was started anew and joined the {this}, {}", counted(summary.restarts, "time"));
        warnings.push(Warning::new(Code::PeerRestarted, message).remedy(format!("look at the {other}'s message")));
    }
    if summary.first_tick > 0 {
        let message = format!(
            "the {this} joined the {other} at tick {}; it computed the ticks before without messages",
            summary.first_tick
        );
        warnings.push(Warning::new(Code::PeerRestarted, message).remedy("start both sides again for a whole run"));
    }
    warnings.extend(silence(summary, other).map(|warning| warning.at("channel.outage_s")));
    warnings
}

fn silence(summary: &SideSummary, other: &str) -> Option<Warning> {
    Some(match (summary.silent_since_s, summary.silences) {
        (Some(since_s), _) => {
            let message = format!("nothing has come from the {other} since {}", show(Some(since_s), Unit::Second));
            Warning::new(Code::PeerSilent, message)
                .remedy(format!("start both sides again; look at the {other}'s message"))
        }
        (None, 0) => return None,
        (None, count) => {
            let message = format!("the {other} was silent for a time and came back, {}", counted(count, "time"));
            Warning::new(Code::PeerSilent, message)
                .remedy("look at delays.csv, the network and the other computer's load")
        }
    })
}

fn promise(summary: &SideSummary) -> String {
    let meter = &summary.meter;
    let generated = format!("The ports generated {}", show(Some(meter.generated_j), Unit::Joule));
    match meter.promised_j {
        None => format!("{generated}; no scheme, no promise."),
        Some(promised_j) => format!(
            "{generated}; the scheme promises at most {}: {}.",
            show(Some(promised_j), Unit::Joule),
            if meter.generated_j <= promised_j { "kept" } else { "NOT kept" }
        ),
    }
}

fn listed(times_s: &[f64]) -> String {
    match times_s {
        [] => "none".to_owned(),
        times_s => times_s.iter().map(|time_s| format!("{time_s} s")).collect::<Vec<_>>().join(", "),
    }
}

fn messages(summary: &SideSummary) -> Table {
    let counters = &summary.counters;
    let received = format!("messages of the {} received", summary.role.other().word());
    let mut table = Table::new("messages", "Messages", [("count", "link"), ("side", summary.role.word())]);
    let counts = [
        ("messages sent", counters.sent),
        (&*received, counters.received),
        ("  after a later one, not used", counters.overtaken),
        ("  lost, or under way at the end", summary.lost),
        ("packets malformed, dropped", counters.malformed),
        ("packets foreign, dropped", counters.foreign),
        ("packets repeated or old, dropped", counters.replayed),
        ("messages of no tick near, dropped", counters.out_of_range),
    ];
    for (label, count) in counts {
        table.row([Cell::from(label), Cell::count(count)]);
    }
    table
}

fn times(summary: &SideSummary) -> Table {
    let columns = [("time", ""), ("median", "median"), ("p99", "99 %"), ("p999", "99.9 %"), ("worst", "worst")];
    let mut table = Table::new("times", "Delays and lateness", columns);
    let other = summary.role.other().word();
    let ticks = |value: Option<f64>| value.map_or(Cell::Undefined, |value| Number::si(value, "").into());
    let seconds = |value: Option<f64>| Cell::of(value, Unit::Second);
    let mut spread = |label: String, of: &Spread, cell: &dyn Fn(Option<f64>) -> Cell| {
        table.row([Cell::from(label), cell(of.median), cell(of.p99), Cell::empty(), cell(of.worst)]);
    };
    spread(format!("delay from the {other}, ticks"), &summary.delay_ticks, &ticks);
    spread(format!("time from the {other}"), &summary.one_way_s, &seconds);
    spread("time there and back".into(), &summary.round_s, &seconds);
    let lateness = &summary.lateness;
    let late = [lateness.median_s, lateness.p99_s, lateness.p999_s, lateness.worst_s].map(seconds);
    table.row(std::iter::once(Cell::from("lateness of the ticks")).chain(late));
    table
}

/// `summary.json` of one side of a link.
#[derive(Debug, Serialize, JsonSchema)]
pub struct LinkFile<'a> {
    /// Version of trocar.
    trocar_version: &'static str,
    /// Name of the scenario.
    scenario: &'a str,
    /// The side: `master` or `slave`.
    side: &'static str,
    /// Number of completed ticks.
    ticks: u64,
    /// Number of ticks of the scenario.
    ticks_of_scenario: u64,
    /// Length of a tick, in s.
    tick_s: f64,
    messages: Messages,
    packets: Packets,
    /// The delay of the messages to this side, in ticks.
    delay_ticks: Spread,
    /// The time from sending to arrival in s, by the clocks of both sides.
    one_way_s: Spread,
    /// The round-trip time in s.
    round_s: Spread,
    /// The error of the clock difference in s: half of the shortest round trip of the greeting.
    clock_s: f64,
    /// The delay between the due time and the beginning of the ticks, in s.
    lateness_s: Lateness,
    /// Number of ticks that began after the next tick was due.
    ticks_missed: u64,
    /// The priority from the scheduler.
    priority: &'a str,
    /// Largest energy that both ports delivered in excess of the received energy, in J.
    generated_j: f64,
    /// Limit of the generated energy from the passivity scheme in J; `None` without a scheme.
    promised_j: Option<f64>,
    /// Times of the ruptures in s; empty on the master's side.
    ruptures_s: &'a [f64],
    /// Times of the accepted alarms in s; empty on the master's side.
    alarms_s: &'a [f64],
    /// Number of times that nothing came from the other side for three outages.
    silences: u64,
    /// Time of the other side's last message in s, if nothing has come since; `None` if it lives.
    silent_since_s: Option<f64>,
    /// Number of times that the other side was started anew and joined this side.
    restarts: u64,
    /// First tick with messages. Above 0 if this side was started anew and joined the other side; the ticks before were
    /// computed without messages.
    first_tick: u64,
    /// The warnings.
    warnings: Vec<Warning>,
}

/// Numbers of messages.
#[derive(Debug, Serialize, JsonSchema)]
struct Messages {
    /// Sent to the other side.
    sent: u64,
    /// Received from the other side.
    received: u64,
    /// Received after a later one and not used.
    overtaken: u64,
    /// Lost, or still on the way at the end.
    lost: u64,
    /// Dropped because their tick is too far away.
    out_of_range: u64,
}

/// Numbers of dropped packets.
#[derive(Debug, Serialize, JsonSchema)]
struct Packets {
    /// Not packets of trocar.
    malformed: u64,
    /// Of another key or session.
    foreign: u64,
    /// Repeated, or with an old number.
    replayed: u64,
}

/// The distribution of the lateness of the ticks in s; undefined without ticks.
#[derive(Debug, Serialize, JsonSchema)]
struct Lateness {
    /// The median.
    median: Option<f64>,
    /// The 99 % quantile.
    p99: Option<f64>,
    /// The 99.9 % quantile.
    p999: Option<f64>,
    /// The maximum.
    worst: Option<f64>,
}

fn json(summary: &SideSummary) -> Json {
    let SideSummary { counters, lateness, meter, .. } = summary;
    json_of(&LinkFile {
        trocar_version: env!("CARGO_PKG_VERSION"),
        scenario: &summary.scenario,
        side: summary.role.word(),
        ticks: summary.ticks.0,
        ticks_of_scenario: summary.ticks.1,
        tick_s: summary.tick_s,
        messages: Messages {
            sent: counters.sent,
            received: counters.received,
            overtaken: counters.overtaken,
            lost: summary.lost,
            out_of_range: counters.out_of_range,
        },
        packets: Packets { malformed: counters.malformed, foreign: counters.foreign, replayed: counters.replayed },
        delay_ticks: summary.delay_ticks,
        one_way_s: summary.one_way_s,
        round_s: summary.round_s,
        clock_s: summary.clock_s,
        lateness_s: Lateness {
            median: lateness.median_s,
            p99: lateness.p99_s,
            p999: lateness.p999_s,
            worst: lateness.worst_s,
        },
        ticks_missed: lateness.missed,
        priority: &summary.priority,
        generated_j: meter.generated_j,
        promised_j: meter.promised_j,
        ruptures_s: &summary.ruptures_s,
        alarms_s: &summary.alarms_s,
        silences: summary.silences,
        silent_since_s: summary.silent_since_s,
        restarts: summary.restarts,
        first_tick: summary.first_tick,
        warnings: warnings(summary),
    })
}
