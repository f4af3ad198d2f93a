mod compare;
pub(crate) mod interval;
mod rows;
mod verify;

use std::collections::BTreeMap;

use nalgebra::DMatrix;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub(crate) use verify::unverified;

/// A quadratic function `V = zᵀ P z` of the scaled states `z = S⁻¹ x`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Lyapunov {
    /// The name, with the number of its node in time.
    pub name: String,
    /// The space of its states.
    pub space: String,
    /// The matrix P.
    #[serde(with = "rows")]
    #[schemars(with = "Vec<Vec<f64>>")]
    pub p: DMatrix<f64>,
}

/// The states of a phase.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StateSpace {
    /// The states, in order.
    pub states: Vec<State>,
    /// The lower triangular matrix S, from scaled states to states.
    #[serde(with = "rows")]
    #[schemars(with = "Vec<Vec<f64>>")]
    pub scale: DMatrix<f64>,
}

/// A state.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct State {
    /// Its name.
    pub name: String,
    /// Its unit.
    pub unit: String,
}

/// A map from the states of one space to the states of another.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StateMap {
    /// The name of the map.
    pub name: String,
    /// The space of the argument.
    pub from: String,
    /// The space of the result.
    pub to: String,
    /// The matrix.
    #[serde(with = "rows")]
    #[schemars(with = "Vec<Vec<f64>>")]
    pub matrix: DMatrix<f64>,
}

/// A term `factor · Mᵀ P M`, with `M` a product of maps.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Summand {
    /// The factor.
    pub factor: f64,
    /// Index of the function, from 0.
    pub function: usize,
    /// The maps; the first one is applied last.
    pub maps: Vec<MapFactor>,
}

/// A map in a product.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MapFactor {
    /// Index of the map, from 0.
    pub map: usize,
    /// True if the map is raised to each power of the inequality.
    pub is_power: bool,
}

/// A sum of terms that must be positive definite.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Inequality {
    /// The property that follows from it.
    pub name: String,
    /// The space of its rows.
    pub rows: String,
    /// The first and the last power for which it holds; `None` without a power.
    pub powers: Option<(u64, u64)>,
    /// The terms.
    pub terms: Vec<Summand>,
}

impl Inequality {
    fn conditions(&self) -> u64 {
        self.powers.map_or(1, |(begin, end)| end - begin + 1)
    }
}

/// The claims of a certificate and the parameters of its functions. With the scenario they determine the maps and the
/// inequalities.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Choice {
    /// Required ticks of teleoperation between two events.
    pub dwell_ticks: u64,
    /// Upper bound, at most 1, of the ratio of V at the beginnings of consecutive events: `ρ μ^(d-1)`.
    pub contraction: f64,
    /// Decay rate of V in teleoperation in 1/s: V decreases by `μ = exp(-rate · tick)` per tick.
    pub rate_per_s: f64,
    /// Bounds of the motion of needle and hand in m per newton of additional force; `None` if no motion is bounded.
    pub bounds_m_per_n: Option<[f64; 2]>,
    /// True if an additional force acts on the tissue, and the needle may lose contact at any tick.
    pub is_driven: bool,
    /// Time constant of the function on a held gap in s.
    pub hold_s: f64,
    /// Pieces of the functions in time, in each phase.
    pub pieces: u64,
}

/// Functions `V = zᵀ P z` on scaled states z, maps on states, and inequalities. They prove the decay of every sequence
/// of events, or bounds of the motion. An inequality states that a sum of `factor · Mᵀ P M` is positive definite. M is a
/// product of maps between scaled states, the first of which is applied last.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Certificate {
    /// The claims and the parameters of the functions.
    pub choice: Choice,
    /// Index of the function at the beginning of events, from 0.
    pub at_events: usize,
    /// The states of each phase, by name.
    pub spaces: BTreeMap<String, StateSpace>,
    /// The functions.
    pub functions: Vec<Lyapunov>,
    /// The maps.
    pub maps: Vec<StateMap>,
    /// The inequalities.
    pub inequalities: Vec<Inequality>,
}

impl Certificate {
    pub fn conditions(&self) -> u64 {
        self.inequalities.iter().map(Inequality::conditions).sum()
    }

    /// An upper bound for a dwell of at least the certificate's.
    pub fn growth_after(&self, dwell_ticks: u64, tick_s: f64) -> f64 {
        let Choice { contraction, rate_per_s, .. } = self.choice;
        let longer = dwell_ticks.saturating_sub(self.choice.dwell_ticks);
        let decay = (-tick_s * rate_per_s).exp();
        // Covers the roundings of the power.
        (contraction * decay.powf(longer as f64)).sqrt() * (1.0 + 1e-12)
    }

    /// For unscaled states.
    pub fn p_at_events(&self) -> DMatrix<f64> {
        let function = &self.functions[self.at_events];
        let scale = &self.spaces[&function.space].scale;
        let inverse = scale.clone().try_inverse().unwrap_or_else(|| scale.clone());
        let plain = inverse.transpose() * &function.p * inverse;
        (&plain + plain.transpose()) * 0.5
    }
}
