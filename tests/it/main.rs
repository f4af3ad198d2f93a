//! All tests of the public interface in one program, with a module per subject.

mod actuators;
mod appendix_poles;
mod architectures;
#[cfg(unix)]
mod book;
mod calibration;
mod cli;
mod degenerate;
#[cfg(unix)]
mod detect_live;
mod detect_many;
mod detect_real;
mod estimators;
mod explore;
mod instruction_sets;
mod lanes;
mod layer_ranges;
mod layering;
mod layers_paper;
mod link;
mod link_parts;
mod link_random;
mod link_schedule;
mod linking;
mod lti;
mod metrics;
mod openness;
mod operators;
mod oracle_trajectories;
mod own_parts;
mod packs;
mod paper;
mod passivity;
mod properties;
mod public_api;
mod recording;
mod report;
mod rig;
mod roc;
mod stability;
mod support;
mod sweep;
mod switching;
mod terminal;
mod tissue;
mod warnings;
