/// A pseudo-random permutation of `0..length` in constant memory: a balanced Feistel network over the next even number
/// of bits, iterated until the result is below the length (Black and Rogaway, *Ciphers with Arbitrary Finite Domains*,
/// CT-RSA 2002).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Permutation {
    length: u64,
    key: u64,
    half_bits: u32,
}

/// Four rounds suffice, and two more cost little.
const ROUNDS: u64 = 6;

impl Permutation {
    pub fn new(length: u64, key: u64) -> Self {
        let bits = u64::BITS - length.saturating_sub(1).leading_zeros();
        Self { length, key, half_bits: bits.div_ceil(2).max(1) }
    }

    /// `index` must be below the length.
    pub fn at(&self, index: u64) -> u64 {
        let mut at = index;
        loop {
            at = self.step(at);
            if at < self.length || index >= self.length {
                return at;
            }
        }
    }

    fn step(&self, value: u64) -> u64 {
        let mask = (1 << self.half_bits) - 1;
        let (mut left, mut right) = (value >> self.half_bits, value & mask);
        for round in 0..ROUNDS {
            let mixed = mix(self.key ^ mix(right | round << 40));
            (left, right) = (right, (left ^ mixed) & mask);
        }
        left << self.half_bits | right
    }
}

/// SplitMix64's finaliser (Steele, Lea and Flood, OOPSLA 2014).
pub fn mix(value: u64) -> u64 {
    let mut z = value.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_number_occurs_once() {
        for length in [1, 2, 3, 7, 64, 65, 1000, 4097] {
            for key in 0..3 {
                let permutation = Permutation::new(length, key);
                let mut hit = vec![false; length as usize];
                (0..length).for_each(|index| hit[permutation.at(index) as usize] = true);
                assert!(hit.iter().all(|hit| *hit), "{length} {key}");
            }
        }
    }

    #[test]
    fn indices_and_keys_are_uncorrelated() {
        let length = 5000;
        let correlation = |a: &dyn Fn(u64) -> f64, b: &dyn Fn(u64) -> f64| {
            let middle = (length - 1) as f64 / 2.0;
            let sum = |f: &dyn Fn(u64) -> f64| (0..length).map(f).sum::<f64>();
            let variance = sum(&|i| (i as f64 - middle).powi(2));
            sum(&|i| (a(i) - middle) * (b(i) - middle)) / variance
        };
        let (one, other) = (Permutation::new(length, 1), Permutation::new(length, 2));
        // For independent sequences the correlation is normal with a standard deviation of 1/√4999.
        assert!(correlation(&|i| i as f64, &|i| one.at(i) as f64).abs() < 0.06);
        assert!(correlation(&|i| other.at(i) as f64, &|i| one.at(i) as f64).abs() < 0.06);
        assert!(correlation(&|i| one.at((i + 1) % length) as f64, &|i| one.at(i) as f64).abs() < 0.06);
    }
}
