//! The stability limits of a parameter.

use super::machines::Machines;
use super::{ClosedLoop, LoopSettings, Parameter, StabilityError};
use crate::teleoperation::ControllerKind;

/// Number of bisections of a boundary: beyond the precision of a double.
const BISECTIONS: usize = 80;

/// The scan for boundaries.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Search {
    /// Minimum value above 0.
    pub low: f64,
    /// Maximum value.
    pub high: f64,
    /// Number of logarithmically spaced values; a change and return between two neighbours is not detected.
    pub points: usize,
    /// Relative width at which the bisection of a boundary ends; with 0 at the last digit.
    pub tolerance: f64,
}

impl Search {
    /// The search range of a parameter's limit.
    #[must_use]
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

/// The stable ranges of a parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Limit {
    /// The parameter.
    pub parameter: Parameter,
    /// Its value in the given loop.
    pub value: f64,
    /// The ranges over which the loop is stable, increasing.
    pub stable: Vec<(f64, f64)>,
    /// The scan that was used.
    pub search: Search,
}

impl Limit {
    /// The upper end of the stable range that contains the present value, otherwise of the last range below it. `None`
    /// without any; infinite if the range reaches the end of the search.
    #[must_use]
    pub fn largest(&self) -> Option<f64> {
        let (_, end) = *self.stable.iter().rev().find(|(start, _)| *start <= self.value)?;
        Some(if end >= self.search.high { f64::INFINITY } else { end })
    }

    /// Whether another stable range lies above.
    #[must_use]
    pub fn is_not_all(&self) -> bool {
        let last = self.stable.last().map_or(0.0, |(_, end)| *end);
        self.largest().is_some_and(|largest| largest < last)
    }
}

/// Tests the loop's stability with changed values; rebuilds the machines only if necessary.
pub(super) struct StabilityTester<'a> {
    settings: &'a LoopSettings,
    machines: Machines,
    closed: ClosedLoop,
}

impl<'a> StabilityTester<'a> {
    pub(super) fn new(settings: &'a LoopSettings) -> Result<Self, StabilityError> {
        let machines = Machines::new(settings)?;
        Ok(Self { settings, closed: ClosedLoop::of(&machines, settings, None)?, machines })
    }

    pub(super) fn is_stable(&self, changes: &[(Parameter, f64)]) -> Result<bool, StabilityError> {
        let with = |settings: LoopSettings, change: &(Parameter, f64)| settings.with(change.0, change.1);
        let settings = changes.iter().fold(self.settings.clone(), with);
        if self.machines.matches(&settings) {
            return ClosedLoop::of(&self.machines, &settings, Some(&self.closed))?.is_stable();
        }
        ClosedLoop::new(&settings)?.is_stable()
    }

    /// Whether the machines are the same with another value.
    pub(super) fn has_machines_of(&self, parameter: Parameter, value: f64) -> bool {
        self.machines.matches(&self.settings.with(parameter, value))
    }

    /// The boundary between two values, by bisection to a relative width: the last value with the verdict `first`.
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

/// The stable ranges of a parameter, with the others unchanged.
///
/// The range is scanned first, because the stable values need not be one interval; then each change of the verdict is
/// bisected. A delay whose samples wait for the next tick has its limit at a whole tick.
///
/// # Errors
/// [`StabilityError`] if the loop cannot be built or analysed at one of the values.
pub fn largest_stable(settings: &LoopSettings, parameter: Parameter, search: Search) -> Result<Limit, StabilityError> {
    let tester = StabilityTester::new(settings)?;
    let mut stable = vec![];
    let mut last: Option<(f64, bool)> = None;
    let mut start = None;
    // A scale of 0 opens the loop of the paper's controller; the gains of others are divided by it.
    let is_scale = matches!(parameter, Parameter::ForceScale | Parameter::PositionScale);
    let is_baseline = settings.link.controller.kind == ControllerKind::PositionForce;
    for value in search.values(parameter.may_be_zero() && (is_baseline || !is_scale)) {
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
