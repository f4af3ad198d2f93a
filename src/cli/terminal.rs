//! Prints on standard output.

use std::io::{ErrorKind, IsTerminal, Write};

use super::error::CliError;

/// Prints text. A closed reader, such as `head`, is not an error.
pub(super) fn print(text: &str) -> Result<(), CliError> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(CliError::Print(error)),
        _ => Ok(()),
    }
}

/// Prints a chart if standard output is a terminal. The colours depend on NO_COLOR and on the terminal.
pub(super) fn draw(chart: impl FnOnce() -> Option<String>) -> Result<(), CliError> {
    if !std::io::stdout().is_terminal() {
        return Ok(());
    }
    let Some(text) = chart() else { return Ok(()) };
    match writeln!(anstream::stdout().lock(), "{text}") {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(CliError::Print(error)),
        _ => Ok(()),
    }
}
