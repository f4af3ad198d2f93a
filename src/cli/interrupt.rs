//! Ctrl-C during long work: the first one ends it in good order, the second one at once.

use std::sync::atomic::{AtomicBool, Ordering};

static STOP: AtomicBool = AtomicBool::new(false);

/// What the exit code of an interrupted command is by custom: 128 and the number of the signal.
pub(super) const EXIT_CODE: u8 = 130;

/// Calls `stop` at the first Ctrl-C (or SIGTERM, or SIGHUP); a second one ends the process at once.
///
/// # Errors
/// Where nothing can listen: then Ctrl-C ends the program as ever.
pub(super) fn on_first(stop: impl Fn() + Send + 'static) -> Result<(), ctrlc::Error> {
    let heard = AtomicBool::new(false);
    ctrlc::set_handler(move || {
        if heard.swap(true, Ordering::SeqCst) {
            std::process::exit(i32::from(EXIT_CODE));
        }
        stop();
    })
}

/// Listens from now on; gives what is set once Ctrl-C was pressed. Where nothing can listen, Ctrl-C ends the program as ever.
pub(super) fn listen() -> &'static AtomicBool {
    let _ = on_first(|| STOP.store(true, Ordering::Relaxed));
    &STOP
}
