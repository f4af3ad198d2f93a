//! Builds many scenarios that differ in a few keys, without reading a file again.
//!
//! Errors that appear only when the plants are built are reported by the run.

use trocar_core::settings::{Fallback, Key};

use super::document::{Entry, Source, drop_replaced_layers, gather, parse_setting};
use super::error::{Place, ScenarioError};
use super::keys::KeyAt;
use super::scenario::{GROUPS, Group, Scenario, ScenarioUpdate};
use super::value::Value;
use super::values::{Values, harmless_name};

/// Affects no other setting.
const SEED: &str = "simulation.seed";

/// In table order; `None` if the whole scenario depends on the keys.
fn groups_of(keys: &[KeyAt]) -> Option<Vec<&'static Group>> {
    let is_changed = |depends: fn(&Group, &Key) -> bool| {
        move |group: &&Group| keys.iter().any(|key| key.path != SEED && depends(group, key))
    };
    if GROUPS.iter().any(|group| is_changed(Group::is_whole)(&group)) {
        return None;
    }
    Some(GROUPS.iter().filter(is_changed(Group::depends_on)).collect())
}

/// A scenario with some open keys.
#[derive(Debug, Clone)]
pub struct Template {
    written: Values,
    first: Scenario,
    keys: Vec<KeyAt>,
    groups: Option<Vec<&'static Group>>,
}

impl Template {
    /// `open` lists the open keys, each with its first value and the place of its values.
    ///
    /// # Errors
    /// The errors of [`Scenario::load`] for the first values; a setting or an entry fixes an open key; an open key has
    /// no effect.
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
        written.check_acting(|key| is_open(&key.path) || written.unmet(key).any(|acts| is_open(acts.key)))?;
        let first = Scenario::resolve(written.clone())?;
        let keys: Vec<KeyAt> = open.iter().map(|(key, ..)| key.clone()).collect();
        let groups = groups_of(&keys);
        Ok(Self { written, first, keys, groups })
    }

    pub fn first(&self) -> &Scenario {
        &self.first
    }

    /// True if a key has a written or default value rather than a derived one.
    pub fn gives(&self, path: &str) -> bool {
        self.written.is_given(path)
    }

    /// Resolved in full as from a file.
    pub fn whole(&self, values: &[Value], seed: u64) -> Result<Scenario, ScenarioError> {
        let mut written = self.written.clone();
        for (key, value) in self.keys.iter().zip(values) {
            written.replace(&key.path, value.clone());
        }
        written.replace(SEED, Value::Whole(seed));
        Scenario::resolve(written)
    }

    /// Each thread needs a separate one.
    pub fn factory(&self) -> CaseFactory<'_> {
        let values = self.first.values().clone();
        let is_derived = |key: &&Key| matches!(key.fallback, Fallback::Derived(_)) && !self.written.is_given(key.path);
        let keys = self.groups.iter().flatten().flat_map(|group| group.keys);
        let derived = keys.filter(is_derived).map(|key| key.path).collect();
        CaseFactory { template: self, values, derived, scenario: self.first.clone() }
    }
}

/// Builds scenarios from a [`Template`].
#[derive(Debug, Clone)]
pub struct CaseFactory<'a> {
    template: &'a Template,
    values: Values,
    /// Must be derived again.
    derived: Vec<&'static str>,
    scenario: Scenario,
}

impl CaseFactory<'_> {
    /// Like [`Template::whole`], but [`Scenario::values`] are the first scenario's.
    ///
    /// # Errors
    /// The errors of [`Scenario::load`], except for plants that cannot be built, which [`Scenario::build`] reports.
    pub fn build(&mut self, values: &[Value], seed: u64) -> Result<Scenario, ScenarioError> {
        let template = self.template;
        let Some(groups) = &template.groups else { return template.whole(values, seed) };
        for (key, value) in self.template.keys.iter().zip(values) {
            self.values.replace(&key.path, value.clone());
        }
        for path in &self.derived {
            self.values.remove(path);
        }
        let mut update = ScenarioUpdate { scenario: &mut self.scenario, values: &mut self.values, replay: None };
        if let Err(error) = groups.iter().try_for_each(|group| (group.read)(&mut update)) {
            // Discard partial changes: some groups may already be read.
            *self = template.factory();
            return Err(error);
        }
        self.scenario.seed = seed;
        Ok(self.scenario.clone())
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use trocar_core::settings::{KeySource as _, Kind};

    use super::super::KEYS;
    use super::*;

    /// Returns values of a key that a sweep might try.
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
        // The comparison excludes the cached steps.
        scenario.steps = Arc::default();
        format!("{scenario:?}")
    }

    /// Builds every value of every key in some sections with the factory, and compares it with the resolution from a
    /// file.
    fn count_compared(name: &str, sections: &[&str]) -> usize {
        let base = Source::parse(name);
        let scenario = Scenario::load(&base, &[]).expect("good");
        let place = Place { file: "sweep".into(), text: "".into(), span: 0..0 };
        let mut compared = 0;
        let keys = KEYS.iter().map(KeyAt::from).chain(scenario.values().layer_keys());
        for key in keys.filter(|key| sections.iter().any(|section| key.path.starts_with(section))) {
            let is_good = |value: &Value| Value::accept(&key.kind, &value.to_toml()).is_some();
            let values: Vec<Value> = trial_values(&key, &scenario).into_iter().filter(is_good).collect();
            // Skip a key without a valid first value.
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
    fn the_factory_agrees_with_a_file_for_every_key() {
        assert!(count_compared("layers/skin-augmented", &[""]) > 300);
        assert!(count_compared("link/four-channel", &["controller", "scaling", "slave", "master", "passivity"]) > 30);
        assert!(count_compared("paper/depth-augmented", &["tissue.presliding", "scaling", "operator.start"]) > 5);
    }

    #[test]
    fn an_open_key_of_a_layer_may_lack_an_effect_but_must_name_a_layer() {
        let base = Source::parse("layers/skin-augmented");
        let open = |path: &str| {
            let place = Place { file: "sweep".into(), text: "".into(), span: 0..0 };
            let key = super::super::find_key(path).expect("a key");
            Template::new(&base, vec![], &[], &[(key, Value::Number(100.0), place)]).map_err(|error| error.message)
        };
        // The caller reports an axis without effect.
        assert!(open("tissue.layer.skin.toughness_j_per_m2").is_ok());
        let stray = open("tissue.layer.dura.friction_n_per_m").expect_err("no such layer");
        assert_eq!(stray, "there is no layer dura in [[tissue.layer]]");
    }
}
