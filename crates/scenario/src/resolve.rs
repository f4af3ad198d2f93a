use std::sync::Arc;

use trocar_core::settings::KeySource as _;

use super::document::Source;
use super::error::ScenarioError;
use super::keys::{KeyAt, find};
use super::replay::{RecordingSpec, load_recording};
use super::run_settings::RunSettings;
use super::scenario::{GROUPS, Scenario, ScenarioUpdate};
use super::specs::{OperatorSpec, TissueSpec};
use super::value::Value;
use super::values::{Values, harmless_name, replays_force, replays_position};
use trocar_core::time::{TickGrid, whole_ticks};
use trocar_engine::channel::{DelaySettings, MAX_DELAY_TICKS};
use trocar_engine::operator::OperatorTraits;
use trocar_engine::operator::{MAX_POSITION_M, MotionSettings};
use trocar_engine::plant::ControlTiming;
use trocar_engine::teleoperation::LinkSettings;
use trocar_engine::tissue::TissueSettings;

const DEFAULT_DURATION_S: f64 = 7.0;

/// About half an hour at 1 kHz, and a trace of 0.3 GB.
const MAX_TICKS: f64 = 2e6;

#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DelayTicks {
    pub whole: u64,
    /// At least 0 and below 1.
    pub share: f64,
}

impl DelayTicks {
    /// Times in s. A receiver that `waits_for_tick` reads a sample at the next tick, otherwise on arrival.
    pub fn new(delay_s: f64, tick_s: f64, waits_for_tick: bool) -> Self {
        let ticks = delay_s / tick_s;
        match whole_ticks(delay_s, tick_s) {
            Some(whole) => Self { whole, share: 0.0 },
            None if waits_for_tick => Self { whole: ticks.ceil() as u64, share: 0.0 },
            None => Self { whole: ticks.floor() as u64, share: ticks.fract() },
        }
    }
}

/// Only continuous position-force control of the appendix' machines without a scheme reads a sample on arrival.
pub fn waits_for_tick(timing: ControlTiming, link: &LinkSettings, has_general_machine: bool) -> bool {
    timing == ControlTiming::Sampled || !link.forwards_samples() || has_general_machine
}

impl Scenario {
    /// The settings (`section.key=value`) override the file.
    pub fn load(source: &Source, settings: &[String]) -> Result<Self, ScenarioError> {
        Self::load_changed(source, &[settings])
    }

    /// Like [`Scenario::load`], with keys and typed values. A number may also be a text with a unit.
    ///
    /// ```
    /// # mod trocar { pub use trocar_scenario as scenario; }
    /// use trocar::scenario::{Scenario, Source};
    ///
    /// let source = Source::parse("layers/skin-augmented");
    /// let settings = [("scaling.force", 0.8.into()), ("simulation.seed", 7.into()), ("operator.end_m", "30 mm".into())];
    /// let scenario = Scenario::load_with(&source, &settings)?;
    /// assert_eq!((scenario.seed, scenario.link.machines.force_scale), (7, 0.8));
    ///
    /// let error = Scenario::load_with(&source, &[("scaling.forse", 0.8.into())]).expect_err("no such key");
    /// assert!(error.to_string().contains("did you mean scaling.force?"));
    /// # Ok::<(), trocar::scenario::ScenarioError>(())
    /// ```
    pub fn load_with(source: &Source, settings: &[(&str, Value)]) -> Result<Self, ScenarioError> {
        let written: Vec<String> = settings.iter().map(|(key, value)| format!("{key}={}", value.to_toml())).collect();
        Self::load(source, &written)
    }

    /// A later list overrides earlier ones and may change a kind, which disables earlier settings.
    pub fn load_changed(source: &Source, settings: &[&[String]]) -> Result<Self, ScenarioError> {
        Self::load_sharing(None, source, settings)
    }

    /// Takes over the plants' steps of another scenario with the same machines.
    pub fn load_sharing(other: Option<&Self>, source: &Source, settings: &[&[String]]) -> Result<Self, ScenarioError> {
        let values = Values::load_changed(source, settings)?;
        values.check_acting(|_| false)?;
        Self::resolve_sharing(other, values)
    }

