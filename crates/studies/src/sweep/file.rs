//! Sweep files.

use std::collections::HashSet;

use super::axis::{Axis, Levels, number};
use super::columns::Column;
use super::correlation::Correlation;
use super::design::{MAX_CASES, SamplingScheme};
use super::sobol::MAX_DIMENSIONS;
use trocar_scenario::{
    Entry, KeyAt, Kind, Place, ScenarioError, Value, find_key, harmless_name, nearest_key, nearest_of,
};

/// The keys of a sweep file, with their meanings.
pub const SWEEP_KEYS: [(&str, &str); 14] = [
    ("name", "Name of the sweep's folder; default: the file name without extension."),
    ("question", "The question that the sweep answers, for its report."),
    ("base", "The scenario to vary: a path relative to this file, or a shipped one."),
    ("seeds", "Number of noise seeds per point, or a list of seeds; default: 1."),
    ("first_seed", "First noise seed, unless the seeds are listed; default: the seed of the scenario."),
    ("metrics", "Metrics to keep for each case; default: a standard set."),
    ("focus", "Metrics with figures and an analysis of influences; default: the first four."),
    ("csv", "True if the rows are also written as CSV, in addition to Parquet; default: true."),
    (
        "design.kind",
        "grid (every combination), random, latin-hypercube, sobol or list (the k-th values of all axes are a point); \
         default: grid.",
    ),
    ("design.points", "Number of points of a random, latin-hypercube or sobol design."),
    ("design.seed", "Seed of the design's random numbers; default: 1."),
    ("correlations.NAME.axes", "Axes that vary together, as a list of keys; not for a grid."),
    (
        "correlations.NAME.coefficient",
        "Correlation of each pair of these axes, after their transformation to normal \
        variables.",
    ),
    ("set", "Keys of the scenario with the same value in all cases, as in set.simulation.duration_s = 7.0."),
];

const AXIS: &str = "a list, as in [1.0, 2.0], or { from = 0.5, to = 2.0, points = 16, log = true }, or \
                    { median = 1.0, spread = 1.5 }";

#[derive(Debug)]
pub(super) struct SweepFile {
    pub(super) name: Option<String>,
    pub(super) question: Option<String>,
    pub(super) base: Option<Entry>,
    pub(super) set: Vec<Entry>,
    pub(super) axes: Vec<Axis>,
    pub(super) correlations: Vec<Correlation>,
    pub(super) scheme: SamplingScheme,
    pub(super) seeds: u64,
    pub(super) first_seed: Option<u64>,
    pub(super) listed_seeds: Option<Vec<u64>>,
    pub(super) columns: Vec<Column>,
    pub(super) focus: Vec<usize>,
    pub(super) csv: bool,
    /// Former names of metrics in the file, each with its current name.
    pub(super) former_names: Vec<(String, String)>,
}

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

