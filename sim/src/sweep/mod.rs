//! Sweeps: a scenario run many times over, with keys that vary and many seeds of noise.
//!
//! A sweep file ([`Plan`]) says which keys take which values and how they are combined ([`Design`]). Case `i` is computed from
//! `i` alone, so that it is the same by itself, in a pack, in a shard and on any number of threads; nothing grows with the
//! number of cases. What comes out is kept in a [`Part`]: a file with a slot for each pack of eight cases, written as the pack
//! is done, so that a run that was ended in any way goes on where it was, and parts that were computed apart are joined by
//! reading one after the other.

mod axis;
mod axis_column;
mod columns;
mod design;
mod equivalent_thresholds;
mod error;
mod execute;
mod file;
mod merge;
mod part;
mod permutation;
mod plan;
mod schema;
mod shard;
mod shared_runs;
mod sobol;
mod stability;
mod statistics;

pub use axis::{Axis, Levels, number};
pub use axis_column::{AxisColumn, text};
pub use columns::Column;
pub use design::{Design, MAX_CASES, SamplingScheme, UnitCoordinates};
pub use error::SweepError;
pub use execute::{Execution, Progress, execute};
pub use file::SWEEP_KEYS;
pub use merge::{CASES, Joined, MANIFEST, Manifest, SWEEP, join};
pub use part::{Layout, Outcome, PACK_CASES, PackRows, Part, Rows};
pub use permutation::Permutation;
pub use plan::{CaseMaker, Plan, difference};
pub use schema::sweep_schema;
pub use shard::Shard;
pub use sobol::{MAX_DIMENSIONS, Sobol};
pub use stability::LoopOfCase;
pub use statistics::{Cell, Findings, HeatMap, Influence, Influences, Spread, Summary, findings};
