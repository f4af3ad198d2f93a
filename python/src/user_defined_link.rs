//! User-defined parts of the link: objects with a method for each step of their role.

use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use pyo3::{BoundObject, IntoPyObject};
use trocar_engine::engine::UserDefinedParts;
use trocar_engine::teleoperation::{
    Architecture, Arrived, ArrivedAtMaster, AtMaster, AtSlave, MasterSample, PAYLOAD, PassivityScheme, Payload,
    SchemeEnergies, SlavePort,
};

use crate::user_defined::{Failure, begun};

/// Sets an architecture or a passivity scheme.
pub(crate) fn set_methods(
    parts: UserDefinedParts,
    role: &str,
    given: &Bound<'_, PyAny>,
    failure: &Failure,
) -> PyResult<UserDefinedParts> {
    if role == "architecture" {
        let needed = ["slave_target", "master_force"];
        return Ok(parts.architecture(UserDefinedArchitecture(Methods::of("architecture", given, needed, failure)?)));
    }
    const NAMES: [&str; 7] = [
        "master_sends",
        "receive_position",
        "limit_reference",
        "slave_sends",
        "receive_force",
        "limit_force",
        "energies",
    ];
    let methods = Methods::of("passivity", given, NAMES, failure)?;
    if methods.all.iter().all(Option::is_none) {
        let kind = given.get_type().qualname()?;
        let must = format!("an object with one of the methods {}", NAMES.join(", "));
        return Err(PyTypeError::new_err(format!("the passivity is of the type {kind}, must be {must}")));
    }
    Ok(parts.scheme(UserDefinedScheme(methods)))
}

/// The methods of an object.
struct Methods<const COUNT: usize> {
    role: &'static str,
    names: [&'static str; COUNT],
    all: [Option<Py<PyAny>>; COUNT],
    failure: Failure,
}

impl<const COUNT: usize> Methods<COUNT> {
    fn of(
        role: &'static str,
        given: &Bound<'_, PyAny>,
        names: [&'static str; COUNT],
        failure: &Failure,
    ) -> PyResult<Self> {
        let present = names.into_iter().find(|name| given.hasattr(*name).unwrap_or(false));
        let object = begun(role, given, present.unwrap_or(names[0]))?;
        let mut all = [const { None }; COUNT];
        for (method, name) in all.iter_mut().zip(names) {
            *method = object.getattr_opt(name)?.filter(|method| method.is_callable()).map(Bound::unbind);
            if method.is_none() && role == "architecture" {
                let kind = object.get_type().qualname()?;
                return Err(PyTypeError::new_err(format!("the architecture {kind} has no method {name}")));
            }
        }
        Ok(Self { role, names, all, failure: failure.clone() })
    }

    /// Calls a method and reads its result. `None` without the method, and after an exception, which ends the run.
    fn call<T>(
        &self,
        method: usize,
        arguments: impl for<'py> IntoPyObject<'py, Target = PyTuple>,
        read: impl FnOnce(&Bound<'_, PyAny>) -> PyResult<T>,
    ) -> Option<T> {
        let function = self.all[method].as_ref().filter(|_| !self.failure.has_failed())?;
        let called = Python::attach(|py| {
            let arguments = arguments.into_pyobject(py).map_err(Into::into)?.into_bound();
            read(&function.bind(py).call1(arguments)?)
        });
        called.map_err(|error| self.failure.set(error)).ok()
    }

    fn number(&self, method: usize, arguments: impl for<'py> IntoPyObject<'py, Target = PyTuple>) -> Option<f64> {
        let name = self.names[method];
        self.call(method, arguments, |returned| self.finite(name, returned))
    }

    fn finite(&self, name: &str, returned: &Bound<'_, PyAny>) -> PyResult<f64> {
        let role = self.role;
        let number: f64 = returned.extract().map_err(|_| {
            let kind = returned.get_type();
            PyTypeError::new_err(format!("{name} of the {role} returned a {kind}, must return a number"))
        })?;
        if number.is_finite() {
            return Ok(number);
        }
        Err(PyValueError::new_err(format!("{name} of the {role} returned {number}, must be finite")))
    }

    fn payload(&self, method: usize, arguments: impl for<'py> IntoPyObject<'py, Target = PyTuple>) -> Payload<f64> {
        let name = self.names[method];
        let read = |returned: &Bound<'_, PyAny>| {
            let wrong = || {
                let (role, kind) = (self.role, returned.get_type());
                PyTypeError::new_err(format!(
                    "{name} of the {role} returned a {kind}, must return up to {PAYLOAD} numbers"
                ))
            };
            let numbers: Vec<f64> = returned.extract().map_err(|_| wrong())?;
            let mut payload = [0.0; PAYLOAD];
            if numbers.len() > PAYLOAD || !numbers.iter().all(|number| number.is_finite()) {
                return Err(wrong());
            }
            payload[..numbers.len()].copy_from_slice(&numbers);
            Ok(payload)
        };
        self.call(method, arguments, read).unwrap_or([0.0; PAYLOAD])
    }
}

struct UserDefinedArchitecture(Methods<2>);

impl Architecture<f64> for UserDefinedArchitecture {
    fn slave_target(&mut self, arrived: &MasterSample<f64>, slave: &AtSlave<f64>) -> f64 {
        let MasterSample { position_m, velocity_m_per_s, hand_force_n, .. } = *arrived;
        let slave = (slave.position_m, slave.velocity_m_per_s, slave.force_n);
        let arguments = (position_m, velocity_m_per_s, hand_force_n, slave.0, slave.1, slave.2);
        self.0.number(0, arguments).unwrap_or(slave.0)
    }

