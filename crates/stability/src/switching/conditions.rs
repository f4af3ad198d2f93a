//! The inequalities of a certificate.
//!
//! Each phase has a quadratic function `V = zᵀ P z`. Inequalities link the phases at every vertex of the tissue's
//! range. They are convex in the maps, so they hold even if the tissue changes from tick to tick.
//!
//! The gap `g` of a ramp only shrinks, so the motion is a mixture of motions with pulses: gaps held for `n` ticks and
//! then 0. The function at the next event is convex, so it suffices that it decays for every pulse: "held" on the
//! states with the gap, "dropped" on those without.
//!
//! ```text
//! entering   P_S(0) after release, freeze and the last tick, < ρ P_T(d-1); for each length of the freeze
//! held       cross-fade on (x, φ, g) with P_S(t); then teleoperation on (x, g) with P_H:
//!            P_H after a tick < a P_H + (1 - a) γ g²,   γ g² < P_S(0)
//! dropping   P_R(t) on (x, φ) < P_S(t);   P_T(0) on x < a P_H + (1 - a) γ g²
//! dropped    cross-fade with P_R(t); then teleoperation with P_T(t), 0 <= t <= d - 1, and P_T(d-1) from then on;
//!            V decreases by a factor μ per tick of teleoperation
//! ```
//! `max(P_H, γ g²)` cannot grow while the gap is held. With at least `d` ticks of teleoperation between events, `V` at
//! an event is at most `ρ μ^(d-1) < 1` times its value at the previous one (dwell time: Geromel and Colaneri, *SIAM J.
//! Control Optim.* 45, 2006; linear between nodes: Allerhand and Shaked, *IEEE Trans. Autom. Control* 56, 2011).
//!
//! A condition is linear in time between nodes, so it suffices at the first and last tick of a piece. If the frozen map
//! depends on the tissue, functions `P_F(t)` replace its powers; with `Γ` on the constant states, `max(P_F, Γ)` cannot
//! grow.
//!
//! A gap that fades, `g_{k+1} = a g_k`, is an ordinary state: one branch, on `(x, φ, g)` and `(x, g)`.
//!
//! A quantity is bounded, `|c z| < 1` for `|w| <= 1`, if `s (c z)² < V` in each phase and `ω < s`.

use nalgebra::DMatrix;

use super::modes::{Modes, Space};
use super::settings::Phases;
use crate::certificate::Choice;
use crate::certificate::interval::{Interval, power};
use trocar_core::augmentation::cross_fade;

const PER_SECOND: f64 = 10.0;

const FROZEN_SHARES: [f64; 4] = [0.0, 0.1, 0.3, 1.0];

#[derive(Debug, Clone)]
pub(super) struct NamedMap {
    pub(super) name: String,
    pub(super) from: Space,
    pub(super) to: Space,
    pub(super) matrix: DMatrix<f64>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Count {
    Once,
    /// Raised to each number in the condition's range.
    Each,
}

/// `f Mᵀ P M`; the first map of `M` is applied last.
#[derive(Debug, Clone)]
pub(super) struct Term {
    pub(super) factor: Interval,
    pub(super) unknown: usize,
    pub(super) maps: Vec<(usize, Count)>,
}

#[derive(Debug, Clone)]
pub(super) struct Condition {
    pub(super) name: &'static str,
    pub(super) terms: Vec<Term>,
    pub(super) rows: Space,
    pub(super) weight: f64,
    pub(super) counts: Option<(u64, u64)>,
}

#[derive(Debug, Clone)]
pub(super) struct Function {
    pub(super) name: String,
    pub(super) space: Space,
}

#[derive(Debug, Clone)]
pub(super) struct Conditions {
    pub(super) functions: Vec<Function>,
    pub(super) maps: Vec<NamedMap>,
    pub(super) list: Vec<Condition>,
    pub(super) at_events: usize,
}

struct Builder<'a> {
    modes: &'a Modes,
    phases: Phases,
    functions: Vec<Function>,
    maps: Vec<NamedMap>,
    list: Vec<Condition>,
    per_tick: f64,
    /// `a` and `1 - a`; the subtraction is exact.
    held: (f64, f64),
    /// `μ` and `ρ`.
    decay: f64,
    at_entry: f64,
    /// `ω`.
    input: Option<usize>,
}

