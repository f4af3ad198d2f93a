use super::{LinearLoop, StabilityError};
use trocar_engine::plant::{ControlTiming, Coupling, GeneralMaster, Machine, SampledGains, slave_system};
use trocar_engine::teleoperation::{MasterGains, SlaveGains};
use trocar_lti::{Complex64, Continuous, StateSpace};

const ROUNDING: f64 = 1e-12;

/// True if the real part is at least 0, up to rounding.
pub fn is_passive_impedance(immittance: Complex64) -> bool {
    immittance.re >= -ROUNDING * immittance.norm()
}

/// The hybrid matrix at one frequency (Hannaford, *IEEE Trans. Robot. Autom.* 5, 1989):
///
/// ```text
/// | F_h  |   | h11  h12 | | v_h |      h11: impedance at the hand with a free needle, in N·s/m
/// |      | = |          | |     |      h12: force transmission;  h21: minus the motion transmission
/// | -v_e |   | h21  h22 | | f_e |      h22: admittance at the needle, in m/(N·s)
/// ```
/// `v_h` and `F_h` are at the master. Ideally `h11 = h22 = 0`, `h12 = 1`, `h21 = -1` (times the scales).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hybrid {
    pub h: [[Complex64; 2]; 2],
}

impl Hybrid {
    /// `η = -cos ∠(h12 h21) + 2 Re h11 Re h22 / |h12 h21|`, infinite if `h12 h21 = 0`. The two-port is absolutely
    /// stable if `η >= 1` and both real parts are at least 0 at every frequency (Llewellyn, *Proc. IRE* 40, 1952; Adams
    /// and Hannaford, *IEEE Trans. Robot. Autom.* 15, 1999).
    pub fn llewellyn(&self) -> f64 {
        let [[h11, _], [_, h22]] = self.h;
        let loop_gain = self.h[0][1] * self.h[1][0];
        if loop_gain.norm() == 0.0 {
            return f64::INFINITY;
        }
        (2.0 * h11.re * h22.re - loop_gain.re) / loop_gain.norm()
    }

    pub fn is_absolutely_stable(&self) -> bool {
        let [[h11, _], [_, h22]] = self.h;
        is_passive_impedance(h11) && is_passive_impedance(h22) && self.llewellyn() >= 1.0 - ROUNDING
    }

    /// At this frequency: `4 Re h11 Re h22 >= |h12 + h21*|²`. The scales make the powers of both sides comparable
    /// (`F_h v_h` and `s_f/s_p f_e v_e`).
    pub fn is_passive(&self, (force, position): (f64, f64)) -> bool {
        let [[h11, h12], [h21, h22]] = self.h;
        let both = (h12 / force + h21.conj() / position).norm_sqr();
        let size = h12.norm_sqr() / (force * force) + h21.norm_sqr() / (position * position);
        let self_terms = 4.0 * h11.re * h22.re / (force * position);
        is_passive_impedance(h11)
            && is_passive_impedance(h22)
            && self_terms - both >= -ROUNDING * (size + self_terms.abs())
    }

    /// `Z_t = h11 - h12 h21 Z_e / (1 + h22 Z_e)` in N·s/m.
    pub fn transmitted(&self, impedance: Complex64) -> Complex64 {
        let [[h11, h12], [h21, h22]] = self.h;
        h11 - h12 * h21 * impedance / (Complex64::new(1.0, 0.0) + h22 * impedance)
    }

    /// `h11 - h12 h21 / h22`, with a clamped needle; `None` if the slave is rigid.
    pub fn stiffest(&self) -> Option<Complex64> {
        let [[h11, h12], [h21, h22]] = self.h;
        (h22.norm() > 0.0).then(|| h11 - h12 * h21 / h22)
    }
}

