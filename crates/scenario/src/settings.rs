use super::error::ScenarioError;
use super::values::Values;
use trocar_engine::plant::{
    ActuatorLimits, ArmParameters, ArmRoles, ControlTiming, Grip, MasterModelSettings, MasterParameters,
    SlaveParameters,
};
use trocar_engine::teleoperation::{ComplianceSettings, ControllerKind};

const MASTER_LIMIT: &str = "actuator.master_force_limit_n";
const COMPLIANCE: &str = "slave.compliance_m_per_n";
const SLAVE_LIMIT: &str = "actuator.slave_command_limit";
const MASTER_RATE: &str = "actuator.master_force_rate_limit_n_per_s";
const SLAVE_RATE: &str = "actuator.slave_command_rate_limit_per_s";
const MASTER_LAG: &str = "actuator.master_lag_s";
const SLAVE_LAG: &str = "actuator.slave_lag_s";

pub(super) fn master(values: &mut Values) -> Result<MasterParameters, ScenarioError> {
    let couples_positions = ControllerKind::read(values)?.couples_positions();
    MasterParameters::read(values, couples_positions)
}

/// Keys override the values from grip and roles.
pub(super) fn arm(values: &mut Values) -> Result<ArmParameters, ScenarioError> {
    let grip = Grip::read(values)?;
    let roles = ArmRoles::read(values)?;
    ArmParameters::read(values, grip, roles)
}

pub(super) fn actuators(
    values: &mut Values,
    timing: ControlTiming,
    (master, slave): (&MasterModelSettings, &SlaveParameters),
) -> Result<ActuatorLimits, ScenarioError> {
    let limits = ActuatorLimits::read(values)?;
    let is_general = master.is_general() || slave.is_general();
    for (key, side, lags) in [
        (MASTER_LAG, "master", master.is_general() && limits.master_lag_s > 0.0),
        (SLAVE_LAG, "slave", is_general && limits.slave_lag_s > 0.0),
    ] {
        if lags {
            let message = format!("{key} acts with the appendix' machines only");
            let remedy = format!("remove it, and describe the lag in {side}.denominator or {side}.a");
            return Err(values.error(key, message).remedy(remedy));
        }
    }
    let lags = [(MASTER_LAG, limits.master_lag_s), (SLAVE_LAG, limits.slave_lag_s)];
    let limiting = [MASTER_LIMIT, SLAVE_LIMIT, MASTER_RATE, SLAVE_RATE].into_iter().find(|key| values.is_given(key));
    let lagging = lags.into_iter().find(|(_, lag_s)| *lag_s > 0.0).map(|(key, _)| key);
    let slows_slave = limits.slave_lag_s > 0.0 || limits.slave_command.or(limits.slave_command_rate_per_s).is_some();
    if slows_slave && ComplianceSettings::read(values)?.compliance_m_per_n > 0.0 {
        let message =
            format!("{COMPLIANCE} acts as a change of the slave's command, which needs a motor without limits and lag");
        return Err(values.error(COMPLIANCE, message).remedy("remove it, or the slave's limits and lag"));
    }
    // General machines' controllers run on the tick.
    let timing = if master.is_general() { ControlTiming::Sampled } else { timing };
    let (key, reason, limit) = match (limiting, lagging, timing) {
        (Some(key), _, ControlTiming::Continuous) => {
            let unknown = "the time at which a continuous controller saturates between two ticks is unknown, so an exact \
                           step is not possible";
            (key, unknown, "limit")
        }
        (_, Some(key), ControlTiming::Continuous) => {
            (key, "the motor's lag is modelled for a command held from tick to tick", "lag")
        }
        (_, _, ControlTiming::Sampled) | (None, None, ControlTiming::Continuous) => return Ok(limits),
    };
    let sampled = format!("simulation.control = \"{}\"", ControlTiming::Sampled.word());
    let message = format!("{key} needs {sampled}: {reason}");
    Err(values.error(key, message).remedy(format!("set {sampled}, or remove the {limit}")))
}
