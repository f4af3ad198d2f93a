//! Stops candidates that will not survive their generation.
//!
//! If all parents are feasible and none dominates another, a child survives only if it is feasible and no parent
//! dominates it. After a part of the patients, a child is stopped if, improved by [`MARGIN`] standard errors,
//!
//! - it violates a constraint (a diverged run or a loop that cannot be certified excludes it at once), or
//! - a parent is better on the same runs in every objective.
//!
//! Quantiles have the margin of the order statistic (binomial distribution), and are compared with the parent's value
//! on all patients.

use super::evaluate::Evaluation;
use super::goals::{Direction, Goals, Limit};
use super::nsga::{Point, pareto_dominates};
use super::quantity::{Aggregate, Samples};

/// Standard errors. Chosen here: 1 child in 700 exceeds them by chance.
const MARGIN: f64 = 3.0;

/// Minimum for a standard error.
const MIN_PATIENTS: usize = 4;

/// All parents are feasible, and none dominates another.
pub(super) struct Race<'a> {
    goals: &'a Goals,
    parents: &'a [Evaluation],
    runs_of_patient: usize,
}

impl<'a> Race<'a> {
    /// `None` if a dominated or infeasible child could survive.
    pub(super) fn among(goals: &'a Goals, parents: &'a [Evaluation], runs_of_patient: usize) -> Option<Self> {
        let points: Vec<Point> = parents.iter().map(|parent| parent.point(goals)).collect();
        let is_dominated =
            |point: &Point| points.iter().any(|other| pareto_dominates(&other.objectives, &point.objectives));
        let is_sharp = points.iter().all(|point| point.violation <= 0.0 && !is_dominated(point));
        is_sharp.then_some(Self { goals, parents, runs_of_patient })
    }

    pub(super) fn is_hopeless(&self, child: &Evaluation) -> bool {
        let goals = self.goals;
        if child.diverged > 0.0 || goals.certified.is_some() && child.without_certificate > 0.0 {
            return true;
        }
        if child.runs as usize / self.runs_of_patient < MIN_PATIENTS {
            return false;
        }
        let (of_objectives, of_constraints) = child.samples.split_at(goals.objectives.len());
        let is_violated = goals.constraints.iter().zip(of_constraints).any(|(constraint, samples)| {
            let direction = match constraint.limit {
                Limit::AtLeast(_) => Direction::Maximise,
                Limit::AtMost(_) => Direction::Minimise,
            };
            let best = self.improved(samples, constraint.aggregate, direction);
            best.is_some_and(|best| constraint.limit.excess(direction.cost(best)) > 0.0)
        });
        let is_worse = |parent: &Evaluation| {
            goals.objectives.iter().enumerate().all(|(index, objective)| match objective.aggregate {
                Aggregate::Mean => {
                    let difference = self.difference(&of_objectives[index], &parent.samples[index]);
                    difference.is_some_and(|(mean, error)| match objective.direction {
                        Direction::Minimise => mean - MARGIN * error > 0.0,
                        Direction::Maximise => mean + MARGIN * error < 0.0,
                    })
                }
                Aggregate::Quantile(_) => {
                    let best = self.improved(&of_objectives[index], objective.aggregate, objective.direction);
                    let of_parent = parent.values[index].map(|value| objective.direction.cost(value));
                    best.zip(of_parent).is_some_and(|(best, of_parent)| best > of_parent)
                }
            })
        };
        is_violated || self.parents.iter().any(is_worse)
    }

    /// Improved by the margin.
    fn improved(&self, samples: &Samples, aggregate: Aggregate, direction: Direction) -> Option<f64> {
        match aggregate {
            Aggregate::Mean => {
                let (mean, error) = self.mean(samples)?;
                Some(direction.cost(mean) - MARGIN * error)
            }
            Aggregate::Quantile(share) => {
                let mut costs: Vec<f64> = samples.values().iter().map(|value| direction.cost(*value)).collect();
                costs.sort_by(f64::total_cmp);
                let share = if direction == Direction::Minimise { share } else { 1.0 - share };
                let count = costs.len() as f64;
                let rank = share * (count - 1.0) - MARGIN * (count * share * (1.0 - share)).sqrt() - 1.0;
                // Without a lower order statistic, nothing excludes a better value.
                if rank < 0.0 { None } else { costs.get(rank as usize).copied() }
            }
        }
    }

    /// Mean and its standard error.
    fn mean(&self, samples: &Samples) -> Option<(f64, f64)> {
        let parts = self.contributions(samples, samples.runs())?;
        Some((parts.mean, parts.error(|patient| parts.of_patients[patient])))
    }

    /// Difference over the same runs, and its standard error.
    fn difference(&self, child: &Samples, parent: &Samples) -> Option<(f64, f64)> {
        let runs = child.runs();
        let (of_child, of_parent) = (self.contributions(child, runs)?, self.contributions(parent, runs)?);
        let error = of_child.error(|patient| of_child.of_patients[patient] - of_parent.of_patients[patient]);
        Some((of_child.mean - of_parent.mean, error))
    }

