//! The layers: a module uses only modules of lower layers, on layer 2 no sibling, and no modules form a circle.

mod circles;
pub mod modules;
mod words;

use std::collections::BTreeSet;

use super::support::file;
use circles::{Graph, circles, siblings};
use modules::{Modules, Place};

/// The folders of the packages, and their crate names.
const PACKAGES: [(&str, &str); 5] =
    [("core", "trocar_core"), ("sim", "trocar_sim"), ("report", "trocar_report"), (".", "trocar"), ("python", "_core")];

/// Every module with its layer; the parts of a controller, which are the package core, are below those of the
/// simulator. A module is at the top of its package; the whole of trocar-report counts as one.
const ROOMS: [(&str, u8); 40] = [
    ("error", 0),
    ("lane", 0),
    ("large_pages", 0),
    ("parallel", 0),
    ("interrupt", 0),
    ("moments", 0),
    ("quantiles", 0),
    ("rows", 0),
    ("settings", 0),
    ("time", 0),
    ("warning", 0),
    ("lti", 1),
    ("augmentation", 1),
    ("chain", 1),
    ("detection", 1),
    ("estimation", 1),
    ("rig", 1),
    ("plant", 2),
    ("population", 2),
    ("tissue", 2),
    ("operator", 2),
    ("channel", 2),
    ("sensor", 2),
    ("recording", 2),
    ("teleoperation", 3),
    ("engine", 4),
    ("scenario", 5),
    ("metrics", 5),
    ("stability", 5),
    ("run", 6),
    ("compare", 6),
    ("detect", 6),
    ("fmu", 6),
    ("remote", 6),
    ("roc", 6),
    ("sweep", 6),
    ("stability_check", 6),
    ("report", 7),
    ("explore", 7),
    ("cli", 7),
];

fn floor(room: &str) -> Option<u8> {
    ROOMS.iter().find(|(name, _)| *name == room).map(|(_, floor)| *floor)
}

/// Returns the top module of a module or path; `None` for the root of a package.
fn room<'a>(package: &str, words: &'a [String]) -> Option<&'a str> {
    if package == "trocar_report" { Some("report") } else { words.first().map(String::as_str) }
}

/// Returns the forbidden uses of a module of a package.
fn offences(package: &str, modules: &Modules, place: &Place) -> BTreeSet<String> {
    let Some(own) = room(package, place) else { return BTreeSet::new() };
    let own_floor = floor(own).unwrap_or_else(|| panic!("{own} has no floor: give it one here"));
    let mut wrong = BTreeSet::new();
    for path in modules.paths(place) {
        let other = PACKAGES.iter().map(|(_, name)| *name).find(|name| path[0] == *name);
        if other.is_none() && path[0] != "crate" {
            continue;
        }
        let Some(used) = room(other.unwrap_or(package), &path[1..]) else { continue };
        let offends = match floor(used) {
            _ if used == own => false,
            // The linear analysis predicts the engine and must not use it.
            Some(_) if own == "stability" && used == "engine" => true,
            Some(floor) => floor > own_floor || (own_floor == 2 && floor == 2),
            None => false,
        };
        if offends {
            wrong.insert(used.to_owned());
        }
    }
    wrong
}

fn package(folder: &str) -> Modules {
    Modules::of_package(&file(folder))
}

#[test]
fn no_floor_knows_a_higher_one() {
    for (folder, name) in PACKAGES.into_iter().filter(|(folder, _)| *folder != "python") {
        let modules = package(folder);
        assert!(modules.places().count() > 20, "{folder}");
        for place in modules.places() {
            let wrong = offences(name, &modules, place);
            assert!(wrong.is_empty(), "{folder}: {} uses {wrong:?}", place.join("::"));
        }
    }
}

#[test]
fn no_modules_form_a_circle() {
    let mut found: BTreeSet<(String, Vec<String>)> = BTreeSet::new();
    for (folder, _) in PACKAGES {
        for (place, graph) in siblings(&package(folder)) {
            found.extend(circles(&graph).into_iter().map(|circle| (format!("{folder}::{}", place.join("::")), circle)));
        }
    }
    assert!(found.is_empty(), "{found:?}");
}

#[test]
fn only_the_top_floor_prints_or_draws() {
    for (folder, name) in PACKAGES.into_iter().filter(|(folder, _)| *folder != "python") {
        let modules = package(folder);
        for place in modules.places() {
            if ["report", "cli"].contains(&room(name, place).unwrap_or_default()) {
                continue;
            }
            for forbidden in ["println", "print", "eprintln", "eprint", "plotters", "anstream", "stdout"] {
                assert!(
                    !modules.words(place).iter().any(|word| word == forbidden),
                    "{folder}: {} has {forbidden}",
                    place.join("::")
                );
            }
        }
    }
}

fn place(path: &str) -> Place {
    path.split("::").filter(|word| !word.is_empty()).map(str::to_owned).collect()
}

