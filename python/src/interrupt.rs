//! Long computations that Ctrl-C ends.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::time::Duration;

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

/// How often signals are looked for.
const PERIOD: Duration = Duration::from_millis(40);

/// Does work on a thread and processors of its own, with the interpreter's lock released, and looks for signals meanwhile.
///
/// On one, as on Ctrl-C, `stop` is set and the exception raised at once. Work that does not look at `stop` goes on unseen to its
/// end, and its outcome is dropped. The work has a pool of threads of its own, so that it also runs in a forked process,
/// where a shared pool's threads are gone.
pub(crate) fn interruptible<T: Send + 'static>(
    py: Python<'_>,
    threads: usize,
    work: impl FnOnce(&AtomicBool) -> T + Send + 'static,
) -> PyResult<T> {
    let stop = Arc::new(AtomicBool::new(false));
    let (send, receive) = sync_channel(1);
    let seen = stop.clone();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().map_err(failed)?;
    let thread = move || {
        // Whoever waited may have gone.
        let _ = send.send(pool.install(|| work(&seen)));
    };
    std::thread::Builder::new().name("trocar".into()).spawn(thread).map_err(failed)?;
    py.detach(move || {
        loop {
            match receive.recv_timeout(PERIOD) {
                Ok(outcome) => return Ok(outcome),
                Err(RecvTimeoutError::Disconnected) => {
                    return Err(failed("the computation broke off; please report it"));
                }
                Err(RecvTimeoutError::Timeout) => {
                    Python::attach(|py| py.check_signals()).inspect_err(|_| stop.store(true, Ordering::Relaxed))?
                }
            }
        }
    })
}

fn failed(reason: impl ToString) -> PyErr {
    PyRuntimeError::new_err(reason.to_string())
}
