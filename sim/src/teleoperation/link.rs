//! The link at work: one tick of it, from the master to the slave and back.

use super::controller::{ControllerKind, ControllerSettings, Machines, MasterGains, SlaveGains};
use super::passivity::{PassivitySettings, Port, Scheme, SlavePort, Tank, TimeDomain, Waves};
use super::recovery::{Receiver, RecoverySettings};
use crate::channel::Delay;
use crate::error::InvalidValue;
use crate::lane::Lane;

/// What the master sends: its position, velocity, acceleration and hand force, and what passivity has to say.
pub type FromMaster<L> = Delay<L, 5>;
/// What the slave sends: the force scaled to the master, its position, velocity and acceleration, the mode, and what
/// passivity has to say.
pub type FromSlave<L> = Delay<L, 6>;

/// What the master's side knows of itself at a tick.
#[derive(Debug, Clone, Copy)]
pub struct AtMaster<L> {
    /// `x_h` in m.
    pub position_m: L,
    /// `v_h` in m/s.
    pub velocity_m_per_s: L,
    /// `F_h` in N.
    pub hand_force_n: L,
}

/// What the slave's side measures of itself at a tick.
#[derive(Debug, Clone, Copy)]
pub struct AtSlave<L> {
    /// `x_e` in m.
    pub position_m: L,
    /// `v_e` in m/s.
    pub velocity_m_per_s: L,
    /// The measured force in N.
    pub force_n: L,
}

/// Everything that a link is told but its two directions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinkSettings {
    /// The architecture.
    pub controller: ControllerSettings,
    /// What its gains depend on.
    pub machines: Machines,
    /// What happens after an outage.
    pub recovery: RecoverySettings,
    /// What keeps it passive.
    pub passivity: PassivitySettings,
}

impl LinkSettings {
    /// Whether it is the paper's: position and force sent and taken as they are.
    #[must_use]
    pub fn is_baseline(&self) -> bool {
        self.controller.kind == ControllerKind::PositionForce
            && self.passivity.scheme == Scheme::None
            && self.machines.compliance_m_per_n == 0.0
    }
}

/// What a link has seen by the end of a run, in one lane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinkReport {
    /// Outages of either direction.
    pub outages: u64,
    /// Ticks of the longest.
    pub longest_outage_ticks: f64,
    /// The tick at which the slave gave the link up.
    pub given_up_tick: Option<f64>,
    /// `∫ F_ed dx_h` in J: what the master's machine put into the link.
    pub master_port_j: f64,
    /// `∫ f_e dx_e` in J: what the needle put into the tissue, as measured.
    pub slave_port_j: f64,
    /// What passivity dissipated at the master's side in J.
    pub master_dissipated_j: f64,
    /// What it kept from the slave in J.
    pub slave_refused_j: f64,
}

/// A scheme at work.
#[derive(Debug, Clone)]
enum Passivity<L> {
    None,
    TimeDomain(TimeDomain<L>),
    Waves(Waves<L>),
    Tank(Tank<L>),
}

/// Accelerations from velocities: differences, through a first-order low pass.
#[derive(Debug, Clone)]
struct Accelerometer<L> {
    weight: L,
    inverse_tick: L,
    velocity: L,
    acceleration: L,
}

impl<L: Lane> Accelerometer<L> {
    fn new(bandwidth_hz: f64, tick_s: f64) -> Self {
        let weight = 1.0 - libm::exp(-std::f64::consts::TAU * bandwidth_hz * tick_s);
        let (weight, inverse_tick) = (L::splat(weight), L::splat(1.0 / tick_s));
        Self { weight, inverse_tick, velocity: L::zero(), acceleration: L::zero() }
    }

    #[inline(always)]
    fn update(&mut self, velocity: L) -> L {
        let raw = (velocity - self.velocity) * self.inverse_tick;
        self.velocity = velocity;
        self.acceleration = self.acceleration + self.weight * (raw - self.acceleration);
        self.acceleration
    }
}

