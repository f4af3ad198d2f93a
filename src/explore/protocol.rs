//! What a page and its server say to each other.

use serde::Deserialize;

use super::state::State;

/// What a page asks for; `id` comes back with the answer.
#[derive(Debug, Clone, Deserialize)]
#[serde(tag = "type", rename_all = "lowercase", deny_unknown_fields)]
pub(super) enum Request {
    /// The scenario's own values, for the controls.
    Open {
        /// Of the request.
        id: u32,
        /// Its name in the catalogue.
        scenario: String,
    },
    /// Both runs of a state.
    Show(Show),
    /// The stability map of a state.
    Map(MapRequest),
    /// A file of a state.
    Export(Export),
    /// An insertion by hand begins.
    Push {
        /// Of the request.
        id: u32,
        /// What is pushed into.
        state: State,
        /// Classical or augmented.
        augmented: bool,
    },
    /// Where the hand aims at, in m.
    Aim {
        /// Desired position in m.
        m: f64,
    },
    /// The insertion by hand ends.
    Stop {},
}

/// Both runs of a state are to be shown.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Show {
    pub id: u32,
    pub state: State,
    /// How many points a line has at most.
    pub points: usize,
    /// From and to, in s; all of it where there is none.
    #[serde(default)]
    pub window_s: Option<(f64, f64)>,
}

/// A stability map.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MapRequest {
    pub id: u32,
    pub state: State,
    pub x: String,
    pub y: String,
}

/// Which file is wanted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum File {
    /// The resolved scenario.
    Toml,
    /// Every signal at every tick.
    Csv,
}

/// A file of one run of a state.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Export {
    pub id: u32,
    pub state: State,
    pub augmented: bool,
    pub file: File,
}

/// What goes to a page.
#[derive(Debug, Clone)]
pub(super) enum Answer {
    /// JSON.
    Text(String),
    /// A [frame](super::frame).
    Frame(Vec<u8>),
}

impl Answer {
    /// A JSON object.
    pub(super) fn json(value: &serde_json::Value) -> Self {
        Self::Text(value.to_string())
    }

    /// What was asked for cannot be had, and why.
    pub(super) fn refused(id: u32, reason: &dyn std::fmt::Display) -> Self {
        Self::json(&serde_json::json!({ "type": "refused", "id": id, "message": reason.to_string() }))
    }
}
