//! One declaration per setting: the field, its default, its range, its key in scenarios, and how it is read.
//!
//! [`settings!`](crate::settings!) declares the settings of a part, [`choice!`](crate::choice!) the kinds of one
//! setting. Both generate a table of [`Key`]s, in the order of the fields, and a reader from any [`KeySource`]. Neither
//! allocates.

mod declare;
mod range;
mod text;

pub use range::Range;
pub use text::{Sentence, sentence, sentence_len};

use core::fmt;

/// The type of a key's value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kind {
    /// A number within a range.
    Number(Range),
    /// A whole number from a minimum to 2⁶³ - 1.
    Whole(u64),
    /// 1 or -1.
    Sign,
    /// A list of numbers within [`Range::ANY`].
    Numbers,
    /// True or false.
    Flag,
    /// One of the listed words.
    Choice(&'static [&'static str]),
    /// Any text.
    Text,
    /// A file, relative to the scenario's folder, or `builtin:` and a name.
    File,
}

impl fmt::Display for Kind {
    /// Writes the requirement on the value, as the end of "must be …".
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(range) => range.fmt(f),
            Self::Whole(min) => write!(f, "a whole number of at least {min}"),
            Self::Sign => f.write_str("1 or -1"),
            Self::Numbers => f.write_str("a list of numbers, as in [1.0, 2.5]"),
            Self::Flag => f.write_str("true or false"),
            Self::Choice(words) => {
                f.write_str("one of ")?;
                words.iter().enumerate().try_for_each(|(index, word)| {
                    let comma = if index == 0 { "" } else { ", " };
                    write!(f, "{comma}\"{word}\"")
                })
            }
            Self::Text => f.write_str("a string, as in \"name\""),
            Self::File => f.write_str("the path of a file, as in \"insertion.csv\""),
        }
    }
}

/// The value of a default.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Constant {
    /// A number.
    Number(f64),
    /// A whole number.
    Whole(u64),
    /// A list of numbers.
    Numbers(&'static [f64]),
    /// True or false.
    Flag(bool),
    /// A word or any text.
    Text(&'static str),
}

/// The value of a key that is not given.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fallback {
    /// A value.
    Value(Constant),
    /// Derived from other keys by the described rule.
    Derived(&'static str),
    /// No value.
    Unset,
}

/// Maximum number of words for which one key acts.
const MAX_WORDS: usize = 8;

/// The words of a choice for which a key acts; for a switch, `true` or `false`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ActsFor {
    /// The key of the choice.
    pub key: &'static str,
    words: [&'static str; MAX_WORDS],
    count: usize,
    /// The key of another choice, and its word.
    also: Option<(&'static str, &'static str)>,
}

impl ActsFor {
    /// Creates a condition on some words of a choice, at most eight.
    #[must_use]
    pub const fn new(key: &'static str, given: &[&'static str]) -> Self {
        let mut words = [""; MAX_WORDS];
        let mut index = 0;
        while index < given.len() {
            words[index] = given[index];
            index += 1;
        }
        Self { key, words, count: given.len(), also: None }
    }

    /// Adds the condition that another choice has this word.
    #[must_use]
    pub const fn only_with(self, key: &'static str, word: &'static str) -> Self {
        Self { also: Some((key, word)), ..self }
    }

    /// The conditions, one per choice. All of them must hold.
    pub fn conditions(self) -> impl Iterator<Item = Self> {
        let also = self.also.map(|(key, word)| Self::new(key, &[word]));
        core::iter::once(Self { also: None, ..self }).chain(also)
    }

    /// Creates a condition on all words of a choice but one.
    #[must_use]
    pub const fn all_but(key: &'static str, words: &[&'static str], left_out: &str) -> Self {
        let mut built = Self::new(key, &[]);
        let mut index = 0;
        while index < words.len() {
            if !are_equal(words[index], left_out) {
                built = built.and(Self::new(key, &[words[index]]));
            }
            index += 1;
        }
        built
    }

    /// Creates a condition on the kinds whose groups of keys contain the first of `keys`.
    #[must_use]
    pub const fn built_from(keys: &[Key], key: &'static str, kinds: &[(&'static str, &[&[Key]])]) -> Self {
        let mut built = Self::new(key, &[]);
        let mut index = 0;
        while index < kinds.len() {
            let (word, groups) = kinds[index];
            if is_in(keys[0].path, groups, groups.len()) {
                built = built.and(Self::new(key, &[word]));
            }
            index += 1;
        }
        built
    }

    /// The words.
    #[must_use]
    pub fn words(&self) -> &[&'static str] {
        &self.words[..self.count]
    }

    const fn and(mut self, other: Self) -> Self {
        let mut index = 0;
        while index < other.count {
            self.words[self.count] = other.words[index];
            self.count += 1;
            index += 1;
        }
        self
    }
}

