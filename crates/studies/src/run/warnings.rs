use super::RunReport;
use super::reach::motion_beyond_run;
use trocar_base::warning::{Code, Warning};
use trocar_core::settings::KeySource as _;
use trocar_detect::recorded_warnings;
use trocar_document::significant;
use trocar_engine::channel::DelaySettings;
use trocar_engine::plant::ControlTiming;
use trocar_engine::tissue::TissueSettings;
use trocar_engine::tissue::literature::Outside;
use trocar_metrics::{Miss, MissReason, Outcome, RuptureMetrics};
use trocar_run::{Swing, lasting_swing};
use trocar_scenario::{OperatorSpec, Scenario, TissueSpec, idle_keys};

/// The controllers' lag stores and returns some energy.
const MAX_GIVEN_J: f64 = 1e-3;
const MAX_GIVEN_SHARE: f64 = 0.1;

const ROUNDING_J: f64 = 1e-9;
const ROUNDING_SHARE: f64 = 1e-9;

impl<'a> RunReport<'a> {
    /// Ordered by code.
    pub fn warnings(self) -> Vec<Warning> {
        let mut all: Vec<Warning> = self.missed_ruptures().collect();
        all.extend(self.stray_alarms());
        all.extend(self.unreached());
        all.extend(self.oscillation());
        all.extend(self.energy_of_the_hand());
        all.extend(self.acting_limits());
        all.extend(self.broken_promise());
        all.extend(delay_beyond_run(&self.run.scenario));
        all.extend(delays_rounded(&self.run.scenario));
        all.extend(replayed(&self.run.scenario));
        all.extend(idle_keys(&self.run.scenario));
        if !self.is_user_defined("tissue") {
            all.extend(outside_measured(&self.run.scenario));
        }
        all.into_iter().map(|warning| warning.of(&self.run.scenario.name)).collect()
    }

    pub(super) fn is_user_defined(self, role: &str) -> bool {
        self.run.user_defined_parts.contains(&role)
    }

    fn is_of_stray_alarm(self, miss: &Miss) -> bool {
        let MissReason::AlarmOfAnother { alarm_s } = miss.reason else { return false };
        let half_tick_s = 0.5 * self.run.scenario.grid.tick_s();
        self.run.metrics.alarms.iter().any(|alarm| !alarm.matched && (alarm.time_s - alarm_s).abs() < half_tick_s)
    }

    fn missed_ruptures(self) -> impl Iterator<Item = Warning> + 'a {
        let has_diverged = matches!(self.run.metrics.outcome, Outcome::Diverged { .. });
        let of = move |(index, rupture): (usize, &RuptureMetrics)| {
            let miss = rupture.miss.as_ref().filter(|miss| !self.is_of_stray_alarm(miss))?;
            // A hand that the force has pushed away does not insert the needle.
            if has_diverged && matches!(miss.reason, MissReason::NotInContact { .. }) {
                return None;
            }
            Some(miss.warning(index + 1, rupture.time_s))
        };
        let (missed, all) = (self.run.metrics.missed_ruptures, self.run.metrics.ruptures.len());
        let unexplained = (!self.run.user_defined_parts.is_empty() && missed > 0).then(|| {
            let message = format!(
                "{missed} of {all} ruptures have no alarm; trocar does not search for reasons if parts are \
                    user-defined"
            );
            let remedy = "look at the decision and the residual after the ruptures in the trace";
            Warning::new(Code::MissedRupture, message).remedy(remedy)
        });
        self.run.metrics.ruptures.iter().enumerate().filter_map(of).chain(unexplained)
    }

    fn oscillation(self) -> Option<Warning> {
        if !self.run.user_defined_parts.is_empty() && self.run.metrics.outcome == Outcome::Completed {
            let Swing { swing_m, frequency_hz } = lasting_swing(&self.run.scenario, &self.run.trace)?;
            let message = format!(
                "it swings by {:.3} mm at {frequency_hz:.2} Hz at the end; if parts are user-defined, trocar cannot \
                 tell whether the hand causes the swing",
                1e3 * swing_m
            );
            return Some(
                Warning::new(Code::Oscillating, message).remedy("compare with a run whose hand rests at the end"),
            );
        }
        let Outcome::Oscillating { frequency_hz, swing_m } = self.run.metrics.outcome else { return None };
        let message = format!(
            "it swings by {:.3} mm at {frequency_hz:.2} Hz at the end, and the swing does not decay",
            1e3 * swing_m
        );
        Some(Warning::new(Code::Oscillating, message).remedy(
            "`trocar stability` shows the limits of scales, stiffness and delay; a passivity scheme tolerates more \
             delay",
        ))
    }

    fn energy_of_the_hand(self) -> Option<Warning> {
        let (hand_j, tissue_j) = (self.run.metrics.operator_energy_j?, self.run.metrics.tissue_energy_j?);
        let is_model = matches!(self.run.scenario.tissue, TissueSpec::Model(_)) && !self.is_user_defined("tissue");
        let is_passive = is_model && !self.run.scenario.organ_motion.moves();
        let allowed_j = MAX_GIVEN_J.max(MAX_GIVEN_SHARE * tissue_j.abs());
        (is_passive && hand_j < -allowed_j).then(|| {
            let message = format!(
                "the master gives the hand {:.3} mJ, but the tissue model supplies no energy: the loop is not passive",
                -1e3 * hand_j
            );
            Warning::new(Code::ActiveLoop, message)
                .at("passivity.scheme")
                .remedy("`trocar stability` shows whether it is stable; a passivity scheme bounds the energy")
        })
    }
}

