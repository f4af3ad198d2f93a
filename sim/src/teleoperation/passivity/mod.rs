//! Schemes that keep the link from making energy, whatever its delay.
//!
//! The two ports are where hand and tissue meet the teleoperator: `(F_ed, x_h)` on the master's side, `(f_e, x_e)` on the
//! slave's, with energy counted as it enters at the master and leaves at the slave. Displacements are used, not
//! velocities, so that a force held over a tick gives the integral of force times velocity exactly. Energies of the slave
//! are compared in the master's units: scaled by force scale over position scale.

mod limits;
mod meter;
pub(super) mod no_scheme;
mod port;
pub(super) mod tank;
pub(super) mod time_domain;
pub(super) mod waves;

pub use limits::{CatchUpSettings, DampingSettings};
pub(super) use port::Port;
pub use port::SlavePort;

use trocar_core::settings::Key;

use super::PassivitySettings;
use crate::lane::Lane;

/// What a scheme adds to what each side sends, and what it does to what arrives.
///
/// At each tick the methods are called once, in this order. What is sent is one number a direction, the payload: a running
/// total survives samples that are late or lost. A scheme implements what it does; all else is passed on.
pub trait PassivityScheme<L: Lane> {
    /// The payload that the master sends, which has moved by `displacement_m` (m) since the last tick.
    #[inline(always)]
    fn master_sends(&mut self, _displacement_m: L) -> L {
        L::zero()
    }

    /// The master's position as the slave takes it, in the master's metres: `position_m` where the sample is taken as it
    /// is; `payload` is what has arrived beside it.
    #[inline(always)]
    fn receive_position(&mut self, position_m: L, _payload: L, _port: &SlavePort<L>) -> L {
        position_m
    }

    /// The slave's reference in m, where the architecture asks for `reference_m`.
    #[inline(always)]
    fn limit_reference(&mut self, reference_m: L, _payload: L, _port: &SlavePort<L>) -> L {
        reference_m
    }

    /// The payload that the slave sends.
    #[inline(always)]
    fn slave_sends(&mut self) -> L {
        L::zero()
    }

    /// The tissue's force as the master takes it, in N: `force_n` where the sample is taken as it is; `payload` is what has
    /// arrived beside it, the velocity is the master's (m/s).
    #[inline(always)]
    fn receive_force(&mut self, force_n: L, _payload: L, _velocity_m_per_s: L) -> L {
        force_n
    }

    /// The force that is fed back in N, where the force law asks for `force_n`; payload and velocity as in
    /// [`PassivityScheme::receive_force`].
    #[inline(always)]
    fn limit_force(&mut self, force_n: L, _payload: L, _velocity_m_per_s: L) -> L {
        force_n
    }

    /// Energy dissipated at the master so far, in J.
    fn dissipated_j(&self) -> L {
        L::zero()
    }

    /// Work kept from the slave so far, in J.
    fn refused_j(&self) -> L {
        L::zero()
    }
}

impl<L: Lane, T: PassivityScheme<L> + ?Sized> PassivityScheme<L> for Box<T> {
    fn master_sends(&mut self, displacement_m: L) -> L {
        (**self).master_sends(displacement_m)
    }

    fn receive_position(&mut self, position_m: L, payload: L, port: &SlavePort<L>) -> L {
        (**self).receive_position(position_m, payload, port)
    }

    fn limit_reference(&mut self, reference_m: L, payload: L, port: &SlavePort<L>) -> L {
        (**self).limit_reference(reference_m, payload, port)
    }

    fn slave_sends(&mut self) -> L {
        (**self).slave_sends()
    }

    fn receive_force(&mut self, force_n: L, payload: L, velocity_m_per_s: L) -> L {
        (**self).receive_force(force_n, payload, velocity_m_per_s)
    }

    fn limit_force(&mut self, force_n: L, payload: L, velocity_m_per_s: L) -> L {
        (**self).limit_force(force_n, payload, velocity_m_per_s)
    }

    fn dissipated_j(&self) -> L {
        (**self).dissipated_j()
    }

    fn refused_j(&self) -> L {
        (**self).refused_j()
    }
}

/// What a built-in scheme is put into.
#[derive(Debug, Clone, Copy)]
pub(super) struct Surroundings<L> {
    /// Time between two ticks in s.
    pub(super) tick_s: f64,
    /// Where the master begins, in m.
    pub(super) start_m: L,
    /// Where the slave's reference begins, in m.
    pub(super) reference_m: L,
    /// Whether a sample arrives at the tick that sends it, both ways.
    pub(super) is_immediate: bool,
}

/// What a line in the registry needs of a scheme besides.
pub(super) trait BuiltInScheme<L: Lane>: PassivityScheme<L> + Sized {
    /// Whether positions go back to the master beside what the scheme sends.
    const CARRIES_POSITIONS: bool = true;
    /// The groups of keys that it is built from.
    const KEYS: &'static [&'static [Key]];

    /// The scheme at rest; none where it would change nothing.
    fn build(settings: &PassivitySettings, around: &Surroundings<L>) -> Option<Self>;
}
