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

/// Reads a message of a page as the server does, and makes the scenarios of its state, for `fuzz/`.
#[cfg(feature = "fuzzing")]
pub fn read_message(text: &str) {
    use protocol::{Export, MapRequest, Request, Show};
    let state = match serde_json::from_str(text) {
        Ok(
            Request::Show(Show { state, .. })
            | Request::Map(MapRequest { state, .. })
            | Request::Export(Export { state, .. })
            | Request::Push { state, .. },
        ) => state,
        _ => return,
    };
    let _ = pair::PairMaker::new(Catalogue::new(None)).scenarios(&state);
}
