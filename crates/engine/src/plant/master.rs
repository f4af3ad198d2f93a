use std::f64::consts::{FRAC_1_SQRT_2, SQRT_2};

use super::{ControlTiming, MASTER_STATES, MasterModel, MotorStep, PlantError, on};
use trocar_lti::{
    Continuous, InputHold, Interconnection, Signal, StateSpace, TransferFunction, append, exact_step, realise,
    realise_with_derivative,
};

trocar_core::choice! {
    /// Action of the hand on the master; as printed there is none, and the loop is unstable.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Coupling at "master.coupling" = Physical {
        /// `m x_h'' + b x_h' = F_h - U_m`
        "physical" => Physical,
        /// Eq. 28 as printed, `X_h = G_m U_m`: unstable, with a pole at +41.961.
        "as-printed" => AsPrinted,
    }
}

trocar_core::settings! {
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct MasterParameters in "master." given (is_fed_positions: bool = false) {
        /// Mass of the master.
        mass_kg: f64 [MASS] for MasterModel::Appendix | MassDamper = 0.245,
        /// Damping of the master.
        damping_n_s_per_m: f64 [NON_NEGATIVE] for MasterModel::Appendix | MassDamper = 4.1,
        /// Integral gain K_i of the force controller, in 1/s.
        force_integral_gain: f64 [NON_NEGATIVE]
            => "12, as in the paper; 0 if positions are fed back to the master"
            if is_fed_positions { 0.0 } else { 12.0 },
        coupling: Coupling for MasterModel::Appendix,
    }
}

trocar_core::settings! {
    /// A mass `m_h` tied to the desired position by (`k_h`, `b_h`) and to the master by (`k_a`, `b_a`), which gives eq.
    /// 32:
    ///
    /// ```text
    /// m_h x_a'' = k_h (x_d - x_a) + b_h (x_d' - x_a') - F_h
    /// F_h       = k_a (x_a - x_h) + b_a (x_a' - x_h')
    /// ```
    /// Stiffness and damping rise with the grip force (Hasser and Cutkosky 2002), by factors chosen here that keep the
    /// damping ratios.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct ArmParameters in "arm." given (grip: Grip = Grip::Paper, roles: ArmRoles = ArmRoles::AsPrinted) {
        /// Stiffness between arm and master.
        k_a_n_per_m: f64 [NON_NEGATIVE] => "from grip and roles; 733 as printed"
            grip.stiffness_factor() * roles.at_master(733.0, 14998.0),
        /// Damping between arm and master.
        b_a_n_s_per_m: f64 [NON_NEGATIVE] => "from grip and roles; 37.3 as printed"
            grip.damping_factor() * roles.at_master(37.3, 178.0),
        /// Stiffness between desired position and arm.
        k_h_n_per_m: f64 [NON_NEGATIVE] => "from grip and roles; 14998 as printed"
            grip.stiffness_factor() * roles.at_master(14998.0, 733.0),
        /// Damping between desired position and arm.
        b_h_n_s_per_m: f64 [NON_NEGATIVE] => "from grip and roles; 178 as printed"
            grip.damping_factor() * roles.at_master(178.0, 37.3),
        /// Mass of the arm.
        m_h_kg: f64 [MASS] => "from the grip; 1.88 for the paper's" 1.88,
    }
}

trocar_core::choice! {
    /// Grip of the hand: as identified in the paper, half as stiff, or twice as stiff.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Grip at "arm.grip" = Paper {
        "paper" => Paper,
        "relaxed" => Relaxed,
        "firm" => Firm,
    }
}

trocar_core::choice! {
    /// Choose which of the arm's two springs is at the master.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum ArmRoles at "arm.roles" = AsPrinted {
        "as-printed" => AsPrinted,
        "de-vlugt" => DeVlugt,
    }
}

impl ArmRoles {
    const fn at_master(self, printed: f64, of_de_vlugt: f64) -> f64 {
        match self {
            Self::AsPrinted => printed,
            Self::DeVlugt => of_de_vlugt,
        }
    }
}

impl Grip {
    const fn stiffness_factor(self) -> f64 {
        match self {
            Self::Paper => 1.0,
            Self::Relaxed => 0.5,
            Self::Firm => 2.0,
        }
    }

    const fn damping_factor(self) -> f64 {
        match self {
            Self::Paper => 1.0,
            Self::Relaxed => FRAC_1_SQRT_2,
            Self::Firm => SQRT_2,
        }
    }
}

impl ArmParameters {
    /// `k_a k_h / (k_a + k_h)`
    pub fn static_stiffness_n_per_m(&self) -> f64 {
        self.k_a_n_per_m * self.k_h_n_per_m / (self.k_a_n_per_m + self.k_h_n_per_m)
    }
}

