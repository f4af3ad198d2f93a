//! The influence of each axis on a metric.
//!
//! The *first-order Sobol index* is the share of the metric's variance that the axis alone explains, `Var(E[y|x]) /
//! Var(y)`, estimated by classes (Plischke, Borgonovo and Smith, Eur. J. Oper. Res. 226, 2013) minus the share that
//! random classes would explain. It covers effects of any shape, and axes of words. The *standardised rank regression
//! coefficient* (Saltelli and Sobol', Reliab. Eng. Syst. Saf. 50, 1995) has a sign, with the other axes constant.

use nalgebra::{DMatrix, DVector};
use schemars::JsonSchema;
use serde::Serialize;

use super::cells::{class, classes};
use crate::sweep::axis::{Axis, number};
use crate::sweep::design::{Design, SamplingScheme};
use crate::sweep::permutation::Permutation;
use trocar_base::moments::Moments;
use trocar_base::quantiles::standard_ranks;
use trocar_scenario::Value;

/// Number for an axis without levels, otherwise a maximum. Chosen here: of a thousand cases, a class has 50.
const MAX_CLASSES: u64 = 20;

/// Makes the standard error of a coefficient of 0 0.01.
const MAX_RANKED: u64 = 10_000;

/// The influence of one axis on a metric.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Influence {
    /// Key of the axis.
    pub axis: String,
    /// First-order Sobol index; `None` if the metric does not vary.
    pub epsilon_squared: Option<f64>,
    /// Standardised rank regression coefficient; `None` for words, and if the regression is singular.
    pub rank_regression: Option<f64>,
    /// The smallest and largest mean of the metric over a class of the axis; `None` for given points, and for a metric
    /// that is never defined.
    pub means: Option<[LevelMean; 2]>,
}

/// The mean of a metric over the cases in a class of an axis.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct LevelMean {
    /// Value of the axis at the middle of the class.
    #[serde(serialize_with = "as_json")]
    #[schemars(with = "serde_json::Value")]
    pub at: Value,
    /// Mean of the metric.
    pub mean: f64,
}

fn as_json<S: serde::Serializer>(value: &Value, serializer: S) -> Result<S::Ok, S::Error> {
    value.to_toml().serialize(serializer)
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Influences {
    pub column: usize,
    /// Descending.
    pub of_axes: Vec<Influence>,
    /// Share of the ranks' variance that the regression explains.
    pub rank_r_squared: Option<f64>,
    pub ranked: u64,
}

pub(super) struct Inputs<'a> {
    design: &'a Design,
    counts: Vec<u64>,
    overall: Vec<Moments>,
    by_class: Vec<Vec<Vec<Moments>>>,
    ranked: Vec<u64>,
    read: usize,
    /// Numbers of the axes for the ranked cases.
    axes: Vec<Vec<f64>>,
    metrics: Vec<Vec<f64>>,
}

impl<'a> Inputs<'a> {
    pub(super) fn new(design: &'a Design) -> Self {
        let counts: Vec<u64> = design.axes.iter().map(|axis| classes(axis, MAX_CLASSES)).collect();
        let by_class: Vec<Vec<Moments>> =
            counts.iter().map(|&count| vec![Moments::default(); count as usize]).collect();
        // A regular selection would always hit the same levels.
        let cases = design.cases();
        let order = Permutation::new(cases, 1);
        let mut ranked: Vec<u64> = (0..cases.min(MAX_RANKED)).map(|index| order.at(index)).collect();
        ranked.sort_unstable();
        let focus = design.focus.len();
        Self {
            design,
            counts,
            overall: vec![Moments::default(); focus],
            by_class: vec![by_class; focus],
            ranked,
            read: 0,
            axes: vec![vec![]; design.axes.len()],
            metrics: vec![vec![]; focus],
        }
    }

    pub(super) fn add(&mut self, case: u64, coordinates: &[f64], values: &[f64]) {
        for (place, column) in self.design.focus.iter().enumerate() {
            self.overall[place].add_finite(values[*column]);
            for (axis, coordinate) in coordinates.iter().enumerate() {
                self.by_class[place][axis][class(*coordinate, self.counts[axis])].add_finite(values[*column]);
            }
        }
        if self.ranked.get(self.read) == Some(&case) {
            self.read += 1;
            for ((numbers, axis), coordinate) in self.axes.iter_mut().zip(&self.design.axes).zip(coordinates) {
                numbers.push(number(&axis.value(*coordinate)).unwrap_or(f64::NAN));
            }
            for (metric, column) in self.metrics.iter_mut().zip(&self.design.focus) {
                metric.push(values[*column]);
            }
        }
    }

