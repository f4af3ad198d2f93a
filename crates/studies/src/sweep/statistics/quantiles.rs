//! Exact order statistics of a stream that is read several times, in constant memory.
//!
//! Each of six passes counts the next eleven bits of the values that share the known leading bits of a wanted value.
//! Doubles are mapped to integers in the same order.

use trocar_base::quantiles::median_ranks;

const DIGITS: u32 = 11;
const BUCKETS: usize = 1 << DIGITS;

#[derive(Debug, Clone)]
pub(super) struct OrderStatistics {
    wanted: Vec<Wanted>,
    /// Prefixes ascend; each has the counts of the next bits.
    prefixes: Vec<(u64, Vec<u64>)>,
    known: u32,
}

#[derive(Debug, Clone, Copy)]
struct Wanted {
    rank: u64,
    /// Rank within the prefix.
    within: u64,
    prefix: u64,
}

/// Ranks from 0 for the quantiles and the median's interval.
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

/// Keeps the order; both zeros are equal.
fn ordered(value: f64) -> u64 {
    let bits = (value + 0.0).to_bits();
    if bits >> 63 == 1 { !bits } else { bits | 1 << 63 }
}

fn disordered(bits: u64) -> f64 {
    f64::from_bits(if bits >> 63 == 1 { bits & !(1 << 63) } else { !bits })
}

impl OrderStatistics {
    pub(super) fn new(ranks: Vec<u64>) -> Self {
        let wanted: Vec<Wanted> = ranks.into_iter().map(|rank| Wanted { rank, within: rank, prefix: 0 }).collect();
        let known = if wanted.is_empty() { 64 } else { 0 };
        Self { wanted, prefixes: vec![(0, vec![0; BUCKETS])], known }
    }

    pub(super) fn are_known(&self) -> bool {
        self.known >= 64
    }

    /// Ignores NaN and infinity.
    pub(super) fn count(&mut self, value: f64) {
        if !value.is_finite() || self.are_known() {
            return;
        }
        let bits = ordered(value);
        let prefix = if self.known == 0 { 0 } else { bits >> (64 - self.known) };
        if let Ok(place) = self.prefixes.binary_search_by_key(&prefix, |(known, _)| *known) {
            let digits = self.digits(bits);
            self.prefixes[place].1[digits] += 1;
        }
    }

    fn digits(&self, bits: u64) -> usize {
        let next = (64 - self.known).min(DIGITS);
        (bits << self.known >> (64 - next)) as usize
    }

    pub(super) fn narrow(&mut self) {
        if self.are_known() {
            return;
        }
        let next = (64 - self.known).min(DIGITS);
        for wanted in &mut self.wanted {
            let Ok(place) = self.prefixes.binary_search_by_key(&wanted.prefix, |(known, _)| *known) else {
                continue;
            };
            let mut digits = 0;
            for (bucket, count) in self.prefixes[place].1.iter().enumerate() {
                if wanted.within < *count {
                    digits = bucket as u64;
                    break;
                }
                wanted.within -= count;
            }
            wanted.prefix = wanted.prefix << next | digits;
        }
        self.known += next;
        // Ranks ascend, and therefore values and prefixes too.
        let mut prefixes: Vec<u64> = self.wanted.iter().map(|wanted| wanted.prefix).collect();
        prefixes.dedup();
        self.prefixes = if self.are_known() {
            vec![]
        } else {
            prefixes.into_iter().map(|prefix| (prefix, vec![0; BUCKETS])).collect()
        };
    }

    pub(super) fn of_rank(&self, rank: u64) -> f64 {
        let place = self.wanted.binary_search_by_key(&rank, |wanted| wanted.rank);
        place.map_or(f64::NAN, |place| disordered(self.wanted[place].prefix))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_agrees_with_a_sort() {
        let mut state = 1_u64;
        let mut next = || {
            state = crate::sweep::permutation::mix(state);
            f64::from_bits(state)
        };
        let mut values: Vec<f64> = std::iter::from_fn(|| Some(next())).filter(|v| v.is_finite()).take(500).collect();
        values.extend([0.0, -0.0, 1.0, 1.0, 1.0, f64::MAX, f64::MIN, 5e-324, -5e-324]);
        let mut statistics = OrderStatistics::new((0..values.len() as u64).collect());
        let mut passes = 0;
        while !statistics.are_known() {
            values.iter().chain(&[f64::NAN, f64::INFINITY]).for_each(|value| statistics.count(*value));
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
    fn the_ranks_of_the_median_agree_with_the_comparison_over_seeds() {
        for count in [1, 2, 5, 6, 50, 201, 1000] {
            let values: Vec<f64> = (0..count).map(|k| k as f64).collect();
            let spread = crate::compare::Spread::of(values).expect("values");
            let (low, high) = median_ranks(count);
            assert_eq!((low as f64, high as f64), (spread.median_low, spread.median_high), "{count}");
        }
    }
}