/// Gains as lanes; see [`MasterGains`] and [`SlaveGains`].
#[derive(Debug, Clone, Copy)]
struct Gains<L> {
    master: [L; 6],
    slave: [L; 4],
}

impl<L: Lane> Gains<L> {
    fn new(master: &MasterGains, slave: &SlaveGains) -> Self {
        let MasterGains { force, hand, position, velocity, drag, inertia } = *master;
        let SlaveGains { velocity: ahead, acceleration, hand_force, own_force } = *slave;
        Self {
            master: [force, hand, position, velocity, drag, inertia].map(L::splat),
            slave: [ahead, acceleration, hand_force, own_force].map(L::splat),
        }
    }
}

/// Both directions of the link, and what each side does with them.
#[derive(Debug, Clone)]
pub struct Link<L: Lane> {
    forward: FromMaster<L>,
    backward: FromSlave<L>,
    /// Whether each side is sent what the paper's is: position and force as they are.
    is_plain: bool,
    kind: ControllerKind,
    force_scale: L,
    position_scale: L,
    energy_scale: L,
    compliance: L,
    gains: Gains<L>,
    master_accelerometer: Accelerometer<L>,
    slave_accelerometer: Accelerometer<L>,
    positions: Receiver<L>,
    forces: Receiver<L>,
    passivity: Passivity<L>,
    master_port: Port<L>,
    slave_port: Port<L>,
    /// Of the last tick at which the master knew of no event: what it was fed, and the force among it.
    unfrozen_force: L,
    calm_force: L,
    /// What passivity on the slave's side had to say, as it has arrived.
    passivity_payload: L,
}

impl<L: Lane> Link<L> {
    /// A link at rest, the master at `start_m` (m), on ticks of `tick_s` (s).
    ///
    /// # Errors
    /// [`InvalidValue`] naming the first setting out of range.
    pub fn new(
        settings: &LinkSettings,
        (forward, backward): (FromMaster<L>, FromSlave<L>),
        tick_s: f64,
        start_m: f64,
    ) -> Result<Self, InvalidValue> {
        let LinkSettings { controller, machines, recovery, passivity } = settings;
        controller.validate()?;
        recovery.validate()?;
        passivity.validate()?;
        let (master_gains, slave_gains) = controller.gains(machines)?;
        let reference = L::splat(machines.position_scale * start_m);
        let (forth_ticks, back_ticks) = (forward.longest_ticks(), backward.longest_ticks());
        let is_immediate = forward.is_immediate() && backward.is_immediate();
        let passivity = match passivity.scheme {
            Scheme::None => Passivity::None,
            Scheme::TimeDomain => Passivity::TimeDomain(TimeDomain::new(passivity, tick_s, reference)),
            // Without delay the two transformations cancel out.
            Scheme::WaveVariables if is_immediate => Passivity::None,
            Scheme::WaveVariables => Passivity::Waves(Waves::new(passivity, tick_s, L::splat(start_m))),
            Scheme::EnergyTank => Passivity::Tank(Tank::new(passivity, tick_s, reference)),
        };
        let accelerometer = || Accelerometer::new(controller.acceleration_bandwidth_hz, tick_s);
        Ok(Self {
            is_plain: controller.kind == ControllerKind::PositionForce
                && matches!(passivity, Passivity::None)
                && machines.compliance_m_per_n == 0.0,
            kind: controller.kind,
            force_scale: L::splat(machines.force_scale),
            position_scale: L::splat(machines.position_scale),
            energy_scale: L::splat(machines.force_scale / machines.position_scale),
            compliance: L::splat(machines.compliance_m_per_n),
            gains: Gains::new(&master_gains, &slave_gains),
            master_accelerometer: accelerometer(),
            slave_accelerometer: accelerometer(),
            positions: Receiver::new(recovery, recovery.speed_m_per_s, tick_s, reference).expecting_within(forth_ticks),
            forces: Receiver::new(&recovery.of_forces(), recovery.force_rate_n_per_s, tick_s, L::zero())
                .expecting_within(back_ticks),
            passivity,
            master_port: Port::at(L::splat(start_m)),
            slave_port: Port::at(reference),
            unfrozen_force: L::zero(),
            calm_force: L::zero(),
            passivity_payload: L::zero(),
            forward,
            backward,
        })
    }

