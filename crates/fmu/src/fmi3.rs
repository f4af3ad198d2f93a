#![allow(unsafe_code, reason = "names and pointers are the standard's")]

use std::ffi::{CStr, c_char, c_void};
use std::path::PathBuf;

use crate::state::SavedState;
use trocar_studies::fmu::Scalar;

use crate::component::{Component, ERROR, OK, text};

type Logger = unsafe extern "C" fn(*mut c_void, i32, *const c_char, *const c_char);

#[unsafe(no_mangle)]
pub extern "C" fn fmi3GetVersion() -> *const c_char {
    c"3.0".as_ptr()
}

/// # Safety
/// As in the standard.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateCoSimulation(
    _name: *const c_char,
    token: *const c_char,
    resources: *const c_char,
    _visible: bool,
    _logging_on: bool,
    _event_mode_used: bool,
    _early_return_allowed: bool,
    _required_intermediate: *const u32,
    _required_count: usize,
    environment: *mut c_void,
    logger: Option<Logger>,
    _intermediate_update: *const c_void,
) -> *mut Component {
    // SAFETY: by the standard the texts end with a NUL.
    let (token, resources) = unsafe { (text(token), text(resources)) };
    let log = move |message: &CStr| {
        if let Some(logger) = logger {
            // SAFETY: the importing program's function has these arguments.
            unsafe { logger(environment, ERROR, c"logStatusError".as_ptr(), message.as_ptr()) };
        }
    };
    Component::new((!resources.is_empty()).then(|| PathBuf::from(resources)), &token, Box::new(log))
}

/// # Safety
/// As in the standard.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeInstance(component: *mut Component) {
    // SAFETY: from `fmi3InstantiateCoSimulation`.
    unsafe { Component::free(component) }
}

/// # Safety
/// As in the standard.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3Reset(component: *mut Component) -> i32 {
    // SAFETY: from `fmi3InstantiateCoSimulation`.
    unsafe {
        Component::call(component, |instance| {
            instance.reset();
            Ok(())
        })
    }
}

/// # Safety
/// As in the standard.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3ExitInitializationMode(component: *mut Component) -> i32 {
    // SAFETY: from `fmi3InstantiateCoSimulation`.
    unsafe { Component::call(component, |instance| instance.initialise()) }
}

/// # Safety
/// As in the standard.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3DoStep(
    component: *mut Component,
    time_s: f64,
    step_s: f64,
    _no_set_state_prior: bool,
    event_needed: *mut bool,
    terminate: *mut bool,
    early_return: *mut bool,
    last_time_s: *mut f64,
) -> i32 {
    // SAFETY: the instance is from `fmi3InstantiateCoSimulation`; the results are null or writable.
    unsafe {
        for result in [event_needed, terminate, early_return] {
            if let Some(result) = result.as_mut() {
                *result = false;
            }
        }
        let status = Component::call(component, |instance| instance.step(time_s, step_s));
        let (end_s, has_ended) = Component::progress(component);
        if let Some(terminate) = terminate.as_mut() {
            *terminate = has_ended;
        }
        if let Some(last) = last_time_s.as_mut() {
            *last = match status {
                OK => time_s + step_s,
                _ => end_s.unwrap_or(time_s),
            };
        }
        status
    }
}

/// # Safety
/// As in the standard.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetFMUState(component: *mut Component, state: *mut *mut SavedState) -> i32 {
    // SAFETY: the instance is from the instantiation, the state is null or from this unit.
    unsafe { Component::save(component, state) }
}

/// # Safety
/// As in the standard.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetFMUState(component: *mut Component, state: *const SavedState) -> i32 {
    // SAFETY: the instance is from the instantiation, the state is from this unit.
    unsafe { Component::restore(component, state) }
}

/// # Safety
/// As in the standard.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeFMUState(_component: *mut Component, state: *mut *mut SavedState) -> i32 {
    // SAFETY: null or a state from this unit.
    unsafe { Component::free_state(state) }
}

