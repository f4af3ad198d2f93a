use super::LONGEST_DWELL_S;
use crate::LinearLoop;
use crate::coverage::{FORCE_STEPS, left_out};
use trocar_core::augmentation::{AugmentationSettings, ForceMap, HoldMap, ReturnMap};
use trocar_core::time::nearest_ticks;
use trocar_engine::teleoperation::ControllerKind;
use trocar_scenario::Scenario;

#[derive(Debug, Clone, PartialEq)]
pub struct SwitchingSettings {
    pub of_loop: LinearLoop,
    pub augmentation: AugmentationSettings,
    /// Covers every nonlinear tissue whose force stays in the sector.
    pub stiffness_n_per_m: (f64, f64),
    /// May change at any tick.
    pub damping_n_s_per_m: (f64, f64),
    /// At any tick.
    pub loses_contact: bool,
}

const MAX_DELAY_TICKS: u64 = 24;

/// In ticks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Phases {
    pub held: (u64, u64),
    pub blend: u64,
    /// Enforced by the supervisor.
    pub refractory: u64,
}

impl SwitchingSettings {
    pub fn of(scenario: &Scenario, of_loop: LinearLoop, stiffness_n_per_m: (f64, f64)) -> Result<Self, String> {
        let (forward, backward) = (of_loop.forward(), of_loop.backward());
        if !scenario.augmentation.enabled {
            return Err("augmentation.enabled = false: there are no events".to_owned());
        }
        if forward.share + backward.share > 0.0 {
            let reason =
                "a delay that is not a whole number of ticks splits a tick, which the certificate does not cover";
            return Err(reason.to_owned());
        }
        if forward.whole + backward.whole > MAX_DELAY_TICKS {
            return Err("the certificate covers delays of up to 24 ticks for both ways together".to_owned());
        }
        if let Some(part) = left_out(scenario, None).iter().find(|part| part.key != FORCE_STEPS) {
            return Err(format!("the certificate does not cover {} ({})", part.what, part.key));
        }
        let augmentation = scenario.augmentation;
        let hold = augmentation.hold.map().ok_or("the certificate does not cover this hold (augmentation.hold)")?;
        let law = augmentation.force.map();
        let law = law.ok_or("the certificate does not cover this force law (augmentation.force_law)")?;
        if hold == HoldMap::Frozen && augmentation.reengage.map().is_none() {
            return Err("the certificate does not cover this return (augmentation.reengage)".to_owned());
        }
        if let ForceMap::IsDamped { .. } = law {
            if hold == HoldMap::Frozen {
                return Err("the certificate does not cover added damping while the slave is frozen".to_owned());
            }
            if of_loop.link.controller.kind != ControllerKind::PositionForce {
                return Err("the certificate covers added damping with position-force control only".to_owned());
            }
        }
        let damping_n_s_per_m = of_loop.tissue.springs.damping_n_s_per_m;
        Ok(Self { of_loop, augmentation, stiffness_n_per_m, damping_n_s_per_m, loses_contact: false })
    }

    pub fn delay_ticks(&self) -> u64 {
        self.of_loop.forward().whole + self.of_loop.backward().whole
    }

    /// Without the damping that the tissue has at some depths only.
    pub(super) fn with_least_damping(&self) -> Self {
        let (least, _) = self.damping_n_s_per_m;
        Self { damping_n_s_per_m: (least, least), ..self.clone() }
    }

    pub fn phases(&self) -> Phases {
        let ticks = |seconds: f64| nearest_ticks(seconds, self.of_loop.tick_s);
        let automaton = &self.augmentation.automaton;
        let longest = ticks(automaton.max_hold_s).max(1);
        let shortest = ticks(automaton.min_hold_s).max(ticks(automaton.exit_quiet_s));
        Phases {
            held: (shortest.clamp(1, longest), longest),
            blend: ticks(self.augmentation.blend_s).max(1),
            refractory: ticks(automaton.refractory_s).max(1),
        }
    }

    pub(super) fn longest_dwell_ticks(&self) -> u64 {
        ((LONGEST_DWELL_S / self.of_loop.tick_s) as u64).max(2)
    }

    pub fn keeps_gap(&self) -> bool {
        self.augmentation.hold.map() == Some(HoldMap::Frozen)
            && self.augmentation.reengage.map() == Some(ReturnMap::Keeps)
    }
}
