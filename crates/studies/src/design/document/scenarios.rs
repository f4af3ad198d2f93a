use std::fmt::Write as _;

use super::DesignStudy;
use super::tables::word;
use crate::design::validation::Designed;
use trocar_document::show;
use trocar_scenario::{Source, Value};

/// One file for each design, and `designed.toml` for the knee.
pub(super) fn files(study: &DesignStudy<'_>) -> Vec<(String, String)> {
    let mut files = vec![];
    for design in &study.validation.designs {
        files.push((
            format!("front/{}.toml", design.name),
            text(study, design, &format!("{}-{}", study.problem.name, design.name)),
        ));
    }
    if let Some(knee) = study.validation.designs.iter().find(|design| design.is_knee) {
        files.push(("designed.toml".to_owned(), text(study, knee, &format!("{}-designed", study.problem.name))));
    }
    files
}

fn text(study: &DesignStudy<'_>, design: &Designed, name: &str) -> String {
    let problem = study.problem;
    let values = problem.values(&design.candidate.coordinates);
    let results: Vec<String> = problem
        .goals
        .objectives
        .iter()
        .zip(&design.validation)
        .map(|(objective, estimate)| {
            let value = show(estimate.map(|estimate| estimate.value), objective.quantity.unit);
            format!("{} {value}", objective.name)
        })
        .collect();
    let mut text = format!(
        "# Designed by `trocar design`: {}{}. On {} other patients: {}.\n",
        if design.is_knee { "the knee of the front of " } else { "a design on the front of " },
        problem.name,
        study.fresh.population().patients(),
        results.join(", ")
    );
    if let Source::Builtin(base) = problem.base() {
        let _ = writeln!(text, "name = {name:?}\nbase = \"builtin:{base}\"");
        let (set, _) = problem.fixed();
        let fixed = set.iter().map(|entry| (entry.path.clone(), entry.value.to_string()));
        let free = problem
            .free
            .iter()
            .zip(&values)
            .map(|(axis, value)| (axis.key.path.to_string(), value.to_toml().to_string()));
        let persons = if problem.persons.is_empty() { vec![] } else { perceiving() };
        write_keys(&mut text, fixed.chain(persons).chain(free).collect());
        return text;
    }
    text + &whole(study, &values, name)
}

fn perceiving() -> Vec<(String, String)> {
    let split = |setting: &str| setting.split_once('=').map(|(key, word)| (key.to_owned(), format!("{word:?}")));
    crate::compare::PERCEIVING.iter().filter_map(|setting| split(setting)).collect()
}

/// The last value of a key applies.
fn write_keys(text: &mut String, keys: Vec<(String, String)>) {
    let mut sections: Vec<(String, Vec<(String, String)>)> = vec![];
    for (path, value) in keys {
        let (section, key) = path.rsplit_once('.').unwrap_or(("", &path));
        let place = match sections.iter().position(|(known, _)| known == section) {
            Some(place) => place,
            None => {
                sections.push((section.to_owned(), vec![]));
                sections.len() - 1
            }
        };
        let of_section = &mut sections[place].1;
        match of_section.iter_mut().find(|(known, _)| known == key) {
            Some((_, old)) => *old = value,
            None => of_section.push((key.to_owned(), value)),
        }
    }
    sections.sort_by_key(|(section, _)| !section.is_empty());
    for (section, keys) in sections {
        if !section.is_empty() {
            let _ = write!(text, "\n[{section}]\n");
        }
        for (key, value) in keys {
            let _ = writeln!(text, "{key} = {value}");
        }
    }
}

/// Every value, because the path to a base file depends on the folder.
fn whole(study: &DesignStudy<'_>, values: &[Value], name: &str) -> String {
    let problem = study.problem;
    let open: Vec<&crate::sweep::Axis> = problem.free.iter().collect();
    let settings = vec![format!("name={name:?}")];
    let scenario =
        problem.template(&open, vec![], &settings).and_then(|template| template.whole(values, template.first().seed));
    match scenario {
        Ok(scenario) => scenario.echo(),
        // The candidate is valid for its patients, but not for the base scenario.
        Err(error) => {
            let words: Vec<String> = values.iter().map(word).collect();
            format!("# {error}\n# {}\n", words.join(", "))
        }
    }
}
