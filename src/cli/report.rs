//! `--report`: what the commands that take it have in common.

use super::error::CliError;
use super::terminal;
use trocar_report::Folder;

/// The name of a page.
pub(super) const FILE: &str = "report.html";

/// What a command line says of a file: shipped ones and relative paths as they are, of others the name alone, so that a page
/// tells nothing of the machine.
pub(super) fn shown(path: &str) -> String {
    let path_here = std::path::Path::new(path);
    match path_here.file_name() {
        Some(name) if path_here.is_absolute() => name.to_string_lossy().into_owned(),
        _ => path.to_owned(),
    }
}

/// Settings as flags again.
pub(super) fn set_flags(settings: &[String]) -> impl Iterator<Item = String> + '_ {
    settings.iter().flat_map(|setting| ["--set".to_owned(), setting.clone()])
}

/// Says where the page is.
pub(super) fn say(folder: &Folder) -> Result<(), CliError> {
    terminal::print(&format!("report: {}\n", folder.path().join(FILE).display()))
}
