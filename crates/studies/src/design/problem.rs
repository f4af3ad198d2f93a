use std::fmt::Write as _;

use sha2::{Digest, Sha256};

use super::file::{DesignFile, SearchSettings, Size};
use super::goals::{Goals, Limit};
use super::nsga::Gene;
use super::quantity::Aggregate;
use crate::compare::{PERCEIVING, Person};
use crate::sweep::{
    Axis, Correlation, Levels, SweptPopulation, check_acting, hash_signals, resolved_toml, scenario_of, sha256,
};
use trocar_scenario::{
    Entry, Place, Scenario, ScenarioError, Source, Template, Value, entries, harmless_name, is_design_goal,
};

#[derive(Debug, Clone)]
pub struct Problem {
    pub name: String,
    pub question: Option<String>,
    /// Empty for the operator of the scenario.
    pub persons: Vec<&'static Person>,
    pub patients: Vec<Axis>,
    pub correlations: Vec<Correlation>,
    pub free: Vec<Axis>,
    pub goals: Goals,
    pub training: Size,
    /// The first seed of patients and noise.
    pub seed: u64,
    pub validation: Size,
    pub search: SearchSettings,
    base: Source,
    base_place: Place,
    set: Vec<Entry>,
    settings: Vec<String>,
    canonical: String,
}

pub fn is_design(source: &Source) -> bool {
    entries(source).is_ok_and(|entries| entries.iter().any(is_design_goal))
}

impl Problem {
    /// `settings` override the file.
    pub fn load(source: &Source, settings: &[String]) -> Result<Self, ScenarioError> {
        let file = DesignFile::of(entries(source)?)?;
        let no_base = || {
            ScenarioError::new(format!("{}: base is missing; it names the scenario to design", source.display()))
                .remedy("write base = \"layers/skin-augmented\", or a path, or population with a sweep file")
        };
        let (mut set, mut patients, mut correlations) = (file.set, file.patients, file.correlations);
        let (base, base_place) = match (&file.population, &file.base) {
            (Some(population), _) => {
                let (sweep, _) = scenario_of(population, source)?;
                let swept = SweptPopulation::of(&sweep)?;
                // The first of equal keys applies.
                set.extend(swept.set);
                (patients, correlations) = (swept.axes, swept.correlations);
                swept.base
            }
            (None, Some(base)) => scenario_of(base, source)?,
            (None, None) => return Err(no_base()),
        };
        for axis in &file.free {
            if let Some(fixed) = set.iter().find(|entry| entry.path == axis.key.path) {
                let message = format!("{} is both free and set", axis.key.path);
                return Err(ScenarioError::new(message)
                    .at(Some(fixed.value_place.clone()))
                    .remedy("remove one of them"));
            }
        }
        let mut problem = Self {
            name: file.name.unwrap_or_else(|| harmless_name(&source.stem())),
            question: file.question,
            persons: file.persons,
            patients,
            correlations,
            free: file.free,
            goals: file.goals,
            training: file.training,
            seed: file.seed,
            validation: file.validation,
            search: file.search,
            base,
            base_place,
            set,
            settings: settings.to_vec(),
            canonical: String::new(),
        };
        let open: Vec<&Axis> = problem.patients.iter().chain(&problem.free).collect();
        let template = problem.template(&open, vec![], &[])?;
        check_acting(&problem.free, &problem.patients, template.first(), "free")?;
        check_acting(&problem.patients, &problem.free, template.first(), "patients")?;
        let mut signals = Sha256::new();
        hash_signals(template.first(), &mut signals);
        problem.canonical = problem.to_toml() + &resolved_toml(template.first(), signals);
        Ok(problem)
    }

    /// All inputs of the design. Equal texts mean equal results.
    pub fn canonical(&self) -> &str {
        &self.canonical
    }

    /// The SHA-256 of [`Problem::canonical`], hexadecimal.
    pub fn hash(&self) -> String {
        sha256(self.canonical.as_bytes())
    }

    pub fn base(&self) -> &Source {
        &self.base
    }

    /// The first values of the free keys and of the patients' keys.
    pub fn example(&self) -> Result<Scenario, ScenarioError> {
        let open: Vec<&Axis> = self.patients.iter().chain(&self.free).collect();
        Ok(self.template(&open, vec![], &[])?.first().clone())
    }

