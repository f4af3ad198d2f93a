//! The certificate: found by a solver, verified independently.

use nalgebra::{Cholesky, DMatrix, DVector};

use super::conditions::{Choice, Conditions, Space, size};
use super::interval::{Enclosure, Interval, exact, is_positive_definite};
use super::modes::Modes;
use super::sdp;
use super::settings::Phases;
use crate::stability::StabilityError;

/// Number of doublings in a Gramian's sum: 2^40 ticks, longer than any transient.
const DOUBLINGS: usize = 40;

/// The minimum margin of a certificate: far above the solver's accuracy of 1e-8, so that the dwell is the same on every
/// machine.
const MIN_MARGIN: f64 = 1e-3;

/// Lyapunov functions that prove that every sequence of events decays.
#[derive(Debug, Clone)]
pub struct Certificate {
    /// Required ticks of teleoperation between two events.
    pub dwell_ticks: u64,
    /// Verified bound of the ratio of `V` at the beginnings of consecutive events; below 1.
    pub contraction: f64,
    /// The solver's common margin of all scaled conditions.
    pub margin: f64,
    /// Number of verified conditions.
    pub conditions: usize,
    /// `P` of the function at the beginning of events, on the loop's states.
    pub at_events: DMatrix<f64>,
    /// All matrices, each with its space.
    matrices: Vec<(DMatrix<f64>, Space)>,
}

impl Certificate {
    /// The matrices of the functions on a space.
    pub(super) fn in_space(&self, space: Space) -> impl Iterator<Item = &(DMatrix<f64>, Space)> {
        self.matrices.iter().filter(move |(_, known)| *known == space)
    }
}

/// The map from scaled states to states of a space; it maps the unit ball to the states reachable by the loop's inputs.
fn scales(modes: &Modes) -> Result<impl Fn(Space) -> DMatrix<f64>, StabilityError> {
    let n = modes.states();
    let middle = (modes.teleoperation(0) + modes.teleoperation(1)) * 0.5;
    let size_of = |column: &DMatrix<f64>| column.norm().max(f64::MIN_POSITIVE);
    // The inputs are normalised by the position that each reaches.
    let inputs = [modes.of_reference(), modes.of_force(), modes.of_desired()];
    let mut gramian: DMatrix<f64> = DMatrix::zeros(n, n);
    for input in &inputs {
        let mut sum = input * input.transpose();
        let mut step = middle.clone();
        for _ in 0..DOUBLINGS {
            sum += &step * &sum * step.transpose();
            step = &step * &step;
        }
        let position = sum[(0, 0)].max(f64::MIN_POSITIVE);
        gramian += sum / position;
    }
    let spread = gramian.diagonal().map(|value| 1e-10 * value);
    gramian += DMatrix::from_diagonal(&spread);
    let gramian = gramian.map(|value| if value.is_finite() { value } else { 0.0 });
    let of_loop = Cholesky::new(gramian)
        .map(|found| found.l())
        .ok_or(StabilityError::Solver { status: "the loop's states do not scale".into() })?;
    let inverse = of_loop.clone().try_inverse().ok_or(StabilityError::Solver { status: "singular".into() })?;
    // A metre of reference and a newton of force, scaled by their equilibria.
    let rest = |input: &DMatrix<f64>| {
        let apart = DMatrix::identity(n, n) - modes.apart(0);
        let state = apart.lu().solve(input).unwrap_or_else(|| input.clone());
        size_of(&(&inverse * state))
    };
    let (metre, newton) = (rest(&modes.of_reference()), rest(&modes.of_force()));
    let frozen = modes.frozen_states();
    Ok(move |space| {
        let with = |extra: &[f64]| {
            let all = n + extra.len();
            let mut scale = DMatrix::zeros(all, all);
            scale.view_mut((0, 0), (n, n)).copy_from(&of_loop);
            for (k, value) in extra.iter().enumerate() {
                scale[(n + k, n + k)] = 1.0 / value;
            }
            scale
        };
        match space {
            Space::Loop => with(&[]),
            Space::Frozen => with(&[metre, newton, newton][..frozen - n]),
            Space::Fading => with(&[newton]),
            Space::Gap => DMatrix::from_element(1, 1, 1.0 / metre),
        }
    })
}

/// The quantities whose bounds a certificate minimises.
#[derive(Debug, Clone)]
pub(super) struct Focus {
    /// The initial states.
    pub(super) starts: Vec<DVector<f64>>,
    /// The quantities to bound: rows on each space's states.
    pub(super) rows: Vec<(Space, DMatrix<f64>)>,
    /// A certificate with a margin for the same conditions.
    pub(super) plain: Certificate,
}

/// The fraction of a certificate with a margin that is added to one without, in factors of four.
const MIN_DILUTION: f64 = 1e-6;
const DILUTIONS: i32 = 12;

/// The fixed margin of the conditions when bounds are minimised.
const FIXED_MARGIN: f64 = 1e-6;

/// The verified certificate for a dwell, if there is one: with the maximum margin, or the minimum bound of the focus.
///
/// # Errors
/// [`StabilityError::Solver`].
pub(super) fn certify(
    modes: &Modes,
    phases: Phases,
    choice: Choice,
    focus: Option<&Focus>,
) -> Result<Option<Certificate>, StabilityError> {
    Ok(attempt(modes, phases, choice, focus)?.certificate)
}

/// A certificate if found, and the solver's margin.
#[derive(Debug, Clone)]
pub(super) struct Attempt {
    pub(super) margin: f64,
    pub(super) certificate: Option<Certificate>,
}

