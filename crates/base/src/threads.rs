use rayon::prelude::*;

/// Starts no threads outside a pool: they would not survive a fork.
pub fn join_in_pool<A: Send, B: Send>(a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
    if rayon::current_thread_index().is_some() { rayon::join(a, b) } else { (a(), b()) }
}

pub(crate) fn for_each(count: usize, work: impl Fn(usize) + Sync + Send) {
    (0..count).into_par_iter().for_each(work);
}