    pub(super) fn fixed(&self) -> (&[Entry], &[String]) {
        (&self.set, &self.settings)
    }

    pub(super) fn without_fixed(&self, section: &str) -> Self {
        let mut other = self.clone();
        other.set.retain(|entry| !entry.path.starts_with(section));
        other
    }

    pub fn genes(&self) -> Vec<Gene> {
        let gene = |axis: &Axis| match &axis.levels {
            Levels::List(list) => Gene::Choice(list.len() as u64),
            Levels::Range { .. } | Levels::LogNormal { .. } => Gene::Number,
        };
        self.free.iter().map(gene).collect()
    }

    /// `coordinates` are from 0 to below 1.
    pub fn values(&self, coordinates: &[f64]) -> Vec<Value> {
        self.free.iter().zip(coordinates).map(|(axis, coordinate)| axis.value(*coordinate)).collect()
    }

    /// The entries and settings take precedence.
    pub(super) fn template(
        &self,
        open: &[&Axis],
        entries: Vec<Entry>,
        settings: &[String],
    ) -> Result<Template, ScenarioError> {
        let open: Vec<_> = open.iter().map(|axis| (axis.key.clone(), axis.first(), axis.place.clone())).collect();
        let mut all = self.settings.clone();
        if !self.persons.is_empty() {
            all.extend(PERCEIVING.map(str::to_owned));
        }
        all.extend_from_slice(settings);
        let entries = entries.into_iter().chain(self.set.iter().cloned()).collect();
        let template = Template::new(&self.base, entries, &all, &open);
        template.map_err(|error| if error.place.is_some() { error } else { error.at(Some(self.base_place.clone())) })
    }

    fn to_toml(&self) -> String {
        let mut text = format!("name = {:?}\n", self.name);
        let mut line = |line: String| {
            text.push_str(&line);
            text.push('\n');
        };
        if let Some(question) = &self.question {
            line(format!("question = {}", toml::Value::String(question.clone())));
        }
        if !self.persons.is_empty() {
            line(format!("persons = {:?}", self.persons.iter().map(|person| person.name).collect::<Vec<_>>()));
        }
        for (section, axes) in [("patients", &self.patients), ("free", &self.free)] {
            line(format!("\n[{section}]"));
            axes.iter().for_each(|axis| line(format!("{} = {}", axis.key.path, axis.to_toml())));
        }
        for Correlation { name, axes, coefficient } in &self.correlations {
            let paths: Vec<&str> = axes.iter().map(|axis| self.patients[*axis].key.path.as_ref()).collect();
            line(format!("\n[correlations.{name}]\naxes = {paths:?}\ncoefficient = {coefficient:?}"));
        }
        let quantile = |aggregate: Aggregate| match aggregate {
            Aggregate::Mean => String::new(),
            Aggregate::Quantile(share) => format!("\nquantile = {share:?}"),
        };
        for objective in &self.goals.objectives {
            let (word, metric) = (objective.direction.word(), &objective.quantity.name);
            line(format!("\n[objectives.{}]\n{word} = {metric:?}{}", objective.name, quantile(objective.aggregate)));
        }
        for constraint in &self.goals.constraints {
            let limit = match constraint.limit {
                Limit::AtLeast(limit) => format!("at_least = {limit:?}"),
                Limit::AtMost(limit) => format!("at_most = {limit:?}"),
            };
            let (name, metric) = (&constraint.name, &constraint.quantity.name);
            line(format!("\n[constraints.{name}]\nmetric = {metric:?}\n{limit}{}", quantile(constraint.aggregate)));
        }
        if let Some(name) = &self.goals.certified {
            line(format!("\n[constraints.{name}]\ncertified = true"));
        }
        let SearchSettings { candidates, generations, seed, front } = self.search;
        let _ = write!(
            text,
            "\n[training]\npatients = {}\nseeds = {}\nseed = {}\n\n[validation]\npatients = {}\nseeds = {}\n\n[search]\n\
             candidates = {candidates}\ngenerations = {generations}\nseed = {seed}\nfront = {front}\n",
            self.training.patients, self.training.seeds, self.seed, self.validation.patients, self.validation.seeds,
        );
        text
    }
}
