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
//! | 7 | [`cli`], [`report`] |
//! | 6 | [`compare`] |
//! | 5 | [`scenario`], [`metrics`] |
//! | 4 | [`engine`] |
//! | 3 | [`augmentation`] |
//! | 2 | [`plant`], [`tissue`], [`operator`], [`channel`], [`sensor`], [`estimation`], [`detection`], [`recording`] |
//! | 1 | [`lti`] |
//! | 0 | [`time`], [`lane`], [`error`] |

pub mod augmentation;
pub mod channel;
pub mod cli;
pub mod compare;
pub mod detect;
pub mod detection;
pub mod engine;
pub mod error;
pub mod estimation;
pub mod lane;
pub mod lti;
pub mod metrics;
pub mod operator;
pub mod plant;
pub mod recording;
pub mod report;
pub mod run;
pub mod scenario;
pub mod sensor;
pub mod time;
pub mod tissue;
