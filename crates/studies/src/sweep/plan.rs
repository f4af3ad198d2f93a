//! A validated sweep: its design and its scenario, with a hash that identifies it.

use std::fmt::Write as _;

use sha2::{Digest, Sha256};

use super::axis::Axis;
use super::columns::Column;
use super::correlation::Correlation;
use super::design::{Design, MAX_CASES, SamplingScheme, UnitCoordinates};
use super::error::SweepError;
use super::file::SweepFile;
use super::part::{Layout, PACK_CASES};
use super::shard::Shard;
use crate::run::RunError;
use trocar_scenario::{
    CaseFactory, Kind, OperatorSpec, Place, Scenario, ScenarioError, Source, Template, TissueSpec, Value, entries,
    harmless_name, is_axis,
};

/// A validated sweep.
#[derive(Debug, Clone)]
pub struct Plan {
    /// The design.
    pub design: Design,
    /// Former names of metrics in the file, each with its current name.
    pub former_names: Vec<(String, String)>,
    template: Template,
    canonical: String,
}

/// Maximum number of axes whose corners are all checked in advance; further axes' ends are checked one by one.
const MAX_CORNER_AXES: usize = 7;

/// True if a file is a sweep file: a table with axes.
#[must_use]
pub fn is_sweep(source: &Source) -> bool {
    entries(source).is_ok_and(|entries| entries.iter().any(is_axis))
}

impl Plan {
    /// Loads a sweep file and its scenario, overridden by `section.key=value` settings, and checks the corners of its
    /// axes.
    ///
    /// # Errors
    /// [`ScenarioError`] with place and remedy if one of them is invalid.
    pub fn load(source: &Source, settings: &[String]) -> Result<Self, ScenarioError> {
        let file = SweepFile::of(entries(source)?, false)?;
        let Some(base) = &file.base else {
            let message = format!("{}: base is missing; it names the scenario to vary", source.display());
            return Err(ScenarioError::new(message).remedy("write base = \"paper/augmented\", or a path"));
        };
        let Some(path) = base.value.as_str().filter(|path| !path.is_empty()) else {
            let message = format!("base is {}, must be the path of a scenario file", base.written);
            return Err(ScenarioError::new(message).at(Some(base.value_place.clone())));
        };
        let (varied, place) = (source.relative(path), base.value_place.clone());
        varied.read().map_err(|error| error.at(Some(place.clone())))?;
        Self::of(file, source, (&varied, Some(place)), settings)
    }

    /// [`Plan::load`] for a sweep file without a base, with a given scenario.
    ///
    /// # Errors
    /// As [`Plan::load`]; also for a file that names a base.
    pub fn over(source: &Source, base: &Source, settings: &[String]) -> Result<Self, ScenarioError> {
        let file = SweepFile::of(entries(source)?, false)?;
        if let Some(entry) = &file.base {
            let error =
                ScenarioError::new("the scenario to vary is given twice: as an argument and as base in the file");
            return Err(error.at(Some(entry.key_place.clone())).remedy("remove one of them"));
        }
        Self::of(file, source, (base, None), settings)
    }

    fn of(
        file: SweepFile,
        source: &Source,
        (base, place): (&Source, Option<Place>),
        settings: &[String],
    ) -> Result<Self, ScenarioError> {
        let open: Vec<_> = file.axes.iter().map(|axis| (axis.key.clone(), axis.first(), axis.place.clone())).collect();
        let template = Template::new(base, file.set.clone(), settings, &open)
            .map_err(|error| if error.place.is_some() { error } else { error.at(place) })?;
        let first_seed = template.first().seed;
        let former_names = file.former_names.clone();
        let mut design = design(file, harmless_name(&source.stem()), first_seed);
        if design.points().is_none() {
            let message = format!("{}: more than {MAX_CASES} cases", source.display());
            return Err(ScenarioError::new(message).remedy("use fewer points or seeds, or a design other than grid"));
        }
        design.focus.dedup();
        let mut plan = Self { canonical: String::new(), design, former_names, template };
        plan.check_acting()?;
        plan.check_corners()?;
        plan.canonical = plan.write_canonical()?;
        Ok(plan)
    }

    /// All inputs of the sweep: every choice, the resolved scenario and the version. Equal texts mean equal sweeps.
    #[must_use]
    pub fn canonical(&self) -> &str {
        &self.canonical
    }

    /// The SHA-256 of [`Plan::canonical`], in hexadecimal digits.
    #[must_use]
    pub fn hash(&self) -> String {
        sha256(self.canonical.as_bytes())
    }

