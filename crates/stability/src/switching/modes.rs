//! The one-tick maps of teleoperation, of the frozen phase and of re-engaging.

use nalgebra::{DMatrix, DVector};

use crate::machines::Machines;
use crate::side::{OwnPart, Side};
use crate::{LinearLoop, StabilityError, SwitchingSettings};
use trocar_core::augmentation::{AmplifySettings, DecaySettings, ForceLawSettings, Freeze, Reengage};

/// A space of states: the loop's states `x`, and those of the extra states that matter in a phase.
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
    /// `(x, r, φ, F*, F_t)`, as far as the force law uses them: frozen.
    Frozen,
    /// `(r, F*, F_t)`, as far as the force law uses them: constant while frozen.
    Held,
    /// `g`.
    Gap,
    /// A quantity to bound.
    Number,
    /// A metre of the hand's release.
    Start,
    /// All states.
    All,
}

/// Extra states after those of the loop.
const REFERENCE: usize = 0;
const FED_BACK: usize = 1;
const ANCHOR: usize = 2;
const TISSUE: usize = 3;
const GAP: usize = 4;
const EXTRA: usize = 5;

/// A range's end for the tissue: `f = K p + B v`.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Vertex {
    stiffness_n_per_m: f64,
    damping_n_s_per_m: f64,
}

/// The linear maps. Positions are relative to the tissue's surface and to the hand's desired position.
///
/// ```text
/// (x, r, φ, F*, F_t, g)     x: master's side, slave's side, hand positions on the way, latest first;
///                           r the reference, φ the force last fed back, F* that at the alarm, F_t the measured one there,
///                           g the gap: x_ref = hand + g
/// ```
/// The supervisor and the slave use the hand's position that has arrived; mode and force arrive at the master later by the
/// backward delay. The master's states are those of the tick at which the slave's samples arrive: then both sides switch
/// at the same time, and all of the delay lies between the hand and the slave.
///
/// The states of a map are those before the tick's force, so that an event that begins at tick `k` uses `x` at `k - 1`:
/// the anchor `F*` and the last reference are those of that tick.
#[derive(Debug, Clone)]
pub(super) struct Modes {
    master: Side,
    /// One for each vertex of the tissue.
    slaves: Vec<Side>,
    /// Whole ticks of both delays.
    delay: usize,
    integral: bool,
    law: ForceLawSettings,
    freeze: Freeze,
    reengage: Reengage,
    /// Decay factor per tick.
    decay_factor: f64,
    pub(super) tick_s: f64,
}

impl Modes {
    pub(super) fn new(settings: &SwitchingSettings) -> Result<Self, StabilityError> {
        let machines = Machines::new(&settings.of_loop)?;
        let (softest, stiffest) = settings.stiffness_n_per_m;
        let damping_n_s_per_m = settings.of_loop.damping_n_s_per_m;
        let in_contact = |stiffness_n_per_m| Vertex { stiffness_n_per_m, damping_n_s_per_m };
        let mut vertices = vec![in_contact(softest), in_contact(stiffest)];
        if settings.loses_contact {
            vertices.push(Vertex { stiffness_n_per_m: 0.0, damping_n_s_per_m: 0.0 });
        }
        let slave = |vertex: &Vertex| {
            let settings = LinearLoop {
                stiffness_n_per_m: vertex.stiffness_n_per_m,
                damping_n_s_per_m: vertex.damping_n_s_per_m,
                ..settings.of_loop.clone()
            };
            Side::slave_with(&machines, &settings, OwnPart::Open)
        };
        let augmentation = &settings.augmentation;
        let tick_s = settings.of_loop.tick_s;
        let decay_factor = match augmentation.force {
            ForceLawSettings::Decay(DecaySettings { time_constant_s, .. }) => libm::exp(-tick_s / time_constant_s),
            ForceLawSettings::Amplify(_) | ForceLawSettings::Damp(_) => 0.0,
        };
        Ok(Self {
            master: Side::master_with(&machines, &settings.of_loop, OwnPart::Open)?,
            slaves: vertices.iter().map(slave).collect::<Result<_, _>>()?,
            delay: settings.delay_ticks() as usize,
            integral: settings.of_loop.master.force_integral_gain != 0.0,
            // The added damping is left out, and told so; what remains is the measured force.
            law: match augmentation.force {
                ForceLawSettings::Damp(_) => ForceLawSettings::Amplify(AmplifySettings { gain: 1.0 }),
                law => law,
            },
            freeze: augmentation.freeze,
            reengage: augmentation.reengage,
            decay_factor,
            tick_s,
        })
    }

