//! Saving and restoring the state of a rig.

use core::slice;

use trocar_core::lane::Stored as _;

use crate::digest::Digest;
use crate::memory::with;
use crate::rig::Rig;
use crate::status::Status;

/// Words before the controller's numbers: their digest.
const HEAD: usize = 1;

fn digest(settings: u64) -> Digest {
    let mut digest = Digest::default();
    digest.add(settings);
    digest
}

/// Runs `run` with a rig whose state has this number of words.
///
/// # Safety
/// `rig` is null or from trocar_rig_init, and no other thread uses it at the same time.
#[allow(unsafe_code, reason = "rig is the caller's")]
unsafe fn with_words(rig: *mut Rig, words: usize, run: impl FnOnce(&mut Rig) -> Status) -> Status {
    // SAFETY: the same requirement as this function's.
    unsafe { with(rig, |rig| if words == HEAD + rig.controller.count() { run(rig) } else { Status::State }) }
}

/// Sets `words` to the number of uint64_t that the state of a rig takes. It depends on the settings.
///
/// # Safety
/// `rig` is null or from trocar_rig_init, and no other thread uses it at the same time; `words` is null or valid.
#[allow(unsafe_code, reason = "rig and count are the caller's, and the name is exported to C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trocar_rig_state_size(rig: *mut Rig, words: *mut usize) -> Status {
    if words.is_null() {
        return Status::Null;
    }
    // SAFETY: the same requirements as this function's; `words` is not null.
    unsafe {
        with(rig, |Rig { controller, .. }| {
            words.write(HEAD + controller.count());
            Status::Ok
        })
    }
}

/// Writes the state of a rig to `state`, which has `words` words, as trocar_rig_state_size states.
///
/// # Safety
/// As for trocar_rig_state_size; `state` is null or points to `words` writable words.
#[allow(unsafe_code, reason = "rig and state are the caller's, and the name is exported to C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trocar_rig_save(rig: *mut Rig, state: *mut u64, words: usize) -> Status {
    if state.is_null() {
        return Status::Null;
    }
    // SAFETY: the same requirements as this function's; the words are written before they are read.
    unsafe {
        with_words(rig, words, |Rig { settings, controller, .. }| {
            let mut digest = digest(*settings);
            let mut place = HEAD;
            controller.numbers(&mut |number| {
                state.add(place).write(*number);
                digest.add(*number);
                place += 1;
            });
            state.write(digest.value());
            Status::Ok
        })
    }
}

/// Continues from a state that trocar_rig_save wrote, for a rig with the same settings and of the same version. If the
/// call fails the rig is unchanged.
///
/// # Safety
/// As for trocar_rig_state_size; `state` is null or points to `words` words.
#[allow(unsafe_code, reason = "rig and state are the caller's, and the name is exported to C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trocar_rig_restore(rig: *mut Rig, state: *const u64, words: usize) -> Status {
    if state.is_null() {
        return Status::Null;
    }
    // SAFETY: the same requirements as this function's.
    unsafe {
        with_words(rig, words, |Rig { settings, controller, .. }| {
            let state = slice::from_raw_parts(state, words);
            let mut digest = digest(*settings);
            state[HEAD..].iter().for_each(|word| digest.add(*word));
            if state[0] != digest.value() {
                return Status::State;
            }
            match controller.restore(&state[HEAD..]) {
                Ok(()) => Status::Ok,
                Err(_) => Status::State,
            }
        })
    }
}
