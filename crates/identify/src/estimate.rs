//! The identification: starts, comparison of structures, estimation, prediction.

use schemars::JsonSchema;
use serde::Serialize;
use trocar_base::warning::Warning;

use crate::IdentifyError;
use crate::actuator::{Bounded, Controller};
use crate::intervals::intervals;
use crate::machine::{Load, Machine};
use crate::measured::{Measured, deviation};
use crate::plausibility;
use crate::problem::Problem;
use crate::questions::Questions;
use crate::structure::{Parameter, Structure};
use crate::whiteness::Whiteness;

/// Corner frequencies of the starts in rad/s: of a slow, a usual and a fast slave.
const STARTS_RAD_PER_S: [f64; 3] = [30.0, 120.0, 500.0];

/// Share of each training recording in which the structures are fitted for their comparison; the rest is held out.
const FITTED_SHARE: f64 = 2.0 / 3.0;

/// The simplest structure within this distance of the best held-out fit is chosen, in points of %.
const TOLERANCE_PERCENT: f64 = 0.05;

/// The recordings of an identification.
#[derive(Debug, Clone, PartialEq)]
pub struct Request {
    /// The recordings that determine the parameters; at least one.
    pub training: Vec<Measured>,
    /// The recordings that take no part in the estimation.
    pub predictions: Vec<Measured>,
}

/// The part of a recording in an identification.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Role {
    /// It determines the parameters.
    Training,
    /// It is predicted with the parameters.
    Prediction,
}

/// The simulation of a recording with the identified machine.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// The recording.
    pub measured: Measured,
    /// Its part.
    pub role: Role,
    /// The simulated slave positions in m; `None` if the simulation diverges.
    pub simulated_m: Option<Vec<f64>>,
    /// `100 (1 - |simulated - slave| / |slave - mean|)` in %, with 2-norms.
    pub fit_percent: Option<f64>,
    /// The correlation of the error in time.
    pub whiteness: Option<Whiteness>,
}

/// An identified machine.
#[derive(Debug, Clone, PartialEq)]
pub struct Identification {
    /// The machine. If only ratios are known, its mass is 1 kg.
    pub machine: Machine,
    /// The chosen structure.
    pub structure: Structure,
    /// The structures with their mean fit on held-out parts of the training recordings, in %; `None` if it diverges.
    pub candidates: Vec<(Structure, Option<f64>)>,
    /// The recordings: those for training first.
    pub fits: Vec<Fit>,
    /// The warnings about the recordings.
    pub warnings: Vec<Warning>,
    pub(crate) parameters: Vec<(Parameter, Bounded)>,
    pub(crate) questions: Questions,
}

impl Identification {
    /// Returns the value and the 95 % interval of a parameter by its key in files, such as `mass_kg`; `None` if the
    /// machine has no such parameter.
    #[must_use]
    pub fn parameter(&self, key: &str) -> Option<(f64, [f64; 2])> {
        let (_, bounded) = self.parameters.iter().find(|(parameter, _)| parameter.key() == key)?;
        Some((bounded.value, [bounded.low, bounded.high]))
    }

    /// Returns the mean fit of the recordings of a role in %; `None` without recordings.
    #[must_use]
    pub fn mean_fit_percent(&self, role: Role) -> Option<f64> {
        let fits: Option<Vec<f64>> =
            self.fits.iter().filter(|fit| fit.role == role).map(|fit| fit.fit_percent).collect();
        let fits = fits.filter(|fits| !fits.is_empty())?;
        Some(fits.iter().sum::<f64>() / fits.len() as f64)
    }
}

/// The number of steps that [`identify`] reports.
pub const STEPS: usize = STARTS_RAD_PER_S.len() + Structure::ALL.len() + 1;