/// The teleoperator in continuous time, with a hold `(1 - exp(-sT)) / (sT)` in each signal of the link; valid well
/// below half the sampling rate. `f_e` is the force reading.
#[derive(Debug, Clone)]
pub struct Ports {
    settings: LinearLoop,
    slave: StateSpace<Continuous>,
    /// Without the arm.
    master: Option<StateSpace<Continuous>>,
    at_master: MasterGains,
    at_slave: SlaveGains,
}

pub(super) fn force_reading(settings: &LinearLoop, s: Complex64) -> Complex64 {
    let one = Complex64::new(1.0, 0.0);
    let ticks = std::f64::consts::TAU * settings.force_bandwidth_hz * settings.tick_s;
    if settings.force_bandwidth_hz <= 0.0 {
        return one;
    }
    let before = (-s * settings.tick_s).exp();
    let (keep, mean) = ((-ticks).exp(), -(-ticks).exp_m1() / ticks);
    (before * (mean - keep) + (1.0 - mean)) / (one - before * keep)
}

fn slave_of(settings: &LinearLoop) -> Result<StateSpace<Continuous>, StabilityError> {
    Ok(if settings.has_general_machine() {
        Machine::of(&settings.slave)?.system().clone()
    } else {
        slave_system(&settings.slave, settings.timing)?
    })
}

fn general_master(settings: &LinearLoop) -> Result<Option<StateSpace<Continuous>>, StabilityError> {
    let LinearLoop { master, master_model, arm, .. } = settings;
    let general = GeneralMaster { parameters: master, model: master_model, arm };
    Ok(master_model.is_general().then(|| general.machine()).transpose()?.map(|machine| machine.system().clone()))
}

impl Ports {
    /// Ignores `K` and `B`.
    pub fn new(settings: &LinearLoop) -> Result<Self, StabilityError> {
        let (at_master, at_slave) = settings.link.controller.gains(&settings.link.machines)?;
        Ok(Self {
            slave: slave_of(settings)?,
            master: general_master(settings)?,
            settings: settings.clone(),
            at_master,
            at_slave,
        })
    }

    pub fn scales(&self) -> (f64, f64) {
        (self.settings.link.machines.force_scale, self.settings.link.machines.position_scale)
    }

    /// `B + K / s` in N·s/m.
    pub fn tissue(&self, omega_rad_per_s: f64) -> Complex64 {
        let s = Complex64::new(0.0, omega_rad_per_s);
        Complex64::new(self.settings.damping_n_s_per_m, 0.0) + s.inv() * self.settings.stiffness_n_per_m
    }

