//! The maximum motion through events: a certified bound, and the largest motion found.

use nalgebra::DMatrix;

use super::SwitchingSettings;
use super::ascent::{Steps, farthest};
use super::attempt::{attempt, narrowed};
use super::conditions::{Choice, Focus};
use super::modes::Modes;
use super::settings::Phases;
use crate::StabilityError;
use crate::certificate::Certificate;
use trocar_base::interrupt;
use trocar_base::parallel::try_map;
use trocar_core::augmentation::cross_fade;

/// The ratio of the smallest certified bound to the largest uncertified one at which the search ends.
const MAX_RATIO: f64 = 1.1;

/// The largest tried bound, relative to the motion found.
const LARGEST: f64 = 64.0;

const STIFFNESSES: usize = 4;

/// Number of tried start times per event, and their range in ticks.
const INSTANTS: u64 = 16;
const LATEST_TICKS: u64 = 400;

const EVENTS: usize = 2;

/// Motion of the slave and feedback force after the hand is released at rest away from its desired position, per metre
/// of that distance, over every admissible sequence of events.
#[derive(Debug, Clone)]
pub struct Reach {
    /// Verified bound of the slave's position in m/m, with its certificate.
    pub slave: (f64, Certificate),
    /// Verified bound of the feedback force in N/m, with its certificate.
    pub force: (f64, Certificate),
    /// The largest motion of the slave found, in m/m, from the first event on, with a varying tissue.
    pub slave_found: f64,
    /// The largest feedback force found, in N/m.
    pub force_found: f64,
    /// The sequence on one constant stiffness with the largest motion of the slave.
    pub worst: Sequence,
    /// The largest motion of that sequence, in m/m.
    pub simulated: f64,
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
    pub(super) fn of(
        settings: &SwitchingSettings,
        steps: &Steps<'_>,
        (phases, choice): (Phases, Choice),
    ) -> Result<Option<Self>, StabilityError> {
        let modes = steps.modes();
        let starts: Vec<DMatrix<f64>> = modes
            .vertices()
            .map(|vertex| DMatrix::from_column_slice(modes.places_all(), 1, modes.after_step(vertex).as_slice()))
            .collect();
        let focus = |rows: Vec<DMatrix<f64>>, frozen: Vec<DMatrix<f64>>| Focus {
            rows,
            frozen,
            bound: 1.0,
            starts: starts.clone(),
        };
        let of_force: Vec<DMatrix<f64>> =
            modes.vertices().map(|vertex| modes.force(vertex)).chain([modes.fed_back()]).collect();
        let [slave_found, force_found] = found(steps, choice.dwell);
        let (slave, force) = rayon::join(
            || bound(modes, phases, choice, &focus(vec![modes.slave()], vec![modes.slave()]), slave_found),
            || bound(modes, phases, choice, &focus(of_force.clone(), vec![modes.fed_back()]), force_found),
        );
        let (Some(slave), Some(force)) = (slave?, force?) else { return Ok(None) };
        let (worst, simulated) = on_one_stiffness(settings, phases, choice.dwell)?;
        Ok(Some(Self { slave, force, slave_found: slave_found.max(simulated), force_found, worst, simulated }))
    }
}

fn found(steps: &Steps<'_>, dwell: u64) -> [f64; 2] {
    let modes = steps.modes();
    [modes.slave(), modes.fed_back()].map(|row| farthest(steps, dwell, &[row]))
}

fn bound(
    modes: &Modes,
    phases: Phases,
    choice: Choice,
    focus: &Focus,
    found: f64,
) -> Result<Option<(f64, Certificate)>, StabilityError> {
    let at = |bound: f64| -> Result<Option<Certificate>, StabilityError> {
        attempt(modes, phases, choice, Some(&Focus { bound, ..focus.clone() }))
    };
    let found = found.max(f64::MIN_POSITIVE);
    let mut best = None;
    let mut ratio: f64 = 1.2;
    let mut fails: f64 = 1.0;
    while best.is_none() && ratio <= LARGEST {
        match at(found * ratio)? {
            Some(certificate) => best = Some((ratio, certificate)),
            None => {
                fails = ratio;
                ratio = 1.0 + 2.0 * (ratio - 1.0);
            }
        }
    }
    let Some(best) = best else { return Ok(None) };
    let (ratio, certificate) = narrowed(best, fails, MAX_RATIO, |ratio| at(found * ratio))?;
    Ok(Some((found * ratio, certificate)))
}

/// Simulates motions so small that a ramp closes its gap within a tick. Returns the slave's maximum position from the
/// first event on.
fn simulate(modes: &Modes, phases: Phases, sequence: &Sequence, extra_ticks: u64) -> f64 {
    let share = *modes.shares().last().unwrap_or(&1.0);
    let (teleoperation, frozen, slave) = (modes.teleoperation(0), modes.frozen(0, share), modes.slave());
    let (freeze, release, closed) = (modes.freeze(), modes.release(0), modes.closed());
    let blends: Vec<DMatrix<f64>> =
        (1..=phases.blend).map(|tick| modes.blend(0, cross_fade(tick as f64 / phases.blend as f64))).collect();
    let mut state = modes.after_step(0);
    let mut max: f64 = 0.0;
    let mut tick = 1;
    let seen = |state: &nalgebra::DVector<f64>| (&slave * state)[0].abs();
    for &start in &sequence.starts {
        while tick + 1 < start {
            state = &teleoperation * state;
            tick += 1;
            if Some(&start) != sequence.starts.first() {
                max = max.max(seen(&state));
            }
        }
        state = &freeze * (&teleoperation * state);
        max = max.max(seen(&state));
        for _ in 0..sequence.held_ticks {
            state = &frozen * state;
            max = max.max(seen(&state));
        }
        state = &release * state;
        for blend in &blends {
            state = blend * state;
            if modes.gap_closes() {
                state = &closed * state;
            }
            max = max.max(seen(&state));
        }
        tick = start + sequence.held_ticks + phases.blend;
    }
    for _ in 0..extra_ticks {
        state = &teleoperation * state;
        max = max.max(seen(&state));
    }
    max
}

/// The tried sequence on one stiffness with the maximum motion of the slave. Each event is added at its worst time.
fn on_one_stiffness(
    settings: &SwitchingSettings,
    phases: Phases,
    dwell: u64,
) -> Result<(Sequence, f64), StabilityError> {
    let (softest, stiffest) = settings.stiffness_n_per_m;
    let (shortest, longest) = phases.held;
    let tried: Vec<(Sequence, f64)> = try_map(STIFFNESSES * 2, |k| {
        let stiffness = softest + (stiffest - softest) * (k / 2) as f64 / (STIFFNESSES - 1) as f64;
        let here =
            SwitchingSettings { stiffness_n_per_m: (stiffness, stiffness), loses_contact: false, ..settings.clone() };
        let modes = Modes::new(&here)?;
        let held_ticks = if k % 2 == 0 { shortest } else { longest };
        let mut best = (Sequence { stiffness_n_per_m: stiffness, starts: vec![], held_ticks }, 0.0);
        for _ in 0..EVENTS {
            interrupt::check();
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
        Ok::<_, StabilityError>(best)
    })?;
    let none = Sequence { stiffness_n_per_m: stiffest, starts: vec![], held_ticks: shortest };
    Ok(tried.into_iter().max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((none, 0.0)))
}
