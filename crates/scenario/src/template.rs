//! Many scenarios that differ in a few keys, built without reading a file again.
//!
//! A key belongs to a [`Part`] of a scenario. Changing it runs the functions that resolve this part of a file, so the
//! same values are refused with the same messages. Errors that appear only when the plants are built are left to the
//! run, which builds them.

use std::sync::Arc;

use trocar_core::settings::{Fallback, Source as _};

use super::document::{Entry, Source, drop_replaced_layers, gather, parse_setting};
use super::error::{Place, ScenarioError};
use super::key_table::KEYS;
use super::keys::KeyAt;
use super::link::link_settings;
use super::resolve::{Scenario, delays, waits_for_tick};
use super::schedule::events;
use super::settings::{actuators, arm, master};
use super::specs::{TissueSpec, operator, stated_tissue, tissue};
use super::value::Value;
use super::values::{Values, harmless_name, replays_force, replays_position};
use crate::population::PopulationSettings;
use trocar_core::augmentation::AugmentationSettings;
use trocar_core::detection::DetectorSettings;
use trocar_core::estimation::{ContactSettings, RlsSettings};
use trocar_engine::channel::{DelaySettings, Irregularity};
use trocar_engine::operator::{Perception, ReflexSettings, StiffeningSettings, StretchSettings, TremorSettings};
use trocar_engine::plant::SlaveParameters;
use trocar_engine::sensor::SensorSettings;
use trocar_engine::tissue::OrganMotion;

/// The part of a scenario that a key affects.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Part {
    /// The seed alone.
    Seed,
    /// The link's settings.
    Link,
    /// Master, arm, slave and motors, and with them the link.
    Machines,
    /// Jitter and loss.
    Irregularity,
    /// The delays of the link.
    Delays,
    /// The sensors.
    Sensor,
    /// The estimator.
    Estimator,
    /// The detector.
    Detector,
    /// The supervisor.
    Augmentation,
    /// The tissue, if it replays no recording.
    Tissue,
    /// The tissue that the analysis of stability takes for a recorded force.
    StatedTissue,
    /// The presliding travel of a recording by depth.
    Presliding,
    /// The operator's motion, if it replays no recording.
    Motion,
    /// Tremor, reflexes, grip and perception.
    Involuntary,
    /// The population.
    Population,
    /// Nothing in this scenario.
    Nothing,
    /// Everything: the scenario is resolved again, its recording read again.
    Whole,
}

/// The beginnings of the keys of what the operator does involuntarily.
const INVOLUNTARY: [&str; 4] = ["operator.tremor_", "operator.reflex", "operator.stretch_", "operator.stiffening_"];

impl Part {
    fn of(path: &str, base: &Scenario) -> Self {
        let section = path.split('.').next().unwrap_or_default();
        match (section, path) {
            (_, "simulation.seed") => Self::Seed,
            (_, "channel.outages_s" | "channel.delays_file" | "operator.kind" | "tissue.kind" | "tissue.index") => {
                Self::Whole
            }
            (_, "channel.jitter_s" | "channel.loss") => Self::Irregularity,
            _ if path == DelaySettings::BOTH || DelaySettings::is_one_way(path) => Self::Delays,
            ("channel" | "scaling", _) | (_, "slave.compliance_m_per_n") => Self::Link,
            ("master" | "arm" | "slave" | "actuator" | "controller" | "passivity", _) => Self::Machines,
            ("sensor", _) => Self::Sensor,
            ("estimator", _) => Self::Estimator,
            ("detector", _) => Self::Detector,
            ("augmentation", _) => Self::Augmentation,
            ("tissue", _) if !replays_force(base.values()) => Self::Tissue,
            (_, "tissue.presliding_m") if matches!(base.tissue, TissueSpec::Depth { .. }) => Self::Presliding,
            ("tissue", _) if base.stated_tissue.is_some() => Self::StatedTissue,
            ("tissue", _) => Self::Nothing,
            ("perception", _) => Self::Involuntary,
            ("population", _) => Self::Population,
            ("operator", key) if INVOLUNTARY.iter().any(|prefix| key.starts_with(prefix)) => Self::Involuntary,
            ("operator", _) if !replays_position(base.values()) => Self::Motion,
            ("operator", _) => Self::Nothing,
            _ => Self::Whole,
        }
    }

