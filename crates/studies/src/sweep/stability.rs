use std::cell::OnceCell;

use crate::stability_check::{Verdict, linear_loop, simulate};
use trocar_metrics::metrics;
use trocar_scenario::Scenario;
use trocar_stability::{
    Analysis, ClosedLoop, LinearLoop, Margins, Mode, Peaks, Switching, SwitchingSettings, VaryingDelays, left_out,
};

/// Computes each part at its first use.
#[derive(Debug)]
pub struct LoopOfCase<'a> {
    scenario: &'a Scenario,
    settings: OnceCell<Option<LinearLoop>>,
    is_stable: OnceCell<Option<bool>>,
    closed: OnceCell<Option<ClosedLoop>>,
    mode: OnceCell<Option<Mode>>,
    margins: OnceCell<Option<Margins>>,
    ports: OnceCell<Option<(bool, bool)>>,
    leaves_out: OnceCell<bool>,
}

impl<'a> LoopOfCase<'a> {
    pub fn new(scenario: &'a Scenario) -> Self {
        Self {
            scenario,
            settings: OnceCell::new(),
            is_stable: OnceCell::new(),
            closed: OnceCell::new(),
            mode: OnceCell::new(),
            margins: OnceCell::new(),
            ports: OnceCell::new(),
            leaves_out: OnceCell::new(),
        }
    }

    fn settings(&self) -> Option<&LinearLoop> {
        self.settings.get_or_init(|| linear_loop(self.scenario).ok()).as_ref()
    }

    fn closed(&self) -> Option<&ClosedLoop> {
        self.closed.get_or_init(|| ClosedLoop::new(self.settings()?).ok()).as_ref()
    }

    fn is_stable(&self) -> Option<bool> {
        *self.is_stable.get_or_init(|| Some(self.settings()?.in_range().ok()?.is_stable))
    }

    fn mode(&self) -> Option<Mode> {
        *self.mode.get_or_init(|| self.closed()?.dominant_mode().ok())
    }

    fn margins(&self) -> Option<Margins> {
        *self.margins.get_or_init(|| self.closed()?.margins().ok())
    }

    fn ports(&self) -> Option<(bool, bool)> {
        *self.ports.get_or_init(|| Analysis::port_verdicts(self.settings()?).ok().flatten())
    }

    fn simulated(&self) -> Option<f64> {
        match simulate(self.scenario, self.settings()?).ok()? {
            Verdict::Decays => Some(1.0),
            Verdict::Grows => Some(0.0),
            Verdict::Undecided => None,
        }
    }

    fn leaves_out(&self) -> bool {
        *self.leaves_out.get_or_init(|| {
            let delays = self.settings().and_then(|settings| VaryingDelays::of(self.scenario, settings).ok().flatten());
            !left_out(self.scenario, delays.as_ref()).is_empty()
        })
    }

    /// `None` if the analysis leaves out a part of the scenario.
    fn events(&self) -> Option<SwitchingSettings> {
        if self.leaves_out() {
            return None;
        }
        let settings = self.settings()?;
        SwitchingSettings::of(self.scenario, settings.clone(), settings.tissue.sector_n_per_m()).ok()
    }

    fn is_decay_certified(&self) -> Option<bool> {
        Peaks::exist(&self.events()?, None).ok()
    }

    fn certified_dwell_s(&self) -> Option<f64> {
        let switching = self.events()?;
        let settings = self.settings()?;
        Some(Switching::certified_dwell(&switching).ok()?? as f64 * settings.tick_s)
    }
}

fn as_number(holds: bool) -> f64 {
    f64::from(u8::from(holds))
}

metrics! {
    impl Loop for LoopOfCase<'_> {
        /// Magnitude of the largest pole of the loop, per tick; motions decay if it is below 1.
        spectral_radius = "spectral radius", Number, Lower => |l| Some(l.mode()?.spectral_radius);
        /// 1 if the loop is stable at every spring and damper of its tissue and out of contact, by its matrices, else 0; undefined if the matrices leave out a part of the scenario.
        is_stable = "is stable", Count, Higher => |l| {
            let stable = l.is_stable()?;
            (!l.leaves_out()).then(|| as_number(stable))
        };
        /// Worst stiffness of the tissue in N/m, at which spectral radius, mode and margins are computed.
        stiffness_n_per_m = "worst stiffness", NewtonPerMetre, Neither => |l| Some(l.settings()?.stiffness_n_per_m);
        /// 1 if a small motion decays in a run of the engine, 0 if it grows; undefined if it does neither.
        is_stable_simulated = "is stable, simulated", Count, Higher => |l| l.simulated();
        /// Damping ratio of the dominant mode; below 0 the mode grows.
        damping_ratio = "damping ratio", Number, Higher => |l| Some(l.mode()?.damping_ratio);
        /// Frequency of the dominant mode in Hz.
        frequency_hz = "frequency", Number, Neither => |l| Some(l.mode()?.frequency_hz);
        /// Growth rate of the dominant mode in 1/s; below 0 the mode decays.
        growth_per_s = "growth", Number, Lower => |l| Some(l.mode()?.growth_per_s);
        /// Factor on the loop gain at which the loop becomes unstable; infinite without such a factor, undefined for an unstable loop.
        gain_margin = "gain margin", Number, Higher => |l| l.margins()?.gain;
        /// Additional phase lag in rad at which the loop becomes unstable; infinite without such a lag, undefined for an unstable loop.
        phase_margin_rad = "phase margin", Number, Higher => |l| l.margins()?.phase_rad;
        /// Additional delay at which the loop becomes unstable; infinite without such a delay, undefined for an unstable loop.
        delay_margin_s = "delay margin", Second, Higher => |l| l.margins()?.delay_s;
        /// 1 if the loop is stable with any passive hand and any passive tissue, else 0.
        is_absolutely_stable = "is absolutely stable", Count, Higher => |l| Some(as_number(l.ports()?.0));
        /// 1 if the teleoperator is passive, else 0.
        is_passive = "is passive", Count, Higher => |l| Some(as_number(l.ports()?.1));
        /// Minimum time of teleoperation between events for which the decay of motions is certified; undefined if the analysis leaves out a part of the scenario.
        certified_dwell_s = "certified dwell", Second, Lower => |l| l.certified_dwell_s();
        /// 1 if the certificate states that every motion but the one by the sensor's noise decays under any sequence of events that keeps the enforced times, else 0; undefined if the analysis leaves out a part of the scenario.
        is_decay_certified = "decay certified", Count, Higher => |l| l.is_decay_certified().map(as_number);
    }
}
