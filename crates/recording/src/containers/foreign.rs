//! The boundary to libraries that may panic.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};
use std::sync::Once;

use super::Format;
use crate::error::Problem;

thread_local! {
    static IS_GUARDED: Cell<bool> = const { Cell::new(false) };
}

/// A panic becomes the error of a damaged file, and prints nothing.
///
/// State that a panic can leave inconsistent must not be used again: everything that the library opened is dropped.
pub(crate) fn guarded<T, E: From<Problem>>(format: Format, work: impl FnOnce() -> Result<T, E>) -> Result<T, E> {
    static QUIET_HOOK: Once = Once::new();
    QUIET_HOOK.call_once(|| {
        let usual = take_hook();
        set_hook(Box::new(move |info| {
            if !IS_GUARDED.with(Cell::get) {
                usual(info);
            }
        }));
    });
    let outer = IS_GUARDED.with(|guarded| guarded.replace(true));
    let outcome = catch_unwind(AssertUnwindSafe(work));
    IS_GUARDED.with(|guarded| guarded.set(outer));
    outcome.unwrap_or_else(|_| Err(format.damaged("its content contradicts itself").into()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_an_error_of_the_file() {
        let refused = guarded(Format::Parquet, || -> Result<(), Problem> { panic!("page 7") }).expect_err("refused");
        assert!(refused.to_string().starts_with("is a Parquet file that cannot be read: "), "{refused}");
        assert!(guarded(Format::Parquet, || Ok::<_, Problem>(3)).is_ok());
    }
}
