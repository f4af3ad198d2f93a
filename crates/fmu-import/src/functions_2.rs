//! The functions of FMI 2.0.
#![allow(unsafe_code, reason = "functions of a third-party library")]

use std::ffi::{c_char, c_void};
use std::sync::Arc;

use libloading::Library;

use crate::error::FmuError;
use crate::library::{Birth, Functions, Handle, Log, Values, function, keep, text};

unsafe extern "C" {
    fn calloc(count: usize, bytes: usize) -> *mut c_void;
    fn free(memory: *mut c_void);
}

#[repr(C)]
pub(crate) struct Callbacks {
    logger: unsafe extern "C" fn(*const c_void, *const c_char, i32, *const c_char, *const c_char),
    allocate_memory: unsafe extern "C" fn(usize, usize) -> *mut c_void,
    free_memory: unsafe extern "C" fn(*mut c_void),
    step_finished: *const c_void,
    pub(crate) environment: *const c_void,
}

impl Callbacks {
    pub(crate) fn new(log: &Arc<Log>) -> Box<Self> {
        Box::new(Self {
            logger: log_message,
            allocate_memory: calloc,
            free_memory: free,
            step_finished: std::ptr::null(),
            environment: Arc::as_ptr(log).cast(),
        })
    }
}

/// Keeps a message. The further arguments for the message's format are not read, and the format is kept unchanged.
unsafe extern "C" fn log_message(
    environment: *const c_void,
    _instance: *const c_char,
    status: i32,
    _category: *const c_char,
    message: *const c_char,
) {
    // SAFETY: the environment is the log that was passed with this function.
    unsafe { keep(environment, status, message) }
}

type Instantiate =
    unsafe extern "C" fn(*const c_char, i32, *const c_char, *const c_char, *const Callbacks, i32, i32) -> Handle;
type OfInstance = unsafe extern "C" fn(Handle) -> i32;
type Set<T> = unsafe extern "C" fn(Handle, *const u32, usize, *const T) -> i32;
type Get<T> = unsafe extern "C" fn(Handle, *const u32, usize, *mut T) -> i32;

/// The functions, which point into their library.
pub(crate) struct Functions2 {
    instantiate: Instantiate,
    free: unsafe extern "C" fn(Handle),
    setup: unsafe extern "C" fn(Handle, i32, f64, f64, i32, f64) -> i32,
    enter: OfInstance,
    exit: OfInstance,
    terminate: OfInstance,
    step: unsafe extern "C" fn(Handle, f64, f64, i32) -> i32,
    set_real: Set<f64>,
    get_real: Get<f64>,
    set_integer: Set<i32>,
    get_integer: Get<i32>,
    set_boolean: Set<i32>,
    get_boolean: Get<i32>,
}

impl Functions2 {
    pub(crate) fn of(library: &Library) -> Result<Self, FmuError> {
        // SAFETY: the types are defined by the standard.
        unsafe {
            Ok(Self {
                instantiate: function(library, "fmi2Instantiate")?,
                free: function(library, "fmi2FreeInstance")?,
                setup: function(library, "fmi2SetupExperiment")?,
                enter: function(library, "fmi2EnterInitializationMode")?,
                exit: function(library, "fmi2ExitInitializationMode")?,
                terminate: function(library, "fmi2Terminate")?,
                step: function(library, "fmi2DoStep")?,
                set_real: function(library, "fmi2SetReal")?,
                get_real: function(library, "fmi2GetReal")?,
                set_integer: function(library, "fmi2SetInteger")?,
                get_integer: function(library, "fmi2GetInteger")?,
                set_boolean: function(library, "fmi2SetBoolean")?,
                get_boolean: function(library, "fmi2GetBoolean")?,
            })
        }
    }
}

fn uri(folder: &std::path::Path) -> String {
    let path = folder.to_string_lossy().replace('\\', "/");
    let mut uri = String::from(if path.starts_with('/') { "file://" } else { "file:///" });
    for byte in path.bytes() {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'/' | b'-' | b'_' | b'.' | b'~' | b':' => uri.push(byte.into()),
            other => uri.push_str(&format!("%{other:02X}")),
        }
    }
    uri
}

