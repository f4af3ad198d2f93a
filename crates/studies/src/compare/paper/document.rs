use schemars::JsonSchema;
use serde::Serialize;

use super::{Judgement, PaperFigure, PaperStudy, Statement};
use trocar_document::{Document, Section, Shown, Study, Table, Verdict, counted, json_of};

const ABOUT: &str = "Barbé, Bayle, de Mathelin and Gangi, In Vivo Model Estimation and Haptic Characterization of \
                     Needle Insertions: each figure but the photographs (2 and 3), drawn from the shipped scenarios \
                     with the signs of the paper, in which a force that resists insertion is negative";

const RULE: &str = "Reproduced: the result meets the condition, which is chosen here. Contradicted: it does not. Not \
    checkable: the number is an input, the result depends on a value that the paper does not state, the simulation \
    lacks the subject of the statement, or the statement names no criterion. The insertion of figures 6 to 16 is \
    generated, as the paper's recording was never \
                    published.";

impl Study for PaperStudy {
    fn document(&self) -> Document<'_> {
        let all = self.figures();
        let mut document = Document {
            name: "paper",
            title: "The statements of the paper".into(),
            verdict: verdict(&all),
            json: json_of(&PaperFile {
                trocar_version: env!("CARGO_PKG_VERSION"),
                figures: all.iter().map(FigureStatements::of).collect(),
            }),
            ..Document::default()
        };
        let mut introduction = Section::new("about", "About").shown(Shown::InReports);
        introduction.text(ABOUT);
        document.sections.push(introduction);
        for figure in all {
            let (id, heading) = figure.number.map_or_else(
                || ("other".to_owned(), "Without a figure".to_owned()),
                |number| (number.to_string(), format!("Figure {number}")),
            );
            let mut section = Section::new(format!("figure-{id}"), heading.clone());
            section.text(format!("{heading}: {}", figure.shows));
            if let Some(number) = figure.number {
                let name = format!("figure_{number:02}");
                section.figure(name.clone());
                document.figure(name, self.drawn(number));
            }
            section.table(statements_table(&heading, &figure.statements));
            for statement in &figure.statements {
                section.text(explanation(statement));
            }
            let mut ours = Section::new(format!("differs-{id}"), format!("{heading}: what differs, and why"))
                .shown(Shown::InReports);
            ours.text(format!("This figure: {}", figure.ours));
            ours.text(figure.differs);
            document.sections.extend([section, ours]);
        }
        document
    }
}

/// `paper.json`: the statements of the paper with the results.
#[derive(Debug, Serialize, JsonSchema)]
pub struct PaperFile<'a> {
    /// Version of trocar.
    trocar_version: &'static str,
    /// The figures of the paper, followed by the statements that no figure shows.
    figures: Vec<FigureStatements<'a>>,
}

/// The statements that a figure of the paper shows.
#[derive(Debug, Serialize, JsonSchema)]
struct FigureStatements<'a> {
    /// Number of the figure in the paper; `None` for the statements that no figure shows.
    number: Option<u8>,
    /// The statements with the results.
    statements: &'a [Statement],
}

impl<'a> FigureStatements<'a> {
    fn of(figure: &'a PaperFigure) -> Self {
        Self { number: figure.number, statements: &figure.statements }
    }
}

fn verdict(figures: &[PaperFigure]) -> Verdict {
    let statements = || figures.iter().flat_map(|figure| &figure.statements);
    let of = |judgement| statements().filter(move |statement| statement.judgement == judgement);
    let [reproduced, contradicted, open] = Judgement::ALL.map(|judgement| of(judgement).count());
    let count = format!(
        "Of {}, {reproduced} are reproduced, {contradicted} contradicted and {open} not checkable.",
        counted(statements().count() as u64, "statement")
    );
    let named = of(Judgement::Contradicted).map(|statement| format!("{} ({})", statement.what, statement.number));
    let named = format!("Contradicted: {}.", named.collect::<Vec<_>>().join("; "));
    Verdict {
        sentences: if contradicted > 0 { vec![count, named] } else { vec![count] },
        left_out: vec![RULE.to_owned()],
    }
}

fn explanation(statement: &Statement) -> String {
    let Statement { number, condition, why, .. } = statement;
    let condition = if condition.is_empty() { String::new() } else { format!("Reproduced if {condition}. ") };
    format!("{number}: {condition}{why}")
}

fn statements_table(heading: &str, statements: &[Statement]) -> Table {
    let columns = [("statement", "statement"), ("paper", "paper"), ("result", "here"), ("judgement", "judgement")];
    let mut table = Table::new("statements", format!("Statements of the paper: {heading}"), columns).of_text();
    for statement in statements {
        let Statement { number, what, section, paper, ours, judgement, .. } = statement;
        table.row([&format!("{number} {what} ({section})"), *paper, ours, judgement.words()]);
    }
    table
}
