use nalgebra::{DMatrix, DVector};

use super::machines::Machines;
use super::response::Response;
use super::side::Side;
use super::{LinearLoop, StabilityError};
use trocar_lti::{Complex64, eigenvalues};

const MAX_STATES: u64 = 4000;

#[derive(Debug, Clone)]
pub struct ClosedLoop {
    tick_s: f64,
    forward: u64,
    backward: u64,
    pub(super) master: Side,
    pub(super) slave: Side,
    responses: [Response; 2],
    pub(super) open_poles: Vec<Complex64>,
}

impl ClosedLoop {
    pub fn new(settings: &LinearLoop) -> Result<Self, StabilityError> {
        Self::of(&Machines::new(settings)?, settings, None)
    }

    /// Reuses the parts that are equal in `other`.
    pub(super) fn of(machines: &Machines, settings: &LinearLoop, other: Option<&Self>) -> Result<Self, StabilityError> {
        trocar_core::error::non_negative("tissue.stiffness_n_per_m", settings.stiffness_n_per_m)?;
        trocar_core::error::non_negative("tissue.damping_n_s_per_m", settings.damping_n_s_per_m)?;
        let sides = (Side::master(machines, settings)?, Side::slave(machines, settings)?);
        Self::of_sides(sides, settings.tick_s, (settings.forward().whole, settings.backward().whole), other)
    }

    pub(super) fn of_sides(
        (master, slave): (Side, Side),
        tick_s: f64,
        (forward, backward): (u64, u64),
        other: Option<&Self>,
    ) -> Result<Self, StabilityError> {
        let open_poles = match other.filter(|other| other.master.a == master.a && other.slave.a == slave.a) {
            Some(other) => other.open_poles.clone(),
            None => [eigenvalues(&master.a)?, eigenvalues(&slave.a)?].concat(),
        };
        let response = |side: &Side, of_other: fn(&Self) -> (&Side, &Response)| {
            let of_other = other.map(of_other).filter(|(known, _)| *known == side);
            of_other.map_or_else(|| Response::new(side), |(_, response)| response.clone())
        };
        Ok(Self {
            tick_s,
            forward,
            backward,
            responses: [
                response(&master, |other| (&other.master, &other.responses[0])),
                response(&slave, |other| (&other.slave, &other.responses[1])),
            ],
            master,
            slave,
            open_poles,
        })
    }

    pub(super) fn with_delays(&self, forward: u64, backward: u64) -> Self {
        Self { forward, backward, ..self.clone() }
    }

    pub(super) fn responses_at(&self, z: Complex64) -> [Complex64; 2] {
        [self.responses[0].at(z), self.responses[1].at(z)]
    }

    pub(super) fn relative_slopes_at(&self, z: Complex64) -> [Complex64; 2] {
        [self.responses[0].relative_slope_at(z), self.responses[1].relative_slope_at(z)]
    }

    pub fn tick_s(&self) -> f64 {
        self.tick_s
    }

    pub fn round_trip_ticks(&self) -> u64 {
        self.forward + self.backward
    }

    /// Includes the delay lines.
    pub fn states(&self) -> u64 {
        let held = u64::from(self.master.before.is_some()) + u64::from(self.slave.before.is_some());
        (self.master.a.nrows() + self.slave.a.nrows()) as u64 + held + self.round_trip_ticks()
    }

    /// `L` at `z = radius · exp(j angle_rad)`; closed-loop poles have `L = 1`.
    pub fn loop_gain(&self, radius: f64, angle_rad: f64) -> Complex64 {
        let z = Complex64::from_polar(radius, angle_rad);
        let gain = self.responses[0].at(z) * self.responses[1].at(z);
        match self.round_trip_ticks() as f64 {
            0.0 => gain,
            ticks => gain * Complex64::from_polar(radius.powf(-ticks), -ticks * angle_rad),
        }
    }

    /// In N per metre of the slave's reference, at `z = exp(j angle_rad)`.
    pub(super) fn force_per_reference(&self, angle_rad: f64) -> Complex64 {
        let delay = Complex64::from_polar(1.0, -(self.round_trip_ticks() as f64) * angle_rad);
        self.responses[1].at(Complex64::from_polar(1.0, angle_rad)) * delay
    }

