//! User-defined parts: Python functions, and compiled functions given by their addresses.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use numpy::PyReadonlyArray1;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyTuple, PyType};
use trocar_core::augmentation::{AugmentedTick, ForceLaw, Mode, ModeChange, MotionLaw};
use trocar_core::detector::{Decision, Detector, DetectorInput, Distance};
use trocar_core::estimation::{Estimate, Estimator};
use trocar_engine::engine::UserDefinedParts;
use trocar_engine::operator::Operator;
use trocar_engine::tissue::{Reaction, Tissue};

use crate::arrays::samples;
use crate::user_defined_link::set_methods;

/// A compiled function. Its inputs, outputs and state are arrays of float64.
type Compiled = unsafe extern "C" fn(*const f64, *mut f64, *mut f64);

/// The first exception of the parts of a run, which ends the run.
#[derive(Clone, Default)]
pub(crate) struct Failure {
    has_failed: Arc<AtomicBool>,
    error: Arc<Mutex<Option<PyErr>>>,
}

impl Failure {
    /// True if there is an exception.
    pub(crate) fn has_failed(&self) -> bool {
        self.has_failed.load(Ordering::Relaxed)
    }

    pub(crate) fn take(&self) -> Option<PyErr> {
        self.error.lock().unwrap_or_else(PoisonError::into_inner).take()
    }

    #[cold]
    pub(crate) fn set(&self, error: PyErr) {
        self.error.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
        self.has_failed.store(true, Ordering::Relaxed);
    }
}

/// The Python type of an input.
#[derive(Clone, Copy)]
enum Input {
    Number,
    Whole,
    Flag,
}

use Input::{Flag, Number, Whole};

/// The arguments and results of a role.
struct Role {
    name: &'static str,
    inputs: &'static [Input],
    /// Names of the outputs. Those after the first `needed` are optional; their default is 0 or false.
    outputs: &'static [&'static str],
    needed: usize,
    /// Sets the part of the role.
    set: fn(UserDefinedParts, Part) -> UserDefinedParts,
}

/// The roles whose parts are objects with several methods.
const ROLES_OF_METHODS: [&str; 2] = ["architecture", "passivity"];

impl Role {
    fn named(name: &str) -> PyResult<&'static Self> {
        ROLES.iter().find(|role| role.name == name).ok_or_else(|| {
            let known = ROLES.iter().map(|role| role.name).chain(ROLES_OF_METHODS).collect::<Vec<_>>().join(", ");
            PyTypeError::new_err(format!(
                "there is no role {name}; the roles are {known}. A key is changed in the scenario, as in \
                 trocar.Scenario.load(path, **{{\"scaling.force\": 0.5, \"simulation.seed\": 3}})"
            ))
        })
    }
}

/// Every role, in the form that `trocar/parts.py` documents.
static ROLES: [Role; 7] = [
    Role {
        name: "tissue",
        inputs: &[Whole, Number, Number],
        outputs: &["force_n", "ruptured"],
        needed: 1,
        set: UserDefinedParts::tissue,
    },
    Role {
        name: "operator",
        inputs: &[Whole, Number, Number, Flag],
        outputs: &["desired_position_m", "notices", "intended_position_m"],
        needed: 1,
        set: |parts, part| parts.operator(UserDefinedOperator::new(part)),
    },
    Role {
        name: "estimator",
        inputs: &[Number, Number, Number],
        outputs: &["predicted_force_n", "stiffness_n_per_m", "damping_n_s_per_m"],
        needed: 1,
        set: |parts, part| parts.estimator(UserDefinedEstimator { part, last: [0.0; 2] }),
    },
    Role {
        name: "detector",
        inputs: &[Number, Number, Number, Number, Number, Flag],
        outputs: &["alarm", "decision", "distance"],
        needed: 1,
        set: UserDefinedParts::detector,
    },
    Role {
        name: "distance",
        inputs: &[Number, Number, Number, Number, Number, Flag],
        outputs: &["distance"],
        needed: 1,
        set: UserDefinedParts::distance,
    },
    Role {
        name: "force_law",
        inputs: &[Number, Number, Number, Number, Number, Flag],
        outputs: &["force_n", "allowed_step_n"],
        needed: 2,
        set: UserDefinedParts::force_law,
    },
    Role {
        name: "motion_law",
        inputs: &[Whole, Number, Number],
        outputs: &["reference_m", "is_blended"],
        needed: 2,
        set: |parts, part| parts.motion_law(UserDefinedMotionLaw { part, is_blended: true }),
    },
];

