use schemars::JsonSchema;
use serde::Serialize;
use trocar_base::warning::Warning;

use crate::IdentifyError;
use crate::actuator::{Bounded, Controller};
use crate::intervals::{Earlier, intervals};
use crate::machine::{Load, Machine};
use crate::measured::{Measured, deviation, fit_percent};
use crate::model::{Model, SlaveSystem, Unknown};
use crate::plausibility;
use crate::problem::Problem;
use crate::questions::Questions;
use crate::structure::{Parameter, Structure};
use crate::whiteness::Whiteness;
use crate::zero::FreeMotion;

/// A slow, a usual and a fast slave.
const STARTS_RAD_PER_S: [f64; 3] = [30.0, 120.0, 500.0];

/// The rest is held out to compare the structures.
pub(crate) const FITTED_SHARE: f64 = 2.0 / 3.0;

/// The simplest structure within this distance of the best fit is chosen.
const TOLERANCE_PERCENT: f64 = 0.05;

#[derive(Debug, Clone, PartialEq)]
pub struct Request {
    pub training: Vec<Measured>,
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

impl Role {
    pub(crate) fn word(self) -> &'static str {
        match self {
            Self::Training => "training",
            Self::Prediction => "prediction",
        }
    }
}

#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    pub measured: Measured,
    pub role: Role,
    /// In N; 0 without a training recording in free motion.
    pub sensor_zero_n: f64,
    /// `None` if the simulation diverges.
    pub simulated_m: Option<Vec<f64>>,
    /// `100 (1 - |simulated - slave| / |slave - mean|)` with 2-norms.
    pub fit_percent: Option<f64>,
    pub whiteness: Option<Whiteness>,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Identification {
    /// Has a mass of 1 kg if only ratios are known.
    pub machine: Machine,
    pub structure: Structure,
    /// With the mean held-out fit in %; `None` if it diverges.
    pub candidates: Vec<(Structure, Option<f64>)>,
    /// Training first.
    pub fits: Vec<Fit>,
    pub warnings: Vec<Warning>,
    pub(crate) parameters: Vec<(Parameter, Bounded)>,
    pub(crate) questions: Questions,
}

impl Identification {
    /// `key` as in files, such as `mass_kg`.
    pub fn parameter(&self, key: &str) -> Option<(f64, [f64; 2])> {
        let (_, bounded) = self.parameters.iter().find(|(parameter, _)| parameter.key() == key)?;
        Some((bounded.value, [bounded.low, bounded.high]))
    }

    pub fn mean_fit_percent(&self, role: Role) -> Option<f64> {
        mean_fit(self.fits.iter().filter(|fit| fit.role == role).map(|fit| fit.fit_percent))
    }
}

pub const STEPS: usize = STARTS_RAD_PER_S.len() + Structure::ALL.len() + 1;