impl SweepFile {
    pub(super) fn of(mut entries: Vec<Entry>, is_stored: bool) -> Result<Self, ScenarioError> {
        if is_stored {
            entries.retain(|entry| !entry.path.starts_with("resolved."));
        }
        // An empty section is ignored.
        let is_bare = |entry: &Entry| entry.value.as_table().is_some_and(|table| table.is_empty());
        entries.retain(|entry| !(matches!(entry.path.as_str(), "axes" | "set" | "design") && is_bare(entry)));
        // A key is the same with and without quotes, as in axes."scaling.force".
        entries.iter_mut().for_each(|entry| entry.path.retain(|letter| letter != '"'));
        // Sorted by position: the order of the axes determines the order of the cases.
        entries.sort_by_key(|entry| entry.key_place.span.start);
        let (axes, entries): (Vec<_>, Vec<_>) = entries.into_iter().partition(|entry| entry.path.starts_with("axes."));
        let (set, entries): (Vec<_>, Vec<_>) = entries.into_iter().partition(|entry| entry.path.starts_with("set."));
        let (groups, entries): (Vec<_>, Vec<_>) =
            entries.into_iter().partition(|entry| entry.path.starts_with("correlations."));
        let find = |path: &str| entries.iter().find(|entry| entry.path == path);
        if let Some(entry) = entries.iter().find(|entry| !is_plain_key(&entry.path)) {
            return Err(unknown(entry));
        }
        let scheme = scheme(&find)?;
        let axes = axes_of(&axes, scheme)?;
        let scheme = with_listed_points(scheme, &axes)?;
        let correlations = correlations_of(&groups, &axes, scheme)?;
        if let (SamplingScheme::Sobol { .. }, Some(beyond)) = (scheme, axes.get(MAX_DIMENSIONS)) {
            let message = format!("a Sobol sequence has at most {MAX_DIMENSIONS} axes here");
            return Err(ScenarioError::new(message).at(Some(beyond.place.clone())).remedy("use a Latin hypercube"));
        }
        let listed_seeds = find("seeds").filter(|entry| entry.value.is_array()).map(listed_seeds).transpose()?;
        if let (Some(_), Some(first)) = (&listed_seeds, find("first_seed")) {
            let message = "first_seed is given, and the seeds are a list";
            return Err(ScenarioError::new(message).at(Some(first.key_place.clone())).remedy("remove one of them"));
        }
        let mut former_names = vec![];
        let columns = columns(find("metrics"), &mut former_names)?;
        let focus = focus(find("focus"), &columns)?;
        let strip = |mut entry: Entry| {
            entry.path.replace_range(..4, "");
            entry
        };
        Ok(Self {
            name: find("name").map(name).transpose()?,
            question: find("question").map(line).transpose()?,
            base: find("base").cloned(),
            set: set.into_iter().map(strip).collect(),
            axes,
            correlations,
            scheme,
            seeds: match &listed_seeds {
                Some(seeds) => seeds.len() as u64,
                None => find("seeds").map_or(Ok(1), |entry| whole(entry, 1, MAX_CASES))?,
            },
            first_seed: find("first_seed").map(|entry| whole(entry, 0, i64::MAX as u64)).transpose()?,
            listed_seeds,
            columns,
            focus,
            csv: find("csv").map_or(Ok(true), flag)?,
            former_names,
        })
    }
}

fn is_plain_key(path: &str) -> bool {
    SWEEP_KEYS.iter().any(|(known, _)| *known == path) && path != "set"
}

fn unknown(entry: &Entry) -> ScenarioError {
    let path = entry.path.as_str();
    let place = Some(entry.key_place.clone());
    if matches!(path, "axes" | "set" | "design") {
        let message = format!("{path} is {}, must be a section of keys", entry.written);
        return ScenarioError::new(message).at(place).remedy(format!("write [{path}] and its keys below"));
    }
    let error = ScenarioError::new(format!("a sweep has no key {path}")).at(place);
    if find_key(path).is_some() {
        return error.remedy(format!("write axes.{path} to vary it, set.{path} to fix it"));
    }
    match nearest_of(path, SWEEP_KEYS.iter().map(|(known, _)| *known).chain(["axes"])) {
        Some(best) => error.remedy(format!("did you mean {best}?")),
        None => error.remedy("`trocar sweep --help` lists all of them"),
    }
}

fn must(entry: &Entry, what: &str) -> ScenarioError {
    ScenarioError::new(format!("{} is {}, must be {what}", entry.path, entry.written))
        .at(Some(entry.value_place.clone()))
}

fn whole(entry: &Entry, min: u64, max: u64) -> Result<u64, ScenarioError> {
    let value = entry.value.as_integer().and_then(|value| u64::try_from(value).ok());
    value
        .filter(|value| (min..=max).contains(value))
        .ok_or_else(|| must(entry, &format!("a whole number from {min} to {max}")))
}

fn listed_seeds(entry: &Entry) -> Result<Vec<u64>, ScenarioError> {
    let seed = |value: &toml::Value| value.as_integer().and_then(|value| u64::try_from(value).ok());
    let seeds = entry.value.as_array().and_then(|list| list.iter().map(seed).collect::<Option<Vec<u64>>>());
    let distinct = seeds.as_ref().map_or(0, |seeds| seeds.iter().collect::<HashSet<_>>().len());
    seeds
        .filter(|seeds| !seeds.is_empty() && seeds.len() == distinct)
        .ok_or_else(|| must(entry, "a number of seeds, or a list of different whole numbers of at least 0"))
}

fn flag(entry: &Entry) -> Result<bool, ScenarioError> {
    entry.value.as_bool().ok_or_else(|| must(entry, "true or false"))
}

fn name(entry: &Entry) -> Result<String, ScenarioError> {
    let is_harmless = |name: &&str| harmless_name(name) == **name;
    let name = entry.value.as_str().filter(is_harmless);
    name.map(str::to_owned).ok_or_else(|| must(entry, "a string of letters, digits, '-' and '_', which names a folder"))
}

