//! `trocar identify`.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use clap::{Args, ValueEnum};

use super::error::CliError;
use super::finish::Finish;
use super::quantity::column;
use super::warnings::Warnings;
use super::{OutputArgs, interrupt, progress};
use trocar_base::interrupt::{catch, watch};
use trocar_document::Study as _;
use trocar_identify::{Identification, IdentifyError, MachineColumns, Measured, Request, STEPS, identify};
use trocar_recording::{Column, Limits};

/// Identify a machine from recordings: parameters with 95 % intervals, and predictions of other recordings
#[derive(Debug, Args)]
#[command(after_long_help = MORE, override_usage = USAGE, mut_arg("out", |arg| arg.help("Folder for the files; it contains one folder with the name of the first recording")))]
pub(super) struct IdentifyArgs {
    /// Recordings that determine the parameters (CSV, .mat, Parquet, TDMS, HDF5, Excel)
    #[arg(value_name = "RECORDING", required = true)]
    recordings: Vec<String>,
    /// A recording that takes no part in the estimation and is predicted (repeatable)
    #[arg(long, value_name = "RECORDING")]
    predict: Vec<String>,
    /// The machine
    #[arg(long, value_enum, default_value_t = MachineKind::Slave)]
    machine: MachineKind,
    /// Column with the time; the factor or unit (s, ms, us, ns, min) converts it to s
    #[arg(long, value_name = "COLUMN[:FACTOR|:UNIT]", value_parser = column("s"))]
    time: Column,
    /// Column with the position of the master, scaled to the slave's side; the factor or unit converts it to m
    #[arg(long, value_name = "COLUMN[:FACTOR|:UNIT]", allow_hyphen_values = true, value_parser = column("m"))]
    master: Column,
    /// Column with the position of the slave; the factor or unit converts it to m
    #[arg(long, value_name = "COLUMN[:FACTOR|:UNIT]", allow_hyphen_values = true, value_parser = column("m"))]
    slave: Column,
    /// Column with the force on the slave, positive when it resists; the factor or unit converts it to N
    #[arg(long, value_name = "COLUMN[:FACTOR|:UNIT]", allow_hyphen_values = true, value_parser = column("N"))]
    force: Column,
    /// Column with the force of the slave's actuator, positive when it pushes forwards; the factor or unit converts it
    /// to N. It separates the controller from the machine
    #[arg(long, value_name = "COLUMN[:FACTOR|:UNIT]", allow_hyphen_values = true, value_parser = column("N"))]
    actuator: Option<Column>,
    /// Memory for reading a recording, in MiB; a file whose content needs more is refused [default: 512]
    #[arg(long, value_name = "MIB", value_parser = clap::value_parser!(u64).range(1..=1 << 20))]
    max_memory: Option<u64>,
    #[command(flatten)]
    output: OutputArgs,
}

/// A machine that can be identified.
#[derive(Debug, Clone, Copy, ValueEnum)]
enum MachineKind {
    /// The slave, with its controller
    Slave,
}

const USAGE: &str = "\
trocar identify [OPTIONS] --time COLUMN --master COLUMN --slave COLUMN
                       --force COLUMN RECORDING...";

const MORE: &str = "\
Method:
  controller  position gain, velocity gain and delay, by regression of the
              actuator's force on the error between master and slave
  machine     mass, viscous and Coulomb friction (and the gains, without
              --actuator): the simulated slave, with the measured master and
              force as inputs, follows the measured slave as closely as possible
  sensor      scale, offset and lag of the force sensor, if they improve the
              simulation of parts that are held out
  intervals   95 %, from blocks of errors that are correlated in time

The fit is 100 (1 - |simulated - slave| / |slave - mean|) %.

Files, in a folder with the name of the first recording in --out: identification.json; machine.toml with the parameters; \
slave.toml, a scenario with this slave, if the recordings determine forces; measured and simulated positions of each recording as columns and figure.

Examples:
  trocar identify free.csv foam.csv --predict spring.csv --time t_s \\
      --master xm_mm:mm --slave xs_mm:mm --force f_n --actuator u_n
  trocar identify free.csv foam.csv --predict wall.csv --time t_s \\
      --master xm_rad:0.075 --slave xs_rad:0.075 --force tau_Nm:13.333333";

pub(super) fn run(args: &IdentifyArgs) -> Result<(), CliError> {
    let MachineKind::Slave = args.machine;
    let stop = Arc::new(AtomicBool::new(false));
    let flag = stop.clone();
    // If the handler cannot be installed, Ctrl-C ends the process at once.
    let _ = interrupt::on_first(move || flag.store(true, Ordering::Relaxed));
    watch(stop);
    let identified = catch(|| identified(args)).map_err(|_| CliError::Interrupted { kept: None })??;
    let document = identified.document();
    let warnings = Warnings::new(&args.output);
    warnings.print(&document.warnings);
    let stem = args.recordings.first().and_then(|first| Path::new(first).file_stem());
    let name = stem.map_or_else(|| "recording".into(), |stem| stem.to_string_lossy().into_owned());
    let folder = args.output.folder().folder(&name);
    Finish { output: &args.output, folder, all: false, report: None }.document(&document)?;
    warnings.finish()
}

fn identified(args: &IdentifyArgs) -> Result<Identification, IdentifyError> {
    let columns = MachineColumns {
        time: args.time.clone(),
        master: args.master.clone(),
        slave: args.slave.clone(),
        force: args.force.clone(),
        actuator: args.actuator.clone(),
    };
    let mut limits = Limits::default();
    if let Some(mebibytes) = args.max_memory {
        limits.max_memory_bytes = mebibytes << 20;
    }
    let open = |paths: &[String]| -> Result<Vec<Measured>, IdentifyError> {
        paths.iter().map(|path| Measured::open(Path::new(path), &columns, &limits)).collect()
    };
    let request = Request { training: open(&args.recordings)?, predictions: open(&args.predict)? };
    let bar = progress::bar(STEPS, args.output.quiet);
    bar.set_message("identifying");
    let identified = identify(request, || bar.inc(1));
    bar.finish_and_clear();
    identified
}
