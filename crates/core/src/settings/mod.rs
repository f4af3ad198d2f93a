//! One declaration per setting: field, default, range, key and reader.
//!
//! [`settings!`](crate::settings!) declares settings, [`choice!`](crate::choice!) the kinds of one setting.

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
    /// Numbers within [`Range::ANY`].
    Numbers,
    /// True or false.
    Flag,
    /// One of the words.
    Choice(&'static [&'static str]),
    /// Any text.
    Text,
    /// Relative to the scenario's folder, or `builtin:` and a name.
    File,
}

impl fmt::Display for Kind {
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

/// A default.
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
    /// A word or text.
    Text(&'static str),
}

/// The value of a key that is not given.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fallback {
    /// A value.
    Value(Constant),
    /// The rule by which it follows from other keys.
    Derived(&'static str),
    /// No value.
    Unset,
}

const MAX_WORDS: usize = 8;

/// Words for which a key acts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ActsFor {
    /// The key of the choice.
    pub key: &'static str,
    words: [&'static str; MAX_WORDS],
    count: usize,
    also: Option<(&'static str, &'static str)>,
}

impl ActsFor {
    /// At most eight words.
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

    /// Another choice must have this word, too.
    #[must_use]
    pub const fn only_with(self, key: &'static str, word: &'static str) -> Self {
        Self { also: Some((key, word)), ..self }
    }

    /// One condition per choice; all must hold.
    pub fn conditions(self) -> impl Iterator<Item = Self> {
        let also = self.also.map(|(key, word)| Self::new(key, &[word]));
        core::iter::once(Self { also: None, ..self }).chain(also)
    }

    /// All words but one.
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

    /// Kinds whose groups contain the first of `keys`.
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
    /// Dotted: `slave.velocity_gain`.
    pub path: &'static str,
    /// Type of the value.
    pub kind: Kind,
    /// Value if the key is not given.
    pub fallback: Fallback,
    /// First paragraph of the field's doc comment.
    pub meaning: &'static str,
    /// `None` if the key always acts.
    pub acts_for: Option<ActsFor>,
}

impl Key {
    /// A key that always acts.
    #[must_use]
    pub const fn new(path: &'static str, kind: Kind, fallback: Fallback, meaning: &'static str) -> Self {
        Self { path, kind, fallback, meaning, acts_for: None }
    }

    /// A number with a default.
    #[must_use]
    pub const fn number(path: &'static str, range: Range, default: f64, meaning: &'static str) -> Self {
        Self::new(path, Kind::Number(range), Fallback::Value(Constant::Number(default)), meaning)
    }

    /// A number derived from other keys.
    #[must_use]
    pub const fn derived(path: &'static str, range: Range, rule: &'static str, meaning: &'static str) -> Self {
        Self::new(path, Kind::Number(range), Fallback::Derived(rule), meaning)
    }

    /// A number or none.
    #[must_use]
    pub const fn optional(path: &'static str, range: Range, meaning: &'static str) -> Self {
        Self::new(path, Kind::Number(range), Fallback::Unset, meaning)
    }

    /// 1 or -1.
    #[must_use]
    pub const fn sign(path: &'static str, default: f64, meaning: &'static str) -> Self {
        Self::new(path, Kind::Sign, Fallback::Value(Constant::Number(default)), meaning)
    }

    /// A whole number.
    #[must_use]
    pub const fn whole(path: &'static str, min: u64, default: u64, meaning: &'static str) -> Self {
        Self::new(path, Kind::Whole(min), Fallback::Value(Constant::Whole(default)), meaning)
    }

    /// True or false.
    #[must_use]
    pub const fn flag(path: &'static str, default: bool, meaning: &'static str) -> Self {
        Self::new(path, Kind::Flag, Fallback::Value(Constant::Flag(default)), meaning)
    }

    /// A list of numbers.
    #[must_use]
    pub const fn numbers(path: &'static str, default: &'static [f64], meaning: &'static str) -> Self {
        Self::new(path, Kind::Numbers, Fallback::Value(Constant::Numbers(default)), meaning)
    }

    /// One of the words.
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

    /// A number.
    fn number(&self, key: &str) -> Result<f64, Self::Error>;

    /// A number without a default.
    fn optional_number(&self, key: &str) -> Option<f64>;

    /// A number, set to the derived one if it is not given.
    fn number_or(&mut self, key: &'static str, derived: impl FnOnce() -> f64) -> f64;

    /// A whole number.
    fn whole(&self, key: &str) -> Result<u64, Self::Error>;

    /// True or false.
    fn flag(&self, key: &str) -> Result<bool, Self::Error>;

    /// A list of numbers.
    fn numbers(&self, key: &str) -> Result<&[f64], Self::Error>;

    /// A word.
    fn word(&self, key: &str) -> Result<&str, Self::Error>;

    /// A text without a default.
    fn optional_word(&self, key: &str) -> Option<&str>;

    /// The error for an unknown word.
    fn unknown_word(&self, key: &str) -> Self::Error;

    /// Visits a list's named tables; keys are `list.*.key`.
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

/// The `COUNT` keys of all groups.
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

/// Keys without a condition get this one.
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

/// Fewer words for the choice at `path`, its default among them.
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

/// The number of different keys.
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

/// A key of several kinds acts for all of them.
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
