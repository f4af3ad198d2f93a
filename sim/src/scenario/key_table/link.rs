//! The keys of what couples the machines: scales, architecture, channel, passivity.

use super::key;
use crate::scenario::keys::{Fallback, Key};
use crate::scenario::value::{Kind, Range as R, Value};
use crate::teleoperation::{
    ControllerKind, ControllerSettings, PassivitySettings, Recovery, RecoverySettings, Scheme,
};
use Fallback::Unset;
use Kind::{Choice, File, Number, Numbers};

const CONTROLLER: ControllerSettings = ControllerSettings::PAPER;
const RECOVERY: RecoverySettings = RecoverySettings::DEFAULT;
const PASSIVITY: PassivitySettings = PassivitySettings::NONE;

pub(super) const KEYS: &[Key] = &[
    // scaling
    key("scaling.force", Number(R::SCALE), number!(1.0), "Force fed back per force measured."),
    key("scaling.position", Number(R::SCALE), number!(1.0), "Slave's motion per master's."),
    // controller
    key(
        "controller.kind",
        Choice(ControllerKind::WORDS),
        word!("position-force"),
        "The paper's; with local force feedback; a spring between the machines; all of it, transparent (Lawrence 1993).",
    ),
    key(
        "controller.coupling_stiffness_n_per_m",
        Number(R::NON_NEGATIVE),
        number!(CONTROLLER.position_position.coupling_stiffness_n_per_m),
        "Spring between the machines (position-position, four-channel).",
    ),
    key(
        "controller.coupling_damping_n_s_per_m",
        Number(R::NON_NEGATIVE),
        number!(CONTROLLER.position_position.coupling_damping_n_s_per_m),
        "Damper beside it.",
    ),
    key(
        "controller.master_force_gain",
        Number(R::NON_NEGATIVE),
        number!(CONTROLLER.local_force.master_force_gain),
        "C_6, the master's local force feedback (local-force, four-channel): its mass feels 1 + C_6 times smaller.",
    ),
    key(
        "controller.slave_force_gain",
        Number(R::NON_NEGATIVE),
        number!(CONTROLLER.local_force.slave_force_gain),
        "C_5, the slave's, in commands U_s per N (local-force, four-channel): it yields to the tissue.",
    ),
    key(
        "controller.acceleration_bandwidth_hz",
        Number(R::POSITIVE),
        number!(CONTROLLER.four_channel.acceleration_bandwidth_hz),
        "Bandwidth of the accelerations that four-channel sends.",
    ),
    // channel
    key(
        "channel.forward_delay_s",
        Number(R::NON_NEGATIVE),
        number!(0.0),
        "From master to slave, of any length; a sampled controller reads what has arrived by its tick.",
    ),
    key("channel.backward_delay_s", Number(R::NON_NEGATIVE), number!(0.0), "From slave to master, of any length."),
    key(
        "channel.jitter_s",
        Number(R::NON_NEGATIVE),
        number!(0.0),
        "Greatest further delay of a sample, drawn anew for each, either way; what arrives after a later one is dropped.",
    ),
    key(
        "channel.loss",
        Number(R::SHARE),
        number!(0.0),
        "Probability that a sample is lost, either way; the receiver holds the last one.",
    ),
    key(
        "channel.outages_s",
        Numbers,
        Fallback::Value(|| Value::Numbers(vec![])),
        "When the link is dead, in pairs, as in [2.0, 2.5]: what is sent from a begin to before its end never arrives.",
    ),
    key(
        "channel.delays_file",
        File,
        Unset,
        "A CSV file of logged delays, for forward_delay_s and backward_delay_s at 0: from each time_s on, counted from the \
         run's start, what is sent takes as long as its columns of those names say, to the nearest tick; where one is empty \
         or lost, it never arrives.",
    ),
    key(
        "channel.outage_s",
        Number(R::NON_NEGATIVE),
        number!(RECOVERY.outage_s),
        "How long no sample has to come for an outage.",
    ),
    key(
        "channel.recovery",
        Choice(Recovery::WORDS),
        word!("ramp"),
        "After an outage the slave runs to the hand, keeps the distance that has opened, or stays for good.",
    ),
    key(
        "channel.recovery_speed_m_per_s",
        Number(R::POSITIVE),
        number!(RECOVERY.speed_m_per_s),
        "Greatest speed of the slave's reference while it runs to the hand.",
    ),
    key(
        "channel.recovery_force_rate_n_per_s",
        Number(R::POSITIVE),
        number!(RECOVERY.force_rate_n_per_s),
        "Greatest rate of the fed-back force while it runs to the live one.",
    ),
    // passivity
    key(
        "passivity.scheme",
        Choice(Scheme::WORDS),
        word!("none"),
        "Observer and controller at both ports (Hannaford and Ryu 2002), wave variables (Niemeyer and Slotine 1991), \
         a tank of energy on each side (Franken et al. 2011).",
    ),
    key(
        "passivity.budget_j",
        Number(R::NON_NEGATIVE),
        number!(PASSIVITY.time_domain.budget_j),
        "Energy that each port may give before it has received any (time-domain).",
    ),
    key(
        "passivity.damping_limit_n_s_per_m",
        Number(R::NON_NEGATIVE),
        number!(PASSIVITY.limits.damping_limit_n_s_per_m),
        "Greatest damping added at the master (time-domain, energy-tank).",
    ),
    key(
        "passivity.wave_impedance_n_s_per_m",
        Number(R::POSITIVE),
        number!(PASSIVITY.waves.wave_impedance_n_s_per_m),
        "b of the waves (wave-variables).",
    ),
    key("passivity.tank_level_j", Number(R::POSITIVE), number!(PASSIVITY.tank.tank_level_j), "Level of each tank."),
    key(
        "passivity.tank_share",
        Number(R::POSITIVE_SHARE),
        number!(PASSIVITY.tank.tank_share),
        "Share of its energy that a tank sends to the other each tick, below 1.",
    ),
    key(
        "passivity.catch_up_speed_m_per_s",
        Number(R::POSITIVE),
        number!(PASSIVITY.limits.catch_up_speed_m_per_s),
        "Speed at which a slave that was held back catches up (time-domain, energy-tank).",
    ),
];
