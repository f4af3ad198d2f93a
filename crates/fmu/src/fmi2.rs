#![allow(unsafe_code, reason = "names and pointers are the standard's")]

use std::ffi::{CStr, CString, c_char, c_void};

use crate::state::SavedState;
use trocar_studies::fmu::Scalar;

use crate::component::{Component, ERROR, OK, folder_of_uri, text};

type Logger = unsafe extern "C" fn(*mut c_void, *const c_char, i32, *const c_char, *const c_char, ...);

/// The unit does not use the memory functions.
#[repr(C)]
pub struct Callbacks {
    logger: Option<Logger>,
    allocate_memory: *const c_void,
    free_memory: *const c_void,
    step_finished: *const c_void,
    environment: *mut c_void,
}

#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetTypesPlatform() -> *const c_char {
    c"default".as_ptr()
}

#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetVersion() -> *const c_char {
    c"2.0".as_ptr()
}

/// # Safety
/// As in the standard.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Instantiate(
    name: *const c_char,
    kind: i32,
    guid: *const c_char,
    resources: *const c_char,
    callbacks: *const Callbacks,
    _visible: i32,
    _logging_on: i32,
) -> *mut Component {
    const CO_SIMULATION: i32 = 1;
    // SAFETY: by the standard the texts end with a NUL, and the callbacks stay valid.
    let (name, guid, resources, callbacks) = unsafe { (text(name), text(guid), text(resources), callbacks.as_ref()) };
    let (logger, environment) = callbacks.map_or((None, std::ptr::null_mut()), |all| (all.logger, all.environment));
    let name = CString::new(name).unwrap_or_default();
    let log = move |message: &CStr| {
        // The message is a printf format without arguments, so escape `%`.
        let format = CString::new(message.to_string_lossy().replace('%', "%%")).unwrap_or_default();
        if let Some(logger) = logger {
            // SAFETY: the importing program's function has these arguments.
            unsafe { logger(environment, name.as_ptr(), ERROR, c"logStatusError".as_ptr(), format.as_ptr()) };
        }
    };
    if kind != CO_SIMULATION {
        log(c"this unit is for co-simulation");
        return std::ptr::null_mut();
    }
    Component::new(folder_of_uri(&resources), &guid, Box::new(log))
}

/// # Safety
/// As in the standard.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeInstance(component: *mut Component) {
    // SAFETY: from `fmi2Instantiate`.
    unsafe { Component::free(component) }
}

/// # Safety
/// As in the standard.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Reset(component: *mut Component) -> i32 {
    // SAFETY: from `fmi2Instantiate`.
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
pub unsafe extern "C" fn fmi2ExitInitializationMode(component: *mut Component) -> i32 {
    // SAFETY: from `fmi2Instantiate`.
    unsafe { Component::call(component, |instance| instance.initialise()) }
}

/// # Safety
/// As in the standard.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DoStep(
    component: *mut Component,
    time_s: f64,
    step_s: f64,
    _no_set_state_prior: i32,
) -> i32 {
    // SAFETY: from `fmi2Instantiate`.
    unsafe { Component::call(component, |instance| instance.step(time_s, step_s)) }
}

/// `fmi2LastSuccessfulTime`.
const LAST_SUCCESSFUL_TIME: i32 = 2;
/// `fmi2Terminated`.
const TERMINATED: i32 = 3;

/// After a discarded step: the end of its last tick.
///
/// # Safety
/// As in the standard.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetRealStatus(component: *mut Component, kind: i32, value: *mut f64) -> i32 {
    // SAFETY: from `fmi2Instantiate`; the value is null or writable.
    let (time_s, value) = unsafe { (Component::progress(component).0, value.as_mut()) };
    match (kind, time_s, value) {
        (LAST_SUCCESSFUL_TIME, Some(time_s), Some(value)) => {
            *value = time_s;
            OK
        }
        _ => ERROR,
    }
}

/// After a discarded step: true if the scenario has ended.
///
/// # Safety
/// As in the standard.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetBooleanStatus(component: *mut Component, kind: i32, value: *mut i32) -> i32 {
    // SAFETY: from `fmi2Instantiate`; the value is null or writable.
    let (has_ended, value) = unsafe { (Component::progress(component).1, value.as_mut()) };
    match (kind, value) {
        (TERMINATED, Some(value)) => {
            *value = i32::from(has_ended);
            OK
        }
        _ => ERROR,
    }
}

/// # Safety
/// As in the standard.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetFMUstate(component: *mut Component, state: *mut *mut SavedState) -> i32 {
    // SAFETY: the instance is from the instantiation, the state is null or from this unit.
    unsafe { Component::save(component, state) }
}

/// # Safety
/// As in the standard.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetFMUstate(component: *mut Component, state: *const SavedState) -> i32 {
    // SAFETY: the instance is from the instantiation, the state is from this unit.
    unsafe { Component::restore(component, state) }
}

/// # Safety
/// As in the standard.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeFMUstate(_component: *mut Component, state: *mut *mut SavedState) -> i32 {
    // SAFETY: null or a state from this unit.
    unsafe { Component::free_state(state) }
}

macro_rules! values {
    ($($get:ident, $set:ident, $value:ty, $kind:literal, $read:expr, $scalar:expr;)*) => {$(
        /// # Safety
        /// As in the standard.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $get(component: *mut Component, references: *const u32, count: usize, values: *mut $value) -> i32 {
            // SAFETY: by the standard both lists have this length.
            unsafe { Component::get(component, (references, values, count), $kind, $read) }
        }

        /// # Safety
        /// As in the standard.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $set(component: *mut Component, references: *const u32, count: usize, values: *const $value) -> i32 {
            // SAFETY: by the standard both lists have this length.
            unsafe { Component::set(component, (references, values, count), $kind, $scalar) }
        }
    )*};
}

fn real(value: Scalar) -> Option<f64> {
    if let Scalar::Real(value) = value { Some(value) } else { None }
}

fn integer(value: Scalar) -> Option<i32> {
    if let Scalar::Integer(value) = value { i32::try_from(value).ok() } else { None }
}

fn boolean(value: Scalar) -> Option<i32> {
    if let Scalar::Boolean(value) = value { Some(i32::from(value)) } else { None }
}

values! {
    fmi2GetReal, fmi2SetReal, f64, "Real", real, Scalar::Real;
    fmi2GetInteger, fmi2SetInteger, i32, "Integer", integer, |value| Scalar::Integer(i64::from(value));
    fmi2GetBoolean, fmi2SetBoolean, i32, "Boolean", boolean, |value| Scalar::Boolean(value != 0);
}

/// No variable is a text: only empty lists succeed.
macro_rules! texts {
    ($($name:ident)*) => {$(
        #[unsafe(no_mangle)]
        pub extern "C" fn $name(_: *mut Component, _: *const u32, count: usize, _: *const c_void) -> i32 {
            if count == 0 { OK } else { ERROR }
        }
    )*};
}

texts! { fmi2GetString fmi2SetString }

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
    OK: fmi2SetDebugLogging fmi2SetupExperiment fmi2EnterInitializationMode fmi2Terminate;
    ERROR: fmi2SerializedFMUstateSize fmi2SerializeFMUstate
        fmi2DeSerializeFMUstate fmi2GetDirectionalDerivative fmi2SetRealInputDerivatives fmi2GetRealOutputDerivatives
        fmi2CancelStep fmi2GetStatus fmi2GetIntegerStatus fmi2GetStringStatus;
}
