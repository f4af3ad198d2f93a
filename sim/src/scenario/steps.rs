//! Both plants' steps over whole ticks, which take longer to make than some hundred ticks to run: made once for all scenarios
//! that are copies of one another but for other parts.

use std::borrow::Cow;

use super::resolve::Scenario;
use crate::plant::{
    ArmParameters, ControlTiming, MasterParameters, MasterStep, PlantError, SlaveParameters, SlaveStep,
};

/// The steps, and what they were made of.
#[derive(Debug, Clone)]
pub(super) struct Steps {
    master_parameters: (MasterParameters, ArmParameters),
    slave_parameters: SlaveParameters,
    timing: ControlTiming,
    tick_s: f64,
    master: MasterStep,
    slave: SlaveStep,
}

impl Steps {
    fn of(scenario: &Scenario) -> Result<Self, PlantError> {
        let (timing, tick_s) = (scenario.timing, scenario.grid.tick_s());
        Ok(Self {
            master_parameters: (scenario.master, scenario.arm),
            slave_parameters: scenario.slave.clone(),
            timing,
            tick_s,
            master: MasterStep::new(&scenario.master, &scenario.arm, timing, tick_s)?,
            slave: SlaveStep::new(&scenario.slave, timing, tick_s)?,
        })
    }

    /// Whether the scenario is still what they were made of: its fields are open to change.
    fn are_of(&self, scenario: &Scenario) -> bool {
        self.master_parameters == (scenario.master, scenario.arm)
            && self.slave_parameters == scenario.slave
            && self.timing == scenario.timing
            && self.tick_s == scenario.grid.tick_s()
    }
}

impl Scenario {
    /// The steps of master and slave over a whole tick.
    pub(super) fn whole_steps(&self) -> Result<(Cow<'_, MasterStep>, Cow<'_, SlaveStep>), PlantError> {
        if let Some(kept) = self.steps.get().filter(|kept| kept.are_of(self)) {
            return Ok((Cow::Borrowed(&kept.master), Cow::Borrowed(&kept.slave)));
        }
        let made = Steps::of(self)?;
        let steps = (Cow::Owned(made.master.clone()), Cow::Owned(made.slave.clone()));
        // Another thread may have been first, with the same numbers; or they belong to a copy that was changed.
        let _ = self.steps.set(made);
        Ok(steps)
    }
}

#[cfg(test)]
mod tests {
    use super::super::Source;
    use super::*;

    #[test]
    fn a_copy_that_was_changed_has_its_own_steps() {
        let base = Scenario::load(&Source::Builtin("01_augmented.toml".into()), &[]).expect("good");
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
        let (master, _) = base.whole_steps().expect("built");
        assert!(matches!(master, Cow::Borrowed(_)), "made again");
    }
}