enum Function {
    Python(Py<PyAny>),
    Compiled { function: Compiled, state: Vec<f64> },
}

pub(crate) struct Part {
    role: &'static Role,
    function: Function,
    /// Number of inputs that a Python function takes: an operator may take the first two only.
    taken: usize,
    /// Number of outputs that the last call returned.
    returned: usize,
    /// The method to call at a gap in the samples of an estimator, or after an alarm of a distance.
    skip: Option<Py<PyAny>>,
    failure: Failure,
}

impl Part {
    /// The part for an object: a compiled function with its state, an object with the methods `step` and `reset`, a
    /// class of objects with a method `step`, or a function. Calls the object's `reset`, or makes a new object, so every
    /// run begins in the same state.
    fn of(role: &'static Role, given: &Bound<'_, PyAny>, failure: &Failure) -> PyResult<Self> {
        let part = |function| Self {
            role,
            function,
            taken: role.inputs.len(),
            returned: 0,
            skip: None,
            failure: failure.clone(),
        };
        if let Some(address) = given.getattr_opt("_trocar_address")? {
            let address: usize = address.extract()?;
            if address == 0 {
                return Err(PyValueError::new_err(format!("the {} has the address 0", role.name)));
            }
            let state: PyReadonlyArray1<'_, f64> = given.getattr("_trocar_state")?.extract()?;
            // SAFETY: the conditions of the call below apply.
            #[allow(unsafe_code, reason = "only a transmutation turns an address into a function")]
            let function = unsafe { std::mem::transmute::<usize, Compiled>(address) };
            return Ok(part(Function::Compiled { function, state: samples(&state)? }));
        }
        let object = begun(role.name, given, "step")?;
        let function = match method(&object, "step")? {
            Some(step) => step,
            None if object.is_callable() => object.clone(),
            None => {
                let kind = object.get_type().qualname()?;
                let must = "a function, an object with a method step, or a compiled function";
                return Err(PyTypeError::new_err(format!("the {} is of the type {kind}, must be {must}", role.name)));
            }
        };
        let taken = match role.name {
            "operator" if !takes_arguments(&function, role.inputs.len())? => 2,
            _ => role.inputs.len(),
        };
        let skip = method(&object, if role.name == "distance" { "after_alarm" } else { "skip" })?.map(Bound::unbind);
        Ok(Self { skip, taken, ..part(Function::Python(function.unbind())) })
    }

    /// Calls the function. After an exception the outputs are 0, and the run ends.
    fn call<const INPUTS: usize, const OUTPUTS: usize>(&mut self, inputs: [f64; INPUTS]) -> [f64; OUTPUTS] {
        let mut outputs = [0.0; OUTPUTS];
        if self.failure.has_failed() {
            return outputs;
        }
        match &mut self.function {
            Function::Python(function) => {
                let called = Python::attach(|py| {
                    call_python(self.role, function.bind(py), &inputs[..self.taken])
                        .and_then(|returned| read_outputs(self.role, &returned, &mut outputs))
                });
                match called {
                    Ok(returned) => self.returned = returned,
                    Err(error) => {
                        self.failure.set(error);
                        return [0.0; OUTPUTS];
                    }
                }
            }
            Function::Compiled { function, state } => {
                // SAFETY: the user of Python's `Compiled` guarantees the address and the signature. The arrays have
                // the documented lengths and live during the call.
                #[allow(unsafe_code, reason = "a C function has no other call")]
                unsafe {
                    function(inputs.as_ptr(), outputs.as_mut_ptr(), state.as_mut_ptr());
                }
                self.returned = OUTPUTS;
            }
        }
        if outputs.iter().all(|value| value.is_finite()) { outputs } else { self.refuse(outputs) }
    }

