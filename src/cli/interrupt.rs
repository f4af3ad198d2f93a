//! Handles Ctrl-C: the first one stops the work and keeps its results, the second one ends the process.

use std::sync::atomic::{AtomicBool, Ordering};

static STOP: AtomicBool = AtomicBool::new(false);

/// Exit code of an interrupted command: 128 plus the number of the signal.
pub(super) const EXIT_CODE: u8 = 130;

/// Calls `stop` at the first Ctrl-C, SIGTERM or SIGHUP; a second one ends the process.
pub(super) fn on_first(stop: impl Fn() + Send + 'static) -> Result<(), ctrlc::Error> {
    let is_second = AtomicBool::new(false);
    ctrlc::set_handler(move || {
        if is_second.swap(true, Ordering::SeqCst) {
            std::process::exit(i32::from(EXIT_CODE));
        }
        stop();
    })
}

/// A flag that the first Ctrl-C sets. Without a handler, Ctrl-C ends the process at once.
pub(super) fn stop_flag() -> &'static AtomicBool {
    let _ = on_first(|| STOP.store(true, Ordering::Relaxed));
    &STOP
}
