use super::{ForceLimiter, ReferenceLimiter, SafetySettings};
use crate::lane::Lane;

/// The limits without the states of a rig.
#[derive(Debug, Clone)]
pub struct CommandLimits<L> {
    force: ForceLimiter<L>,
    reference: ReferenceLimiter<L>,
}

impl<L: Lane> CommandLimits<L> {
    /// `None` if the limits do not act in the simulation.
    #[must_use]
    pub fn in_simulation(settings: &SafetySettings, tick_s: f64, start_m: f64) -> Option<Self> {
        settings.acts_in_simulation().then(|| Self {
            force: ForceLimiter::new(settings, tick_s),
            reference: ReferenceLimiter::new(settings, tick_s, L::splat(start_m)),
        })
    }

    /// Begins at present commands (N, m); `None` if the limits act nowhere.
    #[must_use]
    pub fn continuing(settings: &SafetySettings, tick_s: f64, force_n: f64, reference_m: f64) -> Option<Self> {
        settings.acts_on_rigs().then(|| Self {
            force: ForceLimiter::new(settings, tick_s).continuing(L::splat(force_n)),
            reference: ReferenceLimiter::new(settings, tick_s, L::splat(reference_m)),
        })
    }

    /// Limits the master's force.
    #[inline(always)]
    pub fn force_n(&mut self, wanted_n: L) -> L {
        self.force.limit(wanted_n).force_n
    }

    /// Limits the slave's reference.
    #[inline(always)]
    pub fn reference_m(&mut self, wanted_m: L, slave_m: L) -> L {
        self.reference.limit(wanted_m, slave_m).reference_m
    }
}

crate::lane::gather!(CommandLimits { force, reference });
