//! Names of files and folders.

use std::collections::HashSet;

/// Returns unique names, ignoring case: the second `x` becomes `x-2`, and so on. None of them is one of the `reserved`
/// names, which are in lower case.
#[must_use]
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_names_become_unique() {
        let names = ["x", "y", "x", "X", "x-2", "events.csv", "x"].map(str::to_owned);
        assert_eq!(distinct(&names, &["events.csv"]), ["x", "y", "x-3", "X-4", "x-2", "events.csv-2", "x-5"]);
    }
}
