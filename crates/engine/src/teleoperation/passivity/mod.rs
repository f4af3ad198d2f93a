//! Schemes that keep the teleoperator from generating energy under any delay.
//!
//! The ports are the physical contacts with the hand and the tissue: `(F_ed, x_h)` on the master's side, `(f_e, x_e)`
//! on the slave's, with energy positive into the master's port and out of the slave's. Energies use displacements, so a
//! force held over a tick gives the integral exactly. The slave's energies are scaled to the master's by force scale
//! over position scale.
//!
//! A scheme promises `E_m - E_s >= -E_0` at every tick. Its energy account on each side ([`account`]) pays for the
//! motion of the needle and for the force on the hand, respectively.

mod account;
mod budget;
mod force_limit;
mod hand_yield;
mod limits;
mod no_scheme;
mod port;
mod reference_limit;
mod sides;
mod slave_motion;
pub(super) mod tank;
mod time_domain;
pub(super) mod waves;

pub use limits::{BudgetSettings, CatchUpSettings, DampingSettings};
pub(super) use port::Port;
pub use port::SlavePort;
pub(super) use slave_motion::SlaveMotion;

use self::tank::TankSettings;
use self::waves::WavesSettings;
use trocar_core::settings::{ActsFor, Key};

use trocar_core::lane::Lane;

/// Share of an account reserved for unforeseen effects: hand force and tissue force may change within the motion to
/// which a command commits a machine.
///
/// A friction of 2 N that reverses within 0.5 mm takes 1 mJ, half of the reserve of the default budget of 10 mJ.
const RESERVE: f64 = 0.2;

/// Length of a [`Payload`].
pub const PAYLOAD: usize = 4;

/// Numbers that a scheme adds to each sample of a direction.
pub type Payload<L> = [L; PAYLOAD];

/// Inputs of a scheme at a tick.
#[derive(Debug, Clone, Copy)]
pub struct Arrived<L: Lane> {
    /// The payload of the last sample that has arrived.
    pub payload: Payload<L>,
    /// Lanes in which it has arrived at this tick.
    pub is_fresh: L::Mask,
}

/// Energies of a scheme in J.
#[derive(Debug, Clone, Copy)]
pub struct SchemeEnergies<L> {
    /// `E_0`, the bound of the promise `E_m - E_s >= -E_0` at every tick. `None` without a promise.
    pub promised_j: Option<L>,
    /// Energy dissipated at the master so far.
    pub dissipated_j: L,
    /// Work withheld from the slave so far.
    pub refused_j: L,
}

/// Adds a payload to each side's samples, and changes received samples.
///
/// Each method is called once per tick, in this order. Send energies as running totals, which survive late and lost
/// samples. The default methods pass everything through.
pub trait PassivityScheme<L: Lane> {
    /// True if the scheme uses payloads. Otherwise the link is faster.
    #[inline(always)]
    fn sends_payload(&self) -> bool {
        true
    }

    /// The master's payload, after a displacement of `displacement_m` since the last tick.
    #[inline(always)]
    fn master_sends(&mut self, _displacement_m: L) -> Payload<L> {
        [L::zero(); PAYLOAD]
    }

    /// The master's position for the slave, on the master's scale, from the received one.
    #[inline(always)]
    fn receive_position(&mut self, position_m: L, _arrived: &Arrived<L>, _port: &SlavePort<L>) -> L {
        position_m
    }

    /// The slave's reference in m, from the supervisor's, which is frozen or re-engaging in an event.
    #[inline(always)]
    fn limit_reference(&mut self, reference_m: L, _port: &SlavePort<L>) -> L {
        reference_m
    }

    /// The slave's payload.
    #[inline(always)]
    fn slave_sends(&mut self) -> Payload<L> {
        [L::zero(); PAYLOAD]
    }

    /// The tissue force for the master in N, from the received one and the master's velocity.
    #[inline(always)]
    fn receive_force(&mut self, force_n: L, _arrived: &Arrived<L>, _velocity_m_per_s: L) -> L {
        force_n
    }

