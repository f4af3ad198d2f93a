use super::Faults;
use crate::augmentation::{AmplifySettings, AugmentationSettings, DampSettings, ForceLawSettings};
use crate::chain::Measurement;
use crate::detector::DetectorSettings;
use crate::error::{InvalidValue, finite, require};
use crate::estimation::{ContactSettings, Forgetting, Parameters, RlsSettings, VelocityFilter};
use crate::safety::SafetySettings;
use crate::settings::{Key, KeySource, Range, count, joined, restricted};

/// Far beyond any rig: no product of a tick overflows or underflows.
const MIN_MAGNITUDE: f64 = 1e-12;
const MAX_MAGNITUDE: f64 = 1e12;

const MAX_LIMIT: f64 = 1e6;

/// Bounds the time of a step.
const MAX_BRIDGED_SAMPLES: u64 = 100;

/// Source of the slave's velocity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum VelocitySource {
    /// From the sample.
    Measured,
    /// Estimated from positions by a [`VelocityFilter`].
    Filtered {
        /// Step of the encoder in m, above 0.
        resolution_m: f64,
        /// Standard deviation of the acceleration in m/s², above 0.
        acceleration_std_m_per_s2: f64,
    },
}

impl VelocitySource {
    pub(super) fn is_measured(&self) -> bool {
        matches!(self, Self::Measured)
    }
}

/// NaN exceeds every limit.
#[inline(always)]
pub(super) fn is_beyond(value: f64, limit: f64) -> bool {
    !value.abs().le(&limit)
}

impl Limits {
    #[inline(always)]
    pub(super) fn slave_faults(&self, sample: &Measurement<f64>, reads_velocity: bool) -> Faults {
        Faults {
            master_position: false,
            slave_position: is_beyond(sample.position_m, self.position_m),
            slave_velocity: is_beyond(sample.velocity_m_per_s, self.velocity_m_per_s) & reads_velocity,
            force: is_beyond(sample.force_n, self.force_n),
        }
    }
}

const TICK: Range = Range::stated(1e-6, 1.0, "from 1e-6 to 1");

const LIMIT: Range = Range::stated(MIN_MAGNITUDE, MAX_LIMIT, "positive, from 1e-12 to 1e6");

crate::settings! {
    /// Limits of a possible sample, and rates of recovery. Chosen here.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Limits in "rig." {
        /// Largest magnitude of a position; a sample beyond it is bad.
        position_m: f64 at "rig.position_limit_m" [self::LIMIT] = 1.0,
        /// Largest magnitude of a velocity; a sample beyond it is bad.
        velocity_m_per_s: f64 at "rig.velocity_limit_m_per_s" [self::LIMIT] = 10.0,
        /// Largest magnitude of a force; a sample beyond it is bad.
        force_n: f64 at "rig.force_limit_n" [self::LIMIT] = 100.0,
        /// Longest gap, in samples, over which missing samples are interpolated; at most 100.
        bridged_samples: u64 [0..] = 9,
        /// Speed at which the reference returns to the hand after bad samples.
        recovery_speed_m_per_s: f64 [POSITIVE] = 0.03,
        /// Rate at which the feedback force returns to the measured force after bad samples.
        recovery_force_rate_n_per_s: f64 [POSITIVE] = 50.0,
    }
    where bridged_samples: |s| s.bridged_samples <= MAX_BRIDGED_SAMPLES, "at most 100";
}

crate::settings! {
    #[derive(Debug, Clone, Copy, PartialEq)]
    struct Machines in "rig." {
        /// Time between two samples. Estimator and detector count samples: their defaults are for 0.5 to 2 ms.
        tick_s: f64 at "simulation.tick_s" [self::TICK] = 1e-3,
        /// Position of the master when the controller starts, used until the first good sample.
        start_m: f64 [ANY] = 0.0,
        /// Slave motion per master motion.
        position_scale: f64 at "scaling.position" [self::LIMIT] = 1.0,
        /// Feedback force per measured force.
        force_scale: f64 at "scaling.force" [self::LIMIT] = 1.0,
        /// Step of the slave's encoder; above 0 the velocity is estimated by a Kalman filter, at 0 it is read.
        resolution_m: f64 at "sensor.position_resolution_m" [ENCODER_STEP] = 0.0,
        /// Standard deviation of the acceleration in the Kalman filter.
        acceleration_std_m_per_s2: f64 at "sensor.acceleration_std_m_per_s2" [POSITIVE] = 0.5,
    }
}

/// Settings of a [`HapticController`](super::HapticController).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// From 10⁻⁶ to 1.
    pub tick_s: f64,
    /// Of the master, until the first good sample.
    pub start_m: f64,
    /// Tissue surface assumed by the estimator.
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
    /// Limits of a possible sample.
    pub limits: Limits,
    /// Limits of the commands.
    pub safety: SafetySettings,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            tick_s: Machines::DEFAULT.tick_s,
            start_m: Machines::DEFAULT.start_m,
            contact_m: ContactSettings::DEFAULT.contact_m,
            position_scale: Machines::DEFAULT.position_scale,
            force_scale: Machines::DEFAULT.force_scale,
            velocity: VelocitySource::Measured,
            estimator: RlsSettings::default(),
            detector: DetectorSettings::default(),
            augmentation: AugmentationSettings::default(),
            limits: Limits::default(),
            safety: SafetySettings::default(),
        }
    }
}

