use std::fmt::Write as _;

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::{Value as Json, json};

use super::{Calibration, Candidate, ContactRule, LAGS, RunLength, Whiteness};
use crate::document::{ChainSettings, Samples};
use crate::{Detection, DetectionReport};
use trocar_base::warning::{Code, Warning};
use trocar_document::{
    Cell, Digits, Document, Number, Section, Shown, Study, Table, TextFile, Verdict, counted, json_of, significant,
};
use trocar_metrics::Unit;

const MAX_LISTED: usize = 6;

/// Separate, because a detection has figures of the same names.
const FIGURES: &str = "calibration/";

#[derive(Debug)]
pub struct CalibrationStudy<'a> {
    pub name: &'a str,
    pub calibration: &'a Calibration,
    /// As TOML.
    pub inputs: String,
    report: DetectionReport,
    samples: Samples,
}

impl<'a> CalibrationStudy<'a> {
    /// `ruptures_s` are in s after the first sample.
    pub fn new(
        name: &'a str,
        calibration: &'a Calibration,
        inputs: String,
        (detection, ruptures_s): (Detection, &[f64]),
    ) -> Self {
        let report = DetectionReport::of(&detection, ruptures_s);
        Self { name, calibration, inputs, report, samples: Samples::of(detection) }
    }
}

impl Study for CalibrationStudy<'_> {
    fn document(&self) -> Document<'_> {
        let mut document = self.calibration.document(self.name);
        // Missed ruptures depend on the labels.
        let found = self.report.warnings.iter().filter(|warning| warning.code != Code::MissedRupture);
        document.warnings.extend(found.cloned());
        let mut alarms = Section::new("alarms", "Alarms");
        alarms.text(alarms_line(&self.report));
        document.sections.push(alarms);
        let looked_at_s = self.calibration.looked_at_s;
        let heading =
            format!("# Calibrated on the first {looked_at_s:.3} s by trocar {}.\n", env!("CARGO_PKG_VERSION"));
        let text = format!("{heading}{}\n{}", self.inputs, self.calibration.toml());
        document.files.push(TextFile { name: "calibrated.toml".into(), text });
        self.samples.draw(&mut document, FIGURES, self.name, &self.report);
        document
    }
}

fn alarms_line(report: &DetectionReport) -> String {
    let number = match report.alarms.len() {
        0 => return "with these settings: no alarm in the whole recording".into(),
        1 => "one alarm".to_owned(),
        count => format!("{count} alarms"),
    };
    let listed = report.alarms.iter().take(MAX_LISTED);
    let times: Vec<String> = listed.map(|alarm| format!("{:.4} s", alarm.time_s)).collect();
    let rest = match report.alarms.len().saturating_sub(MAX_LISTED) {
        0 => String::new(),
        more => format!(" and {more} more, which trocar detect lists with calibrated.toml"),
    };
    format!("with these settings: {number} in the whole recording, at {}{rest}", times.join(", "))
}

