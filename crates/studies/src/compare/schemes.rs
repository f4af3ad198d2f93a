use schemars::JsonSchema;
use serde::Serialize;

use super::Comparison;
use crate::run::{RunError, run};
use trocar_base::parallel::try_map;
use trocar_engine::teleoperation::Scheme;
use trocar_scenario::{Scenario, Source};

pub const IMPEDANCE_FREQUENCIES_HZ: [f64; 2] = [1.0, 5.0];

/// Stiffness of the tissue in the measurement of the felt impedance.
const PROBED_N_PER_M: f64 = 200.0;
const PROBE_M: f64 = 1e-3;
/// Only the second half is evaluated.
const PROBE_S: f64 = 6.0;

/// The results of a scenario with one scheme.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct SchemeRow {
    /// Name of the scheme.
    pub scheme: &'static str,
    /// Largest feedback force in N.
    pub peak_force_n: f64,
    /// Root mean square distance of the slave from the hand in m, scaled to the slave.
    pub position_error_m: f64,
    /// Largest energy in J that hand and needle have received beyond the energy that they have delivered.
    pub generated_j: f64,
    /// Upper bound of this energy in J that the scheme guarantees.
    pub promised_j: Option<f64>,
    /// Felt impedance in N·s/m at 1 Hz and at 5 Hz.
    pub felt_impedance_n_s_per_m: [f64; 2],
    /// Largest overshoot of the slave after a rupture in m.
    pub overshoot_m: Option<f64>,
    /// Ruptures without an alarm.
    pub missed_ruptures: u64,
    /// Distance in m by which the slave is deeper than the hand at the end.
    pub left_behind_m: f64,
}

/// A scenario with every scheme that its architecture allows.
#[derive(Debug, Clone)]
pub struct SchemeStudy {
    pub comparison: Comparison,
    pub rows: Vec<SchemeRow>,
}

impl SchemeStudy {
    pub fn of(source: &Source, settings: &[String]) -> Result<Self, RunError> {
        let load = |scheme: Scheme, more: &[String]| {
            let chosen = [format!("passivity.scheme={}", scheme.word())];
            Scenario::load_changed(source, &[settings, &chosen, more])
        };
        let plain = load(Scheme::None, &[])?;
        let is_allowed =
            |scheme: &Scheme| scheme.carries_positions() || !plain.link.controller.kind.couples_positions();
        let schemes: Vec<Scheme> = Scheme::ALL.iter().copied().filter(is_allowed).collect();
        let named = |scheme: Scheme| -> Result<Scenario, RunError> {
            Ok(load(scheme, &[format!("name={}-{}", plain.name, scheme.word())])?)
        };
        let scenarios = schemes.iter().map(|&scheme| named(scheme)).collect::<Result<Vec<_>, _>>()?;
        let comparison = Comparison::of(scenarios)?;
        let row = |(scheme, of): (&Scheme, &crate::run::Run)| -> Result<SchemeRow, RunError> {
            let impedance = |frequency_hz: f64| felt_impedance(&load(*scheme, &probe(frequency_hz))?, frequency_hz);
            let (trace, scale) = (&of.trace, of.scenario.position_scale());
            let errors = trace.slave_position_m.iter().zip(&trace.master_position_m);
            let squares: f64 = errors.map(|(slave, master)| (slave - scale * master).powi(2)).sum();
            let link = of.metrics.link.as_ref();
            let last = |column: &[f64]| column.last().copied().unwrap_or(0.0);
            let left_behind_m = last(&trace.slave_position_m) - scale * last(&trace.master_position_m);
            Ok(SchemeRow {
                scheme: scheme.word(),
                peak_force_n: trace.feedback_force_n.iter().fold(0.0, |peak, force| force.abs().max(peak)),
                position_error_m: (squares / trace.len().max(1) as f64).sqrt(),
                generated_j: of.metrics.ports.map_or(0.0, |ports| ports.generated_j),
                promised_j: link.and_then(|link| link.promised_energy_j),
                felt_impedance_n_s_per_m: [
                    impedance(IMPEDANCE_FREQUENCIES_HZ[0])?,
                    impedance(IMPEDANCE_FREQUENCIES_HZ[1])?,
                ],
                overshoot_m: of
                    .metrics
                    .ruptures
                    .iter()
                    .filter_map(|rupture| rupture.slave_overshoot_m)
                    .reduce(f64::max),
                missed_ruptures: of.metrics.missed_ruptures,
                left_behind_m: left_behind_m.max(0.0),
            })
        };
        let rows = try_map(schemes.len(), |index| row((&schemes[index], &comparison.runs[index])))?;
        Ok(Self { comparison, rows })
    }
}

fn probe(frequency_hz: f64) -> Vec<String> {
    [
        "operator.kind=sine".into(),
        "operator.start_m=0".into(),
        format!("operator.amplitude_m={PROBE_M}"),
        format!("operator.frequency_hz={frequency_hz}"),
        "perception.reflex=none".into(),
        "operator.tremor_amplitude_m=0".into(),
        "tissue.kind=kelvin-voigt".into(),
        format!("tissue.stiffness_n_per_m={PROBED_N_PER_M}"),
        "tissue.damping_n_s_per_m=0".into(),
        "tissue.contact_m=-0.005".into(),
        "estimator.contact_m=-0.005".into(),
        "augmentation.enabled=false".into(),
        "channel.outages_s=[]".into(),
        format!("simulation.duration_s={PROBE_S}"),
    ]
    .into()
}

fn felt_impedance(scenario: &Scenario, frequency_hz: f64) -> Result<f64, RunError> {
    let run = run(scenario.clone())?;
    let trace = &run.trace;
    let turn = 2.0 * std::f64::consts::PI * frequency_hz;
    let amplitude = |values: &[f64]| {
        let half = trace.len() / 2;
        let terms = trace.time_s[half..].iter().zip(&values[half..]);
        let (cosine, sine) = terms.fold((0.0, 0.0), |(cosine, sine), (time_s, value)| {
            let (s, c) = (turn * time_s).sin_cos();
            (cosine + c * value, sine + s * value)
        });
        cosine.hypot(sine)
    };
    Ok(amplitude(&trace.operator_force_n) / amplitude(&trace.master_velocity_m_per_s))
}
