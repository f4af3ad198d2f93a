//! Two pieces of work on the threads that there are.

/// Two pieces of work, side by side if this thread belongs to a pool. A thread of none calls none in: its threads would not survive a
/// fork of the process.
pub fn join_in_pool<A: Send, B: Send>(a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
    if rayon::current_thread_index().is_some() { rayon::join(a, b) } else { (a(), b()) }
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
}
