use thiserror::Error;

use super::samples::intervals;
use super::{Limits, Recording};
use trocar_base::interrupt;
use trocar_base::parallel::join_in_pool;

#[derive(Debug, Clone, PartialEq, Error)]
pub enum ArrayError {
    #[error("{name} has {length} samples and time_s has {times}; each needs one per time")]
    Length { name: &'static str, length: usize, times: usize },
    #[error("{0} samples are too few; at least two are needed")]
    TooFew(usize),
    #[error("{name}[{index}] is {value}, must be a finite number; correct it or remove the sample")]
    NotFinite { name: &'static str, index: usize, value: f64 },
    /// A time is not later than the previous time.
    #[error(
        "time_s[{index}] is {time_s:?} s, must be later than the previous {before_s:?} s; sort the samples, one per time"
    )]
    NotLater { index: usize, time_s: f64, before_s: f64 },
    #[error(
        "no sample for {gap_s:.6} s before time_s[{index}], the limit is {limit_s:.6} s; cut the recording there, or raise \
         recording.max_gap_s"
    )]
    Gap { index: usize, gap_s: f64, limit_s: f64 },
}

impl Recording {
    /// Forces are positive when they resist insertion. `max_gap_s` is by default [`Limits::GAP_IN_MEDIANS`] times the
    /// median interval.
    pub fn new(
        time_s: Vec<f64>,
        position_m: Vec<f64>,
        velocity_m_per_s: Option<Vec<f64>>,
        force_n: Vec<f64>,
        max_gap_s: Option<f64>,
    ) -> Result<Self, ArrayError> {
        let quantities = [
            ("position_m", Some(&*position_m)),
            ("velocity_m_per_s", velocity_m_per_s.as_deref()),
            ("force_n", Some(&*force_n)),
        ];
        // In parallel, because either closure takes a tenth as long as the detection.
        let (checked, interval_s) = join_in_pool(|| check(&time_s, quantities), || intervals(&time_s));
        checked?;
        let recording = Self::with_intervals(time_s, position_m, velocity_m_per_s, force_n, interval_s);
        recording.check_gaps(max_gap_s)?;
        Ok(recording)
    }

    pub fn check_gaps(&self, max_gap_s: Option<f64>) -> Result<(), ArrayError> {
        let limit_s = max_gap_s.unwrap_or(Limits::GAP_IN_MEDIANS * self.median_interval_s());
        let gap = |pair: &[f64]| pair[1] - pair[0];
        let allowed = |gap_s: f64| gap_s <= limit_s * (1.0 + 1e-9);
        let too_long = || self.time_s().windows(2).position(|pair| !allowed(gap(pair)));
        let (_, longest_s) = self.interval_range_s();
        match if allowed(longest_s) { None } else { too_long() } {
            None => Ok(()),
            Some(before) => {
                let gap_s = gap(&self.time_s()[before..before + 2]);
                Err(ArrayError::Gap { index: before + 1, gap_s, limit_s })
            }
        }
    }
}

fn check(time_s: &[f64], others: [(&'static str, Option<&[f64]>); 3]) -> Result<(), ArrayError> {
    let times = time_s.len();
    for (name, values) in std::iter::once(("time_s", Some(time_s))).chain(others) {
        let Some(values) = values else { continue };
        if values.len() != times {
            return Err(ArrayError::Length { name, length: values.len(), times });
        }
        if let Some(index) = first_where(values, |value| !value.is_finite()) {
            return Err(ArrayError::NotFinite { name, index, value: values[index] });
        }
    }
    if times < 2 {
        return Err(ArrayError::TooFew(times));
    }
    match time_s.windows(2).position(|pair| pair[1] <= pair[0]) {
        Some(before) => {
            let (index, time_s, before_s) = (before + 1, time_s[before + 1], time_s[before]);
            Err(ArrayError::NotLater { index, time_s, before_s })
        }
        None => Ok(()),
    }
}

pub fn first_where(values: &[f64], holds: impl Fn(&f64) -> bool) -> Option<usize> {
    const AT_ONCE: usize = 512;
    interrupt::check();
    let has_any = |block: &[f64]| block.iter().fold(false, |any, value| any | holds(value));
    let block = values.chunks(AT_ONCE).position(has_any)? * AT_ONCE;
    Some(block + values[block..].iter().position(holds)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(time_s: &[f64], force_n: &[f64]) -> Result<Recording, ArrayError> {
        Recording::new(time_s.to_vec(), vec![0.0; time_s.len()], None, force_n.to_vec(), None)
    }

    #[test]
    fn even_samples_are_a_recording() {
        let recording = of(&[1.0, 1.5, 2.0], &[1.0, 2.0, 3.0]).expect("good");
        assert_eq!((recording.len(), recording.median_interval_s()), (3, 0.5));
    }

    #[test]
    fn each_error_names_its_sample() {
        let message = |time_s: &[f64], force_n: &[f64]| of(time_s, force_n).expect_err("refused").to_string();
        assert!(message(&[0.0, 1.0], &[0.0; 3]).contains("force_n has 3 samples and time_s has 2"));
        assert!(message(&[0.0], &[0.0]).contains("1 samples are too few"));
        assert!(message(&[0.0, 1.0], &[0.0, f64::NAN]).contains("force_n[1] is NaN"));
        assert!(message(&[0.0, f64::INFINITY], &[0.0; 2]).contains("time_s[1] is inf"));
        assert!(
            message(&[0.0, 1.0, 1.0], &[0.0; 3]).contains("time_s[2] is 1.0 s, must be later than the previous 1.0 s")
        );
        assert!(message(&[0.0, 1.0, 2.0, 13.0], &[0.0; 4]).contains("before time_s[3], the limit is 10.0"));
    }
}
