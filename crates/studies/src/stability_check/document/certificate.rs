//! The file `certificate.json`.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::{Map, Value as Json};

use super::switching::{rows, seconds};
use crate::stability_check::verification::with_digest;
use trocar_document::json_of;
use trocar_stability::{Certificate, Inequality, Lyapunov, StateMap, StateSpace, Summand, Switching};

/// `certificate.json`: all data for an independent verification of the certificates. A matrix is a list of rows.
#[derive(Debug, Serialize, JsonSchema)]
pub struct CertificateFile<'a> {
    /// SHA-256 of the text of the file after this entry and its comma.
    sha256: &'static str,
    /// Length of a tick, in s.
    tick_s: f64,
    /// Minimum and maximum stiffness of the tissue, in N/m.
    stiffness_n_per_m: (f64, f64),
    /// Damping of the tissue, in N·s/m.
    damping_n_s_per_m: f64,
    /// Delay around the loop, in ticks.
    delay_ticks: u64,
    certificates: Certificates<'a>,
}

/// The certificates by name.
#[derive(Debug, Serialize, JsonSchema)]
struct Certificates<'a> {
    /// The certificate with the shortest time between events.
    #[serde(skip_serializing_if = "Option::is_none")]
    shortest_dwell: Option<CertificateEntry<'a>>,
    /// The certificate of the smallest growth at the refractory time of the supervisor.
    #[serde(skip_serializing_if = "Option::is_none")]
    growth_at_refractory: Option<CertificateEntry<'a>>,
    /// The certificate of the statement. The rows of `quantity_0` and `quantity_1` are the positions of needle and hand
    /// over their bounds for an additional force of 1 N.
    #[serde(skip_serializing_if = "Option::is_none")]
    statement: Option<CertificateEntry<'a>>,
}

/// A certificate: functions `V = zᵀ P z` on scaled states z, maps on states, and inequalities. An inequality states
/// that a sum of `factor · Mᵀ P M` is positive definite. M is a product of maps between scaled states, the first of
/// which is applied last.
#[derive(Debug, Serialize, JsonSchema)]
struct CertificateEntry<'a> {
    /// Required time between two events, in s.
    dwell_s: f64,
    /// Required time between two events, in ticks.
    dwell_ticks: u64,
    /// Bound of the ratio of V per tick of teleoperation.
    decay: f64,
    /// Bound of the ratio of V between the beginnings of consecutive events.
    contraction: f64,
    /// Index of the function at the beginnings of events, from 0.
    at_events: usize,
    /// The states of each phase, by name.
    #[schemars(with = "BTreeMap<String, Space<'a>>")]
    spaces: Map<String, Json>,
    /// The functions.
    functions: Vec<FunctionEntry<'a>>,
    /// The maps.
    maps: Vec<MapEntry<'a>>,
    /// The inequalities.
    inequalities: Vec<InequalityEntry<'a>>,
}

/// The states of a phase.
#[derive(Debug, Serialize, JsonSchema)]
struct Space<'a> {
    /// The states, in order.
    states: Vec<StateEntry<'a>>,
    /// The matrix S, from scaled states to states.
    scale: Vec<Vec<f64>>,
}

/// A state.
#[derive(Debug, Serialize, JsonSchema)]
struct StateEntry<'a> {
    /// Its name.
    name: &'a str,
    /// Its unit.
    unit: &'static str,
}

/// A map from the states of one space to the states of another.
#[derive(Debug, Serialize, JsonSchema)]
struct MapEntry<'a> {
    /// Its name.
    name: &'a str,
    /// The source space.
    from: &'a str,
    /// The target space.
    to: &'a str,
    /// The matrix.
    matrix: Vec<Vec<f64>>,
}

/// A function `V = zᵀ P z` on scaled states.
#[derive(Debug, Serialize, JsonSchema)]
struct FunctionEntry<'a> {
    /// Its name.
    name: &'a str,
    /// The space of its states.
    space: &'a str,
    /// The matrix P.
    p: Vec<Vec<f64>>,
}

