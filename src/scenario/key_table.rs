//! Every key of a scenario: where it stands, what it holds, its default and its meaning.
//!
//! Validation, the resolved echo, the JSON Schema and the starter file are all read off this one table.

use super::keys::{Fallback, Key};
use super::layer_keys::{LAYERED_COUNT, with_layers, within};
use super::value::{Kind, Range, Value};
use crate::augmentation::{AugmentationSettings, ForceLaw, Reengage};
use crate::detection::{ArmingSettings, Hypotheses, WINDOW_SAMPLES};
use crate::estimation::{Forgetting, FrictionShape, MOST_FORGETTING_FACTOR};
use crate::operator::TremorSettings;
use crate::plant::{MasterParameters, SlaveParameters};
use crate::recording::Limits;
use crate::teleoperation::{ControllerSettings, PassivitySettings, RecoverySettings};
use crate::tissue::{ShaftParameters, literature};

const CONTROLLER: ControllerSettings = ControllerSettings::PAPER;
const RECOVERY: RecoverySettings = RecoverySettings::DEFAULT;
const PASSIVITY: PassivitySettings = PassivitySettings::NONE;

const fn key(path: &'static str, kind: Kind, fallback: Fallback, meaning: &'static str) -> Key {
    Key { path, kind, fallback, meaning }
}

macro_rules! number {
    ($value:expr) => {
        Fallback::Value(|| Value::Number($value))
    };
}

macro_rules! word {
    ($value:expr) => {
        Fallback::Value(|| Value::Text($value.into()))
    };
}

use Fallback::{Derived, Unset};
use Kind::{Choice, File, Flag, Number, Numbers, Sign, Text, Whole};
use Range as R;

/// The sections, in the order in which they are written, with what each is about.
pub const SECTIONS: [(&str, &str); 23] = [
    ("simulation", "How long, how finely, by which engine."),
    ("master", "The machine in the hand (eq. 28) and its force controller (eq. 29)."),
    ("arm", "The arm that holds it (eq. 32-35), in the paper's letters."),
    ("slave", "The machine that holds the needle (eq. 30) and its position controller (eq. 31)."),
    ("actuator", "What the motors of both sides can do; needs simulation.control = \"sampled\"."),
    ("scaling", "What a newton and a millimetre become on the other side."),
    ("controller", "Which of positions and forces go which way."),
    ("channel", "The link between the sides."),
    ("passivity", "What keeps the link from making energy, whatever its delay."),
    ("operator", "What the person wants to do."),
    ("tissue", "What the needle meets."),
    ("tissue.skin", "The first of its layers, for kind = \"layers\"."),
    ("tissue.fat", "The second layer."),
    ("tissue.muscle", "The third layer."),
    ("tissue.capsule", "The fourth layer: the organ's membrane."),
    ("tissue.organ", "The last layer."),
    ("recording", "The recording that operator or tissue replay, and that detect reads."),
    ("recording.columns", "Its columns, by the names in the file's header."),
    ("recording.scale", "The factor that turns each column into SI."),
    ("sensor", "How force and position are measured."),
    ("estimator", "The online estimation of the tissue (eq. 12-18)."),
    ("detector", "The detection of ruptures (eq. 19-27)."),
    ("augmentation", "What happens on a detection (section 5.1)."),
];

/// The distances by the words that scenarios use, in the order of [`crate::detection::DistanceKind::ALL`].
pub const DISTANCES: &[&str] = &[
    "squared-residual",
    "squared-drop",
    "mean-change",
    "variance-change",
    "parameter-change",
    "force-derivative",
    "likelihood-ratio",
    "page-hinkley",
];

/// What is estimated, by the words that scenarios use, in the order of [`crate::estimation::Parameters::ALL`].
pub const PARAMETERS: &[&str] =
    &["stiffness-and-damping", "stiffness", "stiffness-damping-friction", "hunt-crossley", "least-residual"];