fn line(entry: &Entry) -> Result<String, ScenarioError> {
    let is_line = |text: &&str| !text.trim().is_empty() && !text.contains(char::is_control);
    entry.value.as_str().filter(is_line).map(str::to_owned).ok_or_else(|| must(entry, "a text of one line"))
}

fn scheme<'a>(find: &impl Fn(&str) -> Option<&'a Entry>) -> Result<SamplingScheme, ScenarioError> {
    let Some(kind) = find("design.kind") else { return grid(find) };
    let scheme = |points, seed| {
        let found =
            SamplingScheme::all(points, seed).into_iter().find(|known| Some(known.word()) == kind.value.as_str());
        found.ok_or_else(|| must(kind, &format!("one of \"{}\"", SamplingScheme::WORDS.join("\", \""))))
    };
    match scheme(1, 1)? {
        SamplingScheme::Grid => return grid(find),
        given @ SamplingScheme::List { .. } => {
            return match ["design.points", "design.seed"].into_iter().find_map(find) {
                Some(entry) => Err(ScenarioError::new(format!("a design of given points has no {}", entry.path))
                    .at(Some(entry.key_place.clone()))
                    .remedy("remove it: the points are the values of the axes")),
                None => Ok(given),
            };
        }
        SamplingScheme::Random { .. } | SamplingScheme::LatinHypercube { .. } | SamplingScheme::Sobol { .. } => {}
    }
    let Some(points) = find("design.points") else {
        let message = "design.points is missing, a whole number of at least 1";
        return Err(ScenarioError::new(message).at(Some(kind.value_place.clone())));
    };
    let points = whole(points, 1, MAX_CASES)?;
    let seed = find("design.seed").map_or(Ok(1), |entry| whole(entry, 0, i64::MAX as u64))?;
    scheme(points, seed)
}

fn grid<'a>(find: &impl Fn(&str) -> Option<&'a Entry>) -> Result<SamplingScheme, ScenarioError> {
    match ["design.points", "design.seed"].into_iter().find_map(find) {
        Some(entry) => Err(ScenarioError::new(format!("a grid has no {}", entry.path))
            .at(Some(entry.key_place.clone()))
            .remedy("its ranges have points; or give design.kind = \"random\", \"latin-hypercube\" or \"sobol\"")),
        None => Ok(SamplingScheme::Grid),
    }
}

/// Sets the number of points for given points; other schemes are unchanged.
fn with_listed_points(scheme: SamplingScheme, axes: &[Axis]) -> Result<SamplingScheme, ScenarioError> {
    let SamplingScheme::List { .. } = scheme else { return Ok(scheme) };
    let points = axes.first().and_then(Axis::count).unwrap_or(1);
    let other = axes.iter().find(|axis| !matches!(&axis.levels, Levels::List(list) if list.len() as u64 == points));
    match other {
        None => Ok(SamplingScheme::List { points }),
        Some(axis) => {
            let first = &axes[0].key.path;
            let message = format!("axes.{} must be a list of as many values as axes.{first}, {points}", axis.key.path);
            Err(ScenarioError::new(message)
                .at(Some(axis.place.clone()))
                .remedy("the k-th values of all axes are one point; for every combination give design.kind = \"grid\""))
        }
    }
}

fn texts(entry: &Entry) -> Result<Vec<&str>, ScenarioError> {
    let texts =
        entry.value.as_array().and_then(|list| list.iter().map(toml::Value::as_str).collect::<Option<Vec<_>>>());
    texts.filter(|list| !list.is_empty()).ok_or_else(|| must(entry, "a list of names, as in [\"false_alarms\"]"))
}

fn columns(entry: Option<&Entry>, former_names: &mut Vec<(String, String)>) -> Result<Vec<Column>, ScenarioError> {
    let Some(entry) = entry else { return Ok(Column::defaults()) };
    let mut columns: Vec<Column> = vec![];
    for name in texts(entry)? {
        let Some(column) = Column::named(name) else {
            let error = ScenarioError::new(format!("there is no metric {name}")).at(Some(within(entry, name)));
            return Err(match Column::nearest(name) {
                Some(near) => error.remedy(format!("did you mean {near}?")),
                None => error.remedy("`trocar sweep --help` lists all of them"),
            });
        };
        if columns.iter().any(|other| other.name == column.name) {
            let message = format!("the metric {name} is listed twice");
            return Err(ScenarioError::new(message).at(Some(within(entry, name))));
        }
        if column.name != name {
            former_names.push((name.to_owned(), column.name.clone()));
        }
        columns.push(column);
    }
    Ok(columns)
}

