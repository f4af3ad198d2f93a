//! The verdict on the linear loop of a scenario, and the parts that it leaves out.

use super::document::LoopPart;
use super::tissue_of_run::linear_loop;
use super::{CheckError, document};
use trocar_document::json_of;
use trocar_scenario::Scenario;
use trocar_stability::{
    ClosedLoop, LeftOut, LinearLoop, LoopLimit, Margins, Mode, VaryingDelays, left_out_with, loop_limits, unmodelled,
};

/// The verdict on the linear loop of a scenario, for all user interfaces.
#[derive(Debug, Clone)]
pub struct LoopVerdict {
    /// The loop, at the worst stiffness of its tissue.
    pub settings: LinearLoop,
    /// The dominant mode of that loop.
    pub mode: Mode,
    /// Margins of the loop.
    pub margins: Margins,
    /// True if the loop is stable at every stiffness of its tissue, and in free motion.
    pub is_stable_in_range: bool,
    /// The parts of the scenario that the analysis leaves out, other than tissue and augmentation.
    pub left_out: Vec<LeftOut>,
    /// The limits of motors and force sensor that the loop never reaches.
    pub unreached: Vec<LoopLimit>,
    /// Delays that vary from tick to tick; `None` if they are constant or unbounded.
    pub delays: Option<VaryingDelays>,
    /// Everything that the linear loop leaves out, including tissue and augmentation.
    pub unmodelled: Vec<String>,
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
        let left_out = left_out_with(scenario, delays.as_ref(), &limits);
        Ok(Self {
            mode: closed.dominant_mode()?,
            margins: closed.margins()?,
            is_stable_in_range: settings.is_stable()?,
            unmodelled: unmodelled(scenario, &settings.tissue, &left_out),
            unreached: limits.into_iter().filter(LoopLimit::is_unreached).collect(),
            left_out,
            delays,
            settings,
        })
    }

    /// True if the loop is stable in contact with its tissue and in free motion, for every order of varying delays;
    /// `None` if the analysis leaves out a part.
    #[must_use]
    pub fn is_stable(&self) -> Option<bool> {
        self.left_out.is_empty().then_some(self.is_stable_in_range)
    }

    /// True if the loop is stable at the worst stiffness, without the omitted parts.
    #[must_use]
    pub fn is_linear_loop_stable(&self) -> bool {
        self.mode.spectral_radius < 1.0
    }

    /// The verdict in one sentence, with the tissue for which it holds.
    #[must_use]
    pub fn sentence(&self) -> String {
        document::verdict::sentence(self)
    }

    /// The verdict as JSON, with its tissue and the omitted parts: the first part of `stability.json`, also for the
    /// page and Python.
    #[must_use]
    pub fn json(&self) -> serde_json::Value {
        json_of(&LoopPart::of(self))
    }
}
