use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value as Json;

use super::{Run, RunReport, trace_table};
use crate::animation::animation;
use crate::compare::{events_table, metric_tables, verdict};
use crate::stability_check::LoopVerdict;
use trocar_base::warning::Warning;
use trocar_detect::ExtraParameterEstimate;
use trocar_document::{Document, Section, Shown, Study, TextFile, Window, json_of, show, significant};
use trocar_figures::{self as figures, EnergyView, EstimationView, RunView};
use trocar_metrics::{Metrics, Outcome, RuptureMetrics, Unit};
use trocar_scenario::TissueSpec;

const BEFORE_S: f64 = 0.2;
const AFTER_S: f64 = 1.0;

const MAX_WINDOWS: usize = 6;

const TELEOPERATION: &str = "teleoperation";

impl Study for RunReport<'_> {
    fn document(&self) -> Document<'_> {
        let run = self.run;
        let mut verdict = verdict(&[run]);
        // A diverged run begins with its state.
        if !matches!(run.metrics.outcome, Outcome::Diverged { .. }) {
            verdict.sentences.insert(0, format!("{}.", state(run)));
        }
        if let Some(unreached) = self.unreached_sentence() {
            verdict.sentences.insert(1.min(verdict.sentences.len()), unreached);
        }
        let mut document = Document {
            name: "summary",
            title: run.scenario.name.clone(),
            verdict,
            warnings: self.warnings(),
            sections: sections(run),
            data: vec![trace_table(&run.trace, |_| true)],
            files: vec![TextFile { name: "scenario.toml".into(), text: run.scenario.echo() }],
            json: self.summary(),
            ..Document::default()
        };
        if !run.trace.is_empty() {
            document.sketch = figures::sketch(&[self.view()]).ok();
            document.animation = animation(&[run]);
            add_figures(&mut document, self.view(), &self.estimation(), &self.energies());
        }
        document
    }
}

pub fn add_figures<'a>(
    document: &mut Document<'a>,
    run: RunView<'a>,
    estimation: &EstimationView<'a>,
    energies: &EnergyView<'a>,
) {
    let range_s = run.time_s.first().copied().zip(run.time_s.last().copied());
    document.figure(TELEOPERATION, figures::comparison(&[run], range_s));
    document.figure("energy", figures::energy(energies));
    for (name, describe) in figures::ESTIMATION_FIGURES {
        document.figure(name, describe(estimation));
    }
}

fn sections(run: &Run) -> Vec<Section> {
    let [main, all] = metric_tables(&[run], &[]);
    let mut metrics = Section::new("main", "Main metrics");
    metrics.table(main.shown(Shown::InReports));
    metrics.table(all);
    metrics.text(ruptures_line(run));
    metrics.text(alarms_line(run));
    let mut signals = Section::new("signals", "Signals");
    signals.figures([TELEOPERATION, "estimation", "parameters", "decision"], windows(&run.metrics.ruptures));
    signals.text(REDUCED);
    let mut events = Section::new("events", "Events").shown(Shown::InReports);
    match events_table(&[run]) {
        Some(table) => events.table(table),
        None => events.text("No rupture and no alarm."),
    }
    let mut further = Section::new("further", "Energies and residual");
    further.figures(["energy"], vec![]);
    further.figures(["residual"], vec![]);
    let mut about = Section::new("about", "The run").shown(Shown::InReports);
    about.text(self::about(run));
    vec![metrics, signals, events, further, about]
}

pub(crate) const REDUCED: &str = "Long records are reduced to the minimum and maximum of short intervals; nearly every sample around \
    ruptures and alarms is kept. trace.csv has every tick.";

pub(crate) fn windows(ruptures: &[RuptureMetrics]) -> Vec<Window> {
    let window = |(index, rupture): (usize, &RuptureMetrics)| Window {
        label: format!("rupture {}", index + 1),
        range: ((rupture.time_s - BEFORE_S).max(0.0), rupture.time_s + AFTER_S),
    };
    ruptures.iter().take(MAX_WINDOWS).enumerate().map(window).collect()
}

