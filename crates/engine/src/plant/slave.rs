use super::{ControlTiming, Machine, MotorStep, PlantError, SLAVE_STATES, SlaveController, SlaveModel, on};
use trocar_core::error::{finite, require};
use trocar_core::settings::{ActsFor, Range};
use trocar_lti::{
    Continuous, InputHold, Interconnection, Signal, StateSpace, TransferFunction, exact_step, realise_with_derivative,
};

trocar_core::choice! {
    /// Signal that K_v acts on: the velocity, or as printed the position.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Damping at "slave.damping" = Velocity {
        /// `U_s = K_p (x_ref - x_e) - K_v x_e'`
        "velocity" => Velocity,
        /// Eq. 31 as printed: barely damped, with static gain 1300/1315.
        "as-printed" => AsPrinted,
    }
}

/// The engine stops a run beyond it.
const START: Range = Range::stated(-1.0, 1.0, "from -1 to 1 m");

const ACTS_WITH_FORCE: ActsFor = ActsFor::all_but(SlaveModel::KEY.path, SlaveModel::WORDS, "appendix");

trocar_core::settings! {
    #[derive(Debug, Clone, PartialEq)]
    pub struct SlaveParameters in "slave." no const {
        model: SlaveModel,
        /// Numerator of X_e / U_s, highest power first; of a transfer function, from N to m.
        numerator: Vec<f64> for SlaveModel::Appendix | TransferFunction = [7.778, 656.0],
        /// Denominator of X_e / U_s, highest power first; degree 2 or 3, of a transfer function 2 to 8.
        denominator: Vec<f64> for SlaveModel::Appendix | TransferFunction = [1.0, 104.1, 1.131e-4, 0.0],
        /// Moving mass; the default is that of the appendix' slave in slow motion.
        mass_kg: f64 [POSITIVE] for SlaveModel::MassDamper = 0.159,
        /// Viscous friction of the mass.
        damping_n_s_per_m: f64 [NON_NEGATIVE] for SlaveModel::MassDamper = 0.0,
        /// Coulomb friction of the mass, which holds it at rest up to this force; 0: none.
        coulomb_friction_n: f64 [NON_NEGATIVE] for SlaveModel::MassDamper = 0.0,
        /// Matrix A of the state-space model, row by row: n x n.
        a: Vec<f64> for SlaveModel::StateSpace = [0.0, 1.0, 0.0, 0.0],
        /// Matrix B of the state-space model, row by row: n x 2, for the motor's force and an external force in N, both in the
        /// direction of insertion.
        b: Vec<f64> for SlaveModel::StateSpace = [0.0, 0.0, 6.3, 6.3],
        /// Row C of the state-space model: n numbers, from the states to the position in m.
        c: Vec<f64> for SlaveModel::StateSpace = [1.0, 0.0],
        /// The tissue's force acts on the machine, held over a tick.
        load: bool for (ACTS_WITH_FORCE) = true,
        /// Constant external force on the machine in the direction of insertion, for example its weight.
        constant_force_n: f64 [ANY] for (ACTS_WITH_FORCE) = 0.0,
        /// Reference of the slave at rest before the run; by default that of the master's start. From another one the
        /// slave moves to the master's reference at once.
        start_m: Option<f64> [self::START],
        controller: SlaveController,
        /// Proportional gain K_p.
        proportional_gain: f64 [NON_NEGATIVE] = 1300.0,
        /// Velocity gain K_v.
        velocity_gain: f64 [NON_NEGATIVE] = 15.0,
        damping: Damping for SlaveController::Appendix,
        /// Derivative gain K_d on the error.
        derivative_gain: f64 [NON_NEGATIVE] for SlaveController::Pid = 0.0,
        /// Integral gain K_i on the error.
        integral_gain: f64 [NON_NEGATIVE] for SlaveController::Pid = 0.0,
        /// Part of the measured tissue force that the controller adds to its command.
        force_feed_forward: f64 [ANY] for SlaveController::Pid = 0.0,
    }
}

impl SlaveParameters {
    pub fn has_coulomb_friction(&self) -> bool {
        self.model == SlaveModel::MassDamper && self.coulomb_friction_n > 0.0
    }

    pub(super) fn constant_external_n(&self) -> f64 {
        if self.model == SlaveModel::Appendix { 0.0 } else { self.constant_force_n }
    }

    pub fn is_general(&self) -> bool {
        self.model != SlaveModel::Appendix || self.controller != SlaveController::Appendix
    }

