//! Derives the settings of a real controller from a scenario.

use trocar_core::settings::Key;

use super::document::Source;
use super::error::ScenarioError;
use super::scenario::Scenario;
use super::value::Value;
use trocar_core::rig::{Settings, VelocitySource};
use trocar_core::safety::SafetySettings;

/// An operator and a tissue that need no further key.
const SIMULATION: [&str; 2] = ["operator.kind=ramp", "tissue.kind=kelvin-voigt"];

impl Scenario {
    /// The text may leave out the operator and the tissue.
    pub fn load_for_rig(source: &Source) -> Result<Self, ScenarioError> {
        Self::load(source, &[]).or_else(|error| {
            let without_simulation = Self::load(source, &SIMULATION.map(str::to_owned));
            without_simulation.map_err(|_| error)
        })
    }

    /// Architecture and passivity of the link are not transferred, because [`trocar_core::rig`] implements the paper's
    /// scheme. A limit of the master's motor lowers the limit of the force.
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
            limits: self.rig_limits,
            safety: SafetySettings { force_limit_n: self.force_limit_n(), ..self.safety },
        }
    }

    /// The largest force of a rig's master in N.
    fn force_limit_n(&self) -> f64 {
        let limit_n = self.safety.force_limit_n;
        self.actuators.master_force_n.map_or(limit_n, |motor_n| motor_n.min(limit_n))
    }

    /// Replaces values of some [`Settings::KEYS`]; [`Settings::validate`] checks the ranges.
    pub fn rig_settings_with(&self, changes: &[(&'static str, f64)]) -> Result<Settings, ScenarioError> {
        let mut values = self.values().clone();
        for (key, value) in self.rig_values() {
            if let Some(value) = value {
                values.derive(key.path, value);
            }
        }
        for (path, value) in changes {
            values.derive(path, Value::Number(*value));
        }
        Settings::read(&mut values)
    }

    /// In the order of [`Settings::KEYS`]; `None` for a key without a value.
    pub fn rig_values(&self) -> impl Iterator<Item = (&'static Key, Option<Value>)> {
        Settings::KEYS.iter().map(|key| {
            let value = match key.path {
                "rig.start_m" => Some(Value::Number(self.start_m())),
                "safety.force_limit_n" => Some(Value::Number(self.force_limit_n())),
                path => self.values().get(path).cloned(),
            };
            (key, value)
        })
    }
}
