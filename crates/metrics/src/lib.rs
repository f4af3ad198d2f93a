//! The metrics of a run, computed by streaming observers without storage per tick.
//!
//! An undefined metric is `None`, never 0: the delay of a missed rupture, the travel at 0.3 s of a run that ended
//! before.

#[doc(hidden)]
pub mod catalogue;
mod event;
#[cfg(test)]
pub(crate) mod fixtures;
mod intent;
mod miss;
mod observer;
mod ports;
mod run_metric;
mod rupture;
mod summary;
mod sums;

pub use catalogue::{Better, Declaration, Metric, Scope, Shown};
pub use event::EventMetrics;
pub use intent::{Aftermath, Pursuit};
pub use miss::{DetectorSample, Miss, MissReason, MissRule, SupervisorHistory};
pub use observer::MetricsObserver;
pub use ports::{PortColumns, PortMetrics};
pub use run_metric::RunMetric;
pub use rupture::RuptureMetrics;
pub use summary::{Alarm, LinkMetrics, Metrics, ModeTimes, Outcome};
pub use trocar_base::unit::Unit;

/// The window after a rupture in s: for overshoot, master travel, force fall and peak rate.
pub const RUPTURE_WINDOW_S: f64 = 0.5;

/// Maximum time in s from a rupture to an alarm that counts as its detection.
///
/// The slowest rupture that `trocar calibrate` expects takes half of the force in 30 ms, so that a tenth is left after 0.1 s;
/// the alarms of the shipped scenarios follow within 12 ms. A later alarm has another cause.
pub const ALARM_WINDOW_S: f64 = 0.1;

/// The horizon of a rupture in s: the advance of the needle is compared with the intended motion up to the next rupture, or
/// for this long.
pub const HORIZON_S: f64 = 2.0;

/// Time after the rupture in s at which the slave's travel is read; the minimum of the felt force is taken up to it.
pub const TRAVEL_S: f64 = 0.3;

/// The fraction of its value before the rupture at which a force counts as fallen.
pub const FALLEN_SHARE: f64 = 0.05;

/// A run has diverged once a position exceeds this bound in m, or is NaN.
pub const DIVERGED_M: f64 = trocar_engine::operator::MAX_POSITION_M;

#[cfg(test)]
mod tests;
