//! The keys of what couples the machines: scales, architecture, channel, passivity.

use trocar_core::settings::{Fallback, Key, Kind, Range as R};

use crate::teleoperation::{ControllerKind, ControllerSettings, PassivitySettings, Recovery, RecoverySettings, Scheme};

const CONTROLLER: ControllerSettings = ControllerSettings::PAPER;
const RECOVERY: RecoverySettings = RecoverySettings::DEFAULT;
const PASSIVITY: PassivitySettings = PassivitySettings::NONE;

/// What stands among the slave's keys.
pub(super) const SLAVE_KEYS: &[Key] = &[Key::number(
    "slave.compliance_m_per_n",
    R::NON_NEGATIVE,
    0.0,
    "How far the tissue pushes the resting slave off its reference; the paper's is stiff.",
)];

pub(super) const KEYS: &[Key] = &[
    // scaling
    Key::number("scaling.force", R::SCALE, 1.0, "Force fed back per force measured."),
    Key::number("scaling.position", R::SCALE, 1.0, "Slave's motion per master's."),
    // controller
    Key::choice(
        "controller.kind",
        ControllerKind::WORDS,
        "position-force",
        "The paper's; with local force feedback; a spring between the machines; all of it, transparent (Lawrence 1993).",
    ),
    Key::number(
        "controller.coupling_stiffness_n_per_m",
        R::NON_NEGATIVE,
        CONTROLLER.position_position.coupling_stiffness_n_per_m,
        "Spring between the machines (position-position, four-channel).",
    ),
    Key::number(
        "controller.coupling_damping_n_s_per_m",
        R::NON_NEGATIVE,
        CONTROLLER.position_position.coupling_damping_n_s_per_m,
        "Damper beside it.",
    ),
    Key::number(
        "controller.master_force_gain",
        R::NON_NEGATIVE,
        CONTROLLER.local_force.master_force_gain,
        "C_6, the master's local force feedback (local-force, four-channel): its mass feels 1 + C_6 times smaller.",
    ),
    Key::number(
        "controller.slave_force_gain",
        R::NON_NEGATIVE,
        CONTROLLER.local_force.slave_force_gain,
        "C_5, the slave's, in commands U_s per N (local-force, four-channel): it yields to the tissue.",
    ),
    Key::number(
        "controller.acceleration_bandwidth_hz",
        R::POSITIVE,
        CONTROLLER.four_channel.acceleration_bandwidth_hz,
        "Bandwidth of the accelerations that four-channel sends.",
    ),
    // channel
    Key::number(
        "channel.forward_delay_s",
        R::NON_NEGATIVE,
        0.0,
        "From master to slave, of any length; a sampled controller reads what has arrived by its tick.",
    ),
    Key::number("channel.backward_delay_s", R::NON_NEGATIVE, 0.0, "From slave to master, of any length."),
    Key::number(
        "channel.jitter_s",
        R::NON_NEGATIVE,
        0.0,
        "Greatest further delay of a sample, drawn anew for each, either way; what arrives after a later one is dropped.",
    ),
    Key::number(
        "channel.loss",
        R::SHARE,
        0.0,
        "Probability that a sample is lost, either way; the receiver holds the last one.",
    ),
    Key::numbers(
        "channel.outages_s",
        &[],
        "When the link is dead, in pairs, as in [2.0, 2.5]: what is sent from a begin to before its end never arrives.",
    ),
    Key::new(
        "channel.delays_file",
        Kind::File,
        Fallback::Unset,
        "A CSV file of logged delays, for forward_delay_s and backward_delay_s at 0: from each time_s on, counted from the \
         run's start, what is sent takes as long as its columns of those names say, to the nearest tick; where one is empty \
         or lost, it never arrives.",
    ),
    Key::number(
        "channel.outage_s",
        R::NON_NEGATIVE,
        RECOVERY.outage_s,
        "How long no sample has to come for an outage.",
    ),
    Key::choice(
        "channel.recovery",
        Recovery::WORDS,
        "ramp",
        "After an outage the slave runs to the hand, keeps the distance that has opened, or stays for good.",
    ),
    Key::number(
        "channel.recovery_speed_m_per_s",
        R::POSITIVE,
        RECOVERY.speed_m_per_s,
        "Greatest speed of the slave's reference while it runs to the hand.",
    ),
    Key::number(
        "channel.recovery_force_rate_n_per_s",
        R::POSITIVE,
        RECOVERY.force_rate_n_per_s,
        "Greatest rate of the fed-back force while it runs to the live one.",
    ),
    // passivity
    Key::choice(
        "passivity.scheme",
        Scheme::WORDS,
        "none",
        "Observer and controller at both ports (Hannaford and Ryu 2002), wave variables (Niemeyer and Slotine 1991), \
         a tank of energy on each side (Franken et al. 2011).",
    ),
    Key::number(
        "passivity.budget_j",
        R::NON_NEGATIVE,
        PASSIVITY.time_domain.budget_j,
        "Energy that each port may give before it has received any (time-domain).",
    ),
    Key::number(
        "passivity.damping_limit_n_s_per_m",
        R::NON_NEGATIVE,
        PASSIVITY.limits.damping_limit_n_s_per_m,
        "Greatest damping added at the master (time-domain, energy-tank).",
    ),
    Key::number(
        "passivity.wave_impedance_n_s_per_m",
        R::POSITIVE,
        PASSIVITY.waves.wave_impedance_n_s_per_m,
        "b of the waves (wave-variables).",
    ),
    Key::number("passivity.tank_level_j", R::POSITIVE, PASSIVITY.tank.tank_level_j, "Level of each tank."),
    Key::number(
        "passivity.tank_share",
        R::POSITIVE_SHARE,
        PASSIVITY.tank.tank_share,
        "Share of its energy that a tank sends to the other each tick, below 1.",
    ),
    Key::number(
        "passivity.catch_up_speed_m_per_s",
        R::POSITIVE,
        PASSIVITY.limits.catch_up_speed_m_per_s,
        "Speed at which a slave that was held back catches up (time-domain, energy-tank).",
    ),
];