/// From `x_d, x_d', F_ed` to `F_h, F_ed - F_h`, with states `x_h, v_h, x_a, v_a, ∫(F_ed - F_h)`; with sampled control
/// `U_m` replaces `F_ed`, without an integral.
pub fn master_system(
    master: &MasterParameters,
    arm: &ArmParameters,
    timing: ControlTiming,
) -> Result<StateSpace<Continuous>, PlantError> {
    master.validate()?;
    arm.validate()?;
    build(master, arm, timing).map_err(on("master"))
}

fn build(
    master: &MasterParameters,
    arm: &ArmParameters,
    timing: ControlTiming,
) -> Result<StateSpace<Continuous>, trocar_lti::Error> {
    use Signal::{External, Output};
    let (x_h, v_h, x_a, v_a, integral) = (Output(0), Output(1), Output(2), Output(3), Output(4));
    let (x_d, v_d, force) = (External(0), External(1), External(2));
    let ArmParameters { k_a_n_per_m: k_a, b_a_n_s_per_m: b_a, k_h_n_per_m: k_h, b_h_n_s_per_m: b_h, m_h_kg } = *arm;
    let hand_force = |sign: f64| [(sign * k_a, x_a), (-sign * k_a, x_h), (sign * b_a, v_a), (-sign * b_a, v_h)];

    let g_m =
        realise_with_derivative(&TransferFunction::new(&[1.0], &[master.mass_kg, master.damping_n_s_per_m, 0.0])?)?;
    let hand_mass = realise_with_derivative(&TransferFunction::new(&[1.0], &[m_h_kg, 0.0, 0.0])?)?;
    let integrator = realise(&TransferFunction::new(&[1.0], &[1.0, 0.0])?)?;
    let blocks = match timing {
        ControlTiming::Continuous => append(&[&g_m, &hand_mass, &integrator])?,
        ControlTiming::Sampled => append(&[&g_m, &hand_mass])?,
    };

    let mut wiring = Interconnection::new(&blocks, 3);
    let motor = match master.coupling {
        Coupling::Physical => {
            wiring = wiring.feed(0, &hand_force(1.0))?;
            -1.0
        }
        Coupling::AsPrinted => 1.0,
    };
    wiring = wiring.feed(0, &[(motor, force)])?;
    wiring = wiring.feed(1, &[(k_h, x_d), (-k_h, x_a), (b_h, v_d), (-b_h, v_a)])?.feed(1, &hand_force(-1.0))?;
    if timing == ControlTiming::Continuous {
        wiring = wiring.feed(0, &[(motor * master.force_integral_gain, integral)])?;
        wiring = wiring.feed(2, &[(1.0, force)])?.feed(2, &hand_force(-1.0))?;
    }
    let error: Vec<_> = hand_force(-1.0).into_iter().chain([(1.0, force)]).collect();
    wiring.read(&hand_force(1.0))?.read(&error)?.close(&blocks)
}

/// `x_{k+1} = transition · x_k + desired_now · x_d(k) + desired_next · x_d(k+1) + feedback · F_ed(k)`.
#[derive(Debug, Clone, PartialEq)]
pub struct MasterStep {
    pub transition: [[f64; MASTER_STATES]; MASTER_STATES],
    pub desired_now: [f64; MASTER_STATES],
    pub desired_next: [f64; MASTER_STATES],
    pub feedback: [f64; MASTER_STATES],
    pub hand_force: [f64; MASTER_STATES],
}

impl MasterStep {
    pub fn new(
        master: &MasterParameters,
        arm: &ArmParameters,
        timing: ControlTiming,
        tick_s: f64,
    ) -> Result<Self, PlantError> {
        let mut step = Self::open(master, arm, timing, tick_s)?;
        if timing == ControlTiming::Sampled {
            step.close_sampled_loop(master.force_integral_gain, tick_s);
        }
        Ok(step)
    }

    /// `feedback` is the effect of a held `U_m`; the force integral does not change.
    pub fn of_machine(master: &MasterParameters, arm: &ArmParameters, tick_s: f64) -> Result<Self, PlantError> {
        Self::open(master, arm, ControlTiming::Sampled, tick_s)
    }

    /// Without a lag, [`MasterStep::of_machine`]'s `feedback`.
    pub fn of_motor(
        master: &MasterParameters,
        arm: &ArmParameters,
        tick_s: f64,
        lag_s: f64,
    ) -> Result<MotorStep<MASTER_STATES>, PlantError> {
        const MOTOR_FORCE: usize = 2;
        let system = master_system(master, arm, ControlTiming::Sampled)?;
        MotorStep::new(("master", &system), MOTOR_FORCE, tick_s, lag_s)
    }