    /// Each setting must have an effect in at least one scenario.
    pub fn load_all(sources: &[Source], settings: &[String]) -> Vec<Result<Self, ScenarioError>> {
        let all: Vec<_> = sources.iter().map(|source| Values::load(source, settings)).collect();
        let acts = |key: &KeyAt| all.iter().flatten().any(|values| values.is_acting(key));
        let resolve = |values: &Result<Values, ScenarioError>| {
            let values = values.clone()?;
            values.check_acting(acts)?;
            Self::resolve(values)
        };
        all.iter().map(resolve).collect()
    }

    pub fn resolve(values: Values) -> Result<Self, ScenarioError> {
        Self::resolve_sharing(None, values)
    }

    fn resolve_sharing(other: Option<&Self>, mut values: Values) -> Result<Self, ScenarioError> {
        values.fill_layers();
        values.check_layers()?;
        let replays = replays_position(&values) || replays_force(&values);
        let recording = if replays { Some(load_recording(&mut values)?) } else { None };
        let run = RunSettings::read(&mut values)?;
        let grid = grid(&mut values, &run, recording.as_ref())?;
        let replay = recording
            .map(|spec| {
                let resampled = spec.recording.resample(grid.tick_s(), grid.ticks() as usize + 1);
                let resampled = resampled.map_err(|error| values.error("recording.file", error.to_string()))?;
                Ok((spec, resampled))
            })
            .transpose()?;
        let mut scenario = Self::unread(checked_name(&values, run.name)?, grid, (run.engine, run.timing), run.seed);
        let mut update = ScenarioUpdate { scenario: &mut scenario, values: &mut values, replay: replay.as_ref() };
        GROUPS.iter().try_for_each(|group| (group.read)(&mut update))?;
        scenario.values = Arc::new(values);
        if let Some(other) = other {
            scenario.share_steps(other);
        }
        scenario.check_parts()?;
        Ok(scenario)
    }

    /// Includes derived values.
    pub fn values(&self) -> &Values {
        &self.values
    }

    pub fn with_seed(&self, seed: u64) -> Self {
        let mut other = Self { seed, ..self.clone() };
        Arc::make_mut(&mut other.values).derive_keeping_place("simulation.seed", Value::Whole(seed));
        other
    }

    /// True if the seed has an effect: sensor noise, tremor, random reaction times, jitter or loss.
    pub fn has_random_numbers(&self) -> bool {
        let reacts_randomly = self.perception.settings().is_some()
            || self.reflex.reacts() && self.reflex.reaction_min_s < self.reflex.reaction_max_s;
        let is_noisy = self.sensor.force_noise_std_n > 0.0;
        is_noisy || self.tremor.amplitude_m > 0.0 || reacts_randomly || !self.irregularity.is_none()
    }

    /// Every default written out; loading it gives the same scenario.
    pub fn echo(&self) -> String {
        self.values.to_toml()
    }

    /// The true times of layer ruptures in s, if they are known in advance.
    pub fn rupture_times_s(&self) -> Vec<f64> {
        match &self.tissue {
            TissueSpec::Recording { rupture_ticks, .. } => {
                rupture_ticks.iter().map(|&tick| self.grid.time_s(tick)).collect()
            }
            TissueSpec::Depth { .. } | TissueSpec::Model(_) => vec![],
        }
    }

    /// From the surface down. The k-th rupture of a run is the k-th layer's.
    pub fn rupturing_layers(&self) -> Vec<&str> {
        let layers = self.tissue.settings().map_or(vec![], TissueSettings::layers);
        layers.into_iter().filter(|layer| layer.ruptures).map(|layer| layer.name).collect()
    }

    /// The intention of a recorded hand is unknown.
    pub fn operator_traits(&self) -> OperatorTraits {
        let is_planned = !replays_position(&self.values);
        OperatorTraits {
            intended_scale: is_planned.then(|| self.position_scale()),
            notices: self.reflex.reacts() || self.perception.settings().is_some(),
        }
    }

    /// The ratio of slave motion to master motion.
    pub fn position_scale(&self) -> f64 {
        self.link.machines.position_scale
    }

    fn operator_ends(values: &Values) -> impl Iterator<Item = (&'static str, f64)> {
        let of = |path| Some((path, values.optional_number(path)?));
        let acts = |path: &&str| find(path).is_some_and(|key| values.is_acting(&key));
        ["operator.start_m", "operator.end_m"].into_iter().filter(acts).filter_map(of)
    }

