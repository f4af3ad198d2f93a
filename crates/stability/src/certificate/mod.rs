//! The certificate of events and its verification, which know nothing of the search.

pub(crate) mod interval;
mod verify;

use nalgebra::DMatrix;

pub(crate) use verify::unverified;

/// A quadratic function of a certificate.
#[derive(Debug, Clone)]
pub struct Lyapunov {
    /// The name, with the number of its node in time.
    pub name: String,
    /// `P̂` in `V = zᵀ P̂ z`, with the scaled states `z = S⁻¹ x`.
    pub matrix: DMatrix<f64>,
    /// Index of the space in [`Certificate::spaces`].
    pub space: usize,
}

/// The states of a phase.
#[derive(Debug, Clone)]
pub struct StateSpace {
    /// The name of the space.
    pub name: String,
    /// Name and unit of each state, in order.
    pub states: Vec<(String, &'static str)>,
    /// `S`, from scaled states to states.
    pub scale: DMatrix<f64>,
}

/// A map between the states of two spaces.
#[derive(Debug, Clone)]
pub struct StateMap {
    /// The name of the map.
    pub name: String,
    /// Index of the space of the argument.
    pub from: usize,
    /// Index of the space of the result.
    pub to: usize,
    /// The matrix.
    pub matrix: DMatrix<f64>,
}

/// `f Mᵀ P M` with `M` a product of maps.
#[derive(Debug, Clone)]
pub struct Summand {
    /// `f`.
    pub factor: f64,
    /// Index of the function.
    pub function: usize,
    /// Indices of the maps, the first one applied last; true for the map with the power of the inequality.
    pub maps: Vec<(usize, bool)>,
}

/// A sum that must be positive definite.
#[derive(Debug, Clone)]
pub struct Inequality {
    /// The purpose of the inequality.
    pub name: String,
    /// Index of the space of its rows.
    pub rows: usize,
    /// The first and the last power for which the inequality holds.
    pub powers: Option<(u64, u64)>,
    /// The terms.
    pub terms: Vec<Summand>,
}

impl Inequality {
    /// Number of conditions: one for each power.
    pub(crate) fn conditions(&self) -> u64 {
        self.powers.map_or(1, |(begin, end)| end - begin + 1)
    }
}

/// Lyapunov functions that prove the decay of every sequence of events, or a bound of a quantity.
#[derive(Debug, Clone)]
pub struct Certificate {
    /// Required ticks of teleoperation between two events.
    pub dwell_ticks: u64,
    /// Verified upper bound, at most 1, of the ratio of `V` at the beginnings of consecutive events.
    pub contraction: f64,
    /// Verified factor of `V` per tick of teleoperation, at most 1.
    pub decay: f64,
    /// The solver's common margin of all scaled conditions; not necessarily the maximum.
    pub margin: f64,
    /// Number of verified conditions, counting each power.
    pub conditions: u64,
    /// Index of the function at the beginning of events.
    pub at_events: usize,
    /// The states of each phase.
    pub spaces: Vec<StateSpace>,
    /// The functions.
    pub functions: Vec<Lyapunov>,
    /// The maps.
    pub maps: Vec<StateMap>,
    /// The verified inequalities.
    pub inequalities: Vec<Inequality>,
}

impl Certificate {
    /// A bound of the growth per event for a dwell that is at least the certificate's.
    #[must_use]
    pub fn growth_after(&self, dwell_ticks: u64) -> f64 {
        let longer = dwell_ticks.saturating_sub(self.dwell_ticks);
        // The factor covers the roundings of the power.
        (self.contraction * self.decay.powf(longer as f64)).sqrt() * (1.0 + 1e-12)
    }

    /// Returns `P` of the function at the beginning of events, for unscaled states.
    #[must_use]
    pub fn p_at_events(&self) -> DMatrix<f64> {
        let function = &self.functions[self.at_events];
        let scale = &self.spaces[function.space].scale;
        let inverse = scale.clone().try_inverse().unwrap_or_else(|| scale.clone());
        let plain = inverse.transpose() * &function.matrix * inverse;
        (&plain + plain.transpose()) * 0.5
    }
}
