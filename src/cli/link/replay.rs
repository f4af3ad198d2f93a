use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use clap::Args;

use crate::cli::error::Failure;
use crate::cli::{terminal, warnings};
use trocar_document::Study as _;
use trocar_engine::engine::Trace;
use trocar_link::{Difference, Direction, Role, delays_csv, first_difference, read_direction};
use trocar_report::{Destination, document_text};
use trocar_scenario::{Scenario, Source};
use trocar_studies::run::{RunReport, run as run_scenario};

const EXAMPLES: &str = "\
Example:
  trocar link replay out/skin-augmented";

/// The base has every other key.
const REPLAY: &str = "\
# A link, with the delays that it logged.
name = \"replay\"
base = \"../master/scenario.toml\"

[channel]
forward_delay_s = 0.0
backward_delay_s = 0.0
jitter_s = 0.0
loss = 0.0
outages_s = []
delays_file = \"delays.csv\"
";

#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct ReplayArgs {
    /// Folder of a link, which contains the folders master and slave
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// Print errors only
    #[arg(long, short)]
    quiet: bool,
}

pub(super) fn run(args: &ReplayArgs) -> Result<(), Failure> {
    let load = |name: &str| Scenario::load(&Source::Disk(args.folder.join(name)), &[]);
    let of_link = |role: Role, name: &str| read(&args.folder.join(role.word()).join(name));
    // Report missing logs before anything is written.
    let traces = [of_link(Role::Master, "trace.csv")?, of_link(Role::Slave, "trace.csv")?];
    for role in [Role::Master, Role::Slave] {
        refuse_restarts(&args.folder.join(role.word()).join("summary.json"))?;
    }
    let scenario = load("master/scenario.toml")?;
    let delays = |role: Role, direction| -> Result<Vec<u32>, Failure> {
        let (name, text) = of_link(role, "delays.csv")?;
        Ok(read_direction(&name, &text, direction, &scenario.grid)?)
    };
    let backward = delays(Role::Master, Direction::Backward)?;
    let forward = delays(Role::Slave, Direction::Forward)?;
    let both = [(Direction::Forward, forward.as_slice()), (Direction::Backward, backward.as_slice())];
    let folder = Destination::new(&args.folder).open("link replay", "replay")?;
    folder.write("delays.csv", delays_csv(&both, &scenario.grid).as_bytes())?;
    folder.write("replay.toml", REPLAY.as_bytes())?;
    folder.commit()?;

    let replay = run_scenario(load("replay/replay.toml")?)?;
    let report = RunReport::of(&replay);
    if !args.quiet {
        report.warnings().iter().for_each(|warning| anstream::eprint!("{}", warnings::text(warning)));
    }
    let own = run_scenario(scenario)?;
    let (mut text, mut is_same) = (format!("{}\n", document_text(&report.document(), false)), true);
    for ((name, log), role) in traces.into_iter().zip([Role::Master, Role::Slave]) {
        let compared = |trace: &Trace| first_difference(&name, &log, trace);
        let (ticks, difference) = compared(&replay.trace)?;
        is_same &= difference.is_none();
        let _ = match difference {
            None => writeln!(text, "{}: {ticks} ticks, the replay is the same bit for bit", role.word()),
            Some(difference) => {
                writeln!(text, "{}: the replay differs at {}", role.word(), told(&difference, &own.trace))
            }
        };
        let _ = match compared(&own.trace)?.1 {
            None => writeln!(text, "  a run with the scenario's own channel is the same, too"),
            Some(difference) => {
                writeln!(text, "  the timing made a difference from {}", told(&difference, &own.trace))
            }
        };
    }
    let _ = writeln!(text, "files: {}", folder.path.join("replay.toml").display());
    if !args.quiet {
        terminal::print(&text)?;
    }
    if !is_same {
        return Err(Failure::work("the replay differs from the link; the two should agree bit for bit"));
    }
    Ok(())
}

/// A log without a summary has no restart.
fn refuse_restarts(path: &Path) -> Result<(), Failure> {
    let summary = std::fs::read(path).ok().and_then(|text| serde_json::from_slice::<serde_json::Value>(&text).ok());
    let is_above_0 = |key: &str| summary.as_ref().is_some_and(|summary| summary[key].as_u64().is_some_and(|n| n > 0));
    if is_above_0("restarts") || is_above_0("first_tick") {
        return Err(Failure::work(format!(
            "{}: a side was started anew during this link, so one simulation cannot repeat it: start both sides again",
            path.display()
        )));
    }
    Ok(())
}

fn told(difference: &Difference, trace: &Trace) -> String {
    let Difference { tick, column, logged, simulated } = difference;
    let time_s = trace.time_s.get(*tick as usize).copied().unwrap_or_default();
    format!("tick {tick} ({time_s} s): {column} is {logged:?} in the link and {simulated:?} in the simulation")
}

fn read(path: &Path) -> Result<(String, String), Failure> {
    let name = path.display().to_string();
    let text = std::fs::read_to_string(path).map_err(|error| {
        Failure::input(format!("{name}: {error}: give the folder of a link, which contains master and slave"))
    })?;
    Ok((name, text))
}