    fn machine(&self) -> Result<StateSpace<Continuous>, PlantError> {
        self.validate()?;
        let function = TransferFunction::new(&self.numerator, &self.denominator).map_err(on("slave"))?;
        let numerator = function.numerator().degree().unwrap_or(0);
        let denominator = function.denominator().degree().unwrap_or(0);
        if !(2..=SLAVE_STATES).contains(&denominator) || numerator + 2 > denominator {
            return Err(PlantError::SlaveDegree { numerator, denominator });
        }
        realise_with_derivative(&function).map_err(on("slave"))
    }

    /// The first terms of `U_s / X_e` in `s`: `U_s` per m/s and per m/s².
    pub fn slow_motion(&self) -> Result<(f64, f64), PlantError> {
        self.machine()?;
        let low = |coefficients: &[f64], power: usize| coefficients.iter().rev().nth(power).copied().unwrap_or(0.0);
        let n = |power| low(&self.numerator, power);
        let d = |power| low(&self.denominator, power);
        require("slave.numerator", n(0), n(0) != 0.0, "a list whose last number is not 0")?;
        let stiffness = d(0) / n(0);
        let drag = (d(1) - stiffness * n(1)) / n(0);
        let inertia = (d(2) - drag * n(1) - stiffness * n(2)) / n(0);
        finite("slave.numerator", drag)?;
        finite("slave.numerator", inertia)?;
        Ok((drag, inertia))
    }

    /// Gains on `(x_ref, x_e, v_e)`.
    pub fn control(&self) -> [f64; 3] {
        let (k_p, k_v) = (self.proportional_gain, self.velocity_gain);
        match self.damping {
            Damping::Velocity => [k_p, -k_p, -k_v],
            Damping::AsPrinted => [k_p, -k_p - k_v, 0.0],
        }
    }
}

/// From `x_ref`, or `U_s` with sampled control, to the first states `x_e` and `v_e`. A
/// [general](SlaveParameters::is_general) slave is the [`Machine`] alone.
pub fn slave_system(slave: &SlaveParameters, timing: ControlTiming) -> Result<StateSpace<Continuous>, PlantError> {
    if slave.is_general() {
        return Ok(Machine::of(slave)?.system().clone());
    }
    let machine = slave.machine()?;
    if timing == ControlTiming::Sampled {
        return Ok(machine);
    }
    let [reference, position, velocity] = slave.control();
    let close = || {
        Interconnection::new(&machine, 1)
            .feed(0, &[(reference, Signal::External(0)), (position, Signal::Output(0)), (velocity, Signal::Output(1))])?
            .read(&[(1.0, Signal::Output(0))])?
            .read(&[(1.0, Signal::Output(1))])?
            .close(&machine)
    };
    close().map_err(on("slave"))
}

/// `x_{k+1} = transition · x_k + reference · x_ref(k)`, `x_ref` held.
#[derive(Debug, Clone, PartialEq)]
pub struct SlaveStep {
    /// A slave with two states has a third that is always 0.
    pub transition: [[f64; SLAVE_STATES]; SLAVE_STATES],
    pub reference: [f64; SLAVE_STATES],
    pub rest: [f64; SLAVE_STATES],
}

impl SlaveStep {
    pub fn new(slave: &SlaveParameters, timing: ControlTiming, tick_s: f64) -> Result<Self, PlantError> {
        let mut step = Self::open(slave, timing, tick_s)?;
        if timing == ControlTiming::Sampled {
            let [to_reference, to_position, to_velocity] = slave.control();
            let control = [to_position, to_velocity, 0.0];
            for (row, input) in step.transition.iter_mut().zip(&mut step.reference) {
                for (entry, gain) in row.iter_mut().zip(control) {
                    *entry += *input * gain;
                }
                *input *= to_reference;
            }
        }
        Ok(step)
    }

    /// `reference` is the effect of a held `U_s`; `rest` includes the controller.
    pub fn of_machine(slave: &SlaveParameters, tick_s: f64) -> Result<Self, PlantError> {
        Self::open(slave, ControlTiming::Sampled, tick_s)
    }

    /// Without a lag, [`SlaveStep::of_machine`]'s `reference`.
    pub fn of_motor(slave: &SlaveParameters, tick_s: f64, lag_s: f64) -> Result<MotorStep<SLAVE_STATES>, PlantError> {
        let system = slave_system(slave, ControlTiming::Sampled)?;
        MotorStep::new(("slave", &system), 0, tick_s, lag_s)
    }

