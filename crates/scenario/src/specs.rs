use std::sync::Arc;

use trocar_core::settings::KeySource as _;

use super::error::ScenarioError;
use super::replay::{RecordingSpec, rupture_depths, rupture_ticks};
use super::scenario::ScenarioUpdate;
use super::values::{STATED, Values};
use trocar_core::error::non_negative;
use trocar_core::time::TickGrid;
use trocar_engine::operator::MotionSettings;
use trocar_engine::tissue::{DepthCurves, ReplayIndex, ReplaySettings, TissueSettings};
use trocar_recording::Resampled;

#[derive(Debug, Clone, PartialEq)]
pub enum OperatorSpec {
    /// In m, one per tick.
    Recording(Arc<[f64]>),
    Ramp {
        /// Start position in m.
        start_m: f64,
        /// End position in m.
        end_m: f64,
        /// Speed in m/s.
        speed_m_per_s: f64,
    },
}

#[derive(Debug, Clone, PartialEq)]
pub enum TissueSpec {
    /// In N, one per tick, and the ticks of the labelled ruptures.
    Recording {
        force_n: Arc<[f64]>,
        rupture_ticks: Arc<[u64]>,
    },
    Depth {
        curves: Arc<DepthCurves>,
        /// In m.
        rupture_depths_m: Arc<[f64]>,
        /// Travel over which the force changes to the withdrawal force, in m.
        presliding_m: f64,
    },
    Model(Box<TissueSettings>),
}

impl From<TissueSettings> for TissueSpec {
    fn from(settings: TissueSettings) -> Self {
        Self::Model(Box::new(settings))
    }
}

impl TissueSpec {
    /// `None` for a recording.
    pub fn settings(&self) -> Option<&TissueSettings> {
        match self {
            Self::Model(settings) => Some(settings),
            Self::Recording { .. } | Self::Depth { .. } => None,
        }
    }
}

/// `None` for a replay without a recording, where the caller keeps the motion.
pub(super) fn operator(
    values: &mut Values,
    grid: &TickGrid,
    replay: Option<&(RecordingSpec, Resampled)>,
) -> Result<Option<OperatorSpec>, ScenarioError> {
    let (tick_s, ticks) = (grid.tick_s(), grid.ticks() + 1);
    Ok(Some(match MotionSettings::read(values)? {
        MotionSettings::Recording => {
            let Some((_, resampled)) = replay else { return Ok(None) };
            OperatorSpec::Recording(resampled.position_m.as_slice().into())
        }
        MotionSettings::Ramp(ramp) => {
            OperatorSpec::Ramp { start_m: ramp.start.start_m, end_m: ramp.end.end_m, speed_m_per_s: ramp.speed_m_per_s }
        }
        MotionSettings::MinimumJerk(motion) => OperatorSpec::Recording(motion.positions_m(tick_s, ticks)),
        MotionSettings::InsertionExtraction(motion) => OperatorSpec::Recording(motion.positions_m(tick_s, ticks)),
        MotionSettings::Sine(motion) => OperatorSpec::Recording(motion.positions_m(tick_s, ticks)),
    }))
}

pub(super) fn tissue(of: &mut ScenarioUpdate<'_>) -> Result<(), ScenarioError> {
    let ScenarioUpdate { scenario, values, replay } = of;
    let grid = &scenario.grid;
    scenario.tissue = match (TissueSettings::read(*values)?, *replay) {
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
        (TissueSettings::Recording(ReplaySettings { index }), None) => {
            if let (TissueSpec::Depth { presliding_m: kept, .. }, ReplayIndex::Depth { presliding_m }) =
                (&mut scenario.tissue, index)
            {
                *kept = presliding_m;
            }
            return Ok(());
        }
        (settings, _) => settings.into(),
    };
    Ok(())
}

pub(super) fn stated_tissue(values: &mut Values) -> Result<Option<(f64, f64)>, ScenarioError> {
    if !values.states_tissue() {
        return Ok(None);
    }
    let [stiffness, damping] = STATED.map(|key| {
        let value = values.number(key)?;
        non_negative(key, value).map_err(|error| values.out_of_range(&error))
    });
    Ok(Some((stiffness?, damping?)))
}