/// Identifies the slave of the training recordings, and predicts the others. `progress` is called after each of
/// [`STEPS`] steps. The result is deterministic.
///
/// # Errors
/// [`IdentifyError::NoTraining`], [`IdentifyError::Actuator`] if the actuator's force is not that of a controller, and
/// [`IdentifyError::Diverges`] if no start leads to a machine.
pub fn identify(request: Request, progress: impl Fn()) -> Result<Identification, IdentifyError> {
    let Request { training, predictions } = request;
    if training.is_empty() {
        return Err(IdentifyError::NoTraining);
    }
    let controller = Controller::of(&training)?;
    let base = base_parameters(controller.as_ref());
    let starts = STARTS_RAD_PER_S.map(|corner| start(&training, controller.as_ref(), corner));
    let solved = starts.map(|start| {
        let solved = Problem::new(&training, base.clone(), start).solve();
        progress();
        (solved.0, solved.1.machine())
    });
    let best = solved.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).filter(|(cost, _)| cost.is_finite());
    let (_, mut plain) = best.ok_or(IdentifyError::Diverges)?;
    if training.iter().all(|one| plain.simulate(one).is_none()) {
        return Err(IdentifyError::Diverges);
    }
    let questions = Questions::of(&training, &plain, controller.is_some());
    let base = if questions.only_ratios() {
        plain = per_mass(&plain);
        base.into_iter().filter(|parameter| *parameter != Parameter::Mass).collect()
    } else {
        base
    };
    // A start on a bound of 0 has no derivative by its logarithm.
    let plain = lifted(plain, &starts[1], &base);
    let structures = if questions.has_contact { &Structure::ALL[..] } else { &Structure::ALL[..1] };
    let free = |structure: Structure| -> Vec<Parameter> {
        let sensor = structure.sensor().iter().copied();
        let known = |parameter: &Parameter| questions.reverses || *parameter != Parameter::Offset;
        base.iter().copied().chain(sensor.filter(known)).collect()
    };
    let candidates: Vec<(Structure, Option<f64>)> = structures
        .iter()
        .map(|structure| {
            let fit = held_out(&training, free(*structure), plain);
            progress();
            (*structure, fit)
        })
        .collect();
    let structure = chosen(&candidates);
    let (_, solved) = Problem::new(&training, free(structure), plain).solve();
    let machine = without_traces(solved.machine(), &starts[1], solved.free());
    let mut parameters: Vec<(Parameter, Bounded)> =
        solved.free().iter().copied().zip(intervals(&solved, &machine, &starts[1])).collect();
    if questions.only_ratios() {
        parameters.insert(0, (Parameter::Mass, Bounded { value: 1.0, low: 1.0, high: 1.0 }));
    }
    parameters.extend(controller.iter().flat_map(|controller| {
        let Controller { position_gain, velocity_gain, delay } = *controller;
        [(Parameter::PositionGain, position_gain), (Parameter::VelocityGain, velocity_gain), (Parameter::Delay, delay)]
    }));
    let warnings = training.iter().chain(&predictions).flat_map(plausibility::warnings).collect();
    let of_role = |recordings: Vec<Measured>, role| recordings.into_iter().map(move |one| fit(one, role, &machine));
    let fits = of_role(training, Role::Training).chain(of_role(predictions, Role::Prediction)).collect();
    progress();
    Ok(Identification { machine, structure, candidates, fits, warnings, parameters, questions })
}

fn base_parameters(controller: Option<&Controller>) -> Vec<Parameter> {
    let mut base = vec![Parameter::Mass, Parameter::Viscous, Parameter::Coulomb];
    if controller.is_none() {
        base.extend([Parameter::PositionGain, Parameter::VelocityGain]);
    }
    base
}

/// Returns a machine whose mass and position gain have a corner frequency. The gain is that of the controller, or the
/// ratio of the forces and errors in the recording with the largest forces.
fn start(training: &[Measured], controller: Option<&Controller>, corner_rad_per_s: f64) -> Machine {
    let errors = |one: &Measured| -> Vec<f64> {
        one.master_m.iter().zip(&one.slave_m).map(|(master, slave)| master - slave).collect()
    };
    let error_m = training.iter().map(|one| deviation(&errors(one)) / (one.len() as f64).sqrt()).fold(1e-12, f64::max);
    let force_n = training.iter().map(|one| deviation(&one.force_n) / (one.len() as f64).sqrt()).fold(0.0, f64::max);
    let ratio = if force_n > 0.0 { force_n / error_m } else { corner_rad_per_s.powi(2) };
    let gain = controller.map_or(ratio, |controller| controller.position_gain.value);
    let mass_kg = gain / corner_rad_per_s.powi(2);
    let critical = 2.0 * (mass_kg * gain).sqrt();
    Machine {
        mass_kg,
        viscous_n_s_per_m: 0.1 * critical,
        coulomb_n: 0.3 * gain * error_m,
        position_gain_n_per_m: gain,
        velocity_gain_n_s_per_m: controller.map_or(0.3 * critical, |controller| controller.velocity_gain.value),
        delay_s: controller.map_or(0.0, |controller| controller.delay.value),
        load: Load::EXACT,
    }
}

