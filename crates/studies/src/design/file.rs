use super::goals::{Constraint, Direction, Goals, Limit, Objective};
use super::quantity::{Aggregate, NoQuantity, Quantity};
use crate::compare::{PERSONS, Person};
use crate::sweep::{
    Axis, Correlation, Levels, SamplingScheme, Section, axes_of, correlations_of, line_of, must, name_of, texts, whole,
    within,
};
use trocar_scenario::{Entry, Place, ScenarioError, find_key, nearest_of};

pub const DESIGN_KEYS: [(&str, &str); 27] = [
    ("name", "Name of the design's folder; default: the file name without extension."),
    ("question", "The question that the design answers, for its report."),
    ("base", "The scenario to design: a path relative to this file, or a shipped one."),
    (
        "population",
        "A sweep file instead of base, [patients] and [correlations]: its base, [set], axes and correlations; the points \
         of its axes are the patients.",
    ),
    (
        "persons",
        "Persons or groups of people who operate, as in `trocar strategies --persons`; every patient is operated by each. \
         Default: the operator of the scenario.",
    ),
    ("set", "Keys of the scenario with the same value in all runs, as in set.simulation.duration_s = 7.0."),
    (
        "patients",
        "Keys that differ from patient to patient and from hand to hand: { median, spread }, { from, to, log } or a list.",
    ),
    ("correlations.NAME.axes", "Keys of [patients] that vary together, as a list."),
    (
        "correlations.NAME.coefficient",
        "Correlation of each pair of these keys, after their transformation to normal variables.",
    ),
    ("free", "Keys to design: { from, to, log } or a list of choices."),
    ("objectives.NAME.minimise", "The metric that is minimised."),
    ("objectives.NAME.maximise", "The metric that is maximised, instead of minimise."),
    ("objectives.NAME.quantile", "Quantile of the metric over all runs, from 0 to 1; default: the mean."),
    ("constraints.NAME.metric", "The metric that is limited."),
    ("constraints.NAME.at_least", "Smallest allowed value."),
    ("constraints.NAME.at_most", "Largest allowed value, instead of at_least."),
    ("constraints.NAME.quantile", "Quantile of the metric over all runs, from 0 to 1; default: the mean."),
    (
        "constraints.NAME.certified",
        "true instead of a metric: the certificate of events states that every motion decays, for every patient.",
    ),
    ("training.patients", "Number of patients of the search; default: 16, and 1 if nothing differs between patients."),
    ("training.seeds", "Number of noise seeds of each patient and person in the search; default: 1."),
    ("training.seed", "First seed of patients and noise; default: 1."),
    ("validation.patients", "Number of other patients on whom the results are judged; default: 100."),
    ("validation.seeds", "Number of noise seeds of each of these patients and persons; default: 5."),
    ("search.candidates", "Number of candidates of a generation; default: 48."),
    ("search.generations", "Number of generations, including the first, random one; default: 30."),
    ("search.seed", "Seed of the search; default: 1."),
    ("search.front", "Largest number of shown designs; default: 8."),
];

const FREE_FORMS: &str = "a list of choices, as in [\"ramp\", \"snap\"], or { from = 0.5, to = 2.0, log = true }";

const PATIENTS: Section = Section {
    name: "patients",
    role: "a key of [patients]",
    forms: "a list, as in [1.0, 2.0], or { from = 0.5, to = 2.0, log = true }, or { median = 1.0, spread = 1.5 }",
    words: "it has from, to and log, or median and spread",
    seeds: "give training.seeds and validation.seeds",
    without_points: "remove them: training.patients and validation.patients give the numbers of patients",
};

const FREE: Section = Section {
    name: "free",
    role: "a free key",
    forms: FREE_FORMS,
    words: "it has from, to and log",
    seeds: "give training.seeds and validation.seeds",
    without_points: "remove them: the search chooses any value between from and to, or give a list",
};

