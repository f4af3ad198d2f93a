//! The one-tick maps of teleoperation, of the frozen phase and of re-engaging.

use nalgebra::{DMatrix, DVector};

use crate::augmentation::{AmplifySettings, DecaySettings, ForceLawSettings, Freeze, Reengage};
use crate::stability::machines::Machines;
use crate::stability::side::Side;
use crate::stability::{StabilityError, SwitchingSettings};

/// The linear maps. Positions are relative to the tissue's surface and to the hand's desired position.
///
/// ```text
/// x = (master's side, slave's side)                       the loop in teleoperation: x⁺ = A(K) x
/// y = (x, r, φ, F*)                                       frozen: r is the reference, φ the force last fed back
/// z = (x, F_a), and the gap g                             re-engaging: x_ref = s_p x_h + g
/// ```
/// The states of a map are those before the tick's force, so that an event that begins at tick `k` uses `x` at `k - 1`:
/// the anchor `F*` and the last reference are those of that tick.
#[derive(Debug, Clone)]
pub(super) struct Modes {
    master: Side,
    /// On the minimum and on the maximum stiffness.
    slaves: [Side; 2],
    law: ForceLawSettings,
    freeze: Freeze,
    reengage: Reengage,
    /// Decay factor per tick.
    decay_factor: f64,
}

impl Modes {
    pub(super) fn new(settings: &SwitchingSettings) -> Result<Self, StabilityError> {
        let machines = Machines::new(&settings.of_loop)?;
        let slave = |stiffness_n_per_m| {
            let settings = crate::stability::LoopSettings { stiffness_n_per_m, ..settings.of_loop.clone() };
            Side::slave(&machines, &settings)
        };
        let (softest, stiffest) = settings.stiffness_n_per_m;
        let augmentation = &settings.augmentation;
        let decay_factor = match augmentation.force {
            ForceLawSettings::Decay(DecaySettings { time_constant_s, .. }) => {
                libm::exp(-settings.of_loop.tick_s / time_constant_s)
            }
            ForceLawSettings::Amplify(_) => 0.0,
        };
        Ok(Self {
            master: Side::master(&machines, &settings.of_loop)?,
            slaves: [slave(softest)?, slave(stiffest)?],
            law: augmentation.force,
            freeze: augmentation.freeze,
            reengage: augmentation.reengage,
            decay_factor,
        })
    }

    /// Number of states of the loop.
    pub(super) fn states(&self) -> usize {
        self.master.a.nrows() + self.slaves[0].a.nrows()
    }

    /// Number of states of the master's side, which come first.
    pub(super) fn master_states(&self) -> usize {
        self.master.a.nrows()
    }

