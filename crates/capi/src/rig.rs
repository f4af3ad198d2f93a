//! A rig in memory of the caller.

use core::ffi::{CStr, c_char, c_void};
use core::mem::{align_of, size_of};

use trocar_core::error::InvalidValue;
use trocar_core::rig::{self, HapticController};

use crate::memory::{InMemory, exchange, init_with, mark_of};
use crate::settings::Settings;
use crate::status::Status;

const VERSION: &CStr = match CStr::from_bytes_with_nul(concat!(env!("CARGO_PKG_VERSION"), "\0").as_bytes()) {
    Ok(version) => version,
    Err(_) => panic!("the version has no NUL inside"),
};

/// The controller of a rig, in memory of the caller.
#[derive(Debug)]
pub struct Rig {
    initialised: u64,
    /// Digest of the settings, by which a saved state belongs to them.
    pub(crate) settings: u64,
    pub(crate) controller: HapticController,
}

impl InMemory for Rig {
    const MARK: u64 = mark_of::<Self>();

    fn mark(&self) -> u64 {
        self.initialised
    }

    fn create(settings: &rig::Settings, digest: u64) -> Result<Self, InvalidValue> {
        Ok(Self { initialised: Self::MARK, settings: digest, controller: HapticController::new(settings)? })
    }
}

/// A rig's measurements at one tick. A number that is not finite or exceeds its limit is a fault of its channel.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct Sample {
    /// sizeof(trocar_sample).
    pub struct_size: u64,
    /// Position of the master in m.
    pub master_position_m: f64,
    /// Position of the slave, growing into the tissue, in m.
    pub slave_position_m: f64,
    /// Velocity of the slave in m/s; not read if sensor_position_resolution_m is above 0.
    pub slave_velocity_m_per_s: f64,
    /// Force on the needle in N, positive if it resists insertion.
    pub force_n: f64,
}

/// A rig's commands at one tick, and intermediate values. Every number is finite.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct Command {
    /// sizeof(trocar_command), set by the caller.
    pub struct_size: u64,
    /// Reference for the slave's position controller in m.
    pub slave_reference_m: f64,
    /// Command for the master's force controller in N.
    pub master_force_n: f64,
    /// Maximum change of master_force_n per tick that the active law allows, in N.
    pub allowed_force_step_n: f64,
    /// Estimated stiffness of the tissue in N/m.
    pub stiffness_n_per_m: f64,
    /// Estimated damping of the tissue in N·s/m.
    pub damping_n_s_per_m: f64,
    /// Predicted force in N; 0 if there is no prediction.
    pub predicted_force_n: f64,
    /// Measured minus predicted force in N; 0 at a bad sample and at the next one.
    pub residual_n: f64,
    /// Distance from the hypothesis of no rupture, in the unit of the distance.
    pub distance: f64,
    /// Decision function g, in the unit of the distance.
    pub decision: f64,
    /// Velocity of the slave that the estimator uses, in m/s.
    pub slave_velocity_m_per_s: f64,
    /// 0: teleoperation, 1: augmented, 2: re-engaging.
    pub mode: u32,
    /// 1 if the detector raises an alarm at this sample, otherwise 0.
    pub alarm: u32,
    /// 1 if the supervisor accepts the alarm (with augmentation disabled: if there is an alarm), otherwise 0.
    pub alarm_taken: u32,
    /// Faults of the sample as a sum: 1 master position, 2 slave position, 4 slave velocity, 8 force.
    pub faults: u32,
    /// Number of consecutive bad samples, including this one; 0 if it is good.
    pub faulty_samples: u32,
    /// 0: armed, a drop of the force raises an alarm; 1: settling, the detector waits; 2: blind, samples are missing.
    pub detection: u32,
    /// Number of ticks since detection has this value.
    pub detection_ticks: u32,
    /// State of the commands. 0: disabled, 1: aligning, 2: active, 3: fault.
    pub state: u32,
    /// Cause of the last fault. 0: none, 1: bad samples, 2: stuck force, 3: sign of the force, 4: velocity.
    pub fault: u32,
    /// The safety limits that acted as a sum: 1 force, 2 rate of the force, 4 speed of the reference, 8 distance of the
    /// reference from the slave.
    pub limited: u32,
}