/// Every key, in the order in which they are written.
pub const KEYS: &[Key] = &with_layers::<{ UNLAYERED.len() + LAYERED_COUNT }>(UNLAYERED);

/// Every key but those of the layers.
const UNLAYERED: &[Key] = &[
    key(
        "name",
        Text,
        Derived("the file's name without its ending"),
        "Names the run's folder and its lines in figures.",
    ),
    // simulation
    key(
        "simulation.tick_s",
        Number(R::POSITIVE),
        number!(1e-3),
        "Time between two ticks. Estimator and detector count samples: their defaults are for 0.5 to 2 ms.",
    ),
    key(
        "simulation.duration_s",
        Number(R::POSITIVE),
        Derived("the recording's length, or 7 s without one"),
        "Length of the run.",
    ),
    key(
        "simulation.engine",
        Choice(&["exact", "dop853"]),
        word!("exact"),
        "Between ticks: matrix exponentials, or numerical integration as a check.",
    ),
    key(
        "simulation.control",
        Choice(&["continuous", "sampled"]),
        word!("continuous"),
        "Controllers in continuous time, or on the tick with held outputs.",
    ),
    key("simulation.seed", Whole(0), Fallback::Value(|| Value::Whole(1)), "Seed of every random number."),
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
    // scaling
    key("scaling.force", Number(R::SCALE), number!(1.0), "Force fed back per force measured."),
    key("scaling.position", Number(R::SCALE), number!(1.0), "Slave's motion per master's."),
    // controller
    key(
        "controller.kind",
        Choice(&["position-force", "local-force", "position-position", "four-channel"]),
        word!("position-force"),
        "The paper's; with local force feedback; a spring between the machines; all of it, transparent (Lawrence 1993).",
    ),
    key(
        "controller.coupling_stiffness_n_per_m",
        Number(R::NON_NEGATIVE),
        number!(CONTROLLER.coupling_stiffness_n_per_m),
        "Spring between the machines (position-position, four-channel).",
    ),
    key(
        "controller.coupling_damping_n_s_per_m",
        Number(R::NON_NEGATIVE),
        number!(CONTROLLER.coupling_damping_n_s_per_m),
        "Damper beside it.",
    ),
    key(
        "controller.master_force_gain",
        Number(R::NON_NEGATIVE),
        number!(CONTROLLER.master_force_gain),
        "C_6, the master's local force feedback (local-force, four-channel): its mass feels 1 + C_6 times smaller.",
    ),
    key(
        "controller.slave_force_gain",
        Number(R::NON_NEGATIVE),
        number!(CONTROLLER.slave_force_gain),
        "C_5, the slave's, in commands U_s per N (local-force, four-channel): it yields to the tissue.",
    ),
    key(
        "controller.acceleration_bandwidth_hz",
        Number(R::POSITIVE),
        number!(CONTROLLER.acceleration_bandwidth_hz),
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
        Choice(&["ramp", "hold", "give-up"]),
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
        Choice(&["none", "time-domain", "wave-variables", "energy-tank"]),
        word!("none"),
        "Observer and controller at both ports (Hannaford and Ryu 2002), wave variables (Niemeyer and Slotine 1991), \
         a tank of energy on each side (Franken et al. 2011).",
    ),
    key(
        "passivity.budget_j",
        Number(R::NON_NEGATIVE),
        number!(PASSIVITY.budget_j),
        "Energy that each port may give before it has received any (time-domain).",
    ),
    key(
        "passivity.damping_limit_n_s_per_m",
        Number(R::NON_NEGATIVE),
        number!(PASSIVITY.damping_limit_n_s_per_m),
        "Greatest damping added at the master (time-domain, energy-tank).",
    ),
    key(
        "passivity.wave_impedance_n_s_per_m",
        Number(R::POSITIVE),
        number!(PASSIVITY.wave_impedance_n_s_per_m),
        "b of the waves (wave-variables).",
    ),
    key("passivity.tank_level_j", Number(R::POSITIVE), number!(PASSIVITY.tank_level_j), "Level of each tank."),
    key(
        "passivity.tank_share",
        Number(R::POSITIVE_SHARE),
        number!(PASSIVITY.tank_share),
        "Share of its energy that a tank sends to the other each tick, below 1.",
    ),
    key(
        "passivity.catch_up_speed_m_per_s",
        Number(R::POSITIVE),
        number!(PASSIVITY.catch_up_speed_m_per_s),
        "Speed at which a slave that was held back catches up (time-domain, energy-tank).",
    ),
    // operator
    key(
        "operator.kind",
        Choice(&["recording", "ramp", "minimum-jerk", "insertion-extraction", "sine"]),
        word!("recording"),
        "Replays the recording's position, moves at a constant speed or with the least jerk, in and out, or swings.",
    ),
    key(
        "operator.start_m",
        Number(R::ANY),
        number!(0.0),
        "Where a ramp or a movement begins, and the centre of a swing.",
    ),
    key("operator.end_m", Number(R::ANY), number!(0.02), "Where a ramp or a movement ends."),
    key("operator.speed_m_per_s", Number(R::POSITIVE), number!(0.01), "How fast a ramp gets there."),
    key(
        "operator.movement_s",
        Number(R::POSITIVE),
        number!(1.0),
        "How long a minimum-jerk movement or an insertion takes.",
    ),
    key(
        "operator.pushes",
        Whole(1),
        Fallback::Value(|| Value::Whole(1)),
        "In how many pushes, each from rest to rest, an insertion-extraction goes in.",
    ),
    key("operator.hold_s", Number(R::NON_NEGATIVE), number!(1.0), "How long an insertion-extraction rests inside."),
    key(
        "operator.withdrawal_s",
        Number(R::POSITIVE),
        number!(1.0),
        "How long an insertion-extraction takes to come back.",
    ),
    key("operator.amplitude_m", Number(R::ANY), number!(0.002), "Amplitude of a sine."),
    key("operator.frequency_hz", Number(R::POSITIVE), number!(1.0), "Frequency of a sine."),
    key(
        "operator.tremor_amplitude_m",
        Number(R::NON_NEGATIVE),
        number!(TremorSettings::STEADY.amplitude_m),
        "Root mean square of the hand's tremor; usual are tens to hundreds of micrometres.",
    ),
    key(
        "operator.tremor_low_hz",
        Number(R::POSITIVE),
        number!(TremorSettings::STEADY.low_hz),
        "Lower end of the tremor's band.",
    ),
    key(
        "operator.tremor_high_hz",
        Number(R::POSITIVE),
        number!(TremorSettings::STEADY.high_hz),
        "Upper end of the tremor's band.",
    ),
    key(
        "operator.reflex",
        Choice(&["none", "stop", "withdraw"]),
        word!("none"),
        "What the person does, a reaction time after the felt force has fallen: go on, pause, or pause and withdraw.",
    ),
    key(
        "operator.reflex_weber_fraction",
        Number(R::SHARE),
        number!(0.15),
        "By what share of its recent level the felt force has to fall to be noticed.",
    ),
    key("operator.reflex_reaction_min_s", Number(R::NON_NEGATIVE), number!(0.15), "Shortest reaction time."),
    key("operator.reflex_reaction_max_s", Number(R::NON_NEGATIVE), number!(0.25), "Longest reaction time."),
    key("operator.reflex_memory_s", Number(R::POSITIVE), number!(0.05), "Time constant of the recent level."),
    key(
        "operator.reflex_least_force_n",
        Number(R::NON_NEGATIVE),
        number!(0.3),
        "Level below which no fall is noticed.",
    ),
    key("operator.reflex_pause_s", Number(R::NON_NEGATIVE), number!(0.5), "How long the person pauses."),
    key("operator.reflex_withdraw_m", Number(R::NON_NEGATIVE), number!(0.005), "How far they withdraw."),
    key("operator.reflex_withdraw_speed_m_per_s", Number(R::POSITIVE), number!(0.02), "How fast they withdraw."),
    // tissue
    key(
        "tissue.kind",
        Choice(&["recording", "kelvin-voigt", "hunt-crossley", "generalised", "layers"]),
        word!("recording"),
        "Replays the recording's force over time, or answers as a spring and damper, even (eq. 1), stiffening (eq. 2) or \
         varying with depth (eq. 3-4), or as layers that give way.",
    ),
    key(
        "tissue.index",
        Choice(&["time", "depth"]),
        word!("time"),
        "Replay by time, or by depth: then a frozen slave feels a held force.",
    ),
    key(
        "tissue.presliding_m",
        Number(R::POSITIVE),
        number!(2e-3),
        "Travel over which a retreat in a replay by depth turns to the force of the way out.",
    ),
    key("tissue.stiffness_n_per_m", Number(R::NON_NEGATIVE), number!(200.0), "K of kelvin-voigt."),
    key("tissue.damping_n_s_per_m", Number(R::NON_NEGATIVE), number!(5.0), "B of kelvin-voigt."),
    key("tissue.contact_m", Number(R::ANY), number!(0.0), "Surface of every tissue but a recording."),
    key("tissue.mu", Number(R::NON_NEGATIVE), number!(2000.0), "mu of hunt-crossley, in N/m^n."),
    key("tissue.lambda", Number(R::NON_NEGATIVE), number!(200.0), "lambda of hunt-crossley, in N·s/m^(n+1)."),
    key(
        "tissue.power",
        Number(R::NON_NEGATIVE),
        number!(1.5),
        "n of hunt-crossley and generalised, a multiple of 0.25 up to 7.75.",
    ),
    key(
        "tissue.depths_m",
        Numbers,
        Fallback::Value(|| Value::Numbers(vec![0.0, 0.02])),
        "Depths below the surface at which generalised has its coefficients: 1 to 16, ascending; linear between them.",
    ),
    key(
        "tissue.mus",
        Numbers,
        Fallback::Value(|| Value::Numbers(vec![2000.0, 1000.0])),
        "mu of generalised at each depth, at least 0, in N/m^n.",
    ),
    key(
        "tissue.lambdas",
        Numbers,
        Fallback::Value(|| Value::Numbers(vec![200.0, 200.0])),
        "lambda of generalised at each depth, at least 0, in N·s/m^(n+1).",
    ),
    key(
        "tissue.shaft_stiffness_n_per_m",
        Number(within(&literature::SHAFT_STIFFNESS_N_PER_M)),
        number!(ShaftParameters::default().stiffness_n_per_m),
        "sigma of layers: how stiffly the shaft drags tissue along before it slides.",
    ),
    key(
        "tissue.static_ratio",
        Number(within(&literature::STATIC_RATIO)),
        number!(ShaftParameters::default().static_ratio),
        "Static by kinetic friction of the shaft in layers.",
    ),
    key(
        "tissue.stick_speed_m_per_s",
        Number(within(&literature::STICK_SPEED_M_PER_S)),
        number!(ShaftParameters::default().stick_speed_m_per_s),
        "Speed below which the shaft sticks again.",
    ),
    key(
        "tissue.shaft_damping_n_s_per_m2",
        Number(within(&literature::SHAFT_DAMPING_N_S_PER_M2)),
        number!(ShaftParameters::default().damping_n_s_per_m2),
        "Viscous friction of the shaft per length in layers.",
    ),
    // recording
    key("recording.file", File, Unset, "A CSV file, or builtin:in_vivo_like.csv, builtin:own_ctrl_pop.csv."),
    key(
        "recording.ruptures_s",
        Numbers,
        Fallback::Value(|| Value::Numbers(vec![])),
        "When layers rupture, counted from the recording's first sample.",
    ),
    key("recording.force_sign", Sign, number!(1.0), "-1 where the file counts resistance to insertion as negative."),
    key("recording.position_sign", Sign, number!(1.0), "-1 where the file's positions shrink into the tissue."),
    key(
        "recording.velocity_sign",
        Sign,
        Derived("that of the position"),
        "-1 where the file's velocities are negative into the tissue.",
    ),
    key(
        "recording.max_gap_s",
        Number(R::POSITIVE),
        Unset,
        "Longest time between two samples; 10 median intervals when not given.",
    ),
    key(
        "recording.max_bytes",
        Whole(1),
        Fallback::Value(|| Value::Whole(Limits::default().max_bytes)),
        "Largest file that is read.",
    ),
    key(
        "recording.max_samples",
        Whole(2),
        Fallback::Value(|| Value::Whole(Limits::default().max_samples as u64)),
        "Most samples that are kept.",
    ),
    key("recording.columns.time_s", Text, word!("time_s"), "Time."),
    key("recording.columns.position_m", Text, word!("position_m"), "Position of the needle."),
    key(
        "recording.columns.velocity_m_per_s",
        Text,
        Unset,
        "Velocity of the needle; estimated from the position when not given.",
    ),
    key("recording.columns.force_n", Text, word!("force_n"), "Force on the needle."),
    key("recording.scale.time_s", Number(R::POSITIVE), number!(1.0), "To seconds."),
    key(
        "recording.scale.position_m",
        Number(R::POSITIVE),
        number!(1.0),
        "To metres, as 0.075 for the angle of a lever of that length.",
    ),
    key("recording.scale.velocity_m_per_s", Number(R::POSITIVE), number!(1.0), "To metres per second."),
    key("recording.scale.force_n", Number(R::POSITIVE), number!(1.0), "To newtons."),
    // sensor
    key("sensor.force_bias_n", Number(R::ANY), number!(0.0), "What the force reading adds to every force."),
    key(
        "sensor.force_bandwidth_hz",
        Number(R::NON_NEGATIVE),
        number!(0.0),
        "First-order bandwidth of the force reading, ahead of its noise; 0: no lag.",
    ),
    key(
        "sensor.force_noise_std_n",
        Number(R::NON_NEGATIVE),
        number!(0.0),
        "Standard deviation of the white noise on the force.",
    ),
    key(
        "sensor.force_resolution_n",
        Number(R::NON_NEGATIVE),
        number!(0.0),
        "Step of the force reading; 0 reads exactly.",
    ),
    key(
        "sensor.force_range_n",
        Number(R::POSITIVE),
        Unset,
        "Greatest force reading, either way: beyond it readings are clipped; without a limit when not given.",
    ),
    key(
        "sensor.position_resolution_m",
        Number(R::NON_NEGATIVE),
        number!(0.0),
        "Step of the slave's encoder; above 0 the velocity is estimated by a Kalman filter.",
    ),
    key(
        "sensor.acceleration_std_m_per_s2",
        Number(R::POSITIVE),
        number!(0.5),
        "Acceleration that the Kalman filter expects.",
    ),
    // estimator
    key(
        "estimator.parameters",
        Choice(PARAMETERS),
        word!("stiffness-and-damping"),
        "K and B; K alone, as the paper tries in 3.2.1; with friction; mu, lambda and n of eq. 2; or with and without \
         friction, the smaller error counting.",
    ),
    key(
        "estimator.friction_speed_m_per_s",
        Number(R::POSITIVE),
        number!(FrictionShape::DEFAULT.speed_m_per_s),
        "Speed at which half of the friction acts.",
    ),
    key(
        "estimator.friction_length_m",
        Number(R::POSITIVE),
        number!(FrictionShape::DEFAULT.length_m),
        "Depth at which as much of an error is put down to the stiffness as to friction.",
    ),
    key(
        "estimator.forgetting",
        Choice(&["resetting", "exponential"]),
        word!("resetting"),
        "Restore the whole gain at reset_threshold (eq. 17), or forget a little with each correction.",
    ),
    key(
        "estimator.forgetting_factor",
        Number(R::stated(0.0, MOST_FORGETTING_FACTOR, "from 0 to 0.99999, a memory of 1e5 corrections")),
        number!(Forgetting::DEFAULT_FACTOR),
        "How much everything older counts after a correction, for exponential.",
    ),
    key(
        "estimator.normalisation",
        Number(R::NON_NEGATIVE),
        number!(1e6),
        "beta of eq. 14 in 1/m²: the gain no longer depends on depths beyond 1/sqrt(beta); 0: constant weighting.",
    ),
    key(
        "estimator.initial_gain",
        Number(R::POSITIVE),
        Derived("10 times the normalisation, or 1e4 without one"),
        "F_0 of eq. 13, times the identity.",
    ),
    key(
        "estimator.reset_threshold",
        Number(R::POSITIVE),
        Derived("2/initial_gain + 10/normalisation (ten full corrections), or 2/initial_gain + 5e-4 without one"),
        "alpha_0 of eq. 17, at which F_0 is restored.",
    ),
    key(
        "estimator.dead_zone_n",
        Number(R::NON_NEGATIVE),
        number!(0.03),
        "N_0 of eq. 15: smaller errors teach nothing.",
    ),
    key("estimator.contact_m", Number(R::ANY), number!(0.0), "Where the estimator takes the tissue to begin."),
    // detector
    key(
        "detector.distance",
        Choice(DISTANCES),
        word!("squared-residual"),
        "What decides: e², e² of drops, eq. 22, 23, the stiffness of eq. 26, the derivative, GLR or Page-Hinkley.",
    ),
    key(
        "detector.quiet_std_n",
        Number(R::POSITIVE),
        number!(Hypotheses::default().quiet_std_n),
        "sigma_0: spread of the residual when nothing happens.",
    ),
    key(
        "detector.rupture_std_n",
        Number(R::POSITIVE),
        number!(Hypotheses::default().rupture_std_n),
        "sigma_1: its spread after a rupture.",
    ),
    key(
        "detector.rupture_mean_n",
        Number(R::ANY),
        number!(Hypotheses::default().rupture_mean_n),
        "m_1 of eq. 22: its mean after a rupture.",
    ),
    key(
        "detector.stiffness_change_n_per_m",
        Number(R::POSITIVE),
        number!(Hypotheses::default().stiffness_change_n_per_m),
        "Correction of the stiffness that a rupture causes, for eq. 26.",
    ),
    key(
        "detector.window_samples",
        Whole(1),
        Fallback::Value(|| Value::Whole(WINDOW_SAMPLES as u64)),
        "How many samples the likelihood ratio looks back over, at most 64.",
    ),
    key(
        "detector.threshold",
        Number(R::POSITIVE),
        Derived("what one sample of a rupture adds; 1.98e-2 N² for the paper's variances"),
        "gamma: an alarm when g exceeds it, in the distance's unit.",
    ),
    key(
        "detector.drift",
        Number(R::ANY),
        Derived("halfway between the hypotheses; 2.02e-2 N² for the paper's variances"),
        "nu, taken off each sample (eq. 27), in the distance's unit.",
    ),
    key("detector.cap", Number(R::POSITIVE), Derived("ten thresholds"), "Largest value of g, in the distance's unit."),
    key(
        "detector.settle_s",
        Number(R::NON_NEGATIVE),
        number!(ArmingSettings::default().settle_s),
        "Quiet contact before alarms are taken.",
    ),
    key(
        "detector.drop_only",
        Flag,
        Fallback::Value(|| Value::Flag(ArmingSettings::default().drop_only)),
        "Whether only a force below an expected resisting force counts.",
    ),
    key(
        "detector.motion",
        Choice(&["any", "not-withdrawn", "inserting"]),
        word!("not-withdrawn"),
        "During which motion of the needle a drop counts.",
    ),
    key(
        "detector.withdrawal_speed_m_per_s",
        Number(R::NON_NEGATIVE),
        number!(ArmingSettings::default().withdrawal_speed_m_per_s),
        "Nothing counts while the needle is withdrawn faster than this (not-withdrawn).",
    ),
    key(
        "detector.insertion_speed_m_per_s",
        Number(R::NON_NEGATIVE),
        number!(ArmingSettings::default().insertion_speed_m_per_s),
        "Nothing counts while the needle goes in more slowly than this (inserting).",
    ),
    key(
        "detector.minimum_depth_m",
        Number(R::NON_NEGATIVE),
        number!(ArmingSettings::default().minimum_depth_m),
        "Nothing counts less deep below estimator.contact_m than this.",
    ),
    // augmentation
    key(
        "augmentation.enabled",
        Flag,
        Fallback::Value(|| Value::Flag(AugmentationSettings::default().enabled)),
        "false: the classical scheme.",
    ),
    key(
        "augmentation.freeze",
        Choice(&["measured", "reference"]),
        word!("measured"),
        "Hold the slave at its measured position or at its last reference.",
    ),
    key(
        "augmentation.reengage",
        Choice(&["ramp", "clutch", "snap"]),
        word!("ramp"),
        "Close the gap to the hand at a bounded speed, keep it, or jump it.",
    ),
    key(
        "augmentation.catch_up_speed_m_per_s",
        Number(R::POSITIVE),
        number!(default_catch_up_speed()),
        "Speed at which a ramp closes the gap, on top of the hand's.",
    ),
    key(
        "augmentation.force_law",
        Choice(&["decay", "amplify"]),
        word!("decay"),
        "Let the felt force decay, or scale its variation.",
    ),
    key(
        "augmentation.decay_ratio",
        Number(R::SHARE),
        number!(default_decay().0),
        "Where decay ends, as a share of the force at the alarm.",
    ),
    key("augmentation.decay_time_constant_s", Number(R::POSITIVE), number!(default_decay().1), "How fast it decays."),
    key("augmentation.amplification", Number(R::AT_LEAST_ONE), number!(2.0), "kappa of amplify."),
    key(
        "augmentation.blend_s",
        Number(R::NON_NEGATIVE),
        number!(AugmentationSettings::default().blend_s),
        "Length of the cross-fade back to the measured force.",
    ),
    key(
        "augmentation.min_hold_s",
        Number(R::NON_NEGATIVE),
        number!(AugmentationSettings::default().automaton.min_hold_s),
        "Shortest freeze.",
    ),
    key(
        "augmentation.max_hold_s",
        Number(R::NON_NEGATIVE),
        number!(AugmentationSettings::default().automaton.max_hold_s),
        "Longest freeze.",
    ),
    key(
        "augmentation.exit_ratio",
        Number(R::POSITIVE_SHARE),
        number!(AugmentationSettings::default().automaton.exit_ratio),
        "Share of the threshold below which g counts as quiet.",
    ),
    key(
        "augmentation.exit_quiet_s",
        Number(R::NON_NEGATIVE),
        number!(AugmentationSettings::default().automaton.exit_quiet_s),
        "How long g has to be quiet before release.",
    ),
    key(
        "augmentation.refractory_s",
        Number(R::NON_NEGATIVE),
        number!(AugmentationSettings::default().automaton.refractory_s),
        "How long after an event no alarm is taken.",
    ),
];

fn default_catch_up_speed() -> f64 {
    match Reengage::default() {
        Reengage::Ramp { catch_up_speed_m_per_s } => catch_up_speed_m_per_s,
        Reengage::Clutch | Reengage::Snap => 0.03,
    }
}

fn default_decay() -> (f64, f64) {
    match ForceLaw::default() {
        ForceLaw::Decay { ratio, time_constant_s } => (ratio, time_constant_s),
        ForceLaw::Amplify { .. } => (0.0, 0.03),
    }
}
