//! From values to the parameters of the machines and the settings of sensor, estimator, detector and supervisor.

use super::error::ScenarioError;
use super::key_table::{DISTANCES, PARAMETERS};
use super::value::Value;
use super::values::Values;
use crate::augmentation::{AugmentationSettings, AutomatonSettings, ForceLawSettings, Freeze, Reengage};
use crate::detection::{
    ArmingSettings, CusumSettings, DetectorSettings, DistanceKind, DistanceSettings, Hypotheses, Motion,
};
use crate::estimation::{Forgetting, FrictionShape, Parameters, RlsSettings};
use crate::plant::{
    ActuatorLimits, ArmParameters, ControlTiming, Coupling, Damping, Grip, MasterParameters, SlaveParameters,
};
use crate::sensor::SensorSettings;

const MASTER_LIMIT: &str = "actuator.master_force_limit_n";
const COMPLIANCE: &str = "slave.compliance_m_per_n";
const SLAVE_LIMIT: &str = "actuator.slave_command_limit";
const MASTER_RATE: &str = "actuator.master_force_rate_limit_n_per_s";
const SLAVE_RATE: &str = "actuator.slave_command_rate_limit_per_s";
const MASTER_LAG: &str = "actuator.master_lag_s";
const SLAVE_LAG: &str = "actuator.slave_lag_s";

/// The master's parameters.
pub(super) fn master(values: &mut Values) -> Result<MasterParameters, ScenarioError> {
    // A spring to the slave's position is no force to be tracked: an integral of the difference would never settle.
    let couples_positions = matches!(values.text("controller.kind")?, "position-position" | "four-channel");
    let integral_gain = if couples_positions { 0.0 } else { MasterParameters::default().force_integral_gain };
    values.derive_if_missing("master.force_integral_gain", Value::Number(integral_gain));
    Ok(MasterParameters {
        mass_kg: values.number("master.mass_kg")?,
        damping_n_s_per_m: values.number("master.damping_n_s_per_m")?,
        force_integral_gain: values.number("master.force_integral_gain")?,
        coupling: match values.text("master.coupling")? {
            "as-printed" => Coupling::AsPrinted,
            _ => Coupling::Physical,
        },
    })
}

/// The arm's parameters: its grip's, where no number says otherwise.
pub(super) fn arm(values: &mut Values) -> Result<ArmParameters, ScenarioError> {
    let grip = match values.text("arm.grip")? {
        "relaxed" => Grip::Relaxed,
        "firm" => Grip::Firm,
        _ => Grip::Paper,
    };
    let of_grip = ArmParameters::of_grip(grip);
    let mut number = |path, of_grip| {
        values.derive_if_missing(path, Value::Number(of_grip));
        values.number(path)
    };
    Ok(ArmParameters {
        k_a_n_per_m: number("arm.k_a_n_per_m", of_grip.k_a_n_per_m)?,
        b_a_n_s_per_m: number("arm.b_a_n_s_per_m", of_grip.b_a_n_s_per_m)?,
        k_h_n_per_m: number("arm.k_h_n_per_m", of_grip.k_h_n_per_m)?,
        b_h_n_s_per_m: number("arm.b_h_n_s_per_m", of_grip.b_h_n_s_per_m)?,
        m_h_kg: number("arm.m_h_kg", of_grip.m_h_kg)?,
    })
}

/// The slave's parameters.
pub(super) fn slave(values: &Values) -> Result<SlaveParameters, ScenarioError> {
    Ok(SlaveParameters {
        numerator: values.numbers("slave.numerator")?.to_vec(),
        denominator: values.numbers("slave.denominator")?.to_vec(),
        proportional_gain: values.number("slave.proportional_gain")?,
        velocity_gain: values.number("slave.velocity_gain")?,
        damping: match values.text("slave.damping")? {
            "as-printed" => Damping::AsPrinted,
            _ => Damping::Velocity,
        },
    })
}

