//! What the reproduction of the paper says.

use schemars::JsonSchema;
use serde::Serialize;

use super::paper::{PAPER_VARIANCE_N2, PaperStudy};
use super::{Fact, facts_table};
use trocar_document::{Document, Figure, Section, Shown, Study, Table, Verdict, json_of};
use trocar_figures::{self as figures, FigureError};

impl Study for PaperStudy {
    fn document(&self) -> Document<'_> {
        let all = self.figures();
        let facts: Vec<&Fact> = all.iter().flat_map(|figure| &figure.facts).collect();
        let held = facts.iter().filter(|fact| fact.holds).count();
        let about = "Barbé, Bayle, de Mathelin and Gangi, In Vivo Model Estimation and Haptic Characterization of Needle Insertions: \
                     each figure with results, drawn from the shipped scenarios. Forces are positive when they resist insertion; the \
                     paper has the opposite sign";
        let mut document = Document {
            name: "paper",
            title: "The figures of the paper".into(),
            verdict: Verdict {
                sentences: vec![format!("{held} of {} statements of the paper hold.", facts.len())],
                left_out: vec![],
            },
            json: json_of(&PaperFile {
                trocar_version: env!("CARGO_PKG_VERSION"),
                figures: all.iter().map(|figure| FigureFacts { number: figure.number, facts: &figure.facts }).collect(),
            }),
            ..Document::default()
        };
        let mut introduction = Section::new("about", "About").shown(Shown::InReports);
        introduction.text(about);
        document.sections.push(introduction);
        for figure in all {
            let name = format!("figure_{:02}", figure.number);
            let mut section = Section::new(format!("figure-{}", figure.number), format!("Figure {}", figure.number));
            section.text(format!("Figure {}: {}", figure.number, figure.shows));
            section.figure(name.clone());
            let caption = format!("Statements of the paper, figure {}", figure.number);
            section.table(Table { caption, ..facts_table(&figure.facts) });
            let mut ours = Section::new(
                format!("differs-{}", figure.number),
                format!("Figure {}: what differs, and why", figure.number),
            );
            ours.text(format!("This figure: {}", figure.ours));
            ours.text(figure.differs);
            document.sections.extend([section, ours.shown(Shown::InReports)]);
            document.figure(name, drawn(self, figure.number));
        }
        document
    }
}

/// `paper.json`: the statements of the paper with the results.
#[derive(Debug, Serialize, JsonSchema)]
pub struct PaperFile<'a> {
    /// Version of trocar.
    trocar_version: &'static str,
    /// The figures of the paper.
    figures: Vec<FigureFacts<'a>>,
}

/// The statements that a figure of the paper shows.
#[derive(Debug, Serialize, JsonSchema)]
struct FigureFacts<'a> {
    /// Its number in the paper.
    number: u8,
    /// The statements with the results.
    facts: &'a [Fact],
}

/// Describes a figure of the paper.
fn drawn(study: &PaperStudy, number: u8) -> Result<Figure<'_>, FigureError> {
    let PaperStudy { direct, noisy, .. } = study;
    let [classical, augmented] = &study.pair.runs[..] else { return Err(FigureError::Empty { figure: "paper" }) };
    match number {
        4 => figures::estimation(&direct.estimation()),
        5 => figures::parameters(&direct.estimation()),
        6 => figures::estimation(&classical.estimation()),
        7 => figures::parameters(&classical.estimation()),
        8 => figures::force(&classical.view()),
        9 => figures::distance(&noisy.view(), "Squared change of the force (N²)", study.squared_changes_n2()),
        10 => Ok(figures::principle()),
        11 => {
            let residual_n = study.quiet_residual_n();
            let count = residual_n.len().max(1) as f64;
            let own = (residual_n.iter().map(|e| e * e).sum::<f64>() / count).sqrt();
            let paper = PAPER_VARIANCE_N2.sqrt();
            let gaussians = [
                (own, format!("zero-mean Gaussian of the same power, σ = {own:.3} N")),
                (paper, format!("the paper's, σ = {paper:.3} N")),
            ];
            Ok(figures::distribution("classical, quiet stretches", &residual_n, &gaussians))
        }
        12 => figures::distance(&noisy.view(), "Squared prediction error (N²)", &*noisy.trace.distance),
        13 => figures::decision(&classical.estimation()),
        15 => figures::comparison(&[classical.view()], None),
        _ => figures::comparison(&[augmented.view()], None),
    }
}
