//! What every other package of the simulator may need: quantiles, moments, warnings, rows of long columns, and work on several
//! threads that can be ended from outside.
//!
//! It uses no other package of trocar. The crate `trocar` re-exports what is public of it.

pub mod interrupt;
#[doc(hidden)]
pub mod large_pages;
#[doc(hidden)]
pub mod moments;
#[doc(hidden)]
pub mod parallel;
#[doc(hidden)]
pub mod quantiles;
#[doc(hidden)]
pub mod rows;
pub mod unit;
pub mod warning;
