//! The full link: one tick, from the master to the slave and back.

use super::architecture::{Architecture, ArrivedAtMaster, MasterSample, SlaveSample};
use super::connection::{AtMaster, AtSlave, Connection, LinkReport};
use super::direct::DirectLink;
use super::passivity::{Arrived, PAYLOAD, PassivityScheme, Port, SchemeContext, SlaveMotion, SlavePort};
use super::recovery::{Receiver, RecoverySettings};
use super::{AnyArchitecture, AnyScheme, ControllerKind, LinkSettings};
use crate::channel::Delay;
use crate::error::InvalidValue;
use crate::lane::Lane;
use crate::plant::SlaveStep;

/// What the master sends: its position, velocity, acceleration and hand force.
pub type FromMaster<L> = Delay<L, 4>;
/// What the slave sends: the force scaled to the master, its position, velocity and acceleration, and the mode.
pub type FromSlave<L> = Delay<L, 5>;
/// What a passivity scheme adds to the samples of a direction.
pub type PayloadLine<L> = Delay<L, PAYLOAD>;

/// The lines of both directions. A payload arrives with its sample, so both lines of a direction have the same delays and
/// losses; a link without a scheme leaves those of the payloads alone.
#[derive(Debug, Clone)]
pub struct Lines<L: Lane> {
    /// From the master to the slave.
    pub forward: FromMaster<L>,
    /// From the slave to the master.
    pub backward: FromSlave<L>,
    /// The scheme's payloads from the master.
    pub forward_payload: PayloadLine<L>,
    /// The scheme's payloads from the slave.
    pub backward_payload: PayloadLine<L>,
}

/// Both directions of the link, the architecture, the passivity scheme and a receiver on each side. The type parameters
/// default to the built-in parts.
#[derive(Debug, Clone)]
pub struct Link<L: Lane, A = AnyArchitecture<L>, P = AnyScheme<L>> {
    lines: Lines<L>,
    architecture: A,
    scheme: P,
    /// Whether position and force are transmitted unchanged, as in the paper.
    is_plain: bool,
    scales: DirectLink<L>,
    energy_scale: L,
    compliance: L,
    positions: Receiver<L>,
    forces: Receiver<L>,
    master_port: Port<L>,
    slave_port: Port<L>,
    /// The largest excess of what the ports have delivered over what they have received, in J.
    generated_j: L,
}

impl<L: Lane> Link<L> {
    /// A link at rest, the master at `start_m` (m), for a slave with this step over a tick of `tick_s` (s).
    ///
    /// # Errors
    /// [`InvalidValue`] naming the first setting out of range.
    pub fn new(
        settings: &LinkSettings,
        lines: Lines<L>,
        slave: &SlaveStep,
        tick_s: f64,
        start_m: f64,
    ) -> Result<Self, InvalidValue> {
        let LinkSettings { controller, machines, recovery, passivity } = settings;
        controller.validate()?;
        recovery.validate()?;
        passivity.validate()?;
        let architecture = AnyArchitecture::new(controller, machines, tick_s)?;
        let reference_m = L::splat(machines.position_scale * start_m);
        let is_immediate = lines.forward.is_immediate() && lines.backward.is_immediate();
        let energy_scale = L::splat(machines.energy_scale());
        let context = SchemeContext {
            tick_s,
            start_m: L::splat(start_m),
            reference_m,
            is_immediate,
            position_scale: machines.position_scale,
            energy_scale,
            master_mass_kg: machines.master_mass_kg,
            motion: SlaveMotion::new(slave, tick_s),
        };
        let scheme = AnyScheme::new(passivity, &context);
        let receiver = |settings: &RecoverySettings, speed, start| Receiver::new(settings, speed, tick_s, start);
        Ok(Self {
            is_plain: controller.kind == ControllerKind::PositionForce
                && matches!(scheme, AnyScheme::None(_))
                && machines.compliance_m_per_n == 0.0,
            architecture,
            scheme,
            scales: DirectLink::new(machines.position_scale, machines.force_scale),
            energy_scale,
            compliance: L::splat(machines.compliance_m_per_n),
            positions: receiver(recovery, recovery.speed_m_per_s, reference_m)
                .expecting_within(lines.forward.longest_ticks()),
            forces: receiver(&recovery.of_forces(), recovery.force_rate_n_per_s, L::zero())
                .expecting_within(lines.backward.longest_ticks()),
            master_port: Port::at(L::splat(start_m)),
            slave_port: Port::at(reference_m),
            generated_j: L::zero(),
            lines,
        })
    }
}

