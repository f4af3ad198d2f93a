//! Objectives and constraints of a design.

use super::nsga::Point;
use super::quantity::{Aggregate, Quantity, Samples};

/// The direction of an objective.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Direction {
    /// Smaller values are better.
    Minimise,
    /// Larger values are better.
    Maximise,
}

impl Direction {
    /// The name used in files.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Minimise => "minimise",
            Self::Maximise => "maximise",
        }
    }

    /// A value as a cost, which is minimised.
    #[must_use]
    pub fn cost(self, value: f64) -> f64 {
        match self {
            Self::Minimise => value,
            Self::Maximise => -value,
        }
    }
}

/// An objective.
#[derive(Debug, Clone)]
pub struct Objective {
    /// The name that the file gives it.
    pub name: String,
    /// The quantity.
    pub quantity: Quantity,
    /// The aggregation over the runs.
    pub aggregate: Aggregate,
    /// The direction.
    pub direction: Direction,
}

/// The side of a limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Limit {
    /// Smaller values violate the constraint.
    AtLeast(f64),
    /// Larger values violate the constraint.
    AtMost(f64),
}

impl Limit {
    /// The distance of a value beyond the limit, relative to the limit, or absolute if it is 0; at most 0 within it.
    #[must_use]
    pub fn excess(self, value: f64) -> f64 {
        let (beyond, limit) = match self {
            Self::AtLeast(limit) => (limit - value, limit),
            Self::AtMost(limit) => (value - limit, limit),
        };
        if limit == 0.0 { beyond } else { beyond / limit.abs() }
    }

    /// The limit.
    #[must_use]
    pub fn value(self) -> f64 {
        match self {
            Self::AtLeast(limit) | Self::AtMost(limit) => limit,
        }
    }
}

/// A constraint on a quantity.
#[derive(Debug, Clone)]
pub struct Constraint {
    /// The name that the file gives it.
    pub name: String,
    /// The quantity.
    pub quantity: Quantity,
    /// The aggregation over the runs.
    pub aggregate: Aggregate,
    /// The limit.
    pub limit: Limit,
}

/// The objectives and constraints.
#[derive(Debug, Clone)]
pub struct Goals {
    /// The objectives, at least one.
    pub objectives: Vec<Objective>,
    /// The constraints on quantities.
    pub constraints: Vec<Constraint>,
    /// The name of the constraint that every motion is certified to decay, if there is one.
    pub certified: Option<String>,
}

/// The violation of an undefined value: larger than that of any likely value, so that defined values are preferred.
const UNDEFINED: f64 = 1e3;

impl Goals {
    /// The quantities: those of the objectives, then those of the constraints.
    pub fn quantities(&self) -> impl Iterator<Item = (&Quantity, Aggregate)> {
        let objectives = self.objectives.iter().map(|objective| (&objective.quantity, objective.aggregate));
        objectives.chain(self.constraints.iter().map(|constraint| (&constraint.quantity, constraint.aggregate)))
    }

    /// The values of the quantities over some runs.
    #[must_use]
    pub fn values(&self, samples: &[Samples]) -> Vec<Option<f64>> {
        self.quantities().zip(samples).map(|((_, aggregate), samples)| samples.aggregate(aggregate)).collect()
    }

    /// The point of values of the quantities. `without_certificate` is the share of the loops that cannot be certified,
    /// and `diverged` the share of the runs that diverge.
    #[must_use]
    pub fn point(&self, values: &[Option<f64>], without_certificate: f64, diverged: f64) -> Point {
        let (objectives, constraints) = values.split_at(self.objectives.len().min(values.len()));
        let mut violation = diverged + if self.certified.is_some() { without_certificate } else { 0.0 };
        for (constraint, value) in self.constraints.iter().zip(constraints) {
            violation += value.map_or(UNDEFINED, |value| constraint.limit.excess(value).max(0.0));
        }
        let cost = |(objective, value): (&Objective, &Option<f64>)| {
            value.map_or(f64::INFINITY, |value| objective.direction.cost(value))
        };
        let objectives: Vec<f64> = self.objectives.iter().zip(objectives).map(cost).collect();
        violation += UNDEFINED * objectives.iter().filter(|cost| cost.is_infinite()).count() as f64;
        Point { objectives, violation }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_violation_is_relative_to_its_limit_and_an_undefined_value_violates() {
        let quantity = |name: &str| Quantity::named(name).expect("a quantity");
        let goals = Goals {
            objectives: vec![Objective {
                name: "noticed".into(),
                quantity: quantity("rupture_noticed"),
                aggregate: Aggregate::Mean,
                direction: Direction::Maximise,
            }],
            constraints: vec![Constraint {
                name: "force".into(),
                quantity: quantity("max_tissue_force_n"),
                aggregate: Aggregate::Quantile(0.95),
                limit: Limit::AtMost(4.0),
            }],
            certified: None,
        };
        let point = |noticed, force| goals.point(&[noticed, force], 1.0, 0.0);
        assert_eq!(point(Some(0.9), Some(4.0)), Point { objectives: vec![-0.9], violation: 0.0 });
        assert_eq!(point(Some(0.9), Some(5.0)).violation, 0.25);
        assert_eq!(point(Some(0.9), None).violation, UNDEFINED);
        assert!(point(None, Some(1.0)).violation > 0.0);
        assert_eq!(Limit::AtLeast(0.0).excess(-2.0), 2.0);
        let certified = Goals { certified: Some("c".into()), ..goals };
        assert_eq!(certified.point(&[Some(0.9), Some(1.0)], 0.5, 0.25).violation, 0.75);
    }
}
