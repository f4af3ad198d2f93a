use super::architecture::{Architecture, ArrivedAtMaster, MasterSample, SlaveSample};
use super::connection::{AtMaster, AtSlave, Connection, LinkReport};
use super::direct::DirectLink;
use super::passivity::{Arrived, PAYLOAD, PassivityScheme, Payload, Port, SchemeContext, SlaveMotion, SlavePort};
use super::recovery::{Receiver, RecoverySettings};
use super::{AnyArchitecture, AnyScheme, ControllerKind, LinkSettings};
use crate::channel::{Arrival, Delay};
use crate::plant::SlaveStep;
use trocar_core::augmentation::Modes;
use trocar_core::error::InvalidValue;
use trocar_core::lane::Lane;

/// Position, velocity, acceleration and hand force.
pub type FromMaster<L> = Delay<L, 4>;
/// Force scaled to the master, position, velocity, acceleration and mode.
pub type FromSlave<L> = Delay<L, 5>;
pub type PayloadLine<L> = Delay<L, PAYLOAD>;

/// Both lines of a direction have the same delays and losses.
#[derive(Debug, Clone)]
pub struct Lines<L: Lane> {
    pub forward: FromMaster<L>,
    pub backward: FromSlave<L>,
    pub forward_payload: PayloadLine<L>,
    pub backward_payload: PayloadLine<L>,
}

#[derive(Debug, Clone, Copy)]
pub struct Message<L, const N: usize> {
    pub sample: [L; N],
    /// Zeros without a scheme.
    pub payload: Payload<L>,
}

/// As in [`FromMaster`].
pub type ToSlave<L> = Message<L, 4>;
/// As in [`FromSlave`].
pub type ToMaster<L> = Message<L, 5>;

#[derive(Debug, Clone, Copy)]
pub struct Received<L: Lane, const N: usize> {
    pub sample: [L; N],
    pub payload: Payload<L>,
    pub is_fresh: L::Mask,
}

impl<L: Lane, const N: usize> Received<L, N> {
    #[inline(always)]
    fn of(arrival: &Arrival<L, N>, payload: Payload<L>) -> Self {
        Self { sample: arrival.sample, payload, is_fresh: arrival.is_fresh }
    }

    #[inline(always)]
    fn payload(&self) -> Arrived<L> {
        Arrived { payload: self.payload, is_fresh: self.is_fresh }
    }
}

#[derive(Debug, Clone)]
pub struct Link<L: Lane, A = AnyArchitecture<L>, P = AnyScheme<L>> {
    lines: Lines<L>,
    architecture: A,
    scheme: P,
    /// Unchanged, as in the paper.
    is_plain: bool,
    scales: DirectLink<L>,
    energy_scale: L,
    compliance: L,
    positions: Receiver<L>,
    forces: Receiver<L>,
    master_port: Port<L>,
    slave_port: Port<L>,
    generated_j: L,
}

impl<L: Lane> Link<L> {
    pub fn new(
        settings: &LinkSettings,
        lines: Lines<L>,
        slave: &SlaveStep,
        tick_s: f64,
        start_m: f64,
    ) -> Result<Self, InvalidValue> {
        let architecture = settings.architecture(tick_s)?;
        let LinkSettings { controller, machines, recovery, passivity } = settings;
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
            positions: receiver(recovery, recovery.speed_m_per_s, reference_m)
                .expecting_within(lines.forward.longest_ticks())
                .keeping_pace(!matches!(scheme, AnyScheme::None(_))),
            architecture,
            scheme,
            scales: DirectLink::new(machines.position_scale, machines.force_scale),
            energy_scale,
            compliance: L::splat(machines.compliance_m_per_n),
            forces: receiver(&recovery.of_forces(), recovery.force_rate_n_per_s, L::zero())
                .expecting_within(lines.backward.longest_ticks())
                .fading(recovery, tick_s),
            master_port: Port::at(L::splat(start_m)),
            slave_port: Port::at(reference_m),
            generated_j: L::zero(),
            lines,
        })
    }
}

impl<L: Lane, A, P> Link<L, A, P> {
    pub fn with_slave_at(mut self, start_m: f64) -> Self {
        self.slave_port = Port::at(L::splat(start_m));
        self
    }

    pub fn with_architecture<B: Architecture<L>>(self, architecture: B) -> Link<L, B, P> {
        self.with(|_, scheme| (architecture, scheme))
    }

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

    pub fn is_direct(&self) -> bool {
        self.is_plain && self.lines.forward.is_immediate() && self.lines.backward.is_immediate()
    }

    pub fn as_direct(&self) -> Option<DirectLink<L>> {
        self.is_direct().then_some(self.scales)
    }
}

impl<L: Lane, A, P> Link<L, A, P> {
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

/// A step changes only its own side's state.
impl<L: Lane, A: Architecture<L>, P: PassivityScheme<L>> Link<L, A, P> {
    #[inline(always)]
    pub fn master_sends(&mut self, master: &AtMaster<L>) -> ToSlave<L> {
        let payload = self.scheme.master_sends(self.master_port.moved(master.position_m));
        let MasterSample { position_m, velocity_m_per_s, acceleration_m_per_s2, hand_force_n } =
            self.architecture.master_sends(master);
        Message { sample: [position_m, velocity_m_per_s, acceleration_m_per_s2, hand_force_n], payload }
    }

