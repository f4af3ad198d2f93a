//! Which cases there are, each computed from its number alone.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use super::axis::Axis;
use super::columns::Column;
use super::permutation::{Permutation, mix};
use super::sobol::Sobol;
use crate::scenario::Value;

/// How the axes are filled.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SamplingScheme {
    /// Every combination of their levels, the last axis fastest.
    Grid,
    /// Points of independent random shares.
    Random {
        /// How many.
        points: u64,
        /// Of their random numbers.
        seed: u64,
    },
    /// A Latin hypercube: each of `points` equal parts of every axis is hit once, at a random place within.
    LatinHypercube {
        /// How many.
        points: u64,
        /// Of their random numbers.
        seed: u64,
    },
    /// The first points of Sobol's sequence, digits shifted at random.
    Sobol {
        /// How many; a power of two is the most even.
        points: u64,
        /// Of the shift.
        seed: u64,
    },
}

impl SamplingScheme {
    /// The words that sweep files use.
    pub const WORDS: [&'static str; 4] = ["grid", "random", "latin-hypercube", "sobol"];

    /// Its word.
    #[must_use]
    pub fn word(&self) -> &'static str {
        match self {
            Self::Grid => Self::WORDS[0],
            Self::Random { .. } => Self::WORDS[1],
            Self::LatinHypercube { .. } => Self::WORDS[2],
            Self::Sobol { .. } => Self::WORDS[3],
        }
    }

    /// Its points and the seed, but for a grid.
    #[must_use]
    pub fn points_and_seed(&self) -> Option<(u64, u64)> {
        match *self {
            Self::Grid => None,
            Self::Random { points, seed } | Self::LatinHypercube { points, seed } | Self::Sobol { points, seed } => {
                Some((points, seed))
            }
        }
    }
}

/// What a sweep is, apart from the scenario that it varies.
#[derive(Debug, Clone)]
pub struct Design {
    /// Names its folder.
    pub name: String,
    /// The keys that vary, in the order in which they are written.
    pub axes: Vec<Axis>,
    /// How they do.
    pub filling: SamplingScheme,
    /// How many seeds of noise each point has.
    pub seeds: u64,
    /// The first of them.
    pub first_seed: u64,
    /// What is kept of each case.
    pub columns: Vec<Column>,
    /// Which of them have figures and are asked what they depend on, as places in `columns`.
    pub focus: Vec<usize>,
    /// Whether the rows are written as CSV besides Parquet.
    pub csv: bool,
}

/// Most cases of a sweep: doubles count them exactly.
pub const MAX_CASES: u64 = 1 << 50;

impl Design {
    /// How many points there are, each with [`Design::seeds`] cases; none beyond [`MAX_CASES`] cases.
    #[must_use]
    pub fn points(&self) -> Option<u64> {
        let points = match self.filling.points_and_seed() {
            Some((points, _)) => points,
            None => self.axes.iter().try_fold(1_u64, |product, axis| product.checked_mul(axis.count().unwrap_or(1)))?,
        };
        points.checked_mul(self.seeds).filter(|cases| *cases <= MAX_CASES)?;
        Some(points)
    }

    /// How many cases there are.
    #[must_use]
    pub fn cases(&self) -> u64 {
        self.points().unwrap_or(0) * self.seeds
    }

    /// The seed of a case: neighbouring cases are one point with different seeds.
    #[must_use]
    pub fn seed(&self, case: u64) -> u64 {
        self.first_seed.wrapping_add(case % self.seeds)
    }

    /// What computes the shares of each axis.
    #[must_use]
    pub fn shares(&self) -> UnitCoordinates<'_> {
        let (points, seed) = self.filling.points_and_seed().unwrap_or((1, 0));
        let of_axis = |axis: usize| mix(seed ^ mix(axis as u64));
        UnitCoordinates {
            design: self,
            points,
            random: ChaCha8Rng::seed_from_u64(seed),
            orders: (0..self.axes.len()).map(|axis| Permutation::new(points, of_axis(axis))).collect(),
            sequences: match self.filling {
                SamplingScheme::Sobol { .. } => {
                    (0..self.axes.len()).map(|axis| (Sobol::new(axis), of_axis(axis))).collect()
                }
                SamplingScheme::Grid | SamplingScheme::Random { .. } | SamplingScheme::LatinHypercube { .. } => vec![],
            },
        }
    }
}

/// Computes where on its axes a case lies.
#[derive(Debug, Clone)]
pub struct UnitCoordinates<'a> {
    design: &'a Design,
    points: u64,
    /// Its stream is the point.
    random: ChaCha8Rng,
    orders: Vec<Permutation>,
    sequences: Vec<(Sobol, u64)>,
}