macro_rules! values {
    ($($get:ident, $set:ident, $value:ty, $kind:literal, $read:expr, $scalar:expr;)*) => {$(
        /// # Safety
        /// As in the standard.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $get(
            component: *mut Component,
            references: *const u32,
            count: usize,
            values: *mut $value,
            value_count: usize,
        ) -> i32 {
            if value_count != count {
                return ERROR;
            }
            // SAFETY: by the standard both lists have this length.
            unsafe { Component::get(component, (references, values, count), $kind, $read) }
        }

        /// # Safety
        /// As in the standard.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $set(
            component: *mut Component,
            references: *const u32,
            count: usize,
            values: *const $value,
            value_count: usize,
        ) -> i32 {
            if value_count != count {
                return ERROR;
            }
            // SAFETY: by the standard both lists have this length.
            unsafe { Component::set(component, (references, values, count), $kind, $scalar) }
        }
    )*};
}

fn float(value: Scalar) -> Option<f64> {
    if let Scalar::Real(value) = value { Some(value) } else { None }
}

fn whole(value: Scalar) -> Option<i64> {
    if let Scalar::Integer(value) = value { Some(value) } else { None }
}

fn boolean(value: Scalar) -> Option<bool> {
    if let Scalar::Boolean(value) = value { Some(value) } else { None }
}

values! {
    fmi3GetFloat64, fmi3SetFloat64, f64, "Float64", float, Scalar::Real;
    fmi3GetInt64, fmi3SetInt64, i64, "Int64", whole, Scalar::Integer;
    fmi3GetBoolean, fmi3SetBoolean, bool, "Boolean", boolean, Scalar::Boolean;
}

/// Functions without an effect here, or excluded by the description: a constant status.
macro_rules! constant {
    ($($status:ident: $($name:ident)*;)*) => {$($(
        #[unsafe(no_mangle)]
        pub extern "C" fn $name() -> i32 {
            $status
        }
    )*)*};
}

constant! {
    OK: fmi3SetDebugLogging fmi3EnterInitializationMode fmi3Terminate;
    ERROR: fmi3EnterEventMode fmi3EnterStepMode fmi3EnterConfigurationMode fmi3ExitConfigurationMode
        fmi3GetFloat32 fmi3SetFloat32 fmi3GetInt8 fmi3SetInt8 fmi3GetUInt8 fmi3SetUInt8 fmi3GetInt16 fmi3SetInt16
        fmi3GetUInt16 fmi3SetUInt16 fmi3GetInt32 fmi3SetInt32 fmi3GetUInt32 fmi3SetUInt32 fmi3GetUInt64 fmi3SetUInt64
        fmi3GetString fmi3SetString fmi3GetBinary fmi3SetBinary fmi3GetClock fmi3SetClock
        fmi3GetNumberOfVariableDependencies fmi3GetVariableDependencies
        fmi3SerializedFMUStateSize fmi3SerializeFMUState fmi3DeserializeFMUState fmi3GetDirectionalDerivative
        fmi3GetAdjointDerivative fmi3GetIntervalDecimal fmi3GetIntervalFraction fmi3GetShiftDecimal fmi3GetShiftFraction
        fmi3SetIntervalDecimal fmi3SetIntervalFraction fmi3SetShiftDecimal fmi3SetShiftFraction fmi3EvaluateDiscreteStates
        fmi3UpdateDiscreteStates fmi3EnterContinuousTimeMode fmi3CompletedIntegratorStep fmi3SetTime
        fmi3SetContinuousStates fmi3GetContinuousStateDerivatives fmi3GetEventIndicators fmi3GetContinuousStates
        fmi3GetNominalsOfContinuousStates fmi3GetNumberOfEventIndicators fmi3GetNumberOfContinuousStates
        fmi3GetOutputDerivatives fmi3ActivateModelPartition;
}

/// Kinds of instances that the description excludes: null.
macro_rules! no_instance {
    ($($name:ident)*) => {$(
        #[unsafe(no_mangle)]
        pub extern "C" fn $name() -> *mut Component {
            std::ptr::null_mut()
        }
    )*};
}

no_instance! { fmi3InstantiateModelExchange fmi3InstantiateScheduledExecution }