fn focus(entry: Option<&Entry>, columns: &[Column]) -> Result<Vec<usize>, ScenarioError> {
    let Some(entry) = entry else { return Ok((0..columns.len().min(4)).collect()) };
    let place = |name: &str| {
        let wanted = Column::named(name).map_or_else(|| name.to_owned(), |column| column.name);
        let known = columns.iter().position(|column| column.name == wanted);
        known.ok_or_else(|| {
            let message = format!("focus has {name}, which is not among the kept metrics");
            ScenarioError::new(message).at(Some(within(entry, name))).remedy(format!("add \"{name}\" to metrics"))
        })
    };
    texts(entry)?.into_iter().map(place).collect()
}

fn within(entry: &Entry, name: &str) -> Place {
    let Place { file, text, span } = entry.value_place.clone();
    let quoted = format!("\"{name}\"");
    let found = text.get(span.clone()).and_then(|list| list.rfind(&quoted));
    let span = found.map_or(span.clone(), |at| span.start + at..span.start + at + quoted.len());
    Place { file, text, span }
}

fn axes_of(entries: &[Entry], scheme: SamplingScheme) -> Result<Vec<Axis>, ScenarioError> {
    let mut axes = vec![];
    let mut ranges: Vec<(usize, RangeEntries<'_>)> = vec![];
    for entry in entries {
        let path = &entry.path["axes.".len()..];
        if let Some(key) = find_key(path) {
            refuse_reserved(entry, path)?;
            axes.push(list(entry, key, scheme)?);
            continue;
        }
        let of_range = path.rsplit_once('.').filter(|(parent, _)| find_key(parent).is_some());
        let Some((parent, word)) = of_range else {
            let error = ScenarioError::new(format!("there is no key {path}")).at(Some(entry.key_place.clone()));
            // The suggestion for a misspelt key of a range needs the path without the range's keyword.
            let stem = path.rsplit_once('.').filter(|(_, word)| AXIS_WORDS.contains(word));
            let near = nearest_key(stem.map_or(path, |(stem, _)| stem));
            return Err(match near {
                Some(near) => error.remedy(format!("did you mean {near}?")),
                None => error.remedy("axes are keys of the scenario: `trocar init --all` writes one with every key"),
            });
        };
        refuse_reserved(entry, parent)?;
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
                    _ => "it has from, to, points and log, or median and spread",
                }));
            }
        }
    }
    for (place, entries) in ranges {
        axes.insert(place.min(axes.len()), range(&entries, scheme == SamplingScheme::Grid)?);
    }
    Ok(axes)
}

fn refuse_reserved(entry: &Entry, path: &str) -> Result<(), ScenarioError> {
    let error = |remedy: &str| {
        Err(ScenarioError::new(format!("{path} cannot be an axis")).at(Some(entry.key_place.clone())).remedy(remedy))
    };
    match path {
        "simulation.seed" => error("give seeds = N, and first_seed if needed"),
        "name" => error("a case is named by its number"),
        _ => Ok(()),
    }
}