const MAX_PATIENTS: u64 = 10_000;
const MAX_SEEDS: u64 = 10_000;
const MAX_CANDIDATES: u64 = 10_000;
const MAX_GENERATIONS: u64 = 100_000;
const MAX_FRONT: u64 = 99;
const MAX_OBJECTIVES: usize = 6;
const MAX_FREE: usize = 64;
const MAX_SEED: u64 = i64::MAX as u64 >> 1;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Size {
    pub patients: u64,
    pub seeds: u64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SearchSettings {
    pub candidates: usize,
    pub generations: u64,
    pub seed: u64,
    pub front: usize,
}

#[derive(Debug)]
pub(super) struct DesignFile {
    pub(super) name: Option<String>,
    pub(super) question: Option<String>,
    pub(super) base: Option<Entry>,
    pub(super) population: Option<Entry>,
    pub(super) persons: Vec<&'static Person>,
    pub(super) set: Vec<Entry>,
    pub(super) patients: Vec<Axis>,
    pub(super) correlations: Vec<Correlation>,
    pub(super) free: Vec<Axis>,
    pub(super) goals: Goals,
    pub(super) training: Size,
    pub(super) seed: u64,
    pub(super) validation: Size,
    pub(super) search: SearchSettings,
}

/// Any scheme without points on its axes.
const DRAWN: SamplingScheme = SamplingScheme::LatinHypercube { points: 1, seed: 1 };

const SECTIONS: [&str; 6] = ["set", "patients", "correlations", "free", "objectives", "constraints"];

impl DesignFile {
    pub(super) fn of(mut entries: Vec<Entry>) -> Result<Self, ScenarioError> {
        let is_bare = |entry: &Entry| entry.value.as_table().is_some_and(|table| table.is_empty());
        entries.retain(|entry| !is_bare(entry));
        // A key is the same with and without quotes.
        entries.iter_mut().for_each(|entry| entry.path.retain(|letter| letter != '"'));
        entries.sort_by_key(|entry| entry.key_place.span.start);
        let [set, patients, correlations, free, objectives, constraints] = SECTIONS.map(|name| {
            let in_section = |entry: &&Entry| entry.path.strip_prefix(name).is_some_and(|rest| rest.starts_with('.'));
            entries.iter().filter(in_section).cloned().collect::<Vec<Entry>>()
        });
        let in_sections = |entry: &Entry| SECTIONS.iter().any(|name| entry.path.starts_with(&format!("{name}.")));
        entries.retain(|entry| !in_sections(entry));
        if let Some(entry) = entries.iter().find(|entry| !is_plain(&entry.path)) {
            return Err(unknown(entry));
        }
        let find = |path: &str| entries.iter().find(|entry| entry.path == path);
        let patients = axes_of(&patients, DRAWN, &PATIENTS)?;
        let free = free_keys(&free, &patients)?;
        if let (Some(population), Some(other)) = (find("population"), find("base")) {
            return Err(twice(population, other));
        }
        if let (Some(population), Some(axis)) = (find("population"), patients.first()) {
            let message = "population is given, and [patients] as well";
            return Err(ScenarioError::new(message)
                .at(Some(axis.place.clone()))
                .remedy(format!("remove one of them: the patients are the axes of {}", population.written)));
        }
        let number = |path: &str, default: u64, (min, max): (u64, u64)| {
            find(path).map_or(Ok(default), |entry| whole(entry, min, max))
        };
        let sizes = |section: &str, patients: u64, seeds: u64| -> Result<Size, ScenarioError> {
            Ok(Size {
                patients: number(&format!("{section}.patients"), patients, (1, MAX_PATIENTS))?,
                seeds: number(&format!("{section}.seeds"), seeds, (1, MAX_SEEDS))?,
            })
        };
        let strip = |mut entry: Entry| {
            entry.path.replace_range(..4, "");
            entry
        };
        Ok(Self {
            name: find("name").map(name_of).transpose()?,
            question: find("question").map(line_of).transpose()?,
            base: find("base").cloned(),
            population: find("population").cloned(),
            persons: find("persons").map_or(Ok(vec![]), persons)?,
            set: set.into_iter().map(strip).collect(),
            correlations: correlations_of(&correlations, &patients, DRAWN)?,
            patients,
            free,
            goals: goals(&objectives, &constraints)?,
            training: sizes("training", 16, 1)?,
            seed: number("training.seed", 1, (0, MAX_SEED))?,
            validation: sizes("validation", 100, 5)?,
            search: SearchSettings {
                candidates: number("search.candidates", 48, (4, MAX_CANDIDATES))? as usize,
                generations: number("search.generations", 30, (1, MAX_GENERATIONS))?,
                seed: number("search.seed", 1, (0, MAX_SEED))?,
                front: number("search.front", 8, (1, MAX_FRONT))? as usize,
            },
        })
    }
}

const PLAIN: [&str; 14] = [
    "name",
    "question",
    "base",
    "population",
    "persons",
    "training.patients",
    "training.seeds",
    "training.seed",
    "validation.patients",
    "validation.seeds",
    "search.candidates",
    "search.generations",
    "search.seed",
    "search.front",
];

fn is_plain(path: &str) -> bool {
    PLAIN.contains(&path)
}

fn unknown(entry: &Entry) -> ScenarioError {
    let path = entry.path.as_str();
    let place = Some(entry.key_place.clone());
    if SECTIONS.contains(&path) || matches!(path, "training" | "validation" | "search") {
        let message = format!("{path} is {}, must be a section of keys", entry.written);
        return ScenarioError::new(message).at(place).remedy(format!("write [{path}] and its keys below"));
    }
    let error = ScenarioError::new(format!("a design has no key {path}")).at(place);
    if path.starts_with("axes.") {
        return error
            .remedy("a design has [patients] for what differs between patients, and [free] for what is designed");
    }
    if find_key(path).is_some() {
        return error.remedy(format!("write free.{path} to design it, set.{path} to fix it"));
    }
    match nearest_of(path, PLAIN.into_iter().chain(SECTIONS)) {
        Some(best) => error.remedy(format!("did you mean {best}?")),
        None => error.remedy("`trocar design --help` lists all of them"),
    }
}

fn twice(population: &Entry, other: &Entry) -> ScenarioError {
    ScenarioError::new(format!("population is given, and {} as well", other.path))
        .at(Some(other.key_place.clone()))
        .remedy(format!("remove one of them: the scenario is the base of {}", population.written))
}

fn persons(entry: &Entry) -> Result<Vec<&'static Person>, ScenarioError> {
    let mut persons: Vec<&'static Person> = vec![];
    for name in texts(entry)? {
        let Some(person) = Person::named(name) else {
            let error = ScenarioError::new(format!("there is no person {name}")).at(Some(within(entry, name)));
            let names = PERSONS.map(|person| person.name);
            return Err(match nearest_of(name, names) {
                Some(near) => error.remedy(format!("did you mean {near}?")),
                None => error.remedy(format!("it must be one of {}", names.join(", "))),
            });
        };
        if persons.iter().any(|other| other.name == name) {
            let message = format!("the person {name} is listed twice");
            return Err(ScenarioError::new(message).at(Some(within(entry, name))));
        }
        persons.push(person);
    }
    Ok(persons)
}

