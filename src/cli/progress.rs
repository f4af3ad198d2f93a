//! Progress on long work, on standard error and only where that is a terminal.

use indicatif::{ProgressBar, ProgressStyle};

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
