use indicatif::{ProgressBar, ProgressStyle};
use std::time::Duration;

pub(super) fn rated_bar(items: usize, quiet: bool) -> ProgressBar {
    styled(items, quiet, "{msg} [{bar:30}] {pos}/{len} {per_sec} {eta} left")
}

pub(super) fn bar(scenarios: usize, quiet: bool) -> ProgressBar {
    styled(scenarios, quiet, "{msg} [{bar:30}] {pos}/{len} {eta}")
}

pub(super) fn counter(quiet: bool) -> ProgressBar {
    if quiet {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new_spinner();
    if let Ok(style) = ProgressStyle::with_template("{msg} {pos} {per_sec}") {
        bar.set_style(style);
    }
    bar
}

/// For work whose length is unknown.
pub(super) fn elapsed(work: &'static str, quiet: bool) -> ProgressBar {
    if quiet {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new_spinner().with_message(work);
    if let Ok(style) = ProgressStyle::with_template("{spinner} {msg} {elapsed}") {
        bar.set_style(style);
    }
    bar.enable_steady_tick(Duration::from_millis(100));
    bar
}

fn styled(items: usize, quiet: bool, template: &str) -> ProgressBar {
    if quiet || items < 2 {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(items as u64);
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style.progress_chars("=> "));
    }
    bar
}
