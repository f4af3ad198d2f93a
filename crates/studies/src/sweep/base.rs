use super::axis::Axis;
use super::correlation::Correlation;
use super::file::SweepFile;
use trocar_scenario::{Entry, Place, Scenario, ScenarioError, Source, entries};

/// An axis has an effect in the first case, or through another axis.
pub(crate) fn check_acting(
    axes: &[Axis],
    others: &[Axis],
    first: &Scenario,
    section: &str,
) -> Result<(), ScenarioError> {
    let values = first.values();
    let is_swept = |path: &str| axes.iter().chain(others).any(|axis| axis.key.path == path);
    let inert = axes.iter().find_map(|axis| {
        if values.is_acting(&axis.key) {
            return None;
        }
        Some((axis, values.unmet(&axis.key).find(|acts| !is_swept(acts.key))?))
    });
    let Some((axis, acts)) = inert else { return Ok(()) };
    let words = acts.words().join(" or ");
    let message = format!("{section}.{} has no effect: it acts for {} = {words}", axis.key.path, acts.key);
    let remedy = match section {
        "axes" => format!("remove the axis, or change {} in [set]", acts.key),
        _ => format!("remove it, or change {} in [set]", acts.key),
    };
    Err(ScenarioError::new(message).at(Some(axis.place.clone())).remedy(remedy))
}

pub(crate) struct SweptPopulation {
    pub(crate) base: (Source, Place),
    pub(crate) set: Vec<Entry>,
    pub(crate) axes: Vec<Axis>,
    pub(crate) correlations: Vec<Correlation>,
}

impl SweptPopulation {
    pub(crate) fn of(source: &Source) -> Result<Self, ScenarioError> {
        let file = SweepFile::of(entries(source)?, false)?;
        let base = base_of(&file, source)?;
        Ok(Self { base, set: file.set, axes: file.axes, correlations: file.correlations })
    }
}

pub(super) fn base_of(file: &SweepFile, source: &Source) -> Result<(Source, Place), ScenarioError> {
    let Some(base) = &file.base else {
        let message = format!("{}: base is missing; it names the scenario to vary", source.display());
        return Err(ScenarioError::new(message).remedy("write base = \"paper/augmented\", or a path"));
    };
    scenario_of(base, source)
}

pub(crate) fn scenario_of(entry: &Entry, source: &Source) -> Result<(Source, Place), ScenarioError> {
    let place = entry.value_place.clone();
    let Some(path) = entry.value.as_str().filter(|path| !path.is_empty()) else {
        let message = format!("{} is {}, must be the path of a scenario file", entry.path, entry.written);
        return Err(ScenarioError::new(message).at(Some(place)));
    };
    let scenario = source.relative(path);
    scenario.read().map_err(|error| error.at(Some(place.clone())))?;
    Ok((scenario, place))
}
