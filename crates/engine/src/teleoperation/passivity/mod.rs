//! Schemes that promise `E_m - E_s >= -E_0` at every tick, under any delay.
//!
//! Energy is positive into the master's port `(F_ed, x_h)` and out of the slave's `(f_e, x_e)`, and scaled to the
//! master by force scale over position scale. Displacements give the work of a held force exactly.

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

/// Share of an account for force changes within a committed motion: of the default 10 mJ, 1 mJ pays for a friction of
/// 2 N that reverses within 0.5 mm.
const RESERVE: f64 = 0.2;

pub const PAYLOAD: usize = 4;

/// Numbers that a scheme adds to each sample.
pub type Payload<L> = [L; PAYLOAD];

#[derive(Debug, Clone, Copy)]
pub struct Arrived<L: Lane> {
    pub payload: Payload<L>,
    pub is_fresh: L::Mask,
}

#[derive(Debug, Clone, Copy)]
pub struct SchemeEnergies<L> {
    /// `E_0`; `None` without a promise.
    pub promised_j: Option<L>,
    pub dissipated_j: L,
    pub refused_j: L,
}

/// Each method is called once per tick, in this order. Send energies as running totals, which survive late and lost
/// samples.
pub trait PassivityScheme<L: Lane> {
    #[inline(always)]
    fn sends_payload(&self) -> bool {
        true
    }

    #[inline(always)]
    fn master_sends(&mut self, _displacement_m: L) -> Payload<L> {
        [L::zero(); PAYLOAD]
    }

    /// On the master's scale.
    #[inline(always)]
    fn receive_position(&mut self, position_m: L, _arrived: &Arrived<L>, _port: &SlavePort<L>) -> L {
        position_m
    }

    #[inline(always)]
    fn limit_reference(&mut self, reference_m: L, _port: &SlavePort<L>) -> L {
        reference_m
    }

    #[inline(always)]
    fn slave_sends(&mut self) -> Payload<L> {
        [L::zero(); PAYLOAD]
    }

    #[inline(always)]
    fn receive_force(&mut self, force_n: L, _arrived: &Arrived<L>, _velocity_m_per_s: L) -> L {
        force_n
    }

    #[inline(always)]
    fn limit_force(&mut self, force_n: L, _velocity_m_per_s: L) -> L {
        force_n
    }

    /// The running totals of both directions begin again at 0.
    fn peer_restarts(&mut self) {}

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

#[derive(Debug, Clone, Copy)]
pub(super) struct SchemeContext<L> {
    pub(super) tick_s: f64,
    pub(super) start_m: L,
    pub(super) reference_m: L,
    pub(super) is_immediate: bool,
    pub(super) position_scale: f64,
    /// Energy at the master per energy at the slave.
    pub(super) energy_scale: L,
    pub(super) master_mass_kg: f64,
    pub(super) motion: SlaveMotion,
}

#[cfg(test)]
impl SchemeContext<f64> {
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
    pub enum AnyScheme<L> by (each, of_kind);

    "none" => None = no_scheme::NoScheme,
    "time-domain" => TimeDomain = time_domain::TimeDomain,
    "wave-variables" => WaveVariables = waves::Waves,
    "energy-tank" => EnergyTank = tank::Tank,
}

trocar_core::settings! {
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct PassivitySettings in "passivity." {
        scheme: Scheme,
        damping: DampingSettings for (Scheme::measurement(DampingSettings::KEYS)),
        waves: WavesSettings for (Scheme::measurement(WavesSettings::KEYS)),
        budget: BudgetSettings for (Scheme::measurement(BudgetSettings::KEYS)),
        tank: TankSettings for (Scheme::measurement(TankSettings::KEYS)),
        catch_up: CatchUpSettings for (Scheme::measurement(CatchUpSettings::KEYS)),
    }
}

impl Scheme {
    const fn measurement(keys: &[Key]) -> ActsFor {
        let schemes = of_kind!([WORD, Part] => (WORD, <Part<f64> as BuiltInScheme<f64>>::KEYS));
        ActsFor::built_from(keys, Self::KEY.path, &schemes)
    }

    /// True if the slave's position reaches the master besides the payload.
    pub fn carries_positions(self) -> bool {
        of_kind!(self, Part => Part::<f64>::CARRIES_POSITIONS)
    }
}

impl PassivitySettings {
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

#[cfg(test)]
mod tests;