fn list(entry: &Entry, key: KeyAt, scheme: SamplingScheme) -> Result<Axis, ScenarioError> {
    // For a key with a list as its value, a list of numbers is one value.
    let items = entry.value.as_array().filter(|items| !items.is_empty());
    let items = items.filter(|items| key.kind != Kind::Numbers || items.iter().all(toml::Value::is_array));
    let Some(items) = items else {
        return Err(must(entry, if key.kind == Kind::Numbers { "a list of lists of numbers" } else { AXIS }));
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

fn distribution(entries: &RangeEntries<'_>, any: &Entry, is_grid: bool) -> Result<Axis, ScenarioError> {
    let RangeEntries { path, from, to, points, log, median, spread } = entries;
    let refuse = |entry: &Entry, message: String| Err(ScenarioError::new(message).at(Some(entry.key_place.clone())));
    if let Some(other) = from.or(*to).or(*points).or(*log) {
        return refuse(other, format!("axes.{path} is a range and a distribution, must be {AXIS}"));
    }
    let (Some(median), Some(spread)) = (median, spread) else {
        return refuse(any, format!("axes.{path} has only one of median and spread, must be {AXIS}"));
    };
    if is_grid {
        let error = ScenarioError::new(format!("axes.{path} is a distribution, which a grid cannot have"));
        return Err(error
            .at(Some(any.key_place.clone()))
            .remedy("give design.kind = \"random\", \"latin-hypercube\" or \"sobol\""));
    }
    let key = find_key(path).filter(|key| matches!(key.kind, Kind::Number(_)));
    let Some(key) = key else {
        return refuse(any, format!("axes.{path} has a distribution, but only a key with a number can have one"));
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

fn correlations_of(
    entries: &[Entry],
    axes: &[Axis],
    scheme: SamplingScheme,
) -> Result<Vec<Correlation>, ScenarioError> {
    let mut groups: Vec<(&str, Option<&Entry>, Option<&Entry>)> = vec![];
    for entry in entries {
        let refuse = |message: String| ScenarioError::new(message).at(Some(entry.key_place.clone()));
        let Some((name, word)) = entry.path["correlations.".len()..].rsplit_once('.') else {
            return Err(refuse(format!("{} is {}, must be a section", entry.path, entry.written))
                .remedy("write [correlations.NAME] with axes and coefficient below"));
        };
        if scheme.points_and_seed().is_none() {
            return Err(refuse(format!("a design of the kind {} cannot have correlations", scheme.word()))
                .remedy("give design.kind = \"random\", \"latin-hypercube\" or \"sobol\""));
        }
        if groups.last().is_none_or(|(last, ..)| *last != name) {
            groups.push((name, None, None));
        }
        let Some((_, axes, coefficient)) = groups.last_mut() else { continue };
        match word {
            "axes" => *axes = Some(entry),
            "coefficient" => *coefficient = Some(entry),
            _ => return Err(refuse(format!("a correlation has no {word}")).remedy("it has axes and coefficient")),
        }
    }
    let mut correlations: Vec<Correlation> = vec![];
    for (name, listed, coefficient) in groups {
        let (Some(listed), Some(coefficient)) = (listed, coefficient) else {
            let place = listed.or(coefficient).map(|entry| entry.key_place.clone());
            return Err(ScenarioError::new(format!("correlations.{name} needs axes and coefficient")).at(place));
        };
        let mut indices: Vec<usize> = vec![];
        for path in texts(listed)? {
            let refuse = |message: String| Err(ScenarioError::new(message).at(Some(within(listed, path))));
            let Some(index) = axes.iter().position(|axis| axis.key.path == path) else {
                return refuse(format!("correlations.{name} has {path}, which is no axis of this sweep"));
            };
            if !axes[index].is_numeric() {
                return refuse(format!("correlations.{name} has {path}, whose values are not numbers"));
            }
            if indices.contains(&index) || correlations.iter().any(|other| other.axes.contains(&index)) {
                return refuse(format!("{path} is in two correlations, or twice in one"));
            }
            indices.push(index);
        }
        if indices.len() < 2 {
            return Err(must(listed, "a list of at least two axes"));
        }
        let least = -1.0 / (indices.len() - 1) as f64;
        let number = coefficient.value.as_float().or_else(|| coefficient.value.as_integer().map(|whole| whole as f64));
        let Some(number) = number.filter(|number| *number > least && *number < 1.0) else {
            return Err(must(coefficient, &format!("a number above {least} and below 1 for {} axes", indices.len())));
        };
        correlations.push(Correlation { name: name.to_owned(), axes: indices, coefficient: number });
    }
    Ok(correlations)
}

fn range(entries: &RangeEntries<'_>, is_grid: bool) -> Result<Axis, ScenarioError> {
    if let Some(any) = entries.median.or(entries.spread) {
        return distribution(entries, any, is_grid);
    }
    let RangeEntries { path, from, to, points, log, .. } = entries;
    let any = from.or(*to).or(*points).or(*log);
    let missing = |what: &str| {
        let message = format!("axes.{path} has no {what}, must be {AXIS}");
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
            let message = format!("axes.{path} has points, which only the ranges of a grid have");
            let remedy = "remove them: design.points applies; or give a list";
            return Err(ScenarioError::new(message).at(Some(entry.key_place.clone())).remedy(remedy));
        }
    };
    Ok(Axis { key, levels: Levels::Range { from: first, to: last, log, points }, place: from.value_place.clone() })
}