/// Calls `progress` after each of [`STEPS`] steps.
pub fn identify(request: Request, progress: impl Fn()) -> Result<Identification, IdentifyError> {
    let Request { training, predictions } = request;
    if training.is_empty() {
        return Err(IdentifyError::NoTraining);
    }
    let controller = Controller::of(&training)?;
    let base = base_parameters(controller.as_ref());
    let starts = STARTS_RAD_PER_S.map(|corner| start(&training, controller.as_ref(), corner));
    let free_motion = FreeMotion::of(&training);
    let zeros = |coulomb_n: f64| zeros(&training, free_motion, coulomb_n);
    let with_zeros = |machine: Machine| Model { zeros_n: zeros(f64::INFINITY), machine };
    let solved = starts.map(|start| {
        let free = base.iter().copied().map(Unknown::Of).collect();
        let solved = slave_problem(&training, free, with_zeros(start), free_motion).solve();
        progress();
        (solved.0, solved.1.model())
    });
    let best = solved.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).filter(|(cost, _)| cost.is_finite());
    let (_, mut plain) = best.ok_or(IdentifyError::Diverges)?;
    if training.iter().zip(&plain.zeros_n).all(|(one, zero_n)| plain.machine.simulate(one, *zero_n).is_none()) {
        return Err(IdentifyError::Diverges);
    }
    let questions = Questions::of(&training, &plain, controller.is_some());
    let mut base = base;
    if questions.only_ratios() {
        plain.machine = per_mass(&plain.machine);
        base.retain(|parameter| *parameter != Parameter::Mass);
    }
    // A start on a bound of 0 has no derivative by its logarithm.
    plain.machine = lifted(plain.machine, &starts[1], &base);
    let structures = if questions.has_contact { &Structure::ALL[..] } else { &Structure::ALL[..1] };
    let stages = Stages { base, free_motion, questions };
    let candidates: Vec<(Structure, Option<f64>)> = structures
        .iter()
        .map(|structure| {
            let fit = held_out(&training, &stages, *structure, &plain);
            progress();
            (*structure, fit)
        })
        .collect();
    let structure = chosen(&candidates);
    let Solved { earlier, problem, mut model } = stages.solve(&training, structure, plain);
    let unknowns: Vec<Parameter> = stages.base.iter().copied().chain(structure.sensor().iter().copied()).collect();
    model.machine = without_traces(model.machine, &starts[1], &unknowns);
    let start = Model { machine: starts[1], zeros_n: model.zeros_n.clone() };
    let estimated = intervals(&problem, &model, &start, earlier.as_ref());
    let of_machine = |(unknown, bounded): (Unknown, Bounded)| match unknown {
        Unknown::Of(parameter) => Some((parameter, bounded)),
        Unknown::Zero(_) => None,
    };
    let mut parameters: Vec<(Parameter, Bounded)> = estimated.into_iter().filter_map(of_machine).collect();
    if questions.only_ratios() {
        parameters.insert(0, (Parameter::Mass, Bounded { value: 1.0, low: 1.0, high: 1.0 }));
    }
    parameters.extend(controller.iter().flat_map(|controller| {
        let Controller { position_gain, velocity_gain, delay } = *controller;
        [(Parameter::PositionGain, position_gain), (Parameter::VelocityGain, velocity_gain), (Parameter::Delay, delay)]
    }));
    let Model { machine, zeros_n } = model;
    let warnings = training.iter().chain(&predictions).flat_map(plausibility::warnings).collect();
    let predicted = predictions.into_iter().map(|one| {
        let zero_n = free_motion.map_or(0.0, |free| free.predicted(&one, &machine, &zeros_n));
        fit(one, Role::Prediction, &machine, zero_n)
    });
    let trained = training.into_iter().zip(&zeros_n).map(|(one, zero_n)| fit(one, Role::Training, &machine, *zero_n));
    let fits = trained.chain(predicted).collect();
    progress();
    Ok(Identification { machine, structure, candidates, fits, warnings, parameters, questions })
}

/// 0 without a recording in free motion.
fn zeros(training: &[Measured], free_motion: Option<FreeMotion>, coulomb_n: f64) -> Vec<f64> {
    let zero_n = |(index, one): (usize, &Measured)| match free_motion {
        None => 0.0,
        Some(free) if free.recording == index => free.zero_n,
        Some(free) => free.tare(one, coulomb_n).unwrap_or(free.zero_n),
    };
    training.iter().enumerate().map(zero_n).collect()
}

/// A recording in free motion with a known controller alone determines mass and viscous friction: contact effects, such
/// as the hysteresis of a foam, are not part of the machine.
struct Stages {
    base: Vec<Parameter>,
    free_motion: Option<FreeMotion>,
    questions: Questions,
}

struct Solved<'a> {
    earlier: Option<Earlier<SlaveSystem<'a>>>,
    problem: Problem<SlaveSystem<'a>>,
    model: Model,
}

impl Stages {
    fn solve<'a>(&self, training: &'a [Measured], structure: Structure, mut start: Model) -> Solved<'a> {
        let mut free: Vec<Unknown> = self.base.iter().chain(structure.sensor()).copied().map(Unknown::Of).collect();
        let mut earlier = None;
        if let Some(free_motion) = self.free_motion {
            let offset = Unknown::Of(Parameter::Offset);
            if !free.contains(&offset) {
                free.push(offset);
            }
            if self.questions.has_actuator {
                let alone = std::slice::from_ref(&training[free_motion.recording]);
                let unknowns =
                    [Parameter::Mass, Parameter::Viscous, Parameter::Coulomb, Parameter::Offset].map(Unknown::Of);
                let zeros_n = vec![free_motion.zero_n];
                let at_start = Model { machine: start.machine, zeros_n };
                let (_, solved) = slave_problem(alone, self.known(&unknowns), at_start, self.free_motion).solve();
                start.machine = solved.model().machine;
                free.retain(|unknown| {
                    ![Unknown::Of(Parameter::Mass), Unknown::Of(Parameter::Viscous)].contains(unknown)
                });
                earlier = Some(Earlier { problem: solved, recording: free_motion.recording });
            }
            start.zeros_n = zeros(training, self.free_motion, start.machine.coulomb_n);
            if self.questions.has_contact {
                let in_contact = (0..training.len()).filter(|index| *index != free_motion.recording);
                free.extend(in_contact.map(Unknown::Zero));
            }
        }
        let (_, problem) = slave_problem(training, self.known(&free), start, self.free_motion).solve();
        let mut model = problem.model();
        let readings_n = training
            .iter()
            .zip(&model.zeros_n)
            .flat_map(|(one, zero_n)| one.force_n.iter().map(move |force_n| (force_n - zero_n).abs()));
        model.machine.load.scaled_up_to_n = readings_n.fold(0.0, f64::max);
        Solved { earlier, problem, model }
    }

    /// Excludes the constant force if no reversal distinguishes it from friction.
    fn known(&self, unknowns: &[Unknown]) -> Vec<Unknown> {
        let is_known = |unknown: &Unknown| self.questions.reverses || *unknown != Unknown::Of(Parameter::Offset);
        unknowns.iter().copied().filter(is_known).collect()
    }
}

