//! The README is executed: its commands run, and what it shows is what they print and draw.

use std::path::Path;

use assert_cmd::Command;

fn readme() -> String {
    std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("README.md")).expect("there")
}

/// The blocks fenced with a language.
fn blocks(language: &str) -> Vec<String> {
    let text = readme();
    let opening = format!("```{language}\n");
    text.split(&opening).skip(1).map(|rest| rest.split("```").next().unwrap_or_default().to_owned()).collect()
}

/// Runs trocar with the arguments of a shell line, in a folder; gives what it prints.
fn trocar(folder: &Path, arguments: &str) -> String {
    let output = Command::cargo_bin("trocar")
        .expect("built")
        .current_dir(folder)
        .args(arguments.split_whitespace())
        .assert()
        .success();
    String::from_utf8(output.get_output().stdout.clone()).expect("text")
}

#[test]
fn the_first_screen_has_the_two_commands_and_they_are_the_projects() {
    let first = blocks("sh").remove(0);
    assert!(first.contains("cargo run --release -- compare"), "{first}");
    assert!(first.contains("cargo test"), "{first}");
    let gate = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(".ci/run")).expect("there");
    assert!(gate.lines().any(|line| line == "cargo test"));
}

#[test]
fn compare_prints_and_draws_what_the_readme_shows() {
    let folder = tempfile::tempdir().expect("a folder");
    let printed = trocar(folder.path(), "compare");
    assert_eq!(printed, blocks("text")[0], "paste what `trocar compare` prints into README.md");
    let drawn = std::fs::read(folder.path().join("out/overlay.png")).expect("drawn");
    let shown = std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/overlay.png")).expect("shown");
    assert!(drawn == shown, "copy out/overlay.png to scenarios/overlay.png");
}

#[test]
fn detect_prints_what_the_readme_shows() {
    let folder = tempfile::tempdir().expect("a folder");
    let command = blocks("sh")[1].replace("\\\n", " ");
    let root = env!("CARGO_MANIFEST_DIR");
    let arguments =
        command.trim().strip_prefix("trocar ").expect("a command").replace("scenarios/", &format!("{root}/scenarios/"));
    assert_eq!(trocar(folder.path(), &arguments), blocks("text")[1]);
}

/// Runs a line of a session in a folder, commands joined by `|`; gives what the last one prints.
fn session(folder: &Path, line: &str) -> String {
    line.split(" | ").fold(String::new(), |input, command| {
        let arguments = command.trim().strip_prefix("trocar ").expect("a command").split_whitespace();
        let mut trocar = Command::cargo_bin("trocar").expect("built");
        let assert = trocar.current_dir(folder).args(arguments).write_stdin(input).assert().success();
        String::from_utf8(assert.get_output().stdout.clone()).expect("text")
    })
}

#[test]
fn sessions_print_what_the_readme_shows() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::create_dir(folder.path().join("trials")).expect("made");
    std::fs::write(folder.path().join("labels.csv"), &blocks("csv")[0]).expect("written");
    let sessions = blocks("console");
    assert_eq!(sessions.len(), 2);
    for shown in sessions {
        let mut printed = String::new();
        for line in shown.lines().filter_map(|line| line.strip_prefix("$ ")) {
            printed.push_str(&format!("$ {line}\n{}", session(folder.path(), line)));
        }
        assert_eq!(printed, shown);
    }
}

#[test]
fn the_studies_over_seeds_print_what_the_readme_shows() {
    for index in [2, 3] {
        let folder = tempfile::tempdir().expect("a folder");
        let command = blocks("sh")[index].trim().strip_prefix("trocar ").expect("a command").to_owned();
        let printed = trocar(folder.path(), &command);
        let start = printed.find("200 seeds:").expect("a study");
        let study = printed[start..].split("\n\n").next().expect("a table");
        assert_eq!(study, blocks("text")[index].trim_end());
    }
}

#[test]
fn the_pictures_are_what_their_commands_draw() {
    for (index, picture) in [(4, "reflexes.png"), (6, "late_wall.png")] {
        let folder = tempfile::tempdir().expect("a folder");
        trocar(folder.path(), blocks("sh")[index].trim().strip_prefix("trocar ").expect("a command"));
        let drawn = std::fs::read(folder.path().join("out/overlay.png")).expect("drawn");
        let shown = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios").join(picture);
        assert!(drawn == std::fs::read(shown).expect("shown"), "copy out/overlay.png to scenarios/{picture}");
    }
}

