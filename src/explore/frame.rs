//! The binary message with both runs: a description as JSON, and the lines as numbers.
//!
//! A frame consists of the length of its JSON in bytes (32 bits, little endian), the JSON, spaces up to a multiple of four bytes, and
//! the lines as 32-bit floats, little endian, with `points` points each: the times in s, then for each run the columns in
//! `columns`, with positions in mm and forces in N.

use std::time::Instant;

use serde_json::{Value as Json, json};

use super::limits::MAX_POINTS;
use super::pair::{Pair, SCHEMES};
use super::protocol::{Show, ShownTime};
use super::thin::Window;
use trocar_report::{Animation, answer_of_schemes, row_cells};
use trocar_sim::compare::{NoiseCheck, rows};
use trocar_sim::engine::Trace;
use trocar_sim::metrics::Outcome;
use trocar_sim::run::Run;

/// Displayed time before and after the first rupture, in s.
const BEFORE_S: f64 = 0.3;
const AFTER_S: f64 = 1.5;

/// A column of a frame: its name, its factor to the unit of the page, and its values.
type Column = (&'static str, f64, fn(&Trace) -> &[f64]);

/// The columns of a run, without the mode.
const COLUMNS: [Column; 8] = [
    ("desired_position_mm", 1e3, |trace| &trace.desired_position_m),
    ("master_position_mm", 1e3, |trace| &trace.master_position_m),
    ("slave_position_mm", 1e3, |trace| &trace.slave_position_m),
    ("operator_force_n", 1.0, |trace| &trace.operator_force_n),
    ("tissue_force_n", 1.0, |trace| &trace.tissue_force_n),
    ("feedback_force_n", 1.0, |trace| &trace.feedback_force_n),
    ("stiffness_n_per_m", 1.0, |trace| &trace.stiffness_n_per_m),
    ("decision", 1.0, |trace| &trace.decision),
];

/// Returns the frame of a pair, with the noise checks if they are available.
pub(super) fn frame(pair: &Pair, noise: &[NoiseCheck], show: &Show, began: Instant) -> Vec<u8> {
    let [classical, _] = &pair.runs;
    let grid = classical.scenario.grid;
    let length = pair.runs.iter().map(|run| run.trace.len()).max().unwrap_or(0);
    let tick = |time_s: f64| ((time_s / grid.tick_s()).max(0.0) as usize).min(length);
    let whole_s = (0.0, grid.time_s(length.saturating_sub(1) as u64));
    let animation = Animation::of(&pair.runs.iter().collect::<Vec<_>>());
    let window_s = match show.window {
        ShownTime::All => None,
        ShownTime::Between(from, to) => Some((from, to)),
        ShownTime::Rupture => animation.as_ref().map(|animation| around(animation.origin_s(), whole_s)),
    };
    let ticks = window_s.map_or(0..length, |(from, to)| tick(from)..(tick(to).saturating_add(2)).min(length));
    let window = Window::new(ticks, show.points.clamp(2, MAX_POINTS));
    let mut points: Vec<f32> = Vec::with_capacity((1 + 2 * (COLUMNS.len() + 1)) * window.len());
    points.extend(window.ticks().into_iter().map(|tick| grid.time_s(tick as u64) as f32));
    for run in &pair.runs {
        for (_, factor, values) in &COLUMNS {
            let values = values(&run.trace);
            window.line(|tick| values[tick], values.len(), *factor, &mut points);
        }
        let mode = &run.trace.mode;
        window.line(|tick| f64::from(mode[tick]), mode.len(), 1.0, &mut points);
    }
    let columns: Vec<&str> = COLUMNS.iter().map(|(name, ..)| *name).chain(["mode"]).collect();
    let table = table(&pair.runs, noise);
    let header = json!({
        "type": "shown",
        "id": show.id,
        "points": window.len(),
        "columns": columns,
        "whole_s": whole_s,
        "window_s": window_s,
        "answer": answer_of_schemes(&pair.runs[0], &pair.runs[1]),
        "animation": animation,
        "runs": pair.runs.iter().map(description).collect::<Vec<_>>(),
        "table": table,
        "server_ms": 1e3 * began.elapsed().as_secs_f64(),
    });
    packed(&header, &points)
}

/// Returns the time around an origin, in s, within the run.
fn around(origin_s: f64, whole_s: (f64, f64)) -> (f64, f64) {
    ((origin_s - BEFORE_S).max(whole_s.0), (origin_s + AFTER_S).min(whole_s.1))
}

fn packed(header: &Json, points: &[f32]) -> Vec<u8> {
    let mut text = header.to_string();
    while !text.len().is_multiple_of(4) {
        text.push(' ');
    }
    let mut bytes = Vec::with_capacity(4 + text.len() + 4 * points.len());
    bytes.extend_from_slice(&(text.len() as u32).to_le_bytes());
    bytes.extend_from_slice(text.as_bytes());
    for point in points {
        bytes.extend_from_slice(&point.to_le_bytes());
    }
    bytes
}

/// Returns the description of a run: events, modes, threshold of the detector.
fn description(run: &Run) -> Json {
    let detector = &run.scenario.detector;
    json!({
        "name": run.scenario.name,
        "diverged_s": match run.metrics.outcome {
            Outcome::Completed | Outcome::Oscillating { .. } => None,
            Outcome::Diverged { time_s } => Some(time_s),
        },
        "ruptures_s": run.metrics.ruptures.iter().map(|rupture| rupture.time_s).collect::<Vec<_>>(),
        "alarms": run.metrics.alarms.iter().map(|alarm| (alarm.time_s, alarm.matched)).collect::<Vec<_>>(),
        "modes": modes(&run.trace),
        "warnings": run.warnings(),
        "threshold": detector.cusum.threshold,
        "decision_unit": detector.distance.kind.unit(),
    })
}

/// Returns the intervals that are not teleoperation: start and end in s, and the mode.
fn modes(trace: &Trace) -> Vec<(f64, f64, u8)> {
    let mut intervals: Vec<(f64, f64, u8)> = vec![];
    let mut last = 0;
    for (&time_s, &mode) in trace.time_s.iter().zip(&trace.mode) {
        match intervals.last_mut() {
            Some(interval) if mode == last && mode != 0 => interval.1 = time_s,
            _ if mode != 0 => intervals.push((time_s, time_s, mode)),
            _ => {}
        }
        last = mode;
    }
    intervals
}

/// Returns the table of `compare`: a row per metric, with the change.
pub(super) fn table(runs: &[Run; 2], noise: &[NoiseCheck]) -> Json {
    let metrics: Vec<_> = runs.iter().map(|run| &run.metrics).collect();
    let lines = rows(&metrics, noise).into_iter().map(|row| json!({ "cells": row_cells(&row), "values": row.values }));
    json!({ "schemes": SCHEMES, "rows": lines.collect::<Vec<_>>() })
}
