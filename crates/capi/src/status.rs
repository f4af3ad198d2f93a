//! The status of a call.

use core::ffi::{CStr, c_char};

/// The status of a call.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(i32)]
pub enum Status {
    /// The call has succeeded.
    Ok = 0,
    /// A required pointer is null.
    Null = 1,
    /// The struct_size of a structure differs from this version of the library.
    StructSize = 2,
    /// The memory is smaller than trocar_rig_size(), or trocar_detector_size().
    MemorySize = 3,
    /// The memory is not aligned to trocar_rig_alignment(), or trocar_detector_alignment().
    Alignment = 4,
    /// A setting is out of range; the error text contains its key.
    Setting = 5,
    /// The scenario cannot be read; the error text contains the place and the remedy.
    Scenario = 6,
    /// The rig or the detector is not initialised.
    NotInitialised = 7,
    /// A defect of the library. The rig or the detector must not be used any more.
    Panic = 8,
    /// The state is damaged, or of a rig with other settings or of another version.
    State = 9,
}

impl Status {
    fn text(self) -> &'static CStr {
        match self {
            Self::Ok => c"done",
            Self::Null => c"a pointer that is needed is null",
            Self::StructSize => {
                c"struct_size differs: set it with sizeof, and use the header of this version of the library"
            }
            Self::MemorySize => c"the memory is too small: it needs trocar_rig_size() or trocar_detector_size() bytes",
            Self::Alignment => {
                c"the memory is not aligned to trocar_rig_alignment() or trocar_detector_alignment() bytes"
            }
            Self::Setting => c"a setting is out of range",
            Self::Scenario => c"the scenario cannot be read",
            Self::NotInitialised => {
                c"the rig or the detector is not initialised: call trocar_rig_init or trocar_detector_init first"
            }
            Self::Panic => c"a defect of the library: the rig or the detector must not be used any more",
            Self::State => c"the state is damaged, or of a rig with other settings or of another version",
        }
    }

    const ALL: [Self; 10] = [
        Self::Ok,
        Self::Null,
        Self::StructSize,
        Self::MemorySize,
        Self::Alignment,
        Self::Setting,
        Self::Scenario,
        Self::NotInitialised,
        Self::Panic,
        Self::State,
    ];
}

/// Converts a panic of the body to a status.
#[cfg(feature = "std")]
#[inline(always)]
pub(crate) fn guarded(body: impl FnOnce() -> Status) -> Status {
    std::panic::catch_unwind(std::panic::AssertUnwindSafe(body)).unwrap_or(Status::Panic)
}

/// Runs the body. Without the standard library a panic goes to the panic handler.
#[cfg(not(feature = "std"))]
#[inline(always)]
pub(crate) fn guarded(body: impl FnOnce() -> Status) -> Status {
    body()
}

/// Stops the processor's program: a panic is a defect of the library, after which no command is valid. A watchdog then
/// switches the motors off.
#[cfg(all(feature = "panic-loop", not(feature = "std")))]
#[panic_handler]
fn stop(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {
        core::hint::spin_loop();
    }
}

/// Returns the text of a status: one line without a full stop, never freed. Unknown numbers also have a text.
#[allow(unsafe_code, reason = "the name is exported to C")]
#[unsafe(no_mangle)]
pub extern "C" fn trocar_status_text(status: i32) -> *const c_char {
    let known = Status::ALL.into_iter().find(|known| *known as i32 == status);
    known.map_or(c"unknown status", Status::text).as_ptr()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_status_has_its_number() {
        for (number, status) in Status::ALL.into_iter().enumerate() {
            assert_eq!(status as usize, number);
        }
    }

    #[cfg(feature = "std")]
    #[test]
    fn a_panic_becomes_a_status() {
        assert_eq!(guarded(|| panic!("a defect")), Status::Panic);
    }
}