impl fmt::Display for ActsFor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} = ", self.key)?;
        for (index, word) in self.words().iter().enumerate() {
            let comma = if index > 0 { ", " } else { "" };
            write!(f, "{comma}{word}")?;
        }
        self.also.map_or(Ok(()), |(key, word)| write!(f, ", and to {key} = {word}"))
    }
}

/// A key of a scenario.
#[derive(Debug, Clone, Copy)]
pub struct Key {
    /// Dotted path: `slave.velocity_gain`.
    pub path: &'static str,
    /// Type of the value.
    pub kind: Kind,
    /// Value if the key is not given.
    pub fallback: Fallback,
    /// Meaning: the first paragraph of the field's doc comment.
    pub meaning: &'static str,
    /// Kinds of a choice for which the key acts; `None` for all.
    pub acts_for: Option<ActsFor>,
}

impl Key {
    /// Creates a key that acts for every kind.
    #[must_use]
    pub const fn new(path: &'static str, kind: Kind, fallback: Fallback, meaning: &'static str) -> Self {
        Self { path, kind, fallback, meaning, acts_for: None }
    }

    /// Creates a key for a number with a default.
    #[must_use]
    pub const fn number(path: &'static str, range: Range, default: f64, meaning: &'static str) -> Self {
        Self::new(path, Kind::Number(range), Fallback::Value(Constant::Number(default)), meaning)
    }

    /// Creates a key for a number derived from other keys.
    #[must_use]
    pub const fn derived(path: &'static str, range: Range, rule: &'static str, meaning: &'static str) -> Self {
        Self::new(path, Kind::Number(range), Fallback::Derived(rule), meaning)
    }

    /// Creates a key for a number or none.
    #[must_use]
    pub const fn optional(path: &'static str, range: Range, meaning: &'static str) -> Self {
        Self::new(path, Kind::Number(range), Fallback::Unset, meaning)
    }

    /// Creates a key for 1 or -1.
    #[must_use]
    pub const fn sign(path: &'static str, default: f64, meaning: &'static str) -> Self {
        Self::new(path, Kind::Sign, Fallback::Value(Constant::Number(default)), meaning)
    }

    /// Creates a key for a whole number.
    #[must_use]
    pub const fn whole(path: &'static str, min: u64, default: u64, meaning: &'static str) -> Self {
        Self::new(path, Kind::Whole(min), Fallback::Value(Constant::Whole(default)), meaning)
    }

    /// Creates a key for true or false.
    #[must_use]
    pub const fn flag(path: &'static str, default: bool, meaning: &'static str) -> Self {
        Self::new(path, Kind::Flag, Fallback::Value(Constant::Flag(default)), meaning)
    }

    /// Creates a key for a list of numbers.
    #[must_use]
    pub const fn numbers(path: &'static str, default: &'static [f64], meaning: &'static str) -> Self {
        Self::new(path, Kind::Numbers, Fallback::Value(Constant::Numbers(default)), meaning)
    }

    /// Creates a key for one of the listed words.
    #[must_use]
    pub const fn choice(
        path: &'static str,
        words: &'static [&'static str],
        default: &'static str,
        meaning: &'static str,
    ) -> Self {
        Self::new(path, Kind::Choice(words), Fallback::Value(Constant::Text(default)), meaning)
    }
}

/// A source of settings, read by key.
pub trait KeySource {
    /// The error for a wrong value.
    type Error;

    /// The number of a key.
    ///
    /// # Errors
    /// The key has no number.
    fn number(&self, key: &str) -> Result<f64, Self::Error>;

    /// The number of a key without a default.
    fn optional_number(&self, key: &str) -> Option<f64>;

