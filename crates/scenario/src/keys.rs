use std::borrow::Cow;
use std::collections::HashMap;
use std::ops::Deref;
use std::sync::LazyLock;

use trocar_base::names;
use trocar_core::settings::Key;

use super::key_table::{KEYS, SECTIONS};
use super::layers::{ANY, is_name, key_of, split};

static BY_PATH: LazyLock<HashMap<&str, &'static Key>> =
    LazyLock::new(|| KEYS.iter().map(|key| (key.path, key)).collect());

/// Layers' keys are declared once, with `*` as the layer; the path contains the layer's name.
#[derive(Debug, Clone)]
pub struct KeyAt {
    /// For example `tissue.layer.dura.thickness_m`.
    pub path: Cow<'static, str>,
    pub key: &'static Key,
}

impl KeyAt {
    pub(super) fn of_layer(name: &str, key: &'static Key) -> Self {
        Self { path: Cow::Owned(key.path.replacen(ANY, name, 1)), key }
    }
}

impl From<&'static Key> for KeyAt {
    fn from(key: &'static Key) -> Self {
        Self { path: Cow::Borrowed(key.path), key }
    }
}

impl Deref for KeyAt {
    type Target = Key;

    fn deref(&self) -> &Key {
        self.key
    }
}

/// Includes keys of layers with any name.
pub fn find(path: &str) -> Option<KeyAt> {
    if let Some(key) = BY_PATH.get(path) {
        return Some(KeyAt::from(*key));
    }
    let (name, field) = split(path)?;
    let key = key_of(field).filter(|_| name == ANY || is_name(name))?;
    Some(KeyAt::of_layer(name, key))
}

pub fn is_section(path: &str) -> bool {
    SECTIONS.iter().any(|(section, _)| *section == path)
}

const MIN_SIMILARITY: f64 = 0.8;

const MIN_SIMILARITY_IN_SECTION: f64 = 0.75;

/// Prefers the same section, which is rarely wrong.
pub fn nearest(path: &str) -> Option<&'static str> {
    // A far longer path is like no key.
    const MAX_BYTES: usize = 160;
    if path.len() > MAX_BYTES {
        return None;
    }
    let last = |path: &str| path.rsplit('.').next().unwrap_or_default().to_owned();
    let similarity =
        |known: &str| names::similarity(path, known).max(0.98 * names::similarity(&last(path), &last(known)));
    let section = |path: &str| path.rsplit_once('.').map(|(section, _)| section.to_owned());
    let of_section = KEYS.iter().filter(|key| section(key.path) == section(path));
    let in_section = of_section.map(|key| (names::similarity(&last(path), &last(key.path)), key.path));
    let anywhere = KEYS.iter().map(|key| (similarity(key.path), key.path));
    most_similar(in_section, MIN_SIMILARITY_IN_SECTION).or_else(|| most_similar(anywhere, MIN_SIMILARITY))
}

/// `None` if none is similar enough.
pub fn nearest_of<S: AsRef<str>>(name: &str, known: impl IntoIterator<Item = S>) -> Option<S> {
    let with_similarity = |known: S| (names::similarity(name, known.as_ref()), known);
    most_similar(known.into_iter().map(with_similarity), MIN_SIMILARITY)
}

fn most_similar<T>(candidates: impl Iterator<Item = (f64, T)>, min: f64) -> Option<T> {
    let best = candidates.max_by(|a, b| a.0.total_cmp(&b.0)).filter(|(similarity, _)| *similarity > min);
    best.map(|(_, candidate)| candidate)
}

#[cfg(test)]
mod tests {
    use trocar_core::settings::{Fallback, Kind};

    use super::super::Value;
    use super::*;
    use trocar_engine::tissue::LAYER_KEYS;

    #[test]
    fn the_key_of_a_layer_is_found_at_the_path_of_any_name() {
        let found = find("tissue.layer.dura.thickness_m").expect("a key");
        assert_eq!((&*found.path, found.key.path), ("tissue.layer.dura.thickness_m", "tissue.layer.*.thickness_m"));
        assert_eq!(find("tissue.layer.*.thickness_m").expect("any").path, "tissue.layer.*.thickness_m");
        for path in ["tissue.layer.dura.x", "tissue.layer..thickness_m", "tissue.layer.a b.thickness_m", "tissue.layer"]
        {
            assert!(find(path).is_none(), "{path}");
        }
    }

    #[test]
    fn layers_with_many_names_have_keys() {
        assert!((0..10_000).all(|k| find(&format!("tissue.layer.n{k}.grip_n")).is_some()));
    }

    #[test]
    fn every_default_is_a_value_of_its_kind() {
        for key in KEYS.iter().chain(LAYER_KEYS) {
            if let Fallback::Value(value) = key.fallback {
                let value = Value::from(value);
                assert_eq!(Value::accept(&key.kind, &value.to_toml()), Some(value), "{}", key.path);
            }
        }
    }

    #[test]
    fn every_key_is_unique_and_in_a_section() {
        for (index, key) in KEYS.iter().enumerate() {
            let section = key.path.rsplit_once('.').map(|(section, _)| section);
            assert!(section.is_none_or(|name| SECTIONS.iter().any(|(known, _)| *known == name)), "{}", key.path);
            assert!(KEYS[..index].iter().all(|other| other.path != key.path), "{}", key.path);
        }
    }

    #[test]
    fn keys_depend_on_the_words_of_a_choice_or_on_a_switch() {
        for acts in KEYS.iter().chain(LAYER_KEYS).filter_map(|key| key.acts_for).flat_map(|acts| acts.conditions()) {
            let words: &[&str] = match find(acts.key).map(|choice| choice.kind) {
                Some(Kind::Choice(words)) => words,
                Some(Kind::Flag) => &["true", "false"],
                _ => panic!("{acts:?}"),
            };
            assert!(acts.words().iter().all(|word| words.contains(word)), "{acts:?}");
        }
    }

    #[test]
    fn a_misspelt_key_finds_its_neighbour() {
        assert_eq!(nearest("slave.velocty_gain"), Some("slave.velocity_gain"));
        assert_eq!(nearest("master.velocity_gain"), Some("slave.velocity_gain"));
        assert_eq!(nearest("arm.mass_kg"), Some("arm.m_h_kg"));
        assert_eq!(nearest("zzz"), None);
    }
}