impl<L: Lane, A, P> Link<L, A, P> {
    /// This link, at rest, with another architecture.
    #[must_use]
    pub fn with_architecture<B: Architecture<L>>(self, architecture: B) -> Link<L, B, P> {
        self.with(|_, scheme| (architecture, scheme))
    }

    /// This link, at rest, with another passivity scheme.
    #[must_use]
    pub fn with_scheme<Q: PassivityScheme<L>>(self, scheme: Q) -> Link<L, A, Q> {
        self.with(|architecture, _| (architecture, scheme))
    }

    fn with<B, Q>(self, exchange: impl FnOnce(A, P) -> (B, Q)) -> Link<L, B, Q> {
        let Self { lines, scales, energy_scale, compliance, .. } = self;
        let Self { positions, forces, master_port, slave_port, generated_j, .. } = self;
        let (architecture, scheme) = exchange(self.architecture, self.scheme);
        Link {
            lines,
            architecture,
            scheme,
            is_plain: false,
            scales,
            energy_scale,
            compliance,
            positions,
            forces,
            master_port,
            slave_port,
            generated_j,
        }
    }

    /// Whether positions and forces arrive without delay and unchanged.
    #[must_use]
    pub fn is_direct(&self) -> bool {
        self.is_plain && self.lines.forward.is_immediate() && self.lines.backward.is_immediate()
    }

    /// The equivalent stateless link, if it [is direct](Link::is_direct).
    #[must_use]
    pub fn as_direct(&self) -> Option<DirectLink<L>> {
        self.is_direct().then_some(self.scales)
    }
}

impl<L: Lane, A, P> Link<L, A, P> {
    /// The slave's port, without the work since the last tick.
    #[inline(always)]
    fn port_of(&self, slave: &AtSlave<L>) -> SlavePort<L> {
        SlavePort {
            force_n: self.scales.force_scale * slave.force_n,
            cost_j_per_m: self.energy_scale * slave.force_n,
            work_j: L::zero(),
            position_m: slave.position_m,
            velocity_m_per_s: slave.velocity_m_per_s,
        }
    }
}

impl<L: Lane, A: Architecture<L>, P: PassivityScheme<L>> Connection<L> for Link<L, A, P> {
    #[inline(always)]
    fn position_scale(&self) -> L {
        self.scales.position_scale
    }

    #[inline(always)]
    fn force_scale(&self) -> L {
        self.scales.force_scale
    }

    #[inline(always)]
    fn to_slave(&mut self, master: &AtMaster<L>, slave: &AtSlave<L>) -> L {
        let sent_payload = self.scheme.master_sends(self.master_port.moved(master.position_m));
        let MasterSample { position_m, velocity_m_per_s, acceleration_m_per_s2, hand_force_n } =
            self.architecture.master_sends(master);
        let arrival = self.lines.forward.exchange([position_m, velocity_m_per_s, acceleration_m_per_s2, hand_force_n]);
        let [position_m, velocity_m_per_s, acceleration_m_per_s2, hand_force_n] = arrival.sample;

        let work_j = self.energy_scale * self.slave_port.pushed(slave.position_m, slave.force_n);
        let generated_j = self.energy_scale * self.slave_port.energy_j - self.master_port.energy_j;
        self.generated_j = self.generated_j.max(generated_j);
        let position_m = if self.scheme.sends_payload() {
            let payload = self.lines.forward_payload.exchange(sent_payload).sample;
            let port = SlavePort { work_j, ..self.port_of(slave) };
            self.scheme.receive_position(position_m, &Arrived { payload, is_fresh: arrival.is_fresh }, &port)
        } else {
            position_m
        };
        let arrived = MasterSample { position_m, velocity_m_per_s, acceleration_m_per_s2, hand_force_n };
        let target_m = self.architecture.slave_target(&arrived, slave);
        self.positions.update(target_m, arrival.is_fresh, None)
    }