    /// Number of states of the loop.
    pub(super) fn states(&self) -> usize {
        self.master.a.nrows() + self.slaves[0].a.nrows() + self.delay
    }

    /// Number of all states.
    pub(super) fn places_all(&self) -> usize {
        self.states() + EXTRA
    }

    /// Number of states of the master's side, which come first.
    pub(super) fn master_states(&self) -> usize {
        self.master.a.nrows()
    }

    /// Number of hand positions on the way, which come last.
    pub(super) fn delay(&self) -> usize {
        self.delay
    }

    /// The decay of the slowest mode of teleoperation on any vertex of the tissue, in 1/s; 0 if one does not decay.
    pub(super) fn slowest_decay_per_s(&self) -> Result<f64, StabilityError> {
        let mut largest: f64 = 0.0;
        for vertex in self.vertices() {
            let matrix = self.between(&self.teleoperation(vertex), Space::Loop, Space::Loop);
            largest = trocar_lti::eigenvalues(&matrix)?.into_iter().map(|value| value.norm()).fold(largest, f64::max);
        }
        Ok((-largest.ln() / self.tick_s).max(0.0))
    }

    /// The same without a delay.
    pub(super) fn without_delay(&self) -> Self {
        Self { delay: 0, ..self.clone() }
    }

    /// The ends of the tissue's range.
    pub(super) fn vertices(&self) -> std::ops::Range<usize> {
        0..self.slaves.len()
    }

    /// Name and unit of each state of a space, in order.
    pub(super) fn names(&self, space: Space) -> Vec<(String, &'static str)> {
        let own = |text: &str, unit| (text.to_owned(), unit);
        let mut of_loop = vec![own("x_h", "m"), own("v_h", "m/s"), own("x_a", "m"), own("v_a", "m/s")];
        if self.integral {
            of_loop.push(own("master_force_integral", "N s"));
        }
        for k in of_loop.len()..self.master.a.nrows() {
            of_loop.push((format!("master_{k}"), "1"));
        }
        of_loop.extend([own("x_e", "m"), own("v_e", "m/s"), own("slave_motor", "m/s^2")]);
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
        ];
        let all: Vec<(String, &'static str)> =
            of_loop.into_iter().chain(extra.map(|(name, unit)| own(name, unit))).collect();
        if matches!(space, Space::Number | Space::Start) {
            return vec![own("one", "1")];
        }
        self.places(space).into_iter().map(|place| all[place].clone()).collect()
    }

    /// Whether the feedback force depends on the force at the alarm.
    fn has_anchor(&self) -> bool {
        !matches!(self.law, ForceLawSettings::Decay(DecaySettings { ratio: 0.0, .. }))
    }

    /// Whether there is a gap between hand and reference after an event.
    pub(super) fn has_gap(&self) -> bool {
        self.reengage != Reengage::Snap
    }

    /// Whether the gap closes after an event.
    pub(super) fn gap_closes(&self) -> bool {
        self.reengage != Reengage::Clutch
    }

    /// The states of a space among all.
    fn places(&self, space: Space) -> Vec<usize> {
        let n = self.states();
        let mut places: Vec<usize> = match space {
            Space::Gap | Space::Held | Space::Number | Space::Start => vec![],
            Space::Loop | Space::LoopGap | Space::Fading | Space::FadingGap | Space::Frozen | Space::All => {
                (0..n).collect()
            }
        };
        match space {
            Space::Loop | Space::Number | Space::Start => {}
            Space::LoopGap | Space::Gap => places.push(n + GAP),
            Space::Fading => places.push(n + FED_BACK),
            Space::FadingGap => places.extend([n + FED_BACK, n + GAP]),
            Space::Frozen | Space::Held => {
                places.push(n + REFERENCE);
                if space == Space::Frozen {
                    places.push(n + FED_BACK);
                }
                if self.has_anchor() {
                    places.push(n + ANCHOR);
                }
                if matches!(self.law, ForceLawSettings::Amplify(_)) {
                    places.push(n + TISSUE);
                }
            }
            Space::All => places.extend(n..n + EXTRA),
        }
        places
    }

    /// Number of states of a space.
    pub(super) fn size(&self, space: Space) -> usize {
        if matches!(space, Space::Number | Space::Start) { 1 } else { self.places(space).len() }
    }

    /// The rows and columns of a map over all states that lead from one space to another.
    pub(super) fn between(&self, map: &DMatrix<f64>, from: Space, to: Space) -> DMatrix<f64> {
        map.select_rows(&self.places(to)).select_columns(&self.places(from))
    }

