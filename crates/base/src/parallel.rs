//! The iteration is compiled here once, not again for every type of work.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use crate::interrupt;
use crate::threads::for_each;
pub use crate::threads::join_in_pool;

/// In the order of the indices.
pub fn map<T: Send>(count: usize, work: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let results: Vec<Mutex<Option<T>>> = (0..count).map(|_| Mutex::new(None)).collect();
    each(count, &|index| {
        let result = work(index);
        *results[index].lock().unwrap_or_else(PoisonError::into_inner) = Some(result);
    });
    results.into_iter().filter_map(|result| result.into_inner().unwrap_or_else(PoisonError::into_inner)).collect()
}

/// `None` if `stop` was set and work was skipped.
pub fn map_unless<T: Send>(stop: &AtomicBool, count: usize, work: impl Fn(usize) -> T + Sync) -> Option<Vec<T>> {
    map(count, |index| (!stop.load(Ordering::Relaxed)).then(|| work(index))).into_iter().collect()
}

/// The first error in the order of the indices; later work may be skipped.
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
    results.into_iter().flatten().collect()
}

fn each(count: usize, work: &(dyn Fn(usize) + Sync)) {
    // Unwinding takes microseconds: skip work that has not begun.
    for_each(count, |index| {
        if !interrupt::is_requested() {
            work(index)
        }
    });
    interrupt::check();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(feature = "parallel")]
    #[test]
    fn two_pieces_of_work_run_inside_and_outside_a_pool() {
        let both = || join_in_pool(|| 1, || 2);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("threads");
        assert_eq!((both(), pool.install(both)), ((1, 2), (1, 2)));
    }

    #[test]
    fn results_and_errors_do_not_depend_on_the_number_of_threads() {
        let squares = |limit: usize| try_map(1000, move |k| if k < limit { Ok(k * k) } else { Err(k) });
        assert_eq!(squares(1000), Ok((0..1000).map(|k| k * k).collect()));
        (0..20).for_each(|k| assert_eq!(squares(50 * k), Err(50 * k)));
        assert!(map(0, |k| k).is_empty());
        let stop = AtomicBool::new(false);
        assert_eq!(map_unless(&stop, 3, |k| k), Some(vec![0, 1, 2]));
        stop.store(true, Ordering::Relaxed);
        assert_eq!(map_unless(&stop, 3, |k| k), None);
    }
}