    /// Calls the method for a gap in the samples, or after an alarm.
    fn skip(&self) {
        if let Some(skip) = &self.skip
            && let Err(error) = Python::attach(|py| skip.call0(py))
        {
            self.failure.set(error);
        }
    }

    #[cold]
    fn refuse<const OUTPUTS: usize>(&self, outputs: [f64; OUTPUTS]) -> [f64; OUTPUTS] {
        if let Some((name, value)) = self.role.outputs.iter().zip(outputs).find(|(_, value)| !value.is_finite()) {
            let message = format!("the {} returned {name} = {value}, must be finite", self.role.name);
            self.failure.set(PyValueError::new_err(message));
        }
        [0.0; OUTPUTS]
    }
}

fn method<'py>(object: &Bound<'py, PyAny>, name: &str) -> PyResult<Option<Bound<'py, PyAny>>> {
    Ok(object.getattr_opt(name)?.filter(|method| method.is_callable()))
}

/// The object of a part at the beginning of a run, after its `reset`: a new one of a class, or the given one. An object
/// with the method `needed` and without `reset` is refused, as a second run would begin in the state of the first.
pub(crate) fn begun<'py>(role: &str, given: &Bound<'py, PyAny>, needed: &str) -> PyResult<Bound<'py, PyAny>> {
    let made = match given.cast::<PyType>() {
        Ok(class) if class.hasattr(needed)? => Some(class.call0()?),
        _ => None,
    };
    let object = made.as_ref().unwrap_or(given);
    match method(object, "reset")? {
        Some(reset) => drop(reset.call0()?),
        None if made.is_none() && method(given, needed)?.is_some() => {
            let kind = given.get_type().qualname()?;
            return Err(PyTypeError::new_err(format!(
                "the {role} has a method {needed} and no method reset, so a second run would begin in the state of the \
                 first: add a method reset, or pass the class {kind} itself, of which every run makes a new object"
            )));
        }
        None => {}
    }
    Ok(object.clone())
}

/// True if a Python function can be called with this number of positional arguments.
fn takes_arguments(function: &Bound<'_, PyAny>, count: usize) -> PyResult<bool> {
    let module = function.py().import("trocar._parts")?;
    module.getattr("takes_arguments")?.call1((function, count))?.extract()
}

fn call_python<'py>(role: &Role, function: &Bound<'py, PyAny>, inputs: &[f64]) -> PyResult<Bound<'py, PyAny>> {
    let py = function.py();
    let object = |index: usize| match role.inputs[index] {
        Number => PyFloat::new(py, inputs[index]).into_any(),
        Whole => PyInt::new(py, inputs[index] as u64).into_any(),
        Flag => PyBool::new(py, inputs[index] != 0.0).to_owned().into_any(),
    };
    // Calling with a Rust tuple avoids a Python tuple.
    match inputs.len() {
        2 => function.call1((object(0), object(1))),
        3 => function.call1((object(0), object(1), object(2))),
        4 => function.call1((object(0), object(1), object(2), object(3))),
        6 => function.call1((object(0), object(1), object(2), object(3), object(4), object(5))),
        count => function.call1(PyTuple::new(py, (0..count).map(object))?),
    }
}

/// Reads the outputs of a call. Returns their number.
fn read_outputs(role: &Role, returned: &Bound<'_, PyAny>, outputs: &mut [f64]) -> PyResult<usize> {
    let refuse = || {
        let names = |names: &[&str]| names.join(", ");
        let shorter = if role.needed == 1 { format!("{} alone or ", role.outputs[0]) } else { String::new() };
        let kind = returned.get_type();
        PyTypeError::new_err(format!(
            "the {} returned a {kind}, must return {shorter}({})",
            role.name,
            names(role.outputs)
        ))
    };
    let Ok(given) = returned.cast::<PyTuple>() else {
        if role.needed > 1 {
            return Err(refuse());
        }
        outputs[0] = returned.extract().map_err(|_| refuse())?;
        return Ok(1);
    };
    if !(role.needed..=outputs.len()).contains(&given.len()) {
        return Err(refuse());
    }
    let count = given.len();
    for (output, value) in outputs.iter_mut().zip(given) {
        *output = value.extract().map_err(|_| refuse())?;
    }
    Ok(count)
}

