use nalgebra::{DMatrix, DVector};

use super::{MAX_MACHINE_STATES, Machine, PlantError, SampledGains, SlaveModel, SlaveParameters, SlidingMass, on};
use trocar_core::friction::CoulombFriction;
use trocar_lti::{InputHold, exact_step};

const SOLVED: f64 = 1e-6;

pub type MachineColumn = [f64; MAX_MACHINE_STATES];

/// `x_{k+1} = transition · x_k + command · u_k + external · w_k`, with held motor force `u` and external force `w`. The
/// first states are position and velocity.
#[derive(Debug, Clone, PartialEq)]
pub struct MachineStep {
    pub states: usize,
    pub transition: [MachineColumn; MAX_MACHINE_STATES],
    pub command: MachineColumn,
    pub external: MachineColumn,
    /// Replaces the matrices, which leave out Coulomb friction.
    pub sliding: Option<SlidingMass>,
    pub is_loaded: bool,
    constant_n: f64,
    tick_s: f64,
}

impl MachineStep {
    pub fn new(slave: &SlaveParameters, tick_s: f64) -> Result<Self, PlantError> {
        let machine = Machine::of(slave)?;
        let system = machine.system();
        let step = exact_step(system, tick_s, &[InputHold::Held, InputHold::Held]).map_err(on("slave"))?;
        let states = system.states();
        let column = |matrix: &DMatrix<f64>, j: usize| -> MachineColumn {
            std::array::from_fn(|i| if i < states && j < matrix.ncols() { matrix[(i, j)] } else { 0.0 })
        };
        Ok(Self {
            states,
            transition: std::array::from_fn(|j| column(&step.phi, j)),
            command: column(&step.gamma_now, 0),
            external: column(&step.gamma_now, 1),
            sliding: slave.has_coulomb_friction().then_some(SlidingMass {
                mass_kg: slave.mass_kg,
                damping_n_s_per_m: slave.damping_n_s_per_m,
                friction: CoulombFriction { limit_n: slave.coulomb_friction_n },
            }),
            is_loaded: slave.model != SlaveModel::Appendix && slave.load,
            constant_n: slave.constant_external_n(),
            tick_s,
        })
    }

    pub fn advance(&self, state: &MachineColumn, command: f64, tissue_n: f64) -> MachineColumn {
        let external_n = if self.is_loaded { tissue_n + self.constant_n } else { self.constant_n };
        let mut next = [0.0; MAX_MACHINE_STATES];
        if let Some(mass) = &self.sliding {
            [next[0], next[1]] = mass.advance([state[0], state[1]], command + external_n, self.tick_s);
            return next;
        }
        for (column, value) in self.transition[..self.states].iter().zip(state) {
            for (sum, entry) in next.iter_mut().zip(column) {
                *sum += entry * value;
            }
        }
        for ((sum, of_command), of_external) in next.iter_mut().zip(&self.command).zip(&self.external) {
            *sum += of_command * command + of_external * external_n;
        }
        next
    }
}

#[derive(Debug, Clone, PartialEq)]
pub struct Rest {
    pub state: MachineColumn,
    pub command: f64,
}

impl Rest {
    /// At the reference with an integral, else where the controller balances the machine.
    pub fn of(slave: &SlaveParameters, reference_m: f64) -> Result<Self, PlantError> {
        let machine = Machine::of(slave)?;
        let (a, b) = (machine.system().a(), machine.system().b().column(0));
        let n = a.nrows();
        let gains = SampledGains::of(slave, 1.0);
        let mut matrix = DMatrix::zeros(n + 1, n + 1);
        matrix.view_mut((0, 0), (n, n)).copy_from(a);
        matrix.view_mut((0, n), (n, 1)).copy_from(&b);
        let mut right = DVector::zeros(n + 1);
        right.rows_mut(0, n).copy_from(&(machine.system().b().column(1) * -slave.constant_external_n()));
        if gains.sum != 0.0 || gains.proportional + gains.position == 0.0 {
            (matrix[(n, 0)], right[n]) = (1.0, reference_m);
        } else {
            (matrix[(n, 0)], matrix[(n, n)]) = (gains.proportional + gains.position, 1.0);
            right[n] = gains.proportional * reference_m;
        }
        let no_rest = || PlantError::NoRest { side: "slave", start_m: reference_m };
        let mut solution = solve(matrix, &right).ok_or_else(no_rest)?;
        // Rounding would release a mass that friction holds.
        solution[1] = 0.0;
        let state = std::array::from_fn(|i| if i < n { solution[i] } else { 0.0 });
        Ok(Self { state, command: solution[n] })
    }
}

