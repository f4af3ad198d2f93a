//! Scenarios: TOML in, a validated and resolved description out, echoed with every default written out.

mod build;
mod builtin;
mod document;
mod error;
mod key_table;
mod keys;
mod layer_keys;
mod layered;
mod link;
mod person;
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
pub use error::{Place, ScenarioError};
pub use key_table::{DISTANCES, KEYS, SECTIONS};
pub use keys::{Fallback, Key, find as find_key, nearest as nearest_key, nearest_of};
pub use replay::{DetectionSettings, DetectionSpec, RecordingSpec, recording_columns};
pub use resolve::{DelayTicks, EngineKind, Scenario, waits_for_tick};
pub use schema::json_schema;
pub use specs::{OperatorSpec, TissueSpec};
pub use starter::starter;
pub use template::{CaseFactory, Template};
pub use value::{Kind, Range, Value};
pub use values::{Values, harmless_name};