    /// Whether positions and forces arrive at once and as they are.
    #[must_use]
    pub fn is_direct(&self) -> bool {
        self.is_plain && self.forward.is_immediate() && self.backward.is_immediate()
    }

    /// Slave's motion per master's.
    #[inline(always)]
    pub fn position_scale(&self) -> L {
        self.position_scale
    }

    /// Force fed back per force measured.
    #[inline(always)]
    pub fn force_scale(&self) -> L {
        self.force_scale
    }

    /// From the master to the slave: where its controller wants the slave's reference, in m.
    #[inline(always)]
    pub fn to_slave(&mut self, master: &AtMaster<L>, slave: &AtSlave<L>) -> L {
        let AtMaster { position_m, velocity_m_per_s, hand_force_n } = *master;
        let displacement = self.master_port.moved(position_m);
        let word = match &mut self.passivity {
            Passivity::None => L::zero(),
            Passivity::TimeDomain(scheme) => scheme.master_moved(displacement),
            Passivity::Waves(scheme) => scheme.master_moved(displacement),
            Passivity::Tank(scheme) => scheme.master_moved(displacement),
        };
        let acceleration = self.master_accelerometer.update(velocity_m_per_s);
        let arrival = self.forward.exchange([position_m, velocity_m_per_s, acceleration, hand_force_n, word]);
        let [position_m, velocity_m_per_s, acceleration, hand_force_n, word] = arrival.sample;

        let work = self.slave_port.pushed(slave.position_m, slave.force_n);
        let position_m = match &mut self.passivity {
            Passivity::Waves(scheme) => scheme.receive(word, self.force_scale * slave.force_n),
            _ => position_m,
        };
        let [ahead, inertia, hand_force, own_force] = self.gains.slave;
        let target = match self.kind {
            ControllerKind::PositionForce | ControllerKind::PositionPosition => self.position_scale * position_m,
            ControllerKind::LocalForce | ControllerKind::FourChannel => {
                self.position_scale * position_m
                    + (ahead * velocity_m_per_s + inertia * acceleration)
                    + (hand_force * hand_force_n - own_force * slave.force_n)
            }
        };
        let target = self.positions.update(target, arrival.is_fresh, None);
        let port = SlavePort { scaled_force: self.energy_scale * slave.force_n, work_j: self.energy_scale * work };
        match &mut self.passivity {
            Passivity::None | Passivity::Waves(_) => target,
            Passivity::TimeDomain(scheme) => scheme.meter(target, word, &port),
            Passivity::Tank(scheme) => scheme.meter(target, word, &port),
        }
    }

