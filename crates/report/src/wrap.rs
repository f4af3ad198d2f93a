/// Maximum width of printed lines, in characters.
pub const WIDTH: usize = 80;

/// Breaks a text at spaces into lines of at most `width` characters, the later ones indented by `indent`. A longer
/// word, such as a path, stays whole.
pub fn filled(text: &str, width: usize, indent: usize) -> Vec<String> {
    let mut lines: Vec<String> = vec![];
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= width => {
                line.push(' ');
                line.push_str(word);
            }
            Some(_) => lines.push(" ".repeat(indent) + word),
            None => lines.push(word.to_owned()),
        }
    }
    lines
}

pub fn wrapped(text: &str, indent: usize) -> String {
    let mut result = String::with_capacity(text.len());
    for line in text.split_inclusive('\n') {
        if line.trim_end().chars().count() <= WIDTH {
            result.push_str(line);
        } else {
            result.push_str(&filled(line, WIDTH, indent).join("\n"));
            result.push_str(if line.ends_with('\n') { "\n" } else { "" });
        }
    }
    result
}

/// Breaks a cell after spaces and hyphens into lines of at most `width` characters, the later ones indented by
/// `indent`. A longer word is cut.
pub(crate) fn lines(cell: &str, width: usize, indent: usize) -> Vec<String> {
    let mut lines = vec![];
    let mut line = String::new();
    let mut length = 0;
    let mut end_line = |line: &mut String| {
        lines.push(line.trim_end().to_owned());
        *line = " ".repeat(indent);
        indent
    };
    for part in parts(cell) {
        if length + part.trim_end().chars().count() > width && !line.trim().is_empty() {
            length = end_line(&mut line);
        }
        for letter in part.chars() {
            if length >= width && letter != ' ' {
                length = end_line(&mut line);
            }
            line.push(letter);
            length += 1;
        }
    }
    end_line(&mut line);
    lines
}

pub(crate) fn longest_part(cell: &str) -> usize {
    parts(cell).map(|part| part.trim_end().chars().count()).max().unwrap_or(0)
}

/// Splits after spaces, and after hyphens between letters: a negative number stays whole.
fn parts(cell: &str) -> impl Iterator<Item = &str> {
    let mut rest = cell;
    std::iter::from_fn(move || {
        if rest.is_empty() {
            return None;
        }
        let mut last = ' ';
        let end = rest.char_indices().zip(rest.chars().skip(1)).find_map(|((at, letter), next)| {
            let is_break = letter == ' ' && last != ' ' && next != ' '
                || letter == '-' && last.is_alphanumeric() && next.is_alphabetic();
            last = letter;
            is_break.then_some(at + letter.len_utf8())
        });
        let (part, after) = rest.split_at(end.unwrap_or(rest.len()));
        rest = after;
        Some(part)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_lines_are_broken_at_spaces_and_short_ones_are_unchanged() {
        let short = "two\n\n  lines  \n";
        assert_eq!(wrapped(short, 2), short);
        let long = format!("switching: {}\n", "word ".repeat(30));
        let broken = wrapped(&long, 2);
        assert!(broken.lines().all(|line| line.chars().count() <= WIDTH), "{broken}");
        assert!(broken.lines().nth(1).is_some_and(|line| line.starts_with("  word")), "{broken}");
        assert_eq!(broken.split_whitespace().count(), long.split_whitespace().count());
    }

    #[test]
    fn a_cell_is_broken_after_spaces_and_hyphens_but_not_within_a_number() {
        assert_eq!(lines("through-the-skin", 12, 0), ["through-the-", "skin"]);
        assert_eq!(lines("rupture 1: slave overshoot", 12, 2), ["rupture 1:", "  slave", "  overshoot"]);
        assert_eq!(lines("from -2.5 to 3", 7, 0), ["from", "-2.5 to", "3"]);
        assert_eq!(lines("abcdefgh", 3, 0), ["abc", "def", "gh"]);
        assert_eq!(lines("", 3, 0), [""]);
        assert_eq!((longest_part("a re-engaging hand"), longest_part("")), (8, 0));
    }
}
