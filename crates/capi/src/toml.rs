//! Settings from the text of a scenario.

use core::ffi::{c_char, c_void};
use core::fmt::Write as _;
use core::mem::size_of;
use core::slice;

use trocar_core::settings::{Constant, Kind};
use trocar_scenario::{Scenario, Source, Value};

use crate::detector::Detector;
use crate::error_text::ErrorText;
use crate::memory::{InMemory, clear, init};
use crate::rig::Rig;
use crate::settings::Settings;
use crate::status::{Status, guarded};

/// The settings with which a rig behaves like a scenario's controller.
fn settings_of(text: &str) -> Result<Settings, String> {
    let source = Source::Text { name: "scenario".into(), text: text.into() };
    let scenario = Scenario::load_for_rig(&source).map_err(|error| error.to_string())?;
    let mut settings = Settings::defaults();
    for (key, value) in scenario.rig_values() {
        let is_set = match &value {
            // A number without a default is NaN.
            None => settings.set(key.path, Constant::Number(f64::NAN)),
            Some(Value::Number(value)) => settings.set(key.path, Constant::Number(*value)),
            Some(Value::Whole(value)) => settings.set(key.path, Constant::Whole(*value)),
            Some(Value::Flag(value)) => settings.set(key.path, Constant::Flag(*value)),
            Some(Value::Text(word)) => {
                let words = if let Kind::Choice(words) = key.kind { words } else { &[] };
                let Some(known) = words.iter().find(|known| *known == word) else {
                    return Err(format!("{} is {word:?}; a rig needs {}", key.path, key.kind));
                };
                settings.set(key.path, Constant::Text(known))
            }
            Some(Value::Numbers(_)) => false,
        };
        if !is_set && value.is_some() {
            return Err(format!("{} has no field in the settings of a rig", key.path));
        }
    }
    Ok(settings)
}

/// # Safety
/// `text` is null or points to `size` bytes.
#[allow(unsafe_code, reason = "the text is the caller's")]
unsafe fn read(text: *const c_char, size: usize, error: &mut ErrorText) -> Result<Settings, Status> {
    if text.is_null() {
        return Err(Status::Null);
    }
    // SAFETY: it points to `size` bytes.
    let bytes = unsafe { slice::from_raw_parts(text.cast::<u8>(), size) };
    let text = core::str::from_utf8(bytes).map_err(|wrong| format!("the scenario is not UTF-8: {wrong}"));
    text.and_then(settings_of).map_err(|message| {
        // A text that does not fit is cut.
        let _ = error.write_str(&message);
        Status::Scenario
    })
}

/// Sets the settings from a scenario, a text in TOML. A rig with them behaves like the scenario's controller.
///
/// `text` has `text_size` bytes in UTF-8, without a NUL. `base = "builtin:augmented"` in it names a shipped scenario;
/// other paths are relative to the working directory. The text needs only keys of the controller, `rig.` and `safety.`:
/// operator and tissue may be missing. `settings` has `size` bytes, `sizeof(trocar_rig_settings)`. `error` is null or a
/// buffer of `error_size` bytes for an error text. The function allocates while it reads.
///
/// # Safety
/// Each pointer is null or valid as described.
#[allow(unsafe_code, reason = "text and settings are the caller's, and the name is exported to C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trocar_rig_settings_from_toml(
    text: *const c_char,
    text_size: usize,
    settings: *mut Settings,
    size: usize,
    error: *mut c_char,
    error_size: usize,
) -> Status {
    // SAFETY: the caller's buffer, as described.
    let mut error = unsafe { ErrorText::new(error, error_size) };
    guarded(|| {
        if settings.is_null() {
            return Status::Null;
        }
        if size != size_of::<Settings>() {
            return Status::StructSize;
        }
        // SAFETY: the caller's text, as described; the settings have this size.
        match unsafe { read(text, text_size, &mut error) } {
            Ok(read) => {
                // SAFETY: the caller's settings are not null and have this size, as checked above.
                unsafe { settings.write(read) };
                Status::Ok
            }
            Err(status) => status,
        }
    })
}