    /// Checks the operator's positions; beyond the range every run would count as diverged.
    pub(super) fn check_reach(&self, values: &Values) -> Result<(), ScenarioError> {
        let max_m = MAX_POSITION_M / self.position_scale().max(1.0);
        let beyond = |position: &f64| position.abs() >= max_m;
        if !replays_position(values) {
            // The written ends of a movement, not its first sample out of range.
            for (key, end_m) in Self::operator_ends(values) {
                if beyond(&end_m) {
                    let place = values.place(key);
                    let written = place.as_ref().and_then(|place| place.text.get(place.span.clone()));
                    let written = written.map_or_else(|| end_m.to_string(), str::to_owned);
                    let message = format!("{key} is {written}, must stay within {max_m} m of 0, on either side");
                    return Err(values.error(key, message).remedy("write millimetres with their unit, as in \"60mm\""));
                }
            }
        }
        let (key, position) = match &self.operator {
            OperatorSpec::Recording(positions) => {
                let key = if replays_position(values) { "recording.file" } else { MotionSettings::KEY.path };
                (key, positions.iter().copied().find(beyond))
            }
            OperatorSpec::Ramp { start_m, .. } if beyond(start_m) => ("operator.start_m", Some(*start_m)),
            OperatorSpec::Ramp { end_m, .. } => ("operator.end_m", Some(*end_m).filter(beyond)),
        };
        let Some(position) = position else { return Ok(()) };
        let message = format!("the operator moves to {position} m, must stay within {max_m} m of 0, on either side");
        Err(values.error(key, message).remedy("is a recording in mm? Then recording.scale.position_m = 1e-3"))
    }
}

fn checked_name(values: &Values, name: String) -> Result<String, ScenarioError> {
    if harmless_name(&name) == name {
        return Ok(name);
    }
    let message = format!("name is {name:?}, must be usable as a folder's name");
    Err(values.error("name", message).remedy("use at most 100 letters, digits, '-' and '_'"))
}

fn grid(values: &mut Values, run: &RunSettings, recording: Option<&RecordingSpec>) -> Result<TickGrid, ScenarioError> {
    let tick_s = run.tick_s;
    let duration_s = match (run.duration_s, recording) {
        (Some(duration_s), _) => duration_s,
        (None, Some(spec)) => {
            let length_s = spec.recording.duration_s();
            if tick_s > length_s {
                let message =
                    format!("simulation.tick_s is {tick_s}, must be at most the length of the recording, {length_s} s");
                return Err(values.error("simulation.tick_s", message));
            }
            let covered = spec.recording.ticks_covered(tick_s);
            covered.map_err(|error| values.error("simulation.tick_s", error.to_string()))? as f64 * tick_s
        }
        (None, None) => DEFAULT_DURATION_S,
    };
    values.derive_if_missing("simulation.duration_s", Value::Number(duration_s));
    let ticks = duration_s / tick_s;
    if ticks > MAX_TICKS {
        let message = format!("{duration_s} s in ticks of {tick_s} s are {ticks:.0} ticks, at most {MAX_TICKS:.0}");
        let written = |key: &&str| values.place(key).is_some();
        let key =
            ["simulation.tick_s", "simulation.duration_s"].into_iter().find(written).unwrap_or("simulation.tick_s");
        return Err(values.error(key, message).remedy("shorten the run or lengthen the tick"));
    }
    TickGrid::new(tick_s, duration_s).map_err(|error| values.out_of_range(&error))
}

pub(super) fn delays(
    values: &mut Values,
    grid: &TickGrid,
    waits_for_tick: bool,
) -> Result<(DelaySettings, DelayTicks, DelayTicks), ScenarioError> {
    let settings = DelaySettings::read(values)?;
    let tick_s = grid.tick_s();
    for (path, delay_s) in settings.of_each_way() {
        if delay_s / tick_s > MAX_DELAY_TICKS as f64 {
            let max_s = MAX_DELAY_TICKS as f64 * tick_s;
            let message = format!("{path} is {delay_s:?}, at most {max_s} s, {MAX_DELAY_TICKS} ticks");
            return Err(values.error(path, message));
        }
    }
    let ticks = |delay_s| DelayTicks::new(delay_s, tick_s, waits_for_tick);
    Ok((settings, ticks(settings.forward_delay_s), ticks(settings.backward_delay_s)))
}
