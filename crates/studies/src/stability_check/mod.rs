//! Comparison of the linear verdicts with the engine: the hand moves by a micrometre and back, and the needle's late
//! motion is compared with its earlier motion.

mod certificate;
mod document;
mod event_limits;
mod events;
mod run;
mod sequences;
mod statement;
mod study;
#[cfg(test)]
mod tests;
mod verdict;
mod verification;

pub use certificate::CertificateFile;
pub use document::{LoopPart, StabilityFile};
pub use event_limits::EventLimit;
pub use events::worst_events;
pub use run::{Verdict, simulate};
pub use sequences::{EventRecord, EventRun, Farthest, random_sequences, without_alarms};
pub use statement::Statement;
pub use study::{MAX_STIFFNESS_N_PER_M, StabilityStudy, is_tissue};
pub use verdict::LoopVerdict;
pub use verification::{VerificationError, Verified, verify};

use std::sync::atomic::{AtomicBool, Ordering};

use crate::run::RunError;
use thiserror::Error;
use trocar_base::parallel::try_map;
use trocar_scenario::{Scenario, ScenarioError};
use trocar_stability::{LinearLoop, Parameter, StabilityError, StabilityMap, TissueRange, is_near_boundary};

/// Relative distance to the boundary within which a verdict does not count.
pub const BAND: f64 = 0.005;

#[derive(Debug, Error)]
pub enum CheckError {
    #[error(transparent)]
    Stability(#[from] StabilityError),
    #[error(transparent)]
    Run(#[from] RunError),
}

/// Fails for a model of the tissue that states no springs.
pub fn tissue_range(scenario: &Scenario) -> Result<TissueRange, RunError> {
    let unknown = || ScenarioError::new("this kind of tissue states no springs, which the analysis needs");
    Ok(TissueRange::of_parameters(scenario).ok_or_else(unknown)?)
}

pub fn linear_loop(scenario: &Scenario) -> Result<LinearLoop, CheckError> {
    Ok(LinearLoop::of(scenario, tissue_range(scenario)?)?)
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unconfirmed {
    pub x: f64,
    pub y: f64,
    pub analytic_stable: bool,
    pub simulated: Verdict,
    /// True within [`BAND`] of the boundary.
    pub is_near_boundary: bool,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Check {
    /// Ordered like the map; `None` for points skipped by a stop.
    pub simulated: Vec<Option<Verdict>>,
    /// Points that are not within [`BAND`] of the boundary.
    pub judged: usize,
    pub disagreements: Vec<Unconfirmed>,
    pub undecided: Vec<Unconfirmed>,
}

impl Check {
    pub fn counts(&self) -> [usize; 3] {
        let judged = |points: &[Unconfirmed]| points.iter().filter(|point| !point.is_near_boundary).count();
        let [disagreeing, undecided] = [&self.disagreements, &self.undecided].map(|points| judged(points));
        [self.judged - disagreeing - undecided, disagreeing, undecided]
    }

    pub fn agreement(&self) -> Option<f64> {
        let [agreeing, disagreeing, _] = self.counts();
        let decided = agreeing + disagreeing;
        (decided > 0).then(|| agreeing as f64 / decided as f64)
    }
}

/// Calls `done` after each run, until `stop` is set.
pub fn check(
    (scenario, settings): (&Scenario, &LinearLoop),
    map: &StabilityMap,
    stop: &AtomicBool,
    done: impl Fn() + Sync,
) -> Result<Check, CheckError> {
    let at = |index: usize| -> [(Parameter, f64); 2] {
        let (row, column) = (index / map.x.count, index % map.x.count);
        [(map.x.parameter, map.x.value(column)), (map.y.parameter, map.y.value(row))]
    };
    let points = try_map(map.stable.len(), |index| {
        if stop.load(Ordering::Relaxed) {
            return Ok(None);
        }
        let point = at(index);
        let here = settings.with(point[0].0, point[0].1).with(point[1].0, point[1].1);
        let verdict = simulate(scenario, &here)?;
        let near = is_near_boundary(settings, point, BAND)?;
        done();
        Ok::<_, CheckError>(Some((verdict, near)))
    })?;
    let judged = points.iter().filter(|point| matches!(point, Some((_, false)))).count();
    let unconfirmed = |(index, point): (usize, &Option<(Verdict, bool)>)| {
        let (simulated, is_near_boundary) = (*point)?;
        let analytic_stable = map.stable[index];
        let expected = if analytic_stable { Verdict::Decays } else { Verdict::Grows };
        let [(_, x), (_, y)] = at(index);
        (simulated != expected).then_some(Unconfirmed { x, y, analytic_stable, simulated, is_near_boundary })
    };
    let (undecided, disagreements) =
        points.iter().enumerate().filter_map(unconfirmed).partition(|point| point.simulated == Verdict::Undecided);
    Ok(Check {
        simulated: points.iter().map(|point| point.map(|(verdict, _)| verdict)).collect(),
        judged,
        disagreements,
        undecided,
    })
}
