//! The settings of a rig in C: eight bytes for each key, in the order of the keys.

use core::mem::size_of;

use trocar_core::rig;
use trocar_core::settings::{Constant, Fallback, Key, KeySource, Kind};

use crate::Status;
use crate::digest::Digest;

/// The keys. Each is a field of the C structure.
const KEYS: &[Key] = rig::Settings::KEYS;

/// The settings of a rig, `trocar_rig_settings` in the header.
///
/// The header names each field after its key. A number is a `double`, with NaN for "derived" or "none". A whole number,
/// a flag (0 or 1) and a word (its index among the words of its key) are `uint64_t`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(C)]
pub struct Settings {
    /// Size of the structure in bytes.
    pub struct_size: u64,
    bits: [u64; KEYS.len()],
}

/// `None` if the value does not suit the key.
fn bits_of(key: &Key, value: Constant) -> Option<u64> {
    match (key.kind, value) {
        (Kind::Number(_) | Kind::Sign, Constant::Number(value)) => Some(value.to_bits()),
        (Kind::Whole(_), Constant::Whole(value)) => Some(value),
        (Kind::Flag, Constant::Flag(value)) => Some(u64::from(value)),
        (Kind::Choice(words), Constant::Text(text)) => {
            words.iter().position(|word| *word == text).map(|place| place as u64)
        }
        _ => None,
    }
}

impl Settings {
    /// Returns the defaults. Derived and optional settings are NaN.
    #[must_use]
    pub fn defaults() -> Self {
        let mut settings = Self { struct_size: size_of::<Self>() as u64, bits: [f64::NAN.to_bits(); KEYS.len()] };
        for (bits, key) in settings.bits.iter_mut().zip(KEYS) {
            if let Fallback::Value(value) = key.fallback {
                *bits = bits_of(key, value).unwrap_or(*bits);
            }
        }
        settings
    }

    /// Sets the field of a key. Returns true if the field exists and the value suits it.
    pub fn set(&mut self, path: &str, value: Constant) -> bool {
        let place = KEYS.iter().position(|key| key.path == path);
        let bits = place.and_then(|place| Some((place, bits_of(&KEYS[place], value)?)));
        if let Some((place, bits)) = bits {
            self.bits[place] = bits;
        }
        bits.is_some()
    }

    pub(crate) fn digest(&self) -> u64 {
        let mut digest = Digest::default();
        self.bits.iter().for_each(|bits| digest.add(*bits));
        digest.value()
    }

    /// Reads the settings for the controller.
    ///
    /// # Errors
    /// The key of a field with a value that does not suit it. The controller checks the ranges.
    pub fn read(&self) -> Result<rig::Settings, &'static Key> {
        rig::Settings::read(&mut Fields { bits: self.bits })
    }
}

/// Derived numbers are filled in when they are read.
struct Fields {
    bits: [u64; KEYS.len()],
}

impl Fields {
    fn place(path: &str) -> usize {
        let place = KEYS.iter().position(|key| key.path == path);
        place.expect("a key that is read is one of the table: both come from the same declaration")
    }

    fn bits(&self, path: &str) -> (u64, &'static Key) {
        let place = Self::place(path);
        (self.bits[place], &KEYS[place])
    }
}

impl KeySource for Fields {
    type Error = &'static Key;

    fn number(&self, path: &str) -> Result<f64, Self::Error> {
        // The range check rejects NaN.
        Ok(f64::from_bits(self.bits(path).0))
    }

    fn optional_number(&self, path: &str) -> Option<f64> {
        let value = f64::from_bits(self.bits(path).0);
        (!value.is_nan()).then_some(value)
    }

    fn number_or(&mut self, path: &'static str, derived: impl FnOnce() -> f64) -> f64 {
        self.optional_number(path).unwrap_or_else(|| {
            let value = derived();
            self.bits[Self::place(path)] = value.to_bits();
            value
        })
    }

    fn whole(&self, path: &str) -> Result<u64, Self::Error> {
        Ok(self.bits(path).0)
    }

    fn flag(&self, path: &str) -> Result<bool, Self::Error> {
        match self.bits(path) {
            (0, _) => Ok(false),
            (1, _) => Ok(true),
            (_, key) => Err(key),
        }
    }

    fn numbers(&self, path: &str) -> Result<&[f64], Self::Error> {
        Err(self.bits(path).1)
    }

    fn word(&self, path: &str) -> Result<&str, Self::Error> {
        let (place, key) = self.bits(path);
        let Kind::Choice(words) = key.kind else { return Err(key) };
        usize::try_from(place).ok().and_then(|place| words.get(place)).copied().ok_or(key)
    }

    fn optional_word(&self, path: &str) -> Option<&str> {
        self.word(path).ok()
    }

    fn unknown_word(&self, path: &str) -> Self::Error {
        self.bits(path).1
    }

    fn visit_items(
        &mut self,
        _list: &str,
        _visit: impl FnMut(&str, &mut Self) -> Result<(), Self::Error>,
    ) -> Result<(), Self::Error> {
        Ok(())
    }
}

/// Sets every setting to its default: the simulator's at 1 kHz, with the tissue surface at 0.
///
/// `size` is `sizeof(trocar_rig_settings)`; struct_size is set to it.
///
/// # Safety
/// `settings` is null, or points to `size` writable bytes with the alignment of the structure.
#[allow(unsafe_code, reason = "the structure is the caller's, and the name is exported to C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trocar_rig_settings_default(settings: *mut Settings, size: usize) -> Status {
    if settings.is_null() {
        return Status::Null;
    }
    if size != size_of::<Settings>() {
        return Status::StructSize;
    }
    // SAFETY: it points to a structure of this size.
    unsafe { settings.write(Settings::defaults()) };
    Status::Ok
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_key_is_one_field_and_has_a_kind_that_c_supports() {
        for (place, key) in KEYS.iter().enumerate() {
            assert_eq!(Fields::place(key.path), place, "{} is there twice", key.path);
            let fits = matches!(key.kind, Kind::Number(_) | Kind::Sign | Kind::Whole(_) | Kind::Flag | Kind::Choice(_));
            assert!(fits, "{}: {:?}", key.path, key.kind);
        }
    }

    #[test]
    fn the_defaults_agree_with_rust() {
        assert_eq!(Settings::defaults().read().expect("of their kinds"), rig::Settings::default());
    }

    #[test]
    fn a_field_is_read_by_its_key() {
        let mut settings = Settings::defaults();
        assert!(settings.set("estimator.contact_m", Constant::Number(0.02)));
        assert!(settings.set("detector.distance", Constant::Text("page-hinkley")));
        assert!(!settings.set("detector.distance", Constant::Text("unknown")));
        assert!(!settings.set("estimator.contact", Constant::Number(0.02)));
        let read = settings.read().expect("of their kinds");
        assert_eq!((read.contact_m, read.detector.distance.kind.word()), (0.02, "page-hinkley"));
        // Derived values follow the distance, for example the threshold.
        assert_eq!(read.detector.cusum.threshold, read.detector.distance.tuning().0);
    }

    #[test]
    fn a_word_beyond_the_last_is_rejected_with_its_key() {
        let mut settings = Settings::defaults();
        settings.bits[Fields::place("detector.motion")] = 3;
        assert_eq!(settings.read().expect_err("three words").path, "detector.motion");
        settings = Settings::defaults();
        settings.bits[Fields::place("augmentation.enabled")] = 2;
        assert_eq!(settings.read().expect_err("0 or 1").path, "augmentation.enabled");
    }
}
