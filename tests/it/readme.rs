//! The commands of the README run, and their output and figures are those in the README.

use super::support::file;
use super::support::test_folder::TestFolder;

fn readme() -> String {
    std::fs::read_to_string(file("README.md")).expect("there")
}

/// Returns the fenced blocks of a language.
fn blocks(language: &str) -> Vec<String> {
    let text = readme();
    let opening = format!("```{language}\n");
    text.split(&opening).skip(1).map(|rest| rest.split("```").next().unwrap_or_default().to_owned()).collect()
}

/// Returns the arguments of a shell line that calls trocar.
fn arguments(line: &str) -> Vec<&str> {
    line.trim().strip_prefix("trocar ").expect("a command").split_whitespace().collect()
}

/// Runs a command of the README, with the paths of the project, and returns its output.
fn printed(folder: &TestFolder, command: &str) -> String {
    let command = command.replace("\\\n", " ").replace(" scenarios/", &format!(" {}/", file("scenarios").display()));
    folder.good(&arguments(&command))
}

/// Checks that a text is a block of the README.
fn assert_is_shown(text: &str) {
    assert!(blocks("text").iter().any(|block| block == text), "paste into README.md:\n{text}");
}

/// Checks that a figure is a picture of the README.
fn assert_picture(folder: &TestFolder, drawn: &str, shown: &str) {
    let read = |path| std::fs::read(path).expect("there");
    assert!(read(folder.path(drawn)) == read(file(shown)), "copy {drawn} to {shown}");
}

#[test]
fn the_first_screen_has_the_two_commands_and_they_are_the_projects() {
    let first = blocks("sh").remove(0);
    assert!(first.contains("cargo run --release -- compare"), "{first}");
    assert!(first.contains("cargo test"), "{first}");
    let gate = std::fs::read_to_string(file(".ci/run")).expect("there");
    assert!(gate.lines().any(|line| line == "cargo test --workspace"));
}

#[test]
fn compare_prints_and_draws_what_the_readme_shows() {
    let folder = TestFolder::new();
    let printed = printed(&folder, "trocar compare");
    assert_eq!(printed, blocks("text")[0], "paste what `trocar compare` prints into README.md");
    assert_picture(&folder, "out/overlay.png", "scenarios/overlay.png");
}

#[test]
fn detect_prints_what_the_readme_shows() {
    assert_eq!(printed(&TestFolder::new(), &blocks("sh")[1]), blocks("text")[1]);
}

/// Runs a line of a session in a folder, with commands joined by `|`, and returns the output of the last one.
fn session(folder: &TestFolder, line: &str) -> String {
    line.split(" | ").fold(String::new(), |input, command| {
        let outcome = folder.fed(&arguments(command), input.as_bytes());
        assert_eq!(outcome.code, 0, "{command}: {}", outcome.err);
        outcome.out
    })
}

#[test]
fn sessions_print_what_the_readme_shows() {
    let folder = TestFolder::new();
    std::fs::create_dir(folder.path("trials")).expect("made");
    folder.file("labels.csv", &blocks("csv")[0]);
    let sessions = blocks("console");
    assert_eq!(sessions.len(), 2);
    for shown in sessions {
        let mut printed = String::new();
        for line in shown.lines().filter_map(|line| line.strip_prefix("$ ")) {
            printed.push_str(&format!("$ {line}\n{}", session(&folder, line)));
        }
        assert_eq!(printed, shown);
    }
}

#[test]
fn the_studies_over_seeds_print_what_the_readme_shows() {
    for index in [2, 3] {
        let printed = printed(&TestFolder::new(), &blocks("sh")[index]);
        let start = printed.find("200 seeds:").expect("a study");
        let study = printed[start..].split("\n\n").next().expect("a table");
        assert_eq!(study, blocks("text")[index].trim_end());
    }
}

#[test]
fn the_pictures_are_what_their_commands_draw() {
    for (index, picture) in [(4, "scenarios/reflexes.png"), (6, "scenarios/late_wall.png")] {
        let folder = TestFolder::new();
        printed(&folder, &blocks("sh")[index]);
        assert_picture(&folder, "out/overlay.png", picture);
    }
}

#[test]
fn calibrate_prints_what_the_readme_shows() {
    let command = blocks("sh").into_iter().find(|block| block.starts_with("trocar calibrate scen")).expect("shown");
    assert_is_shown(&printed(&TestFolder::new(), &command));
}

#[test]
fn roc_prints_and_draws_what_the_readme_shows() {
    let commands: Vec<String> = blocks("sh").into_iter().filter(|block| block.starts_with("trocar roc")).collect();
    let folder = TestFolder::new();
    assert_is_shown(&printed(&folder, &commands[0]));
    printed(&folder, &commands[1]);
    assert_picture(&folder, "out/roc.png", "scenarios/roc.png");
}

#[test]
fn the_sweep_prints_what_the_readme_shows() {
    let command = blocks("sh").into_iter().find(|block| block.starts_with("trocar sweep scenarios")).expect("shown");
    assert_is_shown(&printed(&TestFolder::new(), &command));
    assert_is_shown(&std::fs::read_to_string(file("scenarios/sweeps/small.toml")).expect("there"));
}

#[test]
fn stability_prints_and_draws_what_the_readme_shows() {
    let commands = blocks("sh");
    let commands: Vec<_> = commands.iter().filter(|block| block.starts_with("trocar stability")).collect();
    assert_eq!(commands.len(), 2);
    let folder = TestFolder::new();
    for command in commands {
        assert_is_shown(&printed(&folder, command));
    }
    assert_picture(&folder, "out/late-wall/stability.png", "scenarios/stability.png");
}

#[test]
fn the_command_of_the_architectures_runs() {
    let printed = printed(&TestFolder::new(), &blocks("sh")[5]);
    assert!(printed.contains("four-channel"), "{printed}");
}

#[test]
fn the_scenario_of_the_readme_runs() {
    let folder = TestFolder::new();
    folder.file("my.toml", &blocks("toml")[0]);
    let gentler = printed(&folder, "trocar run my.toml --set augmentation.reengage=snap");
    assert!(gentler.starts_with("gentler: completed"), "{gentler}");
    let compared = printed(&folder, "trocar compare scenarios/real_classical.toml scenarios/real_augmented.toml");
    for metric in ["missed ruptures", "false alarms"] {
        let line = compared.lines().find(|line| line.starts_with(metric)).expect("a row");
        assert_eq!(line.split_whitespace().rev().take(2).collect::<Vec<_>>(), ["0", "0"], "{line}");
    }
}

#[test]
fn every_command_of_the_readme_is_one() {
    let folder = TestFolder::new();
    for line in readme().lines().filter(|line| line.starts_with("| `trocar ")) {
        let command = line.trim_start_matches("| `trocar ").split([' ', '`']).next().expect("a word");
        assert!(folder.good(&[command, "--help"]).contains("Usage: trocar"), "{command}");
    }
}