    /// The sections whose derived values depend on this part's keys.
    fn derives(self) -> &'static [&'static str] {
        match self {
            Self::Machines => &["master.", "arm."],
            Self::Delays => &["channel."],
            Self::Estimator => &["estimator."],
            Self::Detector => &["detector."],
            _ => &[],
        }
    }
}

/// A scenario with some keys left open.
#[derive(Debug, Clone)]
pub struct Template {
    /// The written values, without derived ones.
    written: Values,
    first: Scenario,
    keys: Vec<KeyAt>,
    parts: Vec<Part>,
}

impl Template {
    /// The scenario of a file with its bases, overridden by entries and by `section.key=value` settings, with `open`
    /// keys, each with its first value and the place of its values.
    ///
    /// # Errors
    /// As [`Scenario::load`], for the scenario with the first values; an open key that a setting or an entry fixes, and
    /// one of them that does not act.
    pub fn new(
        base: &Source,
        entries: Vec<Entry>,
        settings: &[String],
        open: &[(KeyAt, Value, Place)],
    ) -> Result<Self, ScenarioError> {
        let is_open = |path: &str| open.iter().any(|(key, ..)| key.path == path);
        let mut written = Values::default();
        let mut given = vec![];
        for setting in settings.iter().rev() {
            given.extend(parse_setting(setting)?);
        }
        given.extend(entries);
        for entry in &given {
            if is_open(&entry.path) {
                let message = format!("{} is both swept and set", entry.path);
                return Err(ScenarioError::new(message)
                    .at(Some(entry.value_place.clone()))
                    .remedy("sweep it or set it"));
            }
        }
        for (key, value, place) in open {
            written.give(key, value.clone(), place.clone());
        }
        given.extend(gather(base, &[])?);
        drop_replaced_layers(&mut given);
        for entry in given {
            written.take(entry)?;
        }
        if !written.is_given("name") {
            written.derive("name", Value::Text(harmless_name(&base.stem())));
        }
        written.fill_defaults();
        written.check_acting(|key| is_open(key.path) || written.unmet(key).any(|acts| is_open(acts.key)))?;
        let first = Scenario::resolve(written.clone())?;
        let keys: Vec<KeyAt> = open.iter().map(|(key, ..)| key.clone()).collect();
        let mut parts: Vec<Part> = vec![];
        for key in &keys {
            let part = Part::of(&key.path, &first);
            if !parts.contains(&part) {
                parts.push(part);
            }
        }
        Ok(Self { written, first, keys, parts })
    }

    /// The scenario with the first values.
    #[must_use]
    pub fn first(&self) -> &Scenario {
        &self.first
    }

    /// Whether a key has a written or default value, not a derived one.
    #[must_use]
    pub fn gives(&self, path: &str) -> bool {
        self.written.is_given(path)
    }

    /// The scenario with these values of the open keys and this seed, fully resolved as from a file.
    ///
    /// # Errors
    /// As [`Scenario::load`].
    pub fn whole(&self, values: &[Value], seed: u64) -> Result<Scenario, ScenarioError> {
        let mut written = self.written.clone();
        for (key, value) in self.keys.iter().zip(values) {
            written.replace(&key.path, value.clone());
        }
        written.replace("simulation.seed", Value::Whole(seed));
        Scenario::resolve(written)
    }

    /// A factory of its scenarios; each thread has its own.
    #[must_use]
    pub fn factory(&self) -> CaseFactory<'_> {
        let values = self.first.values().clone();
        let derived = KEYS
            .iter()
            .filter(|key| matches!(key.fallback, Fallback::Derived(_)) && !self.written.is_given(key.path))
            .map(|key| key.path)
            .filter(|path| self.parts.iter().flat_map(|part| part.derives()).any(|section| path.starts_with(section)))
            .collect();
        CaseFactory { template: self, values, derived, scenario: self.first.clone() }
    }
}

/// Builds scenarios from a [`Template`].
#[derive(Debug, Clone)]
pub struct CaseFactory<'a> {
    template: &'a Template,
    /// The values of the last scenario.
    values: Values,
    /// Keys whose values are derived again.
    derived: Vec<&'static str>,
    scenario: Scenario,
}