    /// Given points vary along all axes at once.
    fn has_classes(&self) -> bool {
        !matches!(self.design.scheme, SamplingScheme::List { .. })
    }

    pub(super) fn influences(&self) -> Vec<Influences> {
        let of_focus = |(place, column): (usize, &usize)| {
            let regression = self.regression(place);
            let mut of_axes: Vec<Influence> = self
                .design
                .axes
                .iter()
                .enumerate()
                .map(|(index, axis)| Influence {
                    axis: axis.key.path.to_string(),
                    epsilon_squared: if self.has_classes() {
                        epsilon_squared(&self.overall[place], &self.by_class[place][index])
                    } else {
                        None
                    },
                    rank_regression: regression.as_ref().and_then(|regression| regression.coefficients[index]),
                    means: if self.has_classes() { means(axis, &self.by_class[place][index]) } else { None },
                })
                .collect();
            let strength = |influence: &Influence| influence.epsilon_squared.unwrap_or(0.0);
            let slope = |influence: &Influence| influence.rank_regression.unwrap_or(0.0).abs();
            of_axes.sort_by(|a, b| strength(b).total_cmp(&strength(a)).then(slope(b).total_cmp(&slope(a))));
            Influences {
                column: *column,
                of_axes,
                rank_r_squared: regression.as_ref().map(|regression| regression.r_squared),
                ranked: self.metrics[place].iter().filter(|value| value.is_finite()).count() as u64,
            }
        };
        self.design.focus.iter().enumerate().map(of_focus).collect()
    }

    fn regression(&self, place: usize) -> Option<Regression> {
        let defined: Vec<usize> =
            (0..self.metrics[place].len()).filter(|&k| self.metrics[place][k].is_finite()).collect();
        let chosen = |numbers: &[f64]| defined.iter().map(|&k| numbers[k]).collect::<Vec<_>>();
        let y = standard_ranks(&chosen(&self.metrics[place]))?;
        let columns: Vec<Option<Vec<f64>>> = self.axes.iter().map(|axis| standard_ranks(&chosen(axis))).collect();
        let used: Vec<&Vec<f64>> = columns.iter().flatten().collect();
        if used.is_empty() {
            return None;
        }
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>() / a.len() as f64;
        let matrix = DMatrix::from_fn(used.len(), used.len(), |i, j| dot(used[i], used[j]));
        let right = DVector::from_fn(used.len(), |i, _| dot(used[i], &y));
        let solution = solve(matrix, &right)?;
        let r_squared = solution.iter().zip(&right).map(|(b, r)| b * r).sum::<f64>().clamp(0.0, 1.0);
        let mut solution = solution.iter().copied();
        let coefficients = columns.iter().map(|column| column.as_ref().and_then(|_| solution.next())).collect();
        Some(Regression { coefficients, r_squared })
    }
}

struct Regression {
    /// `None` without ranks.
    coefficients: Vec<Option<f64>>,
    r_squared: f64,
}

/// `ε² = (SSB - (k - 1) SSW / (n - k)) / SST`, at least 0 (Kelley 1935): the share of the variance between `k` classes,
/// minus its expectation for random classes.
fn epsilon_squared(overall: &Moments, classes: &[Moments]) -> Option<f64> {
    let filled: Vec<&Moments> = classes.iter().filter(|class| class.count > 0).collect();
    let (n, k) = (overall.count as f64, filled.len() as f64);
    // Rounding gives a constant metric a standard deviation of about 1e-16 of its magnitude.
    let floor = 1e-24 * n * overall.mean * overall.mean;
    if n <= k || overall.squares <= floor {
        return None;
    }
    let within: f64 = filled.iter().map(|class| class.squares).sum();
    Some(((overall.squares - within - (k - 1.0) * within / (n - k)) / overall.squares).clamp(0.0, 1.0))
}

fn means(axis: &Axis, classes: &[Moments]) -> Option<[LevelMean; 2]> {
    let filled = || classes.iter().enumerate().filter(|(_, class)| class.count > 0);
    let by_mean = |a: &(usize, &Moments), b: &(usize, &Moments)| a.1.mean.total_cmp(&b.1.mean);
    let of = |(index, class): (usize, &Moments)| {
        let coordinate = (index as f64 + 0.5) / classes.len() as f64;
        LevelMean { at: axis.value(coordinate), mean: class.mean }
    };
    Some([of(filled().min_by(by_mean)?), of(filled().max_by(by_mean)?)])
}