/// A positive definite sum of terms.
#[derive(Debug, Serialize, JsonSchema)]
struct InequalityEntry<'a> {
    /// The property that follows from it.
    name: &'a str,
    /// The space of its rows.
    rows: &'a str,
    /// The first and last power for which it holds; `None` without a power.
    powers: Option<(u64, u64)>,
    /// The terms.
    terms: Vec<TermEntry>,
}

/// A term `factor · Mᵀ P M`.
#[derive(Debug, Serialize, JsonSchema)]
struct TermEntry {
    /// The factor.
    factor: f64,
    /// Index of the function, from 0.
    function: usize,
    /// The maps; the first one is applied last.
    maps: Vec<Factor>,
}

/// A map in a product.
#[derive(Debug, Serialize, JsonSchema)]
struct Factor {
    /// Index of the map, from 0.
    map: usize,
    /// True if the map is raised to each power of the inequality.
    is_power: bool,
}

pub(super) fn certificate_json(switching: &Switching) -> Option<String> {
    let shortest_dwell = switching.certificate.as_ref();
    let statement = switching.peaks.as_ref().map(|peaks| &peaks.certificate);
    if shortest_dwell.is_none() && statement.is_none() {
        return None;
    }
    let of = |found| CertificateEntry::of(switching, found);
    let whole = CertificateFile {
        // Depends on the text of the others.
        sha256: "",
        tick_s: switching.settings.of_loop.tick_s,
        stiffness_n_per_m: switching.settings.stiffness_n_per_m,
        damping_n_s_per_m: switching.settings.of_loop.damping_n_s_per_m,
        delay_ticks: switching.settings.delay_ticks(),
        certificates: Certificates {
            shortest_dwell: shortest_dwell.map(of),
            growth_at_refractory: switching.at_refractory.as_ref().map(of),
            statement: statement.map(of),
        },
    };
    serde_json::to_string(&whole).ok().map(|text| with_digest(&(text + "\n")))
}

fn named(spaces: &[StateSpace]) -> Map<String, Json> {
    let space = |space: &StateSpace| {
        let states = space.states.iter().map(|(name, unit)| StateEntry { name, unit }).collect();
        (space.name.clone(), json_of(&Space { states, scale: rows(&space.scale) }))
    };
    spaces.iter().map(space).collect()
}

fn maps_of<'a>(maps: &'a [StateMap], spaces: &'a [StateSpace]) -> Vec<MapEntry<'a>> {
    let name = |place: usize| spaces[place].name.as_str();
    let map = |StateMap { name: of_map, from, to, matrix }: &'a StateMap| MapEntry {
        name: of_map,
        from: name(*from),
        to: name(*to),
        matrix: rows(matrix),
    };
    maps.iter().map(map).collect()
}

impl<'a> CertificateEntry<'a> {
    fn of(switching: &Switching, certificate: &'a Certificate) -> Self {
        let name = |place: usize| certificate.spaces[place].name.as_str();
        let function = |Lyapunov { name: of_function, matrix, space }: &'a Lyapunov| FunctionEntry {
            name: of_function,
            space: name(*space),
            p: rows(matrix),
        };
        let inequality = |one: &'a Inequality| InequalityEntry {
            name: &one.name,
            rows: name(one.rows),
            powers: one.powers,
            terms: one.terms.iter().map(TermEntry::of).collect(),
        };
        Self {
            dwell_s: seconds(switching, certificate.dwell_ticks),
            dwell_ticks: certificate.dwell_ticks,
            decay: certificate.decay,
            contraction: certificate.contraction,
            at_events: certificate.at_events,
            spaces: named(&certificate.spaces),
            functions: certificate.functions.iter().map(function).collect(),
            maps: maps_of(&certificate.maps, &certificate.spaces),
            inequalities: certificate.inequalities.iter().map(inequality).collect(),
        }
    }
}

impl TermEntry {
    fn of(term: &Summand) -> Self {
        let &Summand { factor, function, ref maps } = term;
        Self { factor, function, maps: maps.iter().map(|&(map, is_power)| Factor { map, is_power }).collect() }
    }
}
