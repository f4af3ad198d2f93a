//! Executes the book and the README page by page, each page in its own folder from top to bottom.
//!
//! - `console` blocks: each `$ trocar …` prints the lines below it; a line of `…` stands for any lines.
//! - `sh` blocks: every line that begins with `trocar` succeeds.
//! - `<!-- file: NAME -->` before a block writes the block to that file.
//! - `<!-- drawn: FILE -->` before a picture: the picture equals the file that the page's commands have drawn.
//!
//! `BLESS=1` renews outputs and pictures.

mod page;
mod reference;

use std::collections::BTreeSet;
use std::path::PathBuf;

use crate::support::test_folder::TestFolder;
use crate::support::{file, files_with};
use page::BookPage;

const GENERATED: &str = "<!-- generated -->";

fn pages() -> Vec<PathBuf> {
    let mut pages = files_with("md", &file("docs/src"));
    pages.sort();
    assert!(pages.len() > 30, "{}", pages.len());
    pages
}

/// Executes the pages in a folder of the book.
fn execute(folder: &str) {
    let below = file("docs/src").join(folder);
    let pages: Vec<_> = pages().into_iter().filter(|path| path.parent() == Some(&*below)).collect();
    assert!(!pages.is_empty(), "{folder}");
    pages.iter().for_each(|path| BookPage::read(path).execute());
}

#[test]
fn the_commands_of_the_readme_print_what_it_shows() {
    BookPage::read(&file("README.md")).execute();
}

/// The page about strategies has the output of the command that the README names.
#[test]
fn the_strategies_of_the_readme_have_the_numbers_of_their_page() {
    let [readme, page] = ["README.md", "docs/src/evidence/strategies.md"]
        .map(|path| std::fs::read_to_string(file(path)).expect("there"));
    let command = "trocar strategies scenarios/sweeps/patients.toml --patients 20 --seeds 5";
    let output = page.split(command).nth(1).and_then(|rest| rest.split("```").next()).expect("the output");
    let numbers =
        |row: &str| row.split_whitespace().filter(|word| word.parse::<f64>().is_ok()).collect::<Vec<_>>().join(" ");
    let rows: Vec<&str> = readme.lines().filter(|line| line.starts_with("| `") && line.contains(" mm |")).collect();
    assert!(readme.contains(command) && rows.len() > 3, "{rows:?}");
    for row in rows {
        let name = row.split('`').nth(1).expect("a name");
        let of_page = output.lines().find(|line| line.starts_with(&format!("{name} "))).expect("the strategy");
        // Of the page's columns, the README leaves out the missed ruptures and the largest excess.
        let all = numbers(&of_page.replace(" *", ""));
        let [reached, _, noticed, excess, _, last] = all.split(' ').collect::<Vec<_>>()[..] else {
            panic!("{of_page}")
        };
        let cells = numbers(row.split_once('|').and_then(|(_, rest)| rest.split_once('|')).expect("cells").1);
        assert_eq!(cells, [reached, noticed, excess, last].join(" "), "{name}");
    }
}

#[test]
fn the_scenario_of_the_readme_detects_its_ruptures_with_every_seed() {
    let readme = std::fs::read_to_string(file("README.md")).expect("there");
    let block = readme.split("<!-- file: my.toml -->\n```toml\n").nth(1).and_then(|rest| rest.split("```").next());
    let folder = TestFolder::new();
    let sweep =
        "base = \"my.toml\"\nseeds = 20\nmetrics = [\"detected_ruptures\", \"missed_ruptures\", \"false_alarms\"]\n";
    folder.file("my.toml", block.expect("the scenario")).file("sweep.toml", sweep);
    folder.good(&["sweep", "sweep.toml", "--quiet"]);
    let cases = folder.text("out/sweep/cases.csv");
    let rows: Vec<&str> = cases.lines().skip(1).collect();
    assert_eq!(rows.len(), 20, "{cases}");
    assert!(rows.iter().all(|row| row.ends_with(",completed,3,0,0")), "{cases}");
}

