use std::borrow::Cow;

use super::RunReport;
use trocar_core::augmentation::HoldSettings;
use trocar_document::figure::Shade;
use trocar_figures::{EnergyView, EstimationView, RunView};

/// Only a freeze is called frozen.
pub fn event_shade(hold: HoldSettings) -> Shade {
    match hold {
        HoldSettings::Frozen => Shade::Frozen,
        HoldSettings::SpeedLimit(_) | HoldSettings::ForbiddenRegion(_) | HoldSettings::Yielding(_) => Shade::Held,
        HoldSettings::Following => Shade::Event,
    }
}

impl<'a> RunReport<'a> {
    fn ruptures_s(self) -> Cow<'static, [f64]> {
        self.run.metrics.ruptures.iter().map(|rupture| rupture.time_s).collect()
    }

    fn alarms_s(self) -> Cow<'static, [f64]> {
        self.run.metrics.alarms.iter().map(|alarm| alarm.time_s).collect()
    }

    pub fn view(self) -> RunView<'a> {
        let trace = &self.run.trace;
        RunView {
            name: &self.run.scenario.name,
            is_augmented: self.run.scenario.augmentation.enabled,
            time_s: &trace.time_s,
            master_position_m: &trace.master_position_m,
            slave_position_m: &trace.slave_position_m,
            operator_force_n: &trace.operator_force_n,
            tissue_force_n: &trace.tissue_force_n,
            feedback_force_n: &trace.feedback_force_n,
            mode: &trace.mode,
            event: event_shade(self.run.scenario.augmentation.hold),
            rupture_times_s: self.ruptures_s(),
            alarm_times_s: self.alarms_s(),
        }
    }

    pub fn estimation(self) -> EstimationView<'a> {
        let trace = &self.run.trace;
        let trust = trace.trust();
        EstimationView {
            name: &self.run.scenario.name,
            time_s: &trace.time_s,
            measured_force_n: &trace.measured_force_n,
            residual_n: &trace.residual_n,
            stiffness_n_per_m: &trace.stiffness_n_per_m,
            damping_n_s_per_m: &trace.damping_n_s_per_m,
            standard_errors: trust
                .map(|trust| [trust.stiffness_std_n_per_m.into(), trust.damping_std_n_s_per_m.into()]),
            extra_parameter: trace.extra_parameter.as_ref().map(|(name, column)| (*name, column.as_slice())),
            decision: &trace.decision,
            threshold: self.run.scenario.detector.cusum.threshold,
            decision_unit: self.run.scenario.detector.distance.kind.unit(),
            rupture_times_s: self.ruptures_s(),
            alarm_times_s: self.alarms_s(),
        }
    }

    pub fn energies(self) -> EnergyView<'a> {
        let trace = &self.run.trace;
        EnergyView {
            name: &self.run.scenario.name,
            time_s: &trace.time_s,
            hand_energy_j: &trace.hand_energy_j,
            master_energy_j: &trace.master_energy_j,
            reference_energy_j: &trace.reference_energy_j,
            needle_energy_j: &trace.needle_energy_j,
            energy_scale: self.run.scenario.link.machines.energy_scale(),
            promised_energy_j: self.run.metrics.link.as_ref().and_then(|link| link.promised_energy_j),
        }
    }
}
