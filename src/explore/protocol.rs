use serde::Deserialize;

use super::state::State;

/// The answer has the same `id`.
#[derive(Debug, Clone, Deserialize)]
#[serde(tag = "type", rename_all = "lowercase", deny_unknown_fields)]
pub(super) enum Request {
    Open {
        id: u32,
        scenario: String,
    },
    Show(Show),
    Map(MapRequest),
    Export(Export),
    Push {
        id: u32,
        state: State,
        augmented: bool,
    },
    /// Runs an insertion by hand up to now.
    Aim {
        id: u32,
        /// Desired position in m.
        m: f64,
    },
    Stop {
        id: u32,
    },
    /// Checks the runs of the last state in noise.
    Noise {
        id: u32,
    },
}

impl Request {
    pub(super) fn id(&self) -> u32 {
        match self {
            Self::Open { id, .. } | Self::Push { id, .. } | Self::Aim { id, .. } => *id,
            Self::Stop { id } | Self::Noise { id } => *id,
            Self::Show(show) => show.id,
            Self::Map(map) => map.id,
            Self::Export(export) => export.id,
        }
    }
}

#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Show {
    pub id: u32,
    pub state: State,
    /// Maximum number of points per line.
    pub points: usize,
    #[serde(default)]
    pub window: ShownTime,
}

/// The time range of the lines.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum ShownTime {
    /// Around the first rupture.
    #[default]
    Rupture,
    All,
    /// From one time to another, in s.
    Between(f64, f64),
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MapRequest {
    pub id: u32,
    pub state: State,
    pub x: String,
    pub y: String,
    /// By default around the values of the state.
    #[serde(default)]
    pub x_range: Option<(f64, f64)>,
    #[serde(default)]
    pub y_range: Option<(f64, f64)>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum File {
    Toml,
    /// All signals at every tick.
    Csv,
    Png,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Export {
    pub id: u32,
    pub state: State,
    pub augmented: bool,
    pub file: File,
    #[serde(default)]
    pub window: ShownTime,
    /// With its unit.
    #[serde(default)]
    pub width: Option<String>,
}

#[derive(Debug, Clone)]
pub(super) enum ServerMessage {
    Text(String),
    Frame(Vec<u8>),
}

impl ServerMessage {
    pub(super) fn json(value: &serde_json::Value) -> Self {
        Self::Text(value.to_string())
    }

    pub(super) fn refused(id: u32, reason: &dyn std::fmt::Display) -> Self {
        Self::refused_for(id, reason, &[reason.to_string()])
    }

    pub(super) fn refused_for(id: u32, reason: &dyn std::fmt::Display, all: &[String]) -> Self {
        Self::json(&serde_json::json!({ "type": "refused", "id": id, "message": reason.to_string(), "all": all }))
    }
}
