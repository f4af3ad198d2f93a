//! The page of `trocar explore`: classical and augmented teleoperation, simulated again at every change of a slider.
//!
//! The command serves the page and its files on the loopback interface. A page has one WebSocket: it sends a state (a
//! scenario and the changed keys) and receives both runs. [`state`] validates requests, [`guard`] checks their
//! origin, and [`limits`] contains the limits.

mod assets;
mod connections;
mod controls;
mod frame;
mod guard;
pub mod limits;
mod map;
mod pair;
mod protocol;
mod push;
mod server;
mod session;
mod state;
mod worker;

pub use server::{ExploreError, Options, serve};
pub use state::Catalogue;
