use std::io::{ErrorKind, IsTerminal, Write};

use super::error::CliError;
use trocar_document::Figure;
use trocar_report::sketch;

/// A closed reader such as `head` is not an error.
pub(super) fn print(text: &str) -> Result<(), CliError> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(CliError::Print(error)),
        _ => Ok(()),
    }
}

/// Draws a figure in dots if standard output is a terminal, with colours by `NO_COLOR` and the terminal.
pub(super) fn draw(figure: Option<&Figure<'_>>) -> Result<(), CliError> {
    let Some(figure) = figure.filter(|_| std::io::stdout().is_terminal()) else { return Ok(()) };
    match writeln!(anstream::stdout().lock(), "{}", sketch(figure)) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(CliError::Print(error)),
        _ => Ok(()),
    }
}
