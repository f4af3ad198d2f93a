//! Printing on standard output.

use std::io::{ErrorKind, Write};

use super::error::CliError;

/// Prints text. A reader that has gone away, as `head` does, is no error.
pub(super) fn print(text: &str) -> Result<(), CliError> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(CliError::Print(error)),
        _ => Ok(()),
    }
}
