use super::scenario::Scenario;
use super::specs::{OperatorSpec, TissueSpec};
use std::sync::Arc;
use trocar_engine::tissue::{DepthCurves, Springs, TissueSettings};

/// Depth that the needle may reach, over the intended one: it overshoots.
pub const OVERSHOOT: f64 = 1.1;

/// The origin of the stiffness of a scenario's tissue.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TissueSource {
    SpringDamper,
    /// Slopes, down to the depth that the needle may reach.
    Model,
    /// Slopes between ruptures.
    Layers,
    RecordedDepth,
    /// Over time. It does not depend on the needle, so the stiffness is 0.
    RecordedForce,
    /// Stated to represent a recorded force over time.
    Stated,
}

impl TissueSource {
    pub fn word(self) -> &'static str {
        match self {
            Self::SpringDamper => "spring-damper",
            Self::Model => "model-slopes",
            Self::Layers => "layer-slopes",
            Self::RecordedDepth => "recorded-depth",
            Self::RecordedForce => "recorded-force",
            Self::Stated => "stated",
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TissueRange {
    pub source: TissueSource,
    pub springs: Springs,
}

impl TissueRange {
    pub fn spring(stiffness_n_per_m: f64, damping_n_s_per_m: f64) -> Self {
        Self { source: TissueSource::SpringDamper, springs: Springs::constant(stiffness_n_per_m, damping_n_s_per_m) }
    }

    /// `None` for a model that states no springs.
    pub fn of_parameters(scenario: &Scenario) -> Option<Self> {
        let (source, springs) = match &scenario.tissue {
            TissueSpec::Recording { .. } => match scenario.stated_tissue {
                Some((stiffness, damping)) => (TissueSource::Stated, Springs::constant(stiffness, damping)),
                None => (TissueSource::RecordedForce, Springs::constant(0.0, 0.0)),
            },
            TissueSpec::Depth { .. } | TissueSpec::Model(_) => {
                let tissue = TissueByDepth::of(scenario)?;
                return tissue.range(scenario.position_scale());
            }
        };
        Some(Self { source, springs })
    }

    fn of_model(settings: &TissueSettings, depth_m: f64) -> Option<Self> {
        let springs = settings.springs(depth_m)?;
        let source = match settings {
            TissueSettings::KelvinVoigt(_) => TissueSource::SpringDamper,
            _ if settings.layers().is_empty() => TissueSource::Model,
            _ => TissueSource::Layers,
        };
        Some(Self { source, springs })
    }

    /// The largest stiffness in N/m, on the way back too.
    pub fn stiffest_n_per_m(&self) -> f64 {
        self.springs.stiffness_n_per_m.1.max(self.springs.drawn_back_n_per_m)
    }

    /// The smallest and the largest stiffness in N/m, on the way back too.
    pub fn sector_n_per_m(&self) -> (f64, f64) {
        (self.springs.stiffness_n_per_m.0, self.stiffest_n_per_m())
    }

    /// True if springs and dampers in the range model the whole tissue: no ruptures, friction or relaxation.
    pub fn is_whole_tissue(&self) -> bool {
        matches!(self.source, TissueSource::SpringDamper | TissueSource::Model | TissueSource::Stated)
    }
}

/// The depth that the needle may reach grows with the position scale.
#[derive(Debug, Clone, PartialEq)]
pub struct TissueByDepth {
    tissue: Scaled,
    /// Smallest and largest.
    hand_m: (f64, f64),
}

#[derive(Debug, Clone, PartialEq)]
enum Scaled {
    Model(Arc<TissueSettings>),
    /// With the presliding distance in m.
    Recording(Arc<DepthCurves>, f64),
}

impl TissueByDepth {
    /// From the intended motion with its tremor; `None` for a recording over time.
    pub fn of(scenario: &Scenario) -> Option<Self> {
        let tissue = match &scenario.tissue {
            TissueSpec::Model(settings) => Scaled::Model(Arc::new((**settings).clone())),
            TissueSpec::Depth { curves, presliding_m, .. } => Scaled::Recording(curves.clone(), *presliding_m),
            TissueSpec::Recording { .. } => return None,
        };
        let (low_m, high_m) = match &scenario.operator {
            OperatorSpec::Recording(positions) => {
                let bounds = (f64::INFINITY, f64::NEG_INFINITY);
                positions.iter().fold(bounds, |(low, high), &x| (x.min(low), x.max(high)))
            }
            OperatorSpec::Ramp { start_m, end_m, .. } => (start_m.min(*end_m), start_m.max(*end_m)),
        };
        let [tremor_m, _] = scenario.tremor.largest();
        Some(Self { tissue, hand_m: (low_m - tremor_m, high_m + tremor_m) })
    }

    /// `None` for a model that states no springs.
    pub fn range(&self, position_scale: f64) -> Option<TissueRange> {
        let (low_m, high_m) = self.hand_m;
        match &self.tissue {
            Scaled::Model(settings) => {
                let surface_m = settings.surface_m().unwrap_or(0.0);
                let depth_m = (OVERSHOOT * (high_m * position_scale - surface_m)).max(0.0);
                TissueRange::of_model(settings, depth_m)
            }
            Scaled::Recording(curves, presliding_m) => {
                let until_m = (low_m + OVERSHOOT * (high_m - low_m)) * position_scale;
                let springs = curves.springs(*presliding_m, until_m);
                Some(TissueRange { source: TissueSource::RecordedDepth, springs })
            }
        }
    }
}