struct Roles {
    /// `P_T`.
    dropped: Vec<usize>,
    /// `P_R`.
    fading: Vec<usize>,
    /// `P_S`.
    fading_held: Vec<usize>,
    /// `P_H`.
    held: Option<usize>,
    /// `γ`.
    gap: Option<usize>,
    /// `P_F`, with the ticks since the alarm.
    frozen: Vec<(usize, u64)>,
    /// `Γ`.
    constants: Option<usize>,
}

fn number(value: f64) -> Interval {
    Interval::exact(value)
}

/// `ρ`, without the decay `μ^(d-1)`.
pub(super) fn at_entry(choice: Choice, tick_s: f64) -> f64 {
    let decay = (-tick_s * choice.rate_per_s).exp();
    let of_dwell = power(&vec![vec![number(decay)]], choice.dwell_ticks - 1)[0][0];
    (choice.contraction / of_dwell.high).next_down()
}

/// Within ±1 for an additional force within ±1 N.
pub(super) fn quantities(modes: &Modes, choice: Choice) -> Option<[DMatrix<f64>; 2]> {
    choice.bounds_m_per_n.map(|[needle, hand]| [modes.slave() / needle, modes.hand_position() / hand])
}

fn share(part: u64, whole: u64) -> Interval {
    if part == whole { number(1.0) } else { Interval::rounded(part as f64 / whole as f64) }
}

fn pieces(ticks: u64, max: u64) -> Vec<u64> {
    let count = max.min(ticks);
    (0..count).map(|k| (k + 1) * ticks / count - k * ticks / count).collect()
}

impl Conditions {
    pub(super) fn new(modes: &Modes, phases: Phases, choice: Choice) -> Self {
        let kept = (-modes.tick_s / choice.hold_s).exp();
        let decay = (-modes.tick_s * choice.rate_per_s).exp();
        let at_entry = at_entry(choice, modes.tick_s);
        let mut builder = Builder {
            modes,
            phases,
            functions: vec![],
            maps: vec![],
            list: vec![],
            per_tick: modes.tick_s * PER_SECOND,
            held: (kept, 1.0 - kept),
            decay,
            at_entry,
            input: None,
        };

        let dwell = pieces(choice.dwell_ticks - 1, choice.pieces);
        let fade = pieces(phases.blend, choice.pieces);
        let roles = builder.roles((&dwell, &fade), choice.is_driven);
        for unknown in 0..builder.functions.len() {
            let rows = builder.functions[unknown].space;
            let one = builder.select(rows, rows);
            builder.add("positive", rows, vec![builder.term(number(1.0), unknown, &[one])]);
        }
        builder.enter(&roles);
        builder.fade(&roles, &fade);
        builder.drop_gap(&roles);
        builder.dwell(&roles, &dwell);
        if let Some(rows) = quantities(modes, choice) {
            builder.bound(&roles, &rows);
        }
        let Builder { functions, maps, list, .. } = builder;
        Self { functions, maps, list, at_events: *roles.dropped.last().unwrap_or(&0) }
    }
}