    #[inline(always)]
    pub fn slave_receives(&mut self, received: &Received<L, 4>, slave: &AtSlave<L>) -> L {
        let [position_m, velocity_m_per_s, acceleration_m_per_s2, hand_force_n] = received.sample;
        let work_j = self.energy_scale * self.slave_port.pushed(slave.position_m, slave.force_n);
        let position_m = if self.scheme.sends_payload() {
            let port = SlavePort { work_j, ..self.port_of(slave) };
            self.scheme.receive_position(position_m, &received.payload(), &port)
        } else {
            position_m
        };
        let arrived = MasterSample { position_m, velocity_m_per_s, acceleration_m_per_s2, hand_force_n };
        let target_m = self.architecture.slave_target(&arrived, slave);
        self.positions.update(target_m, received.is_fresh, None)
    }

    #[inline(always)]
    pub fn slave_sends(&mut self, mode: Modes<L>, slave: &AtSlave<L>) -> ToMaster<L> {
        let payload = self.scheme.slave_sends();
        let SlaveSample { force_n, position_m, velocity_m_per_s, acceleration_m_per_s2 } =
            self.architecture.slave_sends(slave, self.scales.force_scale * slave.force_n);
        Message { sample: [force_n, position_m, velocity_m_per_s, acceleration_m_per_s2, mode.codes()], payload }
    }

    #[inline(always)]
    pub fn master_receives(&mut self, received: &Received<L, 5>, master: &AtMaster<L>) -> (Modes<L>, L) {
        let [force_n, position_m, velocity_m_per_s, acceleration_m_per_s2, mode] = received.sample;
        let mode = Modes::from_codes(mode);
        let received_n = if self.scheme.sends_payload() {
            self.scheme.receive_force(force_n, &received.payload(), master.velocity_m_per_s)
        } else {
            force_n
        };
        let arrived = ArrivedAtMaster {
            sample: SlaveSample { force_n, position_m, velocity_m_per_s, acceleration_m_per_s2 },
            force_n: received_n,
            mode,
        };
        let force_n = self.architecture.master_force(&arrived, master);
        (mode, self.forces.update(force_n, received.is_fresh, Some(L::zero())))
    }

    pub fn peer_restarts(&mut self) {
        self.scheme.peer_restarts();
    }

    /// `Σ F_ed Δx_h`
    pub fn master_energy_j(&self) -> L {
        self.master_port.energy_j
    }

    /// `∫ f_e dx_e`, scaled to the master.
    pub fn slave_energy_j(&self) -> L {
        self.energy_scale * self.slave_port.energy_j
    }

    pub fn promised_j(&self) -> Option<L> {
        self.scheme.energies().promised_j
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
        let sent = self.master_sends(master);
        let arrival = self.lines.forward.exchange(sent.sample);
        let payload = if self.scheme.sends_payload() {
            self.lines.forward_payload.exchange(sent.payload).sample
        } else {
            sent.payload
        };
        let hand_m = self.slave_receives(&Received::of(&arrival, payload), slave);
        let generated_j = self.energy_scale * self.slave_port.energy_j - self.master_port.energy_j;
        self.generated_j = self.generated_j.max(generated_j);
        hand_m
    }

    #[inline(always)]
    fn limit_reference(&mut self, reference_m: L, slave: &AtSlave<L>) -> L {
        let port = self.port_of(slave);
        let limited_m = self.scheme.limit_reference(reference_m, &port);
        if self.scheme.sends_payload() {
            self.positions.withhold(reference_m - limited_m);
        }
        limited_m
    }

    #[inline(always)]
    fn to_master(&mut self, mode: Modes<L>, slave: &AtSlave<L>, master: &AtMaster<L>) -> (Modes<L>, L) {
        let sent = self.slave_sends(mode, slave);
        let arrival = self.lines.backward.exchange(sent.sample);
        let payload = if self.scheme.sends_payload() {
            self.lines.backward_payload.exchange(sent.payload).sample
        } else {
            sent.payload
        };
        self.master_receives(&Received::of(&arrival, payload), master)
    }

    #[inline(always)]
    fn limit(&mut self, force_n: L, master: &AtMaster<L>) -> L {
        let present_n = self.forces.presence() * force_n;
        let fed_back_n = self.scheme.limit_force(present_n, master.velocity_m_per_s);
        self.master_port.hold(fed_back_n);
        fed_back_n
    }

    #[inline(always)]
    fn deflection_m(&self, tissue_force_n: L) -> L {
        self.compliance * tissue_force_n
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

trocar_core::lane::gather!(Lines { forward, backward, forward_payload, backward_payload });
trocar_core::lane::gather!(Link {
    lines, architecture, scheme, scales, energy_scale, compliance, positions, forces, master_port, slave_port,
    generated_j,
} same { is_plain });
