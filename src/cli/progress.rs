//! Progress on long work, on standard error and only where that is a terminal.

use indicatif::{ProgressBar, ProgressStyle};

/// A bar over many short pieces of work, with how many are done a second and the time left.
pub(super) fn rated_bar(pieces: usize, quiet: bool) -> ProgressBar {
    let bar = bar(pieces, quiet);
    if let Ok(style) = ProgressStyle::with_template("{msg} [{bar:30}] {pos}/{len} {per_sec} {eta} left") {
        bar.set_style(style.progress_chars("=> "));
    }
    bar
}

/// A bar over a number of scenarios, or none if there is little to wait for or silence is wanted.
pub(super) fn bar(scenarios: usize, quiet: bool) -> ProgressBar {
    if quiet || scenarios < 2 {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(scenarios as u64);
    if let Ok(style) = ProgressStyle::with_template("{msg} [{bar:30}] {pos}/{len} {eta}") {
        bar.set_style(style.progress_chars("=> "));
    }
    bar
}