/// Like trocar_rig_init, with the settings of a scenario, as trocar_rig_settings_from_toml reads them.
///
/// # Safety
/// Each pointer is null or valid as described.
#[allow(unsafe_code, reason = "memory and text are the caller's, and the name is exported to C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trocar_rig_init_toml(
    memory: *mut c_void,
    size: usize,
    text: *const c_char,
    text_size: usize,
    rig: *mut *mut Rig,
    error: *mut c_char,
    error_size: usize,
) -> Status {
    // SAFETY: the same requirements as this function's.
    unsafe { init_toml(memory, size, (text, text_size), rig, (error, error_size)) }
}

/// Like trocar_detector_init, with the settings of a scenario, as trocar_rig_settings_from_toml reads them.
///
/// # Safety
/// Each pointer is null or valid as described.
#[allow(unsafe_code, reason = "memory and text are the caller's, and the name is exported to C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trocar_detector_init_toml(
    memory: *mut c_void,
    size: usize,
    text: *const c_char,
    text_size: usize,
    detector: *mut *mut Detector,
    error: *mut c_char,
    error_size: usize,
) -> Status {
    // SAFETY: the same requirements as this function's.
    unsafe { init_toml(memory, size, (text, text_size), detector, (error, error_size)) }
}

/// # Safety
/// As for [`trocar_rig_init_toml`].
#[allow(unsafe_code, reason = "memory and text are the caller's")]
unsafe fn init_toml<T: InMemory>(
    memory: *mut c_void,
    size: usize,
    (text, text_size): (*const c_char, usize),
    object: *mut *mut T,
    (error, error_size): (*mut c_char, usize),
) -> Status {
    // SAFETY: the caller's buffer, as described.
    let mut error = unsafe { ErrorText::new(error, error_size) };
    guarded(|| {
        // SAFETY: `object` is null or valid.
        unsafe { clear(object) };
        // SAFETY: the caller's text and memory, as described.
        match unsafe { read(text, text_size, &mut error) } {
            // SAFETY: the caller's memory has this size, as described, and `object` is null or valid.
            Ok(settings) => unsafe { init(memory, size, &settings, object, &mut error) },
            Err(status) => status,
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_needs_only_the_keys_of_the_controller() {
        let text =
            "scaling.force = 0.5\ndetector.threshold = 0.05\nrig.force_limit_n = 20.0\n[safety]\nforce_limit_n = 8.0";
        let settings = settings_of(text).expect("enough for a rig").read().expect("of their kinds");
        assert_eq!((settings.force_scale, settings.detector.cusum.threshold), (0.5, 0.05));
        assert_eq!((settings.limits.force_n, settings.safety.force_limit_n), (20.0, 8.0));
        let error = settings_of("estimator.parameters = \"hunt-crossley\"").expect_err("not on a rig");
        assert!(error.starts_with("estimator.parameters is \"hunt-crossley\"; a rig needs one of"), "{error}");
        let error = settings_of("scaling.force = 0.5\nscaling.forec = 0.5").expect_err("no such key");
        assert!(error.contains("scenario:2"), "{error}");
    }

    #[test]
    fn every_shipped_scenario_gives_the_same_rig_as_in_rust() {
        for (name, _) in trocar_scenario::shipped_questions() {
            let Ok(scenario) = Scenario::load(&Source::parse(&format!("builtin:{name}")), &[]) else {
                panic!("{name} loads");
            };
            let read =
                settings_of(&format!("base = \"builtin:{name}\"")).expect("loads").read().expect("of their kinds");
            assert_eq!(read, scenario.rig_settings(), "{name}");
        }
    }

    #[test]
    fn a_wrong_key_is_reported_with_its_line() {
        let message = settings_of("[detector]\nthreshhold = 1.0\n").expect_err("an unknown key");
        assert!(message.contains("threshhold") && message.contains("threshold"), "{message}");
    }
}
