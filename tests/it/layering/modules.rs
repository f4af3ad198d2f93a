//! The modules of a package and their references, from the source text.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use super::words::words;

/// The path of a module from the root of its package: `["figures", "canvas"]`; empty for the root.
pub type Place = Vec<String>;

/// The words of a path.
type Words = Vec<String>;

/// The modules of one package with their own files, without tests.
#[derive(Default)]
pub struct Modules(BTreeMap<Place, Module>);

#[derive(Default)]
struct Module {
    /// Every path of a `use`, and every other path that starts with `crate`, `super`, `self` or a package of this
    /// project.
    paths: Vec<Words>,
    /// The imports, by their local names.
    imports: BTreeMap<String, Words>,
    /// The public imports.
    exports: BTreeSet<String>,
    words: Words,
}

impl Modules {
    /// Returns the modules of the package in a folder.
    pub fn of_package(folder: &Path) -> Self {
        let mut modules = Self::default();
        modules.read_folder(&folder.join("src"), &Place::new());
        modules
    }

    fn read_folder(&mut self, folder: &Path, at: &Place) {
        for entry in fs::read_dir(folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            let name = path.file_stem().expect("a name").to_string_lossy().into_owned();
            let place = if ["lib", "main", "mod"].contains(&&*name) { at.clone() } else { below(at, &name) };
            if path.is_dir() {
                self.read_folder(&path, &place);
            } else if path.extension().is_some_and(|ending| ending == "rs") && name != "tests" && name != "fixtures" {
                self.insert(place, &fs::read_to_string(&path).expect("text"));
            }
        }
    }

    /// Adds a module's source text. A package's `lib.rs` and `main.rs` are one module, the root.
    pub fn insert(&mut self, place: Place, text: &str) {
        let module = self.0.entry(place).or_default();
        let words = words(text);
        let mut at = 0;
        while at < words.len() {
            let is_use = words[at] == "use";
            let word = |index: usize| words.get(index).map_or("", String::as_str);
            let is_start = ["crate", "super", "self"].contains(&word(at)) || word(at).starts_with("trocar");
            if !is_use && !(is_start && word(at + 1) == "::" && (at == 0 || words[at - 1] != "::")) {
                at += 1;
                continue;
            }
            let is_public = at > 0 && words[at - 1] == "pub";
            let mut tree = PathTree { words: &words, at: at + usize::from(is_use), paths: vec![] };
            tree.read(&[]);
            at = tree.at.max(at + 1);
            for (path, name) in tree.paths {
                if is_use {
                    if is_public {
                        module.exports.insert(name.clone());
                    }
                    module.imports.insert(name, path.clone());
                }
                module.paths.push(path);
            }
        }
        module.words.extend(words);
    }

    /// Returns the paths of all modules.
    pub fn places(&self) -> impl Iterator<Item = &Place> {
        self.0.keys()
    }

    /// Returns the words of a module's code.
    pub fn words(&self, place: &Place) -> &[String] {
        &self.0[place].words
    }

    /// Returns the names that a module re-exports publicly.
    pub fn exports(&self, place: &Place) -> impl Iterator<Item = &String> {
        self.0[place].exports.iter()
    }

    /// Returns the paths that a module refers to: from `crate` or from another package.
    pub fn paths<'a>(&'a self, place: &'a Place) -> impl Iterator<Item = Words> + 'a {
        self.0[place].paths.iter().map(|path| self.absolute(place, path))
    }

    /// Returns the modules of this package that a module refers to. A re-exported name counts for the module that
    /// defines it.
    pub fn used(&self, place: &Place) -> Vec<Place> {
        self.0[place].paths.iter().filter_map(|path| Some(self.definition(place, path, 0).ok()?.0)).collect()
    }

    /// Returns the definition of a name in a module: the defining module and the name there, or the path into another
    /// package.
    pub fn named(&self, place: &Place, name: &str) -> Result<(Place, Words), Words> {
        let here = [vec!["crate".to_owned()], place.clone(), vec![name.to_owned()]].concat();
        self.definition(place, &here, 0)
    }

    /// Returns a path from the root of the package; a path into another package is unchanged.
    fn absolute(&self, place: &Place, path: &[String]) -> Words {
        let ups = path.iter().take_while(|word| *word == "super").count();
        let (from, rest) = match path[0].as_str() {
            "crate" => (&[][..], &path[1..]),
            "self" => (&place[..], &path[1..]),
            "super" => (&place[..place.len().saturating_sub(ups)], &path[ups..]),
            child if self.0.contains_key(&below(place, child)) => (&place[..], path),
            _ => return path.to_vec(),
        };
        ["crate".to_owned()].iter().chain(from).chain(rest).cloned().collect()
    }

    /// Returns the definition of a path in a module: the defining module and the rest of the path there, or the path
    /// into another package.
    fn definition(&self, place: &Place, path: &[String], depth: usize) -> Result<(Place, Words), Words> {
        assert!(depth < 20, "{path:?} in {place:?} has no end");
        let absolute = self.absolute(place, path);
        if absolute[0] != "crate" {
            return Err(absolute);
        }
        let mut at = Place::new();
        for (index, word) in absolute.iter().enumerate().skip(1) {
            if self.0.contains_key(&below(&at, word)) {
                at.push(word.clone());
                continue;
            }
            let import = self.0.get(&at).and_then(|module| module.imports.get(word));
            return match import {
                Some(import) => self.definition(&at, &[import, &absolute[index + 1..]].concat(), depth + 1),
                None => Ok((at, absolute[index..].to_vec())),
            };
        }
        Ok((at, vec![]))
    }
}

fn below(place: &Place, name: &str) -> Place {
    place.iter().cloned().chain([name.to_owned()]).collect()
}

/// Parses `a::{b, c::d as e}` into paths, each with its local name.
struct PathTree<'a> {
    words: &'a [String],
    at: usize,
    paths: Vec<(Words, String)>,
}

impl PathTree<'_> {
    fn word(&self) -> &str {
        self.words.get(self.at).map_or("", String::as_str)
    }

    fn read(&mut self, before: &[String]) {
        if self.word() == "{" {
            self.at += 1;
            while !["}", ""].contains(&self.word()) {
                self.read(before);
                self.at += usize::from(self.word() == ",");
            }
            self.at += 1;
            return;
        }
        let mut path = before.to_vec();
        if self.word() != "self" || before.is_empty() {
            path.push(self.word().to_owned());
        }
        self.at += 1;
        let goes_on = self.words.get(self.at + 1).is_some_and(|next| next != "<");
        if self.word() == "::" && goes_on {
            self.at += 1;
            return self.read(&path);
        }
        let mut name = path[path.len() - 1].clone();
        if self.word() == "as" {
            name = self.words[self.at + 1].clone();
            self.at += 2;
        }
        self.paths.push((path, name));
    }
}