    /// The feedback force in N, from the force law's and the master's velocity.
    #[inline(always)]
    fn limit_force(&mut self, force_n: L, _velocity_m_per_s: L) -> L {
        force_n
    }

    /// The other side has started anew, so the running totals of both directions begin again at 0.
    fn peer_restarts(&mut self) {}

    /// The promised bound and the energies dissipated and withheld so far.
    fn energies(&self) -> SchemeEnergies<L> {
        SchemeEnergies { promised_j: None, dissipated_j: L::zero(), refused_j: L::zero() }
    }
}

impl<L: Lane, T: PassivityScheme<L> + ?Sized> PassivityScheme<L> for Box<T> {
    fn sends_payload(&self) -> bool {
        (**self).sends_payload()
    }

    fn master_sends(&mut self, displacement_m: L) -> Payload<L> {
        (**self).master_sends(displacement_m)
    }

    fn receive_position(&mut self, position_m: L, arrived: &Arrived<L>, port: &SlavePort<L>) -> L {
        (**self).receive_position(position_m, arrived, port)
    }

    fn limit_reference(&mut self, reference_m: L, port: &SlavePort<L>) -> L {
        (**self).limit_reference(reference_m, port)
    }

    fn slave_sends(&mut self) -> Payload<L> {
        (**self).slave_sends()
    }

    fn receive_force(&mut self, force_n: L, arrived: &Arrived<L>, velocity_m_per_s: L) -> L {
        (**self).receive_force(force_n, arrived, velocity_m_per_s)
    }

    fn limit_force(&mut self, force_n: L, velocity_m_per_s: L) -> L {
        (**self).limit_force(force_n, velocity_m_per_s)
    }

    fn peer_restarts(&mut self) {
        (**self).peer_restarts();
    }

    fn energies(&self) -> SchemeEnergies<L> {
        (**self).energies()
    }
}

/// Inputs of a built-in scheme's constructor.
#[derive(Debug, Clone, Copy)]
pub(super) struct SchemeContext<L> {
    pub(super) tick_s: f64,
    pub(super) start_m: L,
    pub(super) reference_m: L,
    /// True if samples arrive at the tick that sends them, in both directions.
    pub(super) is_immediate: bool,
    pub(super) position_scale: f64,
    /// Energy at the master per energy at the slave.
    pub(super) energy_scale: L,
    pub(super) master_mass_kg: f64,
    pub(super) motion: SlaveMotion,
}

#[cfg(test)]
impl SchemeContext<f64> {
    /// The paper's machines on a tick of 1 ms.
    fn for_tests() -> Self {
        use crate::plant::{ControlTiming, MasterParameters, SlaveParameters, SlaveStep};
        let step = SlaveStep::new(&SlaveParameters::default(), ControlTiming::Continuous, 1e-3).expect("valid");
        Self {
            tick_s: 1e-3,
            start_m: 0.0,
            reference_m: 0.0,
            is_immediate: false,
            position_scale: 1.0,
            energy_scale: 1.0,
            master_mass_kg: MasterParameters::DEFAULT.mass_kg,
            motion: SlaveMotion::new(&step, 1e-3),
        }
    }
}

pub(super) trait BuiltInScheme<L: Lane>: PassivityScheme<L> + Sized {
    const CARRIES_POSITIONS: bool = true;
    const KEYS: &'static [&'static [Key]];

    /// The keys and values of the dampings (N·s/m) that the scheme holds over a tick at the master.
    fn held_dampings(_settings: &PassivitySettings) -> [Option<(&'static str, f64)>; 2] {
        [None, None]
    }

    fn build(settings: &PassivitySettings, context: &SchemeContext<L>) -> Self;
}

