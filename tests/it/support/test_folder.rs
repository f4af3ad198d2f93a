//! A temporary folder to run trocar in.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Stdio};
use std::time::SystemTime;

use assert_cmd::Command;
use serde_json::Value as Json;
use tempfile::TempDir;

pub struct TestFolder(TempDir);

pub struct Outcome {
    pub code: i32,
    pub out: String,
    pub err: String,
}

impl TestFolder {
    pub fn new() -> Self {
        Self(tempfile::tempdir().expect("a folder"))
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn file(&self, name: &str, content: impl AsRef<[u8]>) -> &Self {
        let path = self.path(name);
        fs::create_dir_all(path.parent().expect("a folder")).expect("created");
        fs::write(path, content).expect("written");
        self
    }

    pub fn text(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::cargo_bin("trocar").expect("built");
        command.current_dir(self.0.path()).args(arguments);
        command
    }

    /// Starts trocar in this folder.
    pub fn begin(&self, arguments: &[&str]) -> Child {
        let mut command = std::process::Command::new(assert_cmd::cargo::cargo_bin("trocar"));
        command.current_dir(self.0.path()).args(arguments).stdout(Stdio::piped()).stderr(Stdio::piped());
        command.spawn().expect("begun")
    }

    pub fn trocar(&self, arguments: &[&str]) -> Outcome {
        self.fed(arguments, b"")
    }

    /// Runs trocar with an input on standard input.
    pub fn fed(&self, arguments: &[&str], input: &[u8]) -> Outcome {
        let output = self.command(arguments).write_stdin(input).output().expect("ran");
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("text");
        Outcome { code: output.status.code().unwrap_or(-1), out: text(output.stdout), err: text(output.stderr) }
    }

    pub fn good(&self, arguments: &[&str]) -> String {
        let outcome = self.trocar(arguments);
        assert_eq!(outcome.code, 0, "{arguments:?}: {}", outcome.err);
        outcome.out
    }

    /// Returns what a command prints, with single spaces between its words.
    pub fn said(&self, arguments: &[&str]) -> String {
        words(&self.good(arguments))
    }

    /// Returns the JSON document that a command prints.
    pub fn json(&self, arguments: &[&str]) -> Json {
        serde_json::from_str(&self.good(arguments)).expect("JSON")
    }

    /// Returns what a command that succeeds prints on standard error.
    pub fn warned(&self, arguments: &[&str]) -> String {
        let outcome = self.trocar(arguments);
        assert_eq!(outcome.code, 0, "{arguments:?}: {}", outcome.err);
        outcome.err
    }

    /// Runs a command that must be refused with exit code 2, no output and no file. Returns the message.
    pub fn refusal(&self, arguments: &[&str]) -> String {
        let before = self.state();
        let outcome = self.trocar(arguments);
        assert_eq!(outcome.code, 2, "{arguments:?}: {}{}", outcome.out, outcome.err);
        assert!(outcome.out.is_empty(), "{}", outcome.out);
        assert!(self.state() == before, "{arguments:?}: something was written");
        outcome.err
    }

    /// Runs a command that must be refused, and checks that its message has all phrases.
    pub fn refused(&self, arguments: &[&str], phrases: &[&str]) {
        let message = self.refusal(arguments);
        for phrase in phrases {
            assert!(message.contains(phrase), "{arguments:?}: no {phrase:?} in\n{message}");
        }
    }

    /// Checks that a command refuses a file that differs from a good text by one of these changes. A change has the
    /// replaced part, its replacement, and phrases of the message.
    pub fn refused_changes(&self, command: &str, good: &str, changes: &[(&str, &str, &[&str])]) {
        for (from, to, phrases) in changes {
            let text = good.replacen(from, to, 1);
            assert_ne!(text, good, "{from}");
            self.file("wrong.toml", text).refused(&[command, "wrong.toml"], phrases);
        }
    }

    /// Runs commands that must be refused, one per line. Returns the messages as displayed.
    pub fn refusals(&self, commands: &str) -> String {
        let seen = |line: &str| {
            let arguments: Vec<&str> = line.split_whitespace().collect();
            format!("$ trocar {}\n{}\n", arguments.join(" "), self.refusal(&arguments))
        };
        commands.lines().filter(|line| !line.trim().is_empty()).map(seen).collect()
    }

    pub fn commands(&self) -> Vec<String> {
        let help = self.good(&["--help"]);
        let listed = ["Commands:\n", "Files and setup:\n"]
            .map(|heading| help.split(heading).nth(1).and_then(|rest| rest.split("\n\n").next()).expect("a list"));
        // The description of a command continues on lines with more indentation.
        let names =
            listed.iter().flat_map(|list| list.lines()).filter_map(|line| line.strip_prefix("  ")?.split(' ').next());
        names.filter(|name| !name.is_empty() && *name != "help").map(str::to_owned).collect()
    }

    pub fn files(&self, below: &str) -> BTreeMap<PathBuf, Vec<u8>> {
        let folder = self.path(below);
        let read = |path: PathBuf| {
            let content = fs::read(&path).expect("read");
            (path.strip_prefix(&folder).expect("below").to_owned(), content)
        };
        files_below(&folder).into_iter().map(read).collect()
    }

    /// Returns every file with its length and modification time, without reading it.
    fn state(&self) -> BTreeMap<PathBuf, (u64, SystemTime)> {
        let look = |path: PathBuf| {
            let about = fs::metadata(&path).expect("there");
            (path, (about.len(), about.modified().expect("a time")))
        };
        files_below(self.0.path()).into_iter().map(look).collect()
    }
}

/// Joins the words of a text with single spaces.
pub fn words(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

pub fn files_below(folder: &Path) -> Vec<PathBuf> {
    let mut found = vec![];
    let mut open = vec![folder.to_owned()];
    while let Some(next) = open.pop() {
        for entry in fs::read_dir(next).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.is_dir() { open.push(path) } else { found.push(path) }
        }
    }
    found
}
