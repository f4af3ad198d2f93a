//! The work of [`parallel`](crate::parallel) on the calling thread, in a build without the feature `parallel`.

/// Runs two pieces of work one after the other.
pub fn join_in_pool<A: Send, B: Send>(a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
    (a(), b())
}

/// Runs work for the indices from 0 to `count`.
pub(crate) fn for_each(count: usize, work: impl Fn(usize) + Sync + Send) {
    (0..count).for_each(work);
}