fn made_up(sources: &[(&str, &str)]) -> Modules {
    let mut modules = Modules::default();
    for (path, text) in [("", "")].iter().chain(sources) {
        modules.insert(place(path), text);
    }
    modules
}

#[test]
fn rooms_are_found_however_they_are_written() {
    let wrong = |package: &str, room: &str, text: &str| {
        let modules = made_up(&[(room, text)]);
        offences(package, &modules, &place(room)).into_iter().collect::<Vec<_>>()
    };
    assert_eq!(wrong("trocar_sim", "tissue", "use crate::engine::Engine;"), ["engine"]);
    assert_eq!(wrong("trocar_sim", "tissue", "use super::engine::Engine;"), ["engine"]);
    assert_eq!(wrong("trocar_sim", "tissue", "use crate::sensor::Sensor;"), ["sensor"]);
    assert_eq!(wrong("trocar_core", "lane", "use crate::detection::Detector;"), ["detection"]);
    assert_eq!(wrong("trocar_sim", "tissue", "use trocar_sim::metrics::Metrics;"), ["metrics"]);
    assert_eq!(wrong("trocar_sim", "lti", "use crate::{error::InvalidValue, plant::{a, b}, lane::Lane};"), ["plant"]);
    assert_eq!(wrong("trocar_sim", "stability", "use crate::engine::Engine;"), ["engine"]);
    assert_eq!(wrong("trocar_sim", "lti", "fn f() { trocar_report::figures::draw() }"), ["report"]);
    assert_eq!(wrong("trocar_sim", "sweep", "fn f(a: &'a str) -> crate::cli::Args<'a> { 'c' }"), ["cli"]);
    let fine = [
        "use crate::tissue::Tissue; // crate::cli is far above",
        "/* crate::cli */ const TEXT: &str = r#\"crate::cli \" crate::cli\"#;",
        "#[cfg(test)] mod tests { use crate::cli::Args; fn f() { {} } }",
    ];
    for text in fine {
        assert!(wrong("trocar_sim", "engine", text).is_empty(), "{text}");
    }
}

#[test]
fn circles_are_found_at_any_depth() {
    let found = |sources: &[(&str, &str)]| -> Vec<(String, Vec<String>)> {
        let graphs = siblings(&made_up(sources)).into_iter();
        graphs.flat_map(|(at, graph)| circles(&graph).into_iter().map(move |names| (at.join("::"), names))).collect()
    };
    let circle = |at: &str, names: &[&str]| (at.to_owned(), names.iter().map(|name| (*name).to_owned()).collect());

    let direct = [("a", "use crate::b::B;"), ("b", "use super::a::A;")];
    assert_eq!(found(&direct), [circle("", &["a", "b"])]);
    let around =
        [("a", "use crate::b::B;"), ("b", "fn f() { crate::c::d::e(); }"), ("c", ""), ("c::d", "use super::super::a;")];
    assert_eq!(found(&around), [circle("", &["a", "b", "c"])]);
    let deep = [("r", "mod a; mod b;"), ("r::a", "use super::b::B;"), ("r::b", "use crate::r::{a::{self, A}, Other};")];
    assert_eq!(found(&deep), [circle("r", &["a", "b"])]);
    let two =
        [("a", "use crate::b::B;"), ("b", "use crate::a::A;"), ("c", "use crate::d::D;"), ("d", "use crate::c::C;")];
    assert_eq!(found(&two), [circle("", &["a", "b"]), circle("", &["c", "d"])]);

    let by_another_name =
        [("r", "pub use a::A; pub use b::B as C;"), ("r::a", "use super::C;"), ("r::b", "use super::A;")];
    assert_eq!(found(&by_another_name), [circle("r", &["a", "b"])]);
    let by_the_root = [("", "pub use a::A;"), ("a", "use crate::b::B;"), ("b", "use crate::A;")];
    assert_eq!(found(&by_the_root), [circle("", &["a", "b"])]);

    let parent_and_child =
        [("a", "mod b; use b::B; pub struct A;"), ("a::b", "use super::A; use crate::a::{self, A as Other};")];
    assert!(found(&parent_and_child).is_empty());
    let in_order = [("a", "use crate::{b::B, c::C};"), ("b", "use crate::c::C;"), ("c", "use other::c::C;")];
    assert!(found(&in_order).is_empty());
}

#[test]
fn a_graph_without_a_way_back_has_no_circle() {
    let graph = |edges: &[(&str, &str)]| {
        let mut graph = Graph::new();
        for (user, used) in edges {
            graph.entry((*user).to_owned()).or_default().insert((*used).to_owned());
        }
        graph
    };
    assert!(circles(&graph(&[("a", "b"), ("a", "c"), ("b", "d"), ("c", "d")])).is_empty());
    assert_eq!(
        circles(&graph(&[("a", "b"), ("b", "c"), ("c", "b"), ("c", "d")])),
        [["b".into(), "c".into()].to_vec()].into()
    );
}
