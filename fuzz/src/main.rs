//! The fuzz targets. `TROCAR_FUZZ` names the target; `./run` builds and runs all of them.

#![no_main]

mod controller;
mod files;
mod link;
mod recordings;

use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;

/// A target: it must return for any bytes, without a panic, and soon.
type Target = fn(&[u8]);

/// The targets by name. Any other name is the extension of a recording.
const TARGETS: [(&str, Target); 5] = [
    ("scenario", files::scenario),
    ("sweep", files::sweep),
    ("tables", files::tables),
    ("link", link::packets),
    ("c", controller::calls),
];

static TARGET: LazyLock<Target> = LazyLock::new(|| {
    let name = std::env::var("TROCAR_FUZZ").expect("TROCAR_FUZZ names a target");
    TARGETS.iter().find(|(target, _)| *target == name).map_or(recordings::recording as Target, |(_, target)| *target)
});

fuzz_target!(|content: &[u8]| (*TARGET)(content));
