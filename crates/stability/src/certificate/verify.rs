//! The verification of a certificate, in interval arithmetic.

use nalgebra::DMatrix;

use super::interval::{
    Enclosure, Interval, exact, is_positive_definite, power, product, rounded, solved, sum, transpose,
};
use super::{Certificate, Inequality, Summand};

impl Certificate {
    /// Verifies every inequality for every power: that the sum of `factor Mᵀ P M` is positive definite. Maps and factors
    /// are taken as rounded numbers. Returns the number of verified conditions.
    ///
    /// # Errors
    /// The first part that does not fit or is not verified.
    pub fn verify(&self) -> Result<u64, String> {
        self.check_form()?;
        let name = |at: usize| &self.inequalities[at].name;
        match unverified(self).first() {
            Some(&(at, power)) => Err(format!("inequality {at} ({}) is not verified for power {power}", name(at))),
            None => Ok(self.inequalities.iter().map(Inequality::conditions).sum()),
        }
    }

    /// Checks sizes and indices, that scales are lower triangular and functions symmetric, and that no number is NaN or
    /// infinite.
    fn check_form(&self) -> Result<(), String> {
        let fits = |space: usize, size: usize| self.spaces.get(space).is_some_and(|space| space.scale.nrows() == size);
        for space in &self.spaces {
            let s = &space.scale;
            let is_lower =
                s.is_square() && (0..s.nrows()).all(|i| s[(i, i)] > 0.0 && s.view((0, i), (i, 1)).amax() == 0.0);
            check(is_lower && is_finite(s), || format!("the scale of {} is not lower triangular", space.name))?;
        }
        for one in &self.functions {
            let is_symmetric = one.matrix.is_square() && one.matrix == one.matrix.transpose() && is_finite(&one.matrix);
            check(is_symmetric && fits(one.space, one.matrix.nrows()), || {
                format!("{} is no form on its space", one.name)
            })?;
        }
        for map in &self.maps {
            let of_spaces = fits(map.to, map.matrix.nrows()) && fits(map.from, map.matrix.ncols());
            check(of_spaces && is_finite(&map.matrix), || format!("{} does not map between its spaces", map.name))?;
        }
        for (at, inequality) in self.inequalities.iter().enumerate() {
            let is_chain = |term: &Summand| {
                let Some(function) = self.functions.get(term.function) else { return false };
                // From the function back to the rows.
                let end = term.maps.iter().try_fold(function.space, |space, &(map, is_power)| {
                    let map = self.maps.get(map).filter(|map| map.to == space)?;
                    (!is_power || map.from == map.to).then_some(map.from)
                });
                let powers = term.maps.iter().filter(|(_, is_power)| *is_power).count();
                end == Some(inequality.rows) && powers <= 1 && term.factor.is_finite()
            };
            let has_range = inequality.powers.is_none_or(|(begin, end)| begin <= end && end - begin <= MAX_POWERS);
            let is_formed = has_range && !inequality.terms.is_empty() && inequality.terms.iter().all(is_chain);
            check(is_formed, || format!("inequality {at} does not fit its maps"))?;
        }
        Ok(())
    }
}

/// Maximum number of powers of an inequality; a freeze has fewer ticks.
const MAX_POWERS: u64 = 10_000_000;

fn check(holds: bool, otherwise: impl FnOnce() -> String) -> Result<(), String> {
    if holds { Ok(()) } else { Err(otherwise()) }
}

fn is_finite(matrix: &DMatrix<f64>) -> bool {
    matrix.iter().all(|value| value.is_finite())
}

/// The inequalities that are not verified, each with its first power.
pub(crate) fn unverified(certificate: &Certificate) -> Vec<(usize, u64)> {
    let scale = |space: usize| &certificate.spaces[space].scale;
    let maps: Vec<Enclosure> = (certificate.maps.iter())
        .map(|map| solved(scale(map.to), product(&rounded(&map.matrix), &exact(scale(map.from)))))
        .collect();
    let failure =
        |(index, inequality): (usize, &Inequality)| Some((index, first_unverified(certificate, &maps, inequality)?));
    certificate.inequalities.iter().enumerate().filter_map(failure).collect()
}

fn first_unverified(certificate: &Certificate, maps: &[Enclosure], inequality: &Inequality) -> Option<u64> {
    let size = certificate.spaces[inequality.rows].scale.nrows();
    let one = power(&vec![vec![Interval::exact(0.0); size]; size], 0);
    let congruence = |term: &Summand, map: &Enclosure| {
        let function = exact(&certificate.functions[term.function].matrix);
        let mut value = product(&transpose(map), &product(&function, map));
        for entry in value.iter_mut().flatten() {
            *entry = *entry * Interval::rounded(term.factor);
        }
        value
    };
    let chain = |factors: &[(usize, bool)], right: &Enclosure| {
        factors.iter().rev().fold(right.clone(), |all, &(map, _)| product(&maps[map], &all))
    };
    let at = |term: &Summand| term.maps.iter().position(|&(_, is_power)| is_power);
    let (powered, fixed): (Vec<_>, Vec<_>) = inequality.terms.iter().partition(|term| at(term).is_some());
    let zero = vec![vec![Interval::exact(0.0); size]; size];
    let fixed = fixed.into_iter().fold(zero, |all, term| sum(&all, &congruence(term, &chain(&term.maps, &one))));
    let (begin, end) = inequality.powers.unwrap_or((0, 0));
    let powers: Vec<(&Summand, usize, Powers)> = (powered.into_iter())
        .filter_map(|term| {
            let at = at(term)?;
            let right = chain(&term.maps[at + 1..], &one);
            Some((term, at, Powers::new(&maps[term.maps[at].0], (begin, end), &right)))
        })
        .collect();
    (begin..=end).find(|&n| {
        let whole = powers.iter().fold(fixed.clone(), |all, (term, at, powers)| {
            sum(&all, &congruence(term, &chain(&term.maps[..*at], &powers.get(n))))
        });
        !is_positive_definite(&whole)
    })
}

/// `M^n R` for all `n` of a range, as products of a few powers, which limits the rounding.
pub(crate) struct Powers {
    begin: u64,
    /// `M^k` for `k` below the stride.
    steps: Vec<Enclosure>,
    /// `M^n R` for every whole number of strides above the first `n`.
    leaps: Vec<Enclosure>,
}

/// Each power is the product of two powers of half its exponent.
pub(crate) fn first_powers(base: &Enclosure, count: usize) -> Vec<Enclosure> {
    let mut all = vec![power(base, 0), base.clone()];
    for n in 2..count {
        all.push(product(&all[n / 2], &all[n - n / 2]));
    }
    all.truncate(count);
    all
}

impl Powers {
    pub(crate) fn new(base: &Enclosure, (begin, end): (u64, u64), right: &Enclosure) -> Self {
        let stride = ((end - begin) as f64).sqrt() as usize + 1;
        let leaps = (end - begin) as usize / stride + 1;
        let to_begin = product(&power(base, begin), right);
        let leaps =
            first_powers(&power(base, stride as u64), leaps).iter().map(|leap| product(leap, &to_begin)).collect();
        Self { begin, steps: first_powers(base, stride), leaps }
    }

    pub(crate) fn get(&self, n: u64) -> Enclosure {
        let (stride, n) = (self.steps.len(), (n - self.begin) as usize);
        product(&self.steps[n % stride], &self.leaps[n / stride])
    }
}
