use std::io::{self, ErrorKind, IsTerminal, Write};

use super::error::Failure;
use trocar_document::Figure;
use trocar_report::sketch;

pub(super) fn print(text: &str) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    out.write_all(text.as_bytes()).and_then(|()| out.flush()).or_else(closed)
}

/// Draws a figure in dots if standard output is a terminal, with colours by `NO_COLOR` and the terminal.
pub(super) fn draw(figure: Option<&Figure<'_>>) -> Result<(), Failure> {
    let Some(figure) = figure.filter(|_| std::io::stdout().is_terminal()) else { return Ok(()) };
    writeln!(anstream::stdout().lock(), "{}", sketch(figure)).or_else(closed)
}

/// A closed reader such as `head` is not an error.
pub(super) fn closed(error: io::Error) -> Result<(), Failure> {
    if error.kind() == ErrorKind::BrokenPipe { Ok(()) } else { Err(failed(error)) }
}

pub(super) fn failed(error: io::Error) -> Failure {
    Failure::work(format!("cannot write to standard output: {error}"))
}
