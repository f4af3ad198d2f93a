//! Recordings of insertions, read from files of several [formats](Format), and traces of link delays, read from CSV
//! files.
//!
//! A recording is the log of a rig: time, position of the needle, optionally its velocity, and the force on it. Column
//! names, units and signs differ between laboratories, so the caller gives a [`Column`] for each quantity, with a
//! factor to SI units, forces being positive when they resist insertion.
//!
//! Without the feature `formats` it reads tables in text alone.
//!
//! ```
//! # mod trocar { pub use trocar_recording as recording; }
//! use trocar::recording::{Columns, Limits, read_csv};
//!
//! let table = "t_s,xs_rad,tau_Nm\n0.0,0.10,0.15\n0.001,0.12,0.30\n";
//! // A lever of 0.075 m: position = 0.075 * angle, force = torque / 0.075.
//! let columns = Columns {
//!     time: "t_s".parse()?,
//!     position: "xs_rad:0.075".parse()?,
//!     velocity: None,
//!     force: "tau_Nm:13.333333333333334".parse()?,
//! };
//! let recording = read_csv("lever.csv", table.as_bytes(), &columns, &Limits::default())?;
//! assert_eq!(recording.len(), 2);
//! assert_eq!(recording.force_n(), [2.0, 4.0]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

// Some parts are for the readers of other files than text.
#![cfg_attr(not(feature = "formats"), allow(dead_code))]
mod arrays;
mod block;
mod column;
#[cfg_attr(not(feature = "formats"), path = "no_containers.rs")]
mod containers;
mod delays;
mod error;
mod file;
mod format;
mod guard;
mod head;
mod header;
mod in_vivo_like;
#[cfg(feature = "formats")]
mod keep;
mod labels;
mod labview;
mod limits;
mod live;
mod matrices;
mod memory;
mod number;
mod quantity;
mod read;
mod resample;
mod responses;
mod room;
mod samples;
mod settings;
mod signals;
mod spaces;
mod stamp;
mod table;
mod units;
mod utf16;

pub use arrays::{ArrayError, first_where};
pub use column::{Column, ColumnError, Columns, offset_splits};
pub use delays::{DelayRow, read_delays};
pub use error::{Place, Problem, RecordingError, Row};
pub use file::{list_signals, open_delays, open_labels, open_recording, open_response, read_file, signal_names};
pub use format::Format;
pub use in_vivo_like::{InVivoLikeVariant, RUPTURES_S, in_vivo_like_csv, in_vivo_like_variant_csv};
#[cfg(feature = "formats")]
pub use keep::keep;
pub use labels::{LabelRow, read_labels};
pub use limits::Limits;
pub use live::{LiveLine, LiveSample, LiveTable};
pub use matrices::{Matrix, read_matrices};
pub use memory::{MEMORY, kept};
pub use quantity::Quantity;
pub use read::{read_csv, scan_csv};
pub use resample::{ResampleError, Resampled};
pub use responses::{ResponseRow, read_response};
pub use samples::{Joined, Recording};
pub use settings::{ColumnSettings, FileSettings, OffsetSettings, ScaleSettings, SignSettings};
pub use signals::{Roles, Signal, signals_by_name};
pub use stamp::CALENDAR_S;
pub use units::IgnoredUnit;

#[cfg(test)]
mod fixtures;
