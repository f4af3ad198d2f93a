use super::file::Size;
use super::problem::Problem;
use crate::compare::Person;
use crate::sweep::{Axis, Design, SamplingScheme, mix};
use trocar_scenario::{CaseFactory, Entry, Scenario, ScenarioError, Template, Value};

/// Separates the judged patients' random numbers from those of the search.
const FRESH: u64 = 0x6672_6573_6800;

/// Distance of the judged patients' noise seeds from those of the search.
const FRESH_SEEDS: u64 = 1 << 40;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Use {
    /// A Latin hypercube over the distributions.
    Training,
    /// Independent random patients with other noise.
    Validation,
}

/// Ordered by patient, person, seed. All candidates share the runs (common random numbers).
#[derive(Debug)]
pub struct Population {
    templates: Vec<Template>,
    persons: Vec<&'static Person>,
    seeds: u64,
    first_seed: u64,
    /// One per patient and person.
    prototypes: Vec<Scenario>,
}

impl Population {
    /// `settings` take precedence.
    pub fn of(problem: &Problem, used: Use, free: &[Axis], settings: &[String]) -> Result<Self, ScenarioError> {
        let Size { patients, seeds } = match used {
            Use::Training => problem.training,
            Use::Validation => problem.validation,
        };
        let differs = !problem.patients.is_empty() || problem.persons.iter().any(|person| person.group.is_some());
        let patients = if differs { patients } else { 1 };
        let (scheme, first_seed) = match used {
            Use::Training => (SamplingScheme::LatinHypercube { points: patients, seed: problem.seed }, problem.seed),
            Use::Validation => (
                SamplingScheme::Random { points: patients, seed: mix(problem.seed ^ FRESH) },
                problem.seed + FRESH_SEEDS,
            ),
        };
        let design = Design {
            name: String::new(),
            question: None,
            axes: problem.patients.clone(),
            correlations: problem.correlations.clone(),
            scheme,
            seeds: 1,
            first_seed: 0,
            listed_seeds: None,
            columns: vec![],
            focus: vec![],
            csv: false,
        };
        let open: Vec<&Axis> = free.iter().collect();
        let template = |patient: usize| {
            let (mut coordinates, mut values) = (vec![], vec![]);
            design.coordinates().values(patient as u64, &mut coordinates, &mut values);
            let entries = design.axes.iter().zip(&values).map(|(axis, value)| entry(axis, value, problem)).collect();
            problem.template(&open, entries, settings)
        };
        let templates = trocar_base::parallel::try_map(patients as usize, template)?;
        let mut population =
            Self { templates, persons: problem.persons.clone(), seeds, first_seed, prototypes: vec![] };
        let persons = population.persons_of_patient();
        let prototype = |index: usize| -> Result<Scenario, ScenarioError> {
            let (patient, person) = (index / persons, index % persons);
            let mut scenario = population.templates[patient].first().clone();
            population.operate(&mut scenario, patient, person);
            scenario.renew_steps();
            // Computes the steps; a candidate may be valid if the first values of the free keys are not.
            let _ = scenario.build();
            Ok(scenario)
        };
        let prototypes = trocar_base::parallel::try_map(population.templates.len() * persons, prototype)?;
        population.prototypes = prototypes;
        Ok(population)
    }

    pub fn patients(&self) -> usize {
        self.templates.len()
    }

    pub fn runs(&self) -> usize {
        self.templates.len() * self.runs_of_patient()
    }

    pub fn runs_of_patient(&self) -> usize {
        self.persons_of_patient() * self.seeds as usize
    }

    /// Those of a patient, or of a seed if there is only one patient.
    pub fn clusters(&self) -> Vec<Vec<usize>> {
        let of_patient = self.runs_of_patient();
        if self.patients() > 1 {
            return (0..self.patients())
                .map(|patient| (patient * of_patient..(patient + 1) * of_patient).collect())
                .collect();
        }
        let seeds = self.seeds as usize;
        (0..seeds).map(|seed| (seed..of_patient).step_by(seeds).collect()).collect()
    }

    pub(super) fn persons_of_patient(&self) -> usize {
        self.persons.len().max(1)
    }

    pub(super) fn factory(&self, patient: usize) -> CaseFactory<'_> {
        self.templates[patient].factory()
    }

    pub(super) fn factories(&self) -> Vec<CaseFactory<'_>> {
        self.templates.iter().map(Template::factory).collect()
    }

    pub(super) fn with_persons(
        &self,
        factory: &mut CaseFactory<'_>,
        patient: usize,
        values: &[Value],
    ) -> Result<Vec<Scenario>, ScenarioError> {
        let first = factory.build(values, self.first_seed)?;
        let of_person = |person: usize| {
            let mut scenario = first.clone();
            self.operate(&mut scenario, patient, person);
            scenario.share_steps(&self.prototypes[patient * self.persons_of_patient() + person]);
            scenario
        };
        Ok((0..self.persons_of_patient()).map(of_person).collect())
    }

    pub(super) fn with_seeds(&self, patient: usize, firsts: &[Scenario]) -> Vec<Scenario> {
        let seed = |offset: u64| self.first_seed + patient as u64 * self.seeds + offset;
        let with_seed = |first: &Scenario, offset: u64| {
            let mut scenario = first.clone();
            scenario.seed = seed(offset);
            scenario
        };
        firsts.iter().flat_map(|first| (0..self.seeds).map(|offset| with_seed(first, offset))).collect()
    }

    fn operate(&self, scenario: &mut Scenario, patient: usize, person: usize) {
        if let Some(person) = self.persons.get(person) {
            scenario.seed = self.first_seed;
            person.replace_operator(scenario, patient as u64);
        }
    }
}

fn entry(axis: &Axis, value: &Value, problem: &Problem) -> Entry {
    let value = value.to_toml();
    Entry {
        path: axis.key.path.to_string(),
        written: value.to_string(),
        value,
        key_place: axis.place.clone(),
        value_place: axis.place.clone(),
        source: problem.base().clone(),
        layer: 0,
    }
}
