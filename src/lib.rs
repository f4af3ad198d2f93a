//! Bilateral teleoperation of needle insertions, with event-based haptic augmentation.
//!
//! An operator moves a master, a slave drives a needle, and the tissue force is fed back to the operator. When a
//! layer ruptures, the needle overshoots. trocar estimates the tissue online, detects the rupture, freezes the slave
//! and amplifies the drop of the felt force. The method is that of Barbé, Bayle, de Mathelin and Gangi, *In Vivo
//! Model Estimation and Haptic Characterization of Needle Insertions*. Equation numbers in this documentation refer
//! to that paper.
//!
//! # Signs and units
//! All quantities are in SI units: m, m/s, N, s. Positions increase into the tissue. Forces are positive when they
//! resist insertion (the paper plots the opposite sign). The operator's force on the master is positive in the
//! direction of insertion.
//!
//! # Entry points
//! | task | start with |
//! |---|---|
//! | run a scenario | [`scenario::Scenario::load`], [`run::run`], [`run::measure`] |
//! | compare scenarios | [`compare::Comparison`] |
//! | run many cases, vary keys | [`sweep`], [`run::run_pack`] |
//! | detect ruptures in a recording | [`detect`]; [`roc`] evaluates detectors |
//! | identify a machine from recordings | [`identify::identify`](fn@identify::identify) |
//! | analyse stability | [`stability`] |
//! | control a rig | [`rig::HapticController`] (the package `trocar-core`: `no_std`, no allocation) |
//! | run a user-defined part in the loop | [`engine::UserDefinedParts`] with [`run::run_with`] |
//! | write results | [`report`] |
//!
//! # Features
//! The default features also build the command line. A program that only runs scenarios uses
//! `default-features = false`, and builds at most 60 packages.
//!
//! | feature | adds |
//! |---|---|
//! | `cli` | the program `trocar`; has `studies` |
//! | `studies` | the modules [`compare`], [`design`](mod@design), [`detect`], [`document`], [`figures`], [`identify`](mod@identify), [`reference`], [`report`], [`roc`], [`stability`], [`stability_check`], [`sweep`], and the documents and warnings of a [`run`]; has the two features below |
//! | `formats` | recordings in other files than text |
//! | `dop853` | `simulation.engine = "dop853"` |
//!
//! ```
//! use trocar::run::measure;
//! use trocar::scenario::{Scenario, Source};
//!
//! let settings = [("scaling.force", 0.8.into()), ("simulation.seed", 7.into())];
//! let scenario = Scenario::load_with(&Source::parse("layers/skin-augmented"), &settings)?;
//! let metrics = measure(&scenario)?;
//! assert!(metrics.ruptures[0].slave_overshoot_m.is_some_and(|overshoot_m| overshoot_m < 1e-3));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Run and compare
//! ```
//! use trocar::compare::Comparison;
//! use trocar::scenario::{Scenario, Source};
//!
//! let load = |name: &str| Scenario::load_with(&Source::parse(name), &[("simulation.seed", 7.into())]);
//! let comparison = Comparison::of(vec![load("paper/classical")?, load("paper/augmented")?])?;
//! let overshoot_m = |k: usize| comparison.runs[k].metrics.ruptures[0].slave_overshoot_m;
//! assert!(overshoot_m(0).is_some_and(|classical| classical > 8e-3));
//! assert!(overshoot_m(1).is_some_and(|augmented| augmented < 1e-4));
//! assert!(comparison.runs[1].trace.slave_position_m.len() == 17_000);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Detect on samples
//! ```
//! use trocar::detect::{DetectionChain, Measurement, VelocitySource};
//! use trocar::scenario::{DetectionSettings, Scenario, Source, Values};
//!
//! let settings = DetectionSettings::resolve(&mut Values::from_settings("mine", &[])?)?;
//! let mut chain = DetectionChain::new(&settings, 0.001, VelocitySource::Measured)?;
//! // Any samples, 1 ms apart; here those of a simulation.
//! let trace = trocar::run::run(Scenario::load(&Source::parse("paper/classical"), &[])?)?.trace;
//! let is_alarm = |k: &usize| {
//!     let reading = Measurement {
//!         force_n: trace.measured_force_n[*k],
//!         position_m: trace.slave_position_m[*k],
//!         velocity_m_per_s: trace.slave_velocity_m_per_s[*k],
//!     };
//!     chain.step(&reading).decision.alarm
//! };
//! let alarms: Vec<usize> = (0..trace.len()).filter(is_alarm).collect();
//! assert_eq!(alarms, [5_523, 8_855]); // 3 ms and 5 ms after the ruptures
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # User-defined parts
//! Every role in the loop is a trait: [`Operator`](operator::Operator), [`Tissue`](tissue::Tissue),
//! [`Estimator`](estimation::Estimator), [`Detector`](detector::Detector), [`Distance`](detector::Distance),
//! [`ForceLaw`](augmentation::ForceLaw), [`MotionLaw`](augmentation::MotionLaw),
//! [`Architecture`](teleoperation::Architecture) and [`PassivityScheme`](teleoperation::PassivityScheme). A type that
//! implements one of them for `f64` runs in any scenario.
//! ```
//! use trocar::engine::UserDefinedParts;
//! use trocar::scenario::{Scenario, Source};
//! use trocar::tissue::{Reaction, Tissue};
//!
//! /// A spring with its rest position at 0.
//! struct Spring {
//!     stiffness_n_per_m: f64,
//! }
//!
//! impl Tissue<f64> for Spring {
//!     fn react(&mut self, _tick: u64, position_m: f64, _velocity_m_per_s: f64) -> Reaction<f64> {
//!         Reaction { force_n: self.stiffness_n_per_m * position_m.max(0.0), ruptured: false }
//!     }
//! }
//!
//! let scenario = Scenario::load(&Source::parse("paper/classical"), &[])?;
//! let parts = UserDefinedParts::default().tissue(Spring { stiffness_n_per_m: 200.0 });
//! let run = trocar::run::run_with(scenario, parts)?;
//! assert!(run.metrics.max_tissue_force_n.is_some_and(|force_n| force_n > 1.0));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # The layers
//! A package depends only on packages of a lower layer.
//!
//! | layer | package | modules |
//! |---|---|---|
//! | 8 | `trocar` | the command line, the page and its server |
//! | 7 | `trocar-report` | [`report`] (renders documents and draws figures; no lower layer prints) |
//! | 6 | `trocar-studies` | [`compare`], [`roc`], [`sweep`], [`design`](mod@design), [`stability_check`] (comparison of the linear analysis with simulations) |
//! | 5 | `trocar-run` | [`run`] (metrics and traces of scenarios; `trocar-studies` adds documents and warnings) |
//! | 5 | `trocar-detect` | [`detect`] (recordings: alarms, scores, calibration) |
//! | 5 | `trocar-figures` | [`figures`] (every figure as a description) |
//! | 5 | `trocar-stability` | [`stability`] (the linear loop, without the engine) |
//! | 3 | `trocar-identify` | [`identify`](mod@identify) (parameters of a machine from recordings of it) |
//! | 5 | `trocar-link` | the two sides of an insertion as two processes |
//! | 4 | `trocar-scenario` | [`scenario`] (TOML, validated, resolved and echoed), [`population`] (people, tissues and links drawn at random) |
//! | 4 | `trocar-metrics` | [`metrics`] (numbers that an observer takes from a run) |
//! | 3 | `trocar-engine` | [`engine`] (one tick, N ticks, observers), [`teleoperation`] (architectures, recovery, passivity), [`plant`], [`tissue`], [`operator`], [`channel`], [`sensor`] |
//! | 2 | `trocar-lti` | [`lti`] (polynomials, transfer functions, state space, exact holds, interconnection, responses) |
//! | 2 | `trocar-recording` | [`recording`] (recordings from files of several formats) |
//! | 1 | `trocar-document` | [`document`] (what a study says: verdict, tables, figures, data) |
//! | 1 | `trocar-base` | [`warning`], quantiles, work on several threads |
//! | core | `trocar-core` | [`rig`] (one step of a real controller), [`chain`] (estimator, distance, decision), [`augmentation`], [`detector`], [`estimation`], [`settings`], [`time`], [`lane`], [`error`] |

#![warn(missing_docs)]

pub use trocar_base::warning;
pub use trocar_core::{augmentation, chain, detector, error, estimation, lane, rig, settings, time};
pub use trocar_engine::{channel, engine, operator, plant, sensor, teleoperation, tissue};
pub use trocar_lti as lti;
pub use trocar_metrics as metrics;
pub use trocar_recording as recording;
#[cfg(not(feature = "studies"))]
pub use trocar_run as run;
pub use trocar_scenario as scenario;
pub use trocar_scenario::population;

#[cfg(feature = "studies")]
mod studies;
#[cfg(feature = "studies")]
pub use studies::*;

#[cfg(feature = "cli")]
mod cli;
#[cfg(feature = "cli")]
mod explore;

#[cfg(feature = "cli")]
#[doc(hidden)]
pub use cli::main;
