pub fn join_in_pool<A: Send, B: Send>(a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
    (a(), b())
}

pub(crate) fn for_each(count: usize, work: impl Fn(usize) + Sync + Send) {
    (0..count).for_each(work);
}