    fn open(
        master: &MasterParameters,
        arm: &ArmParameters,
        timing: ControlTiming,
        tick_s: f64,
    ) -> Result<Self, PlantError> {
        let system = master_system(master, arm, timing)?;
        let step = exact_step(&system, tick_s, &[InputHold::Linear, InputHold::Held, InputHold::Held])
            .map_err(on("master"))?;
        let states = system.states();
        let column = |matrix: &nalgebra::DMatrix<f64>, j: usize| {
            std::array::from_fn(|i| if i < states { matrix[(i, j)] } else { 0.0 })
        };
        let slope: [f64; MASTER_STATES] = column(&step.gamma_now, 1);
        let now: [f64; MASTER_STATES] = column(&step.gamma_now, 0);
        let next: [f64; MASTER_STATES] = column(&step.gamma_next, 0);
        Ok(Self {
            transition: std::array::from_fn(|i| {
                std::array::from_fn(|j| if i < states && j < states { step.phi[(i, j)] } else { 0.0 })
            }),
            desired_now: std::array::from_fn(|i| now[i] - slope[i] / tick_s),
            desired_next: std::array::from_fn(|i| next[i] + slope[i] / tick_s),
            feedback: column(&step.gamma_now, 2),
            hand_force: std::array::from_fn(|j| if j < states { system.c()[(0, j)] } else { 0.0 }),
        })
    }

    /// `U_m = F_ed + K_i I` (held), `I += T (F_ed - F_h)`
    fn close_sampled_loop(&mut self, integral_gain: f64, tick_s: f64) {
        const INTEGRAL: usize = MASTER_STATES - 1;
        for i in 0..INTEGRAL {
            self.transition[i][INTEGRAL] = self.feedback[i] * integral_gain;
        }
        for j in 0..INTEGRAL {
            self.transition[INTEGRAL][j] = -tick_s * self.hand_force[j];
        }
        self.transition[INTEGRAL][INTEGRAL] = 1.0;
        self.feedback[INTEGRAL] = tick_s;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_still_master_feels_the_static_stiffness() {
        assert!((ArmParameters::default().static_stiffness_n_per_m() - 698.845).abs() < 5e-4);
    }

    fn poles(coupling: Coupling) -> Vec<(f64, f64)> {
        let master = MasterParameters { coupling, ..MasterParameters::default() };
        let system = master_system(&master, &ArmParameters::default(), ControlTiming::Continuous).expect("valid");
        let mut poles: Vec<(f64, f64)> = system.poles().expect("found").iter().map(|p| (p.re, p.im)).collect();
        poles.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.total_cmp(&b.1)));
        poles
    }

    #[test]
    fn the_physical_side_has_the_five_independently_computed_poles() {
        let expected = [
            (-12.62462369, 0.0),
            (-21.02629518, 0.0),
            (-43.71857234, -68.79047016),
            (-43.71857234, 68.79047016),
            (-162.41280488, 0.0),
        ];
        for ((re, im), (expected_re, expected_im)) in poles(Coupling::Physical).into_iter().zip(expected) {
            assert!((re - expected_re).abs() < 1e-6 && (im - expected_im).abs() < 1e-6, "{re} {im}");
        }
    }

    #[test]
    fn the_side_as_printed_is_unstable() {
        let poles = poles(Coupling::AsPrinted);
        assert!((poles[0].0 - 41.961).abs() < 5e-4, "{poles:?}");
        assert!(poles[1].0 < 0.0, "{poles:?}");
    }

    #[test]
    fn a_firm_grip_doubles_the_stiffness_at_the_same_damping_ratio_and_roles_exchange_the_springs() {
        use std::f64::consts::SQRT_2;
        assert_eq!(Grip::Firm.stiffness_factor() / Grip::Paper.stiffness_factor(), 2.0);
        assert_eq!(Grip::Relaxed.stiffness_factor() / Grip::Paper.stiffness_factor(), 0.5);
        for grip in [Grip::Paper, Grip::Relaxed, Grip::Firm] {
            assert!((grip.damping_factor().powi(2) - grip.stiffness_factor()).abs() < 1e-15, "{grip:?}");
        }
        assert_eq!(Grip::Firm.damping_factor(), SQRT_2);
        assert_eq!((ArmRoles::AsPrinted.at_master(1.0, 2.0), ArmRoles::DeVlugt.at_master(1.0, 2.0)), (1.0, 2.0));
    }
}
