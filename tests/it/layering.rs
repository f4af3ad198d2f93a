//! The floors of the house: a room knows only the floors below its own, and on floor 2 no sibling.

use std::fs;
use std::path::Path;

use crate::support::rust_files;

/// Every room with its floor.
const ROOMS: [(&str, u8); 32] = [
    ("error", 0),
    ("lane", 0),
    ("moments", 0),
    ("quantiles", 0),
    ("settings", 0),
    ("time", 0),
    ("lti", 1),
    ("plant", 2),
    ("tissue", 2),
    ("operator", 2),
    ("channel", 2),
    ("sensor", 2),
    ("estimation", 2),
    ("detection", 2),
    ("recording", 2),
    ("augmentation", 3),
    ("teleoperation", 3),
    ("engine", 4),
    ("rig", 4),
    ("scenario", 5),
    ("metrics", 5),
    ("stability", 5),
    ("run", 6),
    ("compare", 6),
    ("detect", 6),
    ("roc", 6),
    ("sweep", 6),
    ("stability_check", 6),
    ("report", 7),
    ("explore", 7),
    ("cli", 7),
    ("main", 8),
];

fn floor(room: &str) -> Option<u8> {
    ROOMS.iter().find(|(name, _)| *name == room).map(|(_, floor)| *floor)
}

/// The rooms that a source text refers to: `crate::room` and `crate::{room, …}`, comments left out.
fn rooms_used(text: &str) -> Vec<String> {
    let code: String = text.lines().filter(|line| !line.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n");
    let word = |text: &str| text.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>();
    let mut used = vec![];
    for (at, _) in code.match_indices("crate::") {
        let rest = &code[at + "crate::".len()..];
        if let Some(group) = rest.strip_prefix('{') {
            let group = &group[..group.find(';').unwrap_or(group.len())];
            let mut depth = 0;
            let mut start = true;
            for (i, c) in group.char_indices() {
                match c {
                    '{' => depth += 1,
                    '}' => depth -= 1,
                    ',' if depth == 0 => start = true,
                    c if start && !c.is_whitespace() => {
                        used.push(word(&group[i..]));
                        start = false;
                    }
                    _ => {}
                }
                if depth < 0 {
                    break;
                }
            }
        } else {
            used.push(word(rest));
        }
    }
    used
}

/// What is wrong with a file that belongs to a room.
fn offences(room: &str, text: &str) -> Vec<String> {
    let own = floor(room).unwrap_or_else(|| panic!("{room} has no floor: give it one here and in lib.rs"));
    let offends = |used: &String| match floor(used) {
        Some(_) if used == room => false,
        // What the engine does is to be foretold, not looked up.
        Some(_) if room == "stability" && used == "engine" => true,
        Some(other) => other > own || (own == 2 && other == 2),
        None => false,
    };
    rooms_used(text).into_iter().filter(offends).collect()
}

#[test]
fn no_floor_knows_a_higher_one() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = vec![];
    rust_files(&source, &mut files);
    assert!(files.len() > 50);
    let mut wrong = vec![];
    for file in files {
        let inside = file.strip_prefix(&source).expect("in src");
        let first = inside.components().next().expect("a name").as_os_str().to_string_lossy().replace(".rs", "");
        if first == "lib" {
            continue;
        }
        let text = fs::read_to_string(&file).expect("text");
        for way_round in ["crate::*", "crate as ", "super::super::super"] {
            assert!(!text.contains(way_round), "{} has {way_round}, which this check does not see", inside.display());
        }
        for used in offences(&first, &text) {
            wrong.push(format!("{} uses {used}", inside.display()));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn the_check_sees_what_it_should() {
    assert_eq!(offences("tissue", "use crate::engine::Engine;"), ["engine"]);
    assert_eq!(offences("tissue", "use crate::sensor::Sensor;"), ["sensor"]);
    assert_eq!(offences("lti", "use crate::{error::InvalidValue, plant::{a, b}, lane::Lane};"), ["plant"]);
    assert_eq!(offences("stability", "use crate::engine::Engine;"), ["engine"]);
    assert_eq!(offences("lti", "fn f() { crate::report::figures::draw() }"), ["report"]);
    assert!(offences("engine", "use crate::tissue::Tissue;\n// crate::cli is far above").is_empty());
}

#[test]
fn only_the_top_floor_prints_or_draws() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = vec![];
    rust_files(&source, &mut files);
    for file in files {
        let inside = file.strip_prefix(&source).expect("in src").display().to_string();
        if inside.starts_with("report") || inside.starts_with("cli") {
            continue;
        }
        let text = fs::read_to_string(&file).expect("text");
        for forbidden in ["println!", "print!(", "plotters", "anstream", "stdout()"] {
            assert!(!text.contains(forbidden), "{inside} has {forbidden}");
        }
    }
}
