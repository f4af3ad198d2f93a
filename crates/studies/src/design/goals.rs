use super::nsga::Point;
use super::quantity::{Aggregate, Quantity, Samples};

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Direction {
    Minimise,
    Maximise,
}

impl Direction {
    pub fn word(self) -> &'static str {
        match self {
            Self::Minimise => "minimise",
            Self::Maximise => "maximise",
        }
    }

    /// A cost is minimised.
    pub fn cost(self, value: f64) -> f64 {
        match self {
            Self::Minimise => value,
            Self::Maximise => -value,
        }
    }
}

#[derive(Debug, Clone)]
pub struct Objective {
    pub name: String,
    pub quantity: Quantity,
    pub aggregate: Aggregate,
    pub direction: Direction,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Limit {
    AtLeast(f64),
    AtMost(f64),
}

impl Limit {
    /// Relative to the limit, or absolute if it is 0; at most 0 within it.
    pub fn excess(self, value: f64) -> f64 {
        let (beyond, limit) = match self {
            Self::AtLeast(limit) => (limit - value, limit),
            Self::AtMost(limit) => (value - limit, limit),
        };
        if limit == 0.0 { beyond } else { beyond / limit.abs() }
    }

    pub fn value(self) -> f64 {
        match self {
            Self::AtLeast(limit) | Self::AtMost(limit) => limit,
        }
    }
}

#[derive(Debug, Clone)]
pub struct Constraint {
    pub name: String,
    pub quantity: Quantity,
    pub aggregate: Aggregate,
    pub limit: Limit,
}

#[derive(Debug, Clone)]
pub struct Goals {
    pub objectives: Vec<Objective>,
    pub constraints: Vec<Constraint>,
    pub certified: Option<String>,
}

/// Larger than any likely violation, so that defined values are preferred.
const UNDEFINED: f64 = 1e3;

impl Goals {
    /// Those of the objectives come first.
    pub fn quantities(&self) -> impl Iterator<Item = (&Quantity, Aggregate)> {
        let objectives = self.objectives.iter().map(|objective| (&objective.quantity, objective.aggregate));
        objectives.chain(self.constraints.iter().map(|constraint| (&constraint.quantity, constraint.aggregate)))
    }

    pub fn values(&self, samples: &[Samples]) -> Vec<Option<f64>> {
        self.quantities().zip(samples).map(|((_, aggregate), samples)| samples.aggregate(aggregate)).collect()
    }

    /// `without_certificate` is a share of the loops, `diverged` one of the runs.
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
