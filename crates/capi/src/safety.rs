//! Stop, enable, and the counts of a rig.

use core::mem::size_of;

use crate::memory::with;
use crate::rig::Rig;
use crate::status::Status;

/// Counts since a rig was initialised.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(C)]
pub struct Counts {
    /// sizeof(trocar_counts), set by the caller.
    pub struct_size: u64,
    /// Samples with a faulty channel, stale samples included.
    pub bad: u64,
    /// Samples with the number of the newest sample.
    pub repeated: u64,
    /// Samples with a number below the newest one.
    pub late: u64,
    /// Missing samples that were interpolated.
    pub bridged: u64,
    /// Gaps too long to be bridged, and counters that were set back. The detector was blind.
    pub gaps: u64,
    /// Ticks with a force beyond safety_force_limit_n.
    pub force_limited: u64,
    /// Ticks with a force faster than safety_force_rate_n_per_s.
    pub force_rate_limited: u64,
    /// Ticks with a reference faster than safety_reference_speed_m_per_s, or than an alignment.
    pub reference_speed_limited: u64,
    /// Ticks with a reference farther from the slave than safety_lead_m.
    pub lead_limited: u64,
    /// Alignments that were needed.
    pub alignments: u64,
    /// Faults.
    pub faults: u64,
}

/// Stops: the master's force decays within safety_decay_s, and the slave's reference holds, until trocar_rig_enable. It
/// has no effect if safety_acts is "nowhere".
///
/// # Safety
/// `rig` is null or from trocar_rig_init, and no other thread uses it at the same time.
#[allow(unsafe_code, reason = "the rig is the caller's, and the name is exported to C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trocar_rig_stop(rig: *mut Rig) -> Status {
    // SAFETY: the same requirements as this function's.
    unsafe {
        with(rig, |rig| {
            rig.controller.stop();
            Status::Ok
        })
    }
}

/// Ends a stop or a fault: the reference moves to the hand at safety_alignment_speed_m_per_s, and then the force
/// returns.
///
/// # Safety
/// As for trocar_rig_stop.
#[allow(unsafe_code, reason = "the rig is the caller's, and the name is exported to C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trocar_rig_enable(rig: *mut Rig) -> Status {
    // SAFETY: the same requirements as this function's.
    unsafe {
        with(rig, |rig| {
            rig.controller.enable();
            Status::Ok
        })
    }
}

/// Reads the counts of bad samples and of acting limits.
///
/// # Safety
/// As for trocar_rig_stop; `counts` is null or valid.
#[allow(unsafe_code, reason = "rig and counts are the caller's, and the name is exported to C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trocar_rig_counts(rig: *mut Rig, counts: *mut Counts) -> Status {
    if counts.is_null() {
        return Status::Null;
    }
    // SAFETY: not null, so it is valid; only the first field must be initialised.
    if unsafe { (&raw const (*counts).struct_size).read() } != size_of::<Counts>() as u64 {
        return Status::StructSize;
    }
    // SAFETY: the same requirements as this function's.
    unsafe {
        with(rig, |rig| {
            let (samples, safety) = (rig.controller.counters(), rig.controller.safety_counts());
            counts.write(Counts {
                struct_size: size_of::<Counts>() as u64,
                bad: samples.bad,
                repeated: samples.repeated,
                late: samples.late,
                bridged: samples.bridged,
                gaps: samples.gaps,
                force_limited: safety.force,
                force_rate_limited: safety.force_rate,
                reference_speed_limited: safety.reference_speed,
                lead_limited: safety.lead,
                alignments: safety.alignments,
                faults: safety.faults,
            });
            Status::Ok
        })
    }
}
