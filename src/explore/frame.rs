//! Both runs as a page gets them: what is said of them as JSON, and their lines as numbers.
//!
//! A frame is the length of its JSON in bytes (32 bits, little endian), the JSON, blanks up to a multiple of four bytes, and
//! the lines one after another, 32-bit floats, little endian, each of `points` points: the times in s, then for each run the
//! columns that `columns` names, positions in mm, forces in N.

use std::time::Instant;

use serde_json::{Value as Json, json};

use super::limits::MAX_POINTS;
use super::pair::{Pair, SCHEMES};
use super::protocol::Show;
use super::thin::Window;
use trocar_report::row_cells;
use trocar_sim::compare::{NoiseCheck, rows};
use trocar_sim::engine::Trace;
use trocar_sim::metrics::Outcome;
use trocar_sim::run::Run;

/// A column of a run as the page gets it: its name, its factor into the page's unit, and its values.
type Column = (&'static str, f64, fn(&Trace) -> &[f64]);

/// The columns besides the mode.
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

/// The frame that shows a pair, with how it stands in noise where that was looked at.
pub(super) fn frame(pair: &Pair, noise: &[NoiseCheck], show: &Show, began: Instant) -> Vec<u8> {
    let [classical, _] = &pair.runs;
    let grid = classical.scenario.grid;
    let length = pair.runs.iter().map(|run| run.trace.len()).max().unwrap_or(0);
    let tick = |time_s: f64| ((time_s / grid.tick_s()).max(0.0) as usize).min(length);
    let ticks = show.window_s.map_or(0..length, |(from, to)| tick(from)..(tick(to).saturating_add(2)).min(length));
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
        "whole_s": [0.0, grid.time_s(length.saturating_sub(1) as u64)],
        "runs": pair.runs.iter().map(told).collect::<Vec<_>>(),
        "table": table,
        "server_ms": 1e3 * began.elapsed().as_secs_f64(),
    });
    packed(&header, &points)
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

/// What is said of one run: its events, its modes, its detector's threshold.
fn told(run: &Run) -> Json {
    let detector = &run.scenario.detector;
    json!({
        "name": run.scenario.name,
        "diverged_s": match run.metrics.outcome {
            Outcome::Completed => None,
            Outcome::Diverged { time_s } => Some(time_s),
        },
        "ruptures_s": run.metrics.ruptures.iter().map(|rupture| rupture.time_s).collect::<Vec<_>>(),
        "alarms": run.metrics.alarms.iter().map(|alarm| (alarm.time_s, alarm.matched)).collect::<Vec<_>>(),
        "modes": modes(&run.trace),
        "threshold": detector.cusum.threshold,
        "decision_unit": detector.distance.kind.unit(),
    })
}

/// The stretches that are not teleoperation: from and to in s, and the mode.
fn modes(trace: &Trace) -> Vec<(f64, f64, u8)> {
    let mut stretches: Vec<(f64, f64, u8)> = vec![];
    let mut last = 0;
    for (&time_s, &mode) in trace.time_s.iter().zip(&trace.mode) {
        match stretches.last_mut() {
            Some(stretch) if mode == last && mode != 0 => stretch.1 = time_s,
            _ if mode != 0 => stretches.push((time_s, time_s, mode)),
            _ => {}
        }
        last = mode;
    }
    stretches
}

/// The table that `compare` prints: a line per metric, with the change.
pub(super) fn table(runs: &[Run; 2], noise: &[NoiseCheck]) -> Json {
    let metrics: Vec<_> = runs.iter().map(|run| &run.metrics).collect();
    let lines = rows(&metrics, noise).into_iter().map(|row| json!({ "cells": row_cells(&row), "values": row.values }));
    json!({ "schemes": SCHEMES, "rows": lines.collect::<Vec<_>>() })
}
