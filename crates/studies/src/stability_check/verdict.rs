use super::document::LoopPart;
use super::{CheckError, document, linear_loop};
use trocar_document::json_of;
use trocar_scenario::Scenario;
use trocar_stability::{
    ClosedLoop, LeftOut, LinearLoop, LoopLimit, Margins, Mode, Parameter, RangeVerdict, Search, StabilityError,
    VaryingDelays, assumed_passive, inputs, largest_stable, left_out_with, loop_limits,
};

#[derive(Debug, Clone)]
pub struct LoopVerdict {
    /// At the worst point of the tissue.
    pub settings: LinearLoop,
    pub mode: Mode,
    pub margins: Margins,
    /// At every point of the tissue, and out of contact.
    pub range: RangeVerdict,
    /// Parts with unknown effect on the stability.
    pub left_out: Vec<LeftOut>,
    /// Parts that only dissipate energy.
    pub assumed_passive: Vec<LeftOut>,
    pub inputs: Vec<LeftOut>,
    /// Limits of motors and force sensor that the loop never reaches.
    pub unreached: Vec<LoopLimit>,
    /// `None` if the delays are constant or unbounded.
    pub delays: Option<VaryingDelays>,
}

impl LoopVerdict {
    pub fn of(scenario: &Scenario) -> Result<Self, CheckError> {
        Self::with_loop(scenario, linear_loop(scenario)?)
    }

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

    /// At every spring and damper and out of contact, for every order of varying delays; `None` if the analysis leaves
    /// out a part.
    pub fn is_stable(&self) -> Option<bool> {
        self.left_out.is_empty().then_some(self.range.is_stable)
    }

    pub fn sentence(&self) -> String {
        document::verdict::sentence(self)
    }

    /// Continues "the loop is".
    pub fn instability(&self) -> Result<Option<String>, StabilityError> {
        if self.is_stable() != Some(false) {
            return Ok(None);
        }
        let scale = Parameter::ForceScale;
        let limit = largest_stable(&self.settings, scale, Search { tolerance: 1e-6, ..Search::of(scale) })?;
        Ok(Some(document::verdict::instability(self, &limit)))
    }

    pub fn json(&self) -> serde_json::Value {
        json_of(&LoopPart::of(self))
    }
}
