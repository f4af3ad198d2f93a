//! Recordings in memory, named by a hash of their content, as in `memory:1f3a…`.
//!
//! A name is valid while the program holds the recording that `keep` returned.

use std::collections::HashMap;
use std::sync::{Arc, LazyLock, Mutex, PoisonError, Weak};

use super::Recording;

pub const MEMORY: &str = "memory:";

pub(super) static KEPT: LazyLock<Mutex<HashMap<String, Weak<Recording>>>> = LazyLock::new(Mutex::default);

pub fn kept(name: &str) -> Option<Arc<Recording>> {
    KEPT.lock().unwrap_or_else(PoisonError::into_inner).get(name).and_then(Weak::upgrade)
}
