//! The controller of a rig ([`trocar_core::rig`]) for C and C++.
//!
//! The header `include/trocar.h` is generated from this source and from the declarations of the settings. The caller
//! owns all memory: a rig is initialised in memory of [`trocar_rig_size`] bytes, and no function keeps or frees
//! anything. A detector ([`trocar_detector_step`]) has estimator and detector alone. [`trocar_rig_step`] neither
//! allocates nor blocks. A panic becomes [`Status::Panic`].
//!
//! Without the feature `std` the crate needs neither operating system nor allocator, for example as a static library
//! for a microcontroller:
//!
//! ```text
//! cargo rustc -p trocar-c --lib --release --no-default-features --features panic-loop \
//!     --crate-type staticlib --target thumbv7em-none-eabihf
//! ```

#![warn(missing_docs)]
#![cfg_attr(not(feature = "std"), no_std)]

mod detector;
mod digest;
mod error_text;
mod memory;
mod rig;
mod safety;
mod settings;
mod state;
mod status;
#[cfg(feature = "toml")]
mod toml;

pub use detector::{
    Detection, Detector, DetectorSample, trocar_detector_alignment, trocar_detector_init, trocar_detector_size,
    trocar_detector_step, trocar_detector_step_numbered,
};
pub use rig::{
    Command, Rig, Sample, trocar_rig_alignment, trocar_rig_init, trocar_rig_size, trocar_rig_step,
    trocar_rig_step_numbered, trocar_version,
};
pub use safety::{Counts, trocar_rig_counts, trocar_rig_enable, trocar_rig_stop};
pub use settings::{Settings, trocar_rig_settings_default};
pub use state::{trocar_rig_restore, trocar_rig_save, trocar_rig_state_size};
pub use status::{Status, trocar_status_text};
#[cfg(feature = "toml")]
pub use toml::{trocar_detector_init_toml, trocar_rig_init_toml, trocar_rig_settings_from_toml};
