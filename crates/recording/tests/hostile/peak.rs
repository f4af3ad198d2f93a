//! The largest memory that a thread allocates at a time. The readers use one thread.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

struct Counting;

thread_local! {
    /// Bytes in use, and their maximum. A thread can free what another one has allocated.
    static NOW: Cell<isize> = const { Cell::new(0) };
    static PEAK: Cell<isize> = const { Cell::new(0) };
}

fn add(size: isize) {
    let now = NOW.get() + size;
    NOW.set(now);
    PEAK.set(PEAK.get().max(now));
}

#[allow(unsafe_code, reason = "an allocator is unsafe by its trait")]
// SAFETY: every request is passed unchanged to the system allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        add(layout.size() as isize);
        // SAFETY: the caller keeps the contract of `alloc`.
        unsafe { System.alloc(layout) }
    }
    unsafe fn realloc(&self, old: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // The system moves large blocks without a copy.
        add(-(layout.size() as isize));
        add(size as isize);
        // SAFETY: the caller keeps the contract of `realloc`; `old` comes from the same allocator.
        unsafe { System.realloc(old, layout, size) }
    }
    unsafe fn dealloc(&self, old: *mut u8, layout: Layout) {
        add(-(layout.size() as isize));
        // SAFETY: the caller keeps the contract of `dealloc`; `old` comes from the same allocator.
        unsafe { System.dealloc(old, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// The memory in bytes that a function needs at most at a time, besides that in use before, and its answer.
pub(crate) fn of<T>(work: impl FnOnce() -> T) -> (usize, T) {
    let before = NOW.get();
    PEAK.set(before);
    let answer = work();
    ((PEAK.get() - before).unsigned_abs(), answer)
}

#[test]
fn memory_is_counted() {
    let (peak, _) = of(|| vec![0_u8; 1 << 20]);
    assert!(peak >= 1 << 20);
}
