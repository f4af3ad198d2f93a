use nalgebra::{DMatrix, DVector};

use crate::machines::Machines;
use crate::side::{LocalCommand, Side};
use crate::{LinearLoop, StabilityError, SwitchingSettings};
use trocar_core::augmentation::{ForceMap, Freeze, HoldMap, ReturnMap};

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Space {
    /// `x`: teleoperation.
    Loop,
    /// `(x, g)`: teleoperation with a gap.
    LoopGap,
    /// `(x, φ)`: the cross-fade.
    Fading,
    /// `(x, φ, g)`: the cross-fade with a gap.
    FadingGap,
    /// Frozen: `(x, r, φ, F*, F_t)`, without the states that the force law does not use.
    Frozen,
    /// Constant while frozen: `(r, F*, F_t)`, likewise.
    Held,
    /// `g`.
    Gap,
    /// `w`, the tissue force in addition to `K p + B v`.
    Input,
    /// `(x, w)`, and likewise below.
    DrivenLoop,
    DrivenLoopGap,
    DrivenFading,
    DrivenFadingGap,
    DrivenFrozen,
    Number,
    All,
}

/// The index of `v_h` in `x`; the other indices begin after the loop's states.
const HAND_VELOCITY: usize = 1;

const REFERENCE: usize = 0;
const FED_BACK: usize = 1;
const ANCHOR: usize = 2;
const TISSUE: usize = 3;
pub(super) const GAP: usize = 4;
const INPUT: usize = 5;
const EXTRA: usize = 6;

impl Space {
    pub(super) fn driven(self) -> Self {
        match self {
            Self::Loop => Self::DrivenLoop,
            Self::LoopGap => Self::DrivenLoopGap,
            Self::Fading => Self::DrivenFading,
            Self::FadingGap => Self::DrivenFadingGap,
            Self::Frozen => Self::DrivenFrozen,
            other => other,
        }
    }

