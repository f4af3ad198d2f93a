//! Recordings in memory, which a scenario names by a hash of their content, as in `memory:1f3a…`.
//!
//! A name is valid while the program holds the recording that [`keep`] returned. Equal recordings have the same name.

use std::collections::HashMap;
use std::sync::{Arc, LazyLock, Mutex, PoisonError, Weak};

use sha2::{Digest, Sha256};
use trocar_base::hexadecimal::hexadecimal;

use super::Recording;

/// The prefix of the names.
pub const MEMORY: &str = "memory:";

static KEPT: LazyLock<Mutex<HashMap<String, Weak<Recording>>>> = LazyLock::new(Mutex::default);

/// Makes a recording available by the returned name, while the returned recording or a copy of it is held.
#[must_use]
pub fn keep(recording: Recording) -> (String, Arc<Recording>) {
    let name = name_of(&recording);
    let mut all = KEPT.lock().unwrap_or_else(PoisonError::into_inner);
    all.retain(|_, kept| kept.strong_count() > 0);
    let kept = all.get(&name).and_then(Weak::upgrade).unwrap_or_else(|| Arc::new(recording));
    all.insert(name.clone(), Arc::downgrade(&kept));
    (name, kept)
}

/// Returns the recording of a name, if it is held.
pub fn kept(name: &str) -> Option<Arc<Recording>> {
    KEPT.lock().unwrap_or_else(PoisonError::into_inner).get(name).and_then(Weak::upgrade)
}

fn name_of(recording: &Recording) -> String {
    let mut hash = Sha256::new();
    let velocity = recording.velocity_m_per_s();
    hash.update([u8::from(velocity.is_some())]);
    for samples in [recording.time_s(), recording.position_m(), velocity.unwrap_or_default(), recording.force_n()] {
        samples.iter().for_each(|sample| hash.update(sample.to_bits().to_le_bytes()));
    }
    MEMORY.to_owned() + &hexadecimal(&hash.finalize()[..16])
}

#[cfg(test)]
mod tests {
    use super::super::fixtures::recording;
    use super::*;

    #[test]
    fn a_recording_is_found_by_its_content_while_it_is_held() {
        let (name, held) = keep(recording(&[0.0, 1.0], &[1.0, 2.0]));
        let (same, again) = keep(recording(&[0.0, 1.0], &[1.0, 2.0]));
        let (other, _held_too) = keep(recording(&[0.0, 1.0], &[1.0, 3.0]));
        assert_eq!((&name, Arc::ptr_eq(&held, &again)), (&same, true));
        assert_ne!(name, other);
        assert_eq!(kept(&name).as_deref(), Some(&*held));
        drop((held, again));
        assert_eq!(kept(&name), None);
    }
}