impl From<rig::Command> for Command {
    #[inline(always)]
    fn from(command: rig::Command) -> Self {
        Self {
            struct_size: size_of::<Self>() as u64,
            slave_reference_m: command.slave_reference_m,
            master_force_n: command.master_force_n,
            allowed_force_step_n: command.allowed_force_step_n,
            stiffness_n_per_m: command.stiffness_n_per_m,
            damping_n_s_per_m: command.damping_n_s_per_m,
            predicted_force_n: command.predicted_force_n,
            residual_n: command.residual_n,
            distance: command.distance,
            decision: command.decision,
            slave_velocity_m_per_s: command.slave_velocity_m_per_s,
            mode: u32::from(command.mode.code()),
            alarm: u32::from(command.alarm),
            alarm_taken: u32::from(command.alarm_taken),
            faults: command.faults.bits(),
            faulty_samples: command.faulty_samples,
            detection: u32::from(command.detection.code()),
            detection_ticks: command.detection_ticks,
            state: u32::from(command.state.code()),
            fault: command.fault.map_or(0, |cause| u32::from(cause.code())),
            limited: command.limited.bits(),
        }
    }
}

/// Returns the version of the library, for example "1.2.3". The text is never freed.
#[allow(unsafe_code, reason = "the name is exported to C")]
#[unsafe(no_mangle)]
pub extern "C" fn trocar_version() -> *const c_char {
    VERSION.as_ptr()
}

/// Returns the size of a rig in bytes.
#[allow(unsafe_code, reason = "the name is exported to C")]
#[unsafe(no_mangle)]
pub extern "C" fn trocar_rig_size() -> usize {
    size_of::<Rig>()
}

/// Returns the alignment of a rig's memory in bytes. Memory from malloc has it.
#[allow(unsafe_code, reason = "the name is exported to C")]
#[unsafe(no_mangle)]
pub extern "C" fn trocar_rig_alignment() -> usize {
    align_of::<Rig>()
}

/// Initialises a rig in the given memory: in teleoperation, before the first sample. Another call restarts it.
///
/// `memory` has `size` bytes, at least trocar_rig_size(), aligned to trocar_rig_alignment(). `rig` is set to the rig in
/// it, or to null if the call fails. `error` is null or a buffer of `error_size` bytes for an error text.
///
/// # Safety
/// Each pointer is null or valid as described, and no other thread uses the memory at the same time.
#[allow(unsafe_code, reason = "memory and settings are the caller's, and the name is exported to C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trocar_rig_init(
    memory: *mut c_void,
    size: usize,
    settings: *const Settings,
    rig: *mut *mut Rig,
    error: *mut c_char,
    error_size: usize,
) -> Status {
    // SAFETY: the same requirements as this function's.
    unsafe { init_with(memory, size, settings, rig, (error, error_size)) }
}

/// Processes the sample of a tick and computes its command. Samples are simulation_tick_s apart; for a tick without a
/// sample pass NaN in every field.
///
/// It neither allocates nor blocks, and takes the same time at every good sample outside of events.
///
/// # Safety
/// `rig` is null or from trocar_rig_init; `sample` and `command` are null or valid; no other thread uses the rig at the
/// same time.
#[allow(unsafe_code, reason = "rig, sample and command are the caller's, and the name is exported to C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trocar_rig_step(rig: *mut Rig, sample: *const Sample, command: *mut Command) -> Status {
    // SAFETY: the same requirements as this function's.
    unsafe { step(rig, sample, command, HapticController::step) }
}

/// Like trocar_rig_step, for a sample that its source has numbered from 1, with one number per tick.
///
/// A repeated sample and one with a number below the newest one count as missing, and skipped numbers are lost samples.
/// Ten consecutive ascending numbers below the newest one mean that the counter was set back.
///
/// # Safety
/// As for trocar_rig_step.
#[allow(unsafe_code, reason = "rig, sample and command are the caller's, and the name is exported to C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trocar_rig_step_numbered(
    rig: *mut Rig,
    sample: *const Sample,
    number: u64,
    command: *mut Command,
) -> Status {
    // SAFETY: the same requirements as this function's.
    unsafe { step(rig, sample, command, |controller, sample| controller.step_numbered(sample, number)) }
}

/// # Safety
/// As for [`trocar_rig_step`].
#[allow(unsafe_code, reason = "rig, sample and command are the caller's")]
#[inline(always)]
unsafe fn step(
    rig: *mut Rig,
    sample: *const Sample,
    command: *mut Command,
    run: impl FnOnce(&mut HapticController, &rig::Sample) -> rig::Command,
) -> Status {
    let run = |rig: &mut Rig, sample: Sample| {
        let sample = rig::Sample {
            master_position_m: sample.master_position_m,
            slave_position_m: sample.slave_position_m,
            slave_velocity_m_per_s: sample.slave_velocity_m_per_s,
            force_n: sample.force_n,
        };
        run(&mut rig.controller, &sample).into()
    };
    // SAFETY: the same requirements as this function's.
    unsafe { exchange(rig, sample, command, run) }
}