fn slave_problem(
    recordings: &[Measured],
    free: Vec<Unknown>,
    start: Model,
    free_motion: Option<FreeMotion>,
) -> Problem<SlaveSystem<'_>> {
    Problem::new(SlaveSystem::new(recordings, &start, free_motion), free, start)
}

fn base_parameters(controller: Option<&Controller>) -> Vec<Parameter> {
    let mut base = vec![Parameter::Mass, Parameter::Viscous, Parameter::Coulomb];
    if controller.is_none() {
        base.extend([Parameter::PositionGain, Parameter::VelocityGain]);
    }
    base
}

/// The gain is the controller's, or the largest force per largest error.
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

/// To at least a hundredth of a start of the same size.
fn lifted(mut machine: Machine, start: &Machine, free: &[Parameter]) -> Machine {
    let size = machine.position_gain_n_per_m / start.position_gain_n_per_m;
    for parameter in free {
        let value = parameter.of(&machine).max(0.01 * size * parameter.of(start));
        parameter.set(&mut machine, value);
    }
    machine
}

/// Zeroes parameters below a millionth of their start.
fn without_traces(mut machine: Machine, start: &Machine, free: &[Parameter]) -> Machine {
    for parameter in free.iter().filter(|parameter| parameter.is_positive() && **parameter != Parameter::Mass) {
        if parameter.of(&machine) < 1e-6 * parameter.of(start) {
            parameter.set(&mut machine, 0.0);
        }
    }
    machine
}

/// On the last third of each recording, estimated on the rest.
fn held_out(training: &[Measured], stages: &Stages, structure: Structure, start: &Model) -> Option<f64> {
    let cut = |one: &Measured| (FITTED_SHARE * one.len() as f64) as usize;
    let fitted: Vec<Measured> = training.iter().map(|one| one.before(cut(one))).collect();
    let Model { machine, zeros_n } = stages.solve(&fitted, structure, start.clone()).model;
    let fits = training.iter().zip(&zeros_n).map(|(one, zero_n)| {
        let (simulated, from) = (machine.simulate(one, *zero_n)?, cut(one));
        // The end may be at rest.
        let motion_m = one.motion_m() * (1.0 - FITTED_SHARE).sqrt();
        Some(fit_percent(&simulated[from..], &one.slave_m[from..], motion_m))
    });
    mean_fit(fits)
}

pub(crate) fn mean_fit(fits: impl Iterator<Item = Option<f64>>) -> Option<f64> {
    let fits = fits.collect::<Option<Vec<f64>>>().filter(|fits| !fits.is_empty())?;
    Some(fits.iter().sum::<f64>() / fits.len() as f64)
}

fn chosen(candidates: &[(Structure, Option<f64>)]) -> Structure {
    let best = candidates.iter().filter_map(|candidate| candidate.1).fold(f64::NEG_INFINITY, f64::max);
    let is_close =
        |candidate: &&(Structure, Option<f64>)| candidate.1.is_some_and(|fit| fit >= best - TOLERANCE_PERCENT);
    candidates.iter().find(is_close).map_or(Structure::Plain, |candidate| candidate.0)
}

fn fit(measured: Measured, role: Role, machine: &Machine, sensor_zero_n: f64) -> Fit {
    let simulated_m = machine.simulate(&measured, sensor_zero_n);
    let fit_percent = simulated_m.as_deref().map(|simulated| measured.fit_percent(simulated));
    let whiteness = simulated_m.as_deref().and_then(|simulated| Whiteness::between(simulated, &measured.slave_m));
    Fit { measured, role, sensor_zero_n, simulated_m, fit_percent, whiteness }
}
