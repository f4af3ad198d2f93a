use nalgebra::DMatrix;

use super::{PlantError, SlaveParameters, on};
use trocar_lti::{Continuous, StateSpace, TransferFunction, outputs_first, realise};

pub const MAX_MACHINE_STATES: usize = 8;

/// Relative `c B` below which a force changes the velocity gradually.
const NO_JUMP: f64 = 1e-9;

/// Relative real part of a stable pole: several poles at 0 have an error of about the root of the rounding.
const MARGINAL: f64 = 1e-6;

trocar_core::choice! {
    /// Model of the slave without its controller.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum SlaveModel at "slave.model" = Appendix {
        "appendix" => Appendix,
        "mass-damper" => MassDamper,
        "transfer-function" => TransferFunction,
        "state-space" => StateSpace,
    }
}

#[derive(Debug, Clone, Copy)]
pub(super) enum Model<'a> {
    Function { numerator: &'a [f64], denominator: &'a [f64] },
    MassDamper { mass_kg: f64, damping_n_s_per_m: f64 },
    Matrices { a: &'a [f64], b: &'a [f64], c: &'a [f64] },
}

impl Model<'_> {
    fn key(self) -> &'static str {
        match self {
            Self::Function { .. } => "denominator",
            Self::MassDamper { .. } => "mass_kg",
            Self::Matrices { .. } => "a",
        }
    }
}

/// From motor and external force to the first states, position and velocity.
#[derive(Debug, Clone, PartialEq)]
pub struct Machine {
    system: StateSpace<Continuous>,
}

impl Machine {
    /// Without Coulomb friction; the external force has no effect in the appendix' model.
    pub fn of(slave: &SlaveParameters) -> Result<Self, PlantError> {
        slave.validate()?;
        let model = match slave.model {
            SlaveModel::Appendix | SlaveModel::TransferFunction => {
                Model::Function { numerator: &slave.numerator, denominator: &slave.denominator }
            }
            SlaveModel::MassDamper => {
                Model::MassDamper { mass_kg: slave.mass_kg, damping_n_s_per_m: slave.damping_n_s_per_m }
            }
            SlaveModel::StateSpace => Model::Matrices { a: &slave.a, b: &slave.b, c: &slave.c },
        };
        let Self { mut system } = Self::described("slave", model)?;
        if slave.model == SlaveModel::Appendix {
            let mut b = system.b().clone();
            b.column_mut(1).fill(0.0);
            system = StateSpace::continuous(system.a().clone(), b, system.c().clone(), system.d().clone())
                .map_err(on("slave"))?;
        }
        Ok(Self { system })
    }

    pub(super) fn described(side: &'static str, model: Model<'_>) -> Result<Self, PlantError> {
        let system = match model {
            Model::Function { numerator, denominator } => of_function(side, numerator, denominator)?,
            Model::MassDamper { mass_kg, damping_n_s_per_m } => {
                of_function(side, &[1.0], &[mass_kg, damping_n_s_per_m, 0.0])?
            }
            Model::Matrices { a, b, c } => of_matrices(side, a, b, c)?,
        };
        let key = model.key();
        if system.states() > MAX_MACHINE_STATES {
            return Err(PlantError::TooManyStates { side, key, states: system.states() });
        }
        let poles = system.poles().map_err(on(side))?;
        let largest = poles.iter().map(|pole| pole.norm()).fold(1.0, f64::max);
        if let Some(pole) = poles.iter().find(|pole| pole.re > MARGINAL * largest) {
            return Err(PlantError::Unstable { side, key, re: pole.re, im: pole.im.abs() });
        }
        let velocity = system.c() * system.a();
        let jump = system.c() * system.b();
        if jump.amax() > NO_JUMP * system.c().norm() * system.b().norm() {
            let key = if let Model::Matrices { .. } = model { "b" } else { "numerator" };
            return Err(PlantError::VelocityJumps { side, key });
        }
        let outputs = DMatrix::from_rows(&[system.c().row(0), velocity.row(0)]);
        let direct = DMatrix::zeros(2, system.inputs());
        let system = StateSpace::continuous(system.a().clone(), system.b().clone(), outputs, direct);
        let system = system.and_then(|system| outputs_first(&system, &[0, 1])).map_err(on(side))?;
        Ok(Self { system: balanced(&system, 2).map_err(on(side))? })
    }

