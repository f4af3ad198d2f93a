//! The sides stepped exactly, by the matrix exponentials of `plant`.

use super::{IntegrationError, MasterReading, Sides, SlaveReading};
use crate::lane::Lane;
use crate::plant::{MASTER_STATES, MasterStep, SLAVE_STATES, SlaveStep};

/// Rows of the master's matrix: its states, and `F_h` at the next tick as one more.
const MASTER_ROWS: usize = MASTER_STATES + 1;
/// Columns: the states, `x_d` now and next, `F_ed`.
const MASTER_COLUMNS: usize = MASTER_STATES + 3;
const HAND_FORCE: usize = MASTER_STATES;
/// Rows of the slave's matrix, an even number so that pairs fill a vector register; the last stays 0.
const SLAVE_ROWS: usize = SLAVE_STATES + 1;
const SLAVE_COLUMNS: usize = SLAVE_STATES + 1;

/// Both sides as two matrices, column by column, and their states.
#[derive(Debug, Clone)]
pub struct ExactSides<L> {
    master: [[L; MASTER_ROWS]; MASTER_COLUMNS],
    slave: [[L; SLAVE_ROWS]; SLAVE_COLUMNS],
    master_state: [L; MASTER_ROWS],
    slave_state: [L; SLAVE_ROWS],
}

impl<L: Lane> ExactSides<L> {
    /// Both sides at rest: master and arm at `master_m`, the slave under the reference `reference_m` (m).
    #[must_use]
    pub fn new(master: &MasterStep, slave: &SlaveStep, master_m: f64, reference_m: f64) -> Self {
        let with_hand_force = |column: [f64; MASTER_STATES]| -> [L; MASTER_ROWS] {
            let force: f64 = (0..MASTER_STATES).map(|i| master.hand_force[i] * column[i]).sum();
            std::array::from_fn(|i| L::splat(if i < MASTER_STATES { column[i] } else { force }))
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
        Self {
            master: std::array::from_fn(|j| with_hand_force(master_column(j))),
            slave: std::array::from_fn(|j| padded(slave_column(j))),
            master_state: with_hand_force([master_m, 0.0, master_m, 0.0, 0.0]),
            slave_state: padded(slave.rest.map(|share| share * reference_m)),
        }
    }
}

/// `Σ_j columns[j] · inputs[j]`, summed in the order of the columns.
#[inline(always)]
fn combine<L: Lane, const ROWS: usize, const COLUMNS: usize>(
    columns: &[[L; ROWS]; COLUMNS],
    inputs: [L; COLUMNS],
) -> [L; ROWS] {
    let mut sum: [L; ROWS] = std::array::from_fn(|i| columns[0][i] * inputs[0]);
    for j in 1..COLUMNS {
        for i in 0..ROWS {
            sum[i] = sum[i] + columns[j][i] * inputs[j];
        }
    }
    sum
}

impl<L: Lane> Sides<L> for ExactSides<L> {
    #[inline(always)]
    fn master(&self) -> MasterReading<L> {
        MasterReading {
            position_m: self.master_state[0],
            velocity_m_per_s: self.master_state[1],
            hand_force_n: self.master_state[HAND_FORCE],
        }
    }

    #[inline(always)]
    fn slave(&self) -> SlaveReading<L> {
        SlaveReading { position_m: self.slave_state[0], velocity_m_per_s: self.slave_state[1] }
    }

    #[inline(always)]
    fn step(&mut self, desired: L, desired_next: L, feedback: L, reference: L) -> Result<(), IntegrationError> {
        let [x_h, v_h, x_a, v_a, integral, _] = self.master_state;
        self.master_state = combine(&self.master, [x_h, v_h, x_a, v_a, integral, desired, desired_next, feedback]);
        let [x_e, v_e, third, _] = self.slave_state;
        self.slave_state = combine(&self.slave, [x_e, v_e, third, reference]);
        Ok(())
    }
}
