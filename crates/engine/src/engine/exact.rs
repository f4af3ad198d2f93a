use super::{IntegrationError, MasterOutput, Plants, SlaveOutput, TissueForce};
use crate::plant::{MASTER_STATES, MasterStep, SLAVE_STATES, SlaveStep};
use trocar_core::lane::{Gather, LANES, Lane, by_index, of_each};

/// `x_h, v_h, x_a, v_a`; then the force integral and `F_h` at the next tick.
const MOTION_ROWS: usize = MASTER_STATES - 1;
const FORCE_ROWS: usize = 2;
const MASTER_COLUMNS: usize = MASTER_STATES + 3;
/// Even, to fill vector registers.
const SLAVE_ROWS: usize = SLAVE_STATES + 1;
const SLAVE_COLUMNS: usize = SLAVE_STATES + 1;

pub trait Coefficient<L>: Copy {
    fn in_lanes(self) -> L;
}

impl<L: Lane> Coefficient<L> for L {
    #[inline(always)]
    fn in_lanes(self) -> L {
        self
    }
}

#[derive(Debug, Clone, Copy)]
pub struct Shared(f64);

impl<L: Lane> Coefficient<L> for Shared {
    #[inline(always)]
    fn in_lanes(self) -> L {
        L::splat(self.0)
    }
}

/// Aligned, so that each vector is within a cache line. The field order separates the states: adjacent ones would be
/// written and read as vectors with other bounds, and the reads would stall on the store buffer.
#[derive(Debug, Clone)]
#[repr(C, align(64))]
pub struct ExactPlants<L, C = L> {
    motion: [[C; MOTION_ROWS]; MASTER_COLUMNS],
    motion_state: [L; MOTION_ROWS],
    slave: [[C; SLAVE_ROWS]; SLAVE_COLUMNS],
    slave_state: [L; SLAVE_ROWS],
    forces: [[C; FORCE_ROWS]; MASTER_COLUMNS],
    force_state: [L; FORCE_ROWS],
}

impl<L: Lane> ExactPlants<L> {
    pub fn new(master: &MasterStep, slave: &SlaveStep, master_m: f64, reference_m: f64) -> Self {
        let motion =
            |column: [f64; MASTER_STATES]| -> [L; MOTION_ROWS] { std::array::from_fn(|i| L::splat(column[i])) };
        let forces = |column: [f64; MASTER_STATES]| -> [L; FORCE_ROWS] {
            let hand_force = (0..MASTER_STATES).map(|i| master.hand_force[i] * column[i]).sum();
            [L::splat(column[MOTION_ROWS]), L::splat(hand_force)]
        };
        let padded = |column: [f64; SLAVE_STATES]| -> [L; SLAVE_ROWS] {
            std::array::from_fn(|i| L::splat(if i < SLAVE_STATES { column[i] } else { 0.0 }))
        };
        let master_column = |j: usize| match j {
            5 => master.desired_now,
            6 => master.desired_next,
            7 => master.feedback,
            _ => std::array::from_fn(|i| master.transition[i][j]),
        };
        let slave_column = |j: usize| match j {
            SLAVE_STATES => slave.reference,
            _ => std::array::from_fn(|i| slave.transition[i][j]),
        };
        let rest = [master_m, 0.0, master_m, 0.0, 0.0];
        Self {
            motion: std::array::from_fn(|j| motion(master_column(j))),
            forces: std::array::from_fn(|j| forces(master_column(j))),
            slave: std::array::from_fn(|j| padded(slave_column(j))),
            motion_state: motion(rest),
            force_state: forces(rest),
            slave_state: padded(slave.rest.map(|share| share * reference_m)),
        }
    }
}

#[derive(Debug, Clone, Copy)]
pub(super) struct ForceColumn<L> {
    motion: [L; MOTION_ROWS],
    forces: [L; FORCE_ROWS],
}

impl<L: Lane> ForceColumn<L> {
    pub(super) fn of(master: &MasterStep) -> Self {
        let hand_force: f64 = (0..MASTER_STATES).map(|i| master.hand_force[i] * master.feedback[i]).sum();
        Self {
            motion: std::array::from_fn(|i| L::splat(master.feedback[i])),
            forces: [L::splat(master.feedback[MOTION_ROWS]), L::splat(hand_force)],
        }
    }
}

impl<L: Lane> ExactPlants<L> {
    #[inline(always)]
    pub(super) fn add_force(&mut self, column: &ForceColumn<L>, force: L) {
        self.motion_state = by_index!(MOTION_ROWS, |i| self.motion_state[i] + column.motion[i] * force);
        self.force_state = by_index!(FORCE_ROWS, |i| self.force_state[i] + column.forces[i] * force);
    }

    #[inline(always)]
    pub(super) fn add_reference(&mut self, column: &[L; SLAVE_STATES], reference: L) {
        let [x_e, v_e, third] = by_index!(SLAVE_STATES, |i| self.slave_state[i] + column[i] * reference);
        self.slave_state = [x_e, v_e, third, self.slave_state[SLAVE_STATES]];
    }
}