    /// True if the scenario or an axis sets a key: no other key determines its value.
    #[must_use]
    pub fn gives(&self, path: &str) -> bool {
        self.template.gives(path)
    }

    /// The layout of a shard's part.
    #[must_use]
    pub fn layout(&self, shard: Shard) -> Layout {
        layout(&self.design, &self.canonical, shard.range(self.design.cases().div_ceil(PACK_CASES)))
    }

    /// Creates a builder of the scenarios of cases; each thread needs one.
    #[must_use]
    pub fn maker(&self) -> CaseMaker<'_> {
        let (coordinates, values) = (vec![], vec![]);
        CaseMaker {
            design: &self.design,
            sampler: self.design.coordinates(),
            factory: self.template.factory(),
            coordinates,
            values,
        }
    }

    /// The resolved scenario of a case.
    ///
    /// # Errors
    /// As [`Scenario::load`].
    pub fn scenario(&self, case: u64) -> Result<Scenario, ScenarioError> {
        let (mut coordinates, mut values) = (vec![], vec![]);
        self.design.coordinates().values(case, &mut coordinates, &mut values);
        self.template.whole(&values, self.design.seed(case))
    }

    /// Checks that every axis has an effect, in the first case or because another axis varies the keys on which it
    /// depends.
    fn check_acting(&self) -> Result<(), ScenarioError> {
        let axes = &self.design.axes;
        let values = self.template.first().values();
        let is_swept = |path: &str| axes.iter().any(|axis| axis.key.path == path);
        let inert = axes.iter().find_map(|axis| {
            if values.is_acting(&axis.key) {
                return None;
            }
            Some((axis, values.unmet(&axis.key).find(|acts| !is_swept(acts.key))?))
        });
        let Some((axis, acts)) = inert else { return Ok(()) };
        let words = acts.words().join(" or ");
        let message = format!("axes.{} has no effect: it acts for {} = {words}", axis.key.path, acts.key);
        Err(ScenarioError::new(message)
            .at(Some(axis.place.clone()))
            .remedy(format!("remove the axis, or change {} in [set]", acts.key)))
    }

    /// Resolves and builds scenarios at the ends of the axes, to report invalid values in advance.
    fn check_corners(&self) -> Result<(), ScenarioError> {
        let axes = &self.design.axes;
        let mut factory = self.template.factory();
        if let SamplingScheme::List { .. } = self.design.scheme {
            // Only these combinations occur.
            let (sampler, mut coordinates, mut values) = (self.design.coordinates(), vec![], vec![]);
            return (0..self.design.points().unwrap_or(0)).try_for_each(|point| {
                sampler.values(point * self.design.seeds, &mut coordinates, &mut values);
                self.check_case(&mut factory, &values)
            });
        }
        let ends: Vec<Vec<Value>> = axes
            .iter()
            .map(|axis| axis.ends().into_iter().map(|coordinate| axis.value(coordinate)).collect())
            .collect();
        let firsts: Vec<Value> = axes.iter().map(Axis::first).collect();
        let mut corners: Vec<Vec<Value>> = vec![];
        for (index, of_axis) in ends.iter().enumerate() {
            corners.extend(of_axis.iter().map(|value| {
                let mut values = firsts.clone();
                values[index] = value.clone();
                values
            }));
        }
        for corner in 0..1_u32 << axes.len().min(MAX_CORNER_AXES) {
            let end = |(index, of_axis): (usize, &Vec<Value>)| {
                let last = index < MAX_CORNER_AXES && (corner >> index) & 1 == 1;
                if last { of_axis.last().cloned() } else { of_axis.first().cloned() }
            };
            corners.push(ends.iter().enumerate().filter_map(end).collect());
        }
        corners.iter().try_for_each(|values| self.check_case(&mut factory, values))
    }

    fn check_case(&self, factory: &mut CaseFactory<'_>, values: &[Value]) -> Result<(), ScenarioError> {
        let built = factory.build(values, self.design.first_seed).and_then(|scenario| scenario.build().map(drop));
        built.map_err(|error| {
            let described = describe(&self.design, values);
            if error.remedy.is_some() { error } else { error.remedy(format!("in the case of {described}")) }
        })
    }

    fn write_canonical(&self) -> Result<String, ScenarioError> {
        let mut text = design_toml(&self.design);
        let mut signals = Sha256::new();
        hash_signals(self.template.first(), &mut signals);
        for (index, axis) in self.design.axes.iter().enumerate().filter(|(_, axis)| axis.key.kind == Kind::File) {
            let mut values: Vec<Value> = self.design.axes.iter().map(Axis::first).collect();
            for coordinate in axis.ends() {
                values[index] = axis.value(coordinate);
                hash_signals(&self.template.whole(&values, self.design.first_seed)?, &mut signals);
            }
        }
        // Writing to a string cannot fail.
        let _ = write!(
            text,
            "\n[resolved]\ntrocar_version = \"{}\"\nsignals_sha256 = \"{}\"\n",
            env!("CARGO_PKG_VERSION"),
            hexadecimal(&signals.finalize()),
        );
        let echo = self.template.first().echo();
        let mut is_in_section = false;
        // Each layer is written as a section with its name.
        let mut in_list = None;
        for line in echo.lines() {
            if let Some(list) = line.strip_prefix("[[").and_then(|line| line.strip_suffix("]]")) {
                in_list = Some(list);
                continue;
            }
            if let Some(name) = in_list.and(line.strip_prefix("name = ")) {
                let _ = write!(text, "\n[resolved.{}.{}]\n", in_list.unwrap_or_default(), name.trim_matches('"'));
                in_list = None;
                continue;
            }
            // A file is identified by its content, on any machine. The seeds are part of the design.
            let is_apart = ["file = ", "delays_file = ", "seed = "].iter().any(|key| line.starts_with(key));
            if let Some(section) = line.strip_prefix('[') {
                is_in_section = true;
                let _ = write!(text, "\n[resolved.{section}\n");
            } else if is_in_section && !line.is_empty() && !is_apart {
                let _ = writeln!(text, "{line}");
            }
        }
        Ok(text)
    }
}

