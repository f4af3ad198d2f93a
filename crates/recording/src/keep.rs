use std::sync::{Arc, PoisonError, Weak};

use sha2::{Digest, Sha256};
use trocar_base::hexadecimal::hexadecimal;

use super::Recording;
use super::memory::{KEPT, MEMORY};

pub fn keep(recording: Recording) -> (String, Arc<Recording>) {
    let name = name_of(&recording);
    let mut all = KEPT.lock().unwrap_or_else(PoisonError::into_inner);
    all.retain(|_, kept| kept.strong_count() > 0);
    let kept = all.get(&name).and_then(Weak::upgrade).unwrap_or_else(|| Arc::new(recording));
    all.insert(name.clone(), Arc::downgrade(&kept));
    (name, kept)
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
    use super::super::kept;
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
