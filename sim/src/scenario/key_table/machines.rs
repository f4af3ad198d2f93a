//! The keys of the machines, their motors and the arm that holds one.

use super::key;
use crate::plant::{MasterParameters, SlaveParameters};
use crate::scenario::keys::{Fallback, Key};
use crate::scenario::value::{Kind, Range as R, Value};
use Fallback::{Derived, Unset};
use Kind::{Choice, Number, Numbers};

pub(super) const KEYS: &[Key] = &[
    // master
    key("master.mass_kg", Number(R::MASS), number!(MasterParameters::default().mass_kg), "Mass."),
    key(
        "master.damping_n_s_per_m",
        Number(R::NON_NEGATIVE),
        number!(MasterParameters::default().damping_n_s_per_m),
        "Damping.",
    ),
    key(
        "master.force_integral_gain",
        Number(R::NON_NEGATIVE),
        Derived("12 as the paper has it; 0 where positions are fed back to the master"),
        "K_i in 1/s.",
    ),
    key(
        "master.coupling",
        Choice(&["physical", "as-printed"]),
        word!("physical"),
        "Whether the hand acts on the master; as printed it does not, and the loop is unstable.",
    ),
    // arm
    key(
        "arm.grip",
        Choice(&["paper", "relaxed", "firm"]),
        word!("paper"),
        "How firmly the hand holds: as the paper identified it, half or twice as stiff.",
    ),
    key(
        "arm.k_a_n_per_m",
        Number(R::NON_NEGATIVE),
        Derived("the grip's; 733 as the paper has it"),
        "Stiffness between arm and master.",
    ),
    key(
        "arm.b_a_n_s_per_m",
        Number(R::NON_NEGATIVE),
        Derived("the grip's; 37.3 as the paper has it"),
        "Damping between arm and master.",
    ),
    key(
        "arm.k_h_n_per_m",
        Number(R::NON_NEGATIVE),
        Derived("the grip's; 14998 as the paper has it"),
        "Stiffness between desired position and arm.",
    ),
    key(
        "arm.b_h_n_s_per_m",
        Number(R::NON_NEGATIVE),
        Derived("the grip's; 178 as the paper has it"),
        "Damping between desired position and arm.",
    ),
    key("arm.m_h_kg", Number(R::MASS), Derived("the grip's; 1.88 as the paper has it"), "Mass of the arm."),
    // slave
    key(
        "slave.numerator",
        Numbers,
        Fallback::Value(|| Value::Numbers(SlaveParameters::default().numerator)),
        "Of X_e / U_s, highest power first.",
    ),
    key(
        "slave.denominator",
        Numbers,
        Fallback::Value(|| Value::Numbers(SlaveParameters::default().denominator)),
        "Of X_e / U_s, highest power first; degree 2 or 3.",
    ),
    key(
        "slave.proportional_gain",
        Number(R::NON_NEGATIVE),
        number!(SlaveParameters::default().proportional_gain),
        "K_p.",
    ),
    key("slave.velocity_gain", Number(R::NON_NEGATIVE), number!(SlaveParameters::default().velocity_gain), "K_v."),
    key(
        "slave.damping",
        Choice(&["velocity", "as-printed"]),
        word!("velocity"),
        "What K_v acts on; as printed it is the position.",
    ),
    key(
        "slave.compliance_m_per_n",
        Number(R::NON_NEGATIVE),
        number!(0.0),
        "How far the tissue pushes the resting slave off its reference; the paper's is stiff.",
    ),
    // actuator
    key(
        "actuator.master_force_limit_n",
        Number(R::POSITIVE),
        Unset,
        "Greatest force U_m of the master's motor, either way; without a limit when not given.",
    ),
    key(
        "actuator.slave_command_limit",
        Number(R::POSITIVE),
        Unset,
        "Greatest command U_s to the slave, either way, in its own unit; without a limit when not given.",
    ),
    key(
        "actuator.master_force_rate_limit_n_per_s",
        Number(R::POSITIVE),
        Unset,
        "How fast the commanded force of the master's motor changes at most; without a limit when not given.",
    ),
    key(
        "actuator.slave_command_rate_limit_per_s",
        Number(R::POSITIVE),
        Unset,
        "How fast the command to the slave changes at most, in its unit per s; without a limit when not given.",
    ),
    key(
        "actuator.master_lag_s",
        Number(R::NON_NEGATIVE),
        number!(0.0),
        "Time constant with which the master's motor follows its command, first-order; 0: no lag.",
    ),
    key(
        "actuator.slave_lag_s",
        Number(R::NON_NEGATIVE),
        number!(0.0),
        "Time constant with which the slave's motor follows its command, first-order; 0: no lag.",
    ),
];
