//! Parts of a scenario that the guarantee of its passivity scheme, `E_m - E_s >= -E_0`, does not cover.

use trocar_core::settings::KeySource as _;

use trocar_base::warning::{Code, Warning};
use trocar_engine::plant::Coupling;
use trocar_engine::teleoperation::Scheme;
use trocar_scenario::{Scenario, TissueSpec};

/// Key, sentence, remedy.
type Gap = (&'static str, String, &'static str);

/// The energy may nevertheless stay within the bound; a run measures it.
pub fn promise_gaps(scenario: &Scenario) -> Vec<Warning> {
    if scenario.link.passivity.scheme == Scheme::None {
        return vec![];
    }
    let gaps = [actuators(scenario), compliance(scenario), coupling(scenario), sensors(scenario), tissue(scenario)];
    let warning = |(key, reason, remedy): Gap| {
        Warning::new(Code::PromiseNotCovered, format!("the scheme's promise does not cover this scenario: {reason}"))
            .of(&scenario.name)
            .at(key)
            .remedy(remedy)
    };
    gaps.into_iter().flatten().map(warning).collect()
}

fn actuators(scenario: &Scenario) -> Option<Gap> {
    (!scenario.actuators.are_none()).then(|| {
        let reason = "motors that saturate or lag do not brake as the scheme expects".to_owned();
        ("actuator", reason, "remove [actuator], or look at the energies of a run")
    })
}

fn compliance(scenario: &Scenario) -> Option<Gap> {
    (scenario.link.machines.compliance_m_per_n > 0.0).then(|| {
        let reason = "the tissue moves the slave, which the scheme does not expect".to_owned();
        ("slave.compliance_m_per_n", reason, "set slave.compliance_m_per_n to 0")
    })
}

fn coupling(scenario: &Scenario) -> Option<Gap> {
    (scenario.master.coupling == Coupling::AsPrinted).then(|| {
        let reason = "the hand does not act on the master, which is unstable by itself".to_owned();
        ("master.coupling", reason, "couple the hand to the master")
    })
}

fn sensors(scenario: &Scenario) -> Option<Gap> {
    let sensor = &scenario.sensor;
    (!(sensor.reads_force_exactly() && sensor.reads_position_exactly())).then(|| {
        let reason = "it holds for the measured force and position, and the sensors are not ideal".to_owned();
        ("sensor", reason, "a run compares the true energy with the promise")
    })
}

fn tissue(scenario: &Scenario) -> Option<Gap> {
    let bound = scenario.link.passivity.catch_up.max_stiffness_n_per_m;
    let (key, reason, remedy) = match &scenario.tissue {
        TissueSpec::Recording { .. } => (
            "tissue.index",
            "a force that is replayed by time does not depend on the needle".to_owned(),
            "replay the recording by depth",
        ),
        TissueSpec::Model(_) => {
            let stiffness = scenario.values().optional_number("tissue.stiffness_n_per_m").unwrap_or(0.0);
            if stiffness <= bound {
                return None;
            }
            (
                "passivity.max_stiffness_n_per_m",
                format!("the tissue has {stiffness} N/m, and the promise holds up to {bound} N/m"),
                "raise passivity.max_stiffness_n_per_m",
            )
        }
        TissueSpec::Depth { .. } => return None,
    };
    Some((key, reason, remedy))
}