    /// The states that two spaces share; the others of `to` are 0.
    pub(super) fn selection(&self, from: Space, to: Space) -> DMatrix<f64> {
        self.between(&DMatrix::identity(self.states() + EXTRA, self.states() + EXTRA), from, to)
    }

    /// A row over a space from one over all states.
    pub(super) fn row(&self, row: &DMatrix<f64>, space: Space) -> DMatrix<f64> {
        row.select_columns(&self.places(space))
    }

    /// A row over all states, with weights on both sides.
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

    /// The target of the slave: the hand's position that has arrived, scaled, and the slave's own part, in m.
    pub(super) fn hand(&self, vertex: usize) -> DMatrix<f64> {
        let nothing = DVector::zeros(self.master.c.len());
        let own = self.weights(&nothing, &self.slaves[vertex].own);
        let arrived = match self.delay {
            0 => self.weights(&self.master.c, &DVector::zeros(self.slaves[vertex].c.len())),
            _ => self.unit(self.states() - 1),
        };
        own + arrived
    }

    /// The slave's position in m.
    pub(super) fn slave(&self) -> DMatrix<f64> {
        self.unit(self.master.a.nrows())
    }

    /// The whole force fed back in teleoperation, in N.
    pub(super) fn force(&self, vertex: usize) -> DMatrix<f64> {
        self.weights(&self.master.own, &self.slaves[vertex].c)
    }

    /// The measured force scaled to the master, in N.
    fn measured(&self, vertex: usize) -> DMatrix<f64> {
        self.weights(&DVector::zeros(self.master.c.len()), &self.slaves[vertex].force)
    }

    /// The force last fed back, in N.
    pub(super) fn fed_back(&self) -> DMatrix<f64> {
        self.extra(FED_BACK)
    }

    fn column(&self, at: usize, part: &DVector<f64>) -> DMatrix<f64> {
        let mut column = DMatrix::zeros(self.states() + EXTRA, 1);
        column.view_mut((at, 0), (part.len(), 1)).copy_from(part);
        column
    }

    /// The effect of a metre of reference.
    pub(super) fn of_reference(&self) -> DMatrix<f64> {
        self.column(self.master.a.nrows(), &self.slaves[0].now)
    }

    /// The effect of a newton of feedback force.
    pub(super) fn of_force(&self) -> DMatrix<f64> {
        self.column(0, &self.master.now)
    }

    /// The effect of a metre of desired position, held over the tick.
    pub(super) fn of_desired(&self) -> DMatrix<f64> {
        match &self.master.desired {
            Some((now, next)) => self.column(0, &(now + next)),
            None => DMatrix::zeros(self.states() + EXTRA, 1),
        }
    }

    /// The loop at the first tick after the desired position steps to the origin, with the hand at rest a metre away.
    pub(super) fn after_step(&self, vertex: usize) -> DVector<f64> {
        let (n, at) = (self.states(), self.master.a.nrows());
        let slave = self.slaves[vertex].a.nrows();
        let mut state = DVector::zeros(n + EXTRA);
        // Master and arm: `x_h` and `x_a`.
        (state[0], state[2]) = (1.0, 1.0);
        let sent = self.weights(&self.master.c, &DVector::zeros(slave)) * &state;
        state.rows_mut(n - self.delay, self.delay).fill(sent[0]);
        // The slave in equilibrium at its reference.
        let input = &self.slaves[vertex].now * sent[0];
        let apart = DMatrix::identity(slave, slave) - &self.slaves[vertex].a;
        if let Some(rest) = apart.lu().solve(&input) {
            state.rows_mut(at, slave).copy_from(&rest);
        }
        let mut next = self.teleoperation(vertex) * &state;
        if let Some((now, _)) = &self.master.desired {
            let mut of_master = next.rows_mut(0, at);
            of_master += now;
        }
        next
    }

    /// Both sides and the delay without a reference and a feedback force, all extra states kept.
    pub(super) fn apart(&self, vertex: usize) -> DMatrix<f64> {
        let slave = &self.slaves[vertex];
        let (m, s, n) = (self.master.a.nrows(), slave.a.nrows(), self.states());
        let mut a = DMatrix::zeros(n + EXTRA, n + EXTRA);
        a.view_mut((0, 0), (m, m)).copy_from(&self.master.a);
        a.view_mut((m, m), (s, s)).copy_from(&slave.a);
        if self.delay > 0 {
            a.view_mut((m + s, 0), (1, m)).tr_copy_from(&self.master.c);
        }
        for tick in 1..self.delay {
            a[(m + s + tick, m + s + tick - 1)] = 1.0;
        }
        for state in n..n + EXTRA {
            a[(state, state)] = 1.0;
        }
        a
    }

