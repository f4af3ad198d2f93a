use std::borrow::Cow;

use super::state::{Catalogue, SCHEME, State, StateError, bounded};
use trocar_scenario::{KeyAt, Place, Scenario, Template, Value, Values, find_key};
use trocar_studies::compare::{NoiseCheck, check_in_noise};
use trocar_studies::run::{Run, RunError, run};

pub const SCHEMES: [&str; 2] = ["classical", "augmented"];

#[derive(Debug, Clone)]
pub struct Pair {
    /// Classical, augmented.
    pub runs: [Run; 2],
}

impl Pair {
    /// Computes the noise checks of both runs, which `compare` adds to its table.
    pub fn in_noise(&self) -> Result<Vec<NoiseCheck>, RunError> {
        self.runs.iter().map(|run| check_in_noise(&run.scenario)).collect()
    }
}

/// Caches the last scenario with its recording, so a slider reads no file.
#[derive(Debug)]
pub struct PairMaker {
    catalogue: Catalogue,
    cached: Option<Cached>,
}

#[derive(Debug)]
struct Cached {
    scenario: String,
    paths: Vec<Cow<'static, str>>,
    template: Template,
    /// True if the scenario itself is augmented.
    is_augmented: bool,
}

impl PairMaker {
    pub fn new(catalogue: Catalogue) -> Self {
        Self { catalogue, cached: None }
    }

    /// Their [`Scenario::values`] are those of the first cached state.
    pub fn scenarios(&mut self, state: &State) -> Result<[Scenario; 2], StateError> {
        let (template, values, seed) = self.template(state)?;
        let mut factory = template.factory();
        let mut build = |enabled: bool| -> Result<Scenario, StateError> {
            let mut scenario = factory.build(&scheme(&values, enabled), seed)?;
            SCHEMES[usize::from(enabled)].clone_into(&mut scenario.name);
            bounded(scenario)
        };
        Ok([build(false)?, build(true)?])
    }

    /// A scenario of a state with its own values, to be written to a file.
    pub fn written(&mut self, state: &State, enabled: bool) -> Result<Scenario, StateError> {
        let (template, values, seed) = self.template(state)?;
        bounded(template.whole(&scheme(&values, enabled), seed)?)
    }

    /// The scenario of a state with the augmentation as its file sets it.
    pub fn unpaired(&mut self, state: &State) -> Result<Scenario, StateError> {
        self.template(state)?;
        let is_augmented = self.cached.as_ref().is_some_and(|cached| cached.is_augmented);
        self.written(state, is_augmented)
    }

    pub fn run(&mut self, state: &State) -> Result<Pair, StateError> {
        let [classical, augmented] = self.scenarios(state)?;
        let (classical, augmented) = std::thread::scope(|scope| {
            let other = scope.spawn(|| run(classical));
            let augmented = run(augmented);
            (other.join(), augmented)
        });
        // Propagate a panic of the thread.
        let classical = classical.unwrap_or_else(|panic| std::panic::resume_unwind(panic));
        Ok(Pair { runs: [classical?, augmented?] })
    }

    fn template(&mut self, state: &State) -> Result<(&Template, Vec<Value>, u64), StateError> {
        let source = self.catalogue.source(&state.scenario)?;
        let mut given = state.values()?;
        let seed = given.iter().position(|(key, _)| key.path == "simulation.seed").map(|at| given.remove(at).1);
        let paths: Vec<_> = given.iter().map(|(key, _)| key.path.clone()).collect();
        let is_current = |cached: &Cached| cached.scenario == state.scenario && cached.paths == paths;
        if !self.cached.as_ref().is_some_and(is_current) {
            let place = || Place { file: "the page".into(), text: "".into(), span: 0..0 };
            let scheme = find_key(SCHEME).map(|key| (key, Value::Flag(true)));
            let all = scheme.into_iter().chain(given.iter().cloned());
            let open: Vec<(KeyAt, Value, Place)> = all.map(|(key, value)| (key, value, place())).collect();
            let template = Template::new(&source, vec![], &[], &open)?;
            let is_augmented = Values::load(&source, &[])?.get(SCHEME) == Some(&Value::Flag(true));
            self.cached = Some(Cached { scenario: state.scenario.clone(), paths, template, is_augmented });
        }
        let Some(cached) = &self.cached else { return Err(StateError::Scenario(state.scenario.clone())) };
        let seed = match seed {
            Some(Value::Whole(seed)) => seed,
            _ => cached.template.first().seed,
        };
        Ok((&cached.template, given.into_iter().map(|(_, value)| value).collect(), seed))
    }
}

/// The values of the open keys; the first is the scheme's.
fn scheme(values: &[Value], enabled: bool) -> Vec<Value> {
    std::iter::once(Value::Flag(enabled)).chain(values.iter().cloned()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use trocar_scenario::Source;

    #[test]
    fn a_page_and_the_command_line_give_the_same_runs() {
        let mut maker = PairMaker::new(Catalogue::new(None));
        let mut state = State { scenario: "builtin:paper/augmented.toml".into(), ..State::default() };
        for (key, value) in [("scaling.force", 1.5), ("augmentation.min_hold_s", 0.3), ("scaling.force", 0.8)] {
            state.set.insert(key.into(), value.into());
            let pair = maker.run(&state).expect("runs");
            for (shown, enabled) in pair.runs.iter().zip([false, true]) {
                let settings: Vec<String> = state.set.iter().map(|(key, value)| format!("{key}={value}")).collect();
                let scheme = [format!("augmentation.enabled={enabled}")];
                let scenario = Scenario::load_changed(&Source::parse("paper/augmented"), &[&settings, &scheme]);
                let scenario = scenario.expect("good");
                let expected = run(scenario).expect("runs");
                assert!(shown.trace == expected.trace && shown.metrics == expected.metrics, "{settings:?}");
                let written = maker.written(&state, enabled).expect("good");
                assert_eq!(written.echo(), expected.scenario.echo());
            }
        }
    }

    #[test]
    fn a_run_too_long_for_a_page_is_refused() {
        let mut maker = PairMaker::new(Catalogue::new(None));
        let set = [("simulation.duration_s".to_owned(), 900.into())].into();
        let state = State { scenario: "builtin:layers/skin-augmented.toml".into(), set };
        assert!(matches!(maker.run(&state), Err(StateError::Ticks(900_000))));
    }
}
