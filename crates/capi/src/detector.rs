//! The detector alone, in memory of the caller.

use core::ffi::{c_char, c_void};
use core::mem::{align_of, size_of};

use trocar_core::error::InvalidValue;
use trocar_core::rig::{self, NeedleDetector, NeedleSample};

use crate::memory::{InMemory, exchange, init_with, mark_of};
use crate::settings::Settings;
use crate::status::Status;

/// Estimator and detector of a rig, in memory of the caller.
#[derive(Debug)]
pub struct Detector {
    initialised: u64,
    detector: NeedleDetector,
}

impl InMemory for Detector {
    const MARK: u64 = mark_of::<Self>();

    fn mark(&self) -> u64 {
        self.initialised
    }

    fn create(settings: &rig::Settings, _digest: u64) -> Result<Self, InvalidValue> {
        Ok(Self { initialised: Self::MARK, detector: NeedleDetector::new(settings)? })
    }
}

/// A needle's measurements at one tick. A number that is not finite or exceeds its limit is a fault of its channel.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct DetectorSample {
    /// sizeof(trocar_detector_sample).
    pub struct_size: u64,
    /// Position of the needle, growing into the tissue, in m.
    pub position_m: f64,
    /// Velocity of the needle in m/s; not read if sensor_position_resolution_m is above 0.
    pub velocity_m_per_s: f64,
    /// Force on the needle in N, positive if it resists insertion.
    pub force_n: f64,
}

/// The results of the detector at one tick. Every number is finite.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct Detection {
    /// sizeof(trocar_detection), set by the caller.
    pub struct_size: u64,
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
    /// Velocity of the needle that the estimator uses, in m/s.
    pub velocity_m_per_s: f64,
    /// 1 if the detector raises an alarm at this sample, otherwise 0.
    pub alarm: u32,
    /// 0: armed, a drop of the force raises an alarm; 1: settling, the detector waits; 2: blind, samples are missing.
    pub state: u32,
    /// Number of ticks since state has this value.
    pub state_ticks: u32,
    /// Faults of the sample as a sum: 2 position, 4 velocity, 8 force, as in trocar_command.
    pub faults: u32,
    /// Number of consecutive bad samples, including this one; 0 if it is good.
    pub faulty_samples: u32,
    /// 0.
    pub reserved: u32,
}

impl From<rig::Detection> for Detection {
    fn from(detection: rig::Detection) -> Self {
        Self {
            struct_size: size_of::<Self>() as u64,
            stiffness_n_per_m: detection.stiffness_n_per_m,
            damping_n_s_per_m: detection.damping_n_s_per_m,
            predicted_force_n: detection.predicted_force_n,
            residual_n: detection.residual_n,
            distance: detection.distance,
            decision: detection.decision,
            velocity_m_per_s: detection.velocity_m_per_s,
            alarm: u32::from(detection.alarm),
            state: u32::from(detection.state.code()),
            state_ticks: detection.state_ticks,
            faults: detection.faults.bits(),
            faulty_samples: detection.faulty_samples,
            reserved: 0,
        }
    }
}

/// Returns the size of a detector in bytes.
#[allow(unsafe_code, reason = "the name is exported to C")]
#[unsafe(no_mangle)]
pub extern "C" fn trocar_detector_size() -> usize {
    size_of::<Detector>()
}

/// Returns the alignment of a detector's memory in bytes. Memory from malloc has it.
#[allow(unsafe_code, reason = "the name is exported to C")]
#[unsafe(no_mangle)]
pub extern "C" fn trocar_detector_alignment() -> usize {
    align_of::<Detector>()
}

/// Initialises a detector in the given memory, before the first sample. Another call restarts it.
///
/// It uses the settings of estimator, detector, sensor, tick and samples (`rig_...`); the others must be valid, too.
/// `memory` has `size` bytes, at least trocar_detector_size(), aligned to trocar_detector_alignment(). `detector` is set
/// to the detector in it, or to null if the call fails. `error` is null or a buffer of `error_size` bytes for an error
/// text.
///
/// # Safety
/// Each pointer is null or valid as described, and no other thread uses the memory at the same time.
#[allow(unsafe_code, reason = "memory and settings are the caller's, and the name is exported to C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trocar_detector_init(
    memory: *mut c_void,
    size: usize,
    settings: *const Settings,
    detector: *mut *mut Detector,
    error: *mut c_char,
    error_size: usize,
) -> Status {
    // SAFETY: the same requirements as this function's.
    unsafe { init_with(memory, size, settings, detector, (error, error_size)) }
}

/// Processes the sample of a tick. Samples are simulation_tick_s apart; for a tick without a sample pass NaN in every
/// field.
///
/// On the same samples, alarms, decisions and estimates are those of trocar_rig_step, bit for bit. It neither allocates
/// nor blocks.
///
/// # Safety
/// `detector` is null or from trocar_detector_init; `sample` and `detection` are null or valid; no other thread uses the
/// detector at the same time.
#[allow(unsafe_code, reason = "detector, sample and result are the caller's, and the name is exported to C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trocar_detector_step(
    detector: *mut Detector,
    sample: *const DetectorSample,
    detection: *mut Detection,
) -> Status {
    // SAFETY: the same requirements as this function's.
    unsafe { step(detector, sample, detection, NeedleDetector::step) }
}

/// Like trocar_detector_step, for a sample that its source has numbered from 1, with one number per tick, as in
/// trocar_rig_step_numbered.
///
/// # Safety
/// As for trocar_detector_step.
#[allow(unsafe_code, reason = "detector, sample and result are the caller's, and the name is exported to C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trocar_detector_step_numbered(
    detector: *mut Detector,
    sample: *const DetectorSample,
    number: u64,
    detection: *mut Detection,
) -> Status {
    // SAFETY: the same requirements as this function's.
    unsafe { step(detector, sample, detection, |detector, sample| detector.step_numbered(sample, number)) }
}

/// # Safety
/// As for [`trocar_detector_step`].
#[allow(unsafe_code, reason = "detector, sample and result are the caller's")]
unsafe fn step(
    detector: *mut Detector,
    sample: *const DetectorSample,
    detection: *mut Detection,
    run: impl FnOnce(&mut NeedleDetector, &NeedleSample) -> rig::Detection,
) -> Status {
    let run = |object: &mut Detector, sample: DetectorSample| {
        let DetectorSample { position_m, velocity_m_per_s, force_n, .. } = sample;
        run(&mut object.detector, &NeedleSample { position_m, velocity_m_per_s, force_n }).into()
    };
    // SAFETY: the same requirements as this function's.
    unsafe { exchange(detector, sample, detection, run) }
}
