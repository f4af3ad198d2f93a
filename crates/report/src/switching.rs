//! The stability under switching, as text, JSON, CSV and a figure.

use std::fmt::Write as _;

use serde_json::{Value as Json, json};

use super::figures::{self, Figure, FigureError};
use super::number::significant;
use super::pictures::{PictureError, keep};
use super::tables::shortest;
use super::{Folder, Table};
use trocar_core::augmentation::Reengage;
use trocar_stability::{Certificate, EventBound, GAP_M, LONGEST_DWELL_S, Switching};
use trocar_studies::stability_check::StabilityStudy;

fn policy(reengage: Reengage) -> &'static str {
    match reengage {
        Reengage::Ramp { .. } => "ramp",
        Reengage::RampUntilLoad { .. } => "ramp-until-load",
        Reengage::Clutch => "clutch",
        Reengage::Snap => "snap",
    }
}

/// Returns a number of ticks in s.
pub(super) fn seconds(switching: &Switching, ticks: u64) -> f64 {
    // Rounded, because the product of a tick of 0.001 s has rounding errors in its last digits.
    (ticks as f64 * switching.settings.of_loop.tick_s * 1e12).round() / 1e12
}

/// Returns a number of ticks as text in ms.
fn milliseconds(switching: &Switching, ticks: u64) -> String {
    format!("{} ms", significant(1e3 * seconds(switching, ticks)))
}

/// Returns the analysis of the switching as text, or the reason why there is none.
#[must_use]
pub fn switching_text(study: &StabilityStudy) -> String {
    match &study.switching {
        Ok(switching) => format!("{}\n{}", switching_lines(study, switching), event_table(&switching.events)),
        Err(reason) => format!("Switching: not analysed ({reason}).\n"),
    }
}

/// Returns the findings, one per line.
pub(super) fn switching_lines(study: &StabilityStudy, switching: &Switching) -> String {
    let ms = |ticks| milliseconds(switching, ticks);
    let (softest, stiffest) = switching.settings.stiffness_n_per_m;
    let phases = switching.phases;
    let mut text = format!(
        "switching: {} to {} N/m at any tick, frozen for {} to {}, cross-fade of {}, {}\n",
        significant(softest),
        significant(stiffest),
        ms(phases.held.0),
        ms(phases.held.1),
        ms(phases.blend),
        policy(switching.settings.augmentation.reengage),
    );
    let conditions = switching.certificate.as_ref().map(|found| found.conditions);
    let conditions = conditions.or(switching.kept_gap.as_ref().map(|found| found.conditions));
    let _ = match (switching.dwell_ticks(), conditions) {
        (Some(dwell), Some(conditions)) => writeln!(
            text,
            "certificate: the motion decays under any sequence of events with {} of teleoperation between them; {conditions} conditions verified",
            ms(dwell),
        ),
        _ => writeln!(
            text,
            "certificate: none found with up to {LONGEST_DWELL_S} s of teleoperation between events; \
             this does not show instability"
        ),
    };
    let _ = writeln!(
        text,
        "the supervisor enforces {}: {}",
        ms(phases.refractory),
        match (switching.dwell_ticks(), switching.is_certified()) {
            (_, true) => certified_for(study, switching),
            (Some(dwell), false) =>
                format!("not certified, augmentation.refractory_s must be {}", seconds(switching, dwell)),
            (None, false) => "not certified".to_owned(),
        }
    );
    if let Some(covers) = switching.covers_lost_contact {
        let word = if covers { "certified" } else { "not certified" };
        let _ = writeln!(text, "with a needle that may lose contact at any tick: {word}");
    }
    let found = switching.growth.found;
    let _ = match switching.certified_growth() {
        Some(certified) => writeln!(
            text,
            "growth per event at {}: {} found with the stiffness chosen at every tick, at most {} by the certificate, {} times as much",
            ms(phases.refractory),
            significant(found),
            significant(certified),
            significant(certified / found),
        ),
        None => writeln!(
            text,
            "growth per event at {}: {} found with the stiffness chosen at every tick",
            ms(phases.refractory),
            significant(found)
        ),
    };
    let _ = match switching.growing_dwell_ticks {
        None => writeln!(text, "no growing sequence found, down to one tick between events"),
        Some(ticks) => writeln!(text, "growing sequences found with {} between events", ms(ticks)),
    };
    if switching.shown.found >= 1.0 {
        let _ = writeln!(
            text,
            "with the enforced time, the motion grows {} times from one event to the next: see worst_events.toml",
            significant(switching.shown.found),
        );
    }
    if let Some(reach) = &switching.reach {
        let _ = writeln!(
            text,
            "after a release of the hand at 1 mm, the needle moves at most {} mm under any events (found: {} mm), and the feedback \
             force is at most {} N (found: {} N)",
            significant(reach.slave.0),
            significant(reach.slave_found),
            significant(1e-3 * reach.force.0),
            significant(1e-3 * reach.force_found),
        );
    }
    text
}

/// Returns what a certificate says about the scenario.
fn certified_for(study: &StabilityStudy, switching: &Switching) -> String {
    let (softest, stiffest) = switching.settings.stiffness_n_per_m;
    let range = format!("{} to {} N/m", significant(softest), significant(stiffest));
    if !study.verdict.left_out.is_empty() {
        return format!("certified for {range} without what the analysis leaves out; unknown for the scenario");
    }
    if study.covers_tissue() == Some(true) {
        return format!("certified for {range}, which is the whole tissue of the scenario");
    }
    let (low, high) = study.tissue().stiffness_n_per_m;
    if low < softest || high > stiffest {
        let (low, high) = (significant(low), significant(high));
        return format!("certified for {range}; the tissue has {low} to {high} N/m, so the scenario is not covered");
    }
    format!(
        "certified for springs of {range}; the scenario is not covered, as that leaves out {}",
        study.tissue().left_out().unwrap_or_default()
    )
}

