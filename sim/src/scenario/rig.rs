//! From a scenario to the settings of a real controller.

use super::resolve::Scenario;
use crate::rig::{Limits, Settings, VelocitySource};

impl Scenario {
    /// The settings with which a rig's controller acts as this scenario's.
    ///
    /// Architecture and passivity of the link are not transferred: [`crate::rig`] implements the paper's scheme. The
    /// limits are the defaults, because a scenario has none.
    #[must_use]
    pub fn rig_settings(&self) -> Settings {
        let resolution_m = self.sensor.position_resolution_m;
        Settings {
            tick_s: self.grid.tick_s(),
            start_m: self.start_m(),
            contact_m: self.contact_m,
            position_scale: self.position_scale(),
            force_scale: self.link.machines.force_scale,
            velocity: if resolution_m > 0.0 {
                let acceleration_std_m_per_s2 = self.sensor.acceleration_std_m_per_s2;
                VelocitySource::Filtered { resolution_m, acceleration_std_m_per_s2 }
            } else {
                VelocitySource::Measured
            },
            estimator: self.estimator,
            detector: self.detector,
            augmentation: self.augmentation,
            limits: Limits::default(),
        }
    }
}
