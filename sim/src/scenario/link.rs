//! From values to what joins the plants.

use trocar_core::settings::Source as _;

use super::error::ScenarioError;
use super::values::Values;
use crate::plant::{Coupling, Damping, MasterParameters, PlantError, SlaveParameters};
use crate::teleoperation::{
    ControllerKind, ControllerSettings, CouplingSettings, FourChannelSettings, LimitSettings, LinkSettings,
    LocalForceSettings, Machines, PassivitySettings, Recovery, RecoverySettings, Scheme, TankSettings,
    TimeDomainSettings, WavesSettings,
};

/// The architecture, the recovery and the passivity around two machines.
pub(super) fn link_settings(
    values: &Values,
    master: &MasterParameters,
    slave: &SlaveParameters,
) -> Result<LinkSettings, ScenarioError> {
    let controller = controller(values)?;
    let passivity = passivity(values)?;
    agree(values, (controller.kind, passivity.scheme), master, slave)?;
    let (slave_drag, slave_inertia) = if controller.kind.models_slave() {
        slave.slow_motion().map_err(|error| match error {
            PlantError::Parameter(invalid) => values.out_of_range(&invalid),
            other => values.error("slave.numerator", other.to_string()),
        })?
    } else {
        (0.0, 0.0)
    };
    let machines = Machines {
        master_mass_kg: master.mass_kg,
        master_damping_n_s_per_m: master.damping_n_s_per_m,
        proportional_gain: slave.proportional_gain,
        velocity_gain: slave.velocity_gain,
        slave_drag,
        slave_inertia,
        compliance_m_per_n: values.number("slave.compliance_m_per_n")?,
        position_scale: values.number("scaling.position")?,
        force_scale: values.number("scaling.force")?,
    };
    Ok(LinkSettings { controller, machines, recovery: recovery(values)?, passivity })
}

/// The kind that the word at `path` stands for.
fn kind<T>(values: &Values, path: &str, from_word: fn(&str) -> Option<T>) -> Result<T, ScenarioError> {
    let word = values.text(path)?;
    from_word(word).ok_or_else(|| values.error(path, format!("{path} = {word:?} is unknown")))
}

fn controller(values: &Values) -> Result<ControllerSettings, ScenarioError> {
    Ok(ControllerSettings {
        kind: kind(values, "controller.kind", ControllerKind::from_word)?,
        local_force: LocalForceSettings {
            master_force_gain: values.number("controller.master_force_gain")?,
            slave_force_gain: values.number("controller.slave_force_gain")?,
        },
        position_position: CouplingSettings {
            coupling_stiffness_n_per_m: values.number("controller.coupling_stiffness_n_per_m")?,
            coupling_damping_n_s_per_m: values.number("controller.coupling_damping_n_s_per_m")?,
        },
        four_channel: FourChannelSettings {
            acceleration_bandwidth_hz: values.number("controller.acceleration_bandwidth_hz")?,
        },
    })
}

fn recovery(values: &Values) -> Result<RecoverySettings, ScenarioError> {
    Ok(RecoverySettings {
        policy: kind(values, "channel.recovery", Recovery::from_word)?,
        outage_s: values.number("channel.outage_s")?,
        speed_m_per_s: values.number("channel.recovery_speed_m_per_s")?,
        force_rate_n_per_s: values.number("channel.recovery_force_rate_n_per_s")?,
    })
}

fn passivity(values: &Values) -> Result<PassivitySettings, ScenarioError> {
    Ok(PassivitySettings {
        scheme: kind(values, "passivity.scheme", Scheme::from_word)?,
        limits: LimitSettings {
            damping_limit_n_s_per_m: values.number("passivity.damping_limit_n_s_per_m")?,
            catch_up_speed_m_per_s: values.number("passivity.catch_up_speed_m_per_s")?,
        },
        time_domain: TimeDomainSettings { budget_j: values.number("passivity.budget_j")? },
        waves: WavesSettings { wave_impedance_n_s_per_m: values.number("passivity.wave_impedance_n_s_per_m")? },
        tank: TankSettings {
            tank_level_j: values.number("passivity.tank_level_j")?,
            tank_share: values.number("passivity.tank_share")?,
        },
    })
}

/// Checks that architecture, scheme and machines go together.
fn agree(
    values: &Values,
    (kind, scheme): (ControllerKind, Scheme),
    master: &MasterParameters,
    slave: &SlaveParameters,
) -> Result<(), ScenarioError> {
    if kind.couples_positions() && !scheme.carries_positions() {
        let message = "waves carry a velocity and a force; this controller.kind sends positions back as well";
        let remedy = "use controller.kind = \"position-force\" or \"local-force\", or another passivity.scheme";
        return Err(values.error("passivity.scheme", message).remedy(remedy));
    }
    if kind != ControllerKind::PositionForce && master.coupling == Coupling::AsPrinted {
        let message = "a master on which the hand does not act has only the paper's controller";
        let remedy = "use master.coupling = \"physical\", or controller.kind = \"position-force\"";
        return Err(values.error("master.coupling", message).remedy(remedy));
    }
    if kind.models_slave() && slave.damping == Damping::AsPrinted {
        let message = format!("{} makes the slave follow by damping its velocity", kind.word());
        return Err(values.error("slave.damping", message).remedy("use slave.damping = \"velocity\""));
    }
    for key in ["scaling.position", "scaling.force"] {
        if values.number(key)? == 0.0 && (kind != ControllerKind::PositionForce || scheme != Scheme::None) {
            let message = format!("{key} is 0, must be above 0 for this controller.kind or passivity.scheme");
            return Err(values
                .error(key, message)
                .remedy("a scale of 0 opens the loop: use position-force, no scheme"));
        }
    }
    Ok(())
}
