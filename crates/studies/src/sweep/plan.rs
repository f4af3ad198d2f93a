use sha2::{Digest, Sha256};

use super::axis::Axis;
use super::base::{base_of, check_acting};
use super::canonical::{design_toml, hash_signals, resolved_toml, sha256};
use super::design::{Design, MAX_CASES, SamplingScheme, UnitCoordinates};
use super::error::SweepError;
use super::file::SweepFile;
use super::part::{Layout, PACK_CASES};
use super::shard::Shard;
use crate::run::RunError;
use trocar_scenario::{
    CaseFactory, Kind, Place, Scenario, ScenarioError, Source, Template, Value, entries, harmless_name, is_axis,
};

#[derive(Debug, Clone)]
pub struct Plan {
    pub design: Design,
    template: Template,
    canonical: String,
}

/// The ends of further axes are checked one by one.
const MAX_CORNER_AXES: usize = 7;

pub fn is_sweep(source: &Source) -> bool {
    entries(source).is_ok_and(|entries| entries.iter().any(is_axis))
}

impl Plan {
    /// Checks the corners of the axes. `settings` override the file.
    pub fn load(source: &Source, settings: &[String]) -> Result<Self, ScenarioError> {
        let file = SweepFile::of(entries(source)?, false)?;
        let (varied, place) = base_of(&file, source)?;
        Self::of(file, source, (&varied, Some(place)), settings)
    }

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
        let mut design = design(file, harmless_name(&source.stem()), first_seed);
        if design.points().is_none() {
            let message = format!("{}: more than {MAX_CASES} cases", source.display());
            return Err(ScenarioError::new(message).remedy("use fewer points or seeds, or a design other than grid"));
        }
        design.focus.dedup();
        let mut plan = Self { canonical: String::new(), design, template };
        check_acting(&plan.design.axes, &[], plan.template.first(), "axes")?;
        plan.check_corners()?;
        plan.canonical = plan.write_canonical()?;
        Ok(plan)
    }

    /// All inputs of the sweep. Equal texts mean equal sweeps.
    pub fn canonical(&self) -> &str {
        &self.canonical
    }

    /// The SHA-256 of [`Plan::canonical`], hexadecimal.
    pub fn hash(&self) -> String {
        sha256(self.canonical.as_bytes())
    }

    pub fn gives(&self, path: &str) -> bool {
        self.template.gives(path)
    }

    pub fn layout(&self, shard: Shard) -> Layout {
        layout(&self.design, &self.canonical, shard.range(self.design.cases().div_ceil(PACK_CASES)))
    }

    /// Each thread needs one.
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

    pub fn scenario(&self, case: u64) -> Result<Scenario, ScenarioError> {
        let (mut coordinates, mut values) = (vec![], vec![]);
        self.design.coordinates().values(case, &mut coordinates, &mut values);
        self.template.whole(&values, self.design.seed(case))
    }

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
        let mut signals = Sha256::new();
        hash_signals(self.template.first(), &mut signals);
        for (index, axis) in self.design.axes.iter().enumerate().filter(|(_, axis)| axis.key.kind == Kind::File) {
            let mut values: Vec<Value> = self.design.axes.iter().map(Axis::first).collect();
            for coordinate in axis.ends() {
                values[index] = axis.value(coordinate);
                hash_signals(&self.template.whole(&values, self.design.first_seed)?, &mut signals);
            }
        }
        Ok(design_toml(&self.design) + &resolved_toml(self.template.first(), signals))
    }
}

pub(super) fn layout(design: &Design, canonical: &str, packs: std::ops::Range<u64>) -> Layout {
    let digest = Sha256::digest(canonical.as_bytes());
    let key = digest.iter().take(8).fold(0, |key, byte| key << 8 | u64::from(*byte));
    Layout { key, columns: design.columns.len(), cases: design.cases(), packs }
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

pub fn stored_design(source: &Source) -> Result<Design, ScenarioError> {
    Ok(design(SweepFile::of(entries(source)?, true)?, harmless_name(&source.stem()), 1))
}

fn describe(design: &Design, values: &[Value]) -> String {
    let axes = design.axes.iter().zip(values);
    axes.map(|(axis, value)| format!("{} = {}", axis.key.path, value.to_toml())).collect::<Vec<_>>().join(", ")
}

/// Lines that only one of the texts contains, by section.
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

#[derive(Debug, Clone)]
pub struct CaseMaker<'a> {
    design: &'a Design,
    sampler: UnitCoordinates<'a>,
    factory: CaseFactory<'a>,
    coordinates: Vec<f64>,
    values: Vec<Value>,
}

impl CaseMaker<'_> {
    pub fn scenario(&mut self, case: u64) -> Result<Scenario, SweepError> {
        self.sampler.values(case, &mut self.coordinates, &mut self.values);
        let scenario = self.factory.build(&self.values, self.design.seed(case));
        scenario.map_err(|error| self.refused(case, error.into()))
    }

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
