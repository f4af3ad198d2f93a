//! Temporary.
#[path = "it/explore.rs"]
mod explore;
#[path = "it/link_random.rs"]
mod link_random;
#[path = "it/link_restart.rs"]
mod link_restart;
#[path = "it/link_sides.rs"]
mod link_sides;
#[path = "it/schemas.rs"]
mod schemas;
#[path = "it/support/mod.rs"]
mod support;
