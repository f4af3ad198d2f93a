//! The Z-width: the walls that a hand can touch through the loop, as ranges of stiffness over damping.
//!
//! A wall is a spring `K` and a damper `B` (Colgate and Brown, *ICRA* 1994), in the tissue or virtual: computed by the
//! master from its sampled position,
//!
//! ```text
//! F_k = K x_k + B (x_k - x_{k-1}) / T
//! ```
//! A wall is stable if the motion against it decays with the scenario's arm, and passive if it is stable with every
//! passive hand: for a virtual wall, if and only if `b > K T / 2 + |B|`, with `b` the damping of the master (Colgate
//! and Schenkel, *J. Robot. Syst.* 14, 1997).

use nalgebra::{DMatrix, DVector};

use super::analysis::frequencies_hz;
use super::limit::StabilityTester;
use super::machines::Machines;
use super::side::Side;
use super::{Axis, Hybrid, LinearLoop, Parameter, Ports, StabilityError, is_passive_impedance};
use trocar_base::parallel::try_map;
use trocar_engine::plant::Coupling;
use trocar_engine::teleoperation::ControllerKind;
use trocar_lti::{Complex64, eigenvalues};

const STIFFNESS: (f64, f64) = (0.1, 1e7);
const SCAN: usize = 60;
const BISECTIONS: usize = 40;

/// The maximum stiffness at one damping; all softer walls share the property. `None` if no wall has it, infinite above
/// 1e7.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Walls {
    pub stable_n_per_m: Option<f64>,
    pub passive_n_per_m: Option<f64>,
}

#[derive(Debug, Clone, PartialEq)]
pub struct ZWidth {
    pub damping_n_s_per_m: Vec<f64>,
    /// Passivity is the two-port's, up to a quarter of the sampling rate.
    pub tissue: Vec<Walls>,
    /// `None` if the master's force depends on more than the sampled position: with a force integral, a motor lag, the
    /// coupling as printed, a general master, or a controller other than position-force.
    pub virtual_walls: Option<Vec<Walls>>,
}

fn up_to(holds: impl Fn(f64) -> Result<bool, StabilityError>) -> Result<Option<f64>, StabilityError> {
    if !holds(0.0)? {
        return Ok(None);
    }
    let step = (STIFFNESS.1 / STIFFNESS.0).powf(1.0 / (SCAN - 1) as f64);
    let (mut below, mut above) = (0.0, None);
    for k in 0..SCAN {
        let stiffness = STIFFNESS.0 * step.powi(k as i32);
        if !holds(stiffness)? {
            above = Some(stiffness);
            break;
        }
        below = stiffness;
    }
    let Some(mut above) = above else { return Ok(Some(f64::INFINITY)) };
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (below + above);
        if holds(middle)? { below = middle } else { above = middle }
    }
    Ok(Some(below))
}

fn with_virtual_wall(master: &Side, tick_s: f64, stiffness: f64, damping: f64) -> DMatrix<f64> {
    let n = master.a.nrows();
    let mut position = DVector::zeros(n + 1);
    position[0] = 1.0;
    let mut last = DVector::zeros(n + 1);
    last[n] = 1.0;
    let force = &position * (stiffness + damping / tick_s) - last * (damping / tick_s);
    let mut input = DVector::zeros(n + 1);
    input.rows_mut(0, n).copy_from(&master.now);
    let mut matrix = DMatrix::zeros(n + 1, n + 1);
    matrix.view_mut((0, 0), (n, n)).copy_from(&master.a);
    matrix[(n, 0)] = 1.0;
    matrix + input * force.transpose()
}

impl ZWidth {
    pub fn of(settings: &LinearLoop, axis: &Axis) -> Result<Self, StabilityError> {
        let damping: Vec<f64> = (0..axis.count).map(|index| axis.value(index)).collect();
        let ports = Ports::new(settings)?;
        let hybrids: Vec<(f64, Hybrid)> = frequencies_hz(settings.tick_s)
            .filter_map(|hertz| {
                let omega = std::f64::consts::TAU * hertz;
                ports.at(omega).map(|hybrid| hybrid.map(|hybrid| (omega, hybrid))).transpose()
            })
            .collect::<Result<_, _>>()?;
        let in_tissue = |&damping: &f64| -> Result<Walls, StabilityError> {
            let settings = settings.with(Parameter::Damping, damping);
            let tester = StabilityTester::new(&settings)?;
            let is_passive = |stiffness: f64| {
                hybrids.iter().all(|(omega, hybrid)| {
                    is_passive_impedance(hybrid.transmitted(Complex64::new(damping, -stiffness / omega)))
                })
            };
            Ok(Walls {
                stable_n_per_m: up_to(|stiffness| tester.is_stable(&[(Parameter::Stiffness, stiffness)]))?,
                passive_n_per_m: if hybrids.is_empty() { None } else { up_to(|stiffness| Ok(is_passive(stiffness)))? },
            })
        };
        Ok(Self {
            tissue: try_map(damping.len(), |index| in_tissue(&damping[index]))?,
            virtual_walls: Self::virtual_walls(settings, &damping)?,
            damping_n_s_per_m: damping,
        })
    }

    fn virtual_walls(settings: &LinearLoop, damping: &[f64]) -> Result<Option<Vec<Walls>>, StabilityError> {
        let applies = settings.master.force_integral_gain == 0.0
            && settings.link.controller.kind == ControllerKind::PositionForce
            && settings.actuators.master_lag_s == 0.0
            && settings.master.coupling == Coupling::Physical
            && !settings.master_model.is_general();
        if !applies {
            return Ok(None);
        }
        let master = Side::master(&Machines::new(settings)?, settings)?;
        let of_master = settings.master.damping_n_s_per_m;
        let walls = |&damping: &f64| -> Result<Walls, StabilityError> {
            let is_stable = |stiffness: f64| -> Result<bool, StabilityError> {
                let matrix = with_virtual_wall(&master, settings.tick_s, stiffness, damping);
                Ok(eigenvalues(&matrix)?.iter().all(|value| value.norm() < 1.0))
            };
            let passive = 2.0 * (of_master - damping) / settings.tick_s;
            Ok(Walls { stable_n_per_m: up_to(is_stable)?, passive_n_per_m: (passive > 0.0).then_some(passive) })
        };
        Ok(Some(try_map(damping.len(), |index| walls(&damping[index]))?))
    }
}
