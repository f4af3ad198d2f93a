//! What goes over the link, and what each side makes of what arrives: architectures, recovery from outages, passivity.

mod connection;
mod controller;
mod link;
mod passivity;
mod recovery;

pub use connection::{Connection, DirectLink};
pub use controller::{ControllerKind, ControllerSettings, Machines, MasterGains, SlaveGains};
pub use link::{AtMaster, AtSlave, FromMaster, FromSlave, Link, LinkReport, LinkSettings};
pub use passivity::{PassivitySettings, Scheme};
pub use recovery::{Recovery, RecoverySettings};