pub(super) fn layout(design: &Design, canonical: &str, packs: std::ops::Range<u64>) -> Layout {
    let digest = Sha256::digest(canonical.as_bytes());
    let key = digest.iter().take(8).fold(0, |key, byte| key << 8 | u64::from(*byte));
    Layout { key, columns: design.columns.len(), cases: design.cases(), packs }
}

pub(super) fn sha256(bytes: &[u8]) -> String {
    hexadecimal(&Sha256::digest(bytes))
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        // Writing to a string cannot fail.
        let _ = write!(text, "{byte:02x}");
        text
    })
}

fn design(file: SweepFile, stem: String, first_seed: u64) -> Design {
    Design {
        name: file.name.unwrap_or(stem),
        question: file.question,
        axes: file.axes,
        correlations: file.correlations,
        scheme: file.scheme,
        seeds: file.seeds,
        first_seed: file.listed_seeds.as_ref().map(|seeds| seeds[0]).or(file.first_seed).unwrap_or(first_seed),
        listed_seeds: file.listed_seeds,
        columns: file.columns,
        focus: file.focus,
        csv: file.csv,
    }
}

/// Reads the design from a stored canonical text.
///
/// # Errors
/// [`ScenarioError`] for another text.
pub fn stored_design(source: &Source) -> Result<Design, ScenarioError> {
    Ok(design(SweepFile::of(entries(source)?, true)?, harmless_name(&source.stem()), 1))
}

fn design_toml(design: &Design) -> String {
    let names = |columns: Vec<&Column>| {
        let names: Vec<_> = columns.iter().map(|column| format!("{:?}", column.name)).collect();
        format!("[{}]", names.join(", "))
    };
    let seeds = match &design.listed_seeds {
        Some(seeds) => format!("seeds = {seeds:?}"),
        None => format!("seeds = {}\nfirst_seed = {}", design.seeds, design.first_seed),
    };
    let question = design.question.as_ref().map(|text| format!("question = {}\n", toml::Value::String(text.clone())));
    let mut text = format!(
        "name = {}\n{}{seeds}\nmetrics = {}\nfocus = {}\ncsv = {}\n\n[design]\nkind = \"{}\"\n",
        toml::Value::String(design.name.clone()),
        question.unwrap_or_default(),
        names(design.columns.iter().collect()),
        names(design.focus.iter().map(|index| &design.columns[*index]).collect()),
        design.csv,
        design.scheme.word(),
    );
    if let Some((points, seed)) = design.scheme.points_and_seed() {
        let _ = write!(text, "points = {points}\nseed = {seed}\n");
    }
    if !design.axes.is_empty() {
        text.push_str("\n[axes]\n");
    }
    for axis in &design.axes {
        let _ = writeln!(text, "{} = {}", axis.key.path, axis.to_toml());
    }
    for Correlation { name, axes, coefficient } in &design.correlations {
        let paths: Vec<_> = axes.iter().map(|axis| format!("{:?}", design.axes[*axis].key.path)).collect();
        let coefficient = toml::Value::Float(*coefficient);
        let _ = write!(text, "\n[correlations.{name}]\naxes = [{}]\ncoefficient = {coefficient}\n", paths.join(", "));
    }
    text
}

