//! The public names are listed in a file, so that every change is visible: `INSTA_UPDATE=always` updates it.
//!
//! The list comes from the source text: items, public fields, variants and methods, by their `pub use` paths. Items
//! from macros are not included.

use std::collections::{BTreeMap, BTreeSet};

use insta::assert_snapshot;

use crate::layering::modules::{Modules, Place};
use crate::support::file;

/// The items of a part of a source text.
#[derive(Default)]
struct Items {
    /// Public items, each with its public fields, its variants, or the items of a trait.
    public: BTreeMap<String, Names>,
    /// The items that `impl` adds to a type.
    added: BTreeMap<String, Names>,
}

type Names = BTreeSet<String>;

/// Keywords between `pub` and an item's name.
const KINDS: [&str; 11] =
    ["async", "const", "enum", "extern", "fn", "static", "struct", "trait", "type", "union", "unsafe"];

fn is_name(word: &str) -> bool {
    word.starts_with(|c: char| c.is_alphabetic() || c == '_')
}

impl Items {
    /// Parses the words of a module; function bodies are ignored.
    fn read(words: &[String]) -> Self {
        let mut items = Self::default();
        let mut at = 0;
        while at < words.len() {
            let header = at;
            // An item ends at its semicolon, or with its braces.
            while at < words.len() && ![";", "{"].contains(&words[at].as_str()) {
                at = if ["(", "["].contains(&words[at].as_str()) { closing(words, at) + 1 } else { at + 1 };
            }
            at = at.min(words.len());
            let head = &words[header..at];
            let inside = at + 1;
            if words.get(at).is_some_and(|word| word == "{") {
                at = closing(words, at);
            }
            items.take(head, words.get(inside..at).unwrap_or_default());
            at += 1;
        }
        items
    }

    fn take(&mut self, head: &[String], inside: &[String]) {
        let head = without_attributes(head);
        if head.first().is_some_and(|word| word == "impl") {
            if !head.iter().any(|word| word == "for") {
                self.added.entry(implemented(&head)).or_default().extend(Self::read(inside).public.into_keys());
            }
            return;
        }
        let Some(kind) = head.get(1).filter(|kind| head[0] == "pub" && KINDS.contains(&kind.as_str())) else { return };
        let Some(name) = head[1..].iter().find(|word| is_name(word) && !KINDS.contains(&word.as_str())) else { return };
        let members = match kind.as_str() {
            "struct" | "union" => fields(inside),
            "enum" => variants(inside),
            "trait" => trait_items(inside),
            _ => vec![],
        };
        self.public.entry(name.clone()).or_default().extend(members);
    }
}

/// Returns the position of the closing brace for an opening one.
fn closing(words: &[String], open: usize) -> usize {
    let mut depth = 0;
    for (at, word) in words.iter().enumerate().skip(open) {
        depth +=
            i32::from(["{", "(", "["].contains(&word.as_str())) - i32::from(["}", ")", "]"].contains(&word.as_str()));
        if depth == 0 {
            return at;
        }
    }
    words.len()
}

fn without_attributes(words: &[String]) -> Vec<String> {
    let mut rest = words;
    while rest.len() > 1 && rest[0] == "#" {
        let open = 1 + usize::from(rest[1] == "!");
        rest = rest.get(closing(rest, open) + 1..).unwrap_or_default();
    }
    rest.to_vec()
}

/// Returns the type of an `impl<…> Type<…>`.
fn implemented(head: &[String]) -> String {
    let mut depth = 0;
    for word in &head[1..] {
        match word.as_str() {
            "<" => depth += 1,
            ">" => depth -= 1,
            name if depth == 0 && is_name(name) => return name.to_owned(),
            _ => {}
        }
    }
    String::new()
}

/// Splits a list at the commas outside of brackets.
fn parts(words: &[String]) -> Vec<Vec<String>> {
    let mut parts = vec![vec![]];
    let mut depth = 0;
    for word in words {
        match word.as_str() {
            "(" | "[" | "{" | "<" => depth += 1,
            ")" | "]" | "}" | ">" => depth -= 1,
            "," if depth == 0 => {
                parts.push(vec![]);
                continue;
            }
            _ => {}
        }
        parts.last_mut().expect("one").push(word.clone());
    }
    parts.iter().map(|part| without_attributes(part)).filter(|part| !part.is_empty()).collect()
}

fn fields(inside: &[String]) -> Vec<String> {
    parts(inside).into_iter().filter(|part| part[0] == "pub" && part[1] != "(").map(|part| part[1].clone()).collect()
}

fn variants(inside: &[String]) -> Vec<String> {
    parts(inside).into_iter().map(|part| part[0].clone()).collect()
}

/// Returns the functions, types and constants of a trait.
fn trait_items(inside: &[String]) -> Vec<String> {
    let public = |word: &String| {
        let is_item = ["fn", "type", "const"].contains(&word.as_str());
        [is_item.then(|| "pub".to_owned()), Some(word.clone())].into_iter().flatten()
    };
    Items::read(&inside.iter().flat_map(public).collect::<Vec<_>>()).public.into_keys().collect()
}

