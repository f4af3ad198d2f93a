//! A calibration as text, as JSON, and as TOML tables for a scenario.

use std::fmt::Write as _;

use serde_json::{Value as Json, json};

use super::Table;
use super::wrap::wrapped;
use trocar_document::{show, significant};
use trocar_metrics::Unit;
use trocar_studies::detect::calibration::{Calibration, Candidate, ContactRule, LAGS, RunLength, Whiteness};

/// Returns the chosen settings as they are printed and written: computed numbers have four significant digits, which is more than a
/// few seconds of a recording determine. A given contact position stays as it is.
#[must_use]
pub fn calibrated_settings(calibration: &Calibration) -> Candidate {
    let four = |value: &mut f64| *value = rounded(*value, 4);
    let mut chosen = *calibration.settings();
    if !matches!(calibration.contact_rule, ContactRule::Given) {
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

/// Returns a number rounded to some significant digits.
fn rounded(value: f64, digits: usize) -> f64 {
    format!("{value:.*e}", digits - 1).parse().unwrap_or(value)
}

/// Returns the `[estimator]` and `[detector]` tables of a calibration as TOML.
#[must_use]
pub fn calibration_toml(calibration: &Calibration) -> String {
    let Candidate { contact_m, estimator, detector, .. } = calibrated_settings(calibration);
    let (cusum, arming, hypotheses) = (&detector.cusum, &detector.arming, &detector.distance.hypotheses);
    // Small numbers with a power of ten, as in 2.02e-5.
    let number = |value: f64| format!("{value:?}");
    let mut text = String::from("[estimator]\n");
    let mut line = |name: &str, value: String| {
        // Writing to a string does not fail.
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

/// Returns a calibration as tables: the measured quantities, the candidate memories, and the chosen settings.
#[must_use]
pub fn calibration_text(name: &str, calibration: &Calibration) -> String {
    let settings = calibrated_settings(calibration);
    let newton = |value| show(Some(value), Unit::Newton);
    let mut table = Table::new(["measured in the first", &format!("{} s", significant(calibration.looked_at_s))]);
    table.row(["noise of the force, σ_n".to_owned(), newton(calibration.noise_std_n)]);
    let contact = match calibration.contact_rule {
        ContactRule::Given => "contact position, given",
        ContactRule::FirstForce => "contact position, at the onset of force",
        ContactRule::Extrapolated => "contact position, extrapolated from the loaded part",
        ContactRule::Lowest => "contact position not found: 5 mm below the lowest position",
    };
    table.row([contact.to_owned(), show(Some(settings.contact_m), Unit::Metre)]);
    let ruptures: Vec<String> = calibration.ruptures_s.iter().map(|time| format!("{} s", significant(*time))).collect();
    table.row(["ruptures, excluded".to_owned(), or_dash(ruptures.join(", "))]);
    let segment =
        calibration.quiet_segment_s.map(|(from, to)| format!("{} to {} s", significant(from), significant(to)));
    table.row(["longest quiet segment".to_owned(), or_dash(segment.unwrap_or_default())]);
    table.row(["quiet residual, σ_0".to_owned(), newton(calibration.quiet_std_n)]);
    if let Some(whiteness) = &calibration.whiteness {
        whiteness_rows(&mut table, whiteness);
    }
    let mut text = format!("{name}\n\n{table}\n");
    if calibration.quiet_blocks == 0 {
        text.push_str(
            "The recording has too little quiet contact. σ_0 is set to the noise σ_n and may be too small. Use a longer part \
             of the recording (--first-s).\n\n",
        );
    }
    if calibration.whiteness.is_some_and(|test| test.is_rejected()) {
        text.push_str(
            "The threshold gives the wanted interval for a white Gaussian residual. The quiet residual is not, so that no interval is \
             predicted; the recording alone gives a bound. The threshold is at least twice the largest harmless excursion.\n\n",
        );
    }
    let _ = writeln!(text, "{}", candidates_table(calibration));
    let threshold = settings.detector.cusum.threshold;
    let reason = match 2.0 * settings.harmless_peak > settings.run_length_threshold {
        true => format!("twice the largest harmless excursion, {} N²", significant(settings.harmless_peak)),
        false => "set by --false-alarm-s".to_owned(),
    };
    let mut table = Table::new(["chosen", "value"]);
    table.row(["threshold γ".to_owned(), format!("{} N², {reason}", significant(threshold))]);
    let bound = match calibration.quiet_s {
        0.0 => "unknown".to_owned(),
        quiet_s => format!(
            "above {} s (95 %): none in {} s of quiet contact",
            significant(calibration.least_false_alarm_s()),
            significant(quiet_s)
        ),
    };
    table.row(["interval between false alarms, observed".to_owned(), bound]);
    let predicted =
        calibration.false_alarm_s.map_or_else(|| "none: the residual is not white noise".to_owned(), duration);
    table.row(["  predicted for white noise".to_owned(), predicted]);
    table.row(["predicted delay of the slowest rupture".to_owned(), show(settings.delay_s, Unit::Second)]);
    let _ = write!(text, "{table}\n{}", calibration_toml(calibration));
    wrapped(&text, 0)
}

fn or_dash(text: String) -> String {
    if text.is_empty() { "—".into() } else { text }
}

/// Returns an order of magnitude of a duration in seconds, in hours, or as "over a year".
fn duration(seconds: f64) -> String {
    let hours = seconds / 3600.0;
    match hours {
        _ if hours >= 1e4 => "over a year".into(),
        _ if hours >= 1.0 => format!("about {} h", two_digits(hours)),
        _ => format!("about {} s", two_digits(seconds)),
    }
}

/// Returns a number of at least 0.1 with two significant digits without zeros at its end.
fn two_digits(value: f64) -> String {
    rounded(value, 2).to_string()
}

fn whiteness_rows(table: &mut Table, whiteness: &Whiteness) {
    table.row(["  lag-one correlation".to_owned(), significant(whiteness.lag_one_correlation)]);
    table.row([format!("  whiteness: Ljung-Box, {LAGS} lags"), probability(whiteness.ljung_box_p)]);
    table.row(["  normality: Jarque-Bera".to_owned(), probability(whiteness.jarque_bera_p)]);
}

fn probability(p: f64) -> String {
    if p < 1e-4 { "p < 0.0001".into() } else { format!("p = {p:.4}") }
}

fn candidates_table(calibration: &Calibration) -> Table {
    let mut table = Table::new([
        "memory (corrections)",
        "threshold",
        "slow ruptures detected",
        "median delay",
        "alarms on harmless changes",
        "",
    ]);
    let share = |share: Option<f64>| {
        share.map_or_else(
            || "—".to_owned(),
            |share| format!("{:.0} of {}", share * calibration.probes as f64, calibration.probes),
        )
    };
    for (index, candidate) in calibration.candidates.iter().enumerate() {
        table.row([
            significant(candidate.memory_updates),
            format!("{} N²", significant(candidate.detector.cusum.threshold)),
            share(candidate.found_share),
            show(candidate.delay_s, Unit::Second),
            share(candidate.harmless_share),
            if index == calibration.chosen { "chosen".into() } else { String::new() },
        ]);
    }
    table
}

/// Returns the content of `calibration.json`.
#[must_use]
pub fn calibration_object(name: &str, calibration: &Calibration) -> Json {
    let candidate = |candidate: &Candidate| {
        let Candidate { estimator, detector, .. } = candidate;
        json!({
            "memory_updates": candidate.memory_updates,
            "reset_threshold": estimator.reset_threshold,
            "quiet_std_n": detector.distance.hypotheses.quiet_std_n,
            "threshold": detector.cusum.threshold,
            "drift": detector.cusum.drift,
            "run_length_threshold": candidate.run_length_threshold,
            "harmless_peak": candidate.harmless_peak,
            "found_share": candidate.found_share,
            "delay_s": candidate.delay_s,
            "harmless_share": candidate.harmless_share,
        })
    };
    let Candidate { contact_m, estimator, detector, delay_s, .. } = calibrated_settings(calibration);
    json!({
        "trocar_version": env!("CARGO_PKG_VERSION"),
        "recording": name,
        "warnings": calibration.warnings(),
        "looked_at_s": calibration.looked_at_s,
        "interval_s": calibration.interval_s,
        "noise_std_n": calibration.noise_std_n,
        "contact_rule": calibration.contact_rule,
        "quiet_std_n": calibration.quiet_std_n,
        "quiet_blocks": calibration.quiet_blocks,
        "quiet_segment_s": calibration.quiet_segment_s,
        "whiteness": calibration.whiteness,
        "ruptures_s": calibration.ruptures_s,
        "probes": calibration.probes,
        "candidates": calibration.candidates.iter().map(candidate).collect::<Vec<_>>(),
        "chosen": calibration.chosen,
        "predicted_false_alarm_s": calibration.false_alarm_s,
        "least_false_alarm_s": calibration.least_false_alarm_s(),
        "quiet_s": calibration.quiet_s,
        "predicted_delay_s": delay_s,
        "settings": {
            "estimator": {
                "normalisation": estimator.normalisation,
                "initial_gain": estimator.initial_gain,
                "reset_threshold": estimator.reset_threshold,
                "dead_zone_n": estimator.dead_zone_n,
                "contact_m": contact_m,
            },
            "detector": {
                "distance": detector.distance.kind.word(),
                "quiet_std_n": detector.distance.hypotheses.quiet_std_n,
                "rupture_std_n": detector.distance.hypotheses.rupture_std_n,
                "threshold": detector.cusum.threshold,
                "drift": detector.cusum.drift,
                "cap": detector.cusum.cap,
                "settle_s": detector.arming.settle_s,
                "drop_only": detector.arming.drop_only,
                "withdrawal_speed_m_per_s": detector.arming.withdrawal_speed_m_per_s,
            },
        },
    })
}

/// Returns a table of predicted and simulated run lengths.
#[must_use]
pub fn run_lengths_text(lengths: &[RunLength]) -> String {
    let heading = ["ν / σ_0²", "γ / σ_0²", "predicted", "simulated", "alarms", "simulated / predicted"];
    let mut table = Table::new(heading);
    for length in lengths {
        table.row([
            significant(length.drift),
            significant(length.threshold),
            format!("{:.4e}", length.predicted),
            format!("{:.4e}", length.simulated),
            length.alarms.to_string(),
            format!("{:.3}", length.simulated / length.predicted),
        ]);
    }
    table.to_string()
}