/// `None` for a matrix that is singular to 1e-9.
fn solve(matrix: DMatrix<f64>, right: &DVector<f64>) -> Option<DVector<f64>> {
    let factors = matrix.lu();
    if factors.u().diagonal().iter().any(|pivot| pivot.abs() < 1e-9) { None } else { factors.solve(right) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sweep::axis::Levels;
    use crate::sweep::columns::Column;
    use trocar_scenario::{Place, find_key};

    fn design() -> Design {
        let place = Place { file: "".into(), text: "".into(), span: 0..0 };
        let axis = |path: &str| Axis {
            key: find_key(path).expect("a key"),
            levels: Levels::Range { from: -1.0, to: 1.0, log: false, points: None },
            place: place.clone(),
        };
        Design {
            name: "x".into(),
            axes: ["operator.start_m", "operator.end_m", "sensor.force_bias_n"].map(axis).into(),
            correlations: vec![],
            scheme: SamplingScheme::Sobol { points: 1 << 14, seed: 1 },
            seeds: 1,
            first_seed: 1,
            question: None,
            listed_seeds: None,
            columns: vec![Column::named("tracking_rmse_m").expect("a metric")],
            focus: vec![0],
            csv: true,
        }
    }

    fn of(y: impl Fn(&[f64]) -> f64) -> Influences {
        let design = design();
        let (sampler, mut coordinates, mut inputs) = (design.coordinates(), vec![], Inputs::new(&design));
        for case in 0..design.cases() {
            sampler.of(case, &mut coordinates);
            let x: Vec<f64> = coordinates.iter().map(|coordinate| 2.0 * coordinate - 1.0).collect();
            inputs.add(case, &coordinates, &[y(&x)]);
        }
        inputs.influences().remove(0)
    }

    #[test]
    fn a_sum_has_the_indices_of_its_closed_form() {
        // Var(a x) = a²/3: indices 9/10 and 1/10; the coefficients are their signed square roots.
        let influences = of(|x| 3.0 * x[0] - x[1]);
        let [first, second, third] = &influences.of_axes[..] else { panic!("three") };
        assert_eq!([&first.axis, &second.axis], ["operator.start_m", "operator.end_m"]);
        for (influence, index, slope) in
            [(first, 0.9, 0.9_f64.sqrt()), (second, 0.1, -(0.1_f64.sqrt())), (third, 0.0, 0.0)]
        {
            assert!((influence.epsilon_squared.expect("varies") - index).abs() < 0.01, "{influence:?}");
            assert!((influence.rank_regression.expect("a line") - slope).abs() < 0.03, "{influence:?}");
        }
        assert!(influences.rank_r_squared.expect("a line") > 0.97);
        // With twenty classes, the outermost ones are centred at ±0.95, where the other axes are 0 on average.
        let [smallest, largest] = first.means.clone().expect("means");
        for (mean, end) in [(smallest, -0.95), (largest, 0.95)] {
            assert!((number(&mean.at).expect("a number") - end).abs() < 1e-12, "{mean:?}");
            assert!((mean.mean - 3.0 * end).abs() < 0.03, "{mean:?}");
        }
    }

    #[test]
    fn the_ishigami_function_has_its_published_indices() {
        // Ishigami and Homma (1990), a = 7, b = 0.1: S_1 = 0.3139, S_2 = 0.4424, S_3 = 0. The regression does not
        // detect x_2.
        let influences = of(|x| {
            let [a, b, c] = [x[0], x[1], x[2]].map(|x| std::f64::consts::PI * x);
            a.sin() + 7.0 * b.sin().powi(2) + 0.1 * c.powi(4) * a.sin()
        });
        let index = |axis: &str| influences.of_axes.iter().find(|influence| influence.axis == axis).expect("there");
        // Twenty classes give an index slightly too small, because the class mean is constant within a class.
        for (axis, expected) in [("operator.start_m", 0.3139), ("operator.end_m", 0.4424), ("sensor.force_bias_n", 0.0)]
        {
            assert!((index(axis).epsilon_squared.expect("varies") - expected).abs() < 0.015, "{:?}", index(axis));
        }
        assert!(index("operator.end_m").rank_regression.expect("a line").abs() < 0.03);
        assert!(influences.rank_r_squared.expect("a line") < 0.25);
    }

    #[test]
    fn a_constant_metric_has_no_influences() {
        let influences = of(|_| 0.1);
        assert!(influences.of_axes.iter().all(|i| i.epsilon_squared.is_none() && i.rank_regression.is_none()));
        assert_eq!(of(|_| f64::NAN).ranked, 0);
    }
}
