//! Scenarios: TOML in, a validated and resolved description out, echoed with every default written out.

mod build;
pub mod builtin;
mod document;
mod error;
mod keys;
mod resolve;
mod schema;
mod starter;
mod value;
mod values;

pub use build::ScenarioEngine;
pub use document::Source;
pub use error::{Place, ScenarioError};
pub use keys::{DISTANCES, Fallback, KEYS, Key, SECTIONS};
pub use resolve::{DetectionSpec, EngineKind, OperatorSpec, RecordingSpec, Scenario, TissueSpec};
pub use schema::json_schema;
pub use starter::starter;
pub use value::{Kind, Range, Value};
pub use values::Values;