    /// Number of states while frozen.
    pub(super) fn frozen_states(&self) -> usize {
        self.states() + 2 + usize::from(self.has_anchor())
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

    /// A row over the loop's states from weights on both sides.
    fn weights(&self, of_master: &DVector<f64>, of_slave: &DVector<f64>) -> DMatrix<f64> {
        let mut row = DMatrix::zeros(1, self.states());
        row.view_mut((0, 0), (1, of_master.len())).tr_copy_from(of_master);
        row.view_mut((0, of_master.len()), (1, of_slave.len())).tr_copy_from(of_slave);
        row
    }

    /// The hand's position, scaled to the slave, in m.
    pub(super) fn hand(&self) -> DMatrix<f64> {
        self.weights(&self.master.c, &DVector::zeros(self.slaves[0].c.len()))
    }

    /// The slave's position in m.
    pub(super) fn slave(&self) -> DMatrix<f64> {
        let n = self.slaves[0].c.len();
        self.weights(&DVector::zeros(self.master.c.len()), &DVector::from_fn(n, |i, _| f64::from(u8::from(i == 0))))
    }

    /// The force fed back in teleoperation, in N.
    pub(super) fn force(&self, vertex: usize) -> DMatrix<f64> {
        self.weights(&DVector::zeros(self.master.c.len()), &self.slaves[vertex].c)
    }

    /// The effect of a metre of reference on the loop.
    pub(super) fn of_reference(&self) -> DMatrix<f64> {
        let mut column = DMatrix::zeros(self.states(), 1);
        let at = self.master.a.nrows();
        column.view_mut((at, 0), (self.slaves[0].now.len(), 1)).copy_from(&self.slaves[0].now);
        column
    }

    /// The effect of a newton of feedback force on the loop.
    pub(super) fn of_force(&self) -> DMatrix<f64> {
        let mut column = DMatrix::zeros(self.states(), 1);
        column.view_mut((0, 0), (self.master.now.len(), 1)).copy_from(&self.master.now);
        column
    }

    /// The effect of a metre of desired position, held over the tick, on the loop.
    pub(super) fn of_desired(&self) -> DMatrix<f64> {
        let mut column = DMatrix::zeros(self.states(), 1);
        if let Some((now, next)) = &self.master.desired {
            column.view_mut((0, 0), (now.len(), 1)).copy_from(&(now + next));
        }
        column
    }

    /// The loop at the first tick after the desired position steps to the origin, with the hand at rest a metre away.
    pub(super) fn after_step(&self, vertex: usize) -> DVector<f64> {
        let (n, at) = (self.states(), self.master.a.nrows());
        let mut state = DVector::zeros(n);
        // Master and arm: `x_h` and `x_a`.
        (state[0], state[2]) = (1.0, 1.0);
        // The slave in equilibrium at its reference.
        let input = self.of_reference() * (self.hand() * &state);
        let apart = DMatrix::identity(n, n) - self.apart(vertex);
        let of_slave = apart.view((at, at), (n - at, n - at)).into_owned();
        if let Some(rest) = of_slave.lu().solve(&input.rows(at, n - at).into_owned()) {
            state.rows_mut(at, n - at).copy_from(&rest.column(0));
        }
        let mut next = self.teleoperation(vertex) * &state;
        if let Some((now, _)) = &self.master.desired {
            let mut of_master = next.rows_mut(0, at);
            of_master += now;
        }
        next
    }

    /// Both sides without received signals.
    pub(super) fn apart(&self, vertex: usize) -> DMatrix<f64> {
        let (m, s) = (self.master.a.nrows(), self.slaves[0].a.nrows());
        let mut a = DMatrix::zeros(m + s, m + s);
        a.view_mut((0, 0), (m, m)).copy_from(&self.master.a);
        a.view_mut((m, m), (s, s)).copy_from(&self.slaves[vertex].a);
        a
    }

    /// A tick of teleoperation.
    pub(super) fn teleoperation(&self, vertex: usize) -> DMatrix<f64> {
        self.apart(vertex) + self.of_reference() * self.hand() + self.of_force() * self.force(vertex)
    }

    /// The last tick of teleoperation before an event: `x` to `y`, or with a kept gap `(x, g)` to `y`.
    pub(super) fn entry(&self, vertex: usize) -> DMatrix<f64> {
        let n = self.states();
        let columns = if self.gap_closes() { n } else { n + 1 };
        let mut map = DMatrix::zeros(self.frozen_states(), columns);
        let next = self.apart_by_gap(vertex).columns(0, columns).into_owned();
        let mut held = DMatrix::zeros(1, columns);
        match self.freeze {
            Freeze::Measured => held.copy_from(&(self.slave() * &next)),
            Freeze::Reference => {
                held.fill(1.0);
                held.view_mut((0, 0), (1, n)).copy_from(&self.hand());
            }
        }
        map.view_mut((0, 0), (n, columns)).copy_from(&next);
        map.row_mut(n).copy_from(&held.row(0));
        for state in n + 1..self.frozen_states() {
            map.view_mut((state, 0), (1, n)).copy_from(&self.force(vertex));
        }
        map
    }

    /// A frozen tick, `y` to `y`. The law `amplify` has a floor: `share` is 1 for the map without it and 0 for the
    /// constant `F*`; the floored force always lies between the two.
    pub(super) fn frozen(&self, vertex: usize, share: f64) -> DMatrix<f64> {
        let (n, all) = (self.states(), self.frozen_states());
        let mut fed_back = DMatrix::zeros(1, all);
        match self.law {
            ForceLawSettings::Decay(DecaySettings { ratio, .. }) => {
                fed_back[n + 1] = self.decay_factor;
                if self.has_anchor() {
                    fed_back[n + 2] = ratio * (1.0 - self.decay_factor);
                }
            }
            ForceLawSettings::Amplify(AmplifySettings { gain }) => {
                fed_back.view_mut((0, 0), (1, n)).copy_from(&(self.force(vertex) * (share * gain)));
                fed_back[n + 2] = 1.0 - share * gain;
            }
        }
        let mut map = DMatrix::zeros(all, all);
        map.view_mut((0, 0), (n, n)).copy_from(&self.apart(vertex));
        map.view_mut((0, n), (n, 1)).copy_from(&self.of_reference());
        let mut of_master = map.rows_mut(0, n);
        of_master += self.of_force() * &fed_back;
        map[(n, n)] = 1.0;
        map.row_mut(n + 1).copy_from(&fed_back.row(0));
        if self.has_anchor() {
            map[(n + 2, n + 2)] = 1.0;
        }
        map
    }

    /// Whether the frozen map is the same for every tissue and force, so that its powers are exact.
    pub(super) fn is_frozen_map_unique(&self) -> bool {
        matches!(self.law, ForceLawSettings::Decay(_)) && self.slaves[0].a == self.slaves[1].a
    }

    /// The shares at which [`Self::frozen`] is needed.
    pub(super) fn shares(&self) -> &'static [f64] {
        if matches!(self.law, ForceLawSettings::Decay(_)) { &[1.0] } else { &[0.0, 1.0] }
    }

