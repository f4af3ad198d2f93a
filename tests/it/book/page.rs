//! One executable page.

use std::path::{Path, PathBuf};
use std::process::Command;

use assert_cmd::cargo::cargo_bin;

use crate::support::file;
use crate::support::test_folder::TestFolder;

/// A line that stands for any lines of an output.
const LEFT_OUT: &str = "…";

/// Commands that run until they are stopped.
const SERVERS: [&str; 1] = ["trocar explore"];

pub struct BookPage {
    path: PathBuf,
    lines: Vec<String>,
    folder: TestFolder,
    is_blessed: bool,
}

/// A fenced block: its language, and the range of its lines.
struct Block {
    language: String,
    from: usize,
    to: usize,
}

impl BookPage {
    pub fn read(path: &Path) -> Self {
        let text = std::fs::read_to_string(path).expect("a page");
        let folder = TestFolder::new();
        // Pages for a checkout of the repository name its recordings.
        let recordings =
            ["scenarios/recordings", "tests/data/teleop_1dof"].into_iter().filter(|from| text.contains(from));
        for from in std::iter::once("scenarios/sweeps").chain(recordings) {
            for entry in std::fs::read_dir(file(from)).expect("a folder") {
                let path = entry.expect("an entry").path();
                let name = path.file_name().and_then(|name| name.to_str()).expect("a name");
                folder.file(&format!("{from}/{name}"), std::fs::read(&path).expect("read"));
            }
        }
        Self {
            path: path.to_owned(),
            lines: text.lines().map(str::to_owned).collect(),
            folder,
            is_blessed: std::env::var_os("BLESS").is_some(),
        }
    }

    pub fn execute(mut self) {
        let mut at = 0;
        while let Some(block) = self.next_block(at) {
            let file = self.comment_before(block.from - 1, "file");
            let content = self.lines[block.from..block.to].to_vec();
            match (&*block.language, file) {
                (_, Some(name)) => {
                    self.folder.file(&name, content.join("\n") + "\n");
                }
                ("console", None) => {
                    let renewed = self.session(&content);
                    self.lines.splice(block.from..block.to, renewed);
                }
                ("sh", None) => commands(&content).iter().for_each(|command| {
                    if command.starts_with("trocar ") && !SERVERS.iter().any(|server| command.starts_with(server)) {
                        self.run(command);
                    }
                }),
                (_, None) => {}
            }
            at = self.next_block(block.from - 1).map_or(self.lines.len(), |block| block.to + 1);
        }
        self.check_pictures();
        if self.is_blessed {
            std::fs::write(&self.path, self.lines.join("\n") + "\n").expect("written");
        }
    }

    /// Returns the first block that begins at line `at` or later.
    fn next_block(&self, at: usize) -> Option<Block> {
        let opening = (at..self.lines.len()).find(|&line| self.lines[line].starts_with("```"))?;
        let language = self.lines[opening].trim_start_matches('`').to_owned();
        let to = (opening + 1..self.lines.len()).find(|&line| self.lines[line] == "```");
        let to = to.unwrap_or_else(|| panic!("{}: a block without an end", self.path.display()));
        Some(Block { language, from: opening + 1, to })
    }

    /// Returns the content of `<!-- kind: content -->` in the line before `line`.
    fn comment_before(&self, line: usize, kind: &str) -> Option<String> {
        let before = self.lines.get(line.checked_sub(1)?)?;
        Some(before.strip_prefix(&format!("<!-- {kind}: "))?.strip_suffix(" -->")?.to_owned())
    }

    /// Runs a command in the page's folder. Returns its output.
    fn run(&self, command: &str) -> String {
        let binary = cargo_bin("trocar");
        let mut path = std::ffi::OsString::from(binary.parent().expect("a folder"));
        path.push(":");
        path.push(std::env::var_os("PATH").unwrap_or_default());
        let output =
            Command::new("sh").args(["-c", command]).env("PATH", path).current_dir(self.folder.path("")).output();
        let output = output.expect("a shell");
        let error = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{}: {command}: {error}", self.path.display());
        String::from_utf8(output.stdout).expect("text")
    }

