//! The library without default features, as a program beside trocar builds it.

use std::collections::BTreeSet;
use std::fs;
use std::process::Command;

use crate::support::file;
use crate::support::test_folder::TestFolder;

/// Maximum number of packages, with that of the program.
const PACKAGES: usize = 60;

const MANIFEST: &str = r#"
[package]
name = "program"
version = "0.1.0"
edition = "2024"

[dependencies]
trocar = { path = "PATH", default-features = false }
"#;

/// The program has this repository's Cargo.lock. Cargo then resolves the dependencies without a network.
#[test]
fn a_program_with_the_light_library_builds_few_packages() {
    let folder = TestFolder::new();
    let path = env!("CARGO_MANIFEST_DIR").replace('\\', "/");
    let source = fs::read(file("examples/light.rs")).expect("there");
    folder
        .file("Cargo.toml", MANIFEST.replace("PATH", &path))
        .file("Cargo.lock", fs::read(file("Cargo.lock")).expect("there"))
        .file("src/main.rs", &source);
    let tree = Command::new(env!("CARGO"))
        .args(["tree", "--offline", "--edges", "normal,build", "--prefix", "none", "--format", "{p}"])
        .current_dir(folder.path("."))
        .output()
        .expect("runs");
    assert!(tree.status.success(), "{}", String::from_utf8_lossy(&tree.stderr));
    let lines = String::from_utf8(tree.stdout).expect("text");
    // The name and the version; the rest is the path, and marks of macros and repeated packages.
    let of_line = |line: &str| line.split(' ').take(2).collect::<Vec<_>>().join(" ");
    let packages: BTreeSet<String> = lines.lines().filter(|line| !line.is_empty()).map(of_line).collect();
    assert!((40..=PACKAGES).contains(&packages.len()), "{} packages: {packages:?}", packages.len());
}

#[test]
fn the_example_of_the_light_library_is_short() {
    let source = fs::read_to_string(file("examples/light.rs")).expect("there");
    assert!(source.lines().count() <= 15, "{}", source.lines().count());
}