    /// `None` at a pole, or if the hand does not act on the master.
    pub fn at(&self, omega_rad_per_s: f64) -> Result<Option<Hybrid>, StabilityError> {
        let Self { settings, at_master, at_slave, .. } = self;
        let s = Complex64::new(0.0, omega_rad_per_s);
        let one = Complex64::new(1.0, 0.0);
        let tick_s = settings.tick_s;
        let before = (-s * tick_s).exp();
        let hold = (one - before) / (s * tick_s);
        let link = |delay_s: f64| (-s * delay_s).exp() * hold;
        let arrival_s = |whole: u64, share: f64| (whole as f64 + share) * tick_s;
        let (forward, backward) = (settings.forward(), settings.backward());
        let to_slave = link(arrival_s(forward.whole, forward.share));
        let to_master = link(arrival_s(backward.whole, backward.share));
        let machines = &settings.link.machines;
        let scale = machines.position_scale;

        let read = force_reading(settings, s);
        let weight =
            -(-std::f64::consts::TAU * settings.link.controller.four_channel.acceleration_bandwidth_hz * tick_s)
                .exp_m1();
        let differentiate = (one - before) * (weight / tick_s) / (one - before * (1.0 - weight));

        // The slave: x_e = follow · x_ref + loaded · f_e, with a held x_ref.
        let response = self.slave.evaluate(s)?;
        let (follow, loaded) = match (settings.has_general_machine(), settings.timing) {
            (true, _) => {
                let gains = SampledGains::of(&settings.slave, tick_s);
                let motor = response[(0, 0)];
                let sum = before / (one - before) * gains.sum;
                let on_error = (one - before) * gains.difference + sum + gains.proportional;
                let loop_gain = motor * hold * (on_error + s * gains.velocity + gains.position);
                let from_force = hold * (motor * read * gains.force - response[(0, 1)]);
                (motor * on_error / (one + loop_gain), from_force / (one + loop_gain))
            }
            (false, ControlTiming::Continuous) => (response[(0, 0)], Complex64::new(0.0, 0.0)),
            (false, ControlTiming::Sampled) => {
                let [to_reference, to_position, to_velocity] = settings.slave.control();
                let motor = response[(0, 0)] / (one + s * settings.actuators.slave_lag_s);
                let loop_gain = motor * hold * (s * to_velocity + to_position);
                (motor * to_reference / (one - loop_gain), Complex64::new(0.0, 0.0))
            }
        };
        // x_e = from_hand F_h + from_motion v_h + from_tissue f_e
        let from_motion =
            follow * to_slave * (s.inv() * scale + at_slave.velocity + differentiate * at_slave.acceleration);
        let from_hand = follow * to_slave * at_slave.hand_force;
        let from_tissue = loaded - follow * hold * (read * at_slave.local_force + machines.compliance_m_per_n);

        // The held F_ed = force f_e + local v_h - hand F_h - of_slave x_e
        let force = to_master * read * (at_master.force * machines.force_scale);
        let local = hold * (s.inv() * at_master.position + at_master.velocity) * scale;
        let hand = hold * at_master.hand;
        let of_slave = to_master
            * (s * (at_master.velocity + at_master.drag) + at_master.position + s * differentiate * at_master.inertia);

        // U_m = (1 + k) F_ed - k F_h, with k = K_i / s or its held sum over the ticks, and m s v + b v = F_h - U_m.
        let gain = settings.master.force_integral_gain;
        let timing = if self.master.is_some() { ControlTiming::Sampled } else { settings.timing };
        let integral = match timing {
            ControlTiming::Continuous => s.inv() * gain,
            ControlTiming::Sampled => before / (one - before) * (gain * tick_s),
        };
        let (of_force, of_hand, motor) = match timing {
            ControlTiming::Continuous => (one + integral, integral, one),
            ControlTiming::Sampled => {
                (one + integral, integral * hold, (one + s * settings.actuators.master_lag_s).inv())
            }
        };
        // A general master moves by x_h = G_e F_h - G_m U_m.
        let (inertia, motor) = match &self.master {
            None => (s * settings.master.mass_kg + settings.master.damping_n_s_per_m, motor),
            Some(master) => {
                let response = master.evaluate(s)?;
                let of_hand = response[(0, 1)];
                ((s * of_hand).inv(), motor * response[(0, 0)] / of_hand)
            }
        };
        // Collected by F_h, v_h and f_e: on_hand F_h + on_motion v_h + on_tissue f_e = 0.
        let pushed = match settings.master.coupling {
            Coupling::Physical => (one, one),
            Coupling::AsPrinted => (Complex64::new(0.0, 0.0), -one),
        };
        let drive = motor * pushed.1;
        let on_hand = pushed.0 + drive * of_hand + drive * of_force * (hand + of_slave * from_hand);
        let on_motion = -inertia - drive * of_force * (local - of_slave * from_motion);
        let on_tissue = -drive * of_force * (force - of_slave * from_tissue);
        let (h11, h12) = (-on_motion / on_hand, -on_tissue / on_hand);
        let h21 = -s * (from_motion + from_hand * h11);
        let h22 = -s * (from_tissue + from_hand * h12);
        let hybrid = Hybrid { h: [[h11, h12], [h21, h22]] };
        let is_finite = hybrid.h.iter().flatten().all(|value| value.re.is_finite() && value.im.is_finite());
        Ok(is_finite.then_some(hybrid))
    }
}
