use std::io::{Cursor, Write as _};
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

use super::error::Failure;
use super::{SET_ONE, terminal};
use trocar_report::write_file;
use trocar_scenario::{Source, Values};
use trocar_studies::fmu::{Model, Unit, Version};

const EXAMPLES: &str = "\
Examples:
  trocar export fmu paper/augmented --rig
      the controller of a rig: samples in, commands out
  trocar export fmu layers/skin-augmented --fmi 2
      the whole simulation: the person's position in
  trocar export fmu layers/skin-augmented --tissue
      its tissue alone: the needle's position and velocity in, the force out

The unit contains a library, which `cargo build --release` builds next to trocar.";

/// A user may choose one of them.
const LICENCES: [(&str, &str); 2] =
    [("LICENSE-MIT", include_str!("../../LICENSE-MIT")), ("LICENSE-APACHE", include_str!("../../LICENSE-APACHE"))];

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Format {
    /// A functional mock-up unit (FMU) for co-simulation
    Fmu,
}

/// Write a scenario as a unit for other simulation programs.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct ExportArgs {
    /// The format to write
    #[arg(value_enum)]
    format: Format,
    /// A scenario file, or the name of a shipped scenario
    #[arg(value_name = "SCENARIO")]
    scenario: String,
    /// Version of the standard
    #[arg(long, value_name = "VERSION", default_value = "3", value_parser = ["2", "3"])]
    fmi: String,
    /// Export the controller of a rig instead of the whole simulation
    #[arg(long)]
    rig: bool,
    /// Export the tissue alone: position and velocity of the needle in, force out
    #[arg(long, conflicts_with = "rig")]
    tissue: bool,
    #[arg(long = "set", value_name = "SECTION.KEY=VALUE", help = SET_ONE)]
    settings: Vec<String>,
    /// The library for the FMU; without it, the library in the folder of this program
    #[arg(long, value_name = "FILE")]
    library: Option<PathBuf>,
    /// File to write; without it, the name of the scenario with the extension .fmu
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Replace an existing file
    #[arg(long)]
    force: bool,
    /// Print errors only
    #[arg(long, short)]
    quiet: bool,
}

pub(super) fn run(args: &ExportArgs) -> Result<(), Failure> {
    let Format::Fmu = args.format;
    let source = Source::parse(&args.scenario);
    let name = Values::load(&source, &args.settings)?.name().to_owned();
    let out = args.out.clone().unwrap_or_else(|| PathBuf::from(format!("{name}.fmu")));
    super::refuse_existing(&out, args.force)?;
    let (model, what) = match (args.rig, args.tissue) {
        (true, _) => (Model::Rig, "the controller of a rig"),
        (_, true) => (Model::Tissue, "the tissue"),
        _ => (Model::Simulation, "the whole simulation"),
    };
    let version = if args.fmi == "2" { Version::Two } else { Version::Three };
    let mut unit = Unit::new(&source, &args.settings, (model, version), library(args.library.as_deref())?)?;
    unit.files.extend(LICENCES.map(|(name, text)| (format!("documentation/licenses/{name}.txt"), text.into())));
    let count = unit.files.len();
    let packed = packed(&unit).map_err(|error| Failure::work(format!("the unit cannot be packed: {error}")))?;
    write_file(&out, &packed)?;
    if args.quiet {
        return Ok(());
    }
    terminal::print(&format!("{}: {what}, FMI {}.0, {count} files\n", out.display(), args.fmi))
}

fn library(given: Option<&Path>) -> Result<Vec<u8>, Failure> {
    use std::env::consts::{DLL_PREFIX, DLL_SUFFIX};
    let beside = || {
        let program = std::env::current_exe().unwrap_or_default();
        program.with_file_name(format!("{DLL_PREFIX}trocar_fmu{DLL_SUFFIX}"))
    };
    let path = given.map_or_else(beside, Path::to_owned);
    std::fs::read(&path).map_err(|error| {
        Failure::input(format!(
            "{}: {error}: run `cargo build --release`, which builds the library of units next to trocar, or give its \
             path with --library",
            path.display()
        ))
    })
}

fn packed(unit: &Unit) -> Result<Vec<u8>, std::io::Error> {
    let mut container = ZipWriter::new(Cursor::new(vec![]));
    for (path, content) in &unit.files {
        container.start_file(path.as_str(), SimpleFileOptions::default())?;
        container.write_all(content)?;
    }
    Ok(container.finish()?.into_inner())
}
