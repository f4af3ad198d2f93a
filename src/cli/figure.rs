use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};

use trocar_report::draw::{FigureFormat, FigureStyle, FigureWidth};
use trocar_report::wrapped;

#[derive(Debug, Args)]
pub(super) struct FigureArgs {
    /// Width of the figures as a number with in, mm or cm, such as 3.5in for a column or 7.16in for a page; text is 8
    /// pt at any width
    #[arg(long, value_name = "WIDTH", default_value = "7.16in")]
    figure_width: FigureWidth,
    /// Formats of the figures, separated by commas; pdf embeds its typeface
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_value = "png,svg", value_parser = parser())]
    figure_format: Vec<FigureFormat>,
}

fn parser() -> impl TypedValueParser<Value = FigureFormat> {
    let of = |word: String| FigureFormat::ALL.into_iter().find(|format| format.to_string() == word);
    PossibleValuesParser::new(FigureFormat::ALL.map(|format| format.to_string()))
        .try_map(move |word| of(word).ok_or("no format"))
}

/// In the format that is easiest to view; `None` without figures.
pub(super) fn file_name(style: &FigureStyle, name: &str) -> Option<String> {
    let format = FigureFormat::ALL.into_iter().find(|format| style.formats.contains(format))?;
    Some(format!("{name}.{format}"))
}

pub(super) fn lines(names: &[String]) -> String {
    if names.is_empty() { String::new() } else { wrapped(&format!("figures: {}\n", names.join(", ")), 2) }
}

impl FigureArgs {
    pub(super) fn style(&self) -> FigureStyle {
        FigureStyle { width: self.figure_width, formats: self.figure_format.clone() }
    }
}
