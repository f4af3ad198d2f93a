//! The tissue in a linear loop, from the parameters of a scenario.

use super::scenario::Scenario;
use super::specs::{OperatorSpec, TissueSpec};
use trocar_engine::tissue::Springs;

/// The origin of the stiffness of a scenario's tissue.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TissueSource {
    /// A spring and a damper.
    SpringDamper,
    /// The slopes of a tissue model without layers, down to the intended depth.
    Model,
    /// The slopes of the layers between their ruptures.
    Layers,
    /// The rising parts of a recorded force over depth.
    RecordedDepth,
    /// The slopes in a simulated run.
    Run,
    /// A recorded force over time. It does not depend on the needle, so the stiffness is 0.
    RecordedForce,
    /// A spring and a damper that the scenario states to represent a recorded force over time.
    Stated,
}

impl TissueSource {
    /// The word for this source in files.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::SpringDamper => "spring-damper",
            Self::Model => "model-slopes",
            Self::Layers => "layer-slopes",
            Self::RecordedDepth => "recorded-depth",
            Self::Run => "run-slopes",
            Self::RecordedForce => "recorded-force",
            Self::Stated => "stated",
        }
    }
}

/// The stiffness range of a tissue, and its damping.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TissueRange {
    /// The origin of the range.
    pub source: TissueSource,
    /// The smallest and the largest stiffness in N/m, at least 0.
    pub stiffness_n_per_m: (f64, f64),
    /// The damping in N·s/m; 0 unless the tissue is a spring and a damper.
    pub damping_n_s_per_m: f64,
    /// The largest damping in N·s/m that the tissue may have at some depth; the certificate of events covers it.
    pub largest_damping_n_s_per_m: f64,
}

impl TissueRange {
    /// A spring and a damper.
    #[must_use]
    pub fn spring(stiffness_n_per_m: f64, damping_n_s_per_m: f64) -> Self {
        Self {
            source: TissueSource::SpringDamper,
            stiffness_n_per_m: (stiffness_n_per_m, stiffness_n_per_m),
            damping_n_s_per_m,
            largest_damping_n_s_per_m: damping_n_s_per_m,
        }
    }

    /// A range without damping.
    #[must_use]
    pub fn of_slopes(source: TissueSource, (low, high): (f64, f64)) -> Self {
        Self { source, stiffness_n_per_m: (low.max(0.0), high.max(0.0)), ..Self::spring(0.0, 0.0) }
    }

    fn up_to(self, largest_damping_n_s_per_m: f64) -> Self {
        Self { largest_damping_n_s_per_m, ..self }
    }

    /// The tissue from a scenario's parameters and recordings. `None` if only a run shows it: for the tissue of a unit,
    /// and for one that stiffens with depth under a live hand.
    #[must_use]
    pub fn of_parameters(scenario: &Scenario) -> Option<Self> {
        match &scenario.tissue {
            TissueSpec::Recording { .. } => Some(match scenario.stated_tissue {
                Some((stiffness, damping)) => Self { source: TissueSource::Stated, ..Self::spring(stiffness, damping) },
                None => Self { source: TissueSource::RecordedForce, ..Self::spring(0.0, 0.0) },
            }),
            TissueSpec::Depth { curves, .. } => {
                Some(Self::of_slopes(TissueSource::RecordedDepth, (0.0, curves.steepest_rise_n_per_m())))
            }
            TissueSpec::Unit(_) => None,
            TissueSpec::Model(settings) => Some(match settings.springs(intended_depth_m(scenario))? {
                Springs::SpringDamper(stiffness, damping) => Self::spring(stiffness, damping),
                Springs::ToDepth(slopes, damping) => Self::of_slopes(TissueSource::Model, slopes).up_to(damping),
                Springs::Layers(slopes, damping) => Self::of_slopes(TissueSource::Layers, slopes).up_to(damping),
            }),
        }
    }

    /// True if the stiffness is a single number.
    #[must_use]
    pub fn is_single(&self) -> bool {
        self.stiffness_n_per_m.0 == self.stiffness_n_per_m.1
    }

    /// True if springs in the range model the whole tissue: no ruptures, friction or relaxation.
    #[must_use]
    pub fn is_whole_tissue(&self) -> bool {
        matches!(self.source, TissueSource::SpringDamper | TissueSource::Model | TissueSource::Stated)
    }

    /// A description of the unmodelled parts of the tissue, if there are any.
    #[must_use]
    pub fn left_out(&self) -> Option<&'static str> {
        Some(match self.source {
            TissueSource::SpringDamper => "lost contact",
            TissueSource::Model => "the damping of the tissue, and lost contact",
            TissueSource::Layers => {
                "the ruptures, the relaxation, the damping and the sliding friction of the tissue, and lost contact"
            }
            TissueSource::RecordedDepth => {
                "the falls of the recorded force, its unloading when the needle retreats, and lost contact"
            }
            TissueSource::Run => {
                "everything of the unit's tissue but its stiffness during the advance, and lost contact"
            }
            TissueSource::RecordedForce => return None,
            TissueSource::Stated => "the recorded force (replaced by the stated spring and damper)",
        })
    }
}

fn intended_depth_m(scenario: &Scenario) -> Option<f64> {
    let desired_m = match &scenario.operator {
        OperatorSpec::Recording(positions) => positions.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        OperatorSpec::Ramp { start_m, end_m, .. } => start_m.max(*end_m),
        OperatorSpec::Hand(_) => return None,
    };
    let surface_m = scenario.tissue.settings()?.surface_m()?;
    Some((desired_m * scenario.position_scale() - surface_m).max(0.0))
}
