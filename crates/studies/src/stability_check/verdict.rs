//! The verdict on the linear loop of a scenario, and the parts that it leaves out.

use super::document::LoopPart;
use super::{CheckError, document, linear_loop};
use trocar_document::json_of;
use trocar_scenario::Scenario;
use trocar_stability::{
    ClosedLoop, LeftOut, LinearLoop, LoopLimit, Margins, Mode, Parameter, RangeVerdict, Search, StabilityError,
    VaryingDelays, assumed_passive, inputs, largest_stable, left_out_with, loop_limits,
};

/// The verdict on the linear loop of a scenario, for all user interfaces.
#[derive(Debug, Clone)]
pub struct LoopVerdict {
    /// The loop, at the worst spring and damper of its tissue.
    pub settings: LinearLoop,
    /// The dominant mode of that loop.
    pub mode: Mode,
    /// Margins of the loop.
    pub margins: Margins,
    /// The verdict at every spring and damper of the tissue, and out of contact.
    pub range: RangeVerdict,
    /// The parts of the scenario with which the stability is unknown.
    pub left_out: Vec<LeftOut>,
    /// The parts that the loop does not model because they only dissipate energy.
    pub assumed_passive: Vec<LeftOut>,
    /// The parts that act on the loop as inputs.
    pub inputs: Vec<LeftOut>,
    /// The limits of motors and force sensor that the loop never reaches.
    pub unreached: Vec<LoopLimit>,
    /// Delays that vary from tick to tick; `None` if they are constant or unbounded.
    pub delays: Option<VaryingDelays>,
}

impl LoopVerdict {
    /// Judges a scenario.
    ///
    /// # Errors
    /// [`CheckError`].
    pub fn of(scenario: &Scenario) -> Result<Self, CheckError> {
        Self::with_loop(scenario, linear_loop(scenario)?)
    }

    /// Judges a scenario whose loop is known.
    ///
    /// # Errors
    /// [`CheckError`].
    pub fn with_loop(scenario: &Scenario, settings: LinearLoop) -> Result<Self, CheckError> {
        let closed = ClosedLoop::new(&settings)?;
        let delays = VaryingDelays::of(scenario, &settings)?;
        let limits = loop_limits(scenario);
        Ok(Self {
            mode: closed.dominant_mode()?,
            margins: closed.margins()?,
            range: settings.in_range()?,
            left_out: left_out_with(scenario, delays.as_ref(), &limits),
            assumed_passive: assumed_passive(scenario),
            inputs: inputs(scenario),
            unreached: limits.into_iter().filter(LoopLimit::is_unreached).collect(),
            delays,
            settings,
        })
    }

    /// True if the loop is stable at every spring and damper of its tissue and out of contact, for every order of varying
    /// delays; `None` if the analysis leaves out a part.
    #[must_use]
    pub fn is_stable(&self) -> Option<bool> {
        self.left_out.is_empty().then_some(self.range.is_stable)
    }

    /// The verdict in one sentence, with the tissue for which it holds.
    #[must_use]
    pub fn sentence(&self) -> String {
        document::verdict::sentence(self)
    }

    /// For a loop that is not stable, a continuation of "the loop is" with the largest stable force scale; `None` for any
    /// other verdict.
    ///
    /// # Errors
    /// [`StabilityError`].
    pub fn instability(&self) -> Result<Option<String>, StabilityError> {
        if self.is_stable() != Some(false) {
            return Ok(None);
        }
        let scale = Parameter::ForceScale;
        let limit = largest_stable(&self.settings, scale, Search { tolerance: 1e-6, ..Search::of(scale) })?;
        Ok(Some(document::verdict::instability(self, &limit)))
    }

    /// The verdict as JSON, with its tissue and the omitted parts: the first part of `stability.json`, also for the
    /// page and Python.
    #[must_use]
    pub fn json(&self) -> serde_json::Value {
        json_of(&LoopPart::of(self))
    }
}
