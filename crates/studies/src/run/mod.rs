mod document;
mod limits;
mod promise;
mod reach;
mod trace_table;
mod views;
mod warnings;

pub use trocar_run::{
    PACK, Reach, Run, RunError, SteppedRun, can_share, empty_trace, empty_trace_with, measure, observe, observe_with,
    run, run_pack, run_pack_in, run_pack_sharing, run_with,
};

pub(crate) use document::{REDUCED, about, state, windows};
pub use document::{RunFile, add_figures, outcome};
pub use promise::promise_gaps;
pub use trace_table::trace_table;
pub use views::event_shade;
pub use warnings::{delays_rounded, foreseen, outside_measured, seeds_without_effect};

#[derive(Debug, Clone, Copy)]
pub struct RunReport<'a> {
    run: &'a Run,
}

impl<'a> RunReport<'a> {
    pub fn of(run: &'a Run) -> Self {
        Self { run }
    }
}
