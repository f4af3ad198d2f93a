//! The settings of the switching analysis.

use super::LONGEST_DWELL_S;
use crate::LinearLoop;
use crate::coverage::{FORCE_STEPS, left_out};
use trocar_core::augmentation::{AugmentationSettings, ForceMap, HoldMap, ReturnMap};
use trocar_core::time::nearest_ticks;
use trocar_engine::teleoperation::ControllerKind;
use trocar_scenario::Scenario;

/// A loop with events, on a tissue whose stiffness varies within a range at every tick.
#[derive(Debug, Clone, PartialEq)]
pub struct SwitchingSettings {
    /// The loop in teleoperation.
    pub of_loop: LinearLoop,
    /// The augmentation.
    pub augmentation: AugmentationSettings,
    /// Minimum and maximum `K` in N/m. The force is `K(t) p + B v` with any `K(t)` between them: every nonlinear tissue
    /// whose force stays in the sector.
    pub stiffness_n_per_m: (f64, f64),
    /// Minimum and maximum `B` in N·s/m, which may also change at any tick.
    pub damping_n_s_per_m: (f64, f64),
    /// True if the needle can lose contact, with a force of 0, at any tick.
    pub loses_contact: bool,
}

/// Maximum of both delays together.
const MAX_DELAY_TICKS: u64 = 24;

/// Lengths of the phases in ticks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Phases {
    /// Minimum and maximum duration of the freeze, in ticks.
    pub held: (u64, u64),
    /// Duration of the cross-fade in ticks.
    pub blend: u64,
    /// Minimum ticks of teleoperation between two events, enforced by the supervisor.
    pub refractory: u64,
}

impl SwitchingSettings {
    /// Builds the settings of a scenario with its loop.
    ///
    /// # Errors
    /// The reason why the switching cannot be analysed.
    pub fn of(scenario: &Scenario, of_loop: LinearLoop, stiffness_n_per_m: (f64, f64)) -> Result<Self, &'static str> {
        let (forward, backward) = (of_loop.forward(), of_loop.backward());
        if !scenario.augmentation.enabled {
            return Err("augmentation.enabled = false: there are no events");
        }
        if forward.share + backward.share > 0.0 {
            return Err(
                "a delay that is not a whole number of ticks splits a tick, which the certificate does not cover",
            );
        }
        if forward.whole + backward.whole > MAX_DELAY_TICKS {
            return Err("the certificate covers delays of up to 24 ticks for both ways together");
        }
        if left_out(scenario, None).iter().any(|part| part.key != FORCE_STEPS) {
            return Err("the certificate does not cover a part that the linear loop leaves out");
        }
        let augmentation = scenario.augmentation;
        let hold = augmentation.hold.map().ok_or("the certificate does not cover this hold (augmentation.hold)")?;
        let law = augmentation.force.map();
        let law = law.ok_or("the certificate does not cover this force law (augmentation.force_law)")?;
        if hold == HoldMap::Frozen && augmentation.reengage.map().is_none() {
            return Err("the certificate does not cover this return (augmentation.reengage)");
        }
        if let ForceMap::IsDamped { .. } = law {
            if hold == HoldMap::Frozen {
                return Err("the certificate does not cover added damping while the slave is frozen");
            }
            if of_loop.link.controller.kind != ControllerKind::PositionForce {
                return Err("the certificate covers added damping with position-force control only");
            }
        }
        let damping_n_s_per_m = of_loop.tissue.springs.damping_n_s_per_m;
        Ok(Self { of_loop, augmentation, stiffness_n_per_m, damping_n_s_per_m, loses_contact: false })
    }

    /// Returns both delays together in whole ticks.
    #[must_use]
    pub fn delay_ticks(&self) -> u64 {
        self.of_loop.forward().whole + self.of_loop.backward().whole
    }

    /// The same tissue without the damping that it has at some depths only.
    pub(super) fn with_least_damping(&self) -> Self {
        let (least, _) = self.damping_n_s_per_m;
        Self { damping_n_s_per_m: (least, least), ..self.clone() }
    }

    /// The lengths of the phases.
    #[must_use]
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

    /// True if an event leaves a gap that is kept.
    #[must_use]
    pub fn keeps_gap(&self) -> bool {
        self.augmentation.hold.map() == Some(HoldMap::Frozen)
            && self.augmentation.reengage.map() == Some(ReturnMap::Keeps)
    }
}