#[test]
fn the_rust_of_the_book_is_that_of_examples_which_cargo_compiles() {
    let mut found = 0;
    for page in pages() {
        let text = std::fs::read_to_string(&page).expect("there");
        for block in text.split("```rust").skip(1) {
            let (_, inside) = block.split_once('\n').expect("lines");
            let line = inside.split("\n```").next().and_then(|line| line.strip_prefix("{{#include "));
            let line = line.and_then(|line| line.strip_suffix("}}")).filter(|line| !line.contains('\n'));
            let line = line.unwrap_or_else(|| panic!("{}: {inside}", page.display()));
            let path = page.parent().expect("a folder").join(line.split(':').next().unwrap_or_default());
            assert!(
                path.is_file() && path.parent().is_some_and(|folder| folder.ends_with("examples")),
                "{}",
                path.display()
            );
            found += 1;
        }
    }
    assert!(found >= 4, "{found}");
}

/// The page names `trocar-core` as the only dependency; cargo compiles the examples of this package with it alone.
#[test]
fn the_program_of_the_rig_page_is_an_example_of_the_core() {
    let page = std::fs::read_to_string(file("docs/src/howto/rig.md")).expect("there");
    assert!(page.contains("trocar-core = {") && page.contains("crates/core/examples/rig_step.rs"));
    let manifest = std::fs::read_to_string(file("crates/core/Cargo.toml")).expect("there");
    assert!(
        !manifest.contains("trocar-") || manifest.matches("trocar-").count() == manifest.matches("trocar-core").count()
    );
}

#[test]
fn the_commands_of_the_first_pages_print_what_they_show() {
    execute("");
    execute("reference");
}

#[test]
#[ignore = "a minute of processor time"]
fn the_commands_of_the_tutorials_print_what_they_show() {
    execute("tutorials");
}

#[test]
#[ignore = "a minute of processor time"]
fn the_commands_of_the_concepts_print_what_they_show() {
    execute("concepts");
}

#[test]
#[ignore = "a minute of processor time"]
fn the_commands_of_the_how_to_pages_print_what_they_show() {
    execute("howto");
}

#[test]
#[ignore = "a minute of processor time"]
fn the_evidence_pages_agree_with_their_commands() {
    execute("evidence");
}

#[test]
fn the_first_screen_shows_the_commands_that_a_newcomer_needs() {
    let readme = std::fs::read_to_string(file("README.md")).expect("there");
    let block = readme.split("```sh\n").nth(1).and_then(|rest| rest.split("```").next()).expect("a block");
    assert!(block.contains("cargo run --release -- compare"), "{block}");
    assert!(block.contains("cargo test"), "{block}");
}

fn links(text: &str) -> impl Iterator<Item = &str> {
    text.split("](").skip(1).filter_map(|rest| rest.split(')').next())
}

/// Returns the anchors that mdBook generates for a page's headings.
fn anchors(text: &str) -> BTreeSet<String> {
    let headings =
        text.lines().filter_map(|line| line.strip_prefix('#')).map(|rest| rest.trim_start_matches('#').trim());
    let letter = |c: char| match c {
        ' ' => Some('-'),
        c if c.is_alphanumeric() || c == '-' || c == '_' => Some(c.to_ascii_lowercase()),
        _ => None,
    };
    headings.map(|heading| heading.chars().filter_map(letter).collect()).collect()
}

#[test]
fn every_link_has_a_target() {
    let front = ["README.md", "CONTRIBUTING.md", "SECURITY.md"].map(file);
    for path in pages().into_iter().chain(front) {
        let text = std::fs::read_to_string(&path).expect("text");
        for link in links(&text).filter(|link| !link.contains("://")) {
            let (target, anchor) = link.split_once('#').unwrap_or((link, ""));
            let target = if target.is_empty() { path.clone() } else { path.parent().expect("a folder").join(target) };
            assert!(target.exists(), "{}: {link}", path.display());
            if !anchor.is_empty() {
                let anchors = anchors(&std::fs::read_to_string(&target).expect("text"));
                assert!(anchors.contains(anchor), "{}: {link}, there are {anchors:?}", path.display());
            }
        }
    }
}

#[test]
fn the_contents_list_every_page() {
    let contents = std::fs::read_to_string(file("docs/src/SUMMARY.md")).expect("there");
    let listed: BTreeSet<PathBuf> = links(&contents).map(|link| file("docs/src").join(link)).collect();
    let there: BTreeSet<PathBuf> = pages().into_iter().filter(|path| !path.ends_with("SUMMARY.md")).collect();
    assert_eq!(listed, there);
}
