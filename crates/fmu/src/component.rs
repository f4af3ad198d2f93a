//! Instances in the calls of both versions of the standard.

use std::ffi::{CStr, CString, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

use crate::instance::{Instance, InstanceError};
use crate::state::SavedState;
use trocar_studies::fmu::Scalar;

pub const OK: i32 = 0;
/// The step was not done to its end.
pub const DISCARD: i32 = 2;
pub const ERROR: i32 = 3;

pub type Log = Box<dyn Fn(&CStr)>;

pub struct Component {
    instance: Instance,
    log: Log,
}

fn report(log: &Log, message: &str) {
    let message = CString::new(message).unwrap_or_else(|_| c"an error without a text".to_owned());
    log(&message);
}

impl Component {
    /// Null on failure.
    pub fn new(resources: Option<PathBuf>, token: &str, log: Log) -> *mut Self {
        let load = || match &resources {
            Some(folder) => Instance::load(folder, token).map_err(|error| error.to_string()),
            None => Err("the location of the resources is not a folder on this machine: unpack the unit".to_owned()),
        };
        match catch_unwind(AssertUnwindSafe(load)) {
            Ok(Ok(instance)) => Box::into_raw(Box::new(Self { instance, log })),
            Ok(Err(message)) => {
                report(&log, &message);
                std::ptr::null_mut()
            }
            Err(_) => std::ptr::null_mut(),
        }
    }

    /// # Safety
    /// `component` is null or from [`Component::new`], and not used afterwards.
    #[allow(unsafe_code, reason = "the importing program holds the instance as a pointer")]
    pub unsafe fn free(component: *mut Self) {
        if !component.is_null() {
            // SAFETY: it was created by `Box::into_raw` and is freed once.
            drop(unsafe { Box::from_raw(component) });
        }
    }

    /// # Safety
    /// `component` is null or from [`Component::new`], and no other call uses it at the same time.
    #[allow(unsafe_code, reason = "the importing program holds the instance as a pointer")]
    pub unsafe fn call(component: *mut Self, call: impl FnOnce(&mut Instance) -> Result<(), InstanceError>) -> i32 {
        // SAFETY: guaranteed by the caller.
        let Some(Self { instance, log }) = (unsafe { component.as_mut() }) else { return ERROR };
        match catch_unwind(AssertUnwindSafe(|| call(instance))) {
            Ok(Ok(())) => OK,
            Ok(Err(error)) => {
                report(log, &error.to_string());
                // The importing program ends the simulation, and nothing has failed.
                if matches!(error, InstanceError::Ended { .. }) { DISCARD } else { ERROR }
            }
            Err(_) => {
                report(log, "a defect of the library: this instance must not be used any more");
                ERROR
            }
        }
    }

    /// Returns the end of the last step in s, and true if the scenario has ended.
    ///
    /// # Safety
    /// As for [`Component::call`].
    #[allow(unsafe_code, reason = "the importing program holds the instance as a pointer")]
    pub unsafe fn progress(component: *const Self) -> (Option<f64>, bool) {
        // SAFETY: guaranteed by the caller.
        let component = unsafe { component.as_ref() };
        component.map_or((None, false), |Self { instance, .. }| (instance.time_s(), instance.has_ended()))
    }

    /// Saves the state in a new place, or replaces an earlier state.
    ///
    /// # Safety
    /// As for [`Component::call`]; `place` is null, or holds null or a state from this function that is not freed.
    #[allow(unsafe_code, reason = "the importing program holds the state as a pointer")]
    pub unsafe fn save(component: *mut Self, place: *mut *mut SavedState) -> i32 {
        // SAFETY: guaranteed by the caller.
        let Some(place) = (unsafe { place.as_mut() }) else { return ERROR };
        let save = |instance: &mut Instance| {
            let state = instance.save();
            // SAFETY: guaranteed by the caller.
            match unsafe { place.as_mut() } {
                Some(earlier) => *earlier = state,
                None => *place = Box::into_raw(Box::new(state)),
            }
            Ok(())
        };
        // SAFETY: the same requirements as this function's.
        unsafe { Self::call(component, save) }
    }

    /// # Safety
    /// As for [`Component::call`]; `state` is null or a state of this unit that is not freed.
    #[allow(unsafe_code, reason = "the importing program holds the state as a pointer")]
    pub unsafe fn restore(component: *mut Self, state: *const SavedState) -> i32 {
        // SAFETY: guaranteed by the caller.
        let Some(state) = (unsafe { state.as_ref() }) else { return ERROR };
        // SAFETY: the same requirements as this function's.
        unsafe { Self::call(component, |instance| instance.restore(state)) }
    }

    /// Frees a saved state and sets its place to null.
    ///
    /// # Safety
    /// `place` is null, or holds null or a state from [`Component::save`] that is not used afterwards.
    #[allow(unsafe_code, reason = "the importing program holds the state as a pointer")]
    pub unsafe fn free_state(place: *mut *mut SavedState) -> i32 {
        // SAFETY: guaranteed by the caller.
        if let Some(place) = unsafe { place.as_mut() }
            && !place.is_null()
        {
            // SAFETY: it was created by `Box::into_raw` and is freed once.
            drop(unsafe { Box::from_raw(std::mem::replace(place, std::ptr::null_mut())) });
        }
        OK
    }

    /// `read` converts each value to the type of the call.
    ///
    /// # Safety
    /// As for [`Component::call`]; `references` and `values` have `count` items, or `count` is 0.
    #[allow(unsafe_code, reason = "the lists are the importing program's")]
    pub unsafe fn get<T>(
        component: *mut Self,
        (references, values, count): (*const u32, *mut T, usize),
        kind: &'static str,
        read: impl Fn(Scalar) -> Option<T>,
    ) -> i32 {
        let get = |instance: &mut Instance| {
            for at in 0..count {
                // SAFETY: both lists have `count` items.
                let reference = unsafe { references.add(at).read() };
                let value =
                    read(instance.get(reference, kind)?).ok_or(InstanceError::NoVariable { kind, reference })?;
                // SAFETY: as for `references`.
                unsafe { values.add(at).write(value) };
            }
            Ok(())
        };
        // SAFETY: the same requirements as this function's.
        unsafe { Self::call(component, get) }
    }

    /// `scalar` converts each value from the type of the call.
    ///
    /// # Safety
    /// As for [`Component::get`].
    #[allow(unsafe_code, reason = "the lists are the importing program's")]
    pub unsafe fn set<T>(
        component: *mut Self,
        (references, values, count): (*const u32, *const T, usize),
        kind: &'static str,
        scalar: impl Fn(T) -> Scalar,
    ) -> i32 {
        let set = |instance: &mut Instance| {
            for at in 0..count {
                // SAFETY: both lists have `count` items.
                let (reference, value) = unsafe { (references.add(at).read(), values.add(at).read()) };
                instance.set(reference, kind, scalar(value))?;
            }
            Ok(())
        };
        // SAFETY: the same requirements as this function's.
        unsafe { Self::call(component, set) }
    }
}

/// Copies a text of the importing program; empty for null.
///
/// # Safety
/// `pointer` is null or a text that ends with a NUL.
#[allow(unsafe_code, reason = "the text is the importing program's")]
pub unsafe fn text(pointer: *const c_char) -> String {
    if pointer.is_null() {
        return String::new();
    }
    // SAFETY: guaranteed by the caller.
    unsafe { CStr::from_ptr(pointer) }.to_string_lossy().into_owned()
}

/// A URI with the scheme file and percent-encoded bytes.
pub fn folder_of_uri(uri: &str) -> Option<PathBuf> {
    let rest = uri.strip_prefix("file:")?;
    let path = rest.strip_prefix("//").map_or(rest, |after| after.find('/').map_or("", |slash| &after[slash..]));
    let mut bytes = Vec::with_capacity(path.len());
    let mut left = path.bytes();
    while let Some(byte) = left.next() {
        if byte == b'%' {
            let digit = |byte: Option<u8>| char::from(byte?).to_digit(16);
            bytes.push(u8::try_from(16 * digit(left.next())? + digit(left.next())?).ok()?);
        } else {
            bytes.push(byte);
        }
    }
    let path = String::from_utf8(bytes).ok()?;
    // A drive of Windows follows a slash.
    let is_drive = path.as_bytes().get(2) == Some(&b':');
    Some(Path::new(if is_drive { &path[1..] } else { &path }).to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_uri_names_a_folder() {
        let folder = |uri| folder_of_uri(uri).map(|path| path.display().to_string());
        assert_eq!(folder("file:///tmp/a%20unit/resources"), Some("/tmp/a unit/resources".into()));
        assert_eq!(folder("file:/tmp/unit"), Some("/tmp/unit".into()));
        assert_eq!(folder("file://localhost/tmp/unit"), Some("/tmp/unit".into()));
        assert_eq!(folder("file:///C:/unit"), Some("C:/unit".into()));
        assert_eq!(folder("https://example.org/unit"), None);
        assert_eq!(folder("file:///tmp/%zz"), None);
    }
}