impl RunReport<'_> {
    fn broken_promise(self) -> Option<Warning> {
        let (link, ports) = (self.run.metrics.link.as_ref()?, self.run.metrics.ports.as_ref()?);
        let promised_j = link.promised_energy_j?;
        let moved_j = ports.hand_energy_j.abs() + ports.needle_energy_j.abs();
        (ports.generated_j > promised_j + ROUNDING_J + ROUNDING_SHARE * moved_j).then(|| {
            let message = format!(
                "hand and needle have received {:.3} mJ more than they have given at {:.3} s, with the needle at {:.3} \
                 mm; the scheme promises at most {:.3} mJ",
                1e3 * ports.generated_j,
                ports.generated_at_s,
                1e3 * ports.generated_at_m,
                1e3 * promised_j
            );
            Warning::new(Code::PromiseBroken, message)
                .at("passivity.scheme")
                .remedy("`trocar check` lists what the promise does not cover")
        })
    }
}

pub fn foreseen(scenario: &Scenario) -> Vec<Warning> {
    let mut all: Vec<Warning> = motion_beyond_run(scenario).into_iter().collect();
    all.extend(delay_beyond_run(scenario));
    all.extend(delays_rounded(scenario));
    all.extend(replayed(scenario));
    all
}

fn replayed(scenario: &Scenario) -> Vec<Warning> {
    let replays_position = scenario.values().optional_word("operator.kind") == Some("recording");
    match (&scenario.operator, &scenario.tissue) {
        (OperatorSpec::Recording(position_m), TissueSpec::Recording { force_n, .. }) if replays_position => {
            // The recorded positions are those of the slave.
            recorded_warnings(scenario.grid.tick_s(), position_m, force_n)
        }
        _ => vec![],
    }
}

fn delay_beyond_run(scenario: &Scenario) -> Option<Warning> {
    let ticks = scenario.grid.ticks();
    let beyond = [("channel.forward_delay_s", scenario.forward), ("channel.backward_delay_s", scenario.backward)];
    let (key, delay) = beyond.into_iter().find(|(_, delay)| delay.whole >= ticks)?;
    let message = format!(
        "{key} is {} s and the run lasts {} s: nothing arrives",
        scenario.grid.time_s(delay.whole),
        scenario.grid.time_s(ticks)
    );
    Some(
        Warning::new(Code::DelayBeyondRun, message)
            .at(key)
            .remedy("shorten the delay or lengthen simulation.duration_s"),
    )
}

pub fn delays_rounded(scenario: &Scenario) -> Vec<Warning> {
    let tick_s = scenario.grid.tick_s();
    let acting = [scenario.forward, scenario.backward].map(|delay| delay.whole as f64 + delay.share);
    let of = |(key, delay_s): (&'static str, f64), ticks: f64| {
        // Ignores rounding errors.
        (ticks - delay_s / tick_s > 1e-9 * ticks.max(1.0)).then(|| {
            let why = if scenario.timing == ControlTiming::Sampled {
                "sampled controllers read samples at their ticks"
            } else {
                "this architecture or passivity scheme computes on the tick"
            };
            let message = format!(
                "{key} is {} ms and acts as {} ms: {why}, and a tick is {} ms",
                significant(1e3 * delay_s),
                significant(1e3 * ticks * tick_s),
                significant(1e3 * tick_s)
            );
            Warning::new(Code::DelayRounded, message)
                .at(key)
                .remedy("give a multiple of simulation.tick_s, or shorten the tick")
        })
    };
    let [(forward, forward_s), (backward, backward_s)] = scenario.delays.of_each_way();
    if forward_s == backward_s {
        return of((DelaySettings::BOTH, forward_s), acting[0]).into_iter().collect();
    }
    let each = [of((forward, forward_s), acting[0]), of((backward, backward_s), acting[1])];
    each.into_iter().flatten().collect()
}

pub fn outside_measured(scenario: &Scenario) -> Vec<Warning> {
    let found = scenario.tissue.settings().map_or(vec![], TissueSettings::outside_measured);
    let warning = |Outside { key, value, bounds }: &Outside| {
        Warning::new(Code::OutsideMeasured, format!("{key} is {value}, outside of {}", bounds.stated))
            .at(key.clone())
            .remedy("check its unit; a phantom may have such a value")
    };
    found.iter().map(warning).collect()
}

pub fn seeds_without_effect<'a>(scenarios: impl IntoIterator<Item = &'a Scenario>, seeds: u64) -> Vec<Warning> {
    let copies = scenarios.into_iter().filter(|scenario| seeds > 1 && !scenario.has_random_numbers());
    let warning = |scenario: &Scenario| {
        let message = format!("the scenario has no random numbers: all {seeds} seeds give the same run");
        Warning::new(Code::SeedsWithoutEffect, message)
            .of(&scenario.name)
            .at("simulation.seed")
            .remedy("run one seed, or add noise, as in --set sensor.force_noise_std_n=0.025")
    };
    copies.map(warning).collect()
}
