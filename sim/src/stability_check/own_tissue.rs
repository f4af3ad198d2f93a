//! The stiffness of the tissue in a scenario's own run.

use trocar_core::settings::Source as _;

use crate::engine::{Observer, Signals};
use crate::run::{RunError, observe};
use crate::scenario::Scenario;
use crate::stability::{LoopSettings, TissueKind};
use crate::time::nearest_ticks;

/// Minimum depth in m at which a secant is taken, and advance in m over which a tangent is.
const MIN_DEPTH_M: f64 = 5e-4;
const TANGENT_M: f64 = 5e-5;

/// Time after a rupture in s that is left out: the force of the ruptured layer falls.
const RUPTURE_S: f64 = 0.1;

/// Ranges of stiffness in N/m that the tissue shows while the needle advances.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TissueRange {
    /// Of the force divided by the depth; `None` if the needle did not advance deep enough.
    pub secant: Option<(f64, f64)>,
    /// Of the change of the force divided by the advance, over 0.05 mm, without the 0.1 s after each rupture.
    pub tangent: Option<(f64, f64)>,
}

impl TissueRange {
    /// The smallest range with all secants and tangents.
    #[must_use]
    pub fn sector(&self) -> Option<(f64, f64)> {
        let ranges = || self.secant.into_iter().chain(self.tangent);
        let low = ranges().map(|(low, _)| low).reduce(f64::min)?;
        Some((low, ranges().map(|(_, high)| high).fold(low, f64::max)))
    }

    /// The range in a scenario's run.
    ///
    /// # Errors
    /// [`RunError`].
    pub fn of(scenario: &Scenario) -> Result<Self, RunError> {
        if TissueKind::of(scenario) == TissueKind::SpringDamper {
            let stiffness_n_per_m = LoopSettings::of(scenario).stiffness_n_per_m;
            let stiffness = Some((stiffness_n_per_m, stiffness_n_per_m));
            return Ok(Self { secant: stiffness, tangent: stiffness });
        }
        let mut observer = TissueObserver {
            contact_m: surface_m(scenario),
            from: None,
            until: 0,
            rupture_ticks: nearest_ticks(RUPTURE_S, scenario.grid.tick_s()),
            range: Self { secant: None, tangent: None },
        };
        observe(scenario, &mut observer)?;
        Ok(observer.range)
    }
}

/// Position of the tissue's surface in m: that of a model, or for a recording that of the estimator.
fn surface_m(scenario: &Scenario) -> f64 {
    let of_model = scenario.tissue.settings().and_then(|_| scenario.values().optional_number("tissue.contact_m"));
    of_model.unwrap_or(scenario.contact_m)
}

struct TissueObserver {
    contact_m: f64,
    /// Depth and force at which the present tangent begins.
    from: Option<(f64, f64)>,
    /// The first tick after the last rupture that counts.
    until: u64,
    rupture_ticks: u64,
    range: TissueRange,
}

fn extend(range: &mut Option<(f64, f64)>, value: f64) {
    let (low, high) = range.unwrap_or((value, value));
    *range = Some((low.min(value), high.max(value)));
}

impl Observer<f64> for TissueObserver {
    fn observe(&mut self, s: &Signals<f64>) {
        let (depth_m, force_n) = (s.slave_position_m - self.contact_m, s.tissue_force_n);
        if s.ruptured {
            self.until = s.tick + self.rupture_ticks;
        }
        if s.slave_velocity_m_per_s <= 0.0 || depth_m <= 0.0 || s.tick < self.until {
            self.from = None;
            return;
        }
        if depth_m >= MIN_DEPTH_M {
            extend(&mut self.range.secant, force_n / depth_m);
        }
        let (from_m, from_n) = *self.from.get_or_insert((depth_m, force_n));
        if depth_m - from_m >= TANGENT_M {
            extend(&mut self.range.tangent, (force_n - from_n) / (depth_m - from_m));
            self.from = Some((depth_m, force_n));
        }
    }
}
