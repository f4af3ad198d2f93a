use super::error::Failure;
use super::terminal;
use trocar_document::command_line;
use trocar_report::Folder;
use trocar_report::html::Again;
use trocar_studies::run::Run;

pub(super) const FILE: &str = "report.html";

/// An absolute path becomes its file name, which reveals no path of this machine.
pub(super) fn shown(path: &str) -> String {
    let parsed = std::path::Path::new(path);
    match parsed.file_name() {
        Some(name) if parsed.is_absolute() => name.to_string_lossy().into_owned(),
        _ => path.to_owned(),
    }
}

pub(super) fn set_flags(settings: &[String]) -> impl Iterator<Item = String> + '_ {
    settings.iter().flat_map(|setting| ["--set".to_owned(), setting.clone()])
}

pub(super) fn print_path(folder: &Folder) -> Result<(), Failure> {
    terminal::print(&format!("report: {}\n", folder.path.join(FILE).display()))
}

/// The instructions to repeat a command with the scenarios of its runs, as files under their names, and
/// further flags.
pub(super) fn again(command: &'static str, runs: &[Run], flags: impl IntoIterator<Item = String>) -> Again {
    let files: Vec<_> = runs.iter().map(|run| (format!("{}.toml", run.scenario.name), run.scenario.echo())).collect();
    let names = files.iter().map(|(name, _)| name.clone());
    let words = command.split_whitespace().skip(1).map(str::to_owned).chain(names);
    let line = command_line(words.chain(flags).chain(["--report".to_owned()]));
    Again { command, line, files, note: Again::SAVE }
}

pub(super) fn seeds_flag(seeds: Option<u64>) -> impl Iterator<Item = String> {
    seeds.into_iter().flat_map(|seeds| ["--seeds".to_owned(), seeds.to_string()])
}
