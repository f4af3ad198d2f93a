use super::{Reach, RunReport};
use trocar_base::warning::{Code, Warning};
use trocar_core::settings::KeySource as _;
use trocar_document::counted;
use trocar_engine::operator::MotionSettings;
use trocar_metrics::{ALARM_WINDOW_S, Outcome, RUPTURE_WINDOW_S};
use trocar_scenario::{OperatorSpec, Scenario, TissueSpec};

/// Remaining share of a movement.
const MAX_LEFT_SHARE: f64 = 0.01;

enum Unreached<'a> {
    Layer(&'a str),
    /// Time in s.
    Label(f64),
    /// Depth in m.
    Depth(f64),
}

impl<'a> RunReport<'a> {
    pub(super) fn unreached(self) -> Vec<Warning> {
        let Some(reach) = self.completed_reach() else { return vec![] };
        let motion = if self.is_user_defined("operator") { None } else { motion_beyond_run(&self.run.scenario) };
        let tissue = self.untouched(&reach).or_else(|| self.unruptured(&reach));
        motion.into_iter().chain(tissue).collect()
    }

    pub(super) fn unreached_sentence(self) -> Option<String> {
        let reach = self.completed_reach()?;
        if reach.is_untouched {
            return Some("The needle never touches the tissue.".into());
        }
        Some(match self.first_unreached(&reach)? {
            Unreached::Layer(name) => format!("The layer {name} does not rupture."),
            Unreached::Label(time_s) => format!("The run ends before the rupture that is labelled at {time_s} s."),
            Unreached::Depth(depth_m) => {
                format!("The needle does not reach the rupture at {:.2} mm.", 1e3 * depth_m)
            }
        })
    }

    fn completed_reach(self) -> Option<Reach> {
        self.run.reach.filter(|_| !matches!(self.run.metrics.outcome, Outcome::Diverged { .. }))
    }

    fn untouched(self, reach: &Reach) -> Option<Warning> {
        if !reach.is_untouched {
            return None;
        }
        let deepest = format!("the needle gets to {:.2} mm", 1e3 * reach.deepest_m);
        let surface_m = self.run.scenario.tissue.settings().and_then(|settings| settings.surface_m());
        let (message, place) = match surface_m.filter(|_| !self.is_user_defined("tissue")) {
            Some(surface_m) => (
                format!("the needle never touches the tissue: {deepest}, the surface is at {:.2} mm", 1e3 * surface_m),
                "tissue.contact_m",
            ),
            None => (format!("the tissue force is 0 in the whole run: {deepest}"), "tissue.kind"),
        };
        let remedy = "move the operator beyond the surface (operator.end_m), or reduce tissue.contact_m; write millimetres with \
                      their unit, as in \"25mm\"";
        Some(Warning::new(Code::TissueNotTouched, message).at(place).remedy(remedy))
    }

