//! The library of a unit, and the common parts of both versions of the standard.
#![allow(unsafe_code, reason = "the library is third-party code, called through pointers")]

use std::ffi::{CStr, CString, c_char, c_void};
use std::path::Path;
use std::sync::{Mutex, PoisonError};

use libloading::Library;

use crate::error::FmuError;
use crate::functions_2::{Callbacks, Functions2};
use crate::functions_3::Functions3;
use crate::version::Version;

pub(crate) type Handle = *mut c_void;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Status {
    /// Successful, possibly with a warning.
    Done,
    /// Failed; the instance may be freed.
    Failed(&'static str),
    /// Failed; no function of the library may be called any more.
    Fatal,
}

impl Status {
    pub(crate) fn of(number: i32) -> Self {
        match number {
            0 | 1 => Self::Done,
            2 => Self::Failed("discard"),
            3 => Self::Failed("error"),
            4 => Self::Fatal,
            5 => Self::Failed("pending"),
            _ => Self::Failed("unknown"),
        }
    }

    fn is_kept(number: i32) -> bool {
        number != 0
    }
}

#[derive(Debug, Default)]
pub(crate) struct Log(Mutex<Vec<String>>);

impl Log {
    /// Keeps a message of the library, up to a maximum number.
    pub(crate) fn keep(&self, status: i32, message: &CStr) {
        const MAX_MESSAGES: usize = 8;
        const MAX_CHARS: usize = 400;
        let mut messages = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if Status::is_kept(status) && messages.len() < MAX_MESSAGES {
            // Sanitise third-party text before printing it.
            let plain = |c: char| if c.is_control() { ' ' } else { c };
            let text: String = message.to_string_lossy().chars().take(MAX_CHARS).map(plain).collect();
            messages.push(text.trim().to_owned());
        }
    }

    pub(crate) fn messages(&self) -> Vec<String> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

pub(crate) struct Birth<'a> {
    pub(crate) token: &'a CStr,
    /// The folder of the resources, absolute.
    pub(crate) resources: &'a Path,
    pub(crate) callbacks: &'a Callbacks,
}

pub(crate) type Values<'a, T> = (&'a [u32], T);

/// The functions of a version of the standard.
///
/// For every method except [`Functions::instantiate`]: `handle` is from [`Functions::instantiate`] of the same library,
/// is not freed, and no other thread uses it at the same time.
#[allow(clippy::missing_safety_doc, reason = "said of all")]
pub(crate) trait Functions: Send + Sync {
    fn instantiate(&self, birth: &Birth<'_>) -> Handle;
    unsafe fn enter_initialisation(&self, handle: Handle) -> i32;
    unsafe fn exit_initialisation(&self, handle: Handle) -> i32;
    /// Also returns true if the unit asks to end the simulation.
    unsafe fn do_step(&self, handle: Handle, time_s: f64, step_s: f64) -> (i32, bool);
    unsafe fn terminate(&self, handle: Handle) -> i32;
    unsafe fn free(&self, handle: Handle);
    unsafe fn set_numbers(&self, handle: Handle, values: Values<'_, &[f64]>) -> i32;
    unsafe fn get_numbers(&self, handle: Handle, values: Values<'_, &mut [f64]>) -> i32;
    unsafe fn set_int32(&self, handle: Handle, reference: u32, value: i32) -> i32;
    unsafe fn get_int32(&self, handle: Handle, reference: u32, value: &mut i32) -> i32;
    unsafe fn set_int64(&self, handle: Handle, reference: u32, value: i64) -> i32;
    unsafe fn get_int64(&self, handle: Handle, reference: u32, value: &mut i64) -> i32;
    unsafe fn set_boolean(&self, handle: Handle, reference: u32, value: bool) -> i32;
    unsafe fn get_boolean(&self, handle: Handle, reference: u32, value: &mut bool) -> i32;
}

pub(crate) struct LoadedLibrary {
    pub(crate) functions: Box<dyn Functions>,
    // Dropped after the functions, which point into it.
    _library: Library,
}

impl LoadedLibrary {
    /// Loads a library, which executes its initialisation.
    pub(crate) fn load(path: &Path, (version, needs_tool): (Version, bool)) -> Result<Self, FmuError> {
        // SAFETY: the user has chosen to run the unit's code.
        let library = unsafe { Library::new(path) };
        let library = library.map_err(|error| {
            // Prefer the message of the system.
            let reason = std::error::Error::source(&error).map_or_else(|| error.to_string(), ToString::to_string);
            FmuError::Library { reason, needs_tool }
        })?;
        let functions: Box<dyn Functions> = match version {
            Version::Two => Box::new(Functions2::of(&library)?),
            Version::Three => Box::new(Functions3::of(&library)?),
        };
        Ok(Self { functions, _library: library })
    }
}

impl std::fmt::Debug for LoadedLibrary {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("LoadedLibrary")
    }
}

/// Looks up a function of a library.
///
/// # Safety
/// `T` must be a pointer to a function with the type that the standard defines for this name.
pub(crate) unsafe fn function<T: Copy>(library: &Library, name: &str) -> Result<T, FmuError> {
    // SAFETY: guaranteed by the caller.
    let found = unsafe { library.get::<T>(name) };
    found.map(|symbol| *symbol).map_err(|_| FmuError::NoFunction(name.to_owned()))
}

/// Converts a text for a library; empty if it contains a NUL.
pub(crate) fn text(text: &str) -> CString {
    CString::new(text).unwrap_or_default()
}

/// # Safety
/// `environment` is a [`Log`], and `message` is null or ends with a NUL.
pub(crate) unsafe fn keep(environment: *const c_void, status: i32, message: *const c_char) {
    // SAFETY: guaranteed by the caller.
    if let Some(log) = unsafe { environment.cast::<Log>().as_ref() }
        && !message.is_null()
    {
        // SAFETY: guaranteed by the caller.
        log.keep(status, unsafe { CStr::from_ptr(message) });
    }
}
