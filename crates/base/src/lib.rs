//! Common tools, independent of the other packages of trocar.

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
