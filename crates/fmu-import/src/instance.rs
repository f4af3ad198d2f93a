#![allow(unsafe_code, reason = "calls with the pointer to the instance")]

use std::sync::Arc;
use std::sync::atomic::Ordering;

use crate::description::{Type, Variable};
use crate::error::FmuError;
use crate::fmu::Fmu;
use crate::functions_2::Callbacks;
use crate::library::{Birth, Functions, Handle, Log, Status, text};

/// A running instance. Dropping it terminates and frees it.
pub struct Instance {
    handle: Handle,
    log: Arc<Log>,
    // The instance may call these until it is freed.
    _callbacks: Box<Callbacks>,
    fmu: Arc<Fmu>,
    state: State,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    New,
    Running,
    Failed,
    /// No function may be called any more.
    Fatal,
}

// SAFETY: by the standard any thread may use an instance, one at a time: `Instance` is not `Sync`.
unsafe impl Send for Instance {}

impl Instance {
    /// Creates an instance in initialisation, with some variables set. Inputs may be set next.
    ///
    /// # Errors
    /// [`FmuError`] if the library cannot be loaded, the unit's only allowed instance exists, or a call fails.
    pub fn new(fmu: &Arc<Fmu>, settings: &[(Variable, f64)]) -> Result<Self, FmuError> {
        let library = fmu.library()?;
        let description = fmu.description();
        if description.is_single && fmu.is_taken.swap(true, Ordering::AcqRel) {
            return Err(FmuError::OneInstance);
        }
        let log = Arc::new(Log::default());
        let callbacks = Callbacks::new(&log);
        let token = text(&description.token);
        let resources = fmu.resources();
        let handle =
            library.functions.instantiate(&Birth { token: &token, resources: &resources, callbacks: &callbacks });
        if handle.is_null() {
            fmu.is_taken.store(false, Ordering::Release);
            return Err(FmuError::NoInstance { needs_tool: description.needs_tool, messages: log.messages() });
        }
        let mut instance = Self { handle, log, _callbacks: callbacks, fmu: Arc::clone(fmu), state: State::New };
        for (variable, value) in settings {
            instance.set(variable, *value)?;
        }
        // SAFETY: see `call`.
        instance.call("the initialisation", |functions, handle| unsafe { functions.enter_initialisation(handle) })?;
        Ok(instance)
    }

    /// Ends the initialisation, so that steps are allowed.
    ///
    /// # Errors
    /// [`FmuError::Call`].
    pub fn start(&mut self) -> Result<(), FmuError> {
        // SAFETY: see `call`.
        self.call("the end of the initialisation", |functions, handle| unsafe {
            functions.exit_initialisation(handle)
        })?;
        self.state = State::Running;
        Ok(())
    }

    /// Steps from `time_s` to `time_s + step_s` (s).
    ///
    /// # Errors
    /// [`FmuError::Call`], also for a discarded step; [`FmuError::Ended`].
    pub fn step(&mut self, time_s: f64, step_s: f64) -> Result<(), FmuError> {
        let mut ends = false;
        self.call("doStep", |functions, handle| {
            // SAFETY: see `call`.
            let (status, asks) = unsafe { functions.do_step(handle, time_s, step_s) };
            ends = asks;
            status
        })?;
        if ends { Err(FmuError::Ended { messages: self.log.messages() }) } else { Ok(()) }
    }

    /// Sets numbers by their references. Both lists must have the same length.
    ///
    /// # Errors
    /// [`FmuError::Call`].
    pub fn set_numbers(&mut self, references: &[u32], values: &[f64]) -> Result<(), FmuError> {
        // SAFETY: see `call`.
        self.call("setting inputs", |functions, handle| unsafe { functions.set_numbers(handle, (references, values)) })
    }

    /// Reads numbers by their references. Both lists must have the same length.
    ///
    /// # Errors
    /// [`FmuError::Call`].
    pub fn get_numbers(&mut self, references: &[u32], values: &mut [f64]) -> Result<(), FmuError> {
        // SAFETY: see `call`.
        self.call("reading outputs", |functions, handle| unsafe { functions.get_numbers(handle, (references, values)) })
    }

