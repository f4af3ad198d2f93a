/// Welford, *Technometrics* 4, 1962.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Moments {
    pub count: u64,
    pub mean: f64,
    /// `Σ (x - mean)²`.
    pub squares: f64,
}

impl Moments {
    /// Ignores NaN and infinity.
    pub fn add_finite(&mut self, value: f64) {
        if value.is_finite() {
            self.add(value);
        }
    }

    #[inline]
    pub fn add(&mut self, value: f64) {
        self.count += 1;
        let before = value - self.mean;
        self.mean += before / self.count as f64;
        self.squares += before * (value - self.mean);
    }

    pub fn variance(&self) -> f64 {
        if self.count > 1 { self.squares / (self.count - 1) as f64 } else { 0.0 }
    }

    pub fn standard_error(&self) -> f64 {
        if self.count > 0 { (self.variance() / self.count as f64).sqrt() } else { 0.0 }
    }
}
