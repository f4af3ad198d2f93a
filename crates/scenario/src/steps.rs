//! Computing the steps takes longer than running some hundred ticks, so copies of a scenario share them.

use std::sync::Arc;

use super::scenario::Scenario;
use trocar_engine::plant::{
    ArmParameters, ControlTiming, MasterParameters, MasterStep, PlantError, SlaveParameters, SlaveStep,
};

#[derive(Debug, Clone)]
pub(super) struct Steps {
    master_parameters: (MasterParameters, ArmParameters),
    slave_parameters: SlaveParameters,
    timing: ControlTiming,
    tick_s: f64,
    pub(super) master: MasterStep,
    pub(super) slave: SlaveStep,
}

pub(super) type PlantParameters<'a> = (&'a MasterParameters, &'a ArmParameters, &'a SlaveParameters);

impl Steps {
    pub(super) fn new(
        (master, arm, slave): PlantParameters<'_>,
        timing: ControlTiming,
        tick_s: f64,
    ) -> Result<Self, PlantError> {
        Ok(Self {
            master_parameters: (*master, *arm),
            slave_parameters: slave.clone(),
            timing,
            tick_s,
            master: MasterStep::new(master, arm, timing, tick_s)?,
            // Schemes that use this step do not support a general slave.
            slave: if slave.is_general() {
                SlaveStep::new(&SlaveParameters::default(), timing, tick_s)?
            } else {
                SlaveStep::new(slave, timing, tick_s)?
            },
        })
    }

    /// True if the steps match these parameters: a scenario's public fields may have changed.
    pub(super) fn are_of(&self, (master, arm, slave): PlantParameters<'_>, timing: ControlTiming, tick_s: f64) -> bool {
        self.master_parameters == (*master, *arm)
            && self.slave_parameters == *slave
            && self.timing == timing
            && self.tick_s == tick_s
    }
}

impl Scenario {
    /// Uses the steps of the plants that another scenario has computed, if its machines are the same.
    pub fn share_steps(&mut self, other: &Self) {
        let parameters = (&self.master, &self.arm, &self.slave);
        let fits = |stored: &Steps| stored.are_of(parameters, self.timing, self.grid.tick_s());
        self.steps = if other.steps.get().is_some_and(fits) { Arc::clone(&other.steps) } else { Arc::default() };
    }

    /// Computes the steps of the plants again at their next use, after a change of the machines. Copies made before then
    /// share them.
    pub fn renew_steps(&mut self) {
        self.steps = Arc::default();
    }
}

#[cfg(test)]
mod tests {
    use std::borrow::Cow;

    use super::super::{Scenario, Source};

    #[test]
    fn a_changed_copy_has_different_steps() {
        let base = Scenario::load(&Source::parse("layers/skin-augmented"), &[]).expect("good");
        let steps = |scenario: &Scenario| {
            let (master, slave) = scenario.whole_steps().expect("built");
            (master.into_owned(), slave.into_owned())
        };
        let first = steps(&base);
        let mut other = base.clone();
        other.master.mass_kg *= 2.0;
        assert_ne!(steps(&other).0, first.0);
        assert_eq!(steps(&other).1, first.1);
        other = base.clone();
        other.slave.velocity_gain += 1.0;
        assert_ne!(steps(&other).1, first.1);
        assert_eq!(steps(&base), first);
        let is_borrowed = |scenario: &Scenario| matches!(scenario.whole_steps().expect("built").0, Cow::Borrowed(_));
        assert!(is_borrowed(&base), "computed again");
        // Steps are shared between the same machines only.
        other.share_steps(&base);
        assert!(!is_borrowed(&other));
        assert!(is_borrowed(&other.clone()));
        let mut same = base.clone();
        same.renew_steps();
        same.share_steps(&base);
        assert!(is_borrowed(&same));
    }
}
