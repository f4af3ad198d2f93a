//! Long computations that Ctrl-C can interrupt.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::time::Duration;

use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use trocar_base::interrupt;

/// Interval of the checks for signals.
const PERIOD: Duration = Duration::from_millis(20);

const MAX_THREADS: usize = 1024;

/// Runs work on a separate thread without the interpreter's lock, and checks for signals.
///
/// A signal such as Ctrl-C sets `stop` and raises the exception at once; the work ends at its next check. It has its
/// own thread pool, because the threads of a shared pool do not exist in a forked process.
pub(crate) fn interruptible<T: Send + 'static>(
    py: Python<'_>,
    threads: usize,
    work: impl FnOnce(&AtomicBool) -> T + Send + 'static,
) -> PyResult<T> {
    interruptible_with_progress(py, threads, |_| Ok(()), work)
}

/// Runs work like [`interruptible`] and calls `tell` with the number that the work counts, at each check and at the end.
pub(crate) fn interruptible_with_count<T: Send + 'static>(
    py: Python<'_>,
    threads: usize,
    tell: impl Fn(Python<'_>, u64) -> PyResult<()> + Send + Sync,
    work: impl FnOnce(&AtomicU64) -> T + Send + 'static,
) -> PyResult<T> {
    let done = Arc::new(AtomicU64::new(0));
    let counted = done.clone();
    let tell_done = |py: Python<'_>| tell(py, done.load(Ordering::Relaxed));
    let result = interruptible_with_progress(py, threads, tell_done, move |_| work(&counted))?;
    tell_done(py)?;
    Ok(result)
}

/// Runs work like [`interruptible`] and calls `tell` at each check. An exception of `tell` ends the work like a
/// signal.
pub(crate) fn interruptible_with_progress<T: Send + 'static>(
    py: Python<'_>,
    threads: usize,
    tell: impl Fn(Python<'_>) -> PyResult<()> + Send,
    work: impl FnOnce(&AtomicBool) -> T + Send + 'static,
) -> PyResult<T> {
    if threads > MAX_THREADS {
        return Err(PyValueError::new_err(format!("threads = {threads}, must be at most {MAX_THREADS}")));
    }
    let stop = Arc::new(AtomicBool::new(false));
    let (send, receive) = sync_channel(1);
    let stop_flag = stop.clone();
    let watched = stop.clone();
    let builder = rayon::ThreadPoolBuilder::new().num_threads(threads);
    let pool = builder.start_handler(move |_| interrupt::watch(watched.clone())).build().map_err(failed)?;
    let thread = move || {
        if let Ok(outcome) = interrupt::catch(|| pool.install(|| work(&stop_flag))) {
            // The receiver may be closed.
            let _ = send.send(outcome);
        }
    };
    std::thread::Builder::new().name("trocar".into()).spawn(thread).map_err(failed)?;
    py.detach(move || {
        loop {
            match receive.recv_timeout(PERIOD) {
                Ok(outcome) => return Ok(outcome),
                Err(RecvTimeoutError::Disconnected) => {
                    return Err(failed("the computation failed unexpectedly; please report this error"));
                }
                Err(RecvTimeoutError::Timeout) => {
                    let check = |py: Python<'_>| py.check_signals().and_then(|()| tell(py));
                    Python::attach(check).inspect_err(|_| stop.store(true, Ordering::Relaxed))?
                }
            }
        }
    })
}

fn failed(reason: impl ToString) -> PyErr {
    PyRuntimeError::new_err(reason.to_string())
}
