//! The cases of a sweep; each is computed from its number alone.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use super::axis::Axis;
use super::columns::Column;
use super::correlation::{Correlation, Mixer};
use super::permutation::{Permutation, mix};
use super::sobol::Sobol;
use trocar_scenario::Value;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SamplingScheme {
    /// The last axis varies fastest.
    Grid,
    Random {
        points: u64,
        seed: u64,
    },
    /// Each of `points` equal parts of every axis contains one point.
    LatinHypercube {
        points: u64,
        seed: u64,
    },
    /// The points are shifted digitally by a random number.
    Sobol {
        /// A power of two is the most even.
        points: u64,
        seed: u64,
    },
    /// The k-th values of all axes are a point.
    List {
        points: u64,
    },
}

impl SamplingScheme {
    pub const WORDS: [&'static str; 5] = ["grid", "random", "latin-hypercube", "sobol", "list"];

    /// Ordered like [`SamplingScheme::WORDS`].
    pub fn all(points: u64, seed: u64) -> [Self; 5] {
        let (random, hypercube) = (Self::Random { points, seed }, Self::LatinHypercube { points, seed });
        [Self::Grid, random, hypercube, Self::Sobol { points, seed }, Self::List { points }]
    }

    pub fn word(&self) -> &'static str {
        match self {
            Self::Grid => Self::WORDS[0],
            Self::Random { .. } => Self::WORDS[1],
            Self::LatinHypercube { .. } => Self::WORDS[2],
            Self::Sobol { .. } => Self::WORDS[3],
            Self::List { .. } => Self::WORDS[4],
        }
    }

    pub fn points_and_seed(&self) -> Option<(u64, u64)> {
        match *self {
            Self::Grid | Self::List { .. } => None,
            Self::Random { points, seed } | Self::LatinHypercube { points, seed } | Self::Sobol { points, seed } => {
                Some((points, seed))
            }
        }
    }
}

#[derive(Debug, Clone)]
pub struct Design {
    pub name: String,
    pub question: Option<String>,
    /// Ordered as in the sweep file.
    pub axes: Vec<Axis>,
    pub correlations: Vec<Correlation>,
    pub scheme: SamplingScheme,
    pub seeds: u64,
    pub first_seed: u64,
    /// Seeds that are not consecutive.
    pub listed_seeds: Option<Vec<u64>>,
    pub columns: Vec<Column>,
    /// Indices in `columns`.
    pub focus: Vec<usize>,
    /// True to write CSV in addition to Parquet.
    pub csv: bool,
}

/// A double represents them exactly.
pub const MAX_CASES: u64 = 1 << 50;

impl Design {
    /// `None` for more than [`MAX_CASES`] cases.
    pub fn points(&self) -> Option<u64> {
        let points = match self.scheme {
            SamplingScheme::Grid => {
                self.axes.iter().try_fold(1_u64, |product, axis| product.checked_mul(axis.count().unwrap_or(1)))?
            }
            SamplingScheme::Random { points, .. }
            | SamplingScheme::LatinHypercube { points, .. }
            | SamplingScheme::Sobol { points, .. }
            | SamplingScheme::List { points } => points,
        };
        points.checked_mul(self.seeds).filter(|cases| *cases <= MAX_CASES)?;
        Some(points)
    }

    pub fn cases(&self) -> u64 {
        self.points().unwrap_or(0) * self.seeds
    }

    /// Consecutive cases are one point with different seeds.
    pub fn seed(&self, case: u64) -> u64 {
        let at = case % self.seeds;
        self.listed_seeds.as_ref().map_or(self.first_seed.wrapping_add(at), |seeds| seeds[at as usize])
    }

    pub fn coordinates(&self) -> UnitCoordinates<'_> {
        let (points, seed) = self.scheme.points_and_seed().unwrap_or((1, 0));
        let of_axis = |axis: usize| mix(seed ^ mix(axis as u64));
        UnitCoordinates {
            design: self,
            mixers: self.correlations.iter().map(Mixer::new).collect(),
            points,
            random: ChaCha8Rng::seed_from_u64(seed),
            orders: (0..self.axes.len()).map(|axis| Permutation::new(points, of_axis(axis))).collect(),
            sequences: match self.scheme {
                SamplingScheme::Sobol { .. } => {
                    (0..self.axes.len()).map(|axis| (Sobol::new(axis), of_axis(axis))).collect()
                }
                SamplingScheme::Grid
                | SamplingScheme::Random { .. }
                | SamplingScheme::LatinHypercube { .. }
                | SamplingScheme::List { .. } => vec![],
            },
        }
    }
}