impl CaseFactory<'_> {
    /// The scenario with these values of the open keys and this seed: as [`Template::whole`], except that its
    /// [`Scenario::values`] are those of the first scenario.
    ///
    /// # Errors
    /// As [`Scenario::load`], except for plants that cannot be built, which [`Scenario::build`] refuses.
    pub fn build(&mut self, values: &[Value], seed: u64) -> Result<Scenario, ScenarioError> {
        if self.template.parts.contains(&Part::Whole) {
            return self.template.whole(values, seed);
        }
        for (key, value) in self.template.keys.iter().zip(values) {
            self.values.replace(&key.path, value.clone());
        }
        for path in &self.derived {
            self.values.remove(path);
        }
        let template = self.template;
        if let Err(error) = template.parts.iter().try_for_each(|part| self.set(*part)) {
            // Some parts may already be changed.
            *self = template.factory();
            return Err(error);
        }
        self.scenario.seed = seed;
        Ok(self.scenario.clone())
    }

    /// Resolves one part again.
    fn set(&mut self, part: Part) -> Result<(), ScenarioError> {
        let (scenario, values) = (&mut self.scenario, &mut self.values);
        match part {
            Part::Seed | Part::Nothing | Part::Whole => {}
            Part::Link => set_link(scenario, values)?,
            Part::Machines => {
                scenario.master = master(values)?;
                scenario.slave = SlaveParameters::read(values)?;
                scenario.arm = arm(values)?;
                scenario.actuators = actuators(values, scenario.timing)?;
                scenario.steps = Arc::default();
                set_link(scenario, values)?;
                set_delays(scenario, values)?;
            }
            Part::Irregularity => {
                scenario.irregularity = Irregularity::read(values)?;
                let tick_s = scenario.grid.tick_s();
                scenario.irregularity.validate_on_ticks(tick_s).map_err(|error| values.out_of_range(&error))?;
            }
            Part::Delays => set_delays(scenario, values)?,
            Part::Sensor => {
                scenario.sensor = SensorSettings::read(values)?;
                scenario.sensor.validate().map_err(|error| values.out_of_range(&error))?;
            }
            Part::Estimator => {
                scenario.estimator = RlsSettings::read(values)?;
                scenario.contact_m = ContactSettings::read(values)?.contact_m;
                scenario.estimator.validate().map_err(|error| values.out_of_range(&error))?;
            }
            Part::Detector => {
                scenario.detector = DetectorSettings::read(values)?;
                scenario.detector.validate().map_err(|error| values.out_of_range(&error))?;
            }
            Part::Augmentation => {
                scenario.augmentation = AugmentationSettings::read(values)?;
                scenario.events = events(values, &scenario.grid)?;
                scenario.augmentation.validate().map_err(|error| values.out_of_range(&error))?;
            }
            Part::Tissue => {
                scenario.tissue = tissue(values, &scenario.grid, None)?;
                scenario.organ_motion = OrganMotion::read(values)?;
            }
            Part::StatedTissue => scenario.stated_tissue = stated_tissue(values)?,
            Part::Presliding => {
                if let TissueSpec::Depth { presliding_m, .. } = &mut scenario.tissue {
                    *presliding_m = values.number("tissue.presliding_m")?;
                }
            }
            Part::Motion => {
                scenario.operator = operator(values, &scenario.grid, None)?;
                scenario.check_reach()?;
            }
            Part::Population => {
                scenario.population = PopulationSettings::read(values)?;
                scenario.population.validate().map_err(|error| values.out_of_range(&error))?;
            }
            Part::Involuntary => {
                scenario.tremor = TremorSettings::read(values)?;
                scenario.stretch = StretchSettings::read(values)?;
                scenario.stiffening = StiffeningSettings::read(values)?;
                scenario.reflex = ReflexSettings::read(values)?;
                scenario.perception = Perception::read(values)?;
                let invalid = |error| values.out_of_range(&error);
                scenario.tremor.validate_on_ticks(scenario.grid.tick_s()).map_err(invalid)?;
                scenario.stretch.validate().map_err(invalid)?;
                scenario.stiffening.validate().map_err(invalid)?;
                scenario.reflex.validate_where_reacting().map_err(invalid)?;
                scenario.perception.validate().map_err(invalid)?;
            }
        }
        Ok(())
    }
}