    fn first_unreached(self, reach: &Reach) -> Option<Unreached<'a>> {
        if self.is_user_defined("tissue") {
            return None;
        }
        let occurred = self.run.metrics.ruptures.len();
        match &self.run.scenario.tissue {
            TissueSpec::Model(_) => {
                self.run.scenario.layers_to_rupture().into_iter().nth(occurred).map(Unreached::Layer)
            }
            TissueSpec::Recording { rupture_ticks, .. } => {
                rupture_ticks.get(occurred).map(|&tick| Unreached::Label(self.run.scenario.grid.time_s(tick)))
            }
            TissueSpec::Depth { rupture_depths_m, .. } => {
                rupture_depths_m.iter().copied().find(|depth_m| *depth_m > reach.deepest_m).map(Unreached::Depth)
            }
        }
    }

    fn unruptured(self, reach: &Reach) -> Option<Warning> {
        let end_s = self.run.scenario.grid.time_s(self.run.metrics.ticks);
        let deepest_mm = 1e3 * reach.deepest_m;
        Some(match self.first_unreached(reach)? {
            Unreached::Layer(name) => {
                let layers = self.run.scenario.layers_to_rupture();
                let occurred = self.run.metrics.ruptures.len();
                let force_n = reach.last_force_n;
                let key = format!("tissue.layer.{name}.rupture_force_n");
                let needed = self.run.scenario.values().optional_number(&key).map(|needed_n| {
                    let shared = if force_n < needed_n { "" } else { ", of which the layer bears a part" };
                    format!("{shared}; it ruptures at {needed_n} N")
                });
                let message = format!(
                    "the layer {name} does not rupture: {occurred} of {} do. The needle gets to {deepest_mm:.2} mm, and the tissue force \
                     {}reaches {force_n:.3} N{}",
                    counted(layers.len() as u64, "layer"),
                    if occurred > 0 { "after the last rupture " } else { "" },
                    needed.unwrap_or_default(),
                );
                let remedy = "move the operator further (operator.end_m) or lengthen the run (simulation.duration_s), or \
                              name it as tissue.spared_layer if the needle is to stop before it; detection is not measured there";
                Warning::new(Code::LayerNotRuptured, message).at(format!("tissue.layer.{name}")).remedy(remedy)
            }
            Unreached::Label(time_s) => {
                let message =
                    format!("the rupture that is labelled at {time_s} s is not in the run, which ends at {end_s} s");
                Warning::new(Code::LayerNotRuptured, message)
                    .at("recording.ruptures_s")
                    .remedy("lengthen simulation.duration_s, or remove the label")
            }
            Unreached::Depth(depth_m) => {
                let message = format!(
                    "the needle does not reach the rupture at {:.2} mm: it gets to {deepest_mm:.2} mm",
                    1e3 * depth_m
                );
                Warning::new(Code::LayerNotRuptured, message)
                    .at("recording.ruptures_s")
                    .remedy("move the operator further (operator.end_m) or lengthen the run (simulation.duration_s)")
            }
        })
    }

    pub(super) fn stray_alarms(self) -> Vec<Warning> {
        let ruptures = &self.run.metrics.ruptures;
        let of = |time_s: f64| {
            let index =
                ruptures.iter().rposition(|rupture| (0.0..=RUPTURE_WINDOW_S).contains(&(time_s - rupture.time_s)))?;
            let rupture = &ruptures[index];
            let is_missed = rupture.detection_delay_s.is_none();
            is_missed.then(|| {
                let after_s = time_s - rupture.time_s;
                let why = if after_s > ALARM_WINDOW_S + 0.5 * self.run.scenario.grid.tick_s() {
                    format!("a detection follows within {:.0} ms", 1e3 * ALARM_WINDOW_S)
                } else {
                    "the tissue force had not fallen".to_owned()
                };
                let message = format!(
                    "the alarm at {time_s:.3} s comes {:.1} ms after rupture {} at {:.3} s and is not its detection: {why}",
                    1e3 * after_s,
                    index + 1,
                    rupture.time_s
                );
                Warning::new(Code::StrayAlarm, message)
                    .at("detector.threshold")
                    .remedy("look at the residual and the decision there (residual.png, decision.png); an unstable or too strongly \
                             coupled loop, a wrong label and a wrong model cause such alarms")
            })
        };
        let is_false = |alarm: &&trocar_metrics::Alarm| !alarm.matched;
        self.run.metrics.alarms.iter().filter(is_false).filter_map(|alarm| of(alarm.time_s)).collect()
    }
}

pub(super) fn motion_beyond_run(scenario: &Scenario) -> Option<Warning> {
    let motion = MotionSettings::read(&mut scenario.values().clone()).ok()?;
    let (key, needed_s, [start_m, end_m]) = match motion {
        MotionSettings::Ramp(ramp) => {
            let ends = [ramp.start.start_m, ramp.end.end_m];
            ("operator.speed_m_per_s", (ends[1] - ends[0]).abs() / ramp.speed_m_per_s, ends)
        }
        MotionSettings::MinimumJerk(motion) => {
            ("operator.movement_s", motion.movement.movement_s, [motion.start.start_m, motion.end.end_m])
        }
        MotionSettings::InsertionExtraction(motion) => {
            let in_s = motion.movement.movement_s;
            let run_s = scenario.grid.time_s(scenario.grid.ticks());
            let ends = [motion.start.start_m, motion.end.end_m];
            if in_s > run_s {
                ("operator.movement_s", in_s, ends)
            } else if in_s + motion.hold_s < run_s {
                ("operator.withdrawal_s", in_s + motion.hold_s + motion.withdrawal_s, [ends[1], ends[0]])
            } else {
                return None;
            }
        }
        MotionSettings::Recording | MotionSettings::Sine(_) => return None,
    };
    let run_s = scenario.grid.time_s(scenario.grid.ticks());
    if needed_s <= run_s {
        return None;
    }
    let reached_m = match &scenario.operator {
        OperatorSpec::Recording(positions) => *positions.get(scenario.grid.ticks() as usize)?,
        OperatorSpec::Ramp { speed_m_per_s, .. } => start_m + (end_m - start_m).signum() * speed_m_per_s * run_s,
    };
    ((end_m - reached_m).abs() > MAX_LEFT_SHARE * (end_m - start_m).abs()).then(|| {
        let message = format!(
            "the operator's movement takes {needed_s} s and the run lasts {run_s} s: it ends at {:.2} mm on the way to {:.2} mm",
            1e3 * reached_m,
            1e3 * end_m
        );
        Warning::new(Code::MotionBeyondRun, message)
            .at(key)
            .remedy("lengthen simulation.duration_s, or make the movement faster (operator.movement_s in s, operator.speed_m_per_s in m/s)")
    })
}
