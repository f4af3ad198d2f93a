//! Cooperative cancellation: once a thread's flag ([`watch`]) is set, [`check`] unwinds to [`catch`].

use std::any::Any;
use std::cell::RefCell;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

thread_local! {
    static STOP: RefCell<Option<Arc<AtomicBool>>> = const { RefCell::new(None) };
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Interrupted;

const STEPS: u64 = 4096;

/// Cancels work on this thread once the flag is set.
pub fn watch(stop: Arc<AtomicBool>) {
    STOP.set(Some(stop));
}

#[inline(always)]
pub fn check_at(step: u64) {
    if step.is_multiple_of(STEPS) {
        check();
    }
}

#[inline(never)]
pub fn check() {
    if is_requested() {
        // Not a panic, so no panic message.
        resume_unwind(Box::new(Interrupted));
    }
}

pub(crate) fn is_requested() -> bool {
    STOP.with_borrow(|stop| stop.as_ref().is_some_and(|stop| stop.load(Ordering::Relaxed)))
}

pub fn catch<T>(work: impl FnOnce() -> T) -> Result<T, Interrupted> {
    catch_unwind(AssertUnwindSafe(work)).map_err(|payload: Box<dyn Any + Send>| {
        match payload.downcast::<Interrupted>() {
            Ok(interrupted) => *interrupted,
            Err(panic) => resume_unwind(panic),
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_is_cancelled_once_its_flag_is_set() {
        let stop = Arc::new(AtomicBool::new(false));
        let flag = stop.clone();
        let work = std::thread::spawn(move || {
            watch(stop);
            catch(|| {
                loop {
                    check();
                }
            })
        });
        flag.store(true, Ordering::Relaxed);
        let ended: Result<(), Interrupted> = work.join().expect("no panic");
        assert_eq!(ended, Err(Interrupted));
        assert_eq!(catch(|| 3), Ok(3));
        check();
    }

    #[test]
    fn a_panic_is_not_a_cancellation() {
        let outcome = std::thread::spawn(|| catch(|| resume_unwind(Box::new("a fault")))).join();
        let payload = outcome.map(|_: Result<(), _>| ()).expect_err("panics");
        assert_eq!(payload.downcast_ref::<&str>(), Some(&"a fault"));
    }
}