/// Two sums, over even and odd `j`, halve the latency.
#[inline(always)]
pub(super) fn combine<L: Lane, C: Coefficient<L>, const ROWS: usize, const COLUMNS: usize>(
    columns: &[[C; ROWS]; COLUMNS],
    inputs: [L; COLUMNS],
) -> [L; ROWS] {
    let mut even: [L; ROWS] = by_index!(ROWS, |i| columns[0][i].in_lanes() * inputs[0]);
    let mut odd: [L; ROWS] = by_index!(ROWS, |i| columns[1][i].in_lanes() * inputs[1]);
    for j in (2..COLUMNS).step_by(2) {
        for i in 0..ROWS {
            even[i] = even[i] + columns[j][i].in_lanes() * inputs[j];
            odd[i] = odd[i] + columns[j + 1][i].in_lanes() * inputs[j + 1];
        }
    }
    by_index!(ROWS, |i| even[i] + odd[i])
}

impl<L: Lane, C: Coefficient<L>> Plants<L> for ExactPlants<L, C> {
    #[inline(always)]
    fn master(&self) -> MasterOutput<L> {
        MasterOutput {
            position_m: self.motion_state[0],
            velocity_m_per_s: self.motion_state[1],
            hand_force_n: self.force_state[1],
        }
    }

    #[inline(always)]
    fn slave(&self) -> SlaveOutput<L> {
        SlaveOutput { position_m: self.slave_state[0], velocity_m_per_s: self.slave_state[1] }
    }

    #[inline(always)]
    fn step(
        &mut self,
        desired: L,
        desired_next: L,
        feedback: L,
        reference: L,
        deflection: L,
        _: TissueForce<L>,
    ) -> Result<(), IntegrationError> {
        let ([x_h, v_h, x_a, v_a], [integral, _]) = (self.motion_state, self.force_state);
        let inputs = [x_h, v_h, x_a, v_a, integral, desired, desired_next, feedback];
        self.motion_state = combine(&self.motion, inputs);
        self.force_state = combine(&self.forces, inputs);
        let [x_e, v_e, third, _] = self.slave_state;
        self.slave_state = combine(&self.slave, [x_e, v_e, third, reference - deflection]);
        if L::WIDTH > 1 {
            self.slave_state[SLAVE_STATES] = L::zero();
        }
        Ok(())
    }
}

impl ExactPlants<f64> {
    fn gather_alike<L: Lane>(all: [&Self; LANES]) -> Option<ExactPlants<L, Shared>> {
        fn same<const ROWS: usize, const COLUMNS: usize>(
            a: &[[f64; ROWS]; COLUMNS],
            b: &[[f64; ROWS]; COLUMNS],
        ) -> bool {
            a.iter().flatten().zip(b.iter().flatten()).all(|(a, b)| a.to_bits() == b.to_bits())
        }
        let first = all[0];
        let is_equal = |one: &&Self| {
            same(&one.motion, &first.motion) && same(&one.forces, &first.forces) && same(&one.slave, &first.slave)
        };
        all.iter().all(is_equal).then_some(())?;
        Some(ExactPlants {
            motion: first.motion.map(|column| column.map(Shared)),
            forces: first.forces.map(|column| column.map(Shared)),
            slave: first.slave.map(|column| column.map(Shared)),
            motion_state: Gather::gather(of_each!(all, |one| &one.motion_state))?,
            slave_state: Gather::gather(of_each!(all, |one| &one.slave_state))?,
            force_state: Gather::gather(of_each!(all, |one| &one.force_state))?,
        })
    }
}

/// A branch per tick costs less than compiling every run twice.
#[derive(Debug, Clone)]
#[allow(clippy::large_enum_variant, reason = "the machines of eight cases each are eight times as large")]
pub enum GatheredPlants<L> {
    Alike(ExactPlants<L, Shared>),
    Different(ExactPlants<L>),
}

impl<L: Lane> GatheredPlants<L> {
    pub fn gather(all: [&ExactPlants<f64>; LANES]) -> Option<Self> {
        ExactPlants::gather_alike(all).map(Self::Alike).or_else(|| ExactPlants::gather(all).map(Self::Different))
    }
}

impl<L: Lane> Plants<L> for GatheredPlants<L> {
    #[inline(always)]
    fn master(&self) -> MasterOutput<L> {
        match self {
            Self::Alike(plants) => plants.master(),
            Self::Different(plants) => plants.master(),
        }
    }

    #[inline(always)]
    fn slave(&self) -> SlaveOutput<L> {
        match self {
            Self::Alike(plants) => plants.slave(),
            Self::Different(plants) => plants.slave(),
        }
    }

    #[inline(always)]
    fn step(
        &mut self,
        desired: L,
        desired_next: L,
        feedback: L,
        reference: L,
        deflection: L,
        force: TissueForce<L>,
    ) -> Result<(), IntegrationError> {
        match self {
            Self::Alike(plants) => plants.step(desired, desired_next, feedback, reference, deflection, force),
            Self::Different(plants) => plants.step(desired, desired_next, feedback, reference, deflection, force),
        }
    }
}

trocar_core::lane::gather!(ExactPlants { motion, forces, slave, motion_state, slave_state, force_state });
