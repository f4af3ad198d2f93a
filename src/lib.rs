//! Bilateral teleoperation of needle insertions, with event-based haptic augmentation.
//!
//! A person pushes a master; a slave pushes a needle; the tissue's force comes back. When a membrane gives way the
//! needle lurches. trocar estimates the tissue online, detects the rupture, freezes the slave and exaggerates the felt
//! force drop, after Barbé, Bayle, de Mathelin and Gangi, *In Vivo Model Estimation and Haptic Characterization of
//! Needle Insertions*. Equation numbers in these pages are that paper's.
//!
//! # Signs and units
//! SI throughout: m, m/s, N, s. Positions grow into the tissue. Forces are positive when they resist insertion (the
//! paper plots the opposite sign). The force of the hand on the master is positive when it pushes in.
//!
//! # The house
//! Lower floors know nothing of the higher ones; `tests/layering.rs` keeps it so.
//!
//! | floor | rooms |
//! |---|---|
//! | 7 | [`cli`], [`report`] (tables, CSV, JSON, figures: only this floor draws or prints), [`explore`] (the page and its server) |
//! | 6 | [`run`], [`compare`], [`detect`], [`roc`], [`sweep`], [`stability_check`] (the linear verdicts against the engine) |
//! | 5 | [`scenario`] (TOML → validated, resolved, echoed), [`metrics`] (observers → numbers), [`stability`] (the linearised loop; never the engine) |
//! | 4 | [`engine`] (one tick, N ticks, observers), [`rig`] (one step of a real controller) |
//! | 3 | [`augmentation`] (automaton, force law, re-engagement), [`teleoperation`] (architectures, recovery, passivity) |
//! | 2 | [`plant`], [`tissue`], [`operator`], [`channel`], [`sensor`], [`estimation`], [`detection`], [`recording`]: siblings never import each other |
//! | 1 | [`lti`] (polynomials, transfer functions, state space, exact holds, interconnection, responses) |
//! | 0 | [`time`], [`lane`], [`error`] |
//!
//! Without the default feature `std` there are [`rig`] and what it is made of ([`augmentation`], [`detection`],
//! [`estimation`], [`time`], [`lane`], [`error`]), the same source, for machines that have neither an operating system nor
//! an allocator.
//!
//! # A run in Rust
//! ```
//! use trocar::scenario::{Scenario, Source};
//!
//! let source = Source::Builtin("augmented.toml".into());
//! let scenario = Scenario::load(&source, &["scaling.force=0.8".into()])?;
//! let run = trocar::run::run(scenario)?;
//! let first = &run.metrics.ruptures[0];
//! assert!(first.detection_delay_s.is_some_and(|delay| delay < 0.010));
//! assert!(first.slave_overshoot_m.is_some_and(|overshoot| overshoot < 1e-4));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub use trocar_report as report;
pub use trocar_sim::{augmentation, detection, error, estimation, lane, rig, settings, time};
pub use trocar_sim::{
    channel, compare, detect, engine, lti, metrics, operator, plant, recording, roc, run, scenario, sensor, stability,
    stability_check, sweep, teleoperation, tissue,
};

pub mod cli;
pub mod explore;

/// The README's Rust runs as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