fn free_keys(entries: &[Entry], patients: &[Axis]) -> Result<Vec<Axis>, ScenarioError> {
    let free = axes_of(entries, DRAWN, &FREE)?;
    for axis in &free {
        let refuse = |message: String| ScenarioError::new(message).at(Some(axis.place.clone()));
        if let Levels::LogNormal { .. } = axis.levels {
            return Err(refuse(format!("free.{} is a distribution, must be {FREE_FORMS}", axis.key.path)));
        }
        if axis.count() == Some(1) {
            return Err(refuse(format!("free.{} has one choice only", axis.key.path))
                .remedy(format!("write set.{} to fix it", axis.key.path)));
        }
        if patients.iter().any(|other| other.key.path == axis.key.path) {
            return Err(refuse(format!("{} is both free and in [patients]", axis.key.path))
                .remedy("remove one of them: a design cannot choose what belongs to a patient"));
        }
    }
    if free.is_empty() {
        return Err(ScenarioError::new("a design needs at least one free key").remedy(
            "write [free] with keys and their ranges, as in augmentation.min_hold_s = { from = 0.1, to = 1.0 }",
        ));
    }
    if let Some(beyond) = free.get(MAX_FREE) {
        let message = format!("more than {MAX_FREE} free keys");
        return Err(ScenarioError::new(message)
            .at(Some(beyond.place.clone()))
            .remedy("fix the less important ones with set"));
    }
    Ok(free)
}

