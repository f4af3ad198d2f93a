//! A page to explore: classical beside augmented, simulated anew at every move of a slider.
//!
//! The program serves the page itself, assets and all, on the loopback interface. One WebSocket a page carries everything:
//! a state (a scenario and the keys that differ) goes in, both runs come back. What a page may ask for is in [`state`], who
//! may ask in [`guard`], and how much in [`limits`].

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
mod thin;
mod worker;

pub use guard::Guard;
pub use pair::{Pair, PairMaker};
pub use server::{ExploreError, Options, serve};
pub use state::{Catalogue, State, StateError};
