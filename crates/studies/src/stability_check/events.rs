//! The worst sequence of events of an analysis, as a scenario for the engine.

use trocar_core::augmentation::{RampSettings, RampUntilLoadSettings, Reengage};
use trocar_scenario::{Scenario, ScenarioError, Source};
use trocar_stability::Switching;

const DEPTH_M: f64 = 0.01;

const DISPLACEMENT_M: f64 = 1e-3;

/// As a fraction of the distance that a ramp closes in a tick: the offset closes in one tick, as in the analysis.
const SMALL: f64 = 0.1;

/// Events of a periodic sequence.
const EVENTS: usize = 12;
const LONGEST_S: f64 = 60.0;

const AFTER_S: f64 = 0.5;

struct Demonstration {
    stiffness_n_per_m: f64,
    starts: Vec<u64>,
    held_ticks: u64,
}

fn demonstration(switching: &Switching) -> Demonstration {
    let phases = switching.phases;
    let (softest, stiffest) = switching.settings.stiffness_n_per_m;
    let cycles = &switching.shown.worst;
    let Some(first) = cycles.first() else {
        return Demonstration { stiffness_n_per_m: stiffest, starts: vec![], held_ticks: phases.held.0 };
    };
    let mut tick = 2;
    let mut starts = vec![];
    for cycle in cycles.iter().cycle().take(EVENTS) {
        starts.push(tick);
        tick += first.held_ticks + phases.blend + cycle.dwell_ticks;
    }
    Demonstration {
        stiffness_n_per_m: if first.vertex == 0 { softest } else { stiffest },
        starts,
        held_ticks: first.held_ticks,
    }
}

/// The needle rests in a spring and a damper. Alarms occur only at the times of the sequence.
pub fn worst_events(source: &Source, settings: &[String], switching: &Switching) -> Result<Scenario, ScenarioError> {
    let Demonstration { stiffness_n_per_m, starts, held_ticks } = demonstration(switching);
    let phases = switching.phases;
    let of_loop = &switching.settings.of_loop;
    let tick_s = of_loop.tick_s;
    let at = |tick: u64| format!("{:?}", tick as f64 * tick_s);
    let displacement_m = match switching.settings.augmentation.reengage {
        Reengage::Ramp(RampSettings { catch_up_speed_m_per_s: speed_m_per_s })
        | Reengage::RampUntilLoad(RampUntilLoadSettings { approach_speed_m_per_s: speed_m_per_s, .. }) => {
            DISPLACEMENT_M.min(SMALL * speed_m_per_s * tick_s)
        }
        Reengage::Fade(_) | Reengage::WhenStill(_) | Reengage::Clutch | Reengage::Snap => DISPLACEMENT_M,
    };
    let last = starts.last().map_or(0, |start| start + held_ticks + phases.blend);
    let duration_s = (last as f64 * tick_s + AFTER_S).min(LONGEST_S);
    let events: Vec<String> = starts.iter().map(|&tick| at(tick)).collect();
    let of_check = [
        "name=worst-events".to_owned(),
        format!("simulation.duration_s={duration_s:?}"),
        "simulation.engine=exact".to_owned(),
        "operator.kind=ramp".to_owned(),
        format!("operator.start_m={displacement_m:?}"),
        "operator.end_m=0.0".to_owned(),
        // Reached in the first tick.
        format!("operator.speed_m_per_s={:?}", 2.0 * displacement_m / tick_s),
        "operator.tremor_amplitude_m=0.0".to_owned(),
        "operator.stretch_short_gain_n_s_per_m=0.0".to_owned(),
        "operator.stretch_long_gain_n_per_m=0.0".to_owned(),
        "operator.stiffening_per_n=0.0".to_owned(),
        "perception.reflex=none".to_owned(),
        "tissue.kind=kelvin-voigt".to_owned(),
        format!("tissue.stiffness_n_per_m={stiffness_n_per_m:?}"),
        format!("tissue.damping_n_s_per_m={:?}", switching.settings.damping_n_s_per_m.0),
        format!("tissue.contact_m={:?}", -DEPTH_M),
        format!("sensor.force_bias_n={:?}", -stiffness_n_per_m * DEPTH_M),
        "sensor.force_noise_std_n=0.0".to_owned(),
        "sensor.force_resolution_n=0.0".to_owned(),
        "sensor.position_resolution_m=0.0".to_owned(),
        // The detector never alarms.
        "detector.threshold=1e6".to_owned(),
        format!("augmentation.events_s=[{}]", events.join(", ")),
        format!("augmentation.min_hold_s={}", at(held_ticks)),
        format!("augmentation.max_hold_s={}", at(held_ticks)),
        "augmentation.exit_quiet_s=0.0".to_owned(),
        format!("augmentation.refractory_s={}", at(phases.refractory)),
    ];
    Scenario::load_changed(source, &[settings, &of_check])
}