impl Calibration {
    pub fn document(&self, name: &str) -> Document<'static> {
        let settings = self.rounded_settings();
        let mut measured = Section::new("measured", "Measured");
        measured.table(self.measured_table(&settings));
        let mut candidates = Section::new("candidates", "Candidates");
        candidates.table(self.candidates_table());
        let mut chosen = Section::new("chosen", "Chosen");
        chosen.table(self.chosen_table(&settings));
        let mut toml = Section::new("settings", "Settings").shown(Shown::OnTerminal);
        toml.text(self.toml().trim_end());
        let mut sections = vec![measured];
        sections.extend(self.doubts());
        sections.extend([candidates, chosen, toml]);
        Document {
            name: "calibration",
            title: name.to_owned(),
            warnings: self.warnings(),
            sections,
            json: self.json(name),
            ..Document::default()
        }
    }

    /// To four significant digits, except a given contact.
    pub fn rounded_settings(&self) -> Candidate {
        let four = |value: &mut f64| *value = rounded(*value, 4);
        let mut chosen = *self.settings();
        if !matches!(self.contact_rule, ContactRule::Given) {
            four(&mut chosen.contact_m);
        }
        let Candidate { estimator, detector, .. } = &mut chosen;
        let hypotheses = &mut detector.distance.hypotheses;
        let computed = [
            &mut estimator.reset_threshold,
            &mut estimator.dead_zone_n,
            &mut hypotheses.quiet_std_n,
            &mut hypotheses.rupture_std_n,
            &mut detector.cusum.threshold,
            &mut detector.cusum.drift,
            &mut detector.cusum.cap,
        ];
        computed.into_iter().for_each(four);
        chosen
    }

    pub fn toml(&self) -> String {
        let Candidate { contact_m, estimator, detector, .. } = self.rounded_settings();
        let (cusum, arming, hypotheses) = (&detector.cusum, &detector.arming, &detector.distance.hypotheses);
        let number = |value: f64| format!("{value:?}");
        let mut text = String::from("[estimator]\n");
        let mut line = |name: &str, value: String| {
            let _ = writeln!(text, "{name} = {value}");
        };
        line("normalisation", number(estimator.normalisation));
        line("initial_gain", number(estimator.initial_gain));
        line("reset_threshold", number(estimator.reset_threshold));
        line("dead_zone_n", number(estimator.dead_zone_n));
        line("contact_m", number(contact_m));
        line("\n[detector]\ndistance", format!("{:?}", detector.distance.kind.word()));
        line("quiet_std_n", number(hypotheses.quiet_std_n));
        line("rupture_std_n", number(hypotheses.rupture_std_n));
        line("threshold", number(cusum.threshold));
        line("drift", number(cusum.drift));
        line("cap", number(cusum.cap));
        line("settle_s", number(arming.settle_s));
        line("drop_only", arming.drop_only.to_string());
        line("withdrawal_speed_m_per_s", number(arming.withdrawal_speed_m_per_s));
        text
    }

    fn measured_table(&self, settings: &Candidate) -> Table {
        let newton = |value| Cell::of(Some(value), Unit::Newton);
        let columns = [
            ("quantity", "measured in the first".to_owned()),
            ("value", format!("{} s", significant(self.looked_at_s))),
        ];
        let mut table = Table::new("measured", "Measured quantities", columns);
        table.row(["noise of the force, σ_n".into(), newton(self.noise_std_n)]);
        let contact = match self.contact_rule {
            ContactRule::Given => "contact position, given",
            ContactRule::FirstForce => "contact position, at the onset of force",
            ContactRule::Extrapolated => "contact position, extrapolated from the loaded part",
            ContactRule::Lowest => "contact position not found: 5 mm below the lowest position",
        };
        table.row([contact.into(), Cell::of(Some(settings.contact_m), Unit::Metre)]);
        let ruptures: Vec<String> = self.ruptures_s.iter().map(|time| format!("{} s", significant(*time))).collect();
        let ruptures = if ruptures.is_empty() { Cell::Undefined } else { ruptures.join(", ").into() };
        table.row(["ruptures, excluded".into(), ruptures]);
        let segment = |(from, to)| format!("{} to {} s", significant(from), significant(to)).into();
        table.row(["longest quiet segment".into(), self.quiet_segment_s.map_or(Cell::Undefined, segment)]);
        table.row(["quiet residual, σ_0".into(), newton(self.quiet_std_n)]);
        if let Some(whiteness) = &self.whiteness {
            let lag_one = Number::si(whiteness.lag_one_correlation, "");
            table.row(["  lag-one correlation".into(), Cell::from(lag_one)]);
            let test = format!("  whiteness: Ljung-Box, {LAGS} lags");
            table.row([test, probability(whiteness.ljung_box_p)]);
            table.row(["  normality: Jarque-Bera".to_owned(), probability(whiteness.jarque_bera_p)]);
        }
        table
    }

    fn doubts(&self) -> impl Iterator<Item = Section> {
        let short = (self.quiet_blocks == 0).then_some(
            "The recording has too little quiet contact. σ_0 is set to the noise σ_n and may be too small. Use a \
             longer part of the recording (--first-s).",
        );
        let coloured = self.whiteness.is_some_and(|test| test.is_rejected()).then_some(
            "The threshold gives the requested interval for a white Gaussian residual. The quiet residual is not white, \
             so no interval is predicted; the recording alone gives a bound. The threshold is at least twice the \
             largest harmless excursion.",
        );
        let section = |(id, text): (&'static str, Option<&str>)| {
            let mut section = Section::new(id, "Assumptions");
            section.text(text?);
            Some(section)
        };
        [("quiet", short), ("white", coloured)].into_iter().filter_map(section)
    }

    fn candidates_table(&self) -> Table {
        let columns = [
            ("memory_updates", "memory (corrections)"),
            ("threshold", "threshold"),
            ("found_share", "slow ruptures detected"),
            ("delay_s", "median delay"),
            ("harmless_share", "alarms on harmless changes"),
            ("chosen", ""),
        ];
        let mut table = Table::new("candidates", "Candidates", columns);
        let share = |share: Option<f64>| {
            let of = |share: f64| format!("{:.0} of {}", share * self.probes as f64, self.probes).into();
            share.map_or(Cell::Undefined, of)
        };
        for (index, candidate) in self.candidates.iter().enumerate() {
            table.row([
                Number::si(candidate.memory_updates, "").into(),
                Number::si(candidate.detector.cusum.threshold, "N²").into(),
                share(candidate.found_share),
                Cell::of(candidate.delay_s, Unit::Second),
                share(candidate.harmless_share),
                if index == self.chosen { "chosen".into() } else { Cell::empty() },
            ]);
        }
        table
    }

    fn chosen_table(&self, settings: &Candidate) -> Table {
        let threshold = settings.detector.cusum.threshold;
        let reason = match 2.0 * settings.harmless_peak > settings.run_length_threshold {
            true => format!("twice the largest harmless excursion, {} N²", significant(settings.harmless_peak)),
            false => "set by --false-alarm-s".to_owned(),
        };
        let bound = match self.quiet_s {
            0.0 => "unknown".to_owned(),
            quiet_s => format!(
                "above {} s (95 %): none in {} s of quiet contact",
                significant(self.least_false_alarm_s()),
                significant(quiet_s)
            ),
        };
        let predicted = self.false_alarm_s.map_or_else(|| "none: the residual is not white noise".to_owned(), duration);
        let mut table = Table::new("chosen", "Chosen settings", [("quantity", "chosen"), ("value", "value")]);
        table.row(["threshold γ".to_owned(), format!("{} N², {reason}", significant(threshold))]);
        table.row(["interval between false alarms, observed".to_owned(), bound]);
        table.row(["  predicted for white noise".to_owned(), predicted]);
        table.row(["predicted delay of the slowest rupture".into(), Cell::of(settings.delay_s, Unit::Second)]);
        table
    }

    fn json(&self, name: &str) -> Json {
        let Candidate { contact_m, estimator, detector, delay_s, .. } = self.rounded_settings();
        json_of(&CalibrationFile {
            trocar_version: env!("CARGO_PKG_VERSION"),
            recording: name,
            warnings: self.warnings(),
            looked_at_s: self.looked_at_s,
            interval_s: self.interval_s,
            noise_std_n: self.noise_std_n,
            contact_rule: self.contact_rule,
            quiet_std_n: self.quiet_std_n,
            quiet_blocks: self.quiet_blocks,
            quiet_segment_s: self.quiet_segment_s,
            whiteness: self.whiteness,
            ruptures_s: &self.ruptures_s,
            probes: self.probes,
            candidates: self.candidates.iter().map(CandidateEntry::of).collect(),
            chosen: self.chosen,
            predicted_false_alarm_s: self.false_alarm_s,
            least_false_alarm_s: self.least_false_alarm_s(),
            quiet_s: self.quiet_s,
            predicted_delay_s: delay_s,
            settings: ChainSettings {
                estimator: json!({
                    "normalisation": estimator.normalisation,
                    "initial_gain": estimator.initial_gain,
                    "reset_threshold": estimator.reset_threshold,
                    "dead_zone_n": estimator.dead_zone_n,
                    "contact_m": contact_m,
                }),
                detector: json!({
                    "distance": detector.distance.kind.word(),
                    "quiet_std_n": detector.distance.hypotheses.quiet_std_n,
                    "rupture_std_n": detector.distance.hypotheses.rupture_std_n,
                    "threshold": detector.cusum.threshold,
                    "drift": detector.cusum.drift,
                    "cap": detector.cusum.cap,
                    "settle_s": detector.arming.settle_s,
                    "drop_only": detector.arming.drop_only,
                    "withdrawal_speed_m_per_s": detector.arming.withdrawal_speed_m_per_s,
                }),
            },
        })
    }
}