    fn master_force(&mut self, arrived: &ArrivedAtMaster<f64>, master: &AtMaster<f64>) -> f64 {
        let (sample, mode) = (&arrived.sample, arrived.mode.lane(0).code());
        let arrived = (arrived.force_n, sample.position_m, sample.velocity_m_per_s, mode);
        let AtMaster { position_m, velocity_m_per_s, hand_force_n } = *master;
        let arguments = (arrived.0, arrived.1, arrived.2, arrived.3, position_m, velocity_m_per_s, hand_force_n);
        self.0.number(1, arguments).unwrap_or(0.0)
    }
}

struct UserDefinedScheme(Methods<7>);

/// The force, the cost, the work, the position and the velocity at the slave's port.
fn numbers(port: &SlavePort<f64>) -> (f64, f64, f64, f64, f64) {
    let SlavePort { force_n, cost_j_per_m, work_j, position_m, velocity_m_per_s } = *port;
    (force_n, cost_j_per_m, work_j, position_m, velocity_m_per_s)
}

impl PassivityScheme<f64> for UserDefinedScheme {
    fn master_sends(&mut self, displacement_m: f64) -> Payload<f64> {
        self.0.payload(0, (displacement_m,))
    }

    fn receive_position(&mut self, position_m: f64, arrived: &Arrived<f64>, port: &SlavePort<f64>) -> f64 {
        let arguments = (position_m, arrived.payload, arrived.is_fresh, numbers(port));
        self.0.number(1, arguments).unwrap_or(position_m)
    }

    fn limit_reference(&mut self, reference_m: f64, port: &SlavePort<f64>) -> f64 {
        self.0.number(2, (reference_m, numbers(port))).unwrap_or(reference_m)
    }

    fn slave_sends(&mut self) -> Payload<f64> {
        self.0.payload(3, NoArguments)
    }

    fn receive_force(&mut self, force_n: f64, arrived: &Arrived<f64>, velocity_m_per_s: f64) -> f64 {
        let arguments = (force_n, arrived.payload, arrived.is_fresh, velocity_m_per_s);
        self.0.number(4, arguments).unwrap_or(force_n)
    }

    fn limit_force(&mut self, force_n: f64, velocity_m_per_s: f64) -> f64 {
        self.0.number(5, (force_n, velocity_m_per_s)).unwrap_or(force_n)
    }

    fn energies(&self) -> SchemeEnergies<f64> {
        let read = |returned: &Bound<'_, PyAny>| {
            returned.extract::<(Option<f64>, f64, f64)>().map_err(|_| {
                let kind = returned.get_type();
                let must = "(promised_j or None, dissipated_j, refused_j)";
                PyTypeError::new_err(format!("energies of the passivity returned a {kind}, must return {must}"))
            })
        };
        let found = self.0.call(6, NoArguments, read).unwrap_or((None, 0.0, 0.0));
        let (promised_j, dissipated_j, refused_j) = found;
        SchemeEnergies { promised_j, dissipated_j, refused_j }
    }
}

/// No arguments.
struct NoArguments;

impl<'py> IntoPyObject<'py> for NoArguments {
    type Target = PyTuple;
    type Output = Bound<'py, PyTuple>;
    type Error = PyErr;

    fn into_pyobject(self, py: Python<'py>) -> PyResult<Self::Output> {
        Ok(PyTuple::empty(py))
    }
}
