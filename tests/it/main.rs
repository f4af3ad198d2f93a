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
mod figures;
mod fmu;
#[cfg(unix)]
mod fmu_import;
mod instruction_sets;
mod intent;
mod keys;
mod lab_files;
mod lanes;
mod layer_ranges;
mod layers_paper;
mod link_delays;
mod link_parts;
mod link_random;
mod link_schedule;
mod link_sides;
mod lti;
mod metrics;
mod one_loop;
mod operators;
mod oracle_trajectories;
mod other_blas;
mod own_parts;
mod packs;
mod paper;
mod passive;
mod passivity;
mod population;
mod properties;
mod recording;
mod report;
mod rig;
mod roc;
mod stability;
mod support;
mod sweep;
mod switching;
mod tearing;
mod terminal;
mod tissue;
mod varying_delays;
mod warnings;
