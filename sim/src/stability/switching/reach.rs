//! The maximum motion through events: a certified bound, and the maximum that was found.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::SwitchingSettings;
use super::certificate::{Certificate, Focus, certify, peak};
use super::conditions::{Choice, GROWTH_FROZEN, Space};
use super::interval::{middle, power, product, rounded};
use super::modes::Modes;
use super::settings::Phases;
use crate::augmentation::cross_fade;
use crate::stability::StabilityError;

/// Number of stiffnesses on which sequences are tried.
const STIFFNESSES: usize = 4;

/// Number of start times per event that are tried, and their range in ticks.
const INSTANTS: u64 = 16;
const LATEST_TICKS: u64 = 400;

/// Number of events of the sequences.
const EVENTS: usize = 2;

/// Motion of the slave and feedback force after the hand is released at rest away from its desired position, per metre
/// of that distance, at every tick of every admissible sequence of events.
#[derive(Debug, Clone, PartialEq)]
pub struct Reach {
    /// Verified bound of the slave's position in m/m.
    pub slave_bound: f64,
    /// Verified bound of the feedback force in N/m.
    pub force_bound_n_per_m: f64,
    /// The sequence with the maximum motion of the slave from the first event on.
    pub worst: Sequence,
    /// That maximum, in m/m.
    pub slave_found: f64,
}

/// Events at given ticks, on one stiffness.
#[derive(Debug, Clone, PartialEq)]
pub struct Sequence {
    /// `K` in N/m.
    pub stiffness_n_per_m: f64,
    /// The ticks at which events begin, counted from the release of the hand.
    pub starts: Vec<u64>,
    /// Frozen ticks of each event.
    pub held_ticks: u64,
}

impl Sequence {
    /// The tick `extra_ticks` after the last event's return to teleoperation.
    #[must_use]
    pub fn end(&self, blend: u64, extra_ticks: u64) -> u64 {
        self.starts.last().map_or(0, |start| start + self.held_ticks + blend) + extra_ticks
    }
}

impl Reach {
    /// The bounds for the dwell of `choice`; `None` without a certificate.
    ///
    /// # Errors
    /// [`StabilityError`].
    pub(super) fn of(
        settings: &SwitchingSettings,
        modes: &Modes,
        phases: Phases,
        choice: Choice,
    ) -> Result<Option<Self>, StabilityError> {
        let (of_slave, of_force) = rayon::join(
            || bound(modes, phases, choice, &slave_rows(modes)),
            || bound(modes, phases, choice, &force_rows(modes)),
        );
        let (Some(slave_bound), Some(force_bound_n_per_m)) = (of_slave?, of_force?) else { return Ok(None) };
        let (worst, slave_found) = farthest(settings, phases, choice.dwell)?;
        Ok(Some(Self { slave_bound, force_bound_n_per_m, worst, slave_found }))
    }
}

fn wider(row: &DMatrix<f64>, columns: usize) -> DMatrix<f64> {
    let mut wide = DMatrix::zeros(1, columns);
    wide.view_mut((0, 0), (1, row.len())).copy_from(row);
    wide
}

/// The slave's position in each space.
fn slave_rows(modes: &Modes) -> Vec<(Space, DMatrix<f64>)> {
    let (n, row) = (modes.states(), modes.slave());
    let frozen = wider(&row, modes.frozen_states());
    vec![(Space::Loop, row.clone()), (Space::Fading, wider(&row, n + 1)), (Space::Frozen, frozen)]
}

/// The feedback force in each space: at both ends of the stiffness's range, and in the cross-fade at both of its ends.
fn force_rows(modes: &Modes) -> Vec<(Space, DMatrix<f64>)> {
    let (n, frozen) = (modes.states(), modes.frozen_states());
    let kept = |columns: usize, at: usize| DMatrix::from_fn(1, columns, |_, j| f64::from(u8::from(j == at)));
    let mut rows = vec![(Space::Fading, kept(n + 1, n)), (Space::Frozen, kept(frozen, n + 1))];
    for vertex in 0..2 {
        let row = modes.force(vertex);
        rows.extend([(Space::Fading, wider(&row, n + 1)), (Space::Loop, row)]);
    }
    rows
}

