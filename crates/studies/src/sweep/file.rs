use std::collections::HashSet;

use super::axis::{Axis, Levels};
use super::axis_file::{AXES, axes_of};
use super::columns::Column;
use super::correlation::Correlation;
use super::design::{MAX_CASES, SamplingScheme};
use super::file_values::{flag, line, must, name, texts, whole, within};
use super::sobol::MAX_DIMENSIONS;
use trocar_scenario::{Entry, ScenarioError, find_key, nearest_of};

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
}

impl SweepFile {
    pub(super) fn of(mut entries: Vec<Entry>, is_stored: bool) -> Result<Self, ScenarioError> {
        if is_stored {
            entries.retain(|entry| !entry.path.starts_with("resolved."));
        }
        let is_bare = |entry: &Entry| entry.value.as_table().is_some_and(|table| table.is_empty());
        entries.retain(|entry| !(matches!(entry.path.as_str(), "axes" | "set" | "design") && is_bare(entry)));
        // A key is the same with and without quotes, as in axes."scaling.force".
        entries.iter_mut().for_each(|entry| entry.path.retain(|letter| letter != '"'));
        // The order of the axes determines the order of the cases.
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
        let axes = axes_of(&axes, scheme, &AXES)?;
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
        let columns = columns(find("metrics"))?;
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

fn listed_seeds(entry: &Entry) -> Result<Vec<u64>, ScenarioError> {
    let seed = |value: &toml::Value| value.as_integer().and_then(|value| u64::try_from(value).ok());
    let seeds = entry.value.as_array().and_then(|list| list.iter().map(seed).collect::<Option<Vec<u64>>>());
    let distinct = seeds.as_ref().map_or(0, |seeds| seeds.iter().collect::<HashSet<_>>().len());
    seeds
        .filter(|seeds| !seeds.is_empty() && seeds.len() == distinct)
        .ok_or_else(|| must(entry, "a number of seeds, or a list of different whole numbers of at least 0"))
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

fn columns(entry: Option<&Entry>) -> Result<Vec<Column>, ScenarioError> {
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
        columns.push(column);
    }
    Ok(columns)
}

fn focus(entry: Option<&Entry>, columns: &[Column]) -> Result<Vec<usize>, ScenarioError> {
    let Some(entry) = entry else { return Ok((0..columns.len().min(4)).collect()) };
    let place = |name: &str| {
        let known = columns.iter().position(|column| column.name == name);
        known.ok_or_else(|| {
            let message = format!("focus has {name}, which is not among the kept metrics");
            ScenarioError::new(message).at(Some(within(entry, name))).remedy(format!("add \"{name}\" to metrics"))
        })
    };
    texts(entry)?.into_iter().map(place).collect()
}

pub(crate) fn correlations_of(
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