trocar_core::registry! {
    /// Passivity scheme: observer and controller at both ports (Hannaford and Ryu 2002), wave variables (Niemeyer and
    /// Slotine 1991), or an energy tank on each side (Franken et al. 2011).
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Scheme at "passivity.scheme" = None;
    /// A built-in passivity scheme.
    pub enum AnyScheme<L> by (each, of_kind);

    "none" => None = no_scheme::NoScheme,
    "time-domain" => TimeDomain = time_domain::TimeDomain,
    "wave-variables" => WaveVariables = waves::Waves,
    "energy-tank" => EnergyTank = tank::Tank,
}

trocar_core::settings! {
    /// The scheme, and the settings of all schemes. A key acts for the schemes that read it.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct PassivitySettings in "passivity." {
        /// Kind of passivity scheme.
        scheme: Scheme,
        /// Damping that a scheme may add.
        damping: DampingSettings for (Scheme::measurement(DampingSettings::KEYS)),
        /// Settings of the wave variables.
        waves: WavesSettings for (Scheme::measurement(WavesSettings::KEYS)),
        /// Energy that a scheme may spend in advance.
        budget: BudgetSettings for (Scheme::measurement(BudgetSettings::KEYS)),
        /// Settings of the energy tanks.
        tank: TankSettings for (Scheme::measurement(TankSettings::KEYS)),
        /// Limits of the slave's motion when it catches up.
        catch_up: CatchUpSettings for (Scheme::measurement(CatchUpSettings::KEYS)),
    }
}

impl Scheme {
    /// The condition on the schemes that read these keys.
    const fn measurement(keys: &[Key]) -> ActsFor {
        let schemes = of_kind!([WORD, Part] => (WORD, <Part<f64> as BuiltInScheme<f64>>::KEYS));
        ActsFor::built_from(keys, Self::KEY.path, &schemes)
    }

    /// True if the slave's position reaches the master besides the payload.
    #[must_use]
    pub fn carries_positions(self) -> bool {
        of_kind!(self, Part => Part::<f64>::CARRIES_POSITIONS)
    }
}

impl PassivitySettings {
    /// The keys and values of the dampings (N·s/m) that the scheme holds over a tick at the master.
    pub fn held_dampings(&self) -> [Option<(&'static str, f64)>; 2] {
        of_kind!(self.scheme, Part => Part::<f64>::held_dampings(self))
    }
}

impl<L: Lane> AnyScheme<L> {
    pub(in crate::teleoperation) fn new(settings: &PassivitySettings, context: &SchemeContext<L>) -> Self {
        of_kind!(settings.scheme, Part => Part::<L>::build(settings, context).into())
    }
}

impl<L: Lane> PassivityScheme<L> for AnyScheme<L> {
    #[inline(always)]
    fn sends_payload(&self) -> bool {
        each!(self, scheme => scheme.sends_payload())
    }

    #[inline(always)]
    fn master_sends(&mut self, displacement_m: L) -> Payload<L> {
        each!(self, scheme => scheme.master_sends(displacement_m))
    }

    #[inline(always)]
    fn receive_position(&mut self, position_m: L, arrived: &Arrived<L>, port: &SlavePort<L>) -> L {
        each!(self, scheme => scheme.receive_position(position_m, arrived, port))
    }

    #[inline(always)]
    fn limit_reference(&mut self, reference_m: L, port: &SlavePort<L>) -> L {
        each!(self, scheme => scheme.limit_reference(reference_m, port))
    }

    #[inline(always)]
    fn slave_sends(&mut self) -> Payload<L> {
        each!(self, scheme => scheme.slave_sends())
    }

    #[inline(always)]
    fn receive_force(&mut self, force_n: L, arrived: &Arrived<L>, velocity_m_per_s: L) -> L {
        each!(self, scheme => scheme.receive_force(force_n, arrived, velocity_m_per_s))
    }

    #[inline(always)]
    fn limit_force(&mut self, force_n: L, velocity_m_per_s: L) -> L {
        each!(self, scheme => scheme.limit_force(force_n, velocity_m_per_s))
    }

    fn peer_restarts(&mut self) {
        each!(self, scheme => scheme.peer_restarts());
    }

    fn energies(&self) -> SchemeEnergies<L> {
        each!(self, scheme => scheme.energies())
    }
}
