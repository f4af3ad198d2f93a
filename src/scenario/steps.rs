//! The machines' steps over a tick, computed once for cases that share their machines.

use std::cell::RefCell;

use crate::plant::{
    ArmParameters, ControlTiming, MasterParameters, MasterStep, PlantError, SlaveParameters, SlaveStep,
};

/// What the steps depend on.
#[derive(Clone, PartialEq)]
struct Machines {
    master: MasterParameters,
    arm: ArmParameters,
    slave: SlaveParameters,
    timing: ControlTiming,
    tick_s: f64,
}

thread_local! {
    /// The last ones: in a sweep over anything else, a matrix exponential per case would cost more than its ticks.
    static LAST: RefCell<Option<(Machines, MasterStep, SlaveStep)>> = const { RefCell::new(None) };
}

/// Both machines' steps over a tick of `tick_s` (s).
///
/// # Errors
/// [`PlantError`] as [`MasterStep::new`] and [`SlaveStep::new`].
pub(super) fn steps(
    (master, arm, slave): (&MasterParameters, &ArmParameters, &SlaveParameters),
    timing: ControlTiming,
    tick_s: f64,
) -> Result<(MasterStep, SlaveStep), PlantError> {
    let machines = Machines { master: *master, arm: *arm, slave: slave.clone(), timing, tick_s };
    let known = LAST.with_borrow(|last| match last {
        Some((of, master, slave)) if *of == machines => Some((master.clone(), slave.clone())),
        _ => None,
    });
    if let Some(known) = known {
        return Ok(known);
    }
    let steps = (MasterStep::new(master, arm, timing, tick_s)?, SlaveStep::new(slave, timing, tick_s)?);
    LAST.set(Some((machines, steps.0.clone(), steps.1.clone())));
    Ok(steps)
}
