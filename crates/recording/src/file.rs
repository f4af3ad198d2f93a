use std::fs::{File, FileType, Metadata};
use std::io::{BufRead, Cursor, Read, Seek, SeekFrom};
use std::path::Path;

use super::containers::{ArrayFile, gunzipped};
use super::error::{Place, Problem};
use super::read::{names_csv, scan_csv};
use super::room::Room;
use super::signals::Signal;
use super::{
    Columns, DelayRow, Format, LabelRow, Limits, Recording, RecordingError, ResponseRow, read_csv, read_delays,
    read_labels, read_response,
};

pub fn open_response(path: &Path, limits: &Limits) -> Result<Vec<ResponseRow>, RecordingError> {
    let (name, file) = open(path, limits)?;
    read_response(&name, file, limits)
}

/// The first bytes determine the [`Format`]. In other formats than text the columns are signals, named as by
/// [`list_signals`].
pub fn open_recording(path: &Path, columns: &Columns, limits: &Limits) -> Result<Recording, RecordingError> {
    let room = Room::new(limits);
    match opened(path, &room)? {
        (name, Opened::Text(file)) => read_csv(&name, file, columns, limits),
        (name, Opened::Arrays(mut file)) => file.recording(&name, columns, &room),
    }
}

pub fn list_signals(path: &Path, limits: &Limits) -> Result<Vec<Signal>, RecordingError> {
    let room = Room::new(limits);
    match opened(path, &room)? {
        (name, Opened::Text(file)) => scan_csv(&name, file, limits),
        (name, Opened::Arrays(mut file)) => file.signals(&name, &room),
    }
}

pub fn signal_names(path: &Path, limits: &Limits) -> Result<Vec<String>, RecordingError> {
    match opened(path, &Room::new(limits))? {
        (name, Opened::Text(file)) => names_csv(&name, file, limits),
        (_, Opened::Arrays(file)) => Ok(file.signal_names()),
    }
}

enum Opened {
    Text(Box<dyn Read>),
    Arrays(ArrayFile),
}

fn opened(path: &Path, room: &Room) -> Result<(String, Opened), RecordingError> {
    let (name, mut file) = open(path, room.limits())?;
    let refuse = |problem| Place::file(&name).error(problem);
    let unreadable = |error| refuse(Problem::Unreadable(error));
    let mut format = Format::of(path, &mut file).map_err(unreadable)?;
    let mut text: Box<dyn Read> = match is_gzipped(&mut file).map_err(unreadable)? {
        false if format.conversion().is_some() => return Err(refuse(Problem::NotRead(format))),
        false if !matches!(format, Format::Csv | Format::JsonLines) => {
            let arrays = ArrayFile::open(format, file, room).map_err(refuse)?;
            return Ok((name, Opened::Arrays(arrays)));
        }
        false => Box::new(file),
        true => {
            let mut inside = gunzipped(file).map_err(refuse)?;
            let beginning = inside.fill_buf().map_err(unreadable)?.to_vec();
            format = Format::of(Path::new(""), &mut Cursor::new(beginning)).map_err(unreadable)?;
            Box::new(inside)
        }
    };
    let opened = match format {
        Format::Csv => Opened::Text(text),
        Format::JsonLines => Opened::Arrays(ArrayFile::of_json_lines(&name, &mut text, room)?),
        other => return Err(refuse(Problem::Gzipped(other))),
    };
    Ok((name, opened))
}

fn is_gzipped(file: &mut File) -> std::io::Result<bool> {
    let mut mark = vec![];
    file.by_ref().take(2).read_to_end(&mut mark)?;
    file.seek(SeekFrom::Start(0))?;
    Ok(mark == b"\x1f\x8b")
}

pub fn open_delays(
    path: &Path,
    limits: &Limits,
    max_s: f64,
    take: impl FnMut(&DelayRow),
) -> Result<(), RecordingError> {
    let (name, file) = open(path, limits)?;
    read_delays(&name, file, limits, max_s, take)
}

pub fn read_file(path: &Path, limits: &Limits) -> Result<Vec<u8>, RecordingError> {
    let (name, mut file) = open(path, limits)?;
    let mut bytes = vec![];
    file.read_to_end(&mut bytes).map_err(|error| Place::file(&name).error(Problem::Unreadable(error)))?;
    Ok(bytes)
}

pub fn open_labels(path: &Path, limits: &Limits, needs_file: bool) -> Result<Vec<LabelRow>, RecordingError> {
    let (name, file) = open(path, limits)?;
    read_labels(&name, file, limits, needs_file)
}

