//! What one side of a link says.

use serde_json::{Value as Json, json};

use super::{Role, SideSummary, Spread};
use trocar_base::unit::Unit;
use trocar_document::{Cell, Document, Number, Section, Study, Table, Verdict, counted, show};

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
        if let Some([of_master, of_slave]) = self.proxy_lost {
            section.text(format!("proxy: dropped {of_master} messages of the master, {of_slave} of the slave"));
        }
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
            sections: vec![section],
            json: json(self),
            ..Document::default()
        }
    }
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

/// Returns the summary of a side as `summary.json` has it.
fn json(summary: &SideSummary) -> Json {
    let SideSummary { counters, lateness, meter, .. } = summary;
    let spread = |spread: &Spread| json!({"median": spread.median, "p99": spread.p99, "worst": spread.worst});
    json!({
        "trocar_version": env!("CARGO_PKG_VERSION"),
        "scenario": summary.scenario,
        "side": summary.role.word(),
        "ticks": summary.ticks.0,
        "ticks_of_scenario": summary.ticks.1,
        "tick_s": summary.tick_s,
        "messages": {
            "sent": counters.sent,
            "received": counters.received,
            "overtaken": counters.overtaken,
            "lost": summary.lost,
            "out_of_range": counters.out_of_range,
        },
        "packets": {"malformed": counters.malformed, "foreign": counters.foreign, "replayed": counters.replayed},
        "proxy_lost": summary.proxy_lost.map(|[of_master, of_slave]| json!({"master": of_master, "slave": of_slave})),
        "delay_ticks": spread(&summary.delay_ticks),
        "one_way_s": spread(&summary.one_way_s),
        "round_s": spread(&summary.round_s),
        "clock_s": summary.clock_s,
        "lateness_s": {
            "median": lateness.median_s,
            "p99": lateness.p99_s,
            "p999": lateness.p999_s,
            "worst": lateness.worst_s,
        },
        "ticks_missed": lateness.missed,
        "priority": summary.priority,
        "generated_j": meter.generated_j,
        "promised_j": meter.promised_j,
        "ruptures_s": summary.ruptures_s,
        "alarms_s": summary.alarms_s,
    })
}
