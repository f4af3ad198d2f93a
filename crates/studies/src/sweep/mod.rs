//! Many runs of a scenario with varied keys and noise seeds.
//!
//! Case `i` is computed from `i` alone, so its result is the same in a separate run, a pack or a shard and on any
//! number of threads, and the memory does not grow with the number of cases. An interrupted sweep continues from the
//! stored packs of its [`Part`].

mod answer;
mod axis;
mod axis_column;
mod axis_file;
mod base;
mod canonical;
mod case_tables;
mod columns;
mod correlation;
mod design;
mod document;
mod drawn_cases;
mod equivalent_thresholds;
mod error;
mod execute;
mod file;
mod file_values;
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
pub use axis_column::AxisColumn;
pub(crate) use axis_file::{Section, axes_of};
pub(crate) use base::{SweptPopulation, check_acting, scenario_of};
pub(crate) use canonical::{hash_signals, resolved_toml, sha256};
pub use case_tables::case_tables;
pub use columns::Column;
pub use correlation::Correlation;
pub use design::{Design, MAX_CASES, SamplingScheme, UnitCoordinates};
pub use document::{SweepFile, SweepReport};
pub use drawn_cases::DrawnCases;
pub use error::SweepError;
pub use execute::{Execution, Progress, execute};
pub use file::SWEEP_KEYS;
pub(crate) use file::correlations_of;
pub(crate) use file_values::{line as line_of, must, name as name_of, texts, whole, within};
pub use merge::{CASES, Joined, MANIFEST, Manifest, SWEEP, join};
pub use part::{Layout, Outcome, PACK_CASES, PackRows, Part, Rows};
pub use permutation::Permutation;
pub(crate) use permutation::mix;
pub use plan::{CaseMaker, Plan, difference, is_sweep, stored_design};
pub use schema::sweep_schema;
pub use shard::Shard;
pub use sobol::{MAX_DIMENSIONS, Sobol};
pub use stability::LoopOfCase;
pub use statistics::{Cell, Findings, HeatMap, Influence, Influences, LevelMean, Spread, Summary, findings};
