//! Ctrl-C during long work: the first one ends it in good order, the second one at once.

use std::sync::atomic::{AtomicBool, Ordering};

static STOP: AtomicBool = AtomicBool::new(false);

/// What the exit code of an interrupted command is by custom: 128 and the number of the signal.
pub(super) const EXIT_CODE: u8 = 130;

/// Listens from now on; gives what is set once Ctrl-C was pressed. Where nothing can listen, Ctrl-C ends the program as ever.
pub(super) fn listen() -> &'static AtomicBool {
    let heard = || {
        if STOP.swap(true, Ordering::Relaxed) {
            std::process::exit(i32::from(EXIT_CODE));
        }
    };
    let _ = ctrlc::set_handler(heard);
    &STOP
}
