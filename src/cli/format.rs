//! The formats of files of columns.

use std::io::Write;

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};

use super::error::CliError;
use trocar_report::{ColumnFormat, Folder};

/// The formats of the files with a row per sample.
#[derive(Debug, Args)]
pub(super) struct FormatArgs {
    /// Formats of the file with a row per sample, separated by commas; mat is MATLAB, mcap a log for Foxglove and
    /// PlotJuggler
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_value = "csv", value_parser = parser())]
    format: Vec<ColumnFormat>,
}

impl Default for FormatArgs {
    fn default() -> Self {
        Self { format: vec![ColumnFormat::Csv] }
    }
}

fn parser() -> impl TypedValueParser<Value = ColumnFormat> {
    let of = |word: String| ColumnFormat::ALL.into_iter().find(|format| format.word() == word);
    PossibleValuesParser::new(ColumnFormat::ALL.map(ColumnFormat::word))
        .try_map(move |word| of(word).ok_or("no format"))
}

impl FormatArgs {
    /// Writes a file per format.
    pub(super) fn write(
        &self,
        folder: &Folder,
        stem: &str,
        write: impl Fn(ColumnFormat, &mut (dyn Write + Send)) -> std::io::Result<()>,
    ) -> Result<(), CliError> {
        for format in &self.format {
            folder.stream(&format!("{stem}.{}", format.word()), |out| write(*format, out))?;
        }
        Ok(())
    }

    /// These formats and CSV.
    pub(super) fn with_csv(&self) -> Self {
        let others = self.format.iter().copied().filter(|format| *format != ColumnFormat::Csv);
        Self { format: std::iter::once(ColumnFormat::Csv).chain(others).collect() }
    }

    /// Returns the flag, unless it is the default.
    pub(super) fn flags(&self) -> Vec<String> {
        if self.format == [ColumnFormat::Csv] {
            return vec![];
        }
        let words: Vec<&str> = self.format.iter().map(|format| format.word()).collect();
        vec!["--format".to_owned(), words.join(",")]
    }
}
