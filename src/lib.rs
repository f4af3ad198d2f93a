//! Bilateral teleoperation of needle insertions, with event-based haptic augmentation.
//!
//! An operator moves a master, a slave drives a needle, and the tissue force is fed back to the operator. When a layer ruptures,
//! the needle overshoots. trocar estimates the tissue online, detects the rupture, freezes the slave and amplifies the drop of the
//! felt force, after Barbé, Bayle, de Mathelin and Gangi, *In Vivo Model Estimation and Haptic Characterization of Needle
//! Insertions*. Equation numbers in this documentation refer to that paper.
//!
//! # Signs and units
//! All quantities are in SI units: m, m/s, N, s. Positions increase into the tissue. Forces are positive when they resist
//! insertion (the paper plots the opposite sign). The force of the operator on the master is positive in the direction of insertion.
//!
//! # Modules
//! A module depends only on modules of the same or a lower layer. `tests/it/layering.rs` checks this.
//!
//! | layer | modules |
//! |---|---|
//! | 7 | [`cli`], [`report`] (tables, CSV, JSON, figures; no other layer draws or prints), [`explore`] (the page and its server) |
//! | 6 | [`run`], [`compare`], [`detect`], [`roc`], [`sweep`], [`stability_check`] (comparison of the linear analysis with simulations) |
//! | 5 | [`scenario`] (TOML, validated, resolved and echoed), [`metrics`] (numbers from observers), [`stability`] (the linear loop, without the engine) |
//! | 4 | [`engine`] (one tick, N ticks, observers), [`rig`] (one step of a real controller) |
//! | 3 | [`augmentation`] (automaton, force law, re-engagement), [`teleoperation`] (architectures, recovery, passivity) |
//! | 2 | [`plant`], [`tissue`], [`operator`], [`channel`], [`sensor`], [`estimation`], [`detection`], [`recording`]: siblings never import each other |
//! | 1 | [`lti`] (polynomials, transfer functions, state space, exact holds, interconnection, responses) |
//! | 0 | [`time`], [`lane`], [`error`] |
//!
//! The package `trocar-core` contains [`rig`] and its parts ([`augmentation`], [`detection`], [`estimation`], [`time`], [`lane`],
//! [`error`]). It is `no_std` and does not allocate, for controllers without an operating system.
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
pub use trocar_sim::{augmentation, chain, detection, error, estimation, lane, rig, settings, time};
pub use trocar_sim::{
    channel, compare, detect, engine, lti, metrics, operator, plant, recording, roc, run, scenario, sensor, stability,
    stability_check, sweep, teleoperation, tissue,
};

pub mod cli;
pub mod explore;

/// Runs the Rust examples of the README as tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
