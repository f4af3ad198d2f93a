//! The readers of recordings.

use std::path::PathBuf;
use std::sync::LazyLock;

use trocar_recording::{Column, Columns, Limits, list_signals, open_recording};

/// The file of this process, in memory where possible. Its extension is the name of the target.
static FILE: LazyLock<PathBuf> = LazyLock::new(|| {
    let memory = PathBuf::from("/dev/shm");
    let folder = if memory.is_dir() { memory } else { std::env::temp_dir() };
    let extension = std::env::var("TROCAR_FUZZ").unwrap_or_default();
    folder.join(format!("trocar-fuzz-{}.{extension}", std::process::id()))
});

static COLUMNS: LazyLock<Columns> = LazyLock::new(|| {
    let column = |name: &str| Column::new(name, 1.0).expect("a name");
    Columns { time: column("time_s"), position: column("position_m"), velocity: None, force: column("force_n") }
});

pub fn recording(content: &[u8]) {
    std::fs::write(&*FILE, content).expect("the file can be written");
    let limits = Limits { max_bytes: 32 << 20, ..Limits::default() };
    let listed = list_signals(&FILE, &limits);
    let opened = open_recording(&FILE, &COLUMNS, &limits);
    for message in [listed.err(), opened.err()].into_iter().flatten() {
        assert!(message.to_string().len() < 100_000, "a long message");
    }
}
