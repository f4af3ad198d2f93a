//! Scenarios: from TOML to a validated and resolved description, and random [people, tissues and links](population)
//! around it.
//!
//! The crate depends only on `trocar-core`, `trocar-base`, `trocar-recording` and `trocar-engine`. The shipped
//! scenarios are embedded. The crate `trocar` re-exports it as `trocar::scenario`.
mod build;
mod builtin;
mod clutch;
mod diagnostic;
mod document;
mod engine_kind;
mod error;
mod intervals;
mod kept_files;
mod key_table;
mod keys;
mod layers;
mod link;
mod machine_file;
mod parts;
pub mod population;
mod quantity;
mod replay;
mod resolve;
mod rig;
mod run_settings;
mod scenario;
mod schedule;
mod schedule_settings;
mod schema;
mod settings;
mod spared;
mod specs;
mod starter;
mod steps;
mod template;
mod tissue_range;
mod trace;
mod unread;
mod value;
mod values;

pub use build::ScenarioEngine;
pub use builtin::{questions as shipped_questions, sweeps as shipped_sweeps};
pub use diagnostic::underlined;
pub use document::{Entry, Source, entries, is_axis, is_design_goal};
pub use engine_kind::EngineKind;
pub use error::{Place, ScenarioError};
pub use kept_files::{FileContents, KeptFiles};
pub use key_table::{KEYS, SECTIONS};
pub use keys::{KeyAt, find as find_key, nearest as nearest_key, nearest_of};
pub use layers::{NAME_PATTERN, NAME_RULE};
pub use quantity::{parse as parse_quantity, parse_column, parse_number, unit_of};
pub use replay::{DetectionSettings, DetectionSpec, RecordingSpec, recording_columns, recording_signals};
pub use resolve::{DelayTicks, waits_for_tick};
pub use scenario::Scenario;
pub use schema::{json_schema, number_schema};
pub use specs::{OperatorSpec, TissueSpec};
pub use starter::Starter;
pub use template::{CaseFactory, Template};
pub use tissue_range::{OVERSHOOT, TissueByDepth, TissueRange, TissueSource};
pub use trace::{empty_trace, empty_trace_with};
pub use trocar_core::settings::{Constant, Fallback, Key, Kind, Range};
pub use unread::{Reader, idle_keys, keys_outside_loop, keys_without_effect};
pub use value::Value;
pub use values::{Values, harmless_name};
