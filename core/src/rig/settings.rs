//! Settings of a rig's controller.

use crate::augmentation::{AmplifySettings, AugmentationSettings, DampSettings, ForceLawSettings};
use crate::detection::DetectorSettings;
use crate::error::{InvalidValue, finite, positive, require};
use crate::estimation::{RlsSettings, VelocityFilter};

/// Smallest and largest magnitude of a setting that the tick divides by or multiplies with. Within these bounds no
/// product of the tick overflows or underflows a 64-bit float. Chosen here, far beyond any rig.
const MIN_MAGNITUDE: f64 = 1e-12;
const MAX_MAGNITUDE: f64 = 1e12;

/// Largest limit, scale and amplification.
const MAX_LIMIT: f64 = 1e6;

/// Source of the slave's velocity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum VelocitySource {
    /// From the sample.
    Measured,
    /// Estimated from the slave's positions by a [`VelocityFilter`].
    Filtered {
        /// Step of the encoder in m, above 0.
        resolution_m: f64,
        /// Standard deviation of the acceleration in m/s², above 0.
        acceleration_std_m_per_s2: f64,
    },
}

/// Limits of a possible sample, and how fast commands recover after impossible ones.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Largest magnitude of a position in m, above 0, at most 10⁶.
    pub position_m: f64,
    /// Largest magnitude of a velocity in m/s, above 0, at most 10⁶.
    pub velocity_m_per_s: f64,
    /// Largest magnitude of a force in N, above 0, at most 10⁶: not above the sensor's range.
    pub force_n: f64,
    /// Speed at which the reference returns to the hand, in m/s, above 0.
    pub recovery_speed_m_per_s: f64,
    /// Rate at which the feedback force returns to the measured one, in N/s, above 0.
    pub recovery_force_rate_n_per_s: f64,
}

impl Default for Limits {
    /// Wider than a needle's rig, chosen here; the recovery is that of a link after an outage.
    fn default() -> Self {
        Self {
            position_m: 1.0,
            velocity_m_per_s: 10.0,
            force_n: 100.0,
            recovery_speed_m_per_s: 0.03,
            recovery_force_rate_n_per_s: 50.0,
        }
    }
}

/// All settings of a [`HapticController`](super::HapticController).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Time between two samples in s, from 10⁻⁶ to 1.
    pub tick_s: f64,
    /// Position of the master when the controller starts, in m: used until the first good sample.
    pub start_m: f64,
    /// Position of the tissue surface assumed by the estimator, in m.
    pub contact_m: f64,
    /// Slave motion per master motion, above 0.
    pub position_scale: f64,
    /// Feedback force per measured force, above 0.
    pub force_scale: f64,
    /// Source of the slave's velocity.
    pub velocity: VelocitySource,
    /// The estimator.
    pub estimator: RlsSettings,
    /// The detector.
    pub detector: DetectorSettings,
    /// The supervisor.
    pub augmentation: AugmentationSettings,
    /// The limits of a possible sample.
    pub limits: Limits,
}

impl Default for Settings {
    /// The simulator's settings at 1 kHz, with the tissue surface at 0.
    fn default() -> Self {
        Self {
            tick_s: 1e-3,
            start_m: 0.0,
            contact_m: 0.0,
            position_scale: 1.0,
            force_scale: 1.0,
            velocity: VelocitySource::Measured,
            estimator: RlsSettings::default(),
            detector: DetectorSettings::default(),
            augmentation: AugmentationSettings::default(),
            limits: Limits::default(),
        }
    }
}