    /// A tick with the reference and the feedback force as rows over all states.
    fn tick(&self, vertex: usize, reference: &DMatrix<f64>, force: &DMatrix<f64>) -> DMatrix<f64> {
        self.apart(vertex) + self.of_reference() * reference + self.of_force() * force
    }

    /// The reference in teleoperation and when re-engaging.
    fn reference(&self, vertex: usize) -> DMatrix<f64> {
        let hand = self.hand(vertex);
        if self.has_gap() { hand + self.extra(GAP) } else { hand }
    }

    /// A tick of teleoperation, with the gap if there is one. Keeps the reference and the force for an event.
    pub(super) fn teleoperation(&self, vertex: usize) -> DMatrix<f64> {
        let (reference, force) = (self.reference(vertex), self.force(vertex));
        let mut map = self.tick(vertex, &reference, &force);
        map.row_mut(self.states() + REFERENCE).copy_from(&reference.row(0));
        map.row_mut(self.states() + FED_BACK).copy_from(&force.row(0));
        map.row_mut(self.states() + TISSUE).copy_from(&self.measured(vertex).row(0));
        map
    }

    /// The beginning of an event, after the last tick of teleoperation.
    pub(super) fn freeze(&self) -> DMatrix<f64> {
        let n = self.states();
        let mut map = DMatrix::identity(n + EXTRA, n + EXTRA);
        if self.freeze == Freeze::Measured {
            map.row_mut(n + REFERENCE).copy_from(&self.slave().row(0));
        }
        map.row_mut(n + ANCHOR).copy_from(&self.fed_back().row(0));
        map
    }

    /// A frozen tick. The law `amplify` has a floor: `share` is 1 for the map without it and 0 for the constant `F*`; the
    /// floored force always lies between the two.
    pub(super) fn frozen(&self, vertex: usize, share: f64) -> DMatrix<f64> {
        let fed_back = match self.law {
            ForceLawSettings::Decay(DecaySettings { ratio, .. }) => {
                self.fed_back() * self.decay_factor + self.extra(ANCHOR) * (ratio * (1.0 - self.decay_factor))
            }
            ForceLawSettings::Amplify(_) | ForceLawSettings::Damp(_) => {
                let gain = if let ForceLawSettings::Amplify(AmplifySettings { gain }) = self.law { gain } else { 1.0 };
                // The coupling of the positions keeps its value, so that only the measured force varies.
                self.extra(ANCHOR) + (self.measured(vertex) - self.extra(TISSUE)) * (share * gain)
            }
        };
        let mut map = self.tick(vertex, &self.extra(REFERENCE), &fed_back);
        map.row_mut(self.states() + FED_BACK).copy_from(&fed_back.row(0));
        map
    }

    /// Whether the frozen map is the same for every tissue and force, so that its powers are exact.
    pub(super) fn is_frozen_map_unique(&self) -> bool {
        matches!(self.law, ForceLawSettings::Decay(_)) && self.slaves.iter().all(|slave| slave.a == self.slaves[0].a)
    }

    /// The shares at which [`Self::frozen`] is needed.
    pub(super) fn shares(&self) -> &'static [f64] {
        if matches!(self.law, ForceLawSettings::Decay(_)) { &[1.0] } else { &[0.0, 1.0] }
    }

    /// Whether the target of the slave or the machines depend on the tissue.
    pub(super) fn has_unique_motion(&self) -> bool {
        let alike = |slave: &Side| slave.a == self.slaves[0].a && slave.own == self.slaves[0].own;
        self.slaves.iter().all(alike)
    }

    /// The beginning of re-engaging.
    pub(super) fn release(&self, vertex: usize) -> DMatrix<f64> {
        let n = self.states();
        let mut map = DMatrix::identity(n + EXTRA, n + EXTRA);
        map.row_mut(n + GAP).fill(0.0);
        if self.has_gap() {
            map.row_mut(n + GAP).copy_from(&(self.extra(REFERENCE) - self.hand(vertex)).row(0));
        }
        map
    }

    /// A tick of the cross-fade with a weight of the measured force.
    pub(super) fn blend(&self, vertex: usize, weight: f64) -> DMatrix<f64> {
        let force = self.force(vertex) * weight + self.fed_back() * (1.0 - weight);
        self.tick(vertex, &self.reference(vertex), &force)
    }

    /// A gap that has closed.
    pub(super) fn closed(&self) -> DMatrix<f64> {
        let n = self.states();
        let mut map = DMatrix::identity(n + EXTRA, n + EXTRA);
        map[(n + GAP, n + GAP)] = 0.0;
        map
    }
}
