//! Common tools of all packages: quantiles, moments, warnings, rows of long columns, and parallel work that can be
//! cancelled.
//!
//! The crate uses no other package of trocar. The crate `trocar` re-exports its public items.

#[doc(hidden)]
pub mod centred;
#[doc(hidden)]
pub mod hexadecimal;
pub mod interrupt;
#[doc(hidden)]
pub mod large_pages;
#[doc(hidden)]
pub mod moments;
#[doc(hidden)]
pub mod names;
#[doc(hidden)]
pub mod parallel;
#[doc(hidden)]
pub mod quantiles;
#[doc(hidden)]
pub mod rows;
#[cfg(feature = "schema")]
mod schema;
#[cfg_attr(not(feature = "parallel"), path = "one_thread.rs")]
mod threads;
pub mod unit;
pub mod warning;
