use trocar_core::error::{InvalidValue, positive, require};

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CalibrationRequest {
    /// Above 0.
    pub first_s: f64,
    /// In s after the first sample; `None` to search for it.
    pub quiet_s: Option<(f64, f64)>,
    /// True if `estimator.contact_m` is kept.
    pub keeps_contact: bool,
    /// Above 0.
    pub false_alarm_s: f64,
    /// Time for half of the force; above 0.
    pub slowest_rupture_s: f64,
    /// Time for half of the force; above `slowest_rupture_s`.
    pub fastest_harmless_s: f64,
    /// `σ_1²/σ_0²`, above 1.
    pub variance_ratio: f64,
}

impl Default for CalibrationRequest {
    fn default() -> Self {
        Self {
            first_s: 5.0,
            quiet_s: None,
            keeps_contact: false,
            false_alarm_s: 3600.0,
            slowest_rupture_s: 0.03,
            fastest_harmless_s: 0.5,
            variance_ratio: 100.0,
        }
    }
}

impl CalibrationRequest {
    /// At a quiet variance of 1: the likelihood ratio of eq. 23 changes its sign there.
    pub fn drift(&self) -> f64 {
        let ratio = self.variance_ratio;
        ratio.ln() * ratio / (ratio - 1.0)
    }

    pub fn validate(&self) -> Result<(), InvalidValue> {
        positive("--first-s", self.first_s)?;
        positive("--false-alarm-s", self.false_alarm_s)?;
        positive("--slowest-rupture-s", self.slowest_rupture_s)?;
        positive("--fastest-harmless-s", self.fastest_harmless_s)?;
        let slower = self.fastest_harmless_s > self.slowest_rupture_s;
        require("--fastest-harmless-s", self.fastest_harmless_s, slower, "above --slowest-rupture-s")?;
        let grows = self.variance_ratio.is_finite() && self.variance_ratio > 1.0;
        require("--variance-ratio", self.variance_ratio, grows, "a finite number above 1")?;
        if let Some((from_s, to_s)) = self.quiet_s {
            let inside = from_s >= 0.0 && to_s.is_finite() && to_s > from_s;
            require("--quiet-s", to_s, inside, "two times in s, the second one later")?;
        }
        Ok(())
    }
}