struct Group<'a> {
    name: &'a str,
    entries: Vec<(&'a str, &'a Entry)>,
}

impl<'a> Group<'a> {
    fn all(entries: &'a [Entry], section: &str, words: &[&str]) -> Result<Vec<Self>, ScenarioError> {
        let mut groups: Vec<Self> = vec![];
        for entry in entries {
            let refuse = |message: String| ScenarioError::new(message).at(Some(entry.key_place.clone()));
            let Some((name, word)) = entry.path[section.len() + 1..].rsplit_once('.') else {
                return Err(refuse(format!("{} is {}, must be a section", entry.path, entry.written))
                    .remedy(format!("write [{section}.NAME] with {} below", words.join(", "))));
            };
            if !words.contains(&word) {
                let error = refuse(format!("{section}.{name} has no key {word}"));
                return Err(match nearest_of(word, words) {
                    Some(near) => error.remedy(format!("did you mean {near}?")),
                    None => error.remedy(format!("it has {}", words.join(", "))),
                });
            }
            if groups.last().is_none_or(|last| last.name != name) {
                groups.push(Self { name, entries: vec![] });
            }
            let Some(group) = groups.last_mut() else { continue };
            group.entries.push((word, entry));
        }
        Ok(groups)
    }

    fn find(&self, word: &str) -> Option<&'a Entry> {
        self.entries.iter().find(|(known, _)| *known == word).map(|(_, entry)| *entry)
    }

    fn one(&self, section: &str, words: &[&'static str]) -> Result<(&'static str, &'a Entry), ScenarioError> {
        let given: Vec<(&'static str, &Entry)> =
            words.iter().filter_map(|word| Some((*word, self.find(word)?))).collect();
        let place = || self.entries.first().map(|(_, entry)| entry.key_place.clone());
        match given[..] {
            [one] => Ok(one),
            [] => Err(ScenarioError::new(format!("{section}.{} needs {}", self.name, words.join(" or "))).at(place())),
            [_, (word, entry), ..] => {
                let message = format!("{section}.{} has {} and {word}", self.name, given[0].0);
                Err(ScenarioError::new(message).at(Some(entry.key_place.clone())).remedy("remove one of them"))
            }
        }
    }

    fn aggregate(&self, quantity: &Quantity) -> Result<Aggregate, ScenarioError> {
        let Some(entry) = self.find("quantile") else { return Ok(Aggregate::Mean) };
        if quantity.is_relative() {
            let message = format!("{} is one number for all runs and has no quantile", quantity.name);
            return Err(ScenarioError::new(message).at(Some(entry.key_place.clone())).remedy("remove quantile"));
        }
        match number(entry)? {
            share if (0.0..=1.0).contains(&share) => Ok(Aggregate::Quantile(share)),
            _ => Err(must(entry, "a number from 0 to 1")),
        }
    }
}

fn number(entry: &Entry) -> Result<f64, ScenarioError> {
    let number = entry.value.as_float().or_else(|| entry.value.as_integer().map(|whole| whole as f64));
    number.filter(|number| number.is_finite()).ok_or_else(|| must(entry, "a number"))
}

fn quantity(entry: &Entry) -> Result<Quantity, ScenarioError> {
    let Some(name) = entry.value.as_str() else { return Err(must(entry, "the name of a metric")) };
    let refuse = |message: String| ScenarioError::new(message).at(Some(entry.value_place.clone()));
    Quantity::named(name).map_err(|why| match why {
        NoQuantity::Unknown(Some(near)) => {
            refuse(format!("there is no metric {name}")).remedy(format!("did you mean {near}?"))
        }
        NoQuantity::Unknown(None) => {
            refuse(format!("there is no metric {name}")).remedy("`trocar design --help` lists all of them")
        }
        NoQuantity::Refused(reason) => refuse(format!("a design cannot use {name}: {reason}")),
    })
}

fn goals(objectives: &[Entry], constraints: &[Entry]) -> Result<Goals, ScenarioError> {
    const OBJECTIVE: [&str; 3] = ["minimise", "maximise", "quantile"];
    const CONSTRAINT: [&str; 5] = ["metric", "certified", "at_least", "at_most", "quantile"];
    let mut goals = Goals { objectives: vec![], constraints: vec![], certified: None };
    for group in Group::all(objectives, "objectives", &OBJECTIVE)? {
        let (word, entry) = group.one("objectives", &OBJECTIVE[..2])?;
        let quantity = quantity(entry)?;
        let direction = if word == "minimise" { Direction::Minimise } else { Direction::Maximise };
        unique(group.name, goals.objectives.iter().map(|other| other.name.as_str()), &entry.key_place)?;
        let aggregate = group.aggregate(&quantity)?;
        goals.objectives.push(Objective { name: group.name.to_owned(), quantity, aggregate, direction });
    }
    for group in Group::all(constraints, "constraints", &CONSTRAINT)? {
        let (word, entry) = group.one("constraints", &CONSTRAINT[..2])?;
        unique(group.name, goals.constraints.iter().map(|other| other.name.as_str()), &entry.key_place)?;
        if word == "certified" {
            if entry.value.as_bool() != Some(true) {
                return Err(must(entry, "true").remedy("remove the constraint if no certificate is needed"));
            }
            if let Some((_, other)) = group.entries.iter().find(|(word, _)| *word != "certified") {
                let message = format!(
                    "constraints.{} is certified = true, which has no {}",
                    group.name,
                    other.path.rsplit('.').next().unwrap_or_default()
                );
                return Err(ScenarioError::new(message).at(Some(other.key_place.clone())).remedy("remove it"));
            }
            if goals.certified.is_some() {
                return Err(ScenarioError::new("certified is required twice").at(Some(entry.key_place.clone())));
            }
            goals.certified = Some(group.name.to_owned());
            continue;
        }
        let quantity = quantity(entry)?;
        let (side, limit) = group.one("constraints", &["at_least", "at_most"])?;
        let limit = number(limit)?;
        let limit = if side == "at_least" { Limit::AtLeast(limit) } else { Limit::AtMost(limit) };
        let aggregate = group.aggregate(&quantity)?;
        goals.constraints.push(Constraint { name: group.name.to_owned(), quantity, aggregate, limit });
    }
    if goals.objectives.is_empty() {
        return Err(ScenarioError::new("a design needs at least one objective")
            .remedy("write [objectives.NAME] with minimise = \"METRIC\" or maximise = \"METRIC\" below"));
    }
    if goals.objectives.len() > MAX_OBJECTIVES {
        return Err(ScenarioError::new(format!("a design has at most {MAX_OBJECTIVES} objectives"))
            .remedy("make constraints of the less important ones"));
    }
    Ok(goals)
}

fn unique<'a>(name: &str, mut others: impl Iterator<Item = &'a str>, place: &Place) -> Result<(), ScenarioError> {
    if others.any(|other| other == name) {
        return Err(ScenarioError::new(format!("{name} is in two places of the file"))
            .at(Some(place.clone()))
            .remedy("write its keys below one heading"));
    }
    Ok(())
}
