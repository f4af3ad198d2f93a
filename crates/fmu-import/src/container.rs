//! Unpacks the container of a unit.

use std::fs::{self, File};
use std::io::{Cursor, Read as _};
use std::path::Path;

use zip::ZipArchive;

use crate::error::FmuError;

const MAX_FILES: usize = 20_000;
const MAX_BYTES: u64 = 2 << 30;

/// Unpacks a container into an empty folder. Links, paths that lead out of the folder, and excessive sizes are errors.
pub(crate) fn unpack(content: &[u8], folder: &Path) -> Result<(), FmuError> {
    let no_container = |error: zip::result::ZipError| FmuError::Container(error.to_string());
    let cannot_write = |error: std::io::Error| FmuError::Unpack(error.to_string());
    let mut container = ZipArchive::new(Cursor::new(content)).map_err(no_container)?;
    if container.len() > MAX_FILES {
        return Err(FmuError::Size { max: MAX_FILES as u64, unit: "files" });
    }
    let mut left = MAX_BYTES;
    for index in 0..container.len() {
        let mut entry = container.by_index(index).map_err(no_container)?;
        let written = entry.name().map_err(no_container)?.into_owned();
        let inside = entry.enclosed_name().filter(|_| !entry.is_symlink() && !written.contains('\\'));
        let Some(inside) = inside else { return Err(FmuError::Path(written)) };
        let target = folder.join(inside);
        if entry.is_dir() {
            fs::create_dir_all(&target).map_err(cannot_write)?;
            continue;
        }
        if let Some(parent) = target.parent() {
            fs::create_dir_all(parent).map_err(cannot_write)?;
        }
        let mut file = File::create(&target).map_err(cannot_write)?;
        // The stated size can be wrong, so count the written bytes.
        let mut limited = entry.by_ref().take(left + 1);
        let mut bytes = [0; 1 << 14];
        loop {
            let count = limited.read(&mut bytes).map_err(|error| FmuError::Container(error.to_string()))?;
            if count == 0 {
                break;
            }
            left = left.checked_sub(count as u64).ok_or(FmuError::Size { max: MAX_BYTES, unit: "bytes" })?;
            std::io::Write::write_all(&mut file, &bytes[..count]).map_err(cannot_write)?;
        }
    }
    Ok(())
}
