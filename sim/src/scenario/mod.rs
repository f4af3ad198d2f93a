//! Scenarios: TOML in, a validated and resolved description out, echoed with every default written out.

mod build;
mod builtin;
mod document;
mod engine_kind;
mod error;
mod key_table;
mod keys;
mod link;
mod replay;
mod resolve;
mod rig;
mod schedule;
mod schema;
mod settings;
mod specs;
mod starter;
mod steps;
mod template;
mod value;
mod values;

pub use build::ScenarioEngine;
pub use builtin::questions as shipped_questions;
pub use document::{Entry, Source, entries};
pub use engine_kind::EngineKind;
pub use error::{Place, ScenarioError};
pub use key_table::{KEYS, SECTIONS};
pub use keys::{find as find_key, nearest as nearest_key, nearest_of};
pub use replay::{DetectionSettings, DetectionSpec, RecordingSpec, recording_columns};
pub use resolve::{DelayTicks, Scenario, waits_for_tick};
pub use schema::json_schema;
pub use specs::{OperatorSpec, TissueSpec};
pub use starter::starter;
pub use template::{CaseFactory, Template};
pub use trocar_core::settings::{Constant, Fallback, Key, Kind, Range};
pub use value::Value;
pub use values::{Values, harmless_name};
