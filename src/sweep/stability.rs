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

/// A column of a case's loop: its name, its value.
pub(super) type OfLoop = (&'static str, crate::compare::Unit, fn(&LoopOfCase<'_>) -> Option<f64>);

/// The columns, named `stability_…`; verdicts are 1 and 0.
pub(super) const OF_LOOP: &[OfLoop] = {
    use crate::compare::Unit::{Count, Number, Second};
    &[
        ("stability_spectral_radius", Number, |l| Some(l.mode()?.spectral_radius)),
        ("stability_is_stable", Count, |l| Some(yes(l.closed()?.is_stable().ok()?))),
        ("stability_is_stable_simulated", Count, |l| l.simulated()),
        ("stability_damping_ratio", Number, |l| Some(l.mode()?.damping_ratio)),
        ("stability_frequency_hz", Number, |l| Some(l.mode()?.frequency_hz)),
        ("stability_growth_per_s", Number, |l| Some(l.mode()?.growth_per_s)),
        ("stability_gain_margin", Number, |l| l.margins()?.gain),
        ("stability_phase_margin_rad", Number, |l| l.margins()?.phase_rad),
        ("stability_delay_margin_s", Second, |l| l.margins()?.delay_s),
        ("stability_is_absolutely_stable", Count, |l| Some(yes(l.ports()?.0))),
        ("stability_is_passive", Count, |l| Some(yes(l.ports()?.1))),
        ("stability_certified_dwell_s", Second, |l| l.certified_dwell_s()),
    ]
};