/// What the actuators can do, checked against where the controllers run.
pub(super) fn actuators(values: &Values, timing: ControlTiming) -> Result<ActuatorLimits, ScenarioError> {
    let limits = ActuatorLimits {
        master_force_n: values.optional_number(MASTER_LIMIT),
        slave_command: values.optional_number(SLAVE_LIMIT),
        master_force_rate_n_per_s: values.optional_number(MASTER_RATE),
        slave_command_rate_per_s: values.optional_number(SLAVE_RATE),
        master_lag_s: values.number(MASTER_LAG)?,
        slave_lag_s: values.number(SLAVE_LAG)?,
    };
    let lags = [(MASTER_LAG, limits.master_lag_s), (SLAVE_LAG, limits.slave_lag_s)];
    let given = [MASTER_LIMIT, SLAVE_LIMIT, MASTER_RATE, SLAVE_RATE].into_iter().find(|key| values.is_given(key));
    let lagging = lags.into_iter().find(|(_, lag_s)| *lag_s > 0.0).map(|(key, _)| key);
    let slows_slave = limits.slave_lag_s > 0.0 || limits.slave_command.or(limits.slave_command_rate_per_s).is_some();
    if slows_slave && values.number(COMPLIANCE)? > 0.0 {
        let message =
            format!("{COMPLIANCE} acts like a change of the slave's command, which its motor is to pass whole");
        return Err(values.error(COMPLIANCE, message).remedy("leave it out, or the slave's limits and lag"));
    }
    let (key, reason, limit) = match (given, lagging, timing) {
        (Some(key), _, ControlTiming::Continuous) => {
            let unknown = "when a continuous controller saturates between two ticks is not known, so that the tick could not \
                           be stepped exactly";
            (key, unknown, "limit")
        }
        (_, Some(key), ControlTiming::Continuous) => {
            (key, "a motor's lag is stepped under a command that is held from tick to tick", "lag")
        }
        _ => return Ok(limits),
    };
    let message = format!("{key} needs simulation.control = \"sampled\": {reason}");
    Err(values.error(key, message).remedy(format!("set simulation.control = \"sampled\", or leave the {limit} out")))
}

/// The sensors' settings.
pub(super) fn sensor(values: &Values) -> Result<SensorSettings, ScenarioError> {
    Ok(SensorSettings {
        force_bias_n: values.number("sensor.force_bias_n")?,
        force_bandwidth_hz: values.number("sensor.force_bandwidth_hz")?,
        force_noise_std_n: values.number("sensor.force_noise_std_n")?,
        force_resolution_n: values.number("sensor.force_resolution_n")?,
        force_range_n: values.optional_number("sensor.force_range_n"),
        position_resolution_m: values.number("sensor.position_resolution_m")?,
    })
}

/// The estimator's settings.
pub(super) fn estimator(values: &mut Values) -> Result<RlsSettings, ScenarioError> {
    let normalisation = values.number("estimator.normalisation")?;
    let initial_gain = values.optional_number("estimator.initial_gain").unwrap_or(if normalisation > 0.0 {
        10.0 * normalisation
    } else {
        1e4
    });
    let memory = if normalisation > 0.0 { 10.0 / normalisation } else { 5e-4 };
    let reset_threshold = values.optional_number("estimator.reset_threshold").unwrap_or(2.0 / initial_gain + memory);
    values.derive_if_missing("estimator.initial_gain", Value::Number(initial_gain));
    values.derive_if_missing("estimator.reset_threshold", Value::Number(reset_threshold));
    let dead_zone_n = values.number("estimator.dead_zone_n")?;
    let word = values.text("estimator.parameters")?;
    let index = PARAMETERS.iter().position(|known| *known == word).unwrap_or(0);
    let forgetting = match values.text("estimator.forgetting")? {
        "exponential" => Forgetting::Exponential { factor: values.number("estimator.forgetting_factor")? },
        _ => Forgetting::Resetting,
    };
    Ok(RlsSettings {
        initial_gain,
        reset_threshold,
        dead_zone_n,
        normalisation,
        parameters: Parameters::ALL[index],
        forgetting,
        friction: FrictionShape {
            speed_m_per_s: values.number("estimator.friction_speed_m_per_s")?,
            length_m: values.number("estimator.friction_length_m")?,
        },
    })
}

