//! The functions of FMI 3.0.
#![allow(unsafe_code, reason = "functions of a third-party library")]

use std::ffi::{c_char, c_void};

use libloading::Library;

use crate::error::FmuError;
use crate::library::{Birth, Functions, Handle, Values, function, keep, text};

unsafe extern "C" fn log_message(
    environment: *const c_void,
    status: i32,
    _category: *const c_char,
    message: *const c_char,
) {
    // SAFETY: the environment is the log that was passed with this function.
    unsafe { keep(environment, status, message) }
}

type Logger = unsafe extern "C" fn(*const c_void, i32, *const c_char, *const c_char);
type Instantiate = unsafe extern "C" fn(
    *const c_char,
    *const c_char,
    *const c_char,
    bool,
    bool,
    bool,
    bool,
    *const u32,
    usize,
    *const c_void,
    Logger,
    *const c_void,
) -> Handle;
type OfInstance = unsafe extern "C" fn(Handle) -> i32;
type Step = unsafe extern "C" fn(Handle, f64, f64, bool, *mut bool, *mut bool, *mut bool, *mut f64) -> i32;
type Set<T> = unsafe extern "C" fn(Handle, *const u32, usize, *const T, usize) -> i32;
type Get<T> = unsafe extern "C" fn(Handle, *const u32, usize, *mut T, usize) -> i32;

/// The functions, which point into their library.
pub(crate) struct Functions3 {
    instantiate: Instantiate,
    free: unsafe extern "C" fn(Handle),
    enter: unsafe extern "C" fn(Handle, bool, f64, f64, bool, f64) -> i32,
    exit: OfInstance,
    terminate: OfInstance,
    step: Step,
    set_float: Set<f64>,
    get_float: Get<f64>,
    set_int32: Set<i32>,
    get_int32: Get<i32>,
    set_int64: Set<i64>,
    get_int64: Get<i64>,
    set_boolean: Set<bool>,
    get_boolean: Get<u8>,
}

impl Functions3 {
    pub(crate) fn of(library: &Library) -> Result<Self, FmuError> {
        // SAFETY: the standard defines the types. Booleans are read as bytes, which may have any value.
        unsafe {
            Ok(Self {
                instantiate: function(library, "fmi3InstantiateCoSimulation")?,
                free: function(library, "fmi3FreeInstance")?,
                enter: function(library, "fmi3EnterInitializationMode")?,
                exit: function(library, "fmi3ExitInitializationMode")?,
                terminate: function(library, "fmi3Terminate")?,
                step: function(library, "fmi3DoStep")?,
                set_float: function(library, "fmi3SetFloat64")?,
                get_float: function(library, "fmi3GetFloat64")?,
                set_int32: function(library, "fmi3SetInt32")?,
                get_int32: function(library, "fmi3GetInt32")?,
                set_int64: function(library, "fmi3SetInt64")?,
                get_int64: function(library, "fmi3GetInt64")?,
                set_boolean: function(library, "fmi3SetBoolean")?,
                get_boolean: function(library, "fmi3GetBoolean")?,
            })
        }
    }
}

impl Functions for Functions3 {
    fn instantiate(&self, birth: &Birth<'_>) -> Handle {
        // The standard requires a separator at the end.
        let path = text(&birth.resources.join("").to_string_lossy());
        // SAFETY: the texts end with a NUL, and the log outlives the instance.
        unsafe {
            (self.instantiate)(
                c"tissue".as_ptr(),
                birth.token.as_ptr(),
                path.as_ptr(),
                false,
                false,
                false,
                false,
                std::ptr::null(),
                0,
                birth.callbacks.environment,
                log_message,
                std::ptr::null(),
            )
        }
    }

    unsafe fn enter_initialisation(&self, handle: Handle) -> i32 {
        // SAFETY: `handle` is a valid instance (trait contract).
        unsafe { (self.enter)(handle, false, 0.0, 0.0, false, 0.0) }
    }