impl UnitCoordinates<'_> {
    /// The share of each axis, 0 to below 1, in the order of the axes.
    pub fn of(&self, case: u64, shares: &mut Vec<f64>) {
        let point = case / self.design.seeds;
        shares.clear();
        match self.design.filling {
            SamplingScheme::Grid => {
                let mut left = point;
                for axis in self.design.axes.iter().rev() {
                    let count = axis.count().unwrap_or(1);
                    shares.push(((left % count) as f64 + 0.5) / count as f64);
                    left /= count;
                }
                shares.reverse();
            }
            SamplingScheme::Random { .. } => {
                let mut random = self.stream(point);
                shares.extend(self.design.axes.iter().map(|_| random.random::<f64>()));
            }
            SamplingScheme::LatinHypercube { .. } => {
                let mut random = self.stream(point);
                let share = |order: &Permutation| {
                    let within: f64 = random.random();
                    ((order.at(point) as f64 + within) / self.points as f64).min(1.0 - f64::EPSILON)
                };
                shares.extend(self.orders.iter().map(share));
            }
            SamplingScheme::Sobol { .. } => {
                shares.extend(self.sequences.iter().map(|(sequence, shift)| sequence.coordinate(point, *shift)));
            }
        }
    }

    /// The value of each axis.
    pub fn values(&self, case: u64, shares: &mut Vec<f64>, values: &mut Vec<Value>) {
        self.of(case, shares);
        values.clear();
        values.extend(self.design.axes.iter().zip(shares.iter()).map(|(axis, share)| axis.value(*share)));
    }

    fn stream(&self, point: u64) -> ChaCha8Rng {
        let mut random = self.random.clone();
        random.set_stream(point);
        random
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::{Place, find_key};
    use crate::sweep::axis::Levels;

    fn design(filling: SamplingScheme, points: Option<u64>) -> Design {
        let place = Place { file: "".into(), text: "".into(), span: 0..0 };
        let axis = |path: &str| Axis {
            key: find_key(path).expect("a key"),
            levels: Levels::Range { from: 1.0, to: 2.0, log: false, points },
            place: place.clone(),
        };
        Design {
            name: "x".into(),
            axes: vec![axis("scaling.force"), axis("scaling.position"), axis("channel.jitter_s")],
            filling,
            seeds: 2,
            first_seed: 10,
            columns: vec![],
            focus: vec![],
            csv: true,
        }
    }

    fn all(design: &Design) -> Vec<Vec<f64>> {
        let (sampler, mut shares) = (design.shares(), vec![]);
        (0..design.cases())
            .map(|case| {
                sampler.of(case, &mut shares);
                shares.clone()
            })
            .collect()
    }

    #[test]
    fn a_grid_has_every_combination_the_last_axis_and_the_seeds_fastest() {
        let grid = design(SamplingScheme::Grid, Some(3));
        assert_eq!(grid.cases(), 54);
        let cases = all(&grid);
        assert_eq!(cases[1], cases[0]);
        assert_eq!((grid.seed(0), grid.seed(1), grid.seed(2)), (10, 11, 10));
        assert_eq!(cases[2], [0.5 / 3.0, 0.5 / 3.0, 0.5]);
        let mut distinct: Vec<_> = cases.iter().map(|case| format!("{case:?}")).collect();
        distinct.sort();
        distinct.dedup();
        assert_eq!(distinct.len(), 27);
    }

    #[test]
    fn a_latin_hypercube_hits_each_part_of_each_axis_once() {
        let latin = design(SamplingScheme::LatinHypercube { points: 37, seed: 1 }, None);
        let cases = all(&latin);
        for axis in 0..3 {
            let mut parts: Vec<_> = cases.iter().step_by(2).map(|case| (37.0 * case[axis]) as u64).collect();
            parts.sort_unstable();
            assert_eq!(parts, (0..37).collect::<Vec<_>>());
        }
        assert!(cases.iter().any(|case| case[0] != case[1]), "axes go together");
    }

    #[test]
    fn what_is_random_depends_on_the_seed_and_a_point_on_nothing_else() {
        let random = |seed| design(SamplingScheme::Random { points: 500, seed }, None);
        let cases = all(&random(1));
        assert_ne!(cases, all(&random(2)));
        let mean = |axis: usize| cases.iter().map(|case| case[axis]).sum::<f64>() / cases.len() as f64;
        // The mean of 500 is normal with a standard deviation of 0.013.
        assert!((0..3).all(|axis| (mean(axis) - 0.5).abs() < 0.05));
        let (longer, mut shares) = (design(SamplingScheme::Random { points: 900, seed: 1 }, None), vec![]);
        longer.shares().of(777, &mut shares);
        assert_eq!(shares, cases[777]);
    }

    #[test]
    fn too_many_cases_are_none() {
        assert_eq!(design(SamplingScheme::Random { points: u64::MAX, seed: 1 }, None).points(), None);
        assert_eq!(design(SamplingScheme::Grid, Some(1 << 30)).points(), None);
    }
}
