//! Growth on one constant tissue, which a scenario can simulate.
//!
//! A cycle (an event and the teleoperation after it) is one matrix. Products of cycles are extended while the minimum
//! norm of their prefixes exceeds the best growth (Gripenberg, *Linear Algebra Appl.* 234, 1996).

use nalgebra::DMatrix;

use super::ascent::{power, radius};
use super::modes::{Modes, Space};
use super::settings::Phases;
use crate::StabilityError;
use trocar_base::interrupt;
use trocar_core::augmentation::cross_fade;

const TOLERANCE: f64 = 0.01;

const MAX_EVENTS: usize = 8;

const MAX_PRODUCTS: usize = 20_000;

const DWELLS: usize = 10;
const EXTRA_TICKS: u64 = 400;

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SimulatedCycle {
    pub held_ticks: u64,
    pub dwell_ticks: u64,
    /// 0 softest, 1 stiffest.
    pub vertex: usize,
}

#[derive(Debug, Clone, PartialEq)]
pub struct SimulatedGrowth {
    pub found: f64,
    pub worst: Vec<SimulatedCycle>,
}

struct Node {
    matrix: DMatrix<f64>,
    word: Vec<usize>,
    min_norm: f64,
}

/// For motions so small that a ramp closes its gap in one tick and the force of `amplify` stays above its floor.
fn matrix(modes: &Modes, phases: Phases, cycle: SimulatedCycle) -> DMatrix<f64> {
    let SimulatedCycle { held_ticks, dwell_ticks, vertex } = cycle;
    let space = if modes.gap_closes() { Space::Loop } else { Space::LoopGap };
    let share = *modes.shares().last().unwrap_or(&1.0);
    let mut state = modes.freeze() * modes.teleoperation(vertex) * modes.selection(space, Space::All);
    state = modes.release(vertex) * power(&modes.frozen(vertex, share), held_ticks) * state;
    for tick in 0..phases.blend {
        let weight = cross_fade((tick + 1) as f64 / phases.blend as f64);
        state = modes.blend(vertex, weight) * state;
        if modes.gap_closes() {
            state = modes.closed() * state;
        }
    }
    modes.selection(Space::All, space) * power(&modes.teleoperation(vertex), dwell_ticks - 1) * state
}

fn cycles(phases: Phases, dwell: u64, vertex: usize) -> Vec<SimulatedCycle> {
    let (shortest, longest) = phases.held;
    let mut all = vec![];
    for held_ticks in if shortest == longest { vec![shortest] } else { vec![shortest, longest] } {
        for k in 0..DWELLS as u64 {
            let dwell_ticks = dwell + k * k * EXTRA_TICKS / (DWELLS * DWELLS) as u64;
            all.push(SimulatedCycle { held_ticks, dwell_ticks, vertex });
        }
    }
    all
}

pub(super) fn growth(
    modes: &Modes,
    phases: Phases,
    dwell: u64,
    vertex: usize,
) -> Result<SimulatedGrowth, StabilityError> {
    let cycles = cycles(phases, dwell, vertex);
    let matrices: Vec<DMatrix<f64>> = cycles.iter().map(|&cycle| matrix(modes, phases, cycle)).collect();
    let size = matrices[0].nrows();
    let length = |matrix: &DMatrix<f64>| {
        let square = matrix.transpose() * matrix;
        if square.iter().all(|value| value.is_finite()) {
            square.symmetric_eigenvalues().max().max(0.0).sqrt()
        } else {
            f64::INFINITY
        }
    };
    let mut found = SimulatedGrowth { found: 0.0, worst: vec![] };
    let mut products = 0;
    let mut open = vec![Node { matrix: DMatrix::identity(size, size), word: vec![], min_norm: f64::INFINITY }];
    for events in 1..=MAX_EVENTS {
        let mut next = vec![];
        for node in &open {
            interrupt::check();
            for (k, one) in matrices.iter().enumerate() {
                products += 1;
                let matrix = one * &node.matrix;
                let root = |value: f64| value.powf(1.0 / events as f64);
                let (radius, min_norm) = (root(radius(&matrix)?), root(length(&matrix)).min(node.min_norm));
                let word: Vec<usize> = node.word.iter().copied().chain([k]).collect();
                if radius > found.found * (1.0 + 1e-9) {
                    found.found = radius;
                    found.worst = word.iter().map(|&k| cycles[k]).collect();
                }
                next.push(Node { matrix, word, min_norm });
            }
        }
        next.retain(|node| node.min_norm > found.found + TOLERANCE && found.found.is_finite());
        if next.is_empty() || (products + next.len() * matrices.len()) > MAX_PRODUCTS {
            break;
        }
        open = next;
    }
    Ok(found)
}