    /// Runs a session. Returns it with the actual outputs.
    fn session(&self, shown: &[String]) -> Vec<String> {
        let mut renewed = vec![];
        let mut rest = shown;
        while let Some(first) = rest.first() {
            assert!(first.starts_with("$ "), "{}: {first} is no command", self.path.display());
            let command_lines = 1 + rest.iter().take_while(|line| line.ends_with('\\')).count();
            let (command, after) = rest.split_at(command_lines);
            let (expected, after) = after.split_at(after.iter().take_while(|line| !line.starts_with("$ ")).count());
            rest = after;
            let text = command.join("\n");
            let printed = self.run(text.trim_start_matches("$ "));
            let printed: Vec<&str> = printed.lines().collect();
            renewed.extend_from_slice(command);
            if matches(expected, &printed) {
                renewed.extend_from_slice(expected);
                continue;
            }
            assert!(
                self.is_blessed,
                "{}: {text} prints (BLESS=1 renews the page)\n{}\nnot\n{}",
                self.path.display(),
                printed.join("\n"),
                expected.join("\n")
            );
            renewed.extend(shortened(expected, &printed));
        }
        renewed
    }

    fn check_pictures(&self) {
        for line in 0..self.lines.len() {
            let Some(drawn) = self.comment_before(line, "drawn") else { continue };
            let shown = self.lines[line].split("](").nth(1).and_then(|rest| rest.split(')').next()).expect("a picture");
            let shown = self.path.parent().expect("a folder").join(shown);
            let drawn_bytes =
                std::fs::read(self.folder.path(&drawn)).unwrap_or_else(|error| panic!("{drawn}: {error}"));
            if std::fs::read(&shown).is_ok_and(|bytes| bytes == drawn_bytes) {
                continue;
            }
            assert!(self.is_blessed, "{}: {drawn} is another picture; BLESS=1 renews it", self.path.display());
            std::fs::write(&shown, drawn_bytes).expect("written");
        }
    }
}

fn commands(lines: &[String]) -> Vec<String> {
    let mut commands: Vec<String> = vec![];
    let mut is_open = false;
    for line in lines {
        match commands.last_mut().filter(|_| is_open) {
            Some(command) => command.push_str(&format!("\n{line}")),
            None => commands.push(line.clone()),
        }
        is_open = line.ends_with('\\');
    }
    commands
}

/// Returns true if the output matches the shown lines, in which a line of `…` stands for any lines.
fn matches(shown: &[String], printed: &[&str]) -> bool {
    let mut parts = shown.split(|line| line == LEFT_OUT);
    let first = parts.next().unwrap_or_default();
    let begins = printed.len() >= first.len() && first.iter().zip(printed).all(|(a, b)| a == b);
    let mut rest = printed.get(first.len()..).unwrap_or_default();
    let mut is_whole = true;
    for part in parts {
        is_whole = part.is_empty();
        let found = (0..=rest.len().saturating_sub(part.len()))
            .find(|&at| rest.len() >= at + part.len() && part.iter().zip(&rest[at..]).all(|(a, b)| a == b));
        let Some(at) = found else { return false };
        rest = &rest[at + part.len()..];
        is_whole |= rest.is_empty();
    }
    begins && if shown.iter().any(|line| line == LEFT_OUT) { is_whole } else { rest.is_empty() }
}

/// Returns the output with a `…` in place of the middle lines if the shown lines have one.
fn shortened(shown: &[String], printed: &[&str]) -> Vec<String> {
    let Some(before) = shown.iter().position(|line| line == LEFT_OUT) else {
        return printed.iter().map(|line| (*line).to_owned()).collect();
    };
    let after = shown.iter().rev().take_while(|line| *line != LEFT_OUT).count();
    let (first, last) = (before.min(printed.len()), printed.len().saturating_sub(after).max(before.min(printed.len())));
    let mut lines: Vec<String> = printed[..first].iter().map(|line| (*line).to_owned()).collect();
    lines.push(LEFT_OUT.to_owned());
    lines.extend(printed[last..].iter().map(|line| (*line).to_owned()));
    lines
}

#[test]
fn a_line_of_dots_matches_any_lines() {
    let lines = |text: &str| text.split(' ').map(str::to_owned).collect::<Vec<_>>();
    let printed = ["a", "b", "c", "d"];
    for good in ["a b c d", "a … d", "a …", "… d", "a … c …", "…"] {
        assert!(matches(&lines(good), &printed), "{good}");
    }
    for bad in ["a b c", "a … c", "b …", "… a", "a d …", "a b c d e", "x"] {
        assert!(!matches(&lines(bad), &printed), "{bad}");
    }
    assert_eq!(shortened(&lines("x … y"), &printed), ["a", "…", "d"]);
}