    unsafe fn exit_initialisation(&self, handle: Handle) -> i32 {
        // SAFETY: `handle` is a valid instance (trait contract).
        unsafe { (self.exit)(handle) }
    }

    unsafe fn do_step(&self, handle: Handle, time_s: f64, step_s: f64) -> (i32, bool) {
        let (mut event, mut ends, mut is_early, mut last_s) = (0_u8, 0_u8, 0_u8, time_s);
        // SAFETY: `handle` is a valid instance (trait contract); booleans are bytes.
        let status = unsafe {
            (self.step)(
                handle,
                time_s,
                step_s,
                true,
                (&raw mut event).cast(),
                (&raw mut ends).cast(),
                (&raw mut is_early).cast(),
                &raw mut last_s,
            )
        };
        // An early return is not allowed, so it also ends the simulation.
        (status, ends != 0 || is_early != 0)
    }

    unsafe fn terminate(&self, handle: Handle) -> i32 {
        // SAFETY: `handle` is a valid instance (trait contract).
        unsafe { (self.terminate)(handle) }
    }

    unsafe fn free(&self, handle: Handle) {
        // SAFETY: `handle` is a valid instance (trait contract).
        unsafe { (self.free)(handle) }
    }

    unsafe fn set_numbers(&self, handle: Handle, (references, values): Values<'_, &[f64]>) -> i32 {
        let count = references.len().min(values.len());
        // SAFETY: `handle` is a valid instance (trait contract); the count is within both lists.
        unsafe { (self.set_float)(handle, references.as_ptr(), count, values.as_ptr(), count) }
    }

    unsafe fn get_numbers(&self, handle: Handle, (references, values): Values<'_, &mut [f64]>) -> i32 {
        let count = references.len().min(values.len());
        // SAFETY: `handle` is a valid instance (trait contract); the count is within both lists.
        unsafe { (self.get_float)(handle, references.as_ptr(), count, values.as_mut_ptr(), count) }
    }

    unsafe fn set_int32(&self, handle: Handle, reference: u32, value: i32) -> i32 {
        // SAFETY: `handle` is a valid instance (trait contract); `value` points to one number.
        unsafe { (self.set_int32)(handle, &raw const reference, 1, &raw const value, 1) }
    }

    unsafe fn get_int32(&self, handle: Handle, reference: u32, value: &mut i32) -> i32 {
        // SAFETY: `handle` is a valid instance (trait contract); `value` points to one number.
        unsafe { (self.get_int32)(handle, &raw const reference, 1, &raw mut *value, 1) }
    }

    unsafe fn set_int64(&self, handle: Handle, reference: u32, value: i64) -> i32 {
        // SAFETY: `handle` is a valid instance (trait contract); `value` points to one number.
        unsafe { (self.set_int64)(handle, &raw const reference, 1, &raw const value, 1) }
    }

    unsafe fn get_int64(&self, handle: Handle, reference: u32, value: &mut i64) -> i32 {
        // SAFETY: `handle` is a valid instance (trait contract); `value` points to one number.
        unsafe { (self.get_int64)(handle, &raw const reference, 1, &raw mut *value, 1) }
    }

    unsafe fn set_boolean(&self, handle: Handle, reference: u32, value: bool) -> i32 {
        // SAFETY: `handle` is a valid instance (trait contract); `value` points to one Boolean.
        unsafe { (self.set_boolean)(handle, &raw const reference, 1, &raw const value, 1) }
    }

    unsafe fn get_boolean(&self, handle: Handle, reference: u32, value: &mut bool) -> i32 {
        let mut byte = 0;
        // SAFETY: `handle` is a valid instance (trait contract); `byte` is one byte.
        let status = unsafe { (self.get_boolean)(handle, &raw const reference, 1, &raw mut byte, 1) };
        *value = byte != 0;
        status
    }
}