/// Divides all forces by the mass.
fn per_mass(machine: &Machine) -> Machine {
    let mass = machine.mass_kg;
    Machine {
        mass_kg: 1.0,
        viscous_n_s_per_m: machine.viscous_n_s_per_m / mass,
        coulomb_n: machine.coulomb_n / mass,
        position_gain_n_per_m: machine.position_gain_n_per_m / mass,
        velocity_gain_n_s_per_m: machine.velocity_gain_n_s_per_m / mass,
        ..*machine
    }
}

/// Raises the free parameters of a machine to at least a hundredth of those of a start of the same size.
fn lifted(mut machine: Machine, start: &Machine, free: &[Parameter]) -> Machine {
    let size = machine.position_gain_n_per_m / start.position_gain_n_per_m;
    for parameter in free {
        let value = parameter.of(&machine).max(0.01 * size * parameter.of(start));
        parameter.set(&mut machine, value);
    }
    machine
}

/// Sets positive parameters to 0 that the optimiser drove below a millionth of their start: they are at their bound.
fn without_traces(mut machine: Machine, start: &Machine, free: &[Parameter]) -> Machine {
    for parameter in free.iter().filter(|parameter| parameter.is_positive() && **parameter != Parameter::Mass) {
        if parameter.of(&machine) < 1e-6 * parameter.of(start) {
            parameter.set(&mut machine, 0.0);
        }
    }
    machine
}

/// Returns the mean fit on the last third of each recording after an estimation on the rest, in %.
fn held_out(training: &[Measured], free: Vec<Parameter>, start: Machine) -> Option<f64> {
    let cut = |one: &Measured| (FITTED_SHARE * one.len() as f64) as usize;
    let fitted: Vec<Measured> = training.iter().map(|one| one.before(cut(one))).collect();
    let machine = Problem::new(&fitted, free, start).solve().1.machine();
    let fits = training.iter().map(|one| {
        let (simulated, from) = (machine.simulate(one)?, cut(one));
        let squares = simulated[from..].iter().zip(&one.slave_m[from..]).map(|(a, b)| (a - b).powi(2));
        // Relative to the motion of a third of the whole recording, because the end may be at rest.
        Some(100.0 * (1.0 - squares.sum::<f64>().sqrt() / (one.motion_m() * (1.0 - FITTED_SHARE).sqrt())))
    });
    let fits = fits.collect::<Option<Vec<f64>>>()?;
    Some(fits.iter().sum::<f64>() / fits.len() as f64)
}

/// Returns the simplest structure whose held-out fit is close to the best.
fn chosen(candidates: &[(Structure, Option<f64>)]) -> Structure {
    let best = candidates.iter().filter_map(|candidate| candidate.1).fold(f64::NEG_INFINITY, f64::max);
    let is_close =
        |candidate: &&(Structure, Option<f64>)| candidate.1.is_some_and(|fit| fit >= best - TOLERANCE_PERCENT);
    candidates.iter().find(is_close).map_or(Structure::Plain, |candidate| candidate.0)
}

fn fit(measured: Measured, role: Role, machine: &Machine) -> Fit {
    let simulated_m = machine.simulate(&measured);
    let fit_percent = simulated_m.as_deref().map(|simulated| measured.fit_percent(simulated));
    let whiteness = simulated_m.as_deref().and_then(|simulated| {
        let errors: Vec<f64> = simulated.iter().zip(&measured.slave_m).map(|(a, b)| a - b).collect();
        Whiteness::of(&errors)
    });
    Fit { measured, role, simulated_m, fit_percent, whiteness }
}
