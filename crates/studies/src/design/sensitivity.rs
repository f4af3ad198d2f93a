use schemars::JsonSchema;
use serde::Serialize;

use super::evaluate::Evaluation;
use super::nsga::{Gene, Point};
use super::problem::Problem;
use trocar_base::quantiles::{rank_correlation, standard_ranks};

/// As a share of the objective's range on the front.
pub const EQUAL: f64 = 0.05;

/// The influence of a free key on an objective over the feasible candidates.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, JsonSchema)]
pub struct Sensitivity {
    /// Spearman's rank correlation; `None` for choices, and if either is constant.
    pub rank_correlation: Option<f64>,
    /// Share of the variance of the objective's ranks that the key alone explains: the squared correlation for numbers,
    /// the correlation ratio for choices.
    pub share: Option<f64>,
}

pub fn sensitivities(problem: &Problem, archive: &[Evaluation]) -> Vec<Vec<Sensitivity>> {
    let feasible: Vec<(&Evaluation, Point)> = archive
        .iter()
        .map(|evaluation| (evaluation, evaluation.point(&problem.goals)))
        .filter(|(_, point)| point.violation <= 0.0)
        .collect();
    let of = |key: usize, gene: Gene, objective: usize| {
        let values: Vec<f64> = feasible.iter().map(|(_, point)| point.objectives[objective]).collect();
        let coordinates: Vec<f64> = feasible.iter().map(|(evaluation, _)| evaluation.coordinates[key]).collect();
        // The sign is that of the objective's value, not of its cost.
        let sign = problem.goals.objectives[objective].direction.cost(1.0);
        match gene {
            Gene::Number => {
                let pairs: Vec<(f64, f64)> =
                    coordinates.iter().copied().zip(values.iter().map(|value| sign * value)).collect();
                let correlation = rank_correlation(&pairs);
                Sensitivity { rank_correlation: correlation, share: correlation.map(|r| r * r) }
            }
            Gene::Choice(count) => {
                let choices: Vec<u64> = coordinates.iter().map(|coordinate| gene.choice(*coordinate)).collect();
                Sensitivity { rank_correlation: None, share: correlation_ratio(&choices, count, &values) }
            }
        }
    };
    let objectives = 0..problem.goals.objectives.len();
    let of_key = |(key, gene): (usize, Gene)| objectives.clone().map(|objective| of(key, gene, objective)).collect();
    problem.genes().into_iter().enumerate().map(of_key).collect()
}

/// Share of the variance of the ranks between the choices.
fn correlation_ratio(choices: &[u64], count: u64, values: &[f64]) -> Option<f64> {
    let ranks = standard_ranks(values)?;
    let between = |choice: u64| {
        let of_choice: Vec<f64> =
            choices.iter().zip(&ranks).filter(|(other, _)| **other == choice).map(|(_, rank)| *rank).collect();
        of_choice.iter().sum::<f64>().powi(2) / of_choice.len().max(1) as f64
    };
    Some((0..count).map(between).sum::<f64>() / ranks.len().max(1) as f64)
}

/// `front` gives the ranges of the objectives.
pub fn as_good_as(points: &[Point], front: &[usize], index: usize) -> Vec<usize> {
    let range = |objective: usize| {
        let values = || front.iter().map(|&index| points[index].objectives[objective]);
        values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min)
    };
    let ranges: Vec<f64> = (0..points[index].objectives.len()).map(range).collect();
    let is_as_good = |point: &Point| {
        point.violation <= 0.0
            && point
                .objectives
                .iter()
                .zip(&points[index].objectives)
                .zip(&ranges)
                .all(|((value, best), range)| value - best <= EQUAL * range)
    };
    (0..points.len()).filter(|&other| is_as_good(&points[other])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn choices_explain_the_variance_between_them() {
        let close = |found: Option<f64>, expected: f64| (found.expect("varies") - expected).abs() < 1e-12;
        assert!(close(correlation_ratio(&[0, 0, 1, 1], 2, &[1.0, 1.0, 2.0, 2.0]), 1.0));
        assert!(close(correlation_ratio(&[0, 1, 0, 1], 2, &[1.0, 1.0, 2.0, 2.0]), 0.0));
        // Ranks 0, 1, 2, 3 in pairs: 16/20 of the variance is between the pairs.
        assert!(close(correlation_ratio(&[0, 0, 2, 2], 3, &[1.0, 2.0, 5.0, 9.0]), 0.8));
        assert_eq!(correlation_ratio(&[0, 1], 2, &[3.0, 3.0]), None);
    }

    #[test]
    fn a_candidate_is_as_good_within_a_share_of_the_fronts_range() {
        let point = |a: f64, b: f64, violation: f64| Point { objectives: vec![a, b], violation };
        let points = [
            point(0.0, 10.0, 0.0),
            point(5.0, 2.0, 0.0),
            point(10.0, 0.0, 0.0),
            point(5.4, 2.4, 0.0),
            point(5.6, 2.0, 0.0),
            point(5.0, 2.0, 0.1),
        ];
        assert_eq!(as_good_as(&points, &[0, 1, 2], 1), [1, 3]);
    }
}
