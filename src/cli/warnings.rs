use std::cell::Cell;
use std::io::Write;

use super::OutputArgs;
use super::error::Failure;
use trocar_base::warning::Warning;
use trocar_document::counted;
use trocar_report::{WIDTH, filled};

pub(super) struct Warnings {
    is_quiet: bool,
    are_errors: bool,
    count: Cell<usize>,
}

impl Warnings {
    pub(super) fn new(output: &OutputArgs) -> Self {
        Self { is_quiet: output.quiet, are_errors: output.deny_warnings, count: Cell::new(0) }
    }

    pub(super) fn print(&self, warnings: &[Warning]) {
        self.count.set(self.count.get() + warnings.len());
        if !self.is_quiet {
            for warning in warnings {
                // Ignores a closed standard error.
                let _ = write!(anstream::stderr(), "{}", text(warning));
            }
        }
    }

    /// Ends the command.
    pub(super) fn finish(&self) -> Result<(), Failure> {
        match self.count.get() {
            count if self.are_errors && count > 0 => {
                let counted = counted(count as u64, "warning");
                Err(Failure::work(format!("{counted}, and --deny-warnings makes them errors")))
            }
            _ => Ok(()),
        }
    }
}

pub(super) fn text(warning: &Warning) -> String {
    let style = emphasis();
    let head = format!("warning[{}]: {warning}", warning.code.word());
    let mut lines = filled(&head, WIDTH, 2);
    if let Some(first) = lines.first_mut() {
        *first = first.replacen("warning", &format!("{style}warning{style:#}"), 1);
    }
    if let Some(remedy) = &warning.remedy {
        lines.extend(
            filled(&format!("help: {remedy}"), WIDTH - 2, 4)
                .into_iter()
                .enumerate()
                .map(|(index, line)| if index == 0 { format!("  {line}") } else { line }),
        );
    }
    lines.join("\n") + "\n"
}

fn emphasis() -> clap::builder::styling::Style {
    use clap::builder::styling::{AnsiColor, Style};
    Style::new().bold().fg_color(Some(AnsiColor::Yellow.into()))
}
