//! Printing on standard output.

use std::io::{ErrorKind, IsTerminal, Write};

use super::error::CliError;

/// Prints text. A reader that has gone away, as `head` does, is no error.
pub(super) fn print(text: &str) -> Result<(), CliError> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(CliError::Print(error)),
        _ => Ok(()),
    }
}

/// Draws a picture where somebody sees it: standard output is a terminal. Its colours follow NO_COLOR and what the terminal
/// can do.
pub(super) fn draw(picture: impl FnOnce() -> Option<String>) -> Result<(), CliError> {
    if !std::io::stdout().is_terminal() {
        return Ok(());
    }
    let Some(text) = picture() else { return Ok(()) };
    match writeln!(anstream::stdout().lock(), "{text}") {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(CliError::Print(error)),
        _ => Ok(()),
    }
}
