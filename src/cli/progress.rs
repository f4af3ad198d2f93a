//! Progress on long work, on standard error and only where that is a terminal.

use indicatif::{ProgressBar, ProgressStyle};

/// A bar over many short pieces of work, with how many are done a second and the time left.
pub(super) fn rated_bar(pieces: usize, quiet: bool) -> ProgressBar {
    styled(pieces, quiet, "{msg} [{bar:30}] {pos}/{len} {per_sec} {eta} left")
}

/// A bar over a number of scenarios, or none if there is little to wait for or silence is wanted.
pub(super) fn bar(scenarios: usize, quiet: bool) -> ProgressBar {
    styled(scenarios, quiet, "{msg} [{bar:30}] {pos}/{len} {eta}")
}

fn styled(pieces: usize, quiet: bool, template: &str) -> ProgressBar {
    if quiet || pieces < 2 {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(pieces as u64);
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style.progress_chars("=> "));
    }
    bar
}
