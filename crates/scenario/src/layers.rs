//! The paths of the keys of named layers: `tissue.layer.NAME.FIELD`.

use trocar_core::settings::Key;
use trocar_engine::tissue::{LAYER_KEYS, LAYER_LIST};

const MAX_NAME_LEN: usize = 32;

/// Continues "must be".
pub const NAME_RULE: &str = "at most 32 letters, digits, '-' and '_'";

pub const NAME_PATTERN: &str = "^[A-Za-z0-9_-]{1,32}$";

pub(super) const ANY: &str = "*";

pub(super) fn is_name(name: &str) -> bool {
    let is_letter = |byte: u8| byte.is_ascii_alphanumeric() || b"-_".contains(&byte);
    !name.is_empty() && name.len() <= MAX_NAME_LEN && name.bytes().all(is_letter)
}

/// The part of a path below the list of layers: `dura.thickness_m` for `tissue.layer.dura.thickness_m`.
fn below_list(path: &str) -> Option<&str> {
    path.strip_prefix(LAYER_LIST)?.strip_prefix('.')
}

pub(super) fn is_of_layer(path: &str) -> bool {
    below_list(path).is_some()
}

/// Into name and field; neither has to exist.
pub(super) fn split(path: &str) -> Option<(&str, &str)> {
    below_list(path)?.split_once('.')
}

pub(super) fn field(path: &str) -> &str {
    path.rsplit('.').next().unwrap_or(path)
}

pub(super) fn key_of(wanted: &str) -> Option<&'static Key> {
    LAYER_KEYS.iter().find(|key| field(key.path) == wanted)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_of_a_layer_has_a_name_and_a_field() {
        assert_eq!(split("tissue.layer.dura.thickness_m"), Some(("dura", "thickness_m")));
        for path in ["tissue.layer", "tissue.layer.dura", "tissue.layers.dura.x", "tissue.contact_m"] {
            assert_eq!(split(path), None, "{path}");
        }
        assert!(is_of_layer("tissue.layer.dura") && !is_of_layer("tissue.layer"));
    }

    #[test]
    fn a_name_has_letters_digits_hyphens_and_underscores_only() {
        assert!(is_name("yellow-ligament_2") && is_name(&"x".repeat(MAX_NAME_LEN)));
        for name in ["", "a b", "a.b", ANY, "é", &"x".repeat(MAX_NAME_LEN + 1)] {
            assert!(!is_name(name), "{name}");
        }
    }

    #[test]
    fn the_field_of_a_layer_has_one_key() {
        for key in LAYER_KEYS {
            assert_eq!(key_of(field(key.path)).map(|found| found.path), Some(key.path));
        }
        assert!(key_of("name").is_none());
    }
}
