//! The link and its two ends: architectures, recovery from outages, passivity.
//!
//! A built-in architecture or passivity scheme is a file and a line below. A user's part implements [`Architecture`] or
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

pub use architecture::local_force::LocalForceSettings;
pub use architecture::position_position::CouplingSettings;
pub use architecture::{Architecture, ArrivedAtMaster, MasterGains, MasterSample, SlaveGains, SlaveSample};
pub use connection::{AtMaster, AtSlave, Connection, LinkReport};
pub use direct::DirectLink;
pub use link::{FromMaster, FromSlave, Lines, Link, Message, PayloadLine, Received, ToMaster, ToSlave};
pub use passivity::{
    Arrived, BudgetSettings, CatchUpSettings, DampingSettings, PAYLOAD, PassivityScheme, Payload, SchemeEnergies,
    SlavePort,
};
pub use recovery::{Recovery, RecoverySettings};
pub use settings::{ComplianceSettings, LinkSettings, Machines, Scales};

architectures! {
    /// The paper's architecture; the same with local force feedback; a spring between the machines; or four-channel,
    /// transparent (Lawrence 1993).
    shared { coupling: CouplingSettings, local_force: LocalForceSettings }
    "position-force" => PositionForce = position_force::PositionForce,
    "local-force" => LocalForce = local_force::LocalForce,
    "position-position" => PositionPosition = position_position::PositionPosition,
    "four-channel" => FourChannel = four_channel::FourChannel { four_channel: FourChannelSettings },
}

schemes! {
    /// Observer and controller at both ports (Hannaford and Ryu 2002), wave variables (Niemeyer and Slotine 1991),
    /// an energy tank on each side (Franken et al. 2011).
    "none" => None = no_scheme::NoScheme,
    "time-domain" => TimeDomain = time_domain::TimeDomain shared { damping: DampingSettings },
    "wave-variables" => WaveVariables = waves::Waves { waves: WavesSettings } shared { budget: BudgetSettings },
    "energy-tank" => EnergyTank = tank::Tank { tank: TankSettings } shared { catch_up: CatchUpSettings },
}

#[cfg(test)]
mod tests;