fn hash_signals(scenario: &Scenario, hash: &mut Sha256) {
    let mut numbers = |numbers: &[f64]| {
        hash.update((numbers.len() as u64).to_le_bytes());
        numbers.iter().for_each(|number| hash.update(number.to_bits().to_le_bytes()));
    };
    if let OperatorSpec::Recording(positions) = &scenario.operator {
        numbers(positions);
    }
    match &scenario.tissue {
        TissueSpec::Recording { force_n, .. } => numbers(force_n),
        TissueSpec::Depth { curves, .. } => curves.tables_n().into_iter().for_each(numbers),
        TissueSpec::Unit(_) | TissueSpec::Model(_) => {}
    }
    if let TissueSpec::Unit(tissue) = &scenario.tissue {
        hash.update(tissue.sha256());
    }
    hash.update(format!("{:?} {:?}", scenario.forward_schedule, scenario.backward_schedule));
}

fn describe(design: &Design, values: &[Value]) -> String {
    let axes = design.axes.iter().zip(values);
    axes.map(|(axis, value)| format!("{} = {}", axis.key.path, value.to_toml())).collect::<Vec<_>>().join(", ")
}

/// The lines of two canonical texts that only one of them contains, by section.
#[must_use]
pub fn difference(stored: &str, current: &str) -> String {
    let lines = |text: &str| {
        let mut section = String::new();
        let mut lines = vec![];
        for line in text.lines().filter(|line| !line.is_empty()) {
            match line.strip_prefix('[').and_then(|line| line.strip_suffix(']')) {
                Some(name) if !line.contains('=') => section = format!("{}.", name.trim_start_matches("resolved.")),
                _ => lines.push(format!("{section}{line}")),
            }
        }
        lines
    };
    let (stored, current) = (lines(stored), lines(current));
    let key = |line: &str| line.split(" = ").next().unwrap_or_default().to_owned();
    let mut text = String::new();
    let added: Vec<&String> = current.iter().filter(|line| !stored.contains(line)).collect();
    for old in stored.iter().filter(|line| !current.contains(line)) {
        text.push_str(&format!("  - {old}\n"));
        let now = added.iter().filter(|new| key(new) == key(old));
        now.for_each(|new| text.push_str(&format!("  + {new}\n")));
    }
    let is_new = |new: &&&String| !stored.iter().any(|old| key(old) == key(new));
    added.iter().filter(is_new).for_each(|new| text.push_str(&format!("  + {new}\n")));
    text
}

/// Builds the scenarios of cases.
#[derive(Debug, Clone)]
pub struct CaseMaker<'a> {
    design: &'a Design,
    sampler: UnitCoordinates<'a>,
    factory: CaseFactory<'a>,
    coordinates: Vec<f64>,
    values: Vec<Value>,
}

impl CaseMaker<'_> {
    /// Builds the scenario of a case.
    ///
    /// # Errors
    /// [`SweepError::Case`] for a combination of values that is invalid in a scenario file.
    pub fn scenario(&mut self, case: u64) -> Result<Scenario, SweepError> {
        self.sampler.values(case, &mut self.coordinates, &mut self.values);
        let scenario = self.factory.build(&self.values, self.design.seed(case));
        scenario.map_err(|error| self.refused(case, error.into()))
    }

    /// The error of a case.
    #[must_use]
    pub fn refused(&self, case: u64, source: RunError) -> SweepError {
        let (mut coordinates, mut values) = (vec![], vec![]);
        self.sampler.values(case, &mut coordinates, &mut values);
        SweepError::Case { case, values: describe(self.design, &values), source: Box::new(source) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_difference_shows_only_the_changed_lines() {
        let there = "seeds = 1\n[axes]\nscaling.force = [1.0]\n[resolved.slave]\nvelocity_gain = 15.0\n";
        let here = "seeds = 2\n[axes]\nscaling.force = [1.0]\nscaling.position = [1.0]\n[resolved.slave]\nvelocity_gain = 15.0\n";
        assert_eq!(difference(there, here), "  - seeds = 1\n  + seeds = 2\n  + axes.scaling.position = [1.0]\n");
        assert_eq!(difference(there, there), "");
    }
}