/// As [`certify`].
///
/// # Errors
/// [`StabilityError::Solver`].
pub(super) fn attempt(
    modes: &Modes,
    phases: Phases,
    choice: Choice,
    focus: Option<&Focus>,
) -> Result<Attempt, StabilityError> {
    let conditions = Conditions::new(modes, phases, choice);
    let scale = scales(modes)?;
    let mut scaled_conditions = conditions.scaled(&scale);
    let mut normal = sdp::Normal::Traces;
    let at_events = *conditions.roles.dwelling.last().unwrap_or(&0);
    if let Some(Focus { starts, rows, .. }) = focus {
        for condition in &mut scaled_conditions {
            (condition.offset, condition.weight) = (FIXED_MARGIN * condition.weight, 0.0);
        }
        let longest = rows.iter().map(|(space, row)| (row * scale(*space)).norm()).fold(f64::MIN_POSITIVE, f64::max);
        for (space, row) in rows {
            let scaled_row = row * scale(*space) / longest;
            let unknowns = conditions.unknowns.iter().enumerate().filter(|(_, known)| *known == space);
            for (unknown, _) in unknowns {
                let map = DMatrix::identity(scaled_row.len(), scaled_row.len());
                let terms = vec![sdp::Term { factor: 1.0, unknown, map }];
                scaled_conditions.push(sdp::Condition {
                    terms,
                    weight: 0.0,
                    row: Some(scaled_row.clone()),
                    offset: 0.0,
                });
            }
        }
        let inverse = scale(Space::Loop).try_inverse().unwrap_or_else(|| scale(Space::Loop));
        let starts: Vec<DVector<f64>> = starts.iter().map(|start| &inverse * start).collect();
        let longest = starts.iter().map(|start| start.norm()).fold(f64::MIN_POSITIVE, f64::max);
        normal = sdp::Normal::Level(at_events, starts.into_iter().map(|start| start / longest).collect());
    }
    let (scaled, margin) = match sdp::solve(&conditions.sizes(modes), &scaled_conditions, &normal) {
        // The bound is then less tight.
        Err(_) if focus.is_some() => return Ok(Attempt { margin: 0.0, certificate: None }),
        solved => solved?,
    };
    if margin < MIN_MARGIN && focus.is_none() {
        return Ok(Attempt { margin, certificate: None });
    }
    let matrices: Vec<DMatrix<f64>> = scaled
        .iter()
        .zip(&conditions.unknowns)
        .map(|(matrix, &space)| {
            let inverse =
                scale(space).try_inverse().unwrap_or_else(|| DMatrix::identity(size(modes, space), size(modes, space)));
            let plain = inverse.transpose() * matrix * inverse;
            // Exactly symmetric.
            (&plain + plain.transpose()) * 0.5
        })
        .collect();
    let holds = |matrices: &[DMatrix<f64>]| {
        conditions.list.iter().all(|condition| is_positive_definite(&condition.enclosure(matrices)))
    };
    let matrices = match focus {
        None => Some(matrices).filter(|matrices| holds(matrices)),
        // The minimum bound lies on the boundary of the feasible set. The conditions are homogeneous: adding a little
        // of a certificate with a margin restores feasibility.
        Some(Focus { plain, .. }) => (0..DILUTIONS).find_map(|k| {
            let share = MIN_DILUTION * 4.0_f64.powi(k);
            let diluted = matrices.iter().zip(&plain.matrices).map(|(matrix, (other, _))| matrix + other * share);
            Some(diluted.collect::<Vec<_>>()).filter(|matrices| holds(matrices))
        }),
    };
    let Some(matrices) = matrices else { return Ok(Attempt { margin, certificate: None }) };
    let certificate = Some(Certificate {
        dwell_ticks: choice.dwell,
        contraction: contraction(&conditions, &matrices),
        margin,
        conditions: conditions.list.len(),
        at_events: matrices[at_events].clone(),
        matrices: matrices.into_iter().zip(conditions.unknowns).collect(),
    });
    Ok(Attempt { margin, certificate })
}

/// The verified contraction of `V` over an event, by bisection.
fn contraction(conditions: &Conditions, matrices: &[DMatrix<f64>]) -> f64 {
    let entering: Vec<_> = conditions.list.iter().filter(|condition| condition.name == "entering").collect();
    let holds = |factor: f64| {
        entering.iter().all(|condition| {
            let mut other = (*condition).clone();
            for term in other.terms.iter_mut().filter(|term| term.factor.low > 0.0) {
                term.factor = term.factor * Interval::exact(factor);
            }
            is_positive_definite(&other.enclosure(matrices))
        })
    };
    let (mut below, mut above) = (0.0, 1.0);
    for _ in 0..30 {
        let middle = 0.5 * (below + above);
        if holds(middle) { above = middle } else { below = middle }
    }
    above
}

/// The verified minimum `bound` with `(c x)² <= bound² xᵀ P x`, to a part in a thousand.
pub(super) fn peak(p: &DMatrix<f64>, c: &DMatrix<f64>) -> f64 {
    let Some(inverse) = p.clone().try_inverse() else { return f64::INFINITY };
    let square = (c * inverse * c.transpose())[(0, 0)];
    let mut bound = square.abs().sqrt().max(f64::MIN_POSITIVE);
    // The first value that verifies, from the unverified minimum upwards.
    for _ in 0..60 {
        bound *= 1.0005;
        let weight = Interval::exact((1.0 / (bound * bound)).next_up());
        let outer: Enclosure = (0..c.len())
            .map(|i| (0..c.len()).map(|j| Interval::rounded(c[i]) * Interval::rounded(c[j]) * weight).collect())
            .collect();
        let rest: Enclosure =
            exact(p).iter().zip(&outer).map(|(a, b)| a.iter().zip(b).map(|(x, y)| *x - *y).collect()).collect();
        if is_positive_definite(&rest) {
            return bound;
        }
    }
    f64::INFINITY
}