    pub(super) fn undriven(self) -> (Self, bool) {
        match self {
            Self::DrivenLoop => (Self::Loop, true),
            Self::DrivenLoopGap => (Self::LoopGap, true),
            Self::DrivenFading => (Self::Fading, true),
            Self::DrivenFadingGap => (Self::FadingGap, true),
            Self::DrivenFrozen => (Self::Frozen, true),
            other => (other, false),
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Vertex {
    stiffness_n_per_m: f64,
    damping_n_s_per_m: f64,
}

/// Linear maps of the phases. Positions are relative to the tissue's surface and to the hand's desired position.
///
/// ```text
/// (x, r, φ, F*, F_t, g, w)  x: master's side, slave's side, hand positions on the way, latest first;
///                           r the reference, φ the last feedback force, F* and F_t the feedback force and the measured
///                           force at the alarm, g the gap: x_ref = hand + g;
///                           w the tissue force in addition to K p + B v, an input
/// ```
/// Supervisor and slave use the arrived hand position. The master's states are taken when the slave's samples arrive,
/// so both sides switch at the same time and the whole delay lies between hand and slave. A map starts before the
/// tick's force: an event at tick `k` uses `x`, `F*` and the reference at `k - 1`.
#[derive(Debug, Clone)]
pub(crate) struct Modes {
    master: Side,
    slaves: Vec<Side>,
    delay: usize,
    integral: bool,
    law: ForceMap,
    /// True if the slave follows the hand during events, so they leave no gap.
    follows: bool,
    freeze: Freeze,
    returns: ReturnMap,
    /// 1 unless a gap fades.
    gap_factor: f64,
    decay_factor: f64,
    pub(super) tick_s: f64,
}

impl Modes {
    pub(crate) fn new(settings: &SwitchingSettings) -> Result<Self, StabilityError> {
        let machines = Machines::new(&settings.of_loop)?;
        let (softest, stiffest) = settings.stiffness_n_per_m;
        let (least, most) = settings.damping_n_s_per_m;
        let corners = [(softest, most), (stiffest, most)];
        let mut vertices: Vec<Vertex> = [softest, stiffest]
            .map(|stiffness_n_per_m| Vertex { stiffness_n_per_m, damping_n_s_per_m: least })
            .to_vec();
        for (stiffness_n_per_m, damping_n_s_per_m) in
            corners.into_iter().chain(settings.loses_contact.then_some((0.0, 0.0)))
        {
            let vertex = Vertex { stiffness_n_per_m, damping_n_s_per_m };
            if !vertices.contains(&vertex) {
                vertices.push(vertex);
            }
        }
        let slave = |vertex: &Vertex| {
            let settings = LinearLoop {
                stiffness_n_per_m: vertex.stiffness_n_per_m,
                damping_n_s_per_m: vertex.damping_n_s_per_m,
                // The force of a relaxing spring is within the sector of its range.
                relaxation: None,
                ..settings.of_loop.clone()
            };
            Side::slave_with(&machines, &settings, LocalCommand::Open)
        };
        let augmentation = &settings.augmentation;
        let tick_s = settings.of_loop.tick_s;
        let of_events = augmentation.force.map().zip(augmentation.hold.map());
        let (law, hold) = of_events.ok_or(StabilityError::UncoveredEvents)?;
        let follows = hold == HoldMap::Following;
        let returns = if follows { Some(ReturnMap::Jumps) } else { augmentation.reengage.map() };
        let returns = returns.ok_or(StabilityError::UncoveredEvents)?;
        let decay_factor = match law {
            ForceMap::Decays { time_constant_s, .. } => libm::exp(-tick_s / time_constant_s),
            ForceMap::FollowsTissue { .. } | ForceMap::IsDamped { .. } => 0.0,
        };
        let gap_factor = match returns {
            ReturnMap::Fades { time_constant_s } => libm::exp(-tick_s / time_constant_s),
            ReturnMap::Closes | ReturnMap::Jumps | ReturnMap::Keeps => 1.0,
        };
        Ok(Self {
            master: Side::master_with(&machines, &settings.of_loop, LocalCommand::Open)?,
            slaves: vertices.iter().map(slave).collect::<Result<_, _>>()?,
            delay: settings.delay_ticks() as usize,
            integral: settings.of_loop.master.force_integral_gain != 0.0,
            law,
            follows,
            freeze: augmentation.freeze,
            returns,
            gap_factor,
            decay_factor,
            tick_s,
        })
    }

    pub(crate) fn states(&self) -> usize {
        self.master.a.nrows() + self.slaves[0].a.nrows() + self.delay
    }

    pub(super) fn places_all(&self) -> usize {
        self.states() + EXTRA
    }

    pub(crate) fn master_states(&self) -> usize {
        self.master.a.nrows()
    }

    pub(crate) fn delay(&self) -> usize {
        self.delay
    }

    pub(super) fn teleoperated(&self) -> Space {
        if self.gap_fades() { Space::LoopGap } else { Space::Loop }
    }

    pub(super) fn faded(&self) -> Space {
        if self.gap_fades() { Space::FadingGap } else { Space::Fading }
    }

    /// 0 without decay.
    pub(super) fn slowest_decay_per_s(&self) -> Result<f64, StabilityError> {
        let mut largest: f64 = 0.0;
        for vertex in self.vertices() {
            let matrix = self.between(&self.teleoperation(vertex), self.teleoperated(), self.teleoperated());
            largest = trocar_lti::eigenvalues(&matrix)?.into_iter().map(|value| value.norm()).fold(largest, f64::max);
        }
        Ok((-largest.ln() / self.tick_s).max(0.0))
    }

    pub(crate) fn without_delay(&self) -> Self {
        Self { delay: 0, ..self.clone() }
    }

    pub(super) fn vertices(&self) -> std::ops::Range<usize> {
        0..self.slaves.len()
    }

    pub(super) fn names(&self, space: Space) -> Vec<(String, &'static str)> {
        let named = |text: &str, unit| (text.to_owned(), unit);
        let mut of_loop = vec![named("x_h", "m"), named("v_h", "m/s"), named("x_a", "m"), named("v_a", "m/s")];
        if self.integral {
            of_loop.push(named("master_force_integral", "N s"));
        }
        for k in of_loop.len()..self.master.a.nrows() {
            of_loop.push((format!("master_{k}"), "1"));
        }
        of_loop.extend([named("x_e", "m"), named("v_e", "m/s"), named("slave_motor", "m/s^2")]);
        for k in 3..self.slaves[0].a.nrows() {
            of_loop.push((format!("slave_{k}"), "1"));
        }
        of_loop.extend((1..=self.delay).map(|k| (format!("hand_{k}_ticks_ago"), "m")));
        let extra = [
            ("held_reference", "m"),
            ("force_fed_back", "N"),
            ("force_at_alarm", "N"),
            ("tissue_at_alarm", "N"),
            ("gap", "m"),
            ("additional_force", "N"),
        ];
        let all: Vec<(String, &'static str)> =
            of_loop.into_iter().chain(extra.map(|(name, unit)| named(name, unit))).collect();
        if space == Space::Number {
            return vec![named("one", "1")];
        }
        self.places(space).into_iter().map(|place| all[place].clone()).collect()
    }

    fn has_anchor(&self) -> bool {
        !matches!(self.law, ForceMap::Decays { ratio: 0.0, .. } | ForceMap::IsDamped { .. })
    }

    pub(super) fn has_gap(&self) -> bool {
        self.returns != ReturnMap::Jumps
    }

    pub(super) fn gap_closes(&self) -> bool {
        matches!(self.returns, ReturnMap::Closes | ReturnMap::Jumps)
    }

    pub(super) fn gap_fades(&self) -> bool {
        matches!(self.returns, ReturnMap::Fades { .. })
    }

    fn places(&self, space: Space) -> Vec<usize> {
        let n = self.states();
        let (space, is_driven) = space.undriven();
        let mut places: Vec<usize> = match space {
            Space::Input | Space::Gap | Space::Held | Space::Number => vec![],
            Space::Loop
            | Space::LoopGap
            | Space::Fading
            | Space::FadingGap
            | Space::Frozen
            | Space::All
            | Space::DrivenLoop
            | Space::DrivenLoopGap
            | Space::DrivenFading
            | Space::DrivenFadingGap
            | Space::DrivenFrozen => (0..n).collect(),
        };
        match space {
            Space::Input => places.push(n + INPUT),
            Space::LoopGap | Space::Gap => places.push(n + GAP),
            Space::Fading => places.push(n + FED_BACK),
            Space::FadingGap => places.extend([n + FED_BACK, n + GAP]),
            Space::Frozen | Space::Held => {
                if !self.follows {
                    places.push(n + REFERENCE);
                }
                if space == Space::Frozen {
                    places.push(n + FED_BACK);
                }
                if self.has_anchor() {
                    places.push(n + ANCHOR);
                }
                if matches!(self.law, ForceMap::FollowsTissue { .. }) {
                    places.push(n + TISSUE);
                }
            }
            Space::All => places.extend(n..n + EXTRA),
            Space::Loop
            | Space::Number
            | Space::DrivenLoop
            | Space::DrivenLoopGap
            | Space::DrivenFading
            | Space::DrivenFadingGap
            | Space::DrivenFrozen => {}
        }
        if is_driven {
            places.push(n + INPUT);
        }
        places
    }

    pub(super) fn size(&self, space: Space) -> usize {
        if space == Space::Number { 1 } else { self.places(space).len() }
    }

    pub(super) fn between(&self, map: &DMatrix<f64>, from: Space, to: Space) -> DMatrix<f64> {
        map.select_rows(&self.places(to)).select_columns(&self.places(from))
    }

    pub(super) fn selection(&self, from: Space, to: Space) -> DMatrix<f64> {
        self.between(&DMatrix::identity(self.states() + EXTRA, self.states() + EXTRA), from, to)
    }

    pub(super) fn row(&self, row: &DMatrix<f64>, space: Space) -> DMatrix<f64> {
        row.select_columns(&self.places(space))
    }

    fn weights(&self, of_master: &DVector<f64>, of_slave: &DVector<f64>) -> DMatrix<f64> {
        let mut row = DMatrix::zeros(1, self.states() + EXTRA);
        row.view_mut((0, 0), (1, of_master.len())).tr_copy_from(of_master);
        row.view_mut((0, of_master.len()), (1, of_slave.len())).tr_copy_from(of_slave);
        row
    }

    fn unit(&self, state: usize) -> DMatrix<f64> {
        DMatrix::from_fn(1, self.states() + EXTRA, |_, j| f64::from(u8::from(j == state)))
    }

    fn extra(&self, state: usize) -> DMatrix<f64> {
        self.unit(self.states() + state)
    }

    fn input(&self, weight: f64) -> DMatrix<f64> {
        self.extra(INPUT) * weight
    }

    /// The arrived, scaled hand position plus the slave's part, in m.
    pub(crate) fn hand(&self, vertex: usize) -> DMatrix<f64> {
        let nothing = DVector::zeros(self.master.c.len());
        let local = self.weights(&nothing, &self.slaves[vertex].local) + self.input(self.slaves[vertex].external.local);
        let arrived = match self.delay {
            0 => self.weights(&self.master.c, &DVector::zeros(self.slaves[vertex].c.len())),
            _ => self.unit(self.states() - 1),
        };
        local + arrived
    }

    pub(crate) fn slave(&self) -> DMatrix<f64> {
        self.unit(self.master.a.nrows())
    }

    pub(crate) fn force(&self, vertex: usize) -> DMatrix<f64> {
        self.weights(&self.master.local, &self.slaves[vertex].c) + self.input(self.slaves[vertex].external.sent)
    }

    fn measured(&self, vertex: usize) -> DMatrix<f64> {
        let slave = &self.slaves[vertex];
        self.weights(&DVector::zeros(self.master.c.len()), &slave.force) + self.input(slave.external.measured)
    }

    pub(super) fn fed_back(&self) -> DMatrix<f64> {
        self.extra(FED_BACK)
    }

    fn column(&self, at: usize, part: &DVector<f64>) -> DMatrix<f64> {
        let mut column = DMatrix::zeros(self.states() + EXTRA, 1);
        column.view_mut((at, 0), (part.len(), 1)).copy_from(part);
        column
    }

    pub(crate) fn of_reference(&self) -> DMatrix<f64> {
        self.column(self.master.a.nrows(), &self.slaves[0].now)
    }

    pub(crate) fn of_force(&self) -> DMatrix<f64> {
        self.column(0, &self.master.now)
    }

    pub(crate) fn of_desired(&self) -> DMatrix<f64> {
        match &self.master.desired {
            Some((now, next)) => self.column(0, &(now + next)),
            None => DMatrix::zeros(self.states() + EXTRA, 1),
        }
    }

    pub(crate) fn apart(&self, vertex: usize) -> DMatrix<f64> {
        let slave = &self.slaves[vertex];
        let (m, s, n) = (self.master.a.nrows(), slave.a.nrows(), self.states());
        let mut a = DMatrix::zeros(n + EXTRA, n + EXTRA);
        a.view_mut((0, 0), (m, m)).copy_from(&self.master.a);
        a.view_mut((m, m), (s, s)).copy_from(&slave.a);
        a.view_mut((m, n + INPUT), (s, 1)).copy_from(&slave.external.next);
        if self.delay > 0 {
            a.view_mut((m + s, 0), (1, m)).tr_copy_from(&self.master.c);
        }
        for tick in 1..self.delay {
            a[(m + s + tick, m + s + tick - 1)] = 1.0;
        }
        for state in n..n + EXTRA {
            a[(state, state)] = 1.0;
        }
        a[(n + GAP, n + GAP)] = self.gap_factor;
        a
    }

    fn tick(&self, vertex: usize, reference: &DMatrix<f64>, force: &DMatrix<f64>) -> DMatrix<f64> {
        self.apart(vertex) + self.of_reference() * reference + self.of_force() * force
    }

    fn reference(&self, vertex: usize) -> DMatrix<f64> {
        let hand = self.hand(vertex);
        if self.has_gap() { hand + self.extra(GAP) * self.gap_factor } else { hand }
    }

    /// Stores reference and force for an event.
    pub(super) fn teleoperation(&self, vertex: usize) -> DMatrix<f64> {
        let (reference, force) = (self.reference(vertex), self.force(vertex));
        let mut map = self.tick(vertex, &reference, &force);
        map.row_mut(self.states() + REFERENCE).copy_from(&reference.row(0));
        map.row_mut(self.states() + FED_BACK).copy_from(&force.row(0));
        map.row_mut(self.states() + TISSUE).copy_from(&self.measured(vertex).row(0));
        map
    }

    pub(super) fn freeze(&self) -> DMatrix<f64> {
        let n = self.states();
        let mut map = DMatrix::identity(n + EXTRA, n + EXTRA);
        if self.freeze == Freeze::Measured {
            map.row_mut(n + REFERENCE).copy_from(&self.slave().row(0));
        }
        map.row_mut(n + ANCHOR).copy_from(&self.fed_back().row(0));
        map
    }

    /// For `damp`, `share` is the risen part of the damping. For `amplify`, it is 1 above the floor and 0 for the
    /// constant `F*`; the floored force lies between.
    pub(super) fn frozen(&self, vertex: usize, share: f64) -> DMatrix<f64> {
        let fed_back = match self.law {
            ForceMap::Decays { ratio, .. } => {
                self.fed_back() * self.decay_factor + self.extra(ANCHOR) * (ratio * (1.0 - self.decay_factor))
            }
            ForceMap::IsDamped { damping_n_s_per_m } => {
                self.force(vertex) + self.unit(HAND_VELOCITY) * (share * damping_n_s_per_m)
            }
            ForceMap::FollowsTissue { gain } => {
                // The coupling of the positions stays constant; only the measured force varies.
                self.extra(ANCHOR) + (self.measured(vertex) - self.extra(TISSUE)) * (share * gain)
            }
        };
        let reference = if self.follows { self.hand(vertex) } else { self.extra(REFERENCE) };
        let mut map = self.tick(vertex, &reference, &fed_back);
        map.row_mut(self.states() + FED_BACK).copy_from(&fed_back.row(0));
        map
    }

    /// The same for every tissue and force, so its powers are exact.
    pub(super) fn is_frozen_map_unique(&self) -> bool {
        !self.follows
            && matches!(self.law, ForceMap::Decays { .. })
            && self.slaves.iter().all(|slave| slave.a == self.slaves[0].a)
    }

    pub(super) fn shares(&self) -> &'static [f64] {
        match self.law {
            ForceMap::IsDamped { damping_n_s_per_m: 0.0 } | ForceMap::Decays { .. } => &[1.0],
            ForceMap::IsDamped { .. } | ForceMap::FollowsTissue { .. } => &[0.0, 1.0],
        }
    }

    pub(super) fn drives_target(&self) -> bool {
        self.slaves.iter().any(|slave| slave.external.local != 0.0)
    }

    pub(super) fn hand_position(&self) -> DMatrix<f64> {
        self.unit(0)
    }

    pub(super) fn has_unique_motion(&self) -> bool {
        let alike = |slave: &Side| slave.a == self.slaves[0].a && slave.local == self.slaves[0].local;
        self.slaves.iter().all(alike)
    }

    pub(super) fn release(&self, vertex: usize) -> DMatrix<f64> {
        let n = self.states();
        let mut map = DMatrix::identity(n + EXTRA, n + EXTRA);
        map.row_mut(n + GAP).fill(0.0);
        if self.has_gap() {
            // The gap does not fade in the first tick after the release.
            let gap = (self.extra(REFERENCE) - self.hand(vertex)) / self.gap_factor;
            map.row_mut(n + GAP).copy_from(&gap.row(0));
        }
        map
    }

    pub(super) fn blend(&self, vertex: usize, weight: f64) -> DMatrix<f64> {
        let force = self.force(vertex) * weight + self.fed_back() * (1.0 - weight);
        self.tick(vertex, &self.reference(vertex), &force)
    }

    pub(super) fn closed(&self) -> DMatrix<f64> {
        let n = self.states();
        let mut map = DMatrix::identity(n + EXTRA, n + EXTRA);
        map[(n + GAP, n + GAP)] = 0.0;
        map
    }
}
