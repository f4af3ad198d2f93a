use std::fmt::{self, Display, Formatter};

use super::VaryingDelays;
use super::reached::Bounds;
use trocar_engine::channel::Schedule;
use trocar_engine::plant::ActuatorLimits;
use trocar_engine::teleoperation::Scheme;
use trocar_scenario::{Scenario, TissueSpec};

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeftOut {
    pub key: &'static str,
    pub what: &'static str,
    /// The largest magnitude in the loop, in the unit of the key.
    pub bound: Option<f64>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoopLimit {
    /// Holds if the hand is at most as fast and as far from the surface as in the scenario.
    pub part: LeftOut,
    pub limit: f64,
}

impl LoopLimit {
    pub fn is_unreached(&self) -> bool {
        self.part.bound.is_some_and(|bound| bound < self.limit)
    }
}

const JITTER: [&str; 3] =
    ["jitter", "jitter, which can count as an outage", "jitter, without a proof for every order of the delays"];
const VARYING: [&str; 3] = [
    "delays that vary",
    "delays that vary, which can count as an outage",
    "delays that vary, without a proof for every order of them",
];

const TREMOR: &str = "operator.tremor_amplitude_m";

/// Covered by the certificate as an additional force.
pub(crate) const FORCE_STEPS: &str = "sensor.force_resolution_n";

/// Parts that can supply energy or delay. Excludes parts that act only during events.
pub fn left_out(scenario: &Scenario, delays: Option<&VaryingDelays>) -> Vec<LeftOut> {
    left_out_with(scenario, delays, &loop_limits(scenario))
}

/// Takes precomputed [`loop_limits`].
pub fn left_out_with(scenario: &Scenario, delays: Option<&VaryingDelays>, limits: &[LoopLimit]) -> Vec<LeftOut> {
    let reached = limits.iter().filter(|limit| !limit.is_unreached()).map(|limit| limit.part);
    other_parts(scenario, delays).into_iter().chain(reached).collect()
}

fn other_parts(scenario: &Scenario, delays: Option<&VaryingDelays>) -> Vec<LeftOut> {
    let irregularity = &scenario.irregularity;
    let (forward, backward) = (&scenario.forward_schedule, &scenario.backward_schedule);
    let varies = |schedule: &Schedule| schedule.has_delays() && schedule.ages().is_none_or(|(min, max)| min < max);
    let delays_vary = varies(forward) || varies(backward);
    let has_jitter = irregularity.jitter_ticks(scenario.grid.tick_s()) > 0;
    let sensor = &scenario.sensor;
    let (is_covered, why) = match delays {
        None => (false, 0),
        Some(delays) if delays.can_be_outage => (false, 1),
        Some(delays) if !delays.is_proved => (false, 2),
        Some(_) => (true, 0),
    };
    let parts = [
        (scenario.link.passivity.scheme != Scheme::None, "passivity.scheme", "the passivity scheme"),
        (has_jitter && !is_covered, "channel.jitter_s", JITTER[why]),
        (scenario.safety.acts_in_simulation(), "safety.acts", "the limits of the commands"),
        (irregularity.loss > 0.0, "channel.loss", "lost samples"),
        (forward.has_outages() || backward.has_outages(), "channel.outages_s", "outages"),
        (delays_vary && !is_covered, "channel.delays_file", VARYING[why]),
        (scenario.stretch.acts(), "operator.stretch_short_gain_n_s_per_m", "the stretch reflexes"),
        (scenario.stiffening.acts(), "operator.stiffening_per_n", "the grip that stiffens"),
        (!scenario.clutch.is_empty(), "operator.clutch_s", "the clutch"),
        (
            scenario.encoder.encoder_resolution_m > 0.0,
            "master.encoder_resolution_m",
            "the steps of the master's encoder",
        ),
        (sensor.position_resolution_m > 0.0, "sensor.position_resolution_m", "the steps of the position sensor"),
        (sensor.force_resolution_n > 0.0, FORCE_STEPS, "the steps of the force sensor"),
    ];
    present(parts)
}

fn present(parts: impl IntoIterator<Item = (bool, &'static str, &'static str)>) -> Vec<LeftOut> {
    let present = parts.into_iter().filter(|(is_present, ..)| *is_present);
    present.map(|(_, key, what)| LeftOut { key, what, bound: None }).collect()
}

pub fn assumed_passive(scenario: &Scenario) -> Vec<LeftOut> {
    present([
        (scenario.master_model.has_coulomb_friction(), "master.coulomb_friction_n", "the master's Coulomb friction"),
        (scenario.slave.has_coulomb_friction(), "slave.coulomb_friction_n", "the slave's Coulomb friction"),
    ])
}

/// The parts that move the loop without changing its stability.
pub fn inputs(scenario: &Scenario) -> Vec<LeftOut> {
    let falls = match &scenario.tissue {
        TissueSpec::Depth { .. } => true,
        TissueSpec::Model(settings) => !settings.layers().is_empty(),
        TissueSpec::Recording { .. } => false,
    };
    present([
        (falls, "tissue.kind", "the falls of the tissue force, as at a rupture"),
        (scenario.organ_motion.breathing_amplitude_m > 0.0, "tissue.breathing_amplitude_m", "breathing"),
        (scenario.organ_motion.heartbeat_amplitude_m > 0.0, "tissue.heartbeat_amplitude_m", "the heartbeat"),
        (scenario.reflex.reacts(), "perception.reflex", "a hand that stops or withdraws after a noticed rupture"),
        (scenario.tremor.amplitude_m > 0.0, TREMOR, "the tremor"),
        (scenario.sensor.force_noise_std_n > 0.0, "sensor.force_noise_std_n", "the noise of the force sensor"),
    ])
}

pub fn loop_limits(scenario: &Scenario) -> Vec<LoopLimit> {
    let ActuatorLimits { master_force_n, master_force_rate_n_per_s, slave_command, slave_command_rate_per_s, .. } =
        scenario.actuators;
    type Bound = fn(&Bounds) -> f64;
    let all: [(Option<f64>, (&'static str, &'static str), Bound); 5] = [
        (master_force_n, ("actuator.master_force_limit_n", "the limit of the master's force"), |bounds| {
            bounds.master_force[0]
        }),
        (
            master_force_rate_n_per_s,
            ("actuator.master_force_rate_limit_n_per_s", "the rate limit of its force"),
            |bounds| bounds.master_force[1],
        ),
        (slave_command, ("actuator.slave_command_limit", "the limit of the slave's command"), |bounds| {
            bounds.slave_command[0]
        }),
        (
            slave_command_rate_per_s,
            ("actuator.slave_command_rate_limit_per_s", "the rate limit of its command"),
            |bounds| bounds.slave_command[1],
        ),
        (scenario.sensor.force_range_n, ("sensor.force_range_n", "the range of the force sensor"), |bounds| {
            bounds.tissue_force_n
        }),
    ];
    // Expensive, and valid only without other unmodelled parts.
    let unmodelled = [other_parts(scenario, None), assumed_passive(scenario), inputs(scenario)].concat();
    let is_linear = unmodelled.iter().all(|part| part.key == TREMOR);
    let are_sought = all.iter().any(|(limit, ..)| limit.is_some()) && is_linear;
    let bounds = are_sought.then(|| Bounds::of(scenario)).flatten();
    let given = |(limit, (key, what), bound): (Option<f64>, (&'static str, &'static str), Bound)| {
        let bound = bounds.as_ref().map(bound);
        Some(LoopLimit { part: LeftOut { key, what, bound }, limit: limit? })
    };
    all.into_iter().filter_map(given).collect()
}

impl Display for LeftOut {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({})", self.what, self.key)
    }
}
