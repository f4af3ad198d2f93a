mod arm;
mod document;
mod estimate;
mod master;
mod plausibility;
mod regression;
mod rupture;
mod signals;
mod tissue;
mod two_springs;

pub use estimate::{PartFit, PartIdentification, PartRequest, identify_part};
pub use signals::{PartColumns, Signals};

use trocar_document::TextFile;

use crate::IdentifyError;
use crate::system::{System, relative_errors};
use rupture::Rupture;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    Tissue,
    Arm,
    Master,
}

impl Part {
    pub(crate) fn word(self) -> &'static str {
        match self {
            Self::Tissue => "tissue",
            Self::Arm => "arm",
            Self::Master => "master",
        }
    }

    pub(crate) fn moving(self) -> (&'static str, &'static str) {
        match self {
            Self::Tissue => ("slave", "--slave"),
            Self::Arm | Self::Master => ("master", "--master"),
        }
    }

    fn input_name(self) -> &'static str {
        match self {
            Self::Arm => "the desired position",
            Self::Tissue | Self::Master => "the actuator's force",
        }
    }

    /// From the simplest to the most general.
    fn candidates(self, training: &[Signals]) -> Result<Vec<Candidate>, IdentifyError> {
        match self {
            Self::Tissue => tissue::candidates(training),
            Self::Arm => arm::candidates(training),
            Self::Master => master::candidates(training),
        }
    }

    fn conclusions(self, training: &[Signals], chosen: &Chosen<'_>) -> Conclusions {
        match self {
            Self::Tissue => tissue::conclusions(training, chosen),
            Self::Arm => arm::conclusions(training, chosen),
            Self::Master => master::conclusions(training, chosen),
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Spec {
    pub(crate) key: &'static str,
    pub(crate) name: &'static str,
    /// SI; `1` for a plain number.
    pub(crate) unit: &'static str,
    range: Range,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Range {
    /// Above 0; the coordinate is its logarithm.
    Positive,
    /// The first value and the scale of its changes.
    Any(f64, f64),
    /// Expected at 0 within a standard deviation.
    Near0(f64),
}

impl Spec {
    const fn new(key: &'static str, name: &'static str, unit: &'static str, range: Range) -> Self {
        Self { key, name, unit, range }
    }
}

/// `None` if it diverges.
type Simulation = Box<dyn Fn(&[f64], &Signals) -> Option<Vec<f64>>>;

struct Candidate {
    key: &'static str,
    name: &'static str,
    specs: Vec<Spec>,
    /// One value per parameter in each start.
    starts: Vec<Vec<f64>>,
    simulate: Simulation,
    /// If indistinguishable from 0, a simpler structure is used.
    essential: Vec<&'static str>,
    /// With another estimate of the velocity; the interval includes its effect.
    alternative: Option<Simulation>,
    /// By the rounding of the positions.
    reductions: Vec<(&'static str, f64)>,
}

impl Candidate {
    /// 0 if the structure has no such parameter.
    fn value(&self, values: &[f64], key: &str) -> f64 {
        self.specs.iter().position(|spec| spec.key == key).map_or(0.0, |index| values[index])
    }
}

type NamedRupture = (String, Rupture);

struct Chosen<'a> {
    candidate: &'a Candidate,
    values: &'a [f64],
    ruptures: &'a [NamedRupture],
}

impl Chosen<'_> {
    fn value(&self, key: &str) -> f64 {
        self.candidate.value(self.values, key)
    }
}

struct Conclusions {
    open: Vec<String>,
    file: TextFile,
}

#[derive(Clone, Copy)]
struct PartSystem<'a> {
    part: Part,
    specs: &'a [Spec],
    simulate: &'a Simulation,
    recordings: &'a [Signals],
}

impl System for PartSystem<'_> {
    type Model = Vec<f64>;
    type Unknown = usize;

    fn value(unknown: usize, model: &Vec<f64>) -> f64 {
        model[unknown]
    }

    fn set(unknown: usize, model: &mut Vec<f64>, value: f64) {
        model[unknown] = value;
    }

    fn is_positive(&self, unknown: usize) -> bool {
        self.specs[unknown].range == Range::Positive
    }

    fn errors(&self, model: &Vec<f64>) -> Vec<f64> {
        let errors = |one: &Signals| -> Vec<f64> {
            let simulated = (self.simulate)(model, one);
            relative_errors(simulated, one.predicted(self.part), 1.0 / one.variation(self.part)).collect()
        };
        self.recordings.iter().flat_map(errors).collect()
    }

    fn lengths(&self) -> Vec<usize> {
        self.recordings.iter().map(Signals::len).collect()
    }

    fn expected(&self, unknown: usize) -> Option<(f64, f64)> {
        match self.specs[unknown].range {
            Range::Positive => None,
            Range::Any(first, scale) => Some((first, scale)),
            Range::Near0(sd) => Some((0.0, sd)),
        }
    }

    fn prior_sd(&self, unknown: usize) -> Option<f64> {
        match self.specs[unknown].range {
            Range::Near0(sd) => Some(sd),
            Range::Positive | Range::Any(..) => None,
        }
    }
}