/// The public names of a package.
struct Api<'a> {
    modules: &'a Modules,
    items: BTreeMap<&'a Place, Items>,
    /// The items that `impl` adds to a type in any module, by the module that defines the type.
    added: BTreeMap<(Place, String), Names>,
    lines: Names,
}

impl<'a> Api<'a> {
    fn of(package: &str, modules: &'a Modules) -> Names {
        let items: BTreeMap<_, _> = modules.places().map(|place| (place, Items::read(modules.words(place)))).collect();
        let mut added: BTreeMap<(Place, String), Names> = BTreeMap::new();
        for (place, items) in &items {
            for (name, names) in &items.added {
                if let Ok((place, rest)) = modules.named(place, name) {
                    added.entry((place, rest.join("::"))).or_default().extend(names.iter().cloned());
                }
            }
        }
        let mut api = Self { modules, items, added, lines: Names::new() };
        api.list_module(&Place::new(), package);
        api.lines
    }

    /// Lists a module under its public path.
    fn list_module(&mut self, place: &Place, path: &str) {
        let names: Vec<String> = self.items[place].public.keys().cloned().collect();
        for name in names {
            self.list_item(place, &name, &format!("{path}::{name}"));
        }
        let words = self.modules.words(place);
        for declared in words.windows(3).filter(|three| three[0] == "pub" && three[1] == "mod") {
            let below = [&place[..], &declared[2..]].concat();
            if self.items.contains_key(&below) {
                self.list_module(&below, &format!("{path}::{}", declared[2]));
            }
        }
        for name in self.modules.exports(place) {
            let path = format!("{path}::{name}");
            match self.modules.named(place, name) {
                Ok((place, rest)) if rest.is_empty() => self.list_module(&place, &path),
                Ok((place, rest)) => self.list_item(&place, &rest.join("::"), &path),
                Err(outside) => {
                    self.lines.insert(format!("{path} = {}", outside.join("::")));
                }
            }
        }
    }

    fn list_item(&mut self, place: &Place, name: &str, path: &str) {
        self.lines.insert(path.to_owned());
        let own = self.items[place].public.get(name).into_iter().flatten();
        let added = self.added.get(&(place.clone(), name.to_owned())).into_iter().flatten();
        self.lines.extend(own.chain(added).map(|member| format!("{path}::{member}")));
    }
}

#[test]
fn the_public_names_are_those_of_the_list() {
    let mut lines = Names::new();
    for (folder, package) in
        [("core", "trocar_core"), ("sim", "trocar_sim"), ("report", "trocar_report"), (".", "trocar")]
    {
        lines.extend(Api::of(package, &Modules::of_package(&file(folder))));
    }
    assert_snapshot!("public_api", lines.into_iter().collect::<Vec<_>>().join("\n"));
}

#[test]
fn public_names_are_found_under_every_public_path() {
    let mut modules = Modules::default();
    let sources = [
        ("", "pub mod open; mod closed; pub use closed::Shown as Seen; pub use other::thing;"),
        ("open", "pub(crate) fn hidden() {} pub const fn f(a: [u8; 2]) -> u8 { pub_in(); 1 } pub const N: [u8; 2] = [1; 2];"),
        (
            "closed",
            "pub struct Shown<T> { pub a: Box<dyn Fn(u8) -> T>, b: u8, #[doc(hidden)] pub c: u8 } pub struct Unseen;
            impl<T: Copy> Shown<T> { pub fn new() -> Self { } fn own(&self) {} } impl Clone for Shown<u8> { fn clone() {} }",
        ),
        ("closed::more", "use super::Shown; impl Shown<u8> { pub fn of_bytes() {} }"),
        ("open::kinds", "pub enum Kind { One, Two(u8, u8), Three { a: u8 } } pub trait Role { type A; fn act(&self); }"),
    ];
    for (path, text) in sources {
        let place = path.split("::").filter(|word| !word.is_empty()).map(str::to_owned).collect();
        modules.insert(place, &text.replace("pub(crate) fn hidden", "pub mod kinds; pub(crate) fn hidden"));
    }
    let kinds = ["Kind", "Kind::One", "Kind::Three", "Kind::Two", "Role", "Role::A", "Role::act"];
    let seen = ["", "::a", "::c", "::new", "::of_bytes"].map(|member| format!("p::Seen{member}"));
    let open = ["N".to_owned(), "f".to_owned()].into_iter().chain(kinds.map(|kind| format!("kinds::{kind}")));
    let open = open.map(|name| format!("p::open::{name}"));
    let expected: Names = seen.into_iter().chain(open).chain(["p::thing = other::thing".to_owned()]).collect();
    assert_eq!(Api::of("p", &modules), expected);
}
