//! The inequalities of a certificate.
//!
//! Each mode has a Lyapunov function `V = xᵀ P x`, linked along the phases of an event. With the maps of `modes.rs`, at
//! both ends `v` of the stiffness's range (the maps are affine in `K`, the inequalities convex in the maps, so they
//! also hold for each `K` between, and for one that changes from tick to tick):
//!
//! ```text
//! dwelling        A_vᵀ P_T(t+1) A_v < P_T(t), 0 <= t < d - 1;   then A_vᵀ P_T(d-1) A_v < P_T(d-1)
//! entering        E_vᵀ P_F E_v < P_T(d-1);   where all frozen ticks are equal, E is followed by the shortest freeze
//! frozen          F_vᵀ P_F F_v < (1 + ε) P_F
//! releasing       Rᵀ (P_R(0) ⊕ p_R(0)) R < (1 + ε)^-(longest - shortest) P_F
//! cross-fade      (B_vᵀ P_R(t+1) B_v) ⊕ p_R(t+1) < P_R(t) ⊕ p_R(t)
//! faded           P_G < P_R(end), γ < p_R(end)
//! closing the gap [A_v b]ᵀ P_G [A_v b] < a P_G ⊕ (1 - a) γ, so that max(xᵀ P_G x, γ g²) cannot grow while |g| does not
//! closed          P_T(0) < P_G
//! ```
//! With at least `d` ticks of teleoperation between events, `V` decreases from the beginning of one event to that of
//! the next: the state converges exponentially for every order and length of the phases (dwell-time conditions after
//! Geromel and Colaneri, *SIAM J. Control Optim.* 45, 2006; functions linear between nodes after Allerhand and Shaked,
//! *IEEE Trans. Autom. Control* 56, 2011). A kept gap (`clutch`) persists into the next event: the function at the
//! events is then `max(xᵀ P_G x, γ g²)`, and no dwell is needed.
//!
//! `P_T` and `P_R` are linear in time between nodes; a condition for a tick is then also linear in time, and holds
//! within a piece if it holds for its first and last tick.

use nalgebra::DMatrix;

use super::interval::{Enclosure, exact, middle, power, product, rounded, transpose};
use super::modes::Modes;
use super::sdp;
use super::settings::Phases;
use crate::augmentation::cross_fade;

/// Number of pieces of `P_T`.
const DWELL_PIECES: u64 = 2;

/// Number of pieces of `P_R`.
const BLEND_PIECES: u64 = 1;

/// The factor by which `V` may grow between the shortest and the longest freeze.
pub(super) const GROWTH_FROZEN: f64 = 1.1;

/// The weight of a condition per tick relative to one per event.
const PER_TICK: f64 = 1e-2;

/// A space of states.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Space {
    Loop,
    Frozen,
    Fading,
    Gap,
}

/// `c Mᵀ X M`, with an enclosure of the map.
#[derive(Debug, Clone)]
pub(super) struct Term {
    pub(super) factor: super::interval::Interval,
    pub(super) unknown: usize,
    pub(super) map: Enclosure,
}

/// A sum of terms that must be positive definite.
#[derive(Debug, Clone)]
pub(super) struct Condition {
    pub(super) name: &'static str,
    pub(super) terms: Vec<Term>,
    /// The spaces of its rows.
    pub(super) rows: Vec<Space>,
    pub(super) weight: f64,
}

/// All conditions for a dwell, and their unknown matrices.
#[derive(Debug, Clone)]
pub(super) struct Conditions {
    pub(super) unknowns: Vec<Space>,
    pub(super) list: Vec<Condition>,
    pub(super) roles: Roles,
}

/// The roles of the unknowns.
#[derive(Debug, Clone)]
pub(super) struct Roles {
    /// `P_T` at the nodes; the last one is constant from then on. Only `P_G` if the gap is kept.
    pub(super) dwelling: Vec<usize>,
    pub(super) frozen: usize,
    pub(super) fading: Vec<usize>,
    /// `P_G` and `γ`.
    pub(super) closing: Option<(usize, usize)>,
}

/// The parameters of a certificate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Choice {
    /// Ticks of teleoperation between events.
    pub(super) dwell: u64,
    /// `a` of the conditions above, a multiple of a power of 1/2 so that `1 - a` is exact.
    pub(super) decay: f64,
}

/// Builds the conditions.
struct Builder<'a> {
    modes: &'a Modes,
    unknowns: Vec<Space>,
    list: Vec<Condition>,
}