fn open(path: &Path, limits: &Limits) -> Result<(String, File), RecordingError> {
    let name = path.display().to_string();
    let refuse = |problem| Place::file(&name).error(problem);
    let unreadable = |error| refuse(Problem::Unreadable(error));
    // Opening a pipe blocks until it has a writer. Checked again after opening, because the path may have changed.
    check(&path.metadata().map_err(unreadable)?, limits).map_err(refuse)?;
    let file = File::open(path).map_err(unreadable)?;
    check(&file.metadata().map_err(unreadable)?, limits).map_err(refuse)?;
    Ok((name, file))
}

fn check(metadata: &Metadata, limits: &Limits) -> Result<(), Problem> {
    if !metadata.is_file() {
        return Err(Problem::NotAFile(kind(metadata.file_type())));
    }
    let (size, limit) = (metadata.len(), limits.max_bytes);
    if size > limit {
        return Err(Problem::TooLarge { size, limit });
    }
    Ok(())
}

fn kind(file_type: FileType) -> &'static str {
    if file_type.is_dir() { "directory" } else { "pipe, socket or device" }
}

#[cfg(test)]
mod tests {
    use super::super::fixtures::columns;
    use super::*;

    fn message(path: &Path) -> String {
        let error = open_recording(path, &columns(), &Limits::default()).expect_err("refused");
        let message = error.to_string();
        message.replace(&path.display().to_string(), "PATH")
    }

    #[test]
    fn paths_that_are_not_files_are_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let directory = "PATH: is a directory, not a regular file; give the path of a CSV file";
        assert_eq!(message(folder.path()), directory);
        assert!(message(&folder.path().join("none.csv")).starts_with("PATH: cannot be read: "));
    }

    #[cfg(unix)]
    #[test]
    fn pipes_and_devices_are_refused_without_reading() {
        let expected = "PATH: is a pipe, socket or device, not a regular file; give the path of a CSV file";
        assert_eq!(message(Path::new("/dev/zero")), expected);
        let folder = tempfile::tempdir().expect("a folder");
        let socket = folder.path().join("socket");
        let _listener = std::os::unix::net::UnixListener::bind(&socket).expect("a socket");
        assert_eq!(message(&socket), expected);
        let pipe = folder.path().join("pipe");
        let made = std::process::Command::new("mkfifo").arg(&pipe).status();
        if made.is_ok_and(|status| status.success()) {
            assert_eq!(message(&pipe), expected);
        }
    }

    #[test]
    fn a_format_that_is_not_read_names_its_conversion() {
        let folder = tempfile::tempdir().expect("a folder");
        for (name, content, conversion) in [
            ("a.xls", &b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1"[..], "`pandas.read_excel('FILE').to_csv("),
            (
                "a.ods",
                b"PK\x03\x04______________________\x08___mimetypeapplication/vnd.oasis.opendocument.spreadsheet",
                "read_excel",
            ),
            ("a.mat", &[0; 200], "`scipy.io.savemat("),
            ("a.feather", b"ARROW1\0\0", "`pandas.read_feather('FILE').to_parquet("),
            ("a.db3", b"SQLite format 3\0", "`rosbags-convert --src "),
            ("a.bag", b"#ROSBAG V2.0\n", "`mcap convert FILE "),
        ] {
            let path = folder.path().join(name);
            std::fs::write(&path, content).expect("written");
            let message = message(&path);
            assert!(message.contains("which trocar does not read") && message.contains(conversion), "{message}");
        }
    }

    #[cfg(not(feature = "formats"))]
    #[test]
    fn without_formats_all_but_text_is_refused_and_names_the_feature() {
        let file = tempfile::NamedTempFile::new().expect("a file");
        for content in [&b"PAR1"[..], b"\x93NUMPY", b"{\"a\": 1}", b"\x1f\x8b\x08"] {
            std::fs::write(file.path(), content).expect("written");
            let message = message(file.path());
            assert!(
                message.contains("without the feature formats; build it with features = [\"formats\"]"),
                "{message}"
            );
        }
        std::fs::write(file.path(), "time_s,position_m,force_n\n0,0,0\n0.001,0,1\n").expect("written");
        assert_eq!(list_signals(file.path(), &Limits::default()).expect("text").len(), 3);
    }

    #[test]
    fn a_gigabyte_is_refused_by_its_size() {
        let file = tempfile::NamedTempFile::new().expect("a file");
        file.as_file().set_len(1 << 30).expect("a sparse file");
        let expected = "PATH: is 1024.0 MiB (1073741824 bytes), the limit is 256.0 MiB (268435456 bytes); \
                        keep fewer rows or columns, or raise recording.max_bytes";
        assert_eq!(message(file.path()), expected);
    }
}