fn flag(output: f64) -> bool {
    output != 0.0
}

impl Tissue<f64> for Part {
    fn react(&mut self, tick: u64, position_m: f64, velocity_m_per_s: f64) -> Reaction<f64> {
        let [force_n, ruptured] = self.call([tick as f64, position_m, velocity_m_per_s]);
        Reaction { force_n, ruptured: flag(ruptured) }
    }
}

/// An operator, who sees the position of their own hand, and may notice changes and intend another position than the
/// desired one.
struct UserDefinedOperator {
    part: Part,
    /// The position of the master at the last tick in m; NaN before the first.
    master_m: f64,
    has_cue: bool,
    notices: bool,
    intended_m: Option<f64>,
}

impl UserDefinedOperator {
    fn new(part: Part) -> Self {
        Self { part, master_m: f64::NAN, has_cue: false, notices: false, intended_m: None }
    }
}

impl Operator<f64> for UserDefinedOperator {
    fn desired_position_m(&mut self, tick: u64, felt_n: f64) -> f64 {
        let has_cue = f64::from(u8::from(self.has_cue));
        let [desired_m, notices, intended_m] = self.part.call([tick as f64, felt_n, self.master_m, has_cue]);
        self.notices = flag(notices);
        // The outputs of a compiled function are always three numbers, and it leaves those at 0 that it does not write.
        let gives_intended = self.part.returned > 2 && matches!(self.part.function, Function::Python(_));
        self.intended_m = gives_intended.then_some(intended_m);
        desired_m
    }

    fn intended_position_m(&self, desired_m: f64) -> f64 {
        self.intended_m.unwrap_or(desired_m)
    }

    fn master(&mut self, position_m: f64) {
        self.master_m = position_m;
    }

    fn cue(&mut self, is_on: bool) {
        self.has_cue = is_on;
    }

    fn notices(&self) -> bool {
        self.notices
    }
}

struct UserDefinedEstimator {
    part: Part,
    last: [f64; 2],
}

impl Estimator<f64> for UserDefinedEstimator {
    fn update(&mut self, force_n: f64, depth_m: f64, velocity_m_per_s: f64) -> Estimate<f64> {
        let [predicted_force_n, stiffness_n_per_m, damping_n_s_per_m] =
            self.part.call([force_n, depth_m, velocity_m_per_s]);
        let correction = [stiffness_n_per_m - self.last[0], damping_n_s_per_m - self.last[1]];
        self.last = [stiffness_n_per_m, damping_n_s_per_m];
        Estimate {
            predicted_force_n,
            residual_n: force_n - predicted_force_n,
            correction,
            stiffness_n_per_m,
            damping_n_s_per_m,
            extra_parameter: 0.0,
        }
    }

    fn skip(&mut self) {
        self.part.skip();
    }
}

impl Distance<f64> for Part {
    fn update(&mut self, now: &DetectorInput<f64>) -> f64 {
        let [distance] = self.call(detector_inputs(now));
        distance
    }

    fn reset(&mut self, mask: bool) {
        if mask {
            self.skip();
        }
    }
}

fn detector_inputs(now: &DetectorInput<f64>) -> [f64; 6] {
    let in_contact = f64::from(u8::from(now.in_contact));
    [now.force_n, now.predicted_force_n, now.residual_n, now.depth_m, now.velocity_m_per_s, in_contact]
}

impl Detector<f64> for Part {
    fn update(&mut self, now: &DetectorInput<f64>) -> Decision<f64> {
        let [alarm, decision, distance] = self.call(detector_inputs(now));
        Decision { distance, decision, alarm: flag(alarm) }
    }
}

impl ForceLaw<f64> for Part {
    fn augmented(&mut self, now: &AugmentedTick<f64>) -> (f64, f64) {
        let begins = f64::from(u8::from(now.begins));
        let inputs = [now.anchor_n, now.last_n, now.measured_n, now.moved_n, now.velocity_m_per_s, begins];
        let [force_n, allowed_step_n] = self.call(inputs);
        (force_n, allowed_step_n)
    }
}

