use std::f64::consts::TAU;

use super::machines::Machines;
use super::{ClosedLoop, LinearLoop, Parameter, StabilityError};
use trocar_engine::teleoperation::ControllerKind;

const MAX_CROSSINGS: usize = 1000;
const BESIDE: f64 = 1e-6;

const BISECTIONS: usize = 80;

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Search {
    /// Above 0.
    pub low: f64,
    pub high: f64,
    /// Logarithmically spaced. Two changes of the verdict between neighbours remain undetected.
    pub points: usize,
    /// Relative; 0 bisects to the last digit.
    pub tolerance: f64,
}

impl Search {
    pub fn of(parameter: Parameter) -> Self {
        let (low, high) = match parameter {
            Parameter::ForceScale | Parameter::PositionScale => (1e-3, 1e3),
            Parameter::Stiffness => (1e-1, 1e7),
            Parameter::Delay | Parameter::ForwardDelay | Parameter::BackwardDelay => (1e-5, 2.0),
            _ => (1e-6, 1e6),
        };
        Self { low, high, points: 120, tolerance: 0.0 }
    }

    fn values(&self, with_zero: bool) -> impl Iterator<Item = f64> {
        let Self { low, high, points, .. } = *self;
        let step = (high / low).powf(1.0 / (points - 1) as f64);
        let at = move |k: usize| if k + 1 == points { high } else { low * step.powi(k as i32) };
        with_zero.then_some(0.0).into_iter().chain((0..points).map(at))
    }
}

#[derive(Debug, Clone, PartialEq)]
pub struct Limit {
    pub parameter: Parameter,
    pub value: f64,
    pub stable: Vec<(f64, f64)>,
    pub search: Search,
}

impl Limit {
    /// Infinite beyond the search.
    pub fn largest(&self) -> Option<f64> {
        let (_, end) = *self.stable.iter().rev().find(|(start, _)| *start <= self.value)?;
        Some(if end >= self.search.high { f64::INFINITY } else { end })
    }

    /// True if another stable range lies above.
    pub fn is_not_all(&self) -> bool {
        let last = self.stable.last().map_or(0.0, |(_, end)| *end);
        self.largest().is_some_and(|largest| largest < last)
    }
}

pub(super) struct StabilityTester<'a> {
    settings: &'a LinearLoop,
    machines: Machines,
    closed: ClosedLoop,
}

impl<'a> StabilityTester<'a> {
    pub(super) fn new(settings: &'a LinearLoop) -> Result<Self, StabilityError> {
        let machines = Machines::new(settings)?;
        Ok(Self { settings, closed: ClosedLoop::of(&machines, settings, None)?, machines })
    }

    /// Tests the ends of the tissue's ranges.
    pub(super) fn is_stable(&self, changes: &[(Parameter, f64)]) -> Result<bool, StabilityError> {
        let with = |settings: LinearLoop, change: &(Parameter, f64)| settings.with(change.0, change.1);
        let settings = changes.iter().fold(self.settings.clone(), with);
        let mut last = self.machines.matches(&settings).then(|| self.closed.clone());
        let machines = if last.is_some() { &self.machines } else { &Machines::new(&settings)? };
        for end in settings.at_ends() {
            let closed = ClosedLoop::of(machines, &end, last.as_ref())?;
            if !closed.is_stable()? {
                return Ok(false);
            }
            last = Some(closed);
        }
        Ok(true)
    }

    /// Finds ranges that the scan steps over.
    fn between_crossings(&self, parameter: Parameter) -> Result<Vec<f64>, StabilityError> {
        let value = self.settings.get(parameter);
        let mut crossings: Vec<f64> = match parameter {
            Parameter::Delay | Parameter::ForwardDelay | Parameter::BackwardDelay => {
                let ways = if parameter == Parameter::Delay { 2.0 } else { 1.0 };
                let max_s = Search::of(parameter).high;
                let mut all = vec![];
                for (angle, lead) in self.closed.unit_crossings()? {
                    let added_s = |turn: f64| (lead + turn * TAU) / angle * self.settings.tick_s / ways;
                    let first = ((-value * ways * angle / self.settings.tick_s - lead) / TAU).ceil();
                    let delays = (0..MAX_CROSSINGS).map(|k| value + added_s(first + k as f64));
                    all.extend(delays.take_while(|delay_s| *delay_s < max_s));
                }
                all
            }
            Parameter::ForceScale | Parameter::PositionScale if self.settings.link.is_baseline() => {
                let factors = self.closed.margins()?;
                let finite = factors.gain.filter(|factor| factor.is_finite());
                finite.into_iter().chain(factors.gain_below).map(|factor| factor * value).collect()
            }
            _ => vec![],
        };
        crossings.sort_by(f64::total_cmp);
        let beside = crossings.iter().flat_map(|at| [at * (1.0 - BESIDE), at * (1.0 + BESIDE)]);
        let between = crossings.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
        Ok(if matches!(parameter, Parameter::ForceScale | Parameter::PositionScale) {
            beside.collect()
        } else {
            between.collect()
        })
    }

    pub(super) fn has_machines_of(&self, parameter: Parameter, value: f64) -> bool {
        self.machines.matches(&self.settings.with(parameter, value))
    }

    /// Returns the last value with the verdict `first`.
    pub(super) fn boundary(
        &self,
        parameter: Parameter,
        (mut here, mut there): (f64, f64),
        first: bool,
        tolerance: f64,
    ) -> Result<f64, StabilityError> {
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (here + there);
            if middle == here || middle == there || (there - here).abs() <= tolerance * middle {
                break;
            }
            if self.is_stable(&[(parameter, middle)])? == first { here = middle } else { there = middle }
        }
        Ok(here)
    }
}

/// Scans, because the stable values need not form one interval.
pub fn largest_stable(settings: &LinearLoop, parameter: Parameter, search: Search) -> Result<Limit, StabilityError> {
    let tester = StabilityTester::new(settings)?;
    let mut stable = vec![];
    let mut last: Option<(f64, bool)> = None;
    let mut start = None;
    // A scale of 0 opens the loop of the paper's controller; other controllers divide gains by it.
    let is_scale = matches!(parameter, Parameter::ForceScale | Parameter::PositionScale);
    let is_baseline = settings.link.controller.kind == ControllerKind::PositionForce;
    let mut values: Vec<f64> = search.values(parameter.may_be_zero() && (is_baseline || !is_scale)).collect();
    values.extend(tester.between_crossings(parameter)?.into_iter().filter(|at| (search.low..search.high).contains(at)));
    values.sort_by(f64::total_cmp);
    for value in values {
        let verdict = tester.is_stable(&[(parameter, value)])?;
        match last {
            None if verdict => start = Some(value),
            Some((before, was)) if was != verdict => {
                let at = tester.boundary(parameter, (before, value), was, search.tolerance)?;
                if verdict {
                    start = Some(at);
                } else if let Some(from) = start.take() {
                    stable.push((from, at));
                }
            }
            _ => {}
        }
        last = Some((value, verdict));
    }
    if let Some(from) = start {
        stable.push((from, search.high));
    }
    Ok(Limit { parameter, value: settings.get(parameter), stable, search })
}
