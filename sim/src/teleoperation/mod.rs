//! What goes over the link, and what each side makes of what arrives: architectures, recovery from outages, passivity.
//!
//! An architecture and a passivity scheme are each a file and a line below. A part of one's own is any [`Architecture`] or
//! [`PassivityScheme`]; [`Link::with_architecture`] and [`Link::with_scheme`] put it into a link.

#[macro_use]
mod registry;
mod architecture;
mod connection;
mod direct;
mod link;
mod passivity;
mod recovery;
mod settings;

pub use architecture::{Architecture, ArrivedAtMaster, MasterGains, MasterSample, SlaveGains, SlaveSample};
pub use connection::{AtMaster, AtSlave, Connection, LinkReport};
pub use direct::DirectLink;
pub use link::{FromMaster, FromSlave, Link};
pub use passivity::{LimitSettings, PassivityScheme, SlavePort};
pub use recovery::{Recovery, RecoverySettings};
pub use settings::{LinkSettings, Machines};

architectures! {
    PositionForce "position-force" = position_force::PositionForce,
    LocalForce "local-force" = local_force::LocalForce { LocalForceSettings },
    PositionPosition "position-position" = position_position::PositionPosition { CouplingSettings },
    FourChannel "four-channel" = four_channel::FourChannel { FourChannelSettings },
}

schemes! {
    None "none" = no_scheme::NoScheme,
    TimeDomain "time-domain" = time_domain::TimeDomain { TimeDomainSettings },
    WaveVariables "wave-variables" = waves::Waves { WavesSettings },
    EnergyTank "energy-tank" = tank::Tank { TankSettings },
}
