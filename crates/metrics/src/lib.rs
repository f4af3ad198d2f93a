//! The metrics of a run, computed by streaming observers without storage per tick.
//!
//! An undefined metric is `None`, never 0: the delay of a missed rupture, the travel at 0.3 s of a shorter run.
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
#[cfg(feature = "schema")]
#[doc(hidden)]
pub mod schema;
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

/// The window after a rupture for overshoot, master travel, force fall and peak rate, in s.
pub const RUPTURE_WINDOW_S: f64 = 0.5;

/// Maximum time from a rupture to an alarm that counts as its detection, in s.
///
/// The slowest rupture that `trocar calibrate` expects loses half of the force in 30 ms, so a tenth is left after 0.1
/// s. The alarms of the shipped scenarios follow within 12 ms. A later alarm has another cause.
pub const ALARM_WINDOW_S: f64 = 0.1;

/// Horizon of a rupture in s, or up to the next rupture: time in which the needle's advance is compared with the
/// intended motion.
pub const HORIZON_S: f64 = 2.0;

/// Time after a rupture in s at which the slave's travel is read, and over which the minimum of the felt force is
/// taken.
pub const TRAVEL_S: f64 = 0.3;

/// A force counts as fallen at or below this fraction of its value at the rupture.
pub const FALLEN_SHARE: f64 = 0.05;

/// A run diverges when a position exceeds this bound in m, or is NaN.
pub const DIVERGED_M: f64 = trocar_engine::operator::MAX_POSITION_M;

#[cfg(test)]
mod tests;