impl Functions for Functions2 {
    fn instantiate(&self, birth: &Birth<'_>) -> Handle {
        const CO_SIMULATION: i32 = 1;
        let location = text(&uri(birth.resources));
        // SAFETY: the texts end with a NUL, and the callbacks outlive the instance.
        unsafe {
            (self.instantiate)(
                c"tissue".as_ptr(),
                CO_SIMULATION,
                birth.token.as_ptr(),
                location.as_ptr(),
                birth.callbacks,
                0,
                0,
            )
        }
    }

    unsafe fn enter_initialisation(&self, handle: Handle) -> i32 {
        // SAFETY: `handle` is a valid instance (trait contract).
        unsafe {
            match (self.setup)(handle, 0, 0.0, 0.0, 0, 0.0) {
                0 | 1 => (self.enter)(handle),
                failed => failed,
            }
        }
    }

    unsafe fn exit_initialisation(&self, handle: Handle) -> i32 {
        // SAFETY: `handle` is a valid instance (trait contract).
        unsafe { (self.exit)(handle) }
    }

    unsafe fn do_step(&self, handle: Handle, time_s: f64, step_s: f64) -> (i32, bool) {
        // SAFETY: `handle` is a valid instance (trait contract).
        (unsafe { (self.step)(handle, time_s, step_s, 1) }, false)
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
        // SAFETY: `handle` is a valid instance (trait contract); the count is within both lists.
        unsafe { (self.set_real)(handle, references.as_ptr(), references.len().min(values.len()), values.as_ptr()) }
    }

    unsafe fn get_numbers(&self, handle: Handle, (references, values): Values<'_, &mut [f64]>) -> i32 {
        // SAFETY: `handle` is a valid instance (trait contract); the count is within both lists.
        unsafe { (self.get_real)(handle, references.as_ptr(), references.len().min(values.len()), values.as_mut_ptr()) }
    }

    unsafe fn set_int32(&self, handle: Handle, reference: u32, value: i32) -> i32 {
        // SAFETY: `handle` is a valid instance (trait contract); `value` points to one number.
        unsafe { (self.set_integer)(handle, &raw const reference, 1, &raw const value) }
    }

    unsafe fn get_int32(&self, handle: Handle, reference: u32, value: &mut i32) -> i32 {
        // SAFETY: `handle` is a valid instance (trait contract); `value` points to one number.
        unsafe { (self.get_integer)(handle, &raw const reference, 1, &raw mut *value) }
    }

    unsafe fn set_int64(&self, handle: Handle, reference: u32, value: i64) -> i32 {
        const ERROR: i32 = 3;
        // SAFETY: `handle` is a valid instance (trait contract).
        i32::try_from(value).map_or(ERROR, |value| unsafe { self.set_int32(handle, reference, value) })
    }

    unsafe fn get_int64(&self, handle: Handle, reference: u32, value: &mut i64) -> i32 {
        let mut narrow = 0;
        // SAFETY: `handle` is a valid instance (trait contract).
        let status = unsafe { self.get_int32(handle, reference, &mut narrow) };
        *value = narrow.into();
        status
    }

    unsafe fn set_boolean(&self, handle: Handle, reference: u32, value: bool) -> i32 {
        let value = i32::from(value);
        // SAFETY: `handle` is a valid instance (trait contract); `value` points to one number.
        unsafe { (self.set_boolean)(handle, &raw const reference, 1, &raw const value) }
    }

    unsafe fn get_boolean(&self, handle: Handle, reference: u32, value: &mut bool) -> i32 {
        let mut number = 0;
        // SAFETY: `handle` is a valid instance (trait contract); `number` is one number.
        let status = unsafe { (self.get_boolean)(handle, &raw const reference, 1, &raw mut number) };
        *value = number != 0;
        status
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_is_a_uri() {
        let of = |path: &str| uri(std::path::Path::new(path));
        assert_eq!(of("/tmp/a unit/resources"), "file:///tmp/a%20unit/resources");
        assert_eq!(of("C:\\units\\µ"), "file:///C:/units/%C2%B5");
    }
}
