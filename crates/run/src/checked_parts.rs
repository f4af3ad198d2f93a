//! A number that is not finite in a user-defined part's results ends the run.

use trocar_core::time::TickGrid;
use trocar_engine::engine::{InvalidPart, Observer, Signals};

#[derive(Debug, Clone)]
pub(super) struct CheckedParts {
    user_defined: Vec<&'static str>,
    grid: TickGrid,
    looks: bool,
    found: Option<InvalidPart>,
}

impl CheckedParts {
    pub(super) fn new(user_defined: Vec<&'static str>, grid: TickGrid) -> Self {
        Self { looks: !user_defined.is_empty(), user_defined, grid, found: None }
    }

    pub(super) fn outcome(&self) -> Result<(), InvalidPart> {
        self.found.clone().map_or(Ok(()), Err)
    }

    pub(super) fn user_defined(&self) -> &[&'static str] {
        &self.user_defined
    }

    #[cold]
    fn conclude(&mut self, tick: u64, roles: &[&'static str]) {
        self.looks = false;
        let found: Vec<&str> = roles.iter().copied().filter(|role| self.user_defined.contains(role)).collect();
        // Non-finite numbers of a built-in part mean that the run diverges.
        if !found.is_empty() {
            self.found = Some(InvalidPart { roles: found.join(" or "), tick, time_s: self.grid.time_s(tick) });
        }
    }
}

/// Of the first non-finite signal, in the order of a tick.
fn first_invalid(s: &Signals<f64>) -> Option<&'static [&'static str]> {
    let signals: [(&'static [&'static str], [f64; 3]); 6] = [
        (&["operator"], [s.desired_position_m, s.intended_position_m, 0.0]),
        (&["tissue"], [s.tissue_force_n, 0.0, 0.0]),
        (&["estimator"], [s.stiffness_n_per_m, s.damping_n_s_per_m, s.residual_n]),
        (&["detector", "distance"], [s.distance, s.decision, 0.0]),
        (&["force law", "architecture", "scheme"], [s.commanded_force_n, s.feedback_force_n, 0.0]),
        (&["motion law", "architecture", "scheme"], [s.slave_reference_m, 0.0, 0.0]),
    ];
    let is_invalid = |values: &[f64; 3]| !values.iter().all(|value| value.is_finite());
    signals.into_iter().find(|(_, values)| is_invalid(values)).map(|(roles, _)| roles)
}

impl Observer<f64> for CheckedParts {
    #[inline(always)]
    fn observe(&mut self, signals: &Signals<f64>) {
        if self.looks
            && let Some(roles) = first_invalid(signals)
        {
            self.conclude(signals.tick, roles);
        }
    }

    #[inline(always)]
    fn is_done(&self) -> bool {
        self.found.is_some()
    }
}
