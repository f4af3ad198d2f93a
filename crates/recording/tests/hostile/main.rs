//! Files that are made to cost time or memory: each is answered within the limits, whatever it states or repeats.
//!
//! The tests count the memory that is allocated.

mod containers;
#[cfg(unix)]
mod growth;
mod peak;
mod tables;

use std::time::{Duration, Instant};

use trocar_recording::{Columns, Limits, list_signals, open_recording, signal_names};

/// Maximum size of the files here in bytes; their content may have twice as many.
const MAX_BYTES: u64 = 8 << 20;

/// Maximum number of samples.
const MAX_SAMPLES: usize = 500_000;

/// Memory besides the content, in bytes: buffers of decoders, and growing vectors, which are twice in memory when they
/// grow.
const BESIDES: usize = 24 << 20;

/// Longest time of an answer. It is generous, because other programs can run at the same time; a time that grows with
/// the square of the size is far above it.
const LONGEST: Duration = Duration::from_secs(10);

/// Reads a file in all ways, checks time and memory, and returns the messages of the errors.
fn answers(name: &str, content: &[u8]) -> Vec<String> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join(name);
    std::fs::write(&path, content).expect("written");
    let limits = Limits { max_bytes: MAX_BYTES, max_samples: MAX_SAMPLES, ..Limits::default() };
    let column = |name: &str| trocar_recording::Column::new(name, 1.0).expect("a name");
    let columns =
        Columns { time: column("time_s"), position: column("position_m"), velocity: None, force: column("force_n") };
    let ways: [&dyn Fn() -> Result<usize, trocar_recording::RecordingError>; 3] =
        [&|| Ok(list_signals(&path, &limits)?.len()), &|| Ok(signal_names(&path, &limits)?.len()), &|| {
            Ok(open_recording(&path, &columns, &limits)?.time_s().len())
        }];
    let mut messages = vec![];
    for way in ways {
        let start = Instant::now();
        let (peak, answer) = peak::of(way);
        let allowed = 2 * MAX_BYTES as usize + BESIDES + 3 * content.len();
        assert!(peak <= allowed, "{name}: {peak} bytes of memory for a file of {} bytes", content.len());
        assert!(start.elapsed() < LONGEST, "{name}: {:?}", start.elapsed());
        if let Err(error) = answer {
            let message = error.to_string();
            assert!(message.contains(name), "{message}");
            assert!(message.chars().count() < 1000 + path.display().to_string().len(), "{name}: {message}");
            messages.push(message);
        }
    }
    messages
}

/// Checks that every way of reading a file is refused, with one of the texts in the message.
fn refused(name: &str, content: &[u8], texts: &[&str]) {
    let messages = answers(name, content);
    assert_eq!(messages.len(), 3, "{name}: {messages:?}");
    for message in messages {
        assert!(texts.iter().any(|text| message.contains(text)), "{name}: {message}");
    }
}
