//! Work side by side, on the threads of the pool.
//!
//! What goes over many pieces of work is compiled here, once, and not again for every kind of piece.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

use crate::interrupt;

/// Two pieces of work, side by side if this thread belongs to a pool. A thread of none calls none in: its threads would not survive a
/// fork of the process.
pub fn join_in_pool<A: Send, B: Send>(a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
    if rayon::current_thread_index().is_some() { rayon::join(a, b) } else { (a(), b()) }
}

/// The results of pieces of work with the numbers from 0, in the order of the numbers.
pub fn map<T: Send>(count: usize, work: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let results: Vec<Mutex<Option<T>>> = (0..count).map(|_| Mutex::new(None)).collect();
    each(count, &|index| {
        let result = work(index);
        *results[index].lock().unwrap_or_else(PoisonError::into_inner) = Some(result);
    });
    results.into_iter().filter_map(|result| result.into_inner().unwrap_or_else(PoisonError::into_inner)).collect()
}

/// As [`map`], for work that can fail.
///
/// # Errors
/// The first error in the order of the numbers. Work after it may be left undone.
pub fn try_map<T: Send, E: Send>(count: usize, work: impl Fn(usize) -> Result<T, E> + Sync) -> Result<Vec<T>, E> {
    let failed = AtomicUsize::new(usize::MAX);
    let results = map(count, |index| {
        (index < failed.load(Ordering::Relaxed)).then(|| {
            let result = work(index);
            if result.is_err() {
                failed.fetch_min(index, Ordering::Relaxed);
            }
            result
        })
    });
    // Before the first error, nothing is left out.
    results.into_iter().flatten().collect()
}

fn each(count: usize, work: &(dyn Fn(usize) + Sync)) {
    // Unwinding takes microseconds: work that has not begun is left out, and only what goes on is unwound.
    (0..count).into_par_iter().for_each(|index| {
        if !interrupt::is_requested() {
            work(index)
        }
    });
    interrupt::check();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_pieces_are_done_in_a_pool_and_out_of_one() {
        let both = || join_in_pool(|| 1, || 2);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("threads");
        assert_eq!((both(), pool.install(both)), ((1, 2), (1, 2)));
    }

    #[test]
    fn the_results_and_the_error_are_those_of_one_thread() {
        let squares = |limit: usize| try_map(1000, move |k| if k < limit { Ok(k * k) } else { Err(k) });
        assert_eq!(squares(1000), Ok((0..1000).map(|k| k * k).collect()));
        (0..20).for_each(|k| assert_eq!(squares(50 * k), Err(50 * k)));
        assert!(map(0, |k| k).is_empty());
    }
}