    /// The one-tick matrix, the inputs of the desired position at this tick and the next, and the slave's first state.
    ///
    /// States: the master's side (`x_h, v_h, x_a, v_a` and the force integral first), the slave's side (`x_e, v_e`
    /// first), the delay lines to slave and master (latest sample first), and the last sample of each signal that
    /// arrives within a tick.
    #[allow(clippy::type_complexity, reason = "three parts that are always destructured at once")]
    pub fn matrix(&self) -> Result<(DMatrix<f64>, [DVector<f64>; 2], usize), StabilityError> {
        let (open, input, arrives) = self.open()?;
        let matrix = open + &input * arrives.transpose();
        let of_master = self.master.a.nrows();
        let whole = |part: &DVector<f64>| {
            let mut all = DVector::zeros(matrix.nrows());
            all.rows_mut(0, of_master).copy_from(part);
            all
        };
        let desired = match &self.master.desired {
            Some((now, next)) => [whole(now), whole(next)],
            None => [whole(&DVector::zeros(of_master)), whole(&DVector::zeros(of_master))],
        };
        Ok((matrix, desired, of_master))
    }

    /// Opens the loop where the slave's signal arrives at the master.
    #[allow(clippy::type_complexity, reason = "three parts that are always destructured at once")]
    pub(super) fn open(&self) -> Result<(DMatrix<f64>, DVector<f64>, DVector<f64>), StabilityError> {
        let states = self.states();
        if states > MAX_STATES {
            return Err(StabilityError::TooLarge { ticks: self.round_trip_ticks(), states, max: MAX_STATES });
        }
        let (n, of_master, of_slave) = (states as usize, self.master.a.nrows(), self.slave.a.nrows());
        let (forward, backward) = (self.forward as usize, self.backward as usize);
        let lines_at = of_master + of_slave;
        let mut held = lines_at + forward + backward;
        let mut matrix = DMatrix::zeros(n, n);
        matrix.view_mut((0, 0), (of_master, of_master)).copy_from(&self.master.a);
        matrix.view_mut((of_master, of_master), (of_slave, of_slave)).copy_from(&self.slave.a);
        let (mut input, mut output) = (DVector::zeros(n), DVector::zeros(n));
        let ways = [
            (&self.master, 0, (lines_at, forward), &self.slave, of_master),
            (&self.slave, of_master, (lines_at + forward, backward), &self.master, 0),
        ];
        for (from, from_at, (line, ticks), to, to_at) in ways {
            let arrives = arriving(n, (from, from_at), (line, ticks));
            if ticks > 0 {
                matrix.row_mut(line).copy_from(&arriving(n, (from, from_at), (line, 0)).transpose());
            }
            for tick in 1..ticks {
                matrix[(line + tick, line + tick - 1)] = 1.0;
            }
            let mut effect = DVector::zeros(n);
            effect.rows_mut(to_at, to.now.len()).copy_from(&to.now);
            if let Some(before) = &to.before {
                let mut column = matrix.view_mut((to_at, held), (before.len(), 1));
                column += before;
                effect[held] = 1.0;
                held += 1;
            }
            if to_at == 0 {
                (input, output) = (effect, arrives);
            } else {
                matrix += effect * arrives.transpose();
            }
        }
        Ok((matrix, input, output))
    }

    pub(super) fn arrives_at_slave(&self) -> DVector<f64> {
        let line = self.master.a.nrows() + self.slave.a.nrows();
        arriving(self.states() as usize, (&self.master, 0), (line, self.forward as usize))
    }

    pub fn is_stable(&self) -> Result<bool, StabilityError> {
        Ok(self.poles_outside(1.0)? == 0)
    }
}

fn arriving(n: usize, (from, from_at): (&Side, usize), (line, ticks): (usize, usize)) -> DVector<f64> {
    let mut arrives = DVector::zeros(n);
    match ticks {
        0 => arrives.rows_mut(from_at, from.c.len()).copy_from(&from.c),
        _ => arrives[line + ticks - 1] = 1.0,
    }
    arrives
}
