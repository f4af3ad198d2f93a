use super::axis::{Axis, Levels, number};
use super::design::{MAX_CASES, SamplingScheme};
use super::file_values::{flag, must, whole};
use trocar_scenario::{Entry, KeyAt, Kind, ScenarioError, Value, find_key, nearest_key};

#[derive(Debug)]
pub(crate) struct Section {
    pub(crate) name: &'static str,
    pub(crate) role: &'static str,
    pub(crate) forms: &'static str,
    pub(crate) words: &'static str,
    pub(crate) seeds: &'static str,
    pub(crate) without_points: &'static str,
}

pub(super) const AXES: Section = Section {
    name: "axes",
    role: "an axis",
    forms: "a list, as in [1.0, 2.0], or { from = 0.5, to = 2.0, points = 16, log = true }, or \
            { median = 1.0, spread = 1.5 }",
    words: "it has from, to, points and log, or median and spread",
    seeds: "give seeds = N, and first_seed if needed",
    without_points: "remove them: design.points applies; or give a list",
};

#[derive(Default)]
struct RangeEntries<'a> {
    path: &'a str,
    from: Option<&'a Entry>,
    to: Option<&'a Entry>,
    points: Option<&'a Entry>,
    log: Option<&'a Entry>,
    median: Option<&'a Entry>,
    spread: Option<&'a Entry>,
}

