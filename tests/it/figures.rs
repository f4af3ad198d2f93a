//! The figures that a user requests, and the figures of the paper.

use trocar_studies::compare::{FIGURES, PaperStudy};

use crate::support::test_folder::TestFolder;

#[test]
fn every_figure_of_the_paper_is_a_file_and_the_page_has_the_computed_statements() {
    let folder = TestFolder::new();
    let printed = folder.good(&["paper", "--out", "p", "--figure-width", "3.5in", "--figure-format", "png,svg,pdf"]);
    let files = folder.files("p/paper");
    for number in FIGURES {
        for (format, start) in [("png", &b"\x89PNG"[..]), ("svg", b"<svg"), ("pdf", b"%PDF")] {
            let name = format!("figure_{number:02}.{format}");
            let file = files.iter().find(|(path, _)| path.ends_with(&name)).unwrap_or_else(|| panic!("no {name}")).1;
            assert!(file.starts_with(start), "{name}");
        }
    }
    assert_eq!(files.len(), 3 * FIGURES.len() + 3, "{:?}", files.keys());

    let page = folder.text("p/paper/paper.html").replace("&#x27;", "'").replace("&#x2f;", "/").replace("&gt;", ">");
    let page = page.replace("&lt;", "<");
    assert!(page.len() < 3_000_000, "{}", page.len());
    for figure in PaperStudy::new().expect("runs").figures() {
        let heading = figure.number.map_or("Without a figure:".to_owned(), |number| format!("Figure {number}:"));
        let anchor = figure.number.map_or("figure-other".to_owned(), |number| format!("figure-{number}"));
        assert!(page.contains(&format!("id=\"{anchor}\"")) && page.contains(figure.differs), "{anchor}");
        assert!(printed.contains(&heading));
        for statement in figure.statements {
            assert!(page.contains(&statement.ours), "{}: {}", statement.number, statement.ours);
            assert!(page.contains(&statement.why), "{}: {}", statement.number, statement.why);
        }
    }
}

#[test]
fn figures_have_the_requested_width_and_formats() {
    let folder = TestFolder::new();
    let compare = ["compare", "--quiet", "--out", "o", "--figure-width", "89mm", "--figure-format", "svg,pdf"];
    folder.good(&compare);
    assert!(folder.text("o/compare/overlay.svg").contains("width=\"252.28pt\""));
    let names: Vec<_> = folder.files("o").into_keys().collect();
    let count =
        |end: &str| names.iter().filter(|path| path.extension().is_some_and(|extension| extension == end)).count();
    // Three of the pair and six of each run; the animation is always a PNG.
    assert_eq!((count("svg"), count("pdf"), count("png")), (15, 15, 1), "{names:?}");
    let printed = folder.good(&["compare", "--out", "o", "--figure-format", "pdf"]);
    assert!(printed.contains("figures: comparison.pdf, overlay.pdf, signals.pdf\nfiles: o/compare\n"), "{printed}");
}

#[test]
fn an_impossible_width_or_format_is_rejected_with_a_remedy() {
    let folder = TestFolder::new();
    for (width, phrase) in
        [("3.5", "3.5in, 89mm or 8.9cm"), ("1in", "from 2.5 to 20 in"), ("NaNin", "from 2.5 to 20 in")]
    {
        folder.refused(&["paper", "--figure-width", width], &[phrase]);
    }
    folder.refused(&["compare", "--figure-format", "gif"], &["png, svg, pdf"]);
}
