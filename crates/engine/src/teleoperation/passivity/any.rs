//! The list of the built-in passivity schemes.

use trocar_core::settings::{ActsFor, Key};

use super::limits::{BudgetSettings, CatchUpSettings, DampingSettings};
use super::tank::TankSettings;
use super::waves::WavesSettings;
use super::{Arrived, BuiltInScheme, PassivityScheme, Payload, SchemeContext, SchemeEnergies, SlavePort};
use super::{no_scheme, tank, time_domain, waves};
use trocar_core::lane::Lane;

trocar_core::registry! {
    /// Observer and controller at both ports (Hannaford and Ryu 2002), wave variables (Niemeyer and Slotine 1991),
    /// an energy tank on each side (Franken et al. 2011).
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
    /// The scheme, and the settings of all schemes: a key acts for the schemes that read it.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct PassivitySettings in "passivity." {
        /// The scheme.
        scheme: Scheme,
        /// The damping that a scheme may add.
        damping: DampingSettings for (Scheme::reading(DampingSettings::KEYS)),
        /// The wave variables.
        waves: WavesSettings for (Scheme::reading(WavesSettings::KEYS)),
        /// The energy that a scheme may spend in advance.
        budget: BudgetSettings for (Scheme::reading(BudgetSettings::KEYS)),
        /// The tank.
        tank: TankSettings for (Scheme::reading(TankSettings::KEYS)),
        /// How fast the slave catches up.
        catch_up: CatchUpSettings for (Scheme::reading(CatchUpSettings::KEYS)),
    }
}

impl Scheme {
    /// The schemes that read these keys.
    const fn reading(keys: &[Key]) -> ActsFor {
        let schemes = of_kind!([WORD, Part] => (WORD, <Part<f64> as BuiltInScheme<f64>>::KEYS));
        ActsFor::built_from(keys, Self::KEY.path, &schemes)
    }

    /// Whether the slave's position reaches the master besides the payload.
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
    /// The chosen scheme.
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

    fn energies(&self) -> SchemeEnergies<L> {
        each!(self, scheme => scheme.energies())
    }
}
