//! The starter scenario: every key with its meaning and default, as comments.

use std::fmt::Write as _;

use trocar_core::settings::{Fallback, Key, Kind};

use super::key_table::SECTIONS;
use super::value::Value;
use super::values::{harmless_name, keys_of};

/// The text of a starter scenario of a given name, made valid as a folder's name.
#[must_use]
pub fn starter(name: &str) -> String {
    let mut text = format!(
        "# A trocar scenario. Check it with `trocar check`, run it with `trocar run`.\n\
         # Every key is here with its default, commented out: uncomment what you change. The base overrides defaults.\n\
         # Lengths in m, times in s, forces in N, positive when they resist insertion.\n\
         \n\
         name = {}\n\
         base = \"builtin:augmented.toml\" # inherit from a file, then override; a path is relative to this file\n",
        toml::Value::String(harmless_name(name))
    );
    for (section, about) in SECTIONS {
        // Writing to a string does not fail.
        let _ = write!(text, "\n# {about}\n[{section}]\n");
        for key in keys_of(section) {
            let name = key.path.rsplit('.').next().unwrap_or(key.path);
            let _ = match key.fallback {
                Fallback::Value(value) => {
                    writeln!(text, "# {name} = {} # {} {}", Value::from(value).to_toml(), key.meaning, must(key))
                }
                Fallback::Derived(rule) => writeln!(text, "# {name} = # {} Default: {rule}.", key.meaning),
                Fallback::Unset => writeln!(text, "# {name} = # {}", key.meaning),
            };
        }
    }
    text
}

/// The allowed values of a key, if its default does not show them.
fn must(key: &Key) -> String {
    match key.kind {
        Kind::Choice(_) => format!("({})", key.kind),
        _ => String::new(),
    }
}