#[test]
fn calibrate_prints_what_the_readme_shows() {
    let folder = tempfile::tempdir().expect("a folder");
    let root = env!("CARGO_MANIFEST_DIR");
    let command = blocks("sh").into_iter().find(|block| block.starts_with("trocar calibrate scen")).expect("shown");
    let arguments = command.replace("\\\n", " ").replace("scenarios/", &format!("{root}/scenarios/"));
    let printed = trocar(folder.path(), arguments.trim().strip_prefix("trocar ").expect("a command"));
    assert!(blocks("text").contains(&printed), "paste into README.md:\n{printed}");
}

#[test]
fn roc_prints_and_draws_what_the_readme_shows() {
    let commands: Vec<String> = blocks("sh").into_iter().filter(|block| block.starts_with("trocar roc")).collect();
    let arguments = |index: usize| commands[index].trim().strip_prefix("trocar ").expect("a command").to_owned();
    let folder = tempfile::tempdir().expect("a folder");
    let printed = trocar(folder.path(), &arguments(0));
    assert!(blocks("text").contains(&printed), "paste into README.md:\n{printed}");
    trocar(folder.path(), &arguments(1));
    let drawn = std::fs::read(folder.path().join("out/roc.png")).expect("drawn");
    let shown = std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/roc.png")).expect("shown");
    assert!(drawn == shown, "copy out/roc.png to scenarios/roc.png");
}

#[test]
fn the_sweep_prints_what_the_readme_shows() {
    let folder = tempfile::tempdir().expect("a folder");
    let root = env!("CARGO_MANIFEST_DIR");
    let command = blocks("sh").into_iter().find(|block| block.starts_with("trocar sweep scenarios")).expect("shown");
    let arguments = command.trim().strip_prefix("trocar ").expect("a command");
    let printed = trocar(folder.path(), &arguments.replace("scenarios/", &format!("{root}/scenarios/")));
    assert!(blocks("text").contains(&printed), "paste into README.md:\n{printed}");
    let shown = std::fs::read_to_string(Path::new(root).join("scenarios/sweeps/small.toml")).expect("there");
    assert!(blocks("text").contains(&shown), "paste scenarios/sweeps/small.toml into README.md");
}

#[test]
fn stability_prints_and_draws_what_the_readme_shows() {
    let commands = blocks("sh");
    let commands: Vec<_> = commands.iter().filter(|block| block.starts_with("trocar stability")).collect();
    assert_eq!(commands.len(), 2);
    let folder = tempfile::tempdir().expect("a folder");
    for command in commands {
        let printed = trocar(folder.path(), command.trim().strip_prefix("trocar ").expect("a command"));
        assert!(blocks("text").contains(&printed), "paste into README.md:\n{printed}");
    }
    let drawn = std::fs::read(folder.path().join("out/late-wall/stability.png")).expect("drawn");
    let shown = std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/stability.png")).expect("shown");
    assert!(drawn == shown, "copy out/late-wall/stability.png to scenarios/stability.png");
}

#[test]
fn the_command_of_the_architectures_runs() {
    let folder = tempfile::tempdir().expect("a folder");
    let printed = trocar(folder.path(), blocks("sh")[5].trim().strip_prefix("trocar ").expect("a command"));
    assert!(printed.contains("four-channel"), "{printed}");
}

#[test]
fn the_scenario_of_the_readme_runs() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("my.toml"), &blocks("toml")[0]).expect("written");
    let printed = trocar(folder.path(), "run my.toml --set augmentation.reengage=snap");
    assert!(printed.starts_with("gentler: completed"), "{printed}");
    let root = env!("CARGO_MANIFEST_DIR");
    let pair = format!("{root}/scenarios/real_classical.toml {root}/scenarios/real_augmented.toml");
    let printed = trocar(folder.path(), &format!("compare {pair}"));
    for metric in ["missed ruptures", "false alarms"] {
        let line = printed.lines().find(|line| line.starts_with(metric)).expect("a row");
        assert_eq!(line.split_whitespace().rev().take(2).collect::<Vec<_>>(), ["0", "0"], "{line}");
    }
}

#[test]
fn every_command_of_the_readme_is_one() {
    let folder = tempfile::tempdir().expect("a folder");
    for line in readme().lines().filter(|line| line.starts_with("| `trocar ")) {
        let command = line.trim_start_matches("| `trocar ").split([' ', '`']).next().expect("a word");
        assert!(trocar(folder.path(), &format!("{command} --help")).contains("Usage: trocar"), "{command}");
    }
}