    /// `y` to `z` at the beginning of re-engaging.
    pub(super) fn release(&self) -> DMatrix<f64> {
        let n = self.states();
        DMatrix::from_fn(n + 1, self.frozen_states(), |i, j| {
            f64::from(u8::from(i == j && i < n || i == n && j == n + 1))
        })
    }

    /// The gap at the beginning of re-engaging, from `y`.
    pub(super) fn gap(&self) -> DMatrix<f64> {
        let n = self.states();
        let mut row = DMatrix::zeros(1, self.frozen_states());
        row.view_mut((0, 0), (1, n)).copy_from(&-self.hand());
        row[n] = 1.0;
        row
    }

    /// A tick of the cross-fade, `(z, g)` to `z`, with a weight of the measured force.
    pub(super) fn blend(&self, vertex: usize, weight: f64) -> DMatrix<f64> {
        let n = self.states();
        let mut map = DMatrix::zeros(n + 1, n + 2);
        let felt = self.of_force() * self.force(vertex) * weight;
        map.view_mut((0, 0), (n, n)).copy_from(&(self.apart(vertex) + self.of_reference() * self.hand() + felt));
        map.view_mut((0, n), (n, 1)).copy_from(&(self.of_force() * (1.0 - weight)));
        if self.has_gap() {
            map.view_mut((0, n + 1), (n, 1)).copy_from(&self.of_reference());
        }
        map[(n, n)] = 1.0;
        map
    }

    /// A tick of teleoperation with a gap, `(x, g)` to `x`.
    pub(super) fn apart_by_gap(&self, vertex: usize) -> DMatrix<f64> {
        let n = self.states();
        let mut map = DMatrix::zeros(n, n + 1);
        map.view_mut((0, 0), (n, n)).copy_from(&self.teleoperation(vertex));
        map.view_mut((0, n), (n, 1)).copy_from(&self.of_reference());
        map
    }
}
