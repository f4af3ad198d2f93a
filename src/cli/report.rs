//! Common code of commands with `--report`.

use super::error::CliError;
use super::terminal;
use trocar_report::Folder;

/// The file name of a report.
pub(super) const FILE: &str = "report.html";

/// Returns the path of a file as a report shows it. An absolute path is reduced to its file name, so that a report contains no path
/// of this machine.
pub(super) fn shown(path: &str) -> String {
    let parsed = std::path::Path::new(path);
    match parsed.file_name() {
        Some(name) if parsed.is_absolute() => name.to_string_lossy().into_owned(),
        _ => path.to_owned(),
    }
}

/// Returns settings as `--set` flags.
pub(super) fn set_flags(settings: &[String]) -> impl Iterator<Item = String> + '_ {
    settings.iter().flat_map(|setting| ["--set".to_owned(), setting.clone()])
}

/// Prints the path of the report.
pub(super) fn print_path(folder: &Folder) -> Result<(), CliError> {
    terminal::print(&format!("report: {}\n", folder.path().join(FILE).display()))
}