impl Settings {
    /// Keys of a scenario, and `rig.start_m`.
    pub const KEYS: &'static [Key] = {
        const GROUPS: &[&[Key]] = &[
            Machines::KEYS,
            Limits::KEYS,
            SafetySettings::KEYS,
            ContactSettings::KEYS,
            RlsSettings::KEYS,
            DetectorSettings::KEYS,
            AugmentationSettings::KEYS,
        ];
        const COUNT: usize = count(GROUPS);
        &restricted(
            restricted(joined::<COUNT>(GROUPS), Forgetting::KEY.path, &["resetting"]),
            Parameters::KEY.path,
            &["stiffness-and-damping", "stiffness"],
        )
    };

    /// Does not check ranges; a resolution of 0 means a measured velocity.
    pub fn read<S: KeySource>(source: &mut S) -> Result<Self, S::Error> {
        let Machines { tick_s, start_m, position_scale, force_scale, resolution_m, acceleration_std_m_per_s2 } =
            Machines::read(source)?;
        let velocity = if resolution_m == 0.0 {
            VelocitySource::Measured
        } else {
            VelocitySource::Filtered { resolution_m, acceleration_std_m_per_s2 }
        };
        Ok(Self {
            tick_s,
            start_m,
            position_scale,
            force_scale,
            velocity,
            limits: Limits::read(source)?,
            safety: SafetySettings::read(source)?,
            contact_m: ContactSettings::read(source)?.contact_m,
            estimator: RlsSettings::read(source)?,
            detector: DetectorSettings::read(source)?,
            augmentation: AugmentationSettings::read(source)?,
        })
    }

    /// Checks ranges, and that no good sample makes a tick's numbers overflow.
    pub fn validate(&self) -> Result<(), InvalidValue> {
        self.machines().validate()?;
        self.limits.validate()?;
        self.safety.validate()?;
        within("rig.start_m", self.start_m, self.limits.position_m)?;
        within("estimator.contact_m", self.contact_m, MAX_LIMIT)?;
        if let VelocitySource::Filtered { resolution_m, acceleration_std_m_per_s2 } = self.velocity {
            VelocityFilter::<f64>::new(self.tick_s, resolution_m, acceleration_std_m_per_s2)?;
        }
        self.estimator.validate()?;
        let RlsSettings { parameters, forgetting, .. } = self.estimator;
        // Words are reported by their index from 0, as in C.
        let number =
            |words: &[&str], word| words.iter().position(|one| *one == word).map_or(f64::NAN, |place| place as f64);
        let resets = matches!(forgetting, Forgetting::Resetting);
        let requirement = "the word resetting: a rig runs no other estimator";
        require("estimator.forgetting", number(Forgetting::WORDS, forgetting.word()), resets, requirement)?;
        let requirement = "the word stiffness or stiffness-and-damping: a rig runs no other estimator";
        let baseline = self.estimator.is_baseline();
        require("estimator.parameters", number(Parameters::WORDS, parameters.word()), baseline, requirement)?;
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
            LIMIT.check("augmentation.amplification", gain)?;
        }
        if let ForceLawSettings::Damp(DampSettings { damping_n_s_per_m, .. }) = self.augmentation.force {
            let is_moderate = damping_n_s_per_m <= MAX_LIMIT;
            require("augmentation.damp_damping_n_s_per_m", damping_n_s_per_m, is_moderate, "at most 1e6")?;
        }
        Ok(())
    }

    fn machines(&self) -> Machines {
        let Self { tick_s, start_m, position_scale, force_scale, .. } = *self;
        let (resolution_m, acceleration_std_m_per_s2) = match self.velocity {
            VelocitySource::Measured => (0.0, Machines::DEFAULT.acceleration_std_m_per_s2),
            VelocitySource::Filtered { resolution_m, acceleration_std_m_per_s2 } => {
                (resolution_m, acceleration_std_m_per_s2)
            }
        };
        Machines { tick_s, start_m, position_scale, force_scale, resolution_m, acceleration_std_m_per_s2 }
    }
}

fn within(name: &'static str, value: f64, limit: f64) -> Result<f64, InvalidValue> {
    finite(name, value)?;
    require(name, value, value.abs() <= limit, "within the limit of positions")
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
    use crate::detector::{DistanceSettings, Hypotheses};

    fn refused(settings: Settings) -> &'static str {
        settings.validate().expect_err("out of range").name
    }

    #[test]
    fn a_setting_out_of_range_is_named() {
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
    fn the_words_of_an_estimator_are_those_that_validation_accepts() {
        let words = |path: &str| {
            let key = Settings::KEYS.iter().find(|key| key.path == path).expect("a key");
            if let crate::settings::Kind::Choice(words) = key.kind { words } else { &[] }
        };
        let default = Settings::default();
        for parameters in Parameters::ALL {
            let estimator = RlsSettings { parameters, ..default.estimator };
            let is_accepted = Settings { estimator, ..default }.validate().is_ok();
            assert_eq!(words("estimator.parameters").contains(&parameters.word()), is_accepted, "{parameters:?}");
        }
        assert_eq!(words("estimator.forgetting"), [Forgetting::Resetting.word()]);
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
