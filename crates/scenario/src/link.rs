use super::error::ScenarioError;
use super::values::Values;
use trocar_engine::plant::{
    Coupling, Damping, MasterModelSettings, MasterParameters, PlantError, SlaveController, SlaveModel, SlaveParameters,
};
use trocar_engine::teleoperation::{
    ComplianceSettings, ControllerKind, ControllerSettings, LinkSettings, Machines, PassivitySettings,
    RecoverySettings, Scales, Scheme,
};

const SLAVE_START: &str = "slave.start_m";

pub(super) fn link_settings(
    values: &mut Values,
    (master, model): (&MasterParameters, &MasterModelSettings),
    slave: &SlaveParameters,
    tick_s: f64,
) -> Result<LinkSettings, ScenarioError> {
    let controller = ControllerSettings::read(values)?;
    let passivity = PassivitySettings::read(values)?;
    let scales = Scales::read(values)?;
    check_damping(values, &passivity, master, tick_s)?;
    check_compatible(values, (controller.kind, passivity.scheme, scales), (master, model), slave)?;
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
        compliance_m_per_n: ComplianceSettings::read(values)?.compliance_m_per_n,
        position_scale: scales.position,
        force_scale: scales.force,
    };
    Ok(LinkSettings { controller, machines, recovery: RecoverySettings::read(values)?, passivity })
}

fn check_general(
    values: &Values,
    (kind, scheme): (ControllerKind, Scheme),
    master: &MasterModelSettings,
    slave: &SlaveParameters,
) -> Result<(), ScenarioError> {
    if !(master.is_general() || slave.is_general()) {
        return Ok(());
    }
    let (key, message) = if kind.models_slave() {
        let message = format!("{} computes forces from the appendix' models", kind.word());
        ("controller.kind", message)
    } else if scheme != Scheme::None {
        let message = format!("{} computes its forces from the appendix' models", scheme.word());
        ("passivity.scheme", message)
    } else {
        return Ok(());
    };
    let (model, controller) = (SlaveModel::Appendix.word(), SlaveController::Appendix.word());
    let remedy = format!(
        "use master.model and slave.model = \"{model}\" with slave.controller = \"{controller}\", or change {key}"
    );
    Err(values.error(key, message).remedy(remedy))
}

fn check_damping(
    values: &Values,
    passivity: &PassivitySettings,
    master: &MasterParameters,
    tick_s: f64,
) -> Result<(), ScenarioError> {
    // A force -d v, held over a tick, changes v to (1 - d T / m) v.
    let bound = 2.0 * master.mass_kg / tick_s;
    let too_large = passivity.held_dampings().into_iter().flatten().find(|(_, damping)| *damping >= bound);
    match too_large {
        None => Ok(()),
        Some((key, damping)) => {
            let message = format!("{key} is {damping}, must be below {bound:.4}, 2 master.mass_kg / simulation.tick_s");
            Err(values
                .error(key, message)
                .remedy("a larger damping, held over a tick, reverses the master's motion and amplifies it"))
        }
    }
}

fn check_compatible(
    values: &Values,
    (kind, scheme, scales): (ControllerKind, Scheme, Scales),
    (master, model): (&MasterParameters, &MasterModelSettings),
    slave: &SlaveParameters,
) -> Result<(), ScenarioError> {
    if kind.couples_positions() && !scheme.carries_positions() {
        let message = "wave variables carry velocity and force only; this controller.kind also sends positions back";
        let others = ControllerKind::ALL.iter().filter(|kind| !kind.couples_positions());
        let others: Vec<_> = others.map(|kind| format!("\"{}\"", kind.word())).collect();
        let remedy = format!("use controller.kind = {}, or another passivity.scheme", others.join(" or "));
        return Err(values.error("passivity.scheme", message).remedy(remedy));
    }
    if kind != ControllerKind::PositionForce && master.coupling == Coupling::AsPrinted {
        let message = "a master without the hand's force supports the paper's controller only";
        let (coupling, kind) = (Coupling::Physical.word(), ControllerKind::PositionForce.word());
        let remedy = format!("use master.coupling = \"{coupling}\", or controller.kind = \"{kind}\"");
        return Err(values.error("master.coupling", message).remedy(remedy));
    }
    check_general(values, (kind, scheme), model, slave)?;
    if scheme != Scheme::None && slave.start_m.is_some() {
        let message = format!("{} needs both sides to start at the same place", scheme.word());
        return Err(values.error(SLAVE_START, message).remedy("remove it, or use passivity.scheme = \"none\""));
    }
    if kind.models_slave() && slave.damping == Damping::AsPrinted {
        let message = format!("{} needs velocity damping of the slave", kind.word());
        return Err(values
            .error("slave.damping", message)
            .remedy(format!("use slave.damping = \"{}\"", Damping::Velocity.word())));
    }
    for (key, scale) in [("scaling.position", scales.position), ("scaling.force", scales.force)] {
        if scale == 0.0 && (kind != ControllerKind::PositionForce || scheme != Scheme::None) {
            let message = format!("{key} is 0, must be above 0 for this controller.kind or passivity.scheme");
            return Err(values
                .error(key, message)
                .remedy("a scale of 0 opens the loop: use position-force without a scheme"));
        }
    }
    Ok(())
}
