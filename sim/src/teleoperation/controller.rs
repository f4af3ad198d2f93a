//! The architectures: what each side makes of what the other has sent.
//!
//! All of them are one linear law with other gains, after Lawrence (1993, *Stability and transparency in bilateral
//! teleoperation*), written for sides whose local controllers (eq. 29 and 31) stay as they are. On the master's tick
//!
//! ```text
//! F_ed  = k_f F_e - k_h F_h + k_x (P x_h - x_e) + k_v (P v_h - v_e) - k_b v_e - k_a a_e
//! x_ref = P x_h + g_v v_h + g_a a_h + g_h F_h - g_e f_e
//! ```
//! with `F_e` the measured force scaled to the master, `f_e` unscaled, `P` the position scale; what comes from the other
//! side is as the link delivers it.

use crate::error::{InvalidValue, non_negative, positive, require};

/// Who is sent what.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ControllerKind {
    /// The paper's: position to the slave, measured force to the master.
    PositionForce,
    /// The same with local force feedback: the master's lightens the hand's load, the slave's lets it yield to the tissue.
    LocalForce,
    /// Positions both ways: a spring and a damper between the machines.
    PositionPosition,
    /// Positions and forces both ways, with the gains that make the teleoperator transparent.
    FourChannel,
}

/// The architecture and the gains that it leaves open.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ControllerSettings {
    /// Who is sent what.
    pub kind: ControllerKind,
    /// Spring between the machines, as the slave's side sees it, in N/m, at least 0.
    pub coupling_stiffness_n_per_m: f64,
    /// Damper beside it in N·s/m, at least 0.
    pub coupling_damping_n_s_per_m: f64,
    /// Local force feedback of the master (Lawrence's `C_6`), at least 0: its inertia and damping feel `1 + C_6` times less.
    pub master_force_gain: f64,
    /// Local force feedback of the slave (`C_5`) in commands `U_s` per N, at least 0.
    pub slave_force_gain: f64,
    /// Bandwidth of the accelerations that are sent, in Hz, above 0.
    pub acceleration_bandwidth_hz: f64,
}

impl ControllerSettings {
    /// The paper's, beside gains for the others that are chosen here: a spring somewhat stiffer than the arm, and a force
    /// gain and a bandwidth at which four channels show a tissue of 50 N/m within 5 % at 5 Hz and bear one of 4000 N/m in a
    /// firm grip (`tests/architectures.rs`). At twice the bandwidth they no longer do.
    pub const PAPER: Self = Self {
        kind: ControllerKind::PositionForce,
        coupling_stiffness_n_per_m: 1000.0,
        coupling_damping_n_s_per_m: 10.0,
        master_force_gain: 6.0,
        slave_force_gain: 0.0,
        acceleration_bandwidth_hz: 100.0,
    };

    /// Checks the ranges that the fields state.
    ///
    /// # Errors
    /// [`InvalidValue`] naming the first setting out of range.
    pub fn validate(&self) -> Result<(), InvalidValue> {
        non_negative("controller.coupling_stiffness_n_per_m", self.coupling_stiffness_n_per_m)?;
        non_negative("controller.coupling_damping_n_s_per_m", self.coupling_damping_n_s_per_m)?;
        non_negative("controller.master_force_gain", self.master_force_gain)?;
        non_negative("controller.slave_force_gain", self.slave_force_gain)?;
        positive("controller.acceleration_bandwidth_hz", self.acceleration_bandwidth_hz)?;
        Ok(())
    }
}

/// What the gains depend on besides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Machines {
    /// Mass of the master in kg.
    pub master_mass_kg: f64,
    /// Its damping in N·s/m.
    pub master_damping_n_s_per_m: f64,
    /// `K_p` of the slave.
    pub proportional_gain: f64,
    /// `K_v` of the slave.
    pub velocity_gain: f64,
    /// Command `U_s` that a slow motion of the slave takes per m/s.
    pub slave_drag: f64,
    /// And per m/s².
    pub slave_inertia: f64,
    /// How far the tissue pushes the resting slave off its reference, in m/N.
    pub compliance_m_per_n: f64,
    /// Slave's motion per master's.
    pub position_scale: f64,
    /// Force fed back per force measured.
    pub force_scale: f64,
}

/// `k_f` and the others of the master's law; see the module.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MasterGains {
    /// `k_f`.
    pub force: f64,
    /// `k_h`.
    pub hand: f64,
    /// `k_x` in N/m.
    pub position: f64,
    /// `k_v` in N·s/m.
    pub velocity: f64,
    /// `k_b` in N·s/m.
    pub drag: f64,
    /// `k_a` in kg.
    pub inertia: f64,
}

/// `g_v` and the others of the slave's.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SlaveGains {
    /// `g_v` in s.
    pub velocity: f64,
    /// `g_a` in s².
    pub acceleration: f64,
    /// `g_h` in m/N.
    pub hand_force: f64,
    /// `g_e` in m/N.
    pub own_force: f64,
}

impl ControllerSettings {
    /// The gains around two machines.
    ///
    /// # Errors
    /// [`InvalidValue`] where a law of the slave needs a `K_p` that is 0.
    pub fn gains(&self, machines: &Machines) -> Result<(MasterGains, SlaveGains), InvalidValue> {
        let Machines { position_scale, force_scale, proportional_gain: k_p, .. } = *machines;
        let shapes_reference = matches!(self.kind, ControllerKind::LocalForce | ControllerKind::FourChannel);
        require("slave.proportional_gain", k_p, k_p > 0.0 || !shapes_reference, "above 0 for this controller.kind")?;
        let position_force = MasterGains { force: 1.0, ..MasterGains::default() };
        Ok(match self.kind {
            ControllerKind::PositionForce => (position_force, SlaveGains::default()),
            ControllerKind::LocalForce => (
                MasterGains { force: 1.0 + self.master_force_gain, hand: self.master_force_gain, ..position_force },
                SlaveGains { own_force: self.slave_force_gain / k_p, ..SlaveGains::default() },
            ),
            ControllerKind::PositionPosition => (
                MasterGains {
                    position: force_scale * self.coupling_stiffness_n_per_m,
                    velocity: force_scale * self.coupling_damping_n_s_per_m,
                    ..MasterGains::default()
                },
                SlaveGains::default(),
            ),
            // Lawrence's C_1 = Z_s + C_s, C_2 = 1 + C_6, C_3 = 1 + C_5, C_4 = -(Z_m + C_m); where the tissue pushes the slave
            // by less than it does Lawrence's, so does C_3.
            ControllerKind::FourChannel => (
                MasterGains {
                    force: 1.0 + self.master_force_gain,
                    hand: self.master_force_gain,
                    position: force_scale * self.coupling_stiffness_n_per_m,
                    velocity: force_scale * self.coupling_damping_n_s_per_m,
                    drag: machines.master_damping_n_s_per_m / position_scale,
                    inertia: machines.master_mass_kg / position_scale,
                },
                SlaveGains {
                    velocity: position_scale * (machines.velocity_gain + machines.slave_drag) / k_p,
                    acceleration: position_scale * machines.slave_inertia / k_p,
                    hand_force: (self.slave_force_gain / k_p + machines.compliance_m_per_n) / force_scale,
                    own_force: self.slave_force_gain / k_p,
                },
            ),
        })
    }
}