impl Builder<'_> {
    fn function(&mut self, name: &str, node: usize, space: Space) -> usize {
        self.functions.push(Function { name: format!("{name}_{node}"), space });
        self.functions.len() - 1
    }

    fn roles(&mut self, (dwell, fade): (&[u64], &[u64]), is_driven: bool) -> Roles {
        let modes = self.modes;
        let fading = fade.len() + 1;
        // A gap that fades needs no branches.
        let is_held = modes.has_gap() && !modes.gap_fades();
        // Keeps the solver's matrix narrow.
        let (mut frozen, mut constants) = (vec![], None);
        if !modes.is_frozen_map_unique() {
            let shortest = self.phases.held.0 as f64;
            let mut ticks: Vec<u64> = FROZEN_SHARES.iter().map(|share| (share * shortest) as u64).collect();
            ticks.dedup();
            for (node, tick) in ticks.into_iter().enumerate() {
                frozen.push((self.function("frozen", node, Space::Frozen), tick));
            }
            if modes.size(Space::Held) > 0 {
                constants = Some(self.function("held_while_frozen", 0, Space::Held));
            }
        } else if is_driven && modes.drives_target() {
            frozen.push((self.function("frozen", 0, Space::Frozen), 0));
        }
        let (mut of_fading, mut fading_held) = (vec![], vec![]);
        for node in 0..fading {
            if is_held {
                fading_held.push(self.function("cross_fade_with_gap", node, Space::FadingGap));
            }
            of_fading.push(self.function("cross_fade", node, modes.faded()));
        }
        let held = is_held.then(|| self.function("teleoperation_with_gap", 0, Space::LoopGap));
        let dropped =
            (0..=dwell.len()).map(|node| self.function("teleoperation", node, modes.teleoperated())).collect();
        let gap = is_held.then(|| self.function("gap", 0, Space::Gap));
        self.input = is_driven.then(|| self.function("additional_force", 0, Space::Input));
        Roles { dropped, fading: of_fading, fading_held, held, gap, frozen, constants }
    }

    fn map(&mut self, name: String, from: Space, to: Space, matrix: impl FnOnce(&Modes) -> DMatrix<f64>) -> usize {
        if let Some(known) = self.maps.iter().position(|map| map.name == name && map.from == from && map.to == to) {
            return known;
        }
        let matrix = matrix(self.modes);
        self.maps.push(NamedMap { name, from, to, matrix });
        self.maps.len() - 1
    }

    fn between(&mut self, name: String, from: Space, to: Space, all: impl FnOnce(&Modes) -> DMatrix<f64>) -> usize {
        self.map(name, from, to, |modes| modes.between(&all(modes), from, to))
    }

    fn select(&mut self, from: Space, to: Space) -> usize {
        self.map(format!("{to:?}_of_{from:?}"), from, to, |modes| match (from, to) {
            (Space::Number, Space::Number) => DMatrix::identity(1, 1),
            _ => modes.selection(from, to),
        })
    }

    fn term(&self, factor: Interval, unknown: usize, maps: &[usize]) -> Term {
        Term { factor, unknown, maps: maps.iter().map(|&map| (map, Count::Once)).collect() }
    }

    fn add(&mut self, name: &'static str, rows: Space, terms: Vec<Term>) {
        self.list.push(Condition { name, terms, rows, weight: self.per_tick, counts: None });
    }

    /// `to` after `map` is below `from`.
    fn below(&mut self, name: &'static str, rows: Space, to: usize, map: usize, from: Vec<Term>) {
        let mut terms = from;
        terms.push(self.term(number(-1.0), to, &[map]));
        self.add(name, rows, terms);
    }

    fn driven(&self, space: Space) -> Space {
        if self.input.is_some() { space.driven() } else { space }
    }

    /// `factor ω w²`.
    fn drive(&mut self, terms: &mut Vec<Term>, rows: Space, factor: f64) {
        if let Some(input) = self.input {
            let of_input = self.select(rows, Space::Input);
            terms.push(self.term(number(factor), input, &[of_input]));
        }
    }

    /// `μ P(t) - Mᵀ P(t+1) M + (1 - μ) ω w²` at the first and last tick of a piece with linear `P`.
    fn decaying(
        &mut self,
        name: &'static str,
        rows: Space,
        (from, to): (usize, usize),
        ticks: u64,
        (map, decay): (usize, f64),
    ) {
        let one = self.select(rows, self.functions[from].space);
        let last = if ticks == 1 { None } else { Some(ticks - 1) };
        for tick in std::iter::once(0).chain(last) {
            let mut terms = vec![];
            for (share_to, sign, map) in [(tick, decay, one), (tick + 1, -1.0, map)] {
                for (part, node) in [(ticks - share_to, from), (share_to, to)] {
                    if part > 0 {
                        terms.push(self.term(share(part, ticks) * number(sign), node, &[map]));
                    }
                }
            }
            self.drive(&mut terms, rows, 1.0 - decay);
            self.add(name, rows, terms);
        }
    }

    /// `a P + (1 - a) Γ`; the additional force halves the companion's share. The weights sum to 1, so the larger of the
    /// functions and of `ω w²` cannot grow.
    fn level(&mut self, rows: Space, function: usize, companion: Option<usize>) -> Vec<Term> {
        let (of_function, rest) = self.held;
        let one = self.select(rows, self.functions[function].space);
        let mut terms = vec![self.term(number(of_function), function, &[one])];
        let of_companion = if self.input.is_some() { 0.5 * rest } else { rest };
        match companion {
            Some(companion) => {
                let kept = self.select(rows, self.functions[companion].space);
                terms.push(self.term(number(of_companion), companion, &[kept]));
                self.drive(&mut terms, rows, rest - of_companion);
            }
            None => self.drive(&mut terms, rows, rest),
        }
        terms
    }

    fn at_events(&mut self, roles: &Roles, rows: Space) -> Vec<Term> {
        let one = self.select(rows, self.modes.teleoperated());
        let mut terms = vec![self.term(number(self.at_entry), *roles.dropped.last().unwrap_or(&0), &[one])];
        self.drive(&mut terms, rows, 1.0 - self.at_entry);
        terms
    }

    fn entry(&mut self, vertex: usize, rows: Space, to: Space) -> usize {
        self.between(format!("entry_{vertex}"), rows, to, |modes| modes.freeze() * modes.teleoperation(vertex))
    }

    fn releases(&self) -> std::ops::Range<usize> {
        if self.modes.has_unique_motion() { 0..1 } else { self.modes.vertices() }
    }

    fn enter(&mut self, roles: &Roles) {
        let (space, first) = match (roles.fading_held.first(), roles.fading.first()) {
            (Some(&held), _) => (Space::FadingGap, held),
            (None, Some(&fading)) => (self.modes.faded(), fading),
            (None, None) => return,
        };
        let rows = self.driven(self.modes.teleoperated());
        let level = self.at_events(roles, rows);
        if let (true, [(released, _)]) = (self.modes.is_frozen_map_unique(), &roles.frozen[..]) {
            // The additional force acts only at both ends.
            self.freeze(*released, None, (rows, &level));
        } else if roles.frozen.is_empty() {
            for vertex in self.releases() {
                let release = self.release(vertex, Space::Frozen, space);
                self.freeze(first, Some(release), (rows, &level));
            }
            return;
        } else {
            self.evolve(roles, (rows, &level));
        }
        let last = roles.frozen[roles.frozen.len() - 1].0;
        let rows = self.driven(Space::Frozen);
        for vertex in self.releases() {
            let release = self.release(vertex, rows, space);
            let level = self.level(rows, last, roles.constants);
            self.below("releasing", rows, first, release, level);
        }
    }

    fn release(&mut self, vertex: usize, from: Space, to: Space) -> usize {
        self.between(format!("release_{vertex}"), from, to, |modes| modes.release(vertex))
    }

    /// `to` after an entry, any length of the freeze, and a release if given, is below `level`.
    fn freeze(&mut self, to: usize, release: Option<usize>, (rows, level): (Space, &[Term])) {
        let frozen = self.between("frozen".into(), Space::Frozen, Space::Frozen, |modes| modes.frozen(0, 1.0));
        for vertex in self.modes.vertices() {
            let entry = self.entry(vertex, rows, Space::Frozen);
            let of_release = release.map(|release| (release, Count::Once));
            let maps = of_release.into_iter().chain([(frozen, Count::Each), (entry, Count::Once)]).collect();
            let mut terms = level.to_vec();
            terms.push(Term { factor: number(-1.0), unknown: to, maps });
            let counts = Some(self.phases.held);
            self.list.push(Condition { name: "entering", terms, rows, weight: 1.0, counts });
        }
    }

    fn evolve(&mut self, roles: &Roles, (rows, level): (Space, &[Term])) {
        for vertex in self.modes.vertices() {
            for function in std::iter::once(roles.frozen[0].0).chain(roles.constants) {
                let entry = self.entry(vertex, rows, self.functions[function].space);
                let mut terms = level.to_vec();
                terms.push(self.term(number(-1.0), function, &[entry]));
                self.list.push(Condition { name: "entering", terms, rows, weight: 1.0, counts: None });
            }
        }
        let rows = self.driven(Space::Frozen);
        let last = roles.frozen[roles.frozen.len() - 1].0;
        for vertex in self.modes.vertices() {
            for &part in self.modes.shares() {
                let name = format!("frozen_{vertex}_{part}");
                let map = self.between(name, rows, Space::Frozen, |modes| modes.frozen(vertex, part));
                let mut pieces: Vec<(usize, usize, u64)> =
                    roles.frozen.windows(2).map(|pair| (pair[0].0, pair[1].0, pair[1].1 - pair[0].1)).collect();
                pieces.push((last, last, 1));
                for (from, to, ticks) in pieces {
                    for tick in if ticks == 1 { vec![0] } else { vec![0, ticks - 1] } {
                        let mut terms = vec![];
                        for term in self.level(rows, from, roles.constants) {
                            if term.unknown == from && ticks > 1 && tick > 0 {
                                let at = |part| share(part, ticks) * term.factor;
                                terms.push(Term { factor: at(ticks - tick), ..term.clone() });
                                terms.push(Term { factor: at(tick), unknown: to, ..term });
                            } else {
                                terms.push(term);
                            }
                        }
                        for (part, node) in [(ticks - tick - 1, from), (tick + 1, to)] {
                            if part > 0 {
                                terms.push(self.term(share(part, ticks) * number(-1.0), node, &[map]));
                            }
                        }
                        self.add("frozen", rows, terms);
                    }
                }
            }
        }
    }

    fn fade(&mut self, roles: &Roles, lengths: &[u64]) {
        let all: u64 = lengths.iter().sum();
        let weight = |tick: u64| cross_fade(tick as f64 / all as f64);
        let decay = if self.input.is_some() { self.decay } else { 1.0 };
        let branches = [(self.modes.faded(), &roles.fading), (Space::FadingGap, &roles.fading_held)];
        for (space, nodes) in branches.into_iter().filter(|(_, nodes)| !nodes.is_empty()) {
            let rows = self.driven(space);
            let mut begin = 0;
            for (piece, &ticks) in lengths.iter().enumerate() {
                let (min, max) = (weight(begin + 1), weight(begin + ticks));
                begin += ticks;
                for vertex in self.modes.vertices() {
                    for weight in if ticks == 1 { vec![max] } else { vec![min, max] } {
                        let name = format!("cross_fade_{vertex}_{weight}");
                        let map = self.between(name, rows, space, |modes| modes.blend(vertex, weight));
                        self.decaying("cross-fade", rows, (nodes[piece], nodes[piece + 1]), ticks, (map, decay));
                    }
                }
            }
        }
        let drop_at_ticks = self.select(Space::FadingGap, Space::Fading);
        let held = self.select(Space::FadingGap, Space::FadingGap);
        for (&with_gap, &without) in roles.fading_held.iter().zip(&roles.fading) {
            let from = vec![self.term(number(1.0), with_gap, &[held])];
            self.below("dropping", Space::FadingGap, without, drop_at_ticks, from);
        }
        if let (Some(&last), Some(&next)) = (roles.fading.last(), roles.dropped.first()) {
            let faded = self.modes.faded();
            let (one, of_loop) = (self.select(faded, faded), self.select(faded, self.modes.teleoperated()));
            let from = vec![self.term(number(1.0), last, &[one])];
            self.below("faded", faded, next, of_loop, from);
        }
        if let (Some(&last), Some(next), Some(&first), Some(gap)) =
            (roles.fading_held.last(), roles.held, roles.fading_held.first(), roles.gap)
        {
            let of_loop = self.select(Space::FadingGap, Space::LoopGap);
            let from = vec![self.term(number(1.0), last, &[held])];
            self.below("faded", Space::FadingGap, next, of_loop, from);
            let of_gap = self.select(Space::FadingGap, Space::Gap);
            let from = vec![self.term(number(1.0), first, &[held])];
            self.below("gap", Space::FadingGap, gap, of_gap, from);
        }
    }

    fn teleoperation(&mut self, vertex: usize, rows: Space) -> usize {
        let to = rows.undriven().0;
        self.between(format!("teleoperation_{vertex}"), rows, to, |modes| modes.teleoperation(vertex))
    }

    fn drop_gap(&mut self, roles: &Roles) {
        let (Some(held), Some(&next)) = (roles.held, roles.dropped.first()) else { return };
        let rows = self.driven(Space::LoopGap);
        for vertex in self.modes.vertices() {
            let map = self.teleoperation(vertex, rows);
            let level = self.level(rows, held, roles.gap);
            self.below("held", rows, held, map, level);
        }
        let of_loop = self.select(rows, Space::Loop);
        let level = self.level(rows, held, roles.gap);
        self.below("dropping", rows, next, of_loop, level);
    }

    fn dwell(&mut self, roles: &Roles, lengths: &[u64]) {
        let rows = self.driven(self.modes.teleoperated());
        let last = roles.dropped[lengths.len()];
        for vertex in self.modes.vertices() {
            let map = self.teleoperation(vertex, rows);
            self.decaying("dwelling", rows, (last, last), 1, (map, self.decay));
            for (piece, &ticks) in lengths.iter().enumerate() {
                let nodes = (roles.dropped[piece], roles.dropped[piece + 1]);
                self.decaying("dwelling", rows, nodes, ticks, (map, self.decay));
            }
        }
    }

    fn bound(&mut self, roles: &Roles, rows: &[DMatrix<f64>]) {
        let size = self.function("bound", 0, Space::Number);
        let one = self.select(Space::Number, Space::Number);
        self.add("positive", Space::Number, vec![self.term(number(1.0), size, &[one])]);
        let functions: Vec<(usize, Space)> =
            self.functions.iter().map(|function| function.space).enumerate().filter(|(k, _)| *k != size).collect();
        for (function, space) in functions {
            if matches!(space, Space::Gap | Space::Held | Space::Frozen | Space::Input) {
                continue;
            }
            let whole = self.select(space, space);
            for (k, row) in rows.iter().enumerate() {
                let narrow = self.modes.row(row, space);
                if narrow.iter().all(|value| *value == 0.0) {
                    continue;
                }
                let map = self.map(format!("quantity_{k}"), space, Space::Number, |_| narrow);
                let from = vec![self.term(number(1.0), function, &[whole])];
                self.below("bounded", space, size, map, from);
            }
        }
        let quantities: Vec<usize> = (rows.iter().enumerate())
            .map(|(k, row)| {
                let narrow = self.modes.row(row, Space::Frozen);
                self.map(format!("quantity_frozen_{k}"), Space::Frozen, Space::Number, |_| narrow)
            })
            .collect();
        let rows = self.driven(self.modes.teleoperated());
        let level = self.at_events(roles, rows);
        if self.modes.is_frozen_map_unique() {
            let frozen = self.between("frozen".into(), Space::Frozen, Space::Frozen, |modes| modes.frozen(0, 1.0));
            for vertex in self.modes.vertices() {
                let entry = self.entry(vertex, rows, Space::Frozen);
                for &quantity in &quantities {
                    let maps = vec![(quantity, Count::Once), (frozen, Count::Each), (entry, Count::Once)];
                    let mut terms = level.clone();
                    terms.push(Term { factor: number(-1.0), unknown: size, maps });
                    let counts = Some((0, self.phases.held.1));
                    self.list.push(Condition { name: "bounded", terms, rows, weight: self.per_tick, counts });
                }
            }
        } else {
            let whole = self.select(Space::Frozen, Space::Frozen);
            for &(frozen, _) in &roles.frozen {
                for &quantity in &quantities {
                    let from = vec![self.term(number(1.0), frozen, &[whole])];
                    self.below("bounded", Space::Frozen, size, quantity, from);
                }
            }
        }
        if let Some(input) = self.input {
            let level = self.map("level".into(), Space::Input, Space::Number, |_| DMatrix::identity(1, 1));
            let force = self.select(Space::Input, Space::Input);
            let terms = vec![self.term(number(1.0), size, &[level]), self.term(number(-1.0), input, &[force])];
            self.add("force", Space::Input, terms);
        }
    }
}
