//! What a person does and what the needle meets, as a scenario says it.

use std::sync::Arc;

use super::error::ScenarioError;
use super::replay::{RecordingSpec, missing_recording, rupture_depths, rupture_ticks};
use super::values::Values;
use crate::operator::{Hand, MotionSettings};
use crate::recording::Resampled;
use crate::time::TickGrid;
use crate::tissue::{DepthCurves, ReplayIndex, ReplaySettings, TissueSettings};

/// What the person does.
#[derive(Debug, Clone, PartialEq)]
pub enum OperatorSpec {
    /// Positions in m, one a tick: recorded, or computed beforehand.
    Recording(Arc<[f64]>),
    /// A constant speed.
    Ramp {
        /// Where it begins, in m.
        start_m: f64,
        /// Where it ends, in m.
        end_m: f64,
        /// How fast it gets there, in m/s.
        speed_m_per_s: f64,
    },
    /// Whatever a hand does that is there now.
    Hand(Arc<Hand>),
}

/// What the needle meets.
#[derive(Debug, Clone, PartialEq)]
pub enum TissueSpec {
    /// Forces in N, one a tick, and the ticks of the labelled ruptures.
    Recording {
        /// Forces in N, one a tick.
        force_n: Arc<[f64]>,
        /// When the labels place a rupture.
        rupture_ticks: Arc<[u64]>,
    },
    /// A recording by depth.
    Depth {
        /// What the recording felt at each depth.
        curves: Arc<DepthCurves>,
        /// Depths at which layers rupture, in m.
        rupture_depths_m: Arc<[f64]>,
        /// Travel over which the force turns to that of the way out, in m.
        presliding_m: f64,
    },
    /// A tissue that is made of settings alone.
    Model(Box<TissueSettings>),
}

impl From<TissueSettings> for TissueSpec {
    fn from(settings: TissueSettings) -> Self {
        Self::Model(Box::new(settings))
    }
}

impl TissueSpec {
    /// The settings of a tissue that is made of them alone.
    #[must_use]
    pub fn settings(&self) -> Option<&TissueSettings> {
        match self {
            Self::Model(settings) => Some(settings),
            Self::Recording { .. } | Self::Depth { .. } => None,
        }
    }
}

/// What the person does, given the recording (as it is and on the ticks) where one is replayed.
pub(super) fn operator(
    values: &mut Values,
    grid: &TickGrid,
    replay: Option<(&RecordingSpec, &Resampled)>,
) -> Result<OperatorSpec, ScenarioError> {
    let (tick_s, ticks) = (grid.tick_s(), grid.ticks() + 1);
    Ok(match MotionSettings::read(values)? {
        MotionSettings::Recording => {
            let (_, resampled) = replay.ok_or_else(|| missing_recording(values))?;
            OperatorSpec::Recording(resampled.position_m.as_slice().into())
        }
        MotionSettings::Ramp(ramp) => {
            OperatorSpec::Ramp { start_m: ramp.start.start_m, end_m: ramp.end.end_m, speed_m_per_s: ramp.speed_m_per_s }
        }
        MotionSettings::MinimumJerk(motion) => OperatorSpec::Recording(motion.positions_m(tick_s, ticks)),
        MotionSettings::InsertionExtraction(motion) => OperatorSpec::Recording(motion.positions_m(tick_s, ticks)),
        MotionSettings::Sine(motion) => OperatorSpec::Recording(motion.positions_m(tick_s, ticks)),
    })
}

/// What the needle meets, given the recording (as it is and on the ticks) where one is replayed.
pub(super) fn tissue(
    values: &mut Values,
    grid: &TickGrid,
    replay: Option<(&RecordingSpec, &Resampled)>,
) -> Result<TissueSpec, ScenarioError> {
    Ok(match (TissueSettings::read(values)?, replay) {
        (TissueSettings::Recording(ReplaySettings { index }), Some((spec, resampled))) => match index {
            ReplayIndex::Time => TissueSpec::Recording {
                force_n: resampled.force_n.as_slice().into(),
                rupture_ticks: rupture_ticks(spec, grid),
            },
            ReplayIndex::Depth { presliding_m } => TissueSpec::Depth {
                curves: DepthCurves::new(spec.recording.position_m(), spec.recording.force_n())
                    .map_err(|error| values.out_of_range(&error))?
                    .into(),
                rupture_depths_m: rupture_depths(spec),
                presliding_m,
            },
        },
        (settings, _) => settings.into(),
    })
}