    pub fn system(&self) -> &StateSpace<Continuous> {
        &self.system
    }
}

fn of_function(
    side: &'static str,
    numerator: &[f64],
    denominator: &[f64],
) -> Result<StateSpace<Continuous>, PlantError> {
    let leading = numerator.iter().position(|&value| value != 0.0).unwrap_or(numerator.len());
    let degrees = ((numerator.len() - leading).saturating_sub(1), denominator.len().saturating_sub(1));
    if degrees.1 > MAX_MACHINE_STATES {
        return Err(PlantError::TooManyStates { side, key: "denominator", states: degrees.1 });
    }
    let function = TransferFunction::new(numerator, denominator).map_err(on(side))?;
    if function.relative_degree().is_none_or(|degree| degree < 2) {
        return Err(PlantError::Improper { side, numerator: degrees.0, denominator: degrees.1 });
    }
    let single = balanced(&realise(&function).map_err(on(side))?, 0).map_err(on(side))?;
    let b = single.b().column(0);
    let b = DMatrix::from_columns(&[b, b]);
    StateSpace::continuous(single.a().clone(), b, single.c().clone(), DMatrix::zeros(1, 2)).map_err(on(side))
}

/// Row by row: A (n x n), B (n x 2), C (1 x n).
fn of_matrices(side: &'static str, a: &[f64], b: &[f64], c: &[f64]) -> Result<StateSpace<Continuous>, PlantError> {
    let states = c.len();
    if states > MAX_MACHINE_STATES {
        return Err(PlantError::TooManyStates { side, key: "c", states });
    }
    if states < 2 {
        return Err(PlantError::TooFewStates { side, states });
    }
    for (key, found, expected) in [("a", a.len(), states * states), ("b", b.len(), states * 2)] {
        if found != expected {
            return Err(PlantError::Size { side, key, found, expected, states });
        }
    }
    let (a, b) = (DMatrix::from_row_slice(states, states, a), DMatrix::from_row_slice(states, 2, b));
    let system = StateSpace::continuous(a, b, DMatrix::from_row_slice(1, states, c), DMatrix::zeros(1, 2));
    system.and_then(|system| balanced(&system, 0)).map_err(on(side))
}

/// Scales all but the first states by powers of two (exact), after Osborne (1960, *On pre-conditioning of matrices*).
fn balanced(system: &StateSpace<Continuous>, first: usize) -> Result<StateSpace<Continuous>, trocar_lti::Error> {
    const SWEEPS: usize = 30;
    let n = system.states();
    let (mut a, mut b, mut c) = (system.a().clone(), system.b().clone(), system.c().clone());
    for _ in 0..SWEEPS {
        let mut has_changed = false;
        for i in first..n {
            let of = |entry: &dyn Fn(usize) -> f64| -> f64 { (0..n).filter(|j| *j != i).map(|j| entry(j).abs()).sum() };
            let (column, row) = (of(&|j| a[(j, i)]), of(&|j| a[(i, j)]));
            if column == 0.0 || row == 0.0 || !(column + row).is_finite() {
                continue;
            }
            let power = (0.5 * (row / column).log2()).round();
            if power != 0.0 {
                let scale = power.exp2();
                has_changed = true;
                a.column_mut(i).scale_mut(scale);
                a.row_mut(i).unscale_mut(scale);
                c.column_mut(i).scale_mut(scale);
                b.row_mut(i).unscale_mut(scale);
            }
        }
        if !has_changed {
            break;
        }
    }
    StateSpace::continuous(a, b, c, system.d().clone())
}
