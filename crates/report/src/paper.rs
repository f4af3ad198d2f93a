//! The figures of the paper: files, a page and a table.

use std::fmt::Write as _;

use minijinja::value::Serde;
use minijinja::{AutoEscape, Environment};
use rayon::prelude::*;
use serde::Serialize;

use super::comparison::facts_table;
use super::html::assets::THEME_CSS;
use super::pictures::{DrawnRun, PictureError, keep};
use super::wrap::wrapped;
use super::{Folder, Table};
use crate::draw::FigureFormat;
use trocar_document::Figure;
use trocar_figures::{self as figures, FigureError};
use trocar_studies::compare::{Fact, PAPER_VARIANCE_N2, PaperFigure, PaperStudy};

/// A figure on the page.
#[derive(Serialize)]
struct Shown {
    number: u8,
    shows: &'static str,
    ours: &'static str,
    differs: &'static str,
    svg: String,
    facts: Vec<Fact>,
}

/// The content of the page.
#[derive(Serialize)]
struct Content {
    figures: Vec<Shown>,
    theme: &'static str,
    version: &'static str,
}

/// Writes `figure_04` to `figure_16`, and `paper.html` with all of them.
///
/// # Errors
/// [`PictureError`].
pub fn paper_figures(folder: &Folder, study: &PaperStudy) -> Result<(), PictureError> {
    let shown = |of: PaperFigure| -> Result<Shown, PictureError> {
        let PaperFigure { number, shows, ours, differs, facts } = of;
        let svg = draw(study, number, &|figure| {
            keep(folder, &format!("figure_{number:02}"), figure)?;
            Ok(crate::draw::file(figure, FigureFormat::Svg, folder.figures().width)?)
        })?;
        Ok(Shown { number, shows, ours, differs, svg: String::from_utf8_lossy(&svg).into_owned(), facts })
    };
    let figures = study.figures().into_par_iter().map(shown).collect::<Result<Vec<_>, _>>()?;
    let content = Content { figures, theme: THEME_CSS, version: env!("CARGO_PKG_VERSION") };
    let mut environment = Environment::new();
    environment.set_auto_escape_callback(|_| AutoEscape::Html);
    let page = environment.render_str(include_str!("paper.html"), Serde(content)).map_err(PictureError::Page)?;
    Ok(folder.write("paper.html", page.as_bytes())?)
}

/// Draws a figure of the paper and hands it on, because it borrows the runs.
fn draw<T>(
    study: &PaperStudy,
    number: u8,
    then: &dyn Fn(&Figure<'_>) -> Result<T, PictureError>,
) -> Result<T, PictureError> {
    let [classical, augmented] = &study.pair.runs[..] else {
        return Err(FigureError::Empty { figure: "paper" }.into());
    };
    let of = |run| DrawnRun::of(run);
    let (direct, noisy) = (of(&study.direct), of(&study.noisy));
    let (classical, augmented) = (of(classical), of(augmented));
    match number {
        4 => then(&figures::estimation(&direct.estimation())?),
        5 => then(&figures::parameters(&direct.estimation())?),
        6 => then(&figures::estimation(&classical.estimation())?),
        7 => then(&figures::parameters(&classical.estimation())?),
        8 => then(&figures::force(&classical.view())?),
        9 => then(&figures::distance(&noisy.view(), "Squared change of the force (N²)", &study.squared_changes_n2())?),
        10 => then(&figures::principle()),
        11 => {
            let residual_n = study.quiet_residual_n();
            let count = residual_n.len().max(1) as f64;
            let own = (residual_n.iter().map(|e| e * e).sum::<f64>() / count).sqrt();
            let paper = PAPER_VARIANCE_N2.sqrt();
            let gaussians = [
                (own, format!("zero-mean Gaussian of the same power, σ = {own:.3} N")),
                (paper, format!("the paper's, σ = {paper:.3} N")),
            ];
            then(&figures::distribution("classical, quiet stretches", &residual_n, &gaussians))
        }
        12 => then(&figures::distance(&noisy.view(), "Squared prediction error (N²)", &study.noisy.trace.distance)?),
        13 => then(&figures::decision(&classical.estimation())?),
        15 => then(&figures::comparison(&[classical.view()], None)?),
        _ => then(&figures::comparison(&[augmented.view()], None)?),
    }
}

/// Returns the statements of the paper by figure, with the results.
#[must_use]
pub fn paper_text(study: &PaperStudy) -> String {
    let mut text = String::new();
    for figure in study.figures() {
        let _ = writeln!(text, "{}", wrapped(&format!("Figure {}: {}", figure.number, figure.shows), 2));
        let table: Table = facts_table(&figure.facts);
        let _ = writeln!(text, "{table}");
    }
    text
}
