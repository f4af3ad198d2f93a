//! Bounds of the loop's commands and readings.
//!
//! Let `h` be the response to a unit sample. If the desired position stays within `U` of a point, the output stays
//! within `Σ |h_k| U`; a speed `V` gives `Σ |h_k| V`.

use nalgebra::{DMatrix, DVector};
use trocar_core::settings::KeySource as _;

use super::{ClosedLoop, LinearLoop, StabilityError, TissueRange, TissueSource};
use trocar_scenario::{OperatorSpec, Scenario};

const REMAINS: f64 = 1e-12;
const MAX_SAMPLES: u32 = 200_000;

const MARGIN: f64 = 1.001;

/// Over all hand motions up to the scenario's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// Force in N, rate in N/s.
    pub master_force: [f64; 2],
    pub slave_command: [f64; 2],
    pub tissue_force_n: f64,
}

impl Bounds {
    /// `None` if the loop is unstable, nonlinear, or has machines other than the appendix's.
    pub(super) fn of(scenario: &Scenario) -> Option<Self> {
        let sensor = &scenario.sensor;
        let is_exact = [sensor.force_noise_std_n, sensor.force_bias_n, sensor.force_resolution_n] == [0.0; 3];
        let tissue = TissueRange::of_parameters(scenario)?;
        let is_linear = !scenario.augmentation.enabled && tissue.source == TissueSource::SpringDamper;
        if !(is_exact && is_linear) || scenario.has_general_machine() {
            return None;
        }
        let settings = LinearLoop::of(scenario, tissue).ok()?;
        let surface_m = scenario.values().optional_number("tissue.contact_m")? / settings.link.machines.position_scale;
        let reach = Reach::of(scenario, surface_m);
        let free = LinearLoop { stiffness_n_per_m: 0.0, damping_n_s_per_m: 0.0, ..settings.clone() };
        let of = |settings: &LinearLoop| sums(settings).ok().flatten();
        let (in_contact, out_of_contact) = (of(&settings)?, of(&free)?);
        let sum = |signal: usize| MARGIN * in_contact[signal].max(out_of_contact[signal]);
        let both = |signal: usize| [sum(signal) * reach.distance_m, sum(signal) * reach.speed_m_per_s];
        Some(Self { master_force: both(0), slave_command: both(1), tissue_force_n: sum(2) * reach.distance_m })
    }
}

struct Reach {
    distance_m: f64,
    speed_m_per_s: f64,
}

impl Reach {
    fn of(scenario: &Scenario, surface_m: f64) -> Self {
        let tick_s = scenario.grid.tick_s();
        let from_surface = |position_m: &f64| (position_m - surface_m).abs();
        let reach = match &scenario.operator {
            OperatorSpec::Recording(positions) => Self {
                distance_m: positions.iter().map(from_surface).fold(0.0, f64::max),
                speed_m_per_s: positions.windows(2).map(|pair| (pair[1] - pair[0]).abs() / tick_s).fold(0.0, f64::max),
            },
            OperatorSpec::Ramp { start_m, end_m, speed_m_per_s } => {
                Self { distance_m: from_surface(start_m).max(from_surface(end_m)), speed_m_per_s: speed_m_per_s.abs() }
            }
        };
        let [tremor_m, tremor_m_per_s] = scenario.tremor.largest();
        Self { distance_m: reach.distance_m + tremor_m, speed_m_per_s: reach.speed_m_per_s + tremor_m_per_s }
    }
}

/// `Σ |h_k|`; `None` without decay.
fn sums(settings: &LinearLoop) -> Result<Option<[f64; 3]>, StabilityError> {
    let closed = ClosedLoop::new(settings)?;
    let (a, [now, next], _) = closed.matrix()?;
    let rows = closed.commands(settings)?;
    // The state includes the desired position of the next tick: `x = x' + b_next u`.
    let mut state = &a * &next + now;
    let mut sums = [0.0; 3];
    add(&mut sums, &(&rows * &next));
    let mut largest = state.norm();
    for _ in 0..MAX_SAMPLES {
        add(&mut sums, &(&rows * &state));
        state = &a * state;
        let size = state.norm();
        if !size.is_finite() {
            return Ok(None);
        }
        if size <= REMAINS * largest {
            return Ok(Some(sums));
        }
        largest = largest.max(size);
    }
    Ok(None)
}

fn add(sums: &mut [f64; 3], values: &DVector<f64>) {
    for (sum, value) in sums.iter_mut().zip(values.iter()) {
        *sum += value.abs();
    }
}

impl ClosedLoop {
    /// Returns rows over the states of [`ClosedLoop::matrix`].
    fn commands(&self, settings: &LinearLoop) -> Result<DMatrix<f64>, StabilityError> {
        let (_, _, at_master) = self.open()?;
        let (n, of_master) = (at_master.len(), self.master.a.nrows());
        let mut master = at_master;
        for (k, local) in self.master.local.iter().enumerate() {
            master[k] += local;
        }
        let integral_gain = settings.master.force_integral_gain;
        if integral_gain != 0.0 {
            master[4] += integral_gain;
        }
        let mut tissue = DVector::zeros(n);
        (tissue[of_master], tissue[of_master + 1]) = (settings.stiffness_n_per_m, settings.damping_n_s_per_m);
        let mut reference = self.arrives_at_slave();
        for (k, local) in self.slave.local.iter().enumerate() {
            reference[of_master + k] += local;
        }
        reference -= &tissue * settings.link.machines.compliance_m_per_n;
        let [to_reference, to_position, to_velocity] = settings.slave.control();
        let mut slave = reference * to_reference;
        slave[of_master] += to_position;
        slave[of_master + 1] += to_velocity;
        Ok(DMatrix::from_rows(&[master.transpose(), slave.transpose(), tissue.transpose()]))
    }
}