pub(super) fn event_table(events: &[EventBound]) -> Table {
    let mut table = Table::new([
        format!("released {} mm from the hand", significant(1e3 * GAP_M)).as_str(),
        "reference jumps",
        "needle motion",
        "max speed",
        "max feedback force",
        "max step per tick",
    ]);
    let millimetres =
        |metres: f64| if metres < 1e-9 { "0 mm".into() } else { format!("{} mm", significant(1e3 * metres)) };
    let newtons = |force: f64| if force < 1e-9 { "0 N".into() } else { format!("{} N", significant(force)) };
    for event in events {
        table.row([
            policy(event.reengage).to_owned(),
            millimetres(event.reference_jump_m),
            millimetres(event.slave_motion_m),
            format!("{}/s", millimetres(event.slave_speed_m_per_s)),
            newtons(event.force_n),
            newtons(event.force_step_n),
        ]);
    }
    table
}

/// The rows of a matrix.
pub(super) fn rows(matrix: &nalgebra::DMatrix<f64>) -> Vec<Vec<f64>> {
    matrix.row_iter().map(|row| row.iter().copied().collect()).collect()
}

/// Returns the part `switching` of `stability.json`.
pub(super) fn switching_object(study: &StabilityStudy) -> Json {
    let switching = match &study.switching {
        Ok(switching) => switching,
        Err(reason) => return json!({ "unmodelled": reason }),
    };
    let s = |ticks| seconds(switching, ticks);
    let (softest, stiffest) = switching.settings.stiffness_n_per_m;
    let events: Vec<Json> = switching
        .events
        .iter()
        .map(|event| {
            json!({
                "reengage": policy(event.reengage),
                "reference_jump_m": event.reference_jump_m,
                "slave_motion_m": event.slave_motion_m,
                "slave_speed_m_per_s": event.slave_speed_m_per_s,
                "force_n": event.force_n,
                "force_step_n": event.force_step_n,
            })
        })
        .collect();
    let of_certificate = |found: &Certificate| {
        json!({
            "dwell_s": s(found.dwell_ticks),
            "contraction": found.contraction,
            "conditions": found.conditions,
            "p_at_events": rows(&found.p_at_events()),
        })
    };
    json!({
        "stiffness_n_per_m": [softest, stiffest],
        "held_s": [s(switching.phases.held.0), s(switching.phases.held.1)],
        "blend_s": s(switching.phases.blend),
        "refractory_s": s(switching.phases.refractory),
        "is_certified": study.is_certified(),
        "is_certified_for_range": switching.is_certified(),
        "covers_tissue": study.covers_tissue(),
        "covers_lost_contact": switching.covers_lost_contact,
        "certificate": switching.certificate.as_ref().map(of_certificate),
        "kept_gap": switching.kept_gap.as_ref().map(|found| json!({
            "dwell_s": s(found.dwell_ticks),
            "conditions": found.conditions,
        })),
        "growth_per_event": {
            "dwell_s": s(switching.phases.refractory),
            "found": switching.growth.found,
            "found_changes_of_stiffness": switching.growth.changes,
            "certified": switching.certified_growth(),
            "found_on_one_stiffness": switching.shown.found,
            "growing_dwell_s": switching.growing_dwell_ticks.map(s),
        },
        "reach": switching.reach.as_ref().map(|reach| json!({
            "slave_bound_m_per_m": reach.slave.0,
            "slave_found_m_per_m": reach.slave_found,
            "force_bound_n_per_m": reach.force.0,
            "force_found_n_per_m": reach.force_found,
            "slave_on_one_stiffness_m_per_m": reach.simulated,
            "worst_stiffness_n_per_m": reach.worst.stiffness_n_per_m,
            "worst_events_s": reach.worst.starts.iter().map(|&tick| s(tick)).collect::<Vec<_>>(),
            "worst_held_s": s(reach.worst.held_ticks),
        })),
        "gap_m": GAP_M,
        "released": events,
    })
}

/// Returns `switching.csv`: a row per analysed dwell time.
#[must_use]
pub fn switching_csv(switching: &Switching) -> String {
    let mut text = "dwell_s,certified_growth,found_growth\n".to_owned();
    for point in &switching.by_dwell {
        let _ = writeln!(
            text,
            "{},{},{}",
            shortest(seconds(switching, point.dwell_ticks)),
            point.certified.map_or(String::new(), shortest),
            shortest(point.found),
        );
    }
    text
}

/// Returns `released.csv`: the end of one event, by re-engagement policy.
#[must_use]
pub fn released_csv(switching: &Switching) -> String {
    let mut text =
        "reengage,gap_m,reference_jump_m,slave_motion_m,slave_speed_m_per_s,force_n,force_step_n\n".to_owned();
    for event in &switching.events {
        let EventBound { reengage, reference_jump_m, slave_motion_m, slave_speed_m_per_s, force_n, force_step_n } =
            *event;
        let cells = [GAP_M, reference_jump_m, slave_motion_m, slave_speed_m_per_s, force_n, force_step_n].map(shortest);
        let _ = writeln!(text, "{},{}", policy(reengage), cells.join(","));
    }
    text
}

/// Writes the figure `switching`.
///
/// # Errors
/// [`PictureError`].
pub fn switching_picture(folder: &Folder, name: &str, switching: &Switching) -> Result<(), PictureError> {
    keep(folder, "switching", &figure(name, switching)?)
}

pub(super) fn figure(name: &str, switching: &Switching) -> Result<Figure<'static>, FigureError> {
    figures::switching(name, &switching.by_dwell, switching.settings.of_loop.tick_s)
}
