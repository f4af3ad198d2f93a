//! Objects in the caller's memory.

use core::ffi::{c_char, c_void};
use core::fmt::Write as _;
use core::mem::{needs_drop, size_of};

use crate::error_text::ErrorText;
use crate::settings::Settings;
use crate::status::{Status, guarded};
use trocar_core::error::InvalidValue;
use trocar_core::rig;

/// Created in the caller's memory and never dropped.
pub(crate) trait InMemory: Sized {
    const MARK: u64;

    /// [`InMemory::MARK`] if the object is initialised.
    fn mark(&self) -> u64;

    fn create(settings: &rig::Settings, digest: u64) -> Result<Self, InvalidValue>;
}

/// "trocar" and the size of an object below 65536 bytes.
pub(crate) const fn mark_of<T>() -> u64 {
    assert!(!needs_drop::<T>(), "the caller's memory is never dropped");
    assert!(size_of::<T>() < 1 << 16, "the size fits into the mark");
    0x7472_6f63_6172_0000 | size_of::<T>() as u64
}

/// A failed call must not leave an old or invalid pointer.
///
/// # Safety
/// `object` is null or valid.
#[allow(unsafe_code, reason = "the pointer is the caller's")]
pub(crate) unsafe fn clear<T>(object: *mut *mut T) {
    if !object.is_null() {
        // SAFETY: not null, so it is writable.
        unsafe { object.write(core::ptr::null_mut()) };
    }
}

/// Reads the caller's settings.
///
/// # Safety
/// `settings` is null or points to a structure of any version.
#[allow(unsafe_code, reason = "the settings are the caller's")]
unsafe fn settings_at(settings: *const Settings, error: &mut ErrorText) -> Result<Settings, Status> {
    if settings.is_null() {
        return Err(Status::Null);
    }
    // SAFETY: every version has the first field; the others are read only in a structure of this version.
    unsafe {
        let found = (&raw const (*settings).struct_size).read();
        if found != size_of::<Settings>() as u64 {
            let expected = size_of::<Settings>();
            // A text that does not fit is cut.
            let _ = write!(error, "struct_size of the settings is {found}, must be {expected}: set the defaults first");
            return Err(Status::StructSize);
        }
        Ok(settings.read())
    }
}

/// The caller's pointer is null if this fails.
///
/// # Safety
/// As for [`init`] and [`settings_at`]; `error` is null or a buffer of `error_size` bytes.
#[allow(unsafe_code, reason = "memory, settings and buffer are the caller's")]
pub(crate) unsafe fn init_with<T: InMemory>(
    memory: *mut c_void,
    size: usize,
    settings: *const Settings,
    object: *mut *mut T,
    (error, error_size): (*mut c_char, usize),
) -> Status {
    // SAFETY: the caller's buffer, as described.
    let mut error = unsafe { ErrorText::new(error, error_size) };
    guarded(|| {
        // SAFETY: the same requirements as this function's.
        unsafe {
            clear(object);
            match settings_at(settings, &mut error) {
                Ok(settings) => init(memory, size, &settings, object, &mut error),
                Err(status) => status,
            }
        }
    })
}

/// Initialises an object in the given memory. The caller's pointer is null before.
///
/// # Safety
/// `memory` is null or has `size` writable bytes that no other thread uses; `object` is null or valid.
#[allow(unsafe_code, reason = "the memory is the caller's")]
pub(crate) unsafe fn init<T: InMemory>(
    memory: *mut c_void,
    size: usize,
    settings: &Settings,
    object: *mut *mut T,
    error: &mut ErrorText,
) -> Status {
    if memory.is_null() || object.is_null() {
        return Status::Null;
    }
    if size < size_of::<T>() {
        return Status::MemorySize;
    }
    if !memory.cast::<T>().is_aligned() {
        return Status::Alignment;
    }
    // A text that does not fit is cut.
    let read = match settings.read() {
        Ok(read) => read,
        Err(key) => {
            let _ = write!(error, "{} must be {}", key.path, key.kind);
            return Status::Setting;
        }
    };
    match T::create(&read, settings.digest()) {
        Ok(created) => {
            // SAFETY: the memory is large enough and aligned; `object` is not null.
            unsafe {
                memory.cast::<T>().write(created);
                object.write(memory.cast());
            }
            Status::Ok
        }
        Err(invalid) => {
            let _ = write!(error, "{invalid}");
            Status::Setting
        }
    }
}

/// Calls `run` with an object.
///
/// # Safety
/// `object` is null or was initialised, and no other thread uses it at the same time.
#[allow(unsafe_code, reason = "the object is the caller's")]
#[inline(always)]
pub(crate) unsafe fn with<T: InMemory>(object: *mut T, run: impl FnOnce(&mut T) -> Status) -> Status {
    // SAFETY: null or valid.
    let Some(object) = (unsafe { object.as_mut() }) else { return Status::Null };
    if object.mark() != T::MARK {
        return Status::NotInitialised;
    }
    guarded(|| run(object))
}

/// Calls `run` with an object and a sample, and writes its result. The first field of both structures is their size, which
/// is checked before anything else is read or written.
///
/// # Safety
/// As for [`with`]; `sample` and `result` are null or point to structures of any version.
#[allow(unsafe_code, reason = "object, sample and result are the caller's")]
#[inline(always)]
pub(crate) unsafe fn exchange<T: InMemory, S: Copy, R>(
    object: *mut T,
    sample: *const S,
    result: *mut R,
    run: impl FnOnce(&mut T, S) -> R,
) -> Status {
    if sample.is_null() || result.is_null() {
        return Status::Null;
    }
    // SAFETY: every version begins with its size.
    let sizes = unsafe { (sample.cast::<u64>().read(), result.cast::<u64>().read()) };
    let checked = |object: &mut T| {
        if sizes != (size_of::<S>() as u64, size_of::<R>() as u64) {
            return Status::StructSize;
        }
        // SAFETY: their sizes show structures of this version.
        unsafe { result.write(run(object, sample.read())) };
        Status::Ok
    };
    // SAFETY: the same requirements as this function's.
    unsafe { with(object, checked) }
}
