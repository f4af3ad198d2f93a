use super::IgnoredUnit;
use super::stamp::written;
use trocar_base::quantiles::{AT_ONCE, order_statistic};
use trocar_base::warning::{Code, Warning};

/// In time order. All quantities have the same length, at least two. Every number is finite, and time strictly
/// increases.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    time_s: Vec<f64>,
    position_m: Vec<f64>,
    velocity_m_per_s: Option<Vec<f64>>,
    force_n: Vec<f64>,
    /// Minimum, median and maximum.
    interval_s: [f64; 3],
    joined: Vec<Joined>,
    ignored_units: Vec<IgnoredUnit>,
    unfinished: Option<String>,
    origin_s: f64,
}

/// Interpolated at the times of another signal.
#[derive(Clone, Debug, PartialEq)]
pub struct Joined {
    pub signal: String,
    pub to: String,
    pub median_interval_s: f64,
    pub longest_interval_s: f64,
    /// In s, outside the common time.
    pub cut_s: f64,
}

impl Recording {
    /// The caller ensures every property of the type.
    pub(super) fn from_checked(
        time_s: Vec<f64>,
        position_m: Vec<f64>,
        velocity_m_per_s: Option<Vec<f64>>,
        force_n: Vec<f64>,
    ) -> Self {
        let interval_s = intervals(&time_s);
        Self::with_intervals(time_s, position_m, velocity_m_per_s, force_n, interval_s)
    }

    pub(super) fn with_intervals(
        time_s: Vec<f64>,
        position_m: Vec<f64>,
        velocity_m_per_s: Option<Vec<f64>>,
        force_n: Vec<f64>,
        interval_s: [f64; 3],
    ) -> Self {
        Self {
            time_s,
            position_m,
            velocity_m_per_s,
            force_n,
            interval_s,
            joined: vec![],
            ignored_units: vec![],
            unfinished: None,
            origin_s: 0.0,
        }
    }

    pub(super) fn with_joined(self, joined: Vec<Joined>) -> Self {
        Self { joined, ..self }
    }

    pub(super) fn with_ignored_units(self, ignored_units: Vec<IgnoredUnit>) -> Self {
        Self { ignored_units, ..self }
    }

    pub(super) fn with_unfinished(self, unfinished: Option<String>) -> Self {
        Self { unfinished, ..self }
    }

    pub fn unfinished(&self) -> Option<&str> {
        self.unfinished.as_deref()
    }

    pub fn unfinished_warning(&self) -> Option<Warning> {
        let message = format!("the recording may be cut off: {}", self.unfinished.as_ref()?);
        let remedy = "compare its end with the original, or remove the last sample";
        Some(Warning::new(Code::UnfinishedFile, message).remedy(remedy))
    }

    pub fn ignored_units(&self) -> &[IgnoredUnit] {
        &self.ignored_units
    }

    pub fn joined(&self) -> &[Joined] {
        &self.joined
    }

    pub(super) fn since(self, origin_s: f64) -> Self {
        Self { origin_s, ..self }
    }

    /// In s since 1970; 0 if the times are not of the calendar.
    pub fn origin_s(&self) -> f64 {
        self.origin_s
    }

    pub fn origin_text(&self) -> Option<String> {
        if self.origin_s == 0.0 { None } else { written(self.origin_s) }
    }

    pub fn zeroed(mut self, is_on: bool) -> Self {
        if is_on && let Some(&first_m) = self.position_m.first() {
            self.position_m.iter_mut().for_each(|position_m| *position_m -= first_m);
        }
        self
    }

    pub fn into_columns(self) -> (Vec<f64>, Vec<f64>, Option<Vec<f64>>, Vec<f64>) {
        (self.time_s, self.position_m, self.velocity_m_per_s, self.force_n)
    }

    /// As recorded; the first may differ from 0.
    pub fn time_s(&self) -> &[f64] {
        &self.time_s
    }

    /// Increases into the tissue.
    pub fn position_m(&self) -> &[f64] {
        &self.position_m
    }

    pub fn velocity_m_per_s(&self) -> Option<&[f64]> {
        self.velocity_m_per_s.as_deref()
    }

    /// Positive when it resists insertion.
    pub fn force_n(&self) -> &[f64] {
        &self.force_n
    }

    /// Subtracts the mean force of the first `tare_s` (s) from all forces; 0 subtracts nothing.
    pub fn tared(mut self, tare_s: f64) -> Self {
        let start_s = self.time_s.first().copied().unwrap_or(0.0);
        let count = self.time_s.partition_point(|time_s| time_s - start_s <= tare_s);
        if tare_s > 0.0 && count > 0 {
            let mean_n = self.force_n[..count].iter().sum::<f64>() / count as f64;
            self.force_n.iter_mut().for_each(|force_n| *force_n -= mean_n);
        }
        self
    }

    /// For an even number of intervals, the lower of the middle two.
    pub fn median_interval_s(&self) -> f64 {
        self.interval_s[1]
    }

    pub fn interval_range_s(&self) -> (f64, f64) {
        (self.interval_s[0], self.interval_s[2])
    }

    pub fn duration_s(&self) -> f64 {
        match self.time_s.as_slice() {
            [first, .., last] => last - first,
            _ => 0.0,
        }
    }

    #[expect(clippy::len_without_is_empty, reason = "a recording is never empty")]
    pub fn len(&self) -> usize {
        self.time_s.len()
    }
}

pub(super) fn intervals(time_s: &[f64]) -> [f64; 3] {
    let intervals = || time_s.windows(2).map(|pair| pair[1] - pair[0]);
    let (min_s, max_s) = intervals().fold((f64::INFINITY, 0.0), |(min_s, max_s): (f64, f64), interval_s| {
        (interval_s.min(min_s), interval_s.max(max_s))
    });
    let visit_all = |visit: &mut dyn FnMut(&[f64])| {
        let mut block = [0.0; AT_ONCE];
        for from in (1..time_s.len()).step_by(AT_ONCE) {
            let next = &time_s[from..time_s.len().min(from + AT_ONCE)];
            let pairs = time_s[from - 1..].iter().zip(next);
            block.iter_mut().zip(pairs).for_each(|(interval_s, (before, after))| *interval_s = after - before);
            visit(&block[..next.len()]);
        }
    };
    let count = time_s.len().saturating_sub(1);
    match order_statistic(count, visit_all, count.saturating_sub(1) / 2) {
        Some(median_s) => [min_s, median_s, max_s],
        None => [0.0; 3],
    }
}

#[cfg(test)]
mod tests {
    use super::super::fixtures::recording;
    use super::*;

    #[test]
    fn the_median_is_an_interval_of_the_recording() {
        assert_eq!(intervals(&[0.0, 1.0]), [1.0, 1.0, 1.0]);
        assert_eq!(intervals(&[0.0, 8.0, 9.0]), [1.0, 1.0, 8.0]);
        assert_eq!(intervals(&[0.0, 8.0, 9.0, 11.0]), [1.0, 2.0, 8.0]);
    }

    #[test]
    fn duration_counts_from_the_first_sample() {
        let recording = recording(&[3.0, 3.5, 5.0], &[0.0; 3]);
        assert_eq!(recording.duration_s(), 2.0);
        assert_eq!(recording.len(), 3);
    }
}
