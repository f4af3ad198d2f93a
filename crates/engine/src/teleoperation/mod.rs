//! A built-in architecture or scheme is one file of its folder and one row of the registry in its `mod.rs`;
//! user-defined ones enter by [`Link::with_architecture`] or [`Link::with_scheme`].

mod architecture;
mod connection;
mod direct;
mod link;
mod master_reading;
mod passivity;
mod recovery;
mod settings;

pub use architecture::four_channel::FourChannelSettings;
pub use architecture::local_force::LocalForceSettings;
pub use architecture::position_position::CouplingSettings;
pub use architecture::{
    AnyArchitecture, Architecture, ArrivedAtMaster, ControllerKind, ControllerSettings, MasterGains, MasterSample,
    SlaveGains, SlaveSample,
};
pub use connection::{AtMaster, AtSlave, Connection, LinkReport};
pub use direct::DirectLink;
pub use link::{FromMaster, FromSlave, Lines, Link, Message, PayloadLine, Received, ToMaster, ToSlave};
pub use master_reading::{EncoderSettings, MasterReading};
pub use passivity::tank::TankSettings;
pub use passivity::waves::WavesSettings;
pub use passivity::{
    AnyScheme, Arrived, BudgetSettings, CatchUpSettings, DampingSettings, PAYLOAD, PassivityScheme, PassivitySettings,
    Payload, Scheme, SchemeEnergies, SlavePort,
};
pub use recovery::{Recovery, RecoverySettings};
pub use settings::{ComplianceSettings, LinkSettings, Machines, Scales};

#[cfg(test)]
mod tests;
