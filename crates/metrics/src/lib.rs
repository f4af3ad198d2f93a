//! Metrics of a run from streaming observers, without storage per tick. An undefined metric is `None`, never 0.
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

/// The window after a rupture for overshoot, master travel, force fall and peak rate.
pub const RUPTURE_WINDOW_S: f64 = 0.5;

/// Maximum time from a rupture to an alarm that counts as its detection.
///
/// The slowest rupture that `trocar calibrate` expects leaves a tenth of the force after 0.1 s (half of it is lost in
/// 30 ms); the shipped scenarios' alarms follow within 12 ms.
pub const ALARM_WINDOW_S: f64 = 0.1;

/// Horizon of a rupture, unless the next rupture comes first: the needle's advance is compared with the intended motion.
pub const HORIZON_S: f64 = 2.0;

/// Time after a rupture for the slave's travel and the minimum of the felt force.
pub const TRAVEL_S: f64 = 0.3;

/// A force at or below this fraction of its value at the rupture has fallen.
pub const FALLEN_SHARE: f64 = 0.05;

/// A run diverges beyond this position, or at NaN.
pub const DIVERGED_M: f64 = trocar_engine::operator::MAX_POSITION_M;

#[cfg(test)]
mod tests;