/// `calibration.json`: the quantities measured in a recording, and the resulting settings.
#[derive(Debug, Serialize, JsonSchema)]
pub struct CalibrationFile<'a> {
    /// Version of trocar.
    trocar_version: &'static str,
    /// Name of the recording.
    recording: &'a str,
    /// The warnings about the chosen settings.
    warnings: Vec<Warning>,
    /// Duration of the evaluated part of the recording, in s.
    looked_at_s: f64,
    /// Interval between two samples, in s.
    interval_s: f64,
    /// Standard deviation of the white noise of the force, in N.
    noise_std_n: f64,
    contact_rule: ContactRule,
    /// Standard deviation of the residual without a rupture, in N.
    quiet_std_n: f64,
    /// Number of blocks that give `quiet_std_n`; 0 if there were too few and the noise gives it.
    quiet_blocks: usize,
    /// The longest interval without a rupture, in contact and settled, in s after the first sample.
    quiet_segment_s: Option<(f64, f64)>,
    /// Test of the residual in that interval for white Gaussian noise.
    whiteness: Option<Whiteness>,
    /// The recognised ruptures, in s after the first sample.
    ruptures_s: &'a [f64],
    /// Number of synthetic ruptures and harmless changes that were added to the recording.
    probes: usize,
    /// The candidates, one per memory of the estimator, in ascending order.
    candidates: Vec<CandidateEntry>,
    /// Index of the chosen candidate, from 0.
    chosen: usize,
    /// Predicted time between false alarms in s; `None` if the residual is not white Gaussian noise.
    predicted_false_alarm_s: Option<f64>,
    /// Lower bound of the time between false alarms in s, with 95 % confidence, from the quiet time without an alarm.
    least_false_alarm_s: f64,
    /// Time of quiet contact without an alarm with the chosen settings, in s.
    quiet_s: f64,
    /// Predicted delay of the slowest rupture, in s.
    predicted_delay_s: Option<f64>,
    settings: ChainSettings,
}

