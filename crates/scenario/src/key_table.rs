//! Every key and section of a scenario, from the [table of groups](super::scenario::GROUPS). Each key is declared
//! beside its part.

use trocar_core::settings::{Key, count, joined};

use super::scenario::GROUPS;

/// In the order of files, each with its subject.
pub const SECTIONS: [(&str, &str); count_sections()] = {
    let mut all = [("", ""); count_sections()];
    let (mut filled, mut group) = (0, 0);
    while group < GROUPS.len() {
        let mut index = 0;
        while index < GROUPS[group].sections.len() {
            all[filled] = GROUPS[group].sections[index];
            (filled, index) = (filled + 1, index + 1);
        }
        group += 1;
    }
    all
};

/// In the order of files, without the layers' keys ([`LAYER_KEYS`](trocar_engine::tissue::LAYER_KEYS)).
pub const KEYS: &[Key] = &joined::<{ count(&KEYS_OF_GROUPS) }>(&KEYS_OF_GROUPS);

const KEYS_OF_GROUPS: [&[Key]; GROUPS.len()] = {
    let mut all: [&[Key]; GROUPS.len()] = [&[]; GROUPS.len()];
    let mut group = 0;
    while group < GROUPS.len() {
        all[group] = GROUPS[group].keys;
        group += 1;
    }
    all
};

const fn count_sections() -> usize {
    let (mut count, mut group) = (0, 0);
    while group < GROUPS.len() {
        count += GROUPS[group].sections.len();
        group += 1;
    }
    count
}

#[cfg(test)]
mod tests {
    use std::fmt::Write as _;

    use trocar_core::settings::{Fallback, Kind};

    use super::super::Value;
    use super::*;
    use trocar_engine::tissue::LAYER_KEYS;

    /// Compares with a file in `snapshots`; `BLESS=1` writes it.
    fn assert_snapshot(name: &str, text: &str) {
        let path = format!("{}/src/snapshots/{name}", env!("CARGO_MANIFEST_DIR"));
        if std::env::var_os("BLESS").is_some() {
            std::fs::write(&path, text).expect("written");
        }
        let expected = std::fs::read_to_string(&path).expect("a snapshot");
        let differing = expected.lines().zip(text.lines()).find(|(expected, now)| expected != now);
        assert!(expected == text, "{name} differs at {differing:?}; BLESS=1 writes it anew");
    }

    #[test]
    fn regress_every_key_matches_the_snapshot() {
        let mut text = String::new();
        for key in KEYS.iter().chain(LAYER_KEYS) {
            let range = if let Kind::Number(range) = key.kind {
                format!(" [{:e} {} {:e}]", range.low().0, range.low().1, range.high())
            } else {
                String::new()
            };
            let fallback = match key.fallback {
                Fallback::Value(value) => format!("= {}", Value::from(value).to_toml()),
                Fallback::Derived(rule) => format!("derived: {rule}"),
                Fallback::Unset => "unset".into(),
            };
            let must = key.kind.to_string();
            writeln!(text, "{}\n    {must}{range}\n    {fallback}\n    {}", key.path, key.meaning).expect("text");
        }
        assert_snapshot("keys.txt", &text);
    }
}
