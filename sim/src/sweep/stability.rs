//! What can be said of a case's loop without running it, and what small motions come to when it is run.

use std::cell::OnceCell;

use crate::scenario::Scenario;
use crate::stability::{Analysis, ClosedLoop, LoopSettings, Margins, Mode, Switching, SwitchingSettings};
use crate::stability_check::{Verdict, simulate};

/// The tissue between whose ends events are certified, in N/m, as `trocar stability` has it where nothing is said.
const TISSUE_N_PER_M: (f64, f64) = (50.0, 600.0);

/// A case's loop; each part is computed when it is first asked for.
#[derive(Debug)]
pub struct LoopOfCase<'a> {
    scenario: &'a Scenario,
    settings: &'a LoopSettings,
    closed: OnceCell<Option<ClosedLoop>>,
    mode: OnceCell<Option<Mode>>,
    margins: OnceCell<Option<Margins>>,
    ports: OnceCell<Option<(bool, bool)>>,
}

impl<'a> LoopOfCase<'a> {
    /// The loop of a case's scenario.
    #[must_use]
    pub fn new(scenario: &'a Scenario, settings: &'a LoopSettings) -> Self {
        let (closed, mode) = (OnceCell::new(), OnceCell::new());
        Self { scenario, settings, closed, mode, margins: OnceCell::new(), ports: OnceCell::new() }
    }

    fn closed(&self) -> Option<&ClosedLoop> {
        self.closed.get_or_init(|| ClosedLoop::new(self.settings).ok()).as_ref()
    }

    fn mode(&self) -> Option<Mode> {
        *self.mode.get_or_init(|| self.closed()?.dominant_mode().ok())
    }

    fn margins(&self) -> Option<Margins> {
        *self.margins.get_or_init(|| self.closed()?.margins().ok())
    }

    fn ports(&self) -> Option<(bool, bool)> {
        *self.ports.get_or_init(|| Analysis::port_verdicts(self.settings).ok().flatten())
    }

    fn simulated(&self) -> Option<f64> {
        match simulate(self.scenario, self.settings).ok()? {
            Verdict::Decays => Some(1.0),
            Verdict::Grows => Some(0.0),
            Verdict::Undecided => None,
        }
    }

    fn certified_dwell_s(&self) -> Option<f64> {
        let settings = SwitchingSettings::with_loop(self.scenario, self.settings.clone(), TISSUE_N_PER_M).ok()?;
        Some(Switching::certified_dwell(&settings).ok()?? as f64 * self.settings.tick_s)
    }
}

/// A verdict as a number.
fn yes(holds: bool) -> f64 {
    f64::from(u8::from(holds))
}

/// A column of a case's loop: its name, its unit, what it means, its value.
pub(super) type OfLoop = (&'static str, crate::compare::Unit, &'static str, fn(&LoopOfCase<'_>) -> Option<f64>);

/// The columns, named `stability_…`; verdicts are 1 and 0.
pub(super) const OF_LOOP: &[OfLoop] = {
    use crate::compare::Unit::{Count, Number, Second};
    &[
        (
            "stability_spectral_radius",
            Number,
            "The magnitude of the loop's slowest pole per tick; below 1 motions die out.",
            |l| Some(l.mode()?.spectral_radius),
        ),
        (
            "stability_is_stable",
            Count,
            "Whether the loop is stable in permanent contact, by its matrices: 1 or 0.",
            |l| Some(yes(l.closed()?.is_stable().ok()?)),
        ),
        (
            "stability_is_stable_simulated",
            Count,
            "Whether a small motion dies out in a run of the engine: 1 or 0, none where it does neither.",
            |l| l.simulated(),
        ),
        ("stability_damping_ratio", Number, "The damping ratio of the dominant mode; below 0 it grows.", |l| {
            Some(l.mode()?.damping_ratio)
        }),
        ("stability_frequency_hz", Number, "The frequency in Hz at which the dominant mode swings.", |l| {
            Some(l.mode()?.frequency_hz)
        }),
        (
            "stability_growth_per_s",
            Number,
            "The rate in 1/s at which the dominant mode grows; below 0 it dies out.",
            |l| Some(l.mode()?.growth_per_s),
        ),
        (
            "stability_gain_margin",
            Number,
            "The factor by which the loop's gain may change before it is no longer stable.",
            |l| l.margins()?.gain,
        ),
        (
            "stability_phase_margin_rad",
            Number,
            "The phase in rad that the loop may lose before it is no longer stable.",
            |l| l.margins()?.phase_rad,
        ),
        (
            "stability_delay_margin_s",
            Second,
            "The delay around the loop that may be added before it is no longer stable.",
            |l| l.margins()?.delay_s,
        ),
        (
            "stability_is_absolutely_stable",
            Count,
            "Whether it is stable between any passive hand and any passive tissue: 1 or 0.",
            |l| Some(yes(l.ports()?.0)),
        ),
        ("stability_is_passive", Count, "Whether the teleoperator gives no power of its own: 1 or 0.", |l| {
            Some(yes(l.ports()?.1))
        }),
        (
            "stability_certified_dwell_s",
            Second,
            "The teleoperation between events from which on motions certainly die out, whatever the events.",
            |l| l.certified_dwell_s(),
        ),
    ]
};
