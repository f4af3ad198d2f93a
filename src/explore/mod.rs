//! The page of `trocar explore`: classical and augmented teleoperation, simulated again at every change of a slider.
//!
//! The command serves the page and its files on the loopback interface. A page has one WebSocket: it sends a state (a
//! scenario and the changed keys) and receives both runs.

mod assets;
mod controls;
mod frame;
mod guard;
mod limits;
mod map;
mod page;
mod pair;
mod protocol;
mod push;
mod server;
mod session;
mod state;

pub use server::{ExploreError, Options, serve};
pub use state::Catalogue;