    /// The number of a key. If it is not given, sets it to the derived number.
    fn number_or(&mut self, key: &'static str, derived: impl FnOnce() -> f64) -> f64;

    /// The whole number of a key.
    ///
    /// # Errors
    /// The key has no whole number.
    fn whole(&self, key: &str) -> Result<u64, Self::Error>;

    /// The truth value of a key.
    ///
    /// # Errors
    /// The key is neither true nor false.
    fn flag(&self, key: &str) -> Result<bool, Self::Error>;

    /// The numbers of a key.
    ///
    /// # Errors
    /// The key has no numbers.
    fn numbers(&self, key: &str) -> Result<&[f64], Self::Error>;

    /// The word of a key.
    ///
    /// # Errors
    /// The key has no word.
    fn word(&self, key: &str) -> Result<&str, Self::Error>;

    /// The text of a key without a default.
    fn optional_word(&self, key: &str) -> Option<&str>;

    /// The error for a key with an unknown word.
    fn unknown_word(&self, key: &str) -> Self::Error;

    /// Visits the items of a list of named tables with their names, in order. During a visit the keys of the item are
    /// read as keys of the item `*`: `list.*.key`.
    ///
    /// # Errors
    /// Errors of a visit.
    fn visit_items(
        &mut self,
        list: &str,
        visit: impl FnMut(&str, &mut Self) -> Result<(), Self::Error>,
    ) -> Result<(), Self::Error>;
}

/// The number of keys in all groups.
#[must_use]
pub const fn count(groups: &[&[Key]]) -> usize {
    let (mut count, mut group) = (0, 0);
    while group < groups.len() {
        count += groups[group].len();
        group += 1;
    }
    count
}

/// The keys of all groups, `COUNT` in total.
#[must_use]
pub const fn joined<const COUNT: usize>(groups: &[&[Key]]) -> [Key; COUNT] {
    let mut all = [Key::new("", Kind::Flag, Fallback::Unset, ""); COUNT];
    let (mut filled, mut group) = (0, 0);
    while group < groups.len() {
        let mut index = 0;
        while index < groups[group].len() {
            all[filled] = groups[group][index];
            (filled, index) = (filled + 1, index + 1);
        }
        group += 1;
    }
    all
}

/// The keys of all groups, restricted to one kind of a choice.
#[must_use]
pub const fn acting<const COUNT: usize>(groups: &[&[Key]], acts_for: ActsFor) -> [Key; COUNT] {
    let mut all = joined::<COUNT>(groups);
    let mut index = 0;
    while index < COUNT {
        if all[index].acts_for.is_none() {
            all[index].acts_for = Some(acts_for);
        }
        index += 1;
    }
    all
}

/// The keys with fewer words for one choice, whose default is among them.
#[must_use]
pub const fn restricted<const COUNT: usize>(
    mut keys: [Key; COUNT],
    path: &str,
    words: &'static [&'static str],
) -> [Key; COUNT] {
    let mut index = 0;
    while index < COUNT {
        if are_equal(keys[index].path, path) {
            keys[index].kind = Kind::Choice(words);
        }
        index += 1;
    }
    keys
}

/// The number of different keys in all groups.
#[must_use]
pub const fn count_distinct(groups: &[&[Key]]) -> usize {
    let (mut count, mut group) = (0, 0);
    while group < groups.len() {
        let mut index = 0;
        while index < groups[group].len() {
            if !is_in(groups[group][index].path, groups, group) {
                count += 1;
            }
            index += 1;
        }
        group += 1;
    }
    count
}

/// The `COUNT` different keys of all groups. A key in several groups acts for the kinds of all of them.
#[must_use]
pub const fn distinct<const COUNT: usize>(groups: &[&[Key]]) -> [Key; COUNT] {
    let mut all = [Key::new("", Kind::Flag, Fallback::Unset, ""); COUNT];
    let (mut filled, mut group) = (0, 0);
    while group < groups.len() {
        let mut index = 0;
        while index < groups[group].len() {
            let key = groups[group][index];
            let mut known = 0;
            while known < filled && !are_equal(all[known].path, key.path) {
                known += 1;
            }
            if known == filled {
                all[known] = key;
                filled += 1;
            } else if let (Some(ours), Some(others)) = (all[known].acts_for, key.acts_for) {
                all[known].acts_for = Some(ours.and(others));
            }
            index += 1;
        }
        group += 1;
    }
    all
}

const fn is_in(path: &str, groups: &[&[Key]], before: usize) -> bool {
    let mut group = 0;
    while group < before {
        let mut index = 0;
        while index < groups[group].len() {
            if are_equal(groups[group][index].path, path) {
                return true;
            }
            index += 1;
        }
        group += 1;
    }
    false
}

const fn are_equal(a: &str, b: &str) -> bool {
    let (a, b) = (a.as_bytes(), b.as_bytes());
    let mut index = 0;
    while index < a.len() && index < b.len() && a[index] == b[index] {
        index += 1;
    }
    index == a.len() && index == b.len()
}
