//! What a run was worth, in numbers: streaming observers that keep nothing per tick.
//!
//! A number that does not exist is `None`, never 0: the delay of a rupture that was missed, the travel at 0.3 s of a run
//! that ended before.

pub(crate) mod catalogue;
mod event;
mod observer;
mod run_metric;
mod rupture;
mod summary;
mod sums;
mod unit;

pub use catalogue::{Better, Declaration, Metric, Scope, Shown};
pub use event::EventMetrics;
pub use observer::MetricsObserver;
pub use run_metric::RunMetric;
pub use rupture::RuptureMetrics;
pub use summary::{Alarm, LinkMetrics, Metrics, ModeTimes, Outcome};
pub use unit::Unit;

/// How long after a rupture its consequences are looked at, in s: overshoot, master travel, force fall, steepest change;
/// and how late an alarm may be and still be its detection.
pub const RUPTURE_WINDOW_S: f64 = 0.5;

/// When the slave's travel is read, and how long the felt minimum is looked for, in s after the rupture.
pub const TRAVEL_S: f64 = 0.3;

/// The share of its value before the rupture at which a force counts as gone.
pub const FALLEN_SHARE: f64 = 0.05;

/// A run has diverged once a position is beyond this, in m, or no number.
pub const DIVERGED_M: f64 = crate::operator::MAX_POSITION_M;
