//! Schemes that keep the link from generating energy under any delay.
//!
//! The two ports are the hand's and the tissue's contact with the teleoperator: `(F_ed, x_h)` on the master's side,
//! `(f_e, x_e)` on the slave's, with energy positive into the master's port and out of the slave's. Displacements are
//! used, not velocities, so that a force held over a tick gives the integral of force times velocity exactly. The
//! slave's energies are scaled to the master's by force scale over position scale.

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

/// What a scheme adds to each side's samples, and how it changes received samples.
///
/// At each tick the methods are called once, in this order. The payload is one number per direction; send a running
/// total, which survives late and lost samples. The default methods pass everything through.
pub trait PassivityScheme<L: Lane> {
    /// The master's payload, after a displacement of `displacement_m` (m) since the last tick.
    #[inline(always)]
    fn master_sends(&mut self, _displacement_m: L) -> L {
        L::zero()
    }

    /// The master's position for the slave, on the master's scale; `position_m` and `payload` are received.
    #[inline(always)]
    fn receive_position(&mut self, position_m: L, _payload: L, _port: &SlavePort<L>) -> L {
        position_m
    }

    /// The slave's reference in m, given the architecture's `reference_m`.
    #[inline(always)]
    fn limit_reference(&mut self, reference_m: L, _payload: L, _port: &SlavePort<L>) -> L {
        reference_m
    }

    /// The slave's payload.
    #[inline(always)]
    fn slave_sends(&mut self) -> L {
        L::zero()
    }

    /// The tissue force for the master in N; `force_n` and `payload` are received, the velocity is the master's (m/s).
    #[inline(always)]
    fn receive_force(&mut self, force_n: L, _payload: L, _velocity_m_per_s: L) -> L {
        force_n
    }

    /// The feedback force in N, given the force law's `force_n`; payload and velocity as in
    /// [`PassivityScheme::receive_force`].
    #[inline(always)]
    fn limit_force(&mut self, force_n: L, _payload: L, _velocity_m_per_s: L) -> L {
        force_n
    }

    /// Energy dissipated at the master so far, in J.
    fn dissipated_j(&self) -> L {
        L::zero()
    }

    /// Work withheld from the slave so far, in J.
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

/// What a built-in scheme is built for.
#[derive(Debug, Clone, Copy)]
pub(super) struct SchemeContext<L> {
    /// Time between two ticks in s.
    pub(super) tick_s: f64,
    /// Initial position of the master in m.
    pub(super) start_m: L,
    /// Initial reference of the slave in m.
    pub(super) reference_m: L,
    /// Whether samples arrive at the tick that sends them, in both directions.
    pub(super) is_immediate: bool,
}

/// What the registry needs of a scheme besides the trait.
pub(super) trait BuiltInScheme<L: Lane>: PassivityScheme<L> + Sized {
    /// Whether the slave's position reaches the master besides the payload.
    const CARRIES_POSITIONS: bool = true;
    /// The groups of keys that it reads.
    const KEYS: &'static [&'static [Key]];

    /// The scheme at rest; `None` if it would change nothing.
    fn build(settings: &PassivitySettings, context: &SchemeContext<L>) -> Option<Self>;
}