fn set_link(scenario: &mut Scenario, values: &mut Values) -> Result<(), ScenarioError> {
    let position_scale = scenario.position_scale();
    scenario.link = link_settings(values, &scenario.master, &scenario.slave, scenario.grid.tick_s())?;
    // Checking every position takes longer than everything else.
    if scenario.position_scale() == position_scale { Ok(()) } else { scenario.check_reach() }
}

fn set_delays(scenario: &mut Scenario, values: &mut Values) -> Result<(), ScenarioError> {
    let waits_for_tick = waits_for_tick(scenario.timing, &scenario.link);
    (scenario.delays, scenario.forward, scenario.backward) = delays(values, &scenario.grid, waits_for_tick)?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use trocar_core::settings::Kind;

    use super::*;

    /// The values of a key that a sweep might try.
    fn trial_values(key: &KeyAt, scenario: &Scenario) -> Vec<Value> {
        match key.kind {
            Kind::Number(_) => {
                let now = scenario.values().optional_number(&key.path).unwrap_or(0.01);
                [1.07 * now, 0.5 * now, now + 0.003].map(Value::Number).into()
            }
            Kind::Whole(_) => [2, 3, 50].map(Value::Whole).into(),
            Kind::Choice(words) => words.iter().map(|word| Value::Text((*word).into())).collect(),
            Kind::Flag => [true, false].map(Value::Flag).into(),
            Kind::Sign | Kind::Numbers | Kind::Text | Kind::File => vec![],
        }
    }

    fn debug_text(mut scenario: Scenario) -> String {
        scenario.values = Arc::new(Values::default());
        // The cached steps are not part of the comparison.
        scenario.steps = Arc::default();
        format!("{scenario:?}")
    }

    /// Builds every value of every key of some sections by the factory, and compares with the resolution from a file.
    fn count_compared(name: &str, sections: &[&str]) -> usize {
        let base = Source::parse(name);
        let scenario = Scenario::load(&base, &[]).expect("good");
        let place = Place { file: "sweep".into(), text: "".into(), span: 0..0 };
        let mut compared = 0;
        let keys = KEYS.iter().map(KeyAt::from).chain(scenario.values().layer_keys());
        for key in keys.filter(|key| sections.iter().any(|section| key.path.starts_with(section))) {
            let is_good = |value: &Value| Value::accept(&key.kind, &value.to_toml()).is_some();
            let values: Vec<Value> = trial_values(&key, &scenario).into_iter().filter(is_good).collect();
            // A key without a valid first value is skipped.
            let first = |value: &&Value| {
                Template::new(&base, vec![], &[], &[(key.clone(), (*value).clone(), place.clone())]).is_ok()
            };
            let Some(first) = values.iter().find(first) else { continue };
            let template =
                Template::new(&base, vec![], &[], &[(key.clone(), first.clone(), place.clone())]).expect("good");
            let mut factory = template.factory();
            for (seed, value) in (7..).zip(&values) {
                let value = std::slice::from_ref(value);
                let built =
                    factory.build(value, seed).and_then(|scenario| scenario.build().map(|_| debug_text(scenario)));
                let whole =
                    template.whole(value, seed).and_then(|scenario| scenario.build().map(|_| debug_text(scenario)));
                match (built, whole) {
                    (Ok(built), Ok(whole)) => assert!(built == whole, "{name}: {} = {value:?}", key.path),
                    (built, whole) => assert_eq!(
                        built.err().map(|error| error.message),
                        whole.err().map(|error| error.message),
                        "{name}: {} = {value:?}",
                        key.path
                    ),
                }
                compared += 1;
            }
        }
        compared
    }

    #[test]
    fn the_factory_agrees_with_a_file_key_by_key() {
        assert!(count_compared("layers/skin-augmented", &[""]) > 300);
        assert!(count_compared("link/four-channel", &["controller", "scaling", "slave", "master", "passivity"]) > 30);
        assert!(count_compared("paper/depth-augmented", &["tissue.presliding", "scaling", "operator.start"]) > 5);
    }
}
