use std::borrow::Cow;
use std::collections::HashSet;

/// Makes names unique, ignoring case: the second `x` becomes `x-2`. The `reserved` names are in lower case.
pub fn distinct(names: &[String], reserved: &[&str]) -> Vec<String> {
    let given: HashSet<String> = names.iter().map(|name| name.to_lowercase()).collect();
    let mut used: HashSet<String> = reserved.iter().map(|&name| name.to_owned()).collect();
    let mut unique = |name: &String| {
        if used.insert(name.to_lowercase()) {
            return name.clone();
        }
        let mut next = (2_u64..).map(|number| format!("{name}-{number}"));
        let unused = next.find(|other| {
            let other = other.to_lowercase();
            !given.contains(&other) && used.insert(other)
        });
        unused.unwrap_or_else(|| name.clone())
    };
    names.iter().map(&mut unique).collect()
}

const MAX_CHARACTERS: usize = 80;

/// Of a path, which is recognised by its `/` or `\\`.
const MAX_PATH_CHARACTERS: usize = 240;

const MAX_MESSAGE_CHARACTERS: usize = 4000;

/// Jaro-Winkler, 0 to 1; 0 for names of over 80 bytes: the time grows with the lengths' product.
pub fn similarity(a: &str, b: &str) -> f64 {
    if a.len().max(b.len()) > MAX_CHARACTERS { 0.0 } else { strsim::jaro_winkler(a, b) }
}

pub fn shortened(text: &str) -> Cow<'_, str> {
    cut(text, MAX_CHARACTERS)
}

fn cut(text: &str, characters: usize) -> Cow<'_, str> {
    match text.char_indices().nth(characters) {
        Some((end, _)) => format!("{}…", &text[..end]).into(),
        None => text.into(),
    }
}

/// Limits words to 80 characters and paths to 240.
pub fn with_short_words(message: &str) -> Cow<'_, str> {
    if message.len() <= MAX_CHARACTERS {
        return message.into();
    }
    let limit = |word: &str| if word.contains(['/', '\\']) { MAX_PATH_CHARACTERS } else { MAX_CHARACTERS };
    let words = message.split_inclusive(char::is_whitespace);
    let short: String = words
        .map(|word| {
            let content = word.trim_end();
            match cut(content, limit(content)) {
                Cow::Borrowed(_) => word.into(),
                Cow::Owned(shown) => Cow::Owned(format!("{shown}{}", &word[content.len()..])),
            }
        })
        .take(MAX_MESSAGE_CHARACTERS)
        .collect();
    cut(&short, MAX_MESSAGE_CHARACTERS).into_owned().into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_do_not_repeat_long_inputs() {
        let long = "k".repeat(50_000);
        assert_eq!(with_short_words(&format!("no key {long}\nhere")), format!("no key {}…\nhere", "k".repeat(80)));
        let path = format!("/{}/a.toml: cannot be read", "k".repeat(200));
        assert_eq!(with_short_words(&path), path);
        assert_eq!(with_short_words("no key a"), "no key a");
        assert!(with_short_words(&"µ k ".repeat(50_000)).chars().count() <= MAX_MESSAGE_CHARACTERS + 1);
        assert_eq!(shortened(&long).chars().count(), 81);
    }

    #[test]
    fn long_names_are_not_compared() {
        assert!(similarity("velocity_gain", "velocty_gain") > 0.9);
        assert_eq!(similarity(&"a".repeat(81), &"a".repeat(81)), 0.0);
    }

    #[test]
    fn equal_names_become_unique() {
        let names = ["x", "y", "x", "X", "x-2", "events.csv", "x"].map(str::to_owned);
        assert_eq!(distinct(&names, &["events.csv"]), ["x", "y", "x-3", "X-4", "x-2", "events.csv-2", "x-5"]);
    }
}