fn number(value: f64) -> super::interval::Interval {
    super::interval::Interval::exact(value)
}

/// A quotient, with rounding.
fn share(part: u64, whole: u64) -> super::interval::Interval {
    super::interval::Interval::rounded(part as f64 / whole as f64)
}

impl Builder<'_> {
    fn unknown(&mut self, space: Space) -> usize {
        self.unknowns.push(space);
        self.unknowns.len() - 1
    }

    fn add(&mut self, name: &'static str, rows: &[Space], weight: f64, terms: Vec<Term>) {
        self.list.push(Condition { name, terms, rows: rows.to_vec(), weight });
    }

    fn size(&self, spaces: &[Space]) -> usize {
        spaces.iter().map(|&space| size(self.modes, space)).sum()
    }

    /// The rows of an identity that select the part at `index` of a sum of spaces.
    fn part(&self, spaces: &[Space], index: usize) -> Enclosure {
        let before = self.size(&spaces[..index]);
        let rows = self.size(&spaces[index..=index]);
        exact(&DMatrix::from_fn(rows, self.size(spaces), |i, j| f64::from(u8::from(before + i == j))))
    }
}

/// Number of states of a space.
pub(super) fn size(modes: &Modes, space: Space) -> usize {
    match space {
        Space::Loop => modes.states(),
        Space::Frozen => modes.frozen_states(),
        Space::Fading => modes.states() + 1,
        Space::Gap => 1,
    }
}

fn term(factor: super::interval::Interval, unknown: usize, map: &Enclosure) -> Term {
    Term { factor, unknown, map: map.clone() }
}

/// The lengths of a phase's pieces in ticks.
fn pieces(ticks: u64, max: u64) -> Vec<u64> {
    let count = max.min(ticks);
    (0..count).map(|k| (k + 1) * ticks / count - k * ticks / count).collect()
}

impl Conditions {
    pub(super) fn new(modes: &Modes, phases: Phases, choice: Choice) -> Self {
        let mut builder = Builder { modes, unknowns: vec![], list: vec![] };
        let closing = modes.has_gap().then(|| (builder.unknown(Space::Loop), builder.unknown(Space::Gap)));
        let lengths = if modes.gap_closes() { pieces(choice.dwell - 1, DWELL_PIECES) } else { vec![] };
        let dwelling = match closing {
            Some((of_loop, _)) if !modes.gap_closes() => vec![of_loop],
            _ => (0..=lengths.len()).map(|_| builder.unknown(Space::Loop)).collect(),
        };
        let frozen = builder.unknown(Space::Frozen);
        let faded = pieces(phases.blend, BLEND_PIECES);
        let fading: Vec<usize> = (0..=faded.len()).map(|_| builder.unknown(Space::Fading)).collect();
        let gaps: Vec<usize> =
            if modes.has_gap() { (0..=faded.len()).map(|_| builder.unknown(Space::Gap)).collect() } else { vec![] };
        let roles = Roles { dwelling, frozen, fading: fading.clone(), closing };

        for unknown in 0..builder.unknowns.len() {
            let rows = [builder.unknowns[unknown]];
            let one = builder.part(&rows, 0);
            builder.add("positive", &rows, PER_TICK, vec![term(number(1.0), unknown, &one)]);
        }
        builder.dwell(&roles, &lengths);
        builder.freeze(&roles, &gaps, phases, choice);
        builder.fade(&roles, &gaps, &faded);
        builder.close(&roles, &gaps, choice);
        Self { unknowns: builder.unknowns, list: builder.list, roles }
    }

    /// The sizes of the unknown matrices.
    pub(super) fn sizes(&self, modes: &Modes) -> Vec<usize> {
        self.unknowns.iter().map(|&space| size(modes, space)).collect()
    }

    /// The conditions for the solver, on states scaled by `scale`, which maps scaled states to states.
    pub(super) fn scaled(&self, scale: impl Fn(Space) -> DMatrix<f64>) -> Vec<sdp::Condition> {
        let inverse = |space| scale(space).try_inverse().unwrap_or_else(|| scale(space));
        self.list
            .iter()
            .map(|condition| {
                let blocks: Vec<DMatrix<f64>> = condition.rows.iter().map(|&space| scale(space)).collect();
                let all: usize = blocks.iter().map(DMatrix::nrows).sum();
                let mut rows = DMatrix::zeros(all, all);
                let mut at = 0;
                for block in &blocks {
                    rows.view_mut((at, at), block.shape()).copy_from(block);
                    at += block.nrows();
                }
                let terms = condition.terms.iter().map(|term| sdp::Term {
                    factor: 0.5 * (term.factor.low + term.factor.high),
                    unknown: term.unknown,
                    map: inverse(self.unknowns[term.unknown]) * middle(&term.map) * &rows,
                });
                sdp::Condition { terms: terms.collect(), weight: condition.weight, row: None, offset: 0.0 }
            })
            .collect()
    }
}

