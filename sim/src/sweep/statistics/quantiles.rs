//! Exact order statistics of a stream that is read several times, in memory that does not grow with it.
//!
//! Doubles are mapped to whole numbers of the same order. Each pass counts the next eleven binary digits of those that begin
//! as a wanted one does, and so knows its next eleven: six passes know all 64.

use crate::quantiles::median_ranks;

const DIGITS: u32 = 11;
const BUCKETS: usize = 1 << DIGITS;

/// The values of wanted ranks.
#[derive(Debug, Clone)]
pub(super) struct OrderStatistics {
    wanted: Vec<Wanted>,
    /// Distinct beginnings of the wanted values, ascending, with the counts of what follows each.
    beginnings: Vec<(u64, Vec<u64>)>,
    /// How many of the leading digits are known.
    known: u32,
}

#[derive(Debug, Clone, Copy)]
struct Wanted {
    rank: u64,
    /// Its rank among the values that begin as it does.
    within: u64,
    beginning: u64,
}

/// The ranks, from 0, between which quantiles and the median's interval lie.
pub(super) fn ranks(count: u64, shares: &[f64]) -> Vec<u64> {
    let Some(last) = count.checked_sub(1) else { return vec![] };
    let (low, high) = median_ranks(count);
    let mut ranks = vec![0, low, high, last];
    for share in shares {
        let below = (share * last as f64) as u64;
        ranks.extend([below, (below + 1).min(last)]);
    }
    ranks.sort_unstable();
    ranks.dedup();
    ranks
}

/// Doubles in the order of whole numbers: both zeros are one.
fn ordered(value: f64) -> u64 {
    let bits = (value + 0.0).to_bits();
    if bits >> 63 == 1 { !bits } else { bits | 1 << 63 }
}

fn disordered(bits: u64) -> f64 {
    f64::from_bits(if bits >> 63 == 1 { bits & !(1 << 63) } else { !bits })
}

impl OrderStatistics {
    /// Wants the values of ascending ranks, from 0.
    pub(super) fn new(ranks: Vec<u64>) -> Self {
        let wanted: Vec<Wanted> = ranks.into_iter().map(|rank| Wanted { rank, within: rank, beginning: 0 }).collect();
        let known = if wanted.is_empty() { 64 } else { 0 };
        Self { wanted, beginnings: vec![(0, vec![0; BUCKETS])], known }
    }

    /// Whether no further pass is needed.
    pub(super) fn are_known(&self) -> bool {
        self.known >= 64
    }

    /// Takes a value of the present pass; NaN is passed over.
    pub(super) fn count(&mut self, value: f64) {
        if value.is_nan() || self.are_known() {
            return;
        }
        let bits = ordered(value);
        let beginning = if self.known == 0 { 0 } else { bits >> (64 - self.known) };
        if let Ok(place) = self.beginnings.binary_search_by_key(&beginning, |(known, _)| *known) {
            let digits = self.digits(bits);
            self.beginnings[place].1[digits] += 1;
        }
    }

    /// The next digits of a number, as many as are left.
    fn digits(&self, bits: u64) -> usize {
        let next = (64 - self.known).min(DIGITS);
        (bits << self.known >> (64 - next)) as usize
    }

    /// Ends a pass.
    pub(super) fn narrow(&mut self) {
        if self.are_known() {
            return;
        }
        let next = (64 - self.known).min(DIGITS);
        for wanted in &mut self.wanted {
            let Ok(place) = self.beginnings.binary_search_by_key(&wanted.beginning, |(known, _)| *known) else {
                continue;
            };
            let mut digits = 0;
            for (bucket, count) in self.beginnings[place].1.iter().enumerate() {
                if wanted.within < *count {
                    digits = bucket as u64;
                    break;
                }
                wanted.within -= count;
            }
            wanted.beginning = wanted.beginning << next | digits;
        }
        self.known += next;
        // Ranks ascend, so that values and their beginnings do.
        let mut beginnings: Vec<u64> = self.wanted.iter().map(|wanted| wanted.beginning).collect();
        beginnings.dedup();
        self.beginnings = if self.are_known() {
            vec![]
        } else {
            beginnings.into_iter().map(|beginning| (beginning, vec![0; BUCKETS])).collect()
        };
    }

    /// The value of a rank that was wanted; NaN of any other.
    pub(super) fn of_rank(&self, rank: u64) -> f64 {
        let place = self.wanted.binary_search_by_key(&rank, |wanted| wanted.rank);
        place.map_or(f64::NAN, |place| disordered(self.wanted[place].beginning))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_rank_is_that_of_a_sort() {
        let mut state = 1_u64;
        let mut next = || {
            state = crate::sweep::permutation::mix(state);
            f64::from_bits(state)
        };
        let mut values: Vec<f64> = std::iter::from_fn(|| Some(next())).filter(|v| !v.is_nan()).take(500).collect();
        values.extend([0.0, -0.0, 1.0, 1.0, 1.0, f64::INFINITY, f64::NEG_INFINITY, 5e-324, -5e-324]);
        let mut statistics = OrderStatistics::new((0..values.len() as u64).collect());
        let mut passes = 0;
        while !statistics.are_known() {
            values.iter().chain([&f64::NAN]).for_each(|value| statistics.count(*value));
            statistics.narrow();
            passes += 1;
        }
        values.sort_by(f64::total_cmp);
        assert_eq!(passes, 6);
        for (rank, value) in values.iter().enumerate() {
            assert_eq!(statistics.of_rank(rank as u64), *value, "{rank}");
        }
    }

    #[test]
    fn the_medians_ranks_are_those_of_the_comparison_over_seeds() {
        for count in [1, 2, 5, 6, 50, 201, 1000] {
            let values: Vec<f64> = (0..count).map(|k| k as f64).collect();
            let spread = crate::compare::Spread::of(values).expect("values");
            let (low, high) = median_ranks(count);
            assert_eq!((low as f64, high as f64), (spread.median_low, spread.median_high), "{count}");
        }
    }
}
