//! Layers with names of one's own: their list in scenarios, and the keys of a layer.

use std::collections::HashMap;
use std::sync::{LazyLock, Mutex, PoisonError};

use trocar_core::settings::Key;

use super::kind::TissueSettings;
use trocar_core::error::InvalidValue;

/// The list of the layers in scenarios, from the surface down: `[[tissue.layer]]` with a `name` each.
pub const LAYER_LIST: &str = "tissue.layer";

/// The name of the only layer where no list is given.
pub const DEFAULT_LAYER: &str = "organ";

/// Longest name of a layer.
const MAX_NAME_LEN: usize = 32;

/// Maximum number of different names in a process; their keys are never freed.
const MAX_NAMES: usize = 4096;

/// The rule for names, as the end of "must be ...".
pub const NAME_RULE: &str = "at most 32 letters, digits, '-' and '_'";

/// The rule for names, as a regular expression.
pub const NAME_PATTERN: &str = "^[A-Za-z0-9_-]{1,32}$";

/// The keys of all layers with the same name.
static KEYS_OF_NAMES: LazyLock<Mutex<HashMap<&'static str, &'static [Key]>>> = LazyLock::new(Mutex::default);

/// The keys of the layer `*`, which stands for any layer.
pub const ANY_LAYER_KEYS: &[Key] = TissueSettings::LIST_KEYS;

/// The path of a key without that of the layer: `thickness_m` of `tissue.layer.*.thickness_m`.
fn field(path: &str) -> &str {
    path.rsplit('.').next().unwrap_or(path)
}

/// The name of a layer as it is stored with its keys, and the keys; `None` for a text that cannot be a name.
#[must_use]
pub fn keys_of_layer(name: &str) -> Option<(&'static str, &'static [Key])> {
    let is_letter = |byte: u8| byte.is_ascii_alphanumeric() || b"-_".contains(&byte);
    if name.is_empty() || name.len() > MAX_NAME_LEN || !name.bytes().all(is_letter) {
        return None;
    }
    let mut known = KEYS_OF_NAMES.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((name, keys)) = known.get_key_value(name) {
        return Some((name, keys));
    }
    if known.len() >= MAX_NAMES {
        return None;
    }
    // Keys are compared and stored by their static paths; a name is stored once.
    let of_name = |key: &Key| Key { path: format!("{LAYER_LIST}.{name}.{}", field(key.path)).leak(), ..*key };
    let keys: &'static [Key] = ANY_LAYER_KEYS.iter().map(of_name).collect::<Vec<_>>().leak();
    let name: &'static str = name.to_owned().leak();
    known.insert(name, keys);
    Some((name, keys))
}

/// The key of a layer at a path, as `tissue.layer.dura.thickness_m`; of any layer for the name `*`.
#[must_use]
pub fn layer_key(path: &str) -> Option<&'static Key> {
    let (name, wanted) = path.strip_prefix(LAYER_LIST)?.strip_prefix('.')?.split_once('.')?;
    let is_wanted = |key: &&Key| field(key.path) == wanted;
    if name == "*" {
        return ANY_LAYER_KEYS.iter().find(is_wanted);
    }
    // A misspelt key must not store a name.
    ANY_LAYER_KEYS.iter().find(is_wanted)?;
    keys_of_layer(name)?.1.iter().find(is_wanted)
}

/// A key of the layer `*` as that of a layer.
pub(super) fn own_key(name: &str, path: &'static str) -> &'static str {
    let own = keys_of_layer(name).and_then(|(_, keys)| keys.iter().find(|key| field(key.path) == field(path)));
    own.map_or(path, |key| key.path)
}

/// The error of the layer `*` as that of a layer.
pub(super) fn of_layer(name: &str, error: InvalidValue) -> InvalidValue {
    InvalidValue { name: own_key(name, error.name), ..error }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_layer_has_its_own_keys_stored_once() {
        let key = layer_key("tissue.layer.dura.thickness_m").expect("a key");
        assert_eq!(key.path, "tissue.layer.dura.thickness_m");
        assert!(std::ptr::eq(key, layer_key("tissue.layer.dura.thickness_m").expect("a key")));
        assert_eq!(key.meaning, layer_key("tissue.layer.*.thickness_m").expect("any").meaning);
        for path in ["tissue.layer.dura.x", "tissue.layer..thickness_m", "tissue.layer.a b.thickness_m", "tissue.layer"]
        {
            assert!(layer_key(path).is_none(), "{path}");
        }
        assert!(keys_of_layer(&"x".repeat(MAX_NAME_LEN + 1)).is_none());
    }

    #[test]
    fn an_error_names_the_key_of_its_layer() {
        let error = InvalidValue { name: "tissue.layer.*.grip_n", value: -1.0, requirement: "at least 0" };
        assert_eq!(of_layer("dura", error).name, "tissue.layer.dura.grip_n");
    }
}