/// The solution of least norm if singular.
pub(super) fn solve(matrix: DMatrix<f64>, right: &DVector<f64>) -> Option<DVector<f64>> {
    let (mut scaled, mut right) = (matrix, right.clone());
    let size = |largest: f64| if largest > 0.0 { largest } else { 1.0 };
    for i in 0..scaled.nrows() {
        let size = size(scaled.row(i).amax());
        scaled.row_mut(i).unscale_mut(size);
        right[i] /= size;
    }
    let columns: Vec<f64> = (0..scaled.ncols()).map(|j| size(scaled.column(j).amax())).collect();
    for (j, size) in columns.iter().enumerate() {
        scaled.column_mut(j).unscale_mut(*size);
    }
    let is_solution = |found: &DVector<f64>| (&scaled * found - &right).amax() <= SOLVED * right.amax();
    let direct = scaled.clone().full_piv_lu().solve(&right).filter(is_solution);
    let mut found = direct.or_else(|| scaled.clone().svd(true, true).solve(&right, 1e-13).ok().filter(is_solution))?;
    for (value, size) in found.iter_mut().zip(&columns) {
        *value /= size;
    }
    found.iter().all(|value| value.is_finite()).then_some(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plant::SlaveController;

    fn mass_damper() -> SlaveParameters {
        SlaveParameters { model: SlaveModel::MassDamper, mass_kg: 0.4, damping_n_s_per_m: 3.0, ..Default::default() }
    }

    #[test]
    fn a_mass_damper_follows_its_closed_form_as_matrix_and_as_sliding_mass() {
        let step = MachineStep::new(&mass_damper(), 1e-3).expect("valid");
        let sliding = SlidingMass { mass_kg: 0.4, damping_n_s_per_m: 3.0, friction: CoulombFriction { limit_n: 0.0 } };
        let mut state = [0.0; MAX_MACHINE_STATES];
        let mut motion = [0.0, 0.0];
        for tick in 0..1000 {
            let force_n = (0.02 * f64::from(tick)).sin();
            state = step.advance(&state, force_n, -0.3);
            motion = sliding.advance(motion, force_n - 0.3, 1e-3);
        }
        assert!((state[0] - motion[0]).abs() < 1e-12 && (state[1] - motion[1]).abs() < 1e-11, "{state:?} {motion:?}");
    }

    #[test]
    fn a_machine_at_rest_stays_there() {
        let spring = SlaveParameters {
            model: SlaveModel::TransferFunction,
            numerator: vec![1.0],
            denominator: vec![0.4, 3.0, 200.0],
            ..Default::default()
        };
        let pid = SlaveParameters { controller: SlaveController::Pid, integral_gain: 5.0, ..spring.clone() };
        for (slave, expected) in [(&mass_damper(), 0.02), (&spring, 0.02 * 1300.0 / 1500.0), (&pid, 0.02)] {
            let rest = Rest::of(slave, 0.02).expect("rests");
            assert!((rest.state[0] - expected).abs() < 1e-12, "{rest:?}");
            let step = MachineStep::new(slave, 1e-3).expect("valid");
            let after = step.advance(&rest.state, rest.command, 0.0);
            for (next, now) in after.iter().zip(&rest.state) {
                assert!((next - now).abs() < 1e-10 * (1.0 + now.abs()), "{rest:?} {after:?}");
            }
        }
        let free = SlaveParameters { proportional_gain: 0.0, ..spring };
        assert_eq!(Rest::of(&free, 0.0).expect("rests").state[0], 0.0);
        let held = Rest::of(&free, 0.02).expect("a motor can hold the spring");
        assert!((held.command - 4.0).abs() < 1e-9, "{held:?}");
    }

    #[test]
    fn machines_that_cannot_be_simulated_are_refused_with_their_key() {
        let functions = |numerator: &[f64], denominator: &[f64]| SlaveParameters {
            model: SlaveModel::TransferFunction,
            numerator: numerator.into(),
            denominator: denominator.into(),
            ..Default::default()
        };
        let matrices = |a: &[f64], b: &[f64], c: &[f64]| SlaveParameters {
            model: SlaveModel::StateSpace,
            a: a.into(),
            b: b.into(),
            c: c.into(),
            ..Default::default()
        };
        let mass = [0.0, 1.0, 0.0, -2.0];
        for (slave, expected) in [
            (functions(&[1.0], &[1.0, -2.0, 0.0]), "unstable"),
            (functions(&[1.0, 0.0], &[1.0, 2.0, 0.0]), "2 above"),
            (functions(&[1.0, 0.0, 0.0], &[1.0, 2.0]), "2 above"),
            (functions(&[1.0], &[1.0; 10]), "at most 8"),
            (functions(&[0.0], &[1.0, 1.0, 1.0]), "slave.numerator"),
            (functions(&[1.0], &[0.0, 1.0, 1.0]), "denominator"),
            (functions(&[f64::NAN], &[1.0, 1.0, 1.0]), "slave.numerator"),
            (matrices(&[], &[], &[]), "slave.c"),
            (matrices(&mass[..3], &[0.0, 0.0, 1.0, 1.0], &[1.0, 0.0]), "slave.a has 3 numbers"),
            (matrices(&mass, &[0.0, 1.0], &[1.0, 0.0]), "slave.b has 2 numbers"),
            (matrices(&mass, &[0.0, 0.0, 1.0, 1.0], &[0.0, 1.0]), "at once"),
            (matrices(&[0.0, 1.0, 0.0, 2.0], &[0.0, 0.0, 1.0, 1.0], &[1.0, 0.0]), "unstable"),
            (matrices(&[-1.0, 0.0, 0.0, -2.0], &[0.0, 0.0, 1.0, 1.0], &[1.0, 0.0]), "slave"),
            (matrices(&[0.0, f64::INFINITY, 0.0, -2.0], &[0.0, 0.0, 1.0, 1.0], &[1.0, 0.0]), "slave.a"),
        ] {
            let message = MachineStep::new(&slave, 1e-3).expect_err("refused").to_string();
            assert!(message.contains(expected), "{message}");
        }
    }
}
