//! Ctrl-C, SIGTERM and SIGHUP.
//!
//! The first one asks a command that can stop early ([`on_first`]) to stop and keep its results. Any other command ends
//! at once, and so does every command at the second one: unfinished files are removed, former results stay.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, Once, PoisonError};
use std::time::Duration;

use trocar_report::discard_all;

/// 128 plus the number of the signal.
pub(super) const EXIT_CODE: u8 = 130;

static STOP: AtomicBool = AtomicBool::new(false);

/// True once the process ends because of a signal.
static ENDS: AtomicBool = AtomicBool::new(false);

type Stop = Box<dyn Fn() + Send>;

static ON_FIRST: Mutex<Option<Stop>> = Mutex::new(None);

/// Not under `nohup`, whose SIGHUP the handler would not ignore.
pub(super) fn begin() {
    if !ignores_hangup() {
        install();
    }
}

/// True if the parent process, such as `nohup`, ignores SIGHUP. Known on Linux only.
fn ignores_hangup() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    ignored.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).is_some_and(|mask| mask & 1 == 1)
}

/// Without the handler a signal ends the process without a message.
fn install() {
    static INSTALLED: Once = Once::new();
    INSTALLED.call_once(|| {
        let was_asked = AtomicBool::new(false);
        let _ = ctrlc::set_handler(move || {
            let stop = ON_FIRST.lock().unwrap_or_else(PoisonError::into_inner);
            match &*stop {
                Some(stop) if !was_asked.swap(true, Ordering::SeqCst) => stop(),
                _ => end(),
            }
        });
    });
}

fn end() -> ! {
    ENDS.store(true, Ordering::SeqCst);
    let kept = if discard_all() { ": unfinished results were removed, former ones are unchanged" } else { "" };
    anstream::eprintln!("error: interrupted{kept}");
    std::process::exit(i32::from(EXIT_CODE));
}

/// Waits if a signal has ended the process. The failures that this causes are not reported.
pub(super) fn wait_for_end() {
    while ENDS.load(Ordering::SeqCst) {
        std::thread::sleep(Duration::from_millis(10));
    }
}

/// Calls `stop` at the first signal, instead of ending the process.
pub(super) fn on_first(stop: impl Fn() + Send + 'static) {
    *ON_FIRST.lock().unwrap_or_else(PoisonError::into_inner) = Some(Box::new(stop));
    install();
}

/// Set by the first signal, instead of ending the process.
pub(super) fn stop_flag() -> &'static AtomicBool {
    on_first(|| STOP.store(true, Ordering::Relaxed));
    &STOP
}