struct UserDefinedMotionLaw {
    part: Part,
    is_blended: bool,
}

impl UserDefinedMotionLaw {
    fn reference_m(&mut self, mode: Mode, hand_m: f64, slave_m: f64) -> f64 {
        let [reference_m, is_blended] = self.part.call([f64::from(mode.code()), hand_m, slave_m]);
        self.is_blended = flag(is_blended);
        reference_m
    }
}

impl MotionLaw<f64> for UserDefinedMotionLaw {
    fn follow(&mut self, hand_m: f64, slave_m: f64) -> f64 {
        self.reference_m(Mode::Teleoperation, hand_m, slave_m)
    }

    fn update(&mut self, modes: ModeChange<f64>, hand_m: f64, slave_m: f64) -> f64 {
        self.reference_m(modes.now.lane(0), hand_m, slave_m)
    }

    fn is_blended(&self) -> bool {
        self.is_blended
    }
}

pub(crate) fn detector(given: &Bound<'_, PyAny>, failure: &Failure) -> PyResult<impl Detector<f64> + use<>> {
    Part::of(Role::named("detector")?, given, failure)
}

/// A compiled part for any number of runs. The runs need no interpreter.
pub(crate) struct CompiledPart {
    role: &'static Role,
    function: Compiled,
    state: Vec<f64>,
}

impl CompiledPart {
    fn of(role: &str, given: &Bound<'_, PyAny>) -> PyResult<Option<Self>> {
        let role = Role::named(role)?;
        if given.getattr_opt("_trocar_address")?.is_none() {
            return Ok(None);
        }
        Ok(match Part::of(role, given, &Failure::default())?.function {
            Function::Compiled { function, state } => Some(Self { role, function, state }),
            Function::Python(_) => None,
        })
    }

    pub(crate) fn detector(given: &Bound<'_, PyAny>) -> PyResult<Option<Self>> {
        Self::of("detector", given)
    }

    pub(crate) fn begin(&self, failure: &Failure) -> Part {
        let function = Function::Compiled { function: self.function, state: self.state.clone() };
        let taken = self.role.inputs.len();
        Part { role: self.role, function, taken, returned: 0, skip: None, failure: failure.clone() }
    }
}

pub(crate) struct CompiledParts(Vec<CompiledPart>);

impl CompiledParts {
    pub(crate) fn of(given: &Bound<'_, PyDict>) -> PyResult<Option<Self>> {
        let part = |(name, object): (Bound<'_, PyAny>, Bound<'_, PyAny>)| {
            let name: String = name.extract()?;
            if ROLES_OF_METHODS.contains(&name.as_str()) { Ok(None) } else { CompiledPart::of(&name, &object) }
        };
        Ok(given.iter().map(part).collect::<PyResult<Option<Vec<_>>>>()?.map(Self))
    }

    pub(crate) fn begin(&self) -> UserDefined {
        let failure = Failure::default();
        let with = |parts, one: &CompiledPart| (one.role.set)(parts, one.begin(&failure));
        UserDefined { parts: self.0.iter().fold(UserDefinedParts::default(), with), failure, are_compiled: true }
    }
}

/// The user-defined parts of a run.
pub(crate) struct UserDefined {
    pub(crate) parts: UserDefinedParts,
    pub(crate) failure: Failure,
    pub(crate) are_compiled: bool,
}

impl UserDefined {
    pub(crate) fn of(given: &Bound<'_, PyDict>) -> PyResult<Self> {
        let (mut parts, failure, mut are_compiled) = (UserDefinedParts::default(), Failure::default(), true);
        for (name, object) in given {
            let name: String = name.extract()?;
            if ROLES_OF_METHODS.contains(&name.as_str()) {
                parts = set_methods(parts, &name, &object, &failure)?;
                are_compiled = false;
                continue;
            }
            let role = Role::named(&name)?;
            let part = Part::of(role, &object, &failure)?;
            are_compiled &= matches!(part.function, Function::Compiled { .. });
            parts = (role.set)(parts, part);
        }
        Ok(Self { parts, failure, are_compiled })
    }
}
