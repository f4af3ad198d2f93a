pub const MAX_DIMENSIONS: usize = TABLE.len() + 1;

/// A double in [0, 1) represents one more bit exactly.
const BITS: u32 = 52;

/// Inner coefficients of the primitive polynomial and first direction numbers, from the second coordinate on: S. Joe
/// and F. Y. Kuo, SIAM J. Sci. Comput. 30, 2635-2654 (2008), table new-joe-kuo-6.21201.
const TABLE: [(u64, &[u64]); 20] = [
    (0, &[1]),
    (1, &[1, 3]),
    (1, &[1, 3, 1]),
    (2, &[1, 1, 1]),
    (1, &[1, 1, 3, 3]),
    (4, &[1, 3, 5, 13]),
    (2, &[1, 1, 5, 5, 17]),
    (4, &[1, 1, 5, 5, 5]),
    (7, &[1, 1, 7, 11, 19]),
    (11, &[1, 1, 5, 1, 1]),
    (13, &[1, 1, 1, 3, 11]),
    (14, &[1, 3, 5, 5, 31]),
    (1, &[1, 3, 3, 9, 7, 49]),
    (13, &[1, 1, 1, 15, 21, 21]),
    (16, &[1, 3, 1, 13, 27, 49]),
    (19, &[1, 1, 1, 15, 7, 5]),
    (22, &[1, 3, 1, 15, 13, 25]),
    (25, &[1, 1, 5, 5, 19, 61]),
    (1, &[1, 3, 7, 11, 23, 15, 103]),
    (4, &[1, 3, 7, 13, 13, 15, 69]),
];

#[derive(Debug, Clone, PartialEq)]
pub struct Sobol {
    /// Index 0 is the lowest bit of the index; the leading bit of a coordinate is bit 51.
    directions: [u64; BITS as usize],
}

impl Sobol {
    /// `m_k = 2 a_1 m_{k-1} ⊕ … ⊕ 2^{s-1} a_{s-1} m_{k-s+1} ⊕ 2^s m_{k-s} ⊕ m_{k-s}`, and `v_k = m_k / 2^k`. Dimensions
    /// from [`MAX_DIMENSIONS`] on repeat the last one.
    pub fn new(dimension: usize) -> Self {
        let mut directions = [0; BITS as usize];
        let mut m = [1_u64; BITS as usize];
        if let Some(index) = dimension.checked_sub(1) {
            let (a, first) = TABLE[index.min(TABLE.len() - 1)];
            let s = first.len();
            m[..s].copy_from_slice(first);
            for k in s..m.len() {
                let inner = (1..s).filter(|j| (a >> (s - 1 - j)) & 1 == 1).fold(0, |sum, j| sum ^ (m[k - j] << j));
                m[k] = inner ^ (m[k - s] << s) ^ m[k - s];
            }
        }
        for (k, (direction, m)) in directions.iter_mut().zip(m).enumerate() {
            *direction = m << (BITS as usize - 1 - k);
        }
        Self { directions }
    }

    /// In [0, 1), in the order of the Gray code (Antonov and Saleev, 1979). The 52 lowest bits of `shift` invert bits,
    /// which moves the first point off the corner.
    pub fn coordinate(&self, index: u64, shift: u64) -> f64 {
        let mut left = index ^ (index >> 1);
        let mut sum = shift & ((1 << BITS) - 1);
        while left != 0 {
            let bit = left.trailing_zeros();
            sum ^= self.directions.get(bit as usize).copied().unwrap_or(0);
            left &= left - 1;
        }
        sum as f64 / (1_u64 << BITS) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn oracle_points_agree_with_another_implementation() {
        // scipy 1.17.1: qmc.Sobol(21, scramble=False, bits=52).random(64)[37].
        let expected = [
            0.921875, 0.640625, 0.578125, 0.921875, 0.765625, 0.296875, 0.171875, 0.796875, 0.609375, 0.171875,
            0.015625, 0.078125, 0.578125, 0.859375, 0.109375, 0.484375, 0.796875, 0.421875, 0.046875, 0.140625,
            0.953125,
        ];
        assert_eq!(expected.len(), MAX_DIMENSIONS);
        for (dimension, expected) in expected.into_iter().enumerate() {
            assert_eq!(Sobol::new(dimension).coordinate(37, 0), expected, "{dimension}");
        }
    }

    #[test]
    fn every_dyadic_interval_contains_its_share_with_and_without_a_shift() {
        for dimension in 0..MAX_DIMENSIONS {
            for shift in [0, 0x9_e377_9b97_f4a7] {
                let sequence = Sobol::new(dimension);
                let mut counts = [0; 256];
                for index in 0..1024 {
                    counts[(256.0 * sequence.coordinate(index, shift)) as usize] += 1;
                }
                assert_eq!(counts, [4; 256], "{dimension}");
            }
        }
    }
}
