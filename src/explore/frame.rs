//! Binary messages. A message has a length in bytes (32 bits, little endian), JSON of this length padded with spaces
//! to a multiple of four bytes, and the content of a file or the points of both runs' lines.
//!
//! The points are 32-bit floats, little endian. The description of a line contains the index of its first number and
//! its number of points.

use std::ops::Range;

use serde::Serialize;
use serde_json::{Value as Json, json};

use super::limits::MAX_POINTS;
use super::pair::{Pair, SCHEMES};
use super::protocol::{Show, ShownTime};
use super::state::StateError;
use trocar_document::Animation;
use trocar_document::Figure;
use trocar_figures as figures;
use trocar_figures::FigureError;
use trocar_metrics::Outcome;
use trocar_report::PictureError;
use trocar_report::draw::FigureWidth;
use trocar_report::draw::{FigureFormat, file};
use trocar_studies::animation::animation;
use trocar_studies::compare::{NoiseCheck, rows, verdict_of_schemes};
use trocar_studies::run::{Run, RunReport};

const BEFORE_S: f64 = 0.3;
const AFTER_S: f64 = 1.5;

/// Serialised directly: a JSON tree in between would copy everything.
#[derive(Serialize)]
struct Shown {
    #[serde(rename = "type")]
    kind: &'static str,
    id: u32,
    figure: Json,
    whole_s: (f64, f64),
    answer: String,
    animation: Option<Animation>,
    runs: Vec<Json>,
    table: Json,
    server_ms: f64,
}

/// With the noise checks if available. `server_s` returns the time since the request.
pub(super) fn frame(
    pair: &Pair,
    noise: &[NoiseCheck],
    show: &Show,
    server_s: &dyn Fn() -> f64,
) -> Result<Vec<u8>, StateError> {
    let [classical, augmented] = &pair.runs;
    let grid = classical.scenario.grid;
    let length = pair.runs.iter().map(|run| run.trace.len()).max().unwrap_or(0);
    let tick = |time_s: f64| ((time_s / grid.tick_s()).max(0.0) as usize).min(length);
    let whole_s = (0.0, grid.time_s(length.saturating_sub(1) as u64));
    let animation = animation(&[classical, augmented]);
    let (from_s, to_s) = window_s(show.window, animation.as_ref(), whole_s);
    let ticks = tick(from_s)..tick(to_s).saturating_add(2).min(length);
    let mut points = vec![];
    let figure = signals(&pair.runs, &ticks)?.for_frame(show.points.clamp(2, MAX_POINTS) / 2, &mut points);
    let header = Shown {
        kind: "shown",
        id: show.id,
        figure,
        whole_s,
        answer: verdict_of_schemes(classical, augmented).text(),
        animation,
        runs: pair.runs.iter().map(description).collect(),
        table: table(&pair.runs, noise),
        server_ms: 1e3 * server_s(),
    };
    packed(&header, &points)
}

pub(super) fn signals<'a>(runs: &'a [Run; 2], ticks: &Range<usize>) -> Result<Figure<'a>, FigureError> {
    let views: Vec<_> = runs
        .iter()
        .map(|run| (RunReport::of(run).view().at(ticks), RunReport::of(run).estimation().at(ticks)))
        .collect();
    let times_s = views.iter().flat_map(|(run, _)| run.time_s.first().into_iter().chain(run.time_s.last())).copied();
    let window = times_s.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| (low.min(at), high.max(at)));
    figures::signals(&views, window)
}

/// The requested time in s, or that around the first rupture, within the run.
fn window_s(window: ShownTime, animation: Option<&Animation>, whole_s: (f64, f64)) -> (f64, f64) {
    match (window, animation) {
        (ShownTime::Between(from_s, to_s), _) => (from_s, to_s),
        (ShownTime::Rupture, Some(animation)) => {
            let origin_s = animation.origin_s;
            ((origin_s - BEFORE_S).max(whole_s.0), (origin_s + AFTER_S).min(whole_s.1))
        }
        _ => whole_s,
    }
}

pub(super) fn picture(
    runs: &[Run; 2],
    which: usize,
    (id, name): (u32, String),
    (window, width): (ShownTime, FigureWidth),
) -> Result<Vec<u8>, StateError> {
    let animation = animation(&runs.each_ref());
    let run = &runs[which];
    let whole_s = (0.0, run.trace.time_s.last().copied().unwrap_or(0.0));
    let figure =
        figures::comparison(&[RunReport::of(run).view()], Some(window_s(window, animation.as_ref(), whole_s)))?;
    let png = file(&figure, FigureFormat::Png, width).map_err(PictureError::from)?;
    packed(&json!({ "type": "file", "id": id, "name": name }), &png)
}

fn packed(header: &impl Serialize, payload: &[u8]) -> Result<Vec<u8>, StateError> {
    let mut bytes = vec![0; 4];
    serde_json::to_writer(&mut bytes, header).map_err(StateError::Message)?;
    while !bytes.len().is_multiple_of(4) {
        bytes.push(b' ');
    }
    let length = (bytes.len() - 4) as u32;
    bytes[..4].copy_from_slice(&length.to_le_bytes());
    bytes.extend_from_slice(payload);
    Ok(bytes)
}

fn description(run: &Run) -> Json {
    json!({
        "name": run.scenario.name,
        "diverged_s": match run.metrics.outcome {
            Outcome::Completed | Outcome::Oscillating { .. } => None,
            Outcome::Diverged { time_s } => Some(time_s),
        },
        "warnings": RunReport::of(run).warnings(),
    })
}

pub(super) fn table(runs: &[Run; 2], noise: &[NoiseCheck]) -> Json {
    let metrics: Vec<_> = runs.iter().map(|run| &run.metrics).collect();
    let lines = rows(&metrics, noise).into_iter().map(|row| {
        let cells: Vec<String> = row.cells().iter().map(ToString::to_string).collect();
        json!({ "cells": cells, "values": row.values })
    });
    json!({ "schemes": SCHEMES, "rows": lines.collect::<Vec<_>>() })
}
