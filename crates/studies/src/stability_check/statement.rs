//! What the certificate of events states about a scenario.

use super::StabilityStudy;
use trocar_stability::{Peaks, TissueSource};

/// The statement of a certificate.
#[derive(Debug, Clone, Copy)]
pub enum Statement<'a> {
    /// The effect of everything that has happened decays, under any sequence of events that keeps the enforced times,
    /// and an additional tissue force moves needle and hand within bounds.
    Decays(&'a Peaks),
    /// The motion stays within bounds, and a sustained swing within them is not excluded: the steps of the force sensor
    /// are an additional force that does not end, of this size in N.
    Bounded(&'a Peaks, f64),
    /// Neither is certified, for this reason.
    None(&'static str),
}

impl Statement<'_> {
    /// The word for the statement in files.
    #[must_use]
    pub fn word(&self) -> &'static str {
        match self {
            Self::Decays(_) => "decays",
            Self::Bounded(..) => "bounded",
            Self::None(_) => "none",
        }
    }
}

impl StabilityStudy {
    /// What the certificate states about the scenario, without the parts of [`LoopVerdict::left_out`].
    ///
    /// [`LoopVerdict::left_out`]: super::LoopVerdict::left_out
    #[must_use]
    pub fn statement(&self) -> Statement<'_> {
        let switching = match &self.switching {
            Ok(switching) => switching,
            Err(reason) => return Statement::None(reason),
        };
        if self.tissue().source == TissueSource::Run {
            return Statement::None("the stiffness of the tissue is known from a run only");
        }
        if self.covers_tissue() != Some(true) {
            return Statement::None("the range of stiffness does not contain the tissue's");
        }
        match &switching.peaks {
            Some(_) if self.force_step_n > 0.0 && !switching.settings.of_loop.adds_to_reading() => Statement::None(
                "the needle yields to the tissue, and the steps of the force sensor act on the hand only",
            ),
            Some(peaks) if self.force_step_n > 0.0 => Statement::Bounded(peaks, 0.5 * self.force_step_n),
            Some(peaks) => Statement::Decays(peaks),
            None if switching.settings.keeps_gap() => Statement::None(
                "the gap that an event leaves is kept, and out of contact nothing closes it: each drop of force can \
                 move the needle on",
            ),
            None if !self.verdict.is_stable_in_range => {
                Statement::None("the loop is unstable without events: see worst_events.toml")
            }
            None if switching.shows_growth() => {
                Statement::None("a sequence of events makes the motion grow: see worst_events.toml")
            }
            None => Statement::None("the search found no functions, which does not show instability"),
        }
    }
}