pub fn outcome(run: &Run) -> String {
    format!("{}: {}", run.scenario.name, state(run))
}

pub(crate) fn state(run: &Run) -> String {
    let duration_s = run.metrics.ticks as f64 * run.scenario.grid.tick_s();
    match run.metrics.outcome {
        Outcome::Completed => format!("completed, {} s in {} ticks", significant(duration_s), run.metrics.ticks),
        Outcome::Oscillating { frequency_hz, swing_m } => format!(
            "oscillating, by {} at {} Hz without decay",
            show(Some(swing_m), Unit::Metre),
            significant(frequency_hz)
        ),
        Outcome::Diverged { time_s } if is_pushed(run) => {
            format!("ended at {time_s} s, as the recorded force pushes the hand out of its workspace")
        }
        Outcome::Diverged { time_s } => format!("diverged at {time_s} s"),
    }
}

/// True if a recorded force moves a stable loop: it acts whatever the needle does.
fn is_pushed(run: &Run) -> bool {
    run.user_defined_parts.is_empty()
        && matches!(run.scenario.tissue, TissueSpec::Recording { .. })
        && LoopVerdict::of(&run.scenario).is_ok_and(|verdict| verdict.range.is_stable)
}

pub(crate) fn about(run: &Run) -> String {
    let scenario = &run.scenario;
    format!(
        "{}; tick {}, seed {}, the supervisor {}.",
        outcome(run),
        show(Some(scenario.grid.tick_s()), Unit::Second),
        scenario.seed,
        if scenario.augmentation.enabled { "freezes the slave at ruptures" } else { "does nothing" },
    )
}

fn ruptures_line(run: &Run) -> String {
    let of_layer = |rupture: &RuptureMetrics| Some(format!("{:.3} s ({})", rupture.time_s, rupture.layer.as_deref()?));
    let ruptures: Vec<String> = run.metrics.ruptures.iter().filter_map(of_layer).collect();
    if ruptures.is_empty() { String::new() } else { format!("ruptures: {}", ruptures.join(", ")) }
}

fn alarms_line(run: &Run) -> String {
    let alarms: Vec<String> = run
        .metrics
        .alarms
        .iter()
        .map(|alarm| format!("{:.3} s{}", alarm.time_s, if alarm.matched { "" } else { " (false alarm)" }))
        .collect();
    if alarms.is_empty() { "alarms: none".into() } else { format!("alarms: {}", alarms.join(", ")) }
}

/// `summary.json` of a run: every metric, the events, the seed and the version.
#[derive(Debug, Serialize, JsonSchema)]
pub struct RunFile<'a> {
    /// Version of trocar.
    trocar_version: &'static str,
    /// Name of the scenario.
    scenario: &'a str,
    /// The seed of the random numbers.
    seed: u64,
    /// Length of a tick, in s.
    tick_s: f64,
    /// The warnings about the run.
    warnings: Vec<Warning>,
    metrics: &'a Metrics,
    /// The estimates of the extra parameter, if the estimator has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    further_estimate: Option<ExtraParameterEstimate>,
}

impl<'a> RunFile<'a> {
    pub(crate) fn of(run: &'a Run) -> Self {
        Self {
            trocar_version: env!("CARGO_PKG_VERSION"),
            scenario: &run.scenario.name,
            seed: run.scenario.seed,
            tick_s: run.scenario.grid.tick_s(),
            warnings: RunReport::of(run).warnings(),
            metrics: &run.metrics,
            further_estimate: ExtraParameterEstimate::of(&run.trace.extra_parameter),
        }
    }
}

impl RunReport<'_> {
    pub fn summary(self) -> Json {
        json_of(&RunFile::of(self.run))
    }
}