    #[inline(always)]
    fn limit_reference(&mut self, reference_m: L, slave: &AtSlave<L>) -> L {
        let port = self.port_of(slave);
        self.scheme.limit_reference(reference_m, &port)
    }

    #[inline(always)]
    fn to_master(&mut self, mode: L, slave: &AtSlave<L>, master: &AtMaster<L>) -> (L, L) {
        let sent_payload = self.scheme.slave_sends();
        let SlaveSample { force_n, position_m, velocity_m_per_s, acceleration_m_per_s2 } =
            self.architecture.slave_sends(slave, self.force_scale() * slave.force_n);
        let sent = [force_n, position_m, velocity_m_per_s, acceleration_m_per_s2, mode];
        let arrival = self.lines.backward.exchange(sent);
        let [force_n, position_m, velocity_m_per_s, acceleration_m_per_s2, mode] = arrival.sample;

        let received_n = if self.scheme.sends_payload() {
            let payload = self.lines.backward_payload.exchange(sent_payload).sample;
            let arrived = Arrived { payload, is_fresh: arrival.is_fresh };
            self.scheme.receive_force(force_n, &arrived, master.velocity_m_per_s)
        } else {
            force_n
        };
        let arrived = ArrivedAtMaster {
            sample: SlaveSample { force_n, position_m, velocity_m_per_s, acceleration_m_per_s2 },
            force_n: received_n,
            mode,
        };
        let force_n = self.architecture.master_force(&arrived, master);
        (mode, self.forces.update(force_n, arrival.is_fresh, Some(L::zero())))
    }

    #[inline(always)]
    fn limit(&mut self, force_n: L, master: &AtMaster<L>) -> L {
        let fed_back_n = self.scheme.limit_force(force_n, master.velocity_m_per_s);
        self.master_port.hold(fed_back_n);
        fed_back_n
    }

    #[inline(always)]
    fn apply_compliance(&self, reference_m: L, tissue_force_n: L) -> L {
        reference_m - self.compliance * tissue_force_n
    }

    fn report(&self, index: usize) -> Option<LinkReport> {
        if self.is_direct() {
            return None;
        }
        let (forward, backward) = (self.positions.outages(index), self.forces.outages(index));
        let energies = self.scheme.energies();
        Some(LinkReport {
            outages: (forward.0 + backward.0) as u64,
            longest_outage_ticks: forward.1.max(backward.1),
            given_up_tick: forward.2,
            master_port_j: self.master_port.energy_j.lane(index),
            slave_port_j: self.slave_port.energy_j.lane(index),
            generated_j: self.generated_j.lane(index),
            promised_j: energies.promised_j.map(|promised_j| promised_j.lane(index)),
            left_behind_m: (self.slave_port.position - self.scales.position_scale * self.master_port.position)
                .max(L::zero())
                .lane(index),
            master_dissipated_j: energies.dissipated_j.lane(index),
            slave_refused_j: energies.refused_j.lane(index),
        })
    }
}

crate::lane::gather!(Lines { forward, backward, forward_payload, backward_payload });
crate::lane::gather!(Link {
    lines, architecture, scheme, scales, energy_scale, compliance, positions, forces, master_port, slave_port,
    generated_j,
} same { is_plain });
