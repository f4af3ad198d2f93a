use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::Standing;

/// Deb et al. 2002, section V.
const CROSSOVER_INDEX: f64 = 20.0;
const MUTATION_INDEX: f64 = 20.0;
const CROSSOVER: f64 = 0.9;

/// A coordinate is from 0 to below 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Gene {
    Number,
    Choice(u64),
}

impl Gene {
    /// 0 for a number.
    pub fn choice(self, coordinate: f64) -> u64 {
        match self {
            Self::Number => 0,
            Self::Choice(count) => ((coordinate * count as f64) as u64).min(count.saturating_sub(1)),
        }
    }
}

const LAST: f64 = 1.0 - f64::EPSILON;

/// Each parent is the preferred one of two random points. On average one gene mutates.
pub fn child(genes: &[Gene], parents: &[&[f64]], standings: &[Standing], random: &mut ChaCha8Rng) -> Vec<f64> {
    let mut select = || {
        let (a, b) = (random.random_range(0..parents.len()), random.random_range(0..parents.len()));
        if standings[b].is_preferred_to(&standings[a]) { b } else { a }
    };
    let (first, second) = (parents[select()], parents[select()]);
    let crosses = random.random::<f64>() < CROSSOVER;
    let mutation = 1.0 / genes.len().max(1) as f64;
    let mut of_gene = |gene: Gene, a: f64, b: f64| {
        let crossed = match gene {
            _ if !crosses || random.random::<bool>() => a,
            Gene::Number => crossed(a, b, random),
            Gene::Choice(_) => b,
        };
        if random.random::<f64>() >= mutation {
            return crossed;
        }
        match gene {
            Gene::Number => mutated(crossed, random.random()),
            Gene::Choice(count) if count > 1 => {
                let other = (gene.choice(crossed) + random.random_range(1..count)) % count;
                (other as f64 + 0.5) / count as f64
            }
            Gene::Choice(_) => crossed,
        }
    };
    genes.iter().zip(first.iter().zip(second)).map(|(gene, (a, b))| of_gene(*gene, *a, *b).clamp(0.0, LAST)).collect()
}

/// Bounded simulated binary crossover (Deb and Agrawal, *Complex Systems* 9, 1995).
fn crossed(a: f64, b: f64, random: &mut ChaCha8Rng) -> f64 {
    let (low, high) = (a.min(b), a.max(b));
    let (u, takes_upper): (f64, bool) = (random.random(), random.random());
    if high - low < 1e-14 {
        return a;
    }
    let exponent = CROSSOVER_INDEX + 1.0;
    let spread = |to_bound: f64| {
        let beta = 1.0 + 2.0 * to_bound / (high - low);
        let alpha = 2.0 - libm::pow(beta, -exponent);
        let base = if u <= 1.0 / alpha { u * alpha } else { 1.0 / (2.0 - u * alpha) };
        libm::pow(base, 1.0 / exponent)
    };
    let middle = 0.5 * (low + high);
    if takes_upper {
        middle + 0.5 * spread(1.0 - high) * (high - low)
    } else {
        middle - 0.5 * spread(low) * (high - low)
    }
}

/// Bounded polynomial mutation (Deb 2001, *Multi-objective optimization using evolutionary algorithms*).
fn mutated(value: f64, u: f64) -> f64 {
    let exponent = MUTATION_INDEX + 1.0;
    let change = if u < 0.5 {
        libm::pow(2.0 * u + (1.0 - 2.0 * u) * libm::pow(1.0 - value, exponent), 1.0 / exponent) - 1.0
    } else {
        1.0 - libm::pow(2.0 * (1.0 - u) + 2.0 * (u - 0.5) * libm::pow(value, exponent), 1.0 / exponent)
    };
    value + change
}