/// Candidate settings with their test results.
#[derive(Debug, Serialize, JsonSchema)]
struct CandidateEntry {
    /// Number of corrections between two resets of the estimator's gain.
    memory_updates: f64,
    /// `estimator.reset_threshold`.
    reset_threshold: f64,
    /// `detector.quiet_std_n`, in N.
    quiet_std_n: f64,
    /// `detector.threshold`, in N².
    threshold: f64,
    /// `detector.drift`, in N².
    drift: f64,
    /// Threshold that gives the requested time between false alarms, in N².
    run_length_threshold: f64,
    /// The largest harmless excursion of the decision, in N².
    harmless_peak: f64,
    /// Share of the added slowest ruptures that are detected; `None` if too few probes fit into the recording.
    found_share: Option<f64>,
    /// Median delay of these detections, in s.
    delay_s: Option<f64>,
    /// Share of the added fastest harmless changes that raise an alarm.
    harmless_share: Option<f64>,
}

impl CandidateEntry {
    fn of(candidate: &Candidate) -> Self {
        let Candidate { estimator, detector, .. } = candidate;
        Self {
            memory_updates: candidate.memory_updates,
            reset_threshold: estimator.reset_threshold,
            quiet_std_n: detector.distance.hypotheses.quiet_std_n,
            threshold: detector.cusum.threshold,
            drift: detector.cusum.drift,
            run_length_threshold: candidate.run_length_threshold,
            harmless_peak: candidate.harmless_peak,
            found_share: candidate.found_share,
            delay_s: candidate.delay_s,
            harmless_share: candidate.harmless_share,
        }
    }
}

fn rounded(value: f64, digits: usize) -> f64 {
    format!("{value:.*e}", digits - 1).parse().unwrap_or(value)
}

fn duration(seconds: f64) -> String {
    let two_digits = |value: f64| rounded(value, 2).to_string();
    let hours = seconds / 3600.0;
    match hours {
        _ if hours >= 1e4 => "over a year".into(),
        _ if hours >= 1.0 => format!("about {} h", two_digits(hours)),
        _ => format!("about {} s", two_digits(seconds)),
    }
}

fn probability(p: f64) -> String {
    if p < 1e-4 { "p < 0.0001".into() } else { format!("p = {p:.4}") }
}

pub fn run_lengths_document(lengths: &[RunLength]) -> Document<'static> {
    let columns = [
        ("drift", "ν / σ_0²"),
        ("threshold", "γ / σ_0²"),
        ("predicted", "predicted"),
        ("simulated", "simulated"),
        ("alarms", "alarms"),
        ("ratio", "simulated / predicted"),
    ];
    let mut table = Table::new("run_lengths", "Run lengths", columns);
    for length in lengths {
        table.row([
            Number::si(length.drift, "").into(),
            Number::si(length.threshold, "").into(),
            format!("{:.4e}", length.predicted).into(),
            format!("{:.4e}", length.simulated).into(),
            Cell::count(length.alarms),
            Number::si(length.simulated / length.predicted, "").digits(Digits::Decimals(3)).into(),
        ]);
    }
    let mut section = Section::new("run_lengths", "Run lengths");
    section.table(table);
    Document {
        name: "run_lengths",
        title: "run lengths".into(),
        verdict: Verdict {
            sentences: vec![format!("{}, in samples", counted(lengths.len() as u64, "average run length"))],
            left_out: vec![],
        },
        sections: vec![section],
        ..Document::default()
    }
}
