use nalgebra::DMatrix;

use super::interval::{
    Enclosure, Interval, exact, is_positive_definite, power, product, rounded, solved, sum, transpose,
};
use super::{Certificate, Inequality, Lyapunov, MapFactor, Summand};
use crate::SwitchingSettings;
use crate::switching::required;

impl Certificate {
    /// Takes only claims, functions and scales from the certificate. Returns the number of conditions.
    pub fn verify(&self, settings: &SwitchingSettings) -> Result<u64, String> {
        let required = required(self, settings)?;
        self.check_parts(&required)?;
        required.check_functions()?;
        match unverified(&required).next() {
            Some((at, power)) => {
                Err(format!("inequality {at} ({}) is not verified for power {power}", required.inequalities[at].name))
            }
            None => Ok(required.conditions()),
        }
    }

    fn check_functions(&self) -> Result<(), String> {
        let is_finite = |matrix: &DMatrix<f64>| matrix.iter().all(|value| value.is_finite());
        for (name, space) in &self.spaces {
            let (s, size) = (&space.scale, space.states.len());
            let is_lower =
                s.shape() == (size, size) && (0..size).all(|i| s[(i, i)] > 0.0 && s.view((0, i), (i, 1)).amax() == 0.0);
            if !(is_lower && is_finite(s)) {
                return Err(format!("the scale of {name} is not a lower triangular matrix of {size} states"));
            }
        }
        for Lyapunov { name, space, p } in &self.functions {
            let size = self.spaces[space].states.len();
            if !(p.shape() == (size, size) && *p == p.transpose() && is_finite(p)) {
                return Err(format!("function {name} is not a symmetric matrix of {size} states"));
            }
        }
        Ok(())
    }
}

pub(crate) fn unverified(certificate: &Certificate) -> impl Iterator<Item = (usize, u64)> {
    let scale = |space: &String| &certificate.spaces[space].scale;
    let maps: Vec<Enclosure> = (certificate.maps.iter())
        .map(|map| solved(scale(&map.to), product(&rounded(&map.matrix), &exact(scale(&map.from)))))
        .collect();
    let failure = move |(index, inequality): (usize, &Inequality)| {
        Some((index, first_unverified(certificate, &maps, inequality)?))
    };
    certificate.inequalities.iter().enumerate().filter_map(failure)
}

fn first_unverified(certificate: &Certificate, maps: &[Enclosure], inequality: &Inequality) -> Option<u64> {
    let size = certificate.spaces[&inequality.rows].scale.nrows();
    let one = power(&vec![vec![Interval::exact(0.0); size]; size], 0);
    let congruence = |term: &Summand, map: &Enclosure| {
        let function = exact(&certificate.functions[term.function].p);
        let mut value = product(&transpose(map), &product(&function, map));
        for entry in value.iter_mut().flatten() {
            *entry = *entry * Interval::rounded(term.factor);
        }
        value
    };
    let chain = |factors: &[MapFactor], right: &Enclosure| {
        factors.iter().rev().fold(right.clone(), |all, factor| product(&maps[factor.map], &all))
    };
    let at = |term: &Summand| term.maps.iter().position(|factor| factor.is_power);
    let (powered, fixed): (Vec<_>, Vec<_>) = inequality.terms.iter().partition(|term| at(term).is_some());
    let zero = vec![vec![Interval::exact(0.0); size]; size];
    let fixed = fixed.into_iter().fold(zero, |all, term| sum(&all, &congruence(term, &chain(&term.maps, &one))));
    let (begin, end) = inequality.powers.unwrap_or((0, 0));
    let powers: Vec<(&Summand, usize, Powers)> = (powered.into_iter())
        .filter_map(|term| {
            let at = at(term)?;
            let right = chain(&term.maps[at + 1..], &one);
            Some((term, at, Powers::new(&maps[term.maps[at].map], (begin, end), &right)))
        })
        .collect();
    (begin..=end).find(|&n| {
        let whole = powers.iter().fold(fixed.clone(), |all, (term, at, powers)| {
            sum(&all, &congruence(term, &chain(&term.maps[..*at], &powers.get(n))))
        });
        !is_positive_definite(&whole)
    })
}

/// `M^n R` as products of few powers, to limit the rounding.
pub(crate) struct Powers {
    begin: u64,
    /// `M^k` for `k` below the stride.
    steps: Vec<Enclosure>,
    /// `M^n R` at multiples of the stride.
    leaps: Vec<Enclosure>,
}

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
