//! Rust source as a list of words, sufficient to find paths.

/// Returns the words and marks of a source text, with `::`, `->` and `=>` as one mark each, without comments, strings,
/// character literals, lifetime marks, and `#[cfg(test)] mod name { … }`.
pub fn words(text: &str) -> Vec<String> {
    let mut words = vec![];
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let length = if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if rest.starts_with("/*") {
            rest.find("*/").map_or(rest.len(), |end| end + 2)
        } else if let Some(length) = string(rest) {
            length
        } else if first.is_alphanumeric() || first == '_' {
            let length = rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len());
            words.push(rest[..length].to_owned());
            length
        } else {
            let length =
                if ["::", "->", "=>"].iter().any(|mark| rest.starts_with(mark)) { 2 } else { first.len_utf8() };
            if !first.is_whitespace() && first != '\'' {
                words.push(rest[..length].to_owned());
            }
            length
        };
        rest = &rest[length..];
    }
    without_tests(words)
}

/// Returns the length of the string or character literal at the start of a text.
fn string(text: &str) -> Option<usize> {
    let raw = text.strip_prefix('b').unwrap_or(text).strip_prefix('r');
    if let Some(raw) = raw {
        let hashes = raw.len() - raw.trim_start_matches('#').len();
        if raw[hashes..].starts_with('"') {
            let start = text.len() - raw.len() + hashes + 1;
            let end = format!("\"{}", "#".repeat(hashes));
            return text[start..].find(&end).map(|at| start + at + end.len());
        }
    }
    let quote = text.chars().next().filter(|c| ['"', '\''].contains(c))?;
    let mut letters = text.char_indices().skip(1);
    let mut count = 0;
    while let Some((at, c)) = letters.next() {
        match c {
            '\\' => {
                letters.next();
            }
            _ if c == quote => return (quote == '"' || count > 0).then_some(at + 1),
            // `'a` is a lifetime; only an escaped character literal has more than one character.
            _ if quote == '\'' && count == 1 && !text.starts_with("'\\") => return None,
            _ => {}
        }
        count += 1;
    }
    None
}

fn without_tests(words: Vec<String>) -> Vec<String> {
    const TEST: [&str; 8] = ["#", "[", "cfg", "(", "test", ")", "]", "mod"];
    let mut kept = vec![];
    let mut at = 0;
    while at < words.len() {
        if words[at..].iter().take(TEST.len()).eq(TEST) {
            at += TEST.len() + 1;
            let mut depth = 0;
            while at < words.len() {
                depth += i32::from(words[at] == "{") - i32::from(words[at] == "}");
                at += 1;
                if depth == 0 {
                    break;
                }
            }
        } else {
            kept.push(words[at].clone());
            at += 1;
        }
    }
    kept
}
