//! The C interface: settings from a text, then samples of any bits.

use std::ffi::{c_char, c_void};
use std::mem::{align_of, size_of};
use std::ptr::null_mut;

use trocar_c::{
    Command, Rig, Sample, Status, trocar_rig_alignment, trocar_rig_init_toml, trocar_rig_restore, trocar_rig_save,
    trocar_rig_size, trocar_rig_state_size, trocar_rig_step, trocar_rig_step_numbered,
};

/// The first bytes, up to a zero, are the text; the others are samples.
pub fn calls(content: &[u8]) {
    let end = content.iter().position(|byte| *byte == 0).unwrap_or(content.len());
    let (text, samples) = content.split_at(end);
    let base = b"base = \"builtin:paper/augmented.toml\"\n";
    if text.windows(4).any(|word| word == b"file") {
        return;
    }
    let text = [&base[..], text].concat();
    assert!(trocar_rig_alignment() <= align_of::<u128>());
    let mut memory = vec![0u128; trocar_rig_size().div_ceil(size_of::<u128>())];
    let mut error = [0 as c_char; 200];
    let mut rig: *mut Rig = null_mut();
    // SAFETY: every pointer is one of a live variable, with its size.
    let status = unsafe {
        trocar_rig_init_toml(
            memory.as_mut_ptr().cast::<c_void>(),
            memory.len() * size_of::<u128>(),
            text.as_ptr().cast(),
            text.len(),
            &raw mut rig,
            error.as_mut_ptr(),
            error.len(),
        )
    };
    assert!(status != Status::Panic && rig.is_null() == (status != Status::Ok), "{status:?}");
    if rig.is_null() {
        return;
    }
    let double = |bytes: &[u8]| f64::from_le_bytes(bytes.try_into().expect("eight bytes"));
    for (number, chunk) in samples.chunks_exact(40).enumerate() {
        let sample = Sample {
            struct_size: size_of::<Sample>() as u64,
            master_position_m: double(&chunk[..8]),
            slave_position_m: double(&chunk[8..16]),
            slave_velocity_m_per_s: double(&chunk[16..24]),
            force_n: double(&chunk[24..32]),
        };
        // SAFETY: a command consists of numbers.
        let mut command: Command = unsafe { std::mem::zeroed() };
        command.struct_size = size_of::<Command>() as u64;
        let given = u64::from_le_bytes(chunk[32..].try_into().expect("eight bytes"));
        // SAFETY: the rig was initialised in `memory`; sample and command are variables.
        let status = unsafe {
            if given % 2 == 0 {
                trocar_rig_step(rig, &raw const sample, &raw mut command)
            } else {
                trocar_rig_step_numbered(rig, &raw const sample, given >> 1, &raw mut command)
            }
        };
        assert!(status != Status::Panic, "{status:?} at {number}");
        assert!(command.slave_reference_m.is_finite() && command.master_force_n.is_finite(), "{command:?}");
    }
    let mut words = 0;
    // SAFETY: the rig was initialised in `memory`; the state has the stated number of words.
    unsafe {
        assert_eq!(trocar_rig_state_size(rig, &raw mut words), Status::Ok);
        let mut state = vec![0u64; words];
        assert_eq!(trocar_rig_save(rig, state.as_mut_ptr(), words), Status::Ok);
        // A damaged state must be refused or restored, without a panic.
        for (word, byte) in state.iter_mut().zip(samples) {
            *word ^= u64::from(*byte);
        }
        assert!(trocar_rig_restore(rig, state.as_ptr(), words) != Status::Panic);
    }
}