pub(crate) fn axes_of(
    entries: &[Entry],
    scheme: SamplingScheme,
    section: &Section,
) -> Result<Vec<Axis>, ScenarioError> {
    let mut axes = vec![];
    let mut ranges: Vec<(usize, RangeEntries<'_>)> = vec![];
    for entry in entries {
        let path = &entry.path[section.name.len() + 1..];
        if let Some(key) = find_key(path) {
            refuse_reserved(entry, path, section)?;
            axes.push(list(entry, key, scheme, section)?);
            continue;
        }
        let of_range = path.rsplit_once('.').filter(|(parent, _)| find_key(parent).is_some());
        let Some((parent, word)) = of_range else {
            let error = ScenarioError::new(format!("there is no key {path}")).at(Some(entry.key_place.clone()));
            // The suggestion for a misspelt key needs the path without the range's keyword.
            let stem = path.rsplit_once('.').filter(|(_, word)| AXIS_WORDS.contains(word));
            let near = nearest_key(stem.map_or(path, |(stem, _)| stem));
            return Err(match near {
                Some(near) => error.remedy(format!("did you mean {near}?")),
                None => error.remedy(format!(
                    "the keys of {} are keys of the scenario: `trocar init --all` writes one with every key",
                    section.name
                )),
            });
        };
        refuse_reserved(entry, parent, section)?;
        if ranges.iter().all(|(_, range)| range.path != parent) {
            ranges.push((axes.len() + ranges.len(), RangeEntries { path: parent, ..RangeEntries::default() }));
        }
        let Some((_, range)) = ranges.iter_mut().find(|(_, range)| range.path == parent) else { continue };
        match word {
            "from" => range.from = Some(entry),
            "to" => range.to = Some(entry),
            "points" => range.points = Some(entry),
            "log" => range.log = Some(entry),
            "median" => range.median = Some(entry),
            "spread" => range.spread = Some(entry),
            _ => {
                let error = ScenarioError::new(format!("a range has no {word}")).at(Some(entry.key_place.clone()));
                return Err(error.remedy(match word {
                    "step" => "give points instead: the number of values, including both ends",
                    _ => section.words,
                }));
            }
        }
    }
    for (place, entries) in ranges {
        axes.insert(place.min(axes.len()), range(&entries, scheme == SamplingScheme::Grid, section)?);
    }
    Ok(axes)
}

fn refuse_reserved(entry: &Entry, path: &str, section: &Section) -> Result<(), ScenarioError> {
    let error = |remedy: &str| {
        Err(ScenarioError::new(format!("{path} cannot be {}", section.role))
            .at(Some(entry.key_place.clone()))
            .remedy(remedy))
    };
    match path {
        "simulation.seed" => error(section.seeds),
        "name" => error("a case is named by its number"),
        _ => Ok(()),
    }
}

fn list(entry: &Entry, key: KeyAt, scheme: SamplingScheme, section: &Section) -> Result<Axis, ScenarioError> {
    // For a key with a list as its value, a list of numbers is one value.
    let items = entry.value.as_array().filter(|items| !items.is_empty());
    let items = items.filter(|items| key.kind != Kind::Numbers || items.iter().all(toml::Value::is_array));
    let Some(items) = items else {
        return Err(must(entry, if key.kind == Kind::Numbers { "a list of lists of numbers" } else { section.forms }));
    };
    let mut values: Vec<Value> = vec![];
    for item in items {
        let value = Value::of_key(&key, item).ok_or_else(|| {
            let message = format!("{} has {item}, each must be {}", entry.path, key.kind);
            ScenarioError::new(message).at(Some(entry.value_place.clone()))
        })?;
        // Given points may share a value.
        if !matches!(scheme, SamplingScheme::List { .. }) && values.contains(&value) {
            let message = format!("{} has {item} twice", entry.path);
            return Err(ScenarioError::new(message).at(Some(entry.value_place.clone())));
        }
        values.push(value);
    }
    Ok(Axis { key, levels: Levels::List(values), place: entry.value_place.clone() })
}

const AXIS_WORDS: [&str; 6] = ["from", "to", "points", "log", "median", "spread"];

fn distribution(
    entries: &RangeEntries<'_>,
    any: &Entry,
    is_grid: bool,
    &Section { name: section, forms, .. }: &Section,
) -> Result<Axis, ScenarioError> {
    let RangeEntries { path, from, to, points, log, median, spread } = entries;
    let refuse = |entry: &Entry, message: String| Err(ScenarioError::new(message).at(Some(entry.key_place.clone())));
    if let Some(other) = from.or(*to).or(*points).or(*log) {
        return refuse(other, format!("{section}.{path} is a range and a distribution, must be {forms}"));
    }
    let (Some(median), Some(spread)) = (median, spread) else {
        return refuse(any, format!("{section}.{path} has only one of median and spread, must be {forms}"));
    };
    if is_grid {
        let error = ScenarioError::new(format!("{section}.{path} is a distribution, which a grid cannot have"));
        return Err(error
            .at(Some(any.key_place.clone()))
            .remedy("give design.kind = \"random\", \"latin-hypercube\" or \"sobol\""));
    }
    let key = find_key(path).filter(|key| matches!(key.kind, Kind::Number(_)));
    let Some(key) = key else {
        return refuse(any, format!("{section}.{path} has a distribution, but only a key with a number can have one"));
    };
    let Some(Value::Number(middle)) = Value::of_key(&key, &median.value).filter(|value| number(value) > Some(0.0))
    else {
        return Err(must(median, &format!("{}, above 0", key.kind)));
    };
    let ratio = spread.value.as_float().or_else(|| spread.value.as_integer().map(|whole| whole as f64));
    let Some(ratio) = ratio.filter(|ratio| *ratio > 1.0 && *ratio <= MAX_SPREAD) else {
        return Err(must(spread, "a number above 1 and at most 10"));
    };
    let place = median.value_place.clone();
    Ok(Axis { key, levels: Levels::LogNormal { median: middle, spread: ratio }, place })
}

const MAX_SPREAD: f64 = 10.0;

fn range(entries: &RangeEntries<'_>, is_grid: bool, of: &Section) -> Result<Axis, ScenarioError> {
    if let Some(any) = entries.median.or(entries.spread) {
        return distribution(entries, any, is_grid, of);
    }
    let &Section { name: section, forms, .. } = of;
    let RangeEntries { path, from, to, points, log, .. } = entries;
    let any = from.or(*to).or(*points).or(*log);
    let missing = |what: &str| {
        let message = format!("{section}.{path} has no {what}, must be {forms}");
        ScenarioError::new(message).at(any.map(|entry| entry.key_place.clone()))
    };
    let (from, to) = (from.ok_or_else(|| missing("from"))?, to.ok_or_else(|| missing("to"))?);
    let key = find_key(path).ok_or_else(|| missing("key"))?;
    if !matches!(key.kind, Kind::Number(_) | Kind::Whole(_)) {
        let message = format!("{path} has no range, it is {}", key.kind);
        return Err(ScenarioError::new(message).at(Some(from.key_place.clone())).remedy("give a list"));
    }
    let number = |end: &Entry| match Value::of_key(&key, &end.value) {
        Some(Value::Number(number)) => Ok(number),
        Some(Value::Whole(number)) => Ok(number as f64),
        Some(Value::Numbers(_) | Value::Flag(_) | Value::Text(_)) | None => Err(must(end, &key.kind.to_string())),
    };
    let log = log.map_or(Ok(false), flag)?;
    let (first, last) = (number(from)?, number(to)?);
    if first == last {
        return Err(must(to, "a number other than from").remedy("fix the key with set, or give a list"));
    }
    if let Some((end, _)) = [(from, first), (to, last)].into_iter().find(|(_, number)| log && *number <= 0.0) {
        return Err(must(end, "above 0 with log = true"));
    }
    let points = match (points, is_grid) {
        (Some(entry), true) => Some(whole(entry, 2, MAX_CASES)?),
        (None, true) => return Err(missing("points")),
        (None, false) => None,
        (Some(entry), false) => {
            let message = format!("{section}.{path} has points, which only the ranges of a grid have");
            return Err(ScenarioError::new(message).at(Some(entry.key_place.clone())).remedy(of.without_points));
        }
    };
    Ok(Axis { key, levels: Levels::Range { from: first, to: last, log, points }, place: from.value_place.clone() })
}
