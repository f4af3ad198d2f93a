use super::{BINS, SHORT, before};
use crate::lane::Lane;

/// Over two, four and eight bins and over the reference.
#[derive(Debug, Clone)]
pub(super) struct Extremes<L> {
    pub(super) twos: [L; BINS],
    fours: [L; SHORT],
    eights: [L; SHORT],
    pub(super) whole: [L; BINS],
}

impl<L: Lane> Extremes<L> {
    pub(super) fn new(value: L) -> Self {
        Self { twos: [value; BINS], fours: [value; SHORT], eights: [value; SHORT], whole: [value; BINS] }
    }

    #[inline(always)]
    pub(super) fn update(&mut self, values: &[L; BINS], newest: usize, reference: usize, more: impl Fn(L, L) -> L) {
        let one = values[newest];
        let two = more(one, values[before(newest, 1)]);
        self.twos[newest] = two;
        let four = more(two, self.twos[before(newest, 2)]);
        self.fours[newest % SHORT] = four;
        let eight = more(four, self.fours[before(newest, 4) % SHORT]);
        self.eights[newest % SHORT] = eight;
        // The reference is at most 15 bins.
        self.whole[newest] = match reference {
            8.. => more(eight, self.eights[before(newest, reference - 8) % SHORT]),
            4.. => more(four, self.fours[before(newest, reference - 4) % SHORT]),
            2.. => more(two, self.twos[before(newest, reference - 2)]),
            ..2 => one,
        };
    }

    #[inline(always)]
    pub(super) fn forget(&mut self, mask: L::Mask, value: L) {
        let Self { twos, fours, eights, whole } = self;
        for old in twos.iter_mut().chain(fours).chain(eights).chain(whole) {
            *old = L::select(mask, value, *old);
        }
    }
}

crate::lane::gather!(Extremes { twos, fours, eights, whole } stored);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extremes_cover_the_last_bins() {
        let mut noise = crate::detector::fixtures::Noise(3);
        for reference in 1..=15 {
            let mut values = [0.0; BINS];
            let (mut low, mut high) = (Extremes::<f64>::new(0.0), Extremes::<f64>::new(0.0));
            let mut all: Vec<f64> = vec![0.0; BINS];
            for bin in 1..200 {
                let (newest, value) = (bin % BINS, noise.next());
                (values[newest], all) = (value, {
                    all.push(value);
                    all
                });
                low.update(&values, newest, reference, Lane::min);
                high.update(&values, newest, reference, Lane::max);
                let last = |count: usize| all[all.len() - count..].iter().copied();
                assert_eq!(low.whole[newest], last(reference).fold(f64::INFINITY, f64::min), "{reference} {bin}");
                assert_eq!(high.whole[newest], last(reference).fold(f64::NEG_INFINITY, f64::max), "{reference} {bin}");
                assert_eq!(low.twos[newest], last(2).fold(f64::INFINITY, f64::min), "{bin}");
            }
        }
    }

    #[test]
    fn after_forgetting_every_earlier_value_equals_the_given_one() {
        let mut extremes = Extremes::<f64>::new(3.0);
        extremes.forget(false, 1.0);
        assert!(extremes.whole.iter().chain(&extremes.twos).all(|&value| value == 3.0));
        extremes.forget(true, 1.0);
        assert!(extremes.whole.iter().chain(&extremes.twos).all(|&value| value == 1.0));
        assert!(extremes.fours.iter().chain(&extremes.eights).all(|&value| value == 1.0));
    }
}