#[derive(Debug, Clone)]
pub struct UnitCoordinates<'a> {
    design: &'a Design,
    mixers: Vec<Mixer>,
    points: u64,
    /// Its stream number is the number of the point.
    random: ChaCha8Rng,
    orders: Vec<Permutation>,
    sequences: Vec<(Sobol, u64)>,
}

impl UnitCoordinates<'_> {
    pub fn of(&self, case: u64, coordinates: &mut Vec<f64>) {
        let point = case / self.design.seeds;
        coordinates.clear();
        match self.design.scheme {
            SamplingScheme::Grid => {
                let mut left = point;
                for axis in self.design.axes.iter().rev() {
                    let count = axis.count().unwrap_or(1);
                    coordinates.push(((left % count) as f64 + 0.5) / count as f64);
                    left /= count;
                }
                coordinates.reverse();
            }
            SamplingScheme::Random { .. } => {
                let mut random = self.stream(point);
                coordinates.extend(self.design.axes.iter().map(|_| random.random::<f64>()));
            }
            SamplingScheme::LatinHypercube { .. } => {
                let mut random = self.stream(point);
                let coordinate = |order: &Permutation| {
                    let within: f64 = random.random();
                    ((order.at(point) as f64 + within) / self.points as f64).min(1.0 - f64::EPSILON)
                };
                coordinates.extend(self.orders.iter().map(coordinate));
            }
            SamplingScheme::List { points } => {
                coordinates.extend(self.design.axes.iter().map(|_| (point as f64 + 0.5) / points as f64));
            }
            SamplingScheme::Sobol { .. } => {
                coordinates.extend(self.sequences.iter().map(|(sequence, shift)| sequence.coordinate(point, *shift)));
            }
        }
        self.mixers.iter().for_each(|mixer| mixer.mix(coordinates));
    }

    pub fn values(&self, case: u64, coordinates: &mut Vec<f64>, values: &mut Vec<Value>) {
        self.of(case, coordinates);
        values.clear();
        values
            .extend(self.design.axes.iter().zip(coordinates.iter()).map(|(axis, coordinate)| axis.value(*coordinate)));
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
    use crate::sweep::axis::Levels;
    use trocar_scenario::{Place, find_key};

    fn design(scheme: SamplingScheme, points: Option<u64>) -> Design {
        let place = Place { file: "".into(), text: "".into(), span: 0..0 };
        let axis = |path: &str| Axis {
            key: find_key(path).expect("a key"),
            levels: Levels::Range { from: 1.0, to: 2.0, log: false, points },
            place: place.clone(),
        };
        Design {
            name: "x".into(),
            correlations: vec![],
            axes: vec![axis("scaling.force"), axis("scaling.position"), axis("channel.jitter_s")],
            scheme,
            seeds: 2,
            first_seed: 10,
            question: None,
            listed_seeds: None,
            columns: vec![],
            focus: vec![],
            csv: true,
        }
    }

    fn all(design: &Design) -> Vec<Vec<f64>> {
        let (sampler, mut coordinates) = (design.coordinates(), vec![]);
        (0..design.cases())
            .map(|case| {
                sampler.of(case, &mut coordinates);
                coordinates.clone()
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
        assert!(cases.iter().any(|case| case[0] != case[1]), "axes are independent");
    }

    #[test]
    fn random_points_depend_on_the_seed_and_their_number_only() {
        let random = |seed| design(SamplingScheme::Random { points: 500, seed }, None);
        let cases = all(&random(1));
        assert_ne!(cases, all(&random(2)));
        let mean = |axis: usize| cases.iter().map(|case| case[axis]).sum::<f64>() / cases.len() as f64;
        // The mean of 500 points is normal with a standard deviation of 0.013.
        assert!((0..3).all(|axis| (mean(axis) - 0.5).abs() < 0.05));
        let (longer, mut coordinates) = (design(SamplingScheme::Random { points: 900, seed: 1 }, None), vec![]);
        longer.coordinates().of(777, &mut coordinates);
        assert_eq!(coordinates, cases[777]);
    }

    #[test]
    fn too_many_cases_give_no_number_of_points() {
        assert_eq!(design(SamplingScheme::Random { points: u64::MAX, seed: 1 }, None).points(), None);
        assert_eq!(design(SamplingScheme::Grid, Some(1 << 30)).points(), None);
    }

    #[test]
    fn every_scheme_has_the_name_at_its_place() {
        assert_eq!(SamplingScheme::all(3, 1).map(|scheme| scheme.word()), SamplingScheme::WORDS);
    }
}