    /// From the slave, in `mode`, to the master: the mode that has arrived there, and the force (N) that its controller
    /// would feed back by itself.
    ///
    /// While the mode says that the slave is frozen, what couples the positions stays as it was, and the force changes with
    /// the tissue's alone: the hand must not feel how far it has moved away from a needle that is held.
    #[inline(always)]
    pub fn to_master(&mut self, mode: L, slave: &AtSlave<L>, master: &AtMaster<L>) -> (L, L) {
        let word = match &mut self.passivity {
            Passivity::None => L::zero(),
            Passivity::TimeDomain(scheme) => scheme.slave_sends(),
            Passivity::Waves(scheme) => scheme.slave_sends(),
            Passivity::Tank(scheme) => scheme.slave_sends(),
        };
        let acceleration = self.slave_accelerometer.update(slave.velocity_m_per_s);
        let force_n = self.force_scale * slave.force_n;
        let sample = [force_n, slave.position_m, slave.velocity_m_per_s, acceleration, mode, word];
        let arrival = self.backward.exchange(sample);
        let [force_n, position_m, velocity_m_per_s, acceleration, mode, word] = arrival.sample;

        let wave_force_n = match &mut self.passivity {
            Passivity::Waves(scheme) => scheme.force(word, master.velocity_m_per_s),
            _ => force_n,
        };
        self.passivity_payload = word;
        let [on_force, on_hand, stiffness, damping, drag, inertia] = self.gains.master;
        let force_n = match self.kind {
            ControllerKind::PositionForce => wave_force_n,
            ControllerKind::LocalForce => on_force * wave_force_n - on_hand * master.hand_force_n,
            ControllerKind::PositionPosition | ControllerKind::FourChannel => {
                let apart = self.position_scale * master.position_m - position_m;
                let drifting = self.position_scale * master.velocity_m_per_s - velocity_m_per_s;
                (on_force * force_n - on_hand * master.hand_force_n) + (stiffness * apart + damping * drifting)
                    - (drag * velocity_m_per_s + inertia * acceleration)
            }
        };
        let total_n = match self.kind {
            ControllerKind::PositionForce => force_n,
            _ => {
                let is_frozen = (mode - L::splat(1.0)).abs().lt(L::splat(0.5));
                let live_n = arrival.sample[0];
                let held_n = self.unfrozen_force + (live_n - self.calm_force);
                self.unfrozen_force = L::select(is_frozen, self.unfrozen_force, force_n);
                self.calm_force = L::select(is_frozen, self.calm_force, live_n);
                L::select(is_frozen, held_n, force_n)
            }
        };
        (mode, self.forces.update(total_n, arrival.is_fresh, Some(L::zero())))
    }

    /// The force to feed back of the one that the law asks for (N).
    #[inline(always)]
    pub fn limit(&mut self, force_n: L, master: &AtMaster<L>) -> L {
        let fed_back = match &mut self.passivity {
            Passivity::None | Passivity::Waves(_) => force_n,
            Passivity::TimeDomain(scheme) => scheme.limit(force_n, self.passivity_payload, master.velocity_m_per_s),
            Passivity::Tank(scheme) => scheme.limit(force_n, self.passivity_payload, master.velocity_m_per_s),
        };
        self.master_port.hold(fed_back);
        fed_back
    }

    /// The reference that the slave's controller works on (m), where the tissue pushes the slave off it with a force (N).
    #[inline(always)]
    pub fn apply_compliance(&self, reference_m: L, tissue_force_n: L) -> L {
        reference_m - self.compliance * tissue_force_n
    }

    /// What the link has seen so far in lane `index`.
    #[must_use]
    pub fn report(&self, index: usize) -> LinkReport {
        let (forth, back) = (self.positions.outages(index), self.forces.outages(index));
        let zero = L::zero();
        let (dissipated, refused) = match &self.passivity {
            Passivity::None | Passivity::Waves(_) => (zero, zero),
            Passivity::TimeDomain(scheme) => (scheme.dissipated_j, scheme.refused_j()),
            Passivity::Tank(scheme) => (scheme.dissipated_j, scheme.refused_j()),
        };
        LinkReport {
            outages: (forth.0 + back.0) as u64,
            longest_outage_ticks: forth.1.max(back.1),
            given_up_tick: forth.2,
            master_port_j: self.master_port.energy_j.lane(index),
            slave_port_j: self.slave_port.energy_j.lane(index),
            master_dissipated_j: dissipated.lane(index),
            slave_refused_j: refused.lane(index),
        }
    }
}

crate::lane::gather!(Link {
    forward, backward, force_scale, position_scale, energy_scale, compliance, gains, master_accelerometer,
    slave_accelerometer, positions, forces, passivity, master_port, slave_port, unfrozen_force, calm_force, passivity_payload,
} same { is_plain, kind });
crate::lane::gather!(Gains { master, slave });
crate::lane::gather!(Accelerometer { weight, inverse_tick, velocity, acceleration });
crate::lane::gather_variants!(Passivity { TimeDomain, Waves, Tank } empty { None });