    fn contributions(&self, samples: &Samples, runs: usize) -> Option<Contributions> {
        let mean = samples.aggregate_over(Aggregate::Mean, 0..runs)?;
        let weight: f64 = (0..runs).map(|run| samples.sum(run).1).sum();
        let deviation = |run: usize| {
            let (sum, weight) = samples.sum(run);
            sum - mean * weight
        };
        let patients = runs / self.runs_of_patient;
        let of_patient = |patient: usize| {
            let runs = patient * self.runs_of_patient..(patient + 1) * self.runs_of_patient;
            runs.map(deviation).sum::<f64>() / weight
        };
        Some(Contributions { mean, of_patients: (0..patients).map(of_patient).collect() })
    }
}

/// A mean, and each patient's deviation from it.
struct Contributions {
    mean: f64,
    of_patients: Vec<f64>,
}

impl Contributions {
    fn error(&self, part: impl Fn(usize) -> f64) -> f64 {
        let patients = self.of_patients.len();
        let squares: f64 = (0..patients).map(|patient| part(patient).powi(2)).sum();
        (squares * patients as f64 / (patients.max(2) - 1) as f64).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::super::evaluate::Ended;
    use super::super::goals::{Constraint, Objective};
    use super::super::quantity::{Quantity, Values};
    use super::*;

    fn goals(limit: f64) -> Goals {
        let quantity = |name: &str| Quantity::named(name).expect("a quantity");
        let objective = |name: &str, direction| Objective {
            name: name.into(),
            quantity: quantity(name),
            aggregate: Aggregate::Mean,
            direction,
        };
        Goals {
            objectives: vec![
                objective("max_slave_overshoot_m", Direction::Minimise),
                objective("min_felt_contrast", Direction::Maximise),
            ],
            constraints: vec![Constraint {
                name: "force".into(),
                quantity: quantity("max_tissue_force_n"),
                aggregate: Aggregate::Mean,
                limit: Limit::AtMost(limit),
            }],
            certified: None,
        }
    }

    fn evaluation(goals: &Goals, patients: usize, of: impl Fn(usize) -> [f64; 3]) -> Evaluation {
        let mut samples = vec![Samples::default(); 3];
        for patient in 0..patients {
            for (samples, value) in samples.iter_mut().zip(of(patient)) {
                samples.push(Values { values: vec![value], weight: 1.0 });
            }
        }
        Evaluation {
            coordinates: vec![],
            ended: Ended::Complete,
            runs: patients as u64,
            diverged: 0.0,
            without_certificate: 0.0,
            values: goals.values(&samples),
            samples,
        }
    }

    /// Patients differ by much more than the candidates.
    fn patient(patient: usize) -> f64 {
        (patient % 5) as f64
    }

    #[test]
    fn a_child_stops_if_it_is_worse_on_the_same_patients_but_not_if_it_is_better_in_one_objective() {
        let goals = goals(10.0);
        let parents = [evaluation(&goals, 16, |k| [patient(k), patient(k), 1.0])];
        let race = Race::among(&goals, &parents, 1).expect("a feasible parent");
        let child = |overshoot: f64, contrast: f64| {
            let noise = |k: usize| 1e-3 * (k % 2) as f64;
            evaluation(&goals, 4, |k| [patient(k) + overshoot + noise(k), patient(k) + contrast + noise(k), 1.0])
        };
        assert!(race.is_hopeless(&child(0.1, -0.1)));
        assert!(!race.is_hopeless(&child(0.1, 0.1)));
        assert!(!race.is_hopeless(&child(-0.1, -0.1)));
        assert!(!race.is_hopeless(&child(0.0, 0.0)), "an equal child");
        let few = evaluation(&goals, 3, |k| [patient(k) + 1.0, patient(k) - 1.0, 1.0]);
        assert!(!race.is_hopeless(&few), "too few patients");
    }

    #[test]
    fn a_child_stops_beyond_a_limit_and_if_it_diverges() {
        let goals = goals(2.0);
        let parents = [evaluation(&goals, 16, |k| [patient(k), patient(k), 1.0])];
        let race = Race::among(&goals, &parents, 1).expect("a feasible parent");
        let with_force = |force: f64| evaluation(&goals, 6, |k| [0.0, 9.0, force + 0.1 * patient(k)]);
        assert!(race.is_hopeless(&with_force(3.0)));
        assert!(!race.is_hopeless(&with_force(1.9)), "it may be mended");
        assert!(race.is_hopeless(&Evaluation { diverged: 0.1, ..with_force(0.0) }));
        // A dominated child may survive if a parent is infeasible or dominated.
        let infeasible = [evaluation(&goals, 16, |_| [1.0, 1.0, 5.0])];
        assert!(Race::among(&goals, &infeasible, 1).is_none());
        let dominated = [0.0, 1.0].map(|cost| evaluation(&goals, 16, |_| [cost, 1.0, 1.0]));
        assert!(Race::among(&goals, &dominated, 1).is_none());
    }
}
