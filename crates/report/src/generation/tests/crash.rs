//! Ends the process, in the imagination of a test, at one of its operations on the file system.

use std::cell::{Cell, RefCell};
use std::io;
use std::path::Path;

thread_local! {
    /// Number of operations until the end; `None` for none.
    static LEFT: Cell<Option<usize>> = const { Cell::new(None) };
    static IS_CRASHED: Cell<bool> = const { Cell::new(false) };
    static DONE: RefCell<Vec<String>> = const { RefCell::new(vec![]) };
}

/// Called before each operation. From the end on, every operation fails.
pub(in crate::generation) fn point(name: &str, path: &Path) -> io::Result<()> {
    IS_CRASHED.set(is_crashed() || LEFT.get() == Some(0));
    if is_crashed() {
        return Err(io::Error::other("the process has ended"));
    }
    LEFT.set(LEFT.get().map(|left| left - 1));
    let file = path.file_name().unwrap_or_default().to_string_lossy();
    DONE.with_borrow_mut(|done| done.push(format!("{name} {file}")));
    Ok(())
}

pub(in crate::generation) fn is_crashed() -> bool {
    IS_CRASHED.get()
}

/// Performs work that ends after some operations. Returns the operations, and true if it came to its own end.
pub(super) fn ended_after(operations: Option<usize>, work: impl FnOnce()) -> (Vec<String>, bool) {
    DONE.take();
    LEFT.set(operations);
    work();
    LEFT.set(None);
    (DONE.take(), !IS_CRASHED.take())
}