/// The detector's settings.
pub(super) fn detector(values: &mut Values) -> Result<DetectorSettings, ScenarioError> {
    let word = values.text("detector.distance")?;
    let index = DISTANCES.iter().position(|known| *known == word).unwrap_or(0);
    let kind = DistanceKind::ALL[index];
    let hypotheses = Hypotheses {
        quiet_std_n: values.number("detector.quiet_std_n")?,
        rupture_std_n: values.number("detector.rupture_std_n")?,
        rupture_mean_n: values.number("detector.rupture_mean_n")?,
        stiffness_change_n_per_m: values.number("detector.stiffness_change_n_per_m")?,
    };
    hypotheses.validate().map_err(|error| values.out_of_range(&error))?;
    let (threshold, drift) = hypotheses.tuning(kind);
    let threshold = values.optional_number("detector.threshold").unwrap_or(threshold);
    let drift = values.optional_number("detector.drift").unwrap_or(drift);
    let cap = values.optional_number("detector.cap").unwrap_or(10.0 * threshold);
    values.derive_if_missing("detector.threshold", Value::Number(threshold));
    values.derive_if_missing("detector.drift", Value::Number(drift));
    values.derive_if_missing("detector.cap", Value::Number(cap));
    Ok(DetectorSettings {
        distance: DistanceSettings {
            kind,
            hypotheses,
            window_samples: values.whole("detector.window_samples")? as usize,
        },
        cusum: CusumSettings { threshold, drift, cap },
        arming: ArmingSettings {
            settle_s: values.number("detector.settle_s")?,
            drop_only: values.flag("detector.drop_only")?,
            motion: match values.text("detector.motion")? {
                "any" => Motion::Any,
                "inserting" => Motion::Inserting,
                _ => Motion::NotWithdrawn,
            },
            withdrawal_speed_m_per_s: values.number("detector.withdrawal_speed_m_per_s")?,
            insertion_speed_m_per_s: values.number("detector.insertion_speed_m_per_s")?,
            minimum_depth_m: values.number("detector.minimum_depth_m")?,
        },
    })
}

/// The supervisor's settings.
pub(super) fn augmentation(values: &Values) -> Result<AugmentationSettings, ScenarioError> {
    Ok(AugmentationSettings {
        enabled: values.flag("augmentation.enabled")?,
        automaton: AutomatonSettings {
            min_hold_s: values.number("augmentation.min_hold_s")?,
            max_hold_s: values.number("augmentation.max_hold_s")?,
            exit_ratio: values.number("augmentation.exit_ratio")?,
            exit_quiet_s: values.number("augmentation.exit_quiet_s")?,
            refractory_s: values.number("augmentation.refractory_s")?,
        },
        freeze: match values.text("augmentation.freeze")? {
            "reference" => Freeze::Reference,
            _ => Freeze::Measured,
        },
        reengage: match values.text("augmentation.reengage")? {
            "clutch" => Reengage::Clutch,
            "snap" => Reengage::Snap,
            _ => Reengage::Ramp { catch_up_speed_m_per_s: values.number("augmentation.catch_up_speed_m_per_s")? },
        },
        force: match values.text("augmentation.force_law")? {
            "amplify" => ForceLawSettings::Amplify { gain: values.number("augmentation.amplification")? },
            _ => ForceLawSettings::Decay {
                ratio: values.number("augmentation.decay_ratio")?,
                time_constant_s: values.number("augmentation.decay_time_constant_s")?,
            },
        },
        blend_s: values.number("augmentation.blend_s")?,
    })
}