impl Condition {
    /// The enclosure of the condition's matrix, for exact unknown matrices.
    pub(super) fn enclosure(&self, unknowns: &[DMatrix<f64>]) -> Enclosure {
        let mut sum: Option<Enclosure> = None;
        for Term { factor, unknown, map } in &self.terms {
            let mut value = product(&transpose(map), &product(&exact(&unknowns[*unknown]), map));
            for entry in value.iter_mut().flatten() {
                *entry = *entry * *factor;
            }
            sum = Some(match sum {
                None => value,
                Some(before) => {
                    before.iter().zip(&value).map(|(a, b)| a.iter().zip(b).map(|(x, y)| *x + *y).collect()).collect()
                }
            });
        }
        sum.unwrap_or_default()
    }
}

impl Builder<'_> {
    fn dwell(&mut self, roles: &Roles, lengths: &[u64]) {
        if !self.modes.gap_closes() {
            return;
        }
        let rows = [Space::Loop];
        let one = self.part(&rows, 0);
        let maps: Vec<Enclosure> = (0..2).map(|vertex| rounded(&self.modes.teleoperation(vertex))).collect();
        for (&last, map) in std::iter::repeat(&roles.dwelling[lengths.len()]).zip(&maps) {
            let terms = vec![term(number(1.0), last, &one), term(number(-1.0), last, map)];
            self.add("dwelling", &rows, PER_TICK, terms);
        }
        for (piece, &ticks) in lengths.iter().enumerate() {
            let nodes = (roles.dwelling[piece], roles.dwelling[piece + 1]);
            for map in &maps {
                for terms in along(nodes, ticks, &one, map) {
                    self.add("dwelling", &rows, PER_TICK, terms);
                }
            }
        }
    }

    fn freeze(&mut self, roles: &Roles, gaps: &[usize], phases: Phases, choice: Choice) {
        let modes = self.modes;
        let (shortest, longest) = phases.held;
        let is_unique = modes.is_frozen_map_unique();
        let extra = if is_unique { longest - shortest } else { longest };
        let at_events = *roles.dwelling.last().unwrap_or(&0);
        for vertex in 0..2 {
            let mut map = rounded(&modes.entry(vertex));
            if is_unique {
                map = product(&power(&rounded(&modes.frozen(0, 1.0)), shortest), &map);
            }
            let (rows, mut terms) = match roles.closing {
                Some((of_loop, of_gap)) if !modes.gap_closes() => {
                    let rows = vec![Space::Loop, Space::Gap];
                    let gap = term(number(1.0 - choice.decay), of_gap, &self.part(&rows, 1));
                    let terms = vec![term(number(choice.decay), of_loop, &self.part(&rows, 0)), gap];
                    (rows, terms)
                }
                _ => {
                    let rows = vec![Space::Loop];
                    let terms = vec![term(number(1.0), at_events, &self.part(&rows, 0))];
                    (rows, terms)
                }
            };
            terms.push(term(number(-1.0), roles.frozen, &map));
            self.add("entering", &rows, 1.0, terms);
        }
        let rows = [Space::Frozen];
        let one = self.part(&rows, 0);
        let rate = if extra == 0 { 0.0 } else { GROWTH_FROZEN.ln() / extra as f64 };
        // An exact double, and its power rounded up.
        let rate = 1.0 + (rate * 2.0_f64.powi(40)).floor() * 2.0_f64.powi(-40);
        let grown = power(&vec![vec![number(rate)]], extra)[0][0];
        if extra > 0 {
            for vertex in 0..if is_unique { 1 } else { 2 } {
                for &share in modes.shares() {
                    let map = rounded(&modes.frozen(vertex, share));
                    let terms = vec![term(number(rate), roles.frozen, &one), term(number(-1.0), roles.frozen, &map)];
                    self.add("frozen", &rows, (rate - 1.0).min(PER_TICK), terms);
                }
            }
        }
        let shrunk = number((1.0 / grown.high).next_down());
        let mut terms =
            vec![term(shrunk, roles.frozen, &one), term(number(-1.0), roles.fading[0], &rounded(&modes.release()))];
        terms.extend(gaps.first().map(|&gap| term(number(-1.0), gap, &rounded(&modes.gap()))));
        self.add("releasing", &rows, 1.0, terms);
    }

    fn fade(&mut self, roles: &Roles, gaps: &[usize], lengths: &[u64]) {
        let modes = self.modes;
        let all: u64 = lengths.iter().sum();
        let weight = |tick: u64| cross_fade(tick as f64 / all as f64);
        let rows: &[Space] = if modes.has_gap() { &[Space::Fading, Space::Gap] } else { &[Space::Fading] };
        let width = self.size(rows);
        let one = self.part(rows, 0);
        let mut begin = 0;
        for (piece, &ticks) in lengths.iter().enumerate() {
            // The corners of the range of `(w, w K)`.
            let (min, max) = (if piece == 0 { 0.0 } else { weight(begin) }, weight(begin + ticks));
            let mut corners = vec![(0, max), (1, max), (0, min)];
            if min > 0.0 {
                corners.push((1, min));
            }
            begin += ticks;
            for (vertex, weight) in corners {
                let map = rounded(&modes.blend(vertex, weight).columns(0, width).into_owned());
                let of_states = along((roles.fading[piece], roles.fading[piece + 1]), ticks, &one, &map);
                let mut of_gap = vec![];
                if modes.has_gap() {
                    let gap = self.part(rows, 1);
                    of_gap = along((gaps[piece], gaps[piece + 1]), ticks, &gap, &gap);
                }
                for (k, mut terms) in of_states.into_iter().enumerate() {
                    terms.extend(of_gap.get(k).cloned().unwrap_or_default());
                    self.add("cross-fade", rows, PER_TICK, terms);
                }
            }
        }
    }

    fn close(&mut self, roles: &Roles, gaps: &[usize], choice: Choice) {
        let modes = self.modes;
        let end = roles.fading[roles.fading.len() - 1];
        let n = modes.states();
        let rows = [Space::Fading];
        let whole = self.part(&rows, 0);
        let of_loop = exact(&DMatrix::identity(n, n + 1));
        let next = roles.closing.map_or(roles.dwelling[0], |(closing, _)| closing);
        let terms = vec![term(number(1.0), end, &whole), term(number(-1.0), next, &of_loop)];
        self.add("faded", &rows, PER_TICK, terms);
        let (Some((closing, of_gap)), Some(&last)) = (roles.closing, gaps.last()) else { return };
        let rows = [Space::Gap];
        let one = self.part(&rows, 0);
        self.add("faded", &rows, PER_TICK, vec![term(number(1.0), last, &one), term(number(-1.0), of_gap, &one)]);
        let rows = [Space::Loop, Space::Gap];
        for vertex in 0..2 {
            let terms = vec![
                term(number(choice.decay), closing, &self.part(&rows, 0)),
                term(number(1.0 - choice.decay), of_gap, &self.part(&rows, 1)),
                term(number(-1.0), closing, &rounded(&modes.apart_by_gap(vertex))),
            ];
            self.add("closing the gap", &rows, PER_TICK, terms);
        }
        if modes.gap_closes() {
            let rows = [Space::Loop];
            let one = self.part(&rows, 0);
            let terms = vec![term(number(1.0), closing, &one), term(number(-1.0), roles.dwelling[0], &one)];
            self.add("closed", &rows, PER_TICK, terms);
        }
    }
}

/// `P(t) - Mᵀ P(t+1) M` at the first and the last tick of a piece, `P` linear between its ends.
fn along((from, to): (usize, usize), ticks: u64, one: &Enclosure, map: &Enclosure) -> Vec<Vec<Term>> {
    let minus = |interval: super::interval::Interval| number(0.0) - interval;
    let at = |tick: u64| {
        let mut terms = vec![];
        for (share_to, sign, map) in [(tick, false, one), (tick + 1, true, map)] {
            for (part, node) in [(ticks - share_to, from), (share_to, to)] {
                if part > 0 {
                    let factor = if part == ticks { number(1.0) } else { share(part, ticks) };
                    terms.push(term(if sign { minus(factor) } else { factor }, node, map));
                }
            }
        }
        terms
    };
    if ticks == 1 { vec![at(0)] } else { vec![at(0), at(ticks - 1)] }
}