/// The verified maximum of the rows after the release of the hand.
fn bound(
    modes: &Modes,
    phases: Phases,
    choice: Choice,
    rows: &[(Space, DMatrix<f64>)],
) -> Result<Option<f64>, StabilityError> {
    let starts: Vec<DVector<f64>> = (0..2).map(|vertex| modes.after_step(vertex)).collect();
    let mut focused = rows.to_vec();
    let frozen_row = rows.iter().find(|(space, _)| *space == Space::Frozen).map(|(_, row)| row.clone());
    // Up to the shortest freeze there is no Lyapunov function: each tick is bounded separately. A few of them suffice
    // for the solver.
    let step = rounded(&modes.frozen(0, 1.0));
    let entries: Vec<DMatrix<f64>> = (0..2).map(|vertex| modes.entry(vertex)).collect();
    let of_entry = |now: &DMatrix<f64>, entry: &DMatrix<f64>| {
        frozen_row.as_ref().map(|row| (row * now * entry).columns(0, modes.states()).into_owned())
    };
    if modes.is_frozen_map_unique() {
        for ticks in [1, 5, 20, 60].into_iter().filter(|&ticks| ticks <= phases.held.0) {
            let now = middle(&power(&step, ticks));
            focused.extend(entries.iter().filter_map(|entry| Some((Space::Loop, of_entry(&now, entry)?))));
        }
    }
    let Some(plain) = certify(modes, phases, choice, None)? else { return Ok(None) };
    let focus = Focus { starts: starts.clone(), rows: focused, plain: plain.clone() };
    let focused = certify(modes, phases, choice, Some(&focus))?;
    let max = |found: &Certificate| {
        let p = &found.at_events;
        let level = |start: &DVector<f64>| (start.transpose() * p * start)[(0, 0)];
        let level = starts.iter().map(level).fold(0.0, f64::max).sqrt() * (1.0 + 1e-9);
        let mut max: f64 = 0.0;
        for (space, row) in rows {
            let grown = if *space == Space::Frozen { GROWTH_FROZEN.sqrt() } else { 1.0 };
            for (matrix, _) in found.in_space(*space) {
                max = max.max(grown * peak(matrix, row));
            }
        }
        if modes.is_frozen_map_unique() {
            let mut now = power(&step, 0);
            for _ in 0..=phases.held.0 {
                for row in entries.iter().filter_map(|entry| of_entry(&middle(&now), entry)) {
                    max = max.max(peak(p, &row));
                }
                now = product(&step, &now);
            }
        }
        level * max
    };
    let bounds = [focused, Some(plain)].into_iter().flatten().map(|found| max(&found));
    Ok(bounds.filter(|bound| bound.is_finite()).reduce(f64::min))
}

/// Simulates the maps for motions so small that a ramp closes its gap within a tick; returns the slave's maximum
/// position from the first event on.
fn simulate(modes: &Modes, phases: Phases, sequence: &Sequence, extra_ticks: u64) -> f64 {
    let n = modes.states();
    let share = *modes.shares().last().unwrap_or(&1.0);
    let (teleoperation, frozen, slave) = (modes.teleoperation(0), modes.frozen(0, share), modes.slave());
    let blends: Vec<DMatrix<f64>> =
        (1..=phases.blend).map(|tick| modes.blend(0, cross_fade(tick as f64 / phases.blend as f64))).collect();
    let mut state = modes.after_step(0);
    let mut max: f64 = 0.0;
    let mut tick = 1;
    for &start in &sequence.starts {
        while tick + 1 < start {
            state = &teleoperation * state;
            tick += 1;
            if Some(&start) != sequence.starts.first() {
                max = max.max((&slave * &state)[(0, 0)].abs());
            }
        }
        let entry = modes.entry(0);
        let mut y = entry.columns(0, n) * &state;
        max = max.max(y[modes.master_states()].abs());
        for _ in 0..sequence.held_ticks {
            y = &frozen * y;
            max = max.max(y[modes.master_states()].abs());
        }
        let mut gap = if modes.has_gap() { (modes.gap() * &y)[(0, 0)] } else { 0.0 };
        let mut z = (modes.release() * &y).push(gap);
        for blend in &blends {
            let next = blend * &z;
            gap = if modes.gap_closes() { 0.0 } else { gap };
            z = next.push(gap);
            max = max.max(z[modes.master_states()].abs());
        }
        state = z.rows(0, n).into_owned();
        tick = start + sequence.held_ticks + phases.blend;
    }
    for _ in 0..extra_ticks {
        state = &teleoperation * state;
        max = max.max((&slave * &state)[(0, 0)].abs());
    }
    max
}

/// The tried sequence with the maximum motion of the slave: each event is added at its worst start time.
fn farthest(settings: &SwitchingSettings, phases: Phases, dwell: u64) -> Result<(Sequence, f64), StabilityError> {
    let (softest, stiffest) = settings.stiffness_n_per_m;
    let (shortest, longest) = phases.held;
    let tried: Vec<(Sequence, f64)> = (0..STIFFNESSES * 2)
        .into_par_iter()
        .map(|k| {
            let stiffness = softest + (stiffest - softest) * (k / 2) as f64 / (STIFFNESSES - 1) as f64;
            let here = SwitchingSettings { stiffness_n_per_m: (stiffness, stiffness), ..settings.clone() };
            let modes = Modes::new(&here)?;
            let held_ticks = if k % 2 == 0 { shortest } else { longest };
            let mut best = (Sequence { stiffness_n_per_m: stiffness, starts: vec![], held_ticks }, 0.0);
            for _ in 0..EVENTS {
                let earliest = if best.0.starts.is_empty() { 2 } else { best.0.end(phases.blend, dwell) };
                let mut here = (best.0.clone(), 0.0);
                for instant in 0..INSTANTS {
                    let mut sequence = best.0.clone();
                    sequence.starts.push(earliest + instant * LATEST_TICKS / INSTANTS);
                    let max = simulate(&modes, phases, &sequence, LATEST_TICKS);
                    if max > here.1 {
                        here = (sequence, max);
                    }
                }
                best = here;
            }
            Ok(best)
        })
        .collect::<Result<_, StabilityError>>()?;
    let none = Sequence { stiffness_n_per_m: stiffest, starts: vec![], held_ticks: shortest };
    Ok(tried.into_iter().max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((none, 0.0)))
}