impl Settings {
    /// Checks the stated ranges of the fields, those of estimator, detector and supervisor, and that no good sample can
    /// make a tick's numbers overflow.
    ///
    /// # Errors
    /// [`InvalidValue`] naming the first setting out of range.
    pub fn validate(&self) -> Result<(), InvalidValue> {
        let tick = (1e-6..=1.0).contains(&self.tick_s);
        require("simulation.tick_s", self.tick_s, tick, "from 1e-6 to 1")?;
        self.limits.validate()?;
        within("rig.start_m", self.start_m, self.limits.position_m)?;
        within("estimator.contact_m", self.contact_m, MAX_LIMIT)?;
        at_most("scaling.position", self.position_scale, MAX_LIMIT)?;
        at_most("scaling.force", self.force_scale, MAX_LIMIT)?;
        if let VelocitySource::Filtered { resolution_m, acceleration_std_m_per_s2 } = self.velocity {
            VelocityFilter::<f64>::new(self.tick_s, resolution_m, acceleration_std_m_per_s2)?;
        }
        self.estimator.validate()?;
        let requirement = "stiffness or stiffness-and-damping with resetting: a rig runs no other estimator";
        require("estimator.parameters", 0.0, self.estimator.is_baseline(), requirement)?;
        moderate("estimator.initial_gain", self.estimator.initial_gain)?;
        moderate_or_zero("estimator.dead_zone_n", self.estimator.dead_zone_n)?;
        moderate_or_zero("estimator.normalisation", self.estimator.normalisation)?;
        self.detector.validate()?;
        let hypotheses = &self.detector.distance.hypotheses;
        moderate("detector.quiet_std_n", hypotheses.quiet_std_n)?;
        moderate("detector.rupture_std_n", hypotheses.rupture_std_n)?;
        moderate("detector.rupture_mean_n", hypotheses.rupture_mean_n)?;
        self.augmentation.validate()?;
        if let ForceLawSettings::Amplify(AmplifySettings { gain }) = self.augmentation.force {
            at_most("augmentation.amplification", gain, MAX_LIMIT)?;
        }
        if let ForceLawSettings::Damp(DampSettings { damping_n_s_per_m, .. }) = self.augmentation.force {
            let is_moderate = damping_n_s_per_m <= MAX_LIMIT;
            require("augmentation.damp_damping_n_s_per_m", damping_n_s_per_m, is_moderate, "at most 1e6")?;
        }
        Ok(())
    }
}

impl Limits {
    /// Checks the stated ranges of the fields.
    ///
    /// # Errors
    /// [`InvalidValue`] naming the first limit out of range.
    pub fn validate(&self) -> Result<(), InvalidValue> {
        at_most("rig.position_limit_m", self.position_m, MAX_LIMIT)?;
        at_most("rig.velocity_limit_m_per_s", self.velocity_m_per_s, MAX_LIMIT)?;
        at_most("rig.force_limit_n", self.force_n, MAX_LIMIT)?;
        positive("rig.recovery_speed_m_per_s", self.recovery_speed_m_per_s)?;
        positive("rig.recovery_force_rate_n_per_s", self.recovery_force_rate_n_per_s)?;
        Ok(())
    }
}

fn within(name: &'static str, value: f64, limit: f64) -> Result<f64, InvalidValue> {
    finite(name, value)?;
    require(name, value, value.abs() <= limit, "within the limit of positions")
}

fn at_most(name: &'static str, value: f64, max: f64) -> Result<f64, InvalidValue> {
    require(name, value, value >= MIN_MAGNITUDE && value <= max, "positive, from 1e-12 to 1e6")
}

fn moderate(name: &'static str, value: f64) -> Result<f64, InvalidValue> {
    require(name, value, (MIN_MAGNITUDE..=MAX_MAGNITUDE).contains(&value.abs()), "of a magnitude from 1e-12 to 1e12")
}

fn moderate_or_zero(name: &'static str, value: f64) -> Result<f64, InvalidValue> {
    if value == 0.0 { Ok(value) } else { moderate(name, value) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detection::{DistanceSettings, Hypotheses};

    fn refused(settings: Settings) -> &'static str {
        settings.validate().expect_err("out of range").name
    }

    #[test]
    fn what_is_out_of_range_is_named() {
        let default = Settings::default();
        assert!(default.validate().is_ok());
        assert_eq!(refused(Settings { tick_s: 0.0, ..default }), "simulation.tick_s");
        assert_eq!(refused(Settings { start_m: 2.0, ..default }), "rig.start_m");
        assert_eq!(refused(Settings { contact_m: f64::NAN, ..default }), "estimator.contact_m");
        let limits = Limits { force_n: f64::INFINITY, ..default.limits };
        assert_eq!(refused(Settings { limits, ..default }), "rig.force_limit_n");
        let velocity = VelocitySource::Filtered { resolution_m: 0.0, acceleration_std_m_per_s2: 1.0 };
        assert_eq!(refused(Settings { velocity, ..default }), "sensor.position_resolution_m");
    }

    #[test]
    fn a_spread_of_zero_is_refused_and_a_dead_zone_of_zero_is_not() {
        let default = Settings::default();
        for quiet_std_n in [0.0, 1e-200, f64::NAN] {
            let distance = DistanceSettings {
                hypotheses: Hypotheses { quiet_std_n, ..Hypotheses::default() },
                ..default.detector.distance
            };
            let detector = DetectorSettings { distance, ..default.detector };
            assert_eq!(refused(Settings { detector, ..default }), "detector.quiet_std_n");
        }
        let estimator = RlsSettings { dead_zone_n: 0.0, normalisation: 0.0, ..default.estimator };
        assert!(Settings { estimator, ..default }.validate().is_ok());
    }
}
