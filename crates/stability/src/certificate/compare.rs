use nalgebra::DMatrix;

use super::{Certificate, Inequality, Lyapunov, StateMap, Summand};

/// Relative: computers may round `exp` differently.
const TOLERANCE: f64 = 1e-9;

/// Relative to the largest entry of the matrix, for sums that cancel.
const CANCELLED: f64 = 1e-15;

impl Certificate {
    pub(super) fn check_parts(&self, required: &Self) -> Result<(), String> {
        let spaces: Vec<_> = self.spaces.iter().collect();
        each(
            "space",
            &spaces,
            &required.spaces.iter().collect::<Vec<_>>(),
            |(name, _)| name,
            |a, b| a.0 == b.0 && a.1.states == b.1.states,
        )?;
        let is_function = |a: &Lyapunov, b: &Lyapunov| a.name == b.name && a.space == b.space;
        each("function", &self.functions, &required.functions, |one| &one.name, is_function)?;
        let is_map = |a: &StateMap, b: &StateMap| {
            a.name == b.name && a.from == b.from && a.to == b.to && are_close(&a.matrix, &b.matrix)
        };
        each("map", &self.maps, &required.maps, |one| &one.name, is_map)?;
        let is_inequality = |a: &Inequality, b: &Inequality| {
            let are_terms = a.terms.len() == b.terms.len() && a.terms.iter().zip(&b.terms).all(|(a, b)| is_term(a, b));
            a.name == b.name && a.rows == b.rows && a.powers == b.powers && are_terms
        };
        each("inequality", &self.inequalities, &required.inequalities, |one| &one.name, is_inequality)?;
        if self.at_events == required.at_events { Ok(()) } else { Err("at_events is another function".to_owned()) }
    }
}

fn each<T>(
    kind: &str,
    stated: &[T],
    required: &[T],
    name: impl Fn(&T) -> &String,
    is_same: impl Fn(&T, &T) -> bool,
) -> Result<(), String> {
    if let Some(index) = stated.iter().zip(required).position(|(a, b)| !is_same(a, b)) {
        return Err(format!("{kind} {index} is not the scenario's {}", name(&required[index])));
    }
    match (stated.len(), required.len()) {
        (stated, needed) if stated < needed => Err(format!("{kind} {stated} ({}) is missing", name(&required[stated]))),
        (stated, needed) if stated > needed => Err(format!("{kind} {needed} is not one of the scenario's {needed}")),
        _ => Ok(()),
    }
}

fn is_term(a: &Summand, b: &Summand) -> bool {
    a.function == b.function && a.maps == b.maps && is_close(a.factor, b.factor, 0.0)
}

fn are_close(a: &DMatrix<f64>, b: &DMatrix<f64>) -> bool {
    let cancelled = CANCELLED * b.amax();
    a.shape() == b.shape() && a.iter().zip(b.iter()).all(|(a, b)| is_close(*a, *b, cancelled))
}

fn is_close(a: f64, b: f64, cancelled: f64) -> bool {
    b.is_finite() && (a - b).abs() <= TOLERANCE * b.abs() + cancelled
}
