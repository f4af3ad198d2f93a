use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};

use trocar_report::ColumnFormat;

#[derive(Debug, Default, Args)]
pub(super) struct FormatArgs {
    /// Formats of the file with one row per sample, separated by commas; mat is for MATLAB [default: csv, but parquet
    /// for a detection with over a million rows]
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = parser())]
    format: Vec<ColumnFormat>,
}

/// Rows above which a detection is written as Parquet by default: CSV is several times as large.
pub(super) const LONG_ROWS: usize = 1_000_000;

fn parser() -> impl TypedValueParser<Value = ColumnFormat> {
    let of = |word: String| ColumnFormat::ALL.into_iter().find(|format| format.to_string() == word);
    PossibleValuesParser::new(ColumnFormat::ALL.map(|format| format.to_string()))
        .try_map(move |word| of(word).ok_or("no format"))
}

impl FormatArgs {
    pub(super) fn formats(&self) -> &[ColumnFormat] {
        if self.format.is_empty() { &[ColumnFormat::Csv] } else { &self.format }
    }

    /// Returns the formats of a detection with a number of rows.
    pub(super) fn of_rows(&self, rows: usize) -> &[ColumnFormat] {
        if self.format.is_empty() && rows > LONG_ROWS { &[ColumnFormat::Parquet] } else { self.formats() }
    }

    pub(super) fn with_csv(&self) -> Self {
        let others = self.formats().iter().copied().filter(|format| *format != ColumnFormat::Csv);
        Self { format: std::iter::once(ColumnFormat::Csv).chain(others).collect() }
    }

    pub(super) fn flags(&self) -> Vec<String> {
        if self.format.is_empty() {
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
        assert_eq!(parsed(&[]).formats(), [ColumnFormat::Csv]);
        assert!(parsed(&[]).flags().is_empty());
    }

    #[test]
    fn a_long_detection_is_parquet_unless_a_format_is_given() {
        assert_eq!(parsed(&[]).of_rows(LONG_ROWS), [ColumnFormat::Csv]);
        assert_eq!(parsed(&[]).of_rows(LONG_ROWS + 1), [ColumnFormat::Parquet]);
        assert_eq!(parsed(&["--format", "csv"]).of_rows(LONG_ROWS + 1), [ColumnFormat::Csv]);
    }

    #[test]
    fn formats_keep_their_order_except_that_csv_comes_first_if_required() {
        let both = parsed(&["--format", "mat,csv"]);
        assert_eq!(both.flags(), ["--format", "mat,csv"]);
        assert_eq!(both.with_csv().flags(), ["--format", "csv,mat"]);
        assert_eq!(parsed(&["--format", "mat"]).with_csv().flags(), ["--format", "csv,mat"]);
    }
}
