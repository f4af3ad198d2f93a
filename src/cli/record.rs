use std::path::PathBuf;

use clap::Args;

use super::error::Failure;
use super::terminal;
use trocar_recording::{RUPTURES_S, in_vivo_like_csv};
use trocar_report::write_file;

const EXAMPLES: &str = "\
Example:
  trocar record --seed 7 --out seven.csv";

/// Write the in-vivo-like recording.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct RecordArgs {
    /// Seed of the measurement noise
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// File to write, or - for standard output
    #[arg(long, value_name = "FILE", default_value = "in_vivo_like.csv")]
    out: PathBuf,
    /// Replace an existing file
    #[arg(long)]
    force: bool,
    /// Print errors only
    #[arg(long, short)]
    quiet: bool,
}

pub(super) fn run(args: &RecordArgs) -> Result<(), Failure> {
    let text = in_vivo_like_csv(args.seed);
    if args.out.as_os_str() == "-" {
        return terminal::print(&text);
    }
    super::refuse_existing(&args.out, args.force)?;
    write_file(&args.out, text.as_bytes())?;
    if args.quiet {
        return Ok(());
    }
    let [first, second] = RUPTURES_S;
    terminal::print(&format!("{}: layers rupture at {first} s and {second} s\n", args.out.display()))
}