    /// Sets a variable of any type. The value must suit the type (see [`Type::takes`]).
    fn set(&mut self, variable: &Variable, value: f64) -> Result<(), FmuError> {
        let reference = variable.reference;
        let outcome = self.call("setting parameters", |functions, handle| {
            // SAFETY: see `call`.
            unsafe {
                match variable.kind {
                    Some(Type::Real) => functions.set_numbers(handle, (&[reference], &[value])),
                    Some(Type::Int32) => functions.set_int32(handle, reference, value as i32),
                    Some(Type::Int64) => functions.set_int64(handle, reference, value as i64),
                    Some(Type::Boolean) => functions.set_boolean(handle, reference, value != 0.0),
                    None => 0,
                }
            }
        });
        outcome.map_err(|error| match error {
            FmuError::Call { messages, .. } => FmuError::Variable {
                name: variable.name.clone(),
                problem: format!("cannot be set to {value}{}", crate::error::reported(&messages)),
            },
            other => other,
        })
    }

    /// True if a variable of any type is not 0.
    ///
    /// # Errors
    /// [`FmuError::Call`].
    pub fn is_set(&mut self, variable: &Variable) -> Result<bool, FmuError> {
        let (reference, mut is_set) = (variable.reference, false);
        self.call("reading outputs", |functions, handle| {
            let (mut number, mut narrow, mut wide) = ([0.0], 0, 0);
            // SAFETY: see `call`.
            unsafe {
                let status = match variable.kind {
                    Some(Type::Real) => functions.get_numbers(handle, (&[reference], &mut number)),
                    Some(Type::Int32) => functions.get_int32(handle, reference, &mut narrow),
                    Some(Type::Int64) => functions.get_int64(handle, reference, &mut wide),
                    Some(Type::Boolean) => functions.get_boolean(handle, reference, &mut is_set),
                    None => 0,
                };
                is_set |= number != [0.0] || narrow != 0 || wide != 0;
                status
            }
        })?;
        Ok(is_set)
    }

    /// Calls a function and checks its status. The handle belongs to this library, is not freed, and is used by no
    /// other thread.
    fn call(
        &mut self,
        function: &'static str,
        call: impl FnOnce(&dyn Functions, Handle) -> i32,
    ) -> Result<(), FmuError> {
        let messages = |log: &Log| log.messages();
        if matches!(self.state, State::Failed | State::Fatal) {
            return Err(FmuError::Call { function, status: "error", messages: messages(&self.log) });
        }
        let functions = &self.fmu.library()?.functions;
        let status = match Status::of(call(&**functions, self.handle)) {
            Status::Done => return Ok(()),
            Status::Failed(word) => {
                self.state = State::Failed;
                word
            }
            Status::Fatal => {
                self.state = State::Fatal;
                "fatal"
            }
        };
        Err(FmuError::Call { function, status, messages: messages(&self.log) })
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        if self.state == State::Fatal {
            // After a fatal error no function may be called. A unit with one instance stays taken.
            return;
        }
        if let Ok(library) = self.fmu.library() {
            // SAFETY: an instance of this library, not used afterwards.
            unsafe {
                if self.state == State::Running {
                    library.functions.terminate(self.handle);
                }
                library.functions.free(self.handle);
            }
        }
        self.fmu.is_taken.store(false, Ordering::Release);
    }
}

impl std::fmt::Debug for Instance {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Instance").field("fmu", &self.fmu.path()).field("state", &self.state).finish()
    }
}

impl Type {
    /// True if a number is a value of this type: a whole number in its range; 0 or 1 for booleans.
    #[must_use]
    pub fn takes(self, value: f64) -> bool {
        let is_whole_within = |limit: f64| value.fract() == 0.0 && value >= -limit && value < limit;
        match self {
            Self::Real => value.is_finite(),
            Self::Int32 => is_whole_within(f64::from(1_u32 << 31)),
            Self::Int64 => is_whole_within(9e15),
            Self::Boolean => value == 0.0 || value == 1.0,
        }
    }
}
