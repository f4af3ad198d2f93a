use trocar_base::quantiles::quantile_of;

/// Time from each tick's due time to its beginning.
#[derive(Debug, Clone)]
pub struct Lateness {
    late_s: Vec<f64>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LatenessSummary {
    pub median_s: Option<f64>,
    pub p99_s: Option<f64>,
    pub p999_s: Option<f64>,
    pub worst_s: Option<f64>,
    pub missed: u64,
}

impl Lateness {
    pub fn new(ticks: u64) -> Self {
        Self { late_s: Vec::with_capacity(ticks as usize) }
    }

    pub fn add(&mut self, late_s: f64) {
        self.late_s.push(late_s);
    }

    pub fn summary(&self, tick_s: f64) -> LatenessSummary {
        let mut values = self.late_s.clone();
        let mut at = |share| quantile_of(&mut values, share);
        LatenessSummary {
            median_s: at(0.5),
            p99_s: at(0.99),
            p999_s: at(0.999),
            worst_s: at(1.0),
            missed: self.late_s.iter().filter(|late_s| **late_s > tick_s).count() as u64,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_summary_has_the_quantiles_of_the_ticks() {
        let mut lateness = Lateness::new(1001);
        assert_eq!(lateness.summary(1e-3).worst_s, None);
        (0..=1000).for_each(|tick| lateness.add(f64::from(tick)));
        let summary = lateness.summary(998.5);
        assert_eq!((summary.median_s, summary.p99_s), (Some(500.0), Some(990.0)));
        assert_eq!((summary.p999_s, summary.worst_s, summary.missed), (Some(999.0), Some(1000.0), 2));
    }
}