    fn open(slave: &SlaveParameters, timing: ControlTiming, tick_s: f64) -> Result<Self, PlantError> {
        let system = slave_system(slave, timing)?;
        let step = exact_step(&system, tick_s, &[InputHold::Held]).map_err(on("slave"))?;
        let states = system.states();
        let entry = |i, j| if i < states && j < states { step.phi[(i, j)] } else { 0.0 };
        let continuous = slave_system(slave, ControlTiming::Continuous)?;
        Ok(Self {
            transition: std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j))),
            reference: std::array::from_fn(|i| if i < states { step.gamma_now[(i, 0)] } else { 0.0 }),
            rest: rest(&continuous),
        })
    }
}

/// Without a steady state, only position 1.
fn rest(system: &StateSpace<Continuous>) -> [f64; SLAVE_STATES] {
    let settled = system.a().clone().lu().solve(&(-system.b()));
    let settled = settled.filter(|state| state.iter().all(|value| value.is_finite()));
    std::array::from_fn(|i| match &settled {
        Some(state) => state.get(i).copied().unwrap_or(0.0),
        None => f64::from(u8::from(i == 0)),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slave_without_a_steady_state_starts_at_its_reference() {
        use nalgebra::{DMatrix, dmatrix};
        let system = |a: DMatrix<f64>| {
            let (b, c, d) = (dmatrix![0.0; 0.0; 4.0], dmatrix![1.0, 0.0, 0.0], dmatrix![0.0]);
            StateSpace::new(a, b, c, d, Continuous).expect("sizes agree")
        };
        // x' = v, v' = w, w' = 4 r: a permanent drift.
        assert_eq!(rest(&system(dmatrix![0.0, 1.0, 0.0; 0.0, 0.0, 1.0; 0.0, 0.0, 0.0])), [1.0, 0.0, 0.0]);
        // x' = v, v' = w, w' = 4 r - 2 x: x = 2 r, v = 0, w = 0.
        assert_eq!(rest(&system(dmatrix![0.0, 1.0, 0.0; 0.0, 0.0, 1.0; -2.0, 0.0, 0.0])), [2.0, 0.0, 0.0]);
    }

    #[test]
    fn both_readings_have_the_independently_computed_poles() {
        for (damping, real, pair) in [
            (Damping::Velocity, -109.79934886, (-55.48532557, 68.47096846)),
            (Damping::AsPrinted, -93.44011474, (-5.32994263, 95.93539974)),
        ] {
            let slave = SlaveParameters { damping, ..SlaveParameters::default() };
            let poles = slave_system(&slave, ControlTiming::Continuous).expect("valid").poles().expect("found");
            assert_eq!(poles.len(), 3);
            for pole in poles {
                let (re, im) = if pole.im.abs() < 1e-9 { (real, 0.0) } else { (pair.0, pair.1 * pole.im.signum()) };
                assert!((pole.re - re).abs() < 1e-6 && (pole.im - im).abs() < 1e-6, "{damping:?} {pole}");
            }
        }
    }

    #[test]
    fn the_command_of_a_slow_motion_is_the_first_terms_of_the_inverse_transfer_function() {
        // (2 s² + 6 s + 3) / (2 s + 4) = 3/4 + (6 - 2 · 3/4)/4 s + (2 - 2 (6 - 2 · 3/4)/4)/4 s² + ...
        let slave = |numerator: &[f64], denominator: &[f64]| SlaveParameters {
            numerator: numerator.into(),
            denominator: denominator.into(),
            ..SlaveParameters::default()
        };
        let drag = (6.0 - 1.5) / 4.0;
        let (found, inertia) = slave(&[2.0, 4.0], &[1.0, 2.0, 6.0, 3.0]).slow_motion().expect("valid");
        assert!((found - drag).abs() < 1e-12, "{found}");
        assert!((inertia - (2.0 - 2.0 * drag) / 4.0).abs() < 1e-12, "{inertia}");
        let error = slave(&[1.0, 0.0], &[1.0, 2.0, 6.0, 3.0]).slow_motion().expect_err("no slow motion");
        assert!(error.to_string().contains("slave.numerator"), "{error}");
    }

    #[test]
    fn a_slave_whose_numerator_is_too_fast_is_refused() {
        let degrees = |numerator: usize, denominator: usize| {
            let slave = SlaveParameters {
                numerator: vec![1.0; numerator + 1],
                denominator: vec![1.0; denominator + 1],
                ..SlaveParameters::default()
            };
            slave_system(&slave, ControlTiming::Continuous).is_ok()
        };
        assert_eq!([degrees(0, 2), degrees(0, 3), degrees(1, 3)], [true; 3]);
        assert_eq!([degrees(1, 2), degrees(2, 3), degrees(0, 1), degrees(1, 4)], [false; 4]);
    }
}
