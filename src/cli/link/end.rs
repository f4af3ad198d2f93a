use crate::cli::error::Failure;
use trocar_engine::engine::EngineError;
use trocar_link::{Greeted, MasterEnd, PACKET_BYTES, Role, SlaveEnd};
use trocar_scenario::Scenario;

pub(super) enum End {
    Master(Box<MasterEnd>),
    Slave(Box<SlaveEnd>),
}

macro_rules! either {
    ($end:expr, $one:ident => $result:expr) => {
        match $end {
            End::Master($one) => $result,
            End::Slave($one) => $result,
        }
    };
}

impl End {
    pub(super) fn new(role: Role, scenario: &Scenario, greeted: &Greeted) -> Result<Self, Failure> {
        let session = greeted.session.clone();
        Ok(match role {
            Role::Master => Self::Master(Box::new(MasterEnd::new(scenario, session)?)),
            Role::Slave => Self::Slave(Box::new(SlaveEnd::new(scenario, session)?)),
        })
    }

    /// Returns the packet for the beginning of a tick, from the side that sends before it receives.
    pub(super) fn send(&mut self, now_ns: i64) -> Option<[u8; PACKET_BYTES]> {
        match self {
            Self::Master(end) => Some(end.send(now_ns)),
            Self::Slave(_) => None,
        }
    }

    /// Computes the rest of a tick. Returns the packet of the side that sends after it has received.
    pub(super) fn step(&mut self, now_ns: i64) -> Result<Option<[u8; PACKET_BYTES]>, EngineError> {
        match self {
            Self::Master(end) => end.step().map(|()| None),
            Self::Slave(end) => end.step(now_ns).map(Some),
        }
    }
}

pub(super) use either;
