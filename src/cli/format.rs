//! The formats of files with one row per sample.

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};

use trocar_report::ColumnFormat;

#[derive(Debug, Args)]
pub(super) struct FormatArgs {
    /// Formats of the file with one row per sample, separated by commas; mat is for MATLAB, mcap for Foxglove and
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
    let of = |word: String| ColumnFormat::ALL.into_iter().find(|format| format.to_string() == word);
    PossibleValuesParser::new(ColumnFormat::ALL.map(|format| format.to_string()))
        .try_map(move |word| of(word).ok_or("no format"))
}

impl FormatArgs {
    pub(super) fn formats(&self) -> &[ColumnFormat] {
        &self.format
    }

    pub(super) fn with_csv(&self) -> Self {
        let others = self.format.iter().copied().filter(|format| *format != ColumnFormat::Csv);
        Self { format: std::iter::once(ColumnFormat::Csv).chain(others).collect() }
    }

    pub(super) fn flags(&self) -> Vec<String> {
        if self.format == [ColumnFormat::Csv] {
            return vec![];
        }
        let words: Vec<String> = self.format.iter().map(ToString::to_string).collect();
        vec!["--format".to_owned(), words.join(",")]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Debug, Parser)]
    struct Only {
        #[command(flatten)]
        format: FormatArgs,
    }

    fn parsed(words: &[&str]) -> FormatArgs {
        Only::try_parse_from(std::iter::once(&"trocar").chain(words)).expect("valid").format
    }

    #[test]
    fn the_default_is_csv_and_has_no_flag() {
        assert_eq!(parsed(&[]).format, [ColumnFormat::Csv]);
        assert_eq!(parsed(&[]).format, FormatArgs::default().format);
        assert!(parsed(&[]).flags().is_empty());
    }

    #[test]
    fn formats_keep_their_order_except_that_csv_comes_first_if_required() {
        let both = parsed(&["--format", "mat,csv"]);
        assert_eq!(both.flags(), ["--format", "mat,csv"]);
        assert_eq!(both.with_csv().flags(), ["--format", "csv,mat"]);
        assert_eq!(parsed(&["--format", "mat"]).with_csv().flags(), ["--format", "csv,mat"]);
        assert!(FormatArgs::default().with_csv().flags().is_empty());
    }
}
