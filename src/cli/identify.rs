use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use clap::{Args, ValueEnum};

use super::error::Failure;
use super::finish::Finish;
use super::quantity::column;
use super::warnings::Warnings;
use super::{OutputArgs, interrupt, progress};
use trocar_base::interrupt::{catch, watch};
use trocar_document::Study;
use trocar_identify::{
    IdentifyError, MachineColumns, Measured, Part, PartColumns, PartRequest, Request, STEPS, Signals, identify,
    identify_part,
};
use trocar_recording::{Column, Limits};

/// Identify slave, master, arm or tissue from recordings: parameters with 95 % intervals, and predictions of other recordings
#[derive(Debug, Args)]
#[command(after_long_help = MORE, override_usage = USAGE, mut_arg("out", |arg| arg.help("Folder for the files; it contains one folder with the name of the first recording")))]
pub(super) struct IdentifyArgs {
    /// Recordings that determine the parameters (CSV, .mat, Parquet, TDMS, HDF5, Excel)
    #[arg(value_name = "RECORDING", required = true)]
    recordings: Vec<String>,
    /// A recording that takes no part in the estimation and is predicted (repeatable)
    #[arg(long, value_name = "RECORDING")]
    predict: Vec<String>,
    /// What is identified
    #[arg(long, value_enum, default_value_t = MachineKind::Slave)]
    machine: MachineKind,
    /// Column with the time; the factor or unit (s, ms, us, ns, min) converts it to s
    #[arg(long, value_name = "COLUMN[:FACTOR|:UNIT]", value_parser = column("s"))]
    time: Column,
    /// Column with the position of the master, for a slave scaled to its side; the factor or unit converts it to m (slave, arm, master)
    #[arg(long, value_name = "COLUMN[:FACTOR|:UNIT]", allow_hyphen_values = true, value_parser = column("m"))]
    master: Option<Column>,
    /// Column with the position of the slave or the needle, increasing into the tissue; the factor or unit converts it to m
    /// (slave, tissue)
    #[arg(long, value_name = "COLUMN[:FACTOR|:UNIT]", allow_hyphen_values = true, value_parser = column("m"))]
    slave: Option<Column>,
    /// Column with the force; the factor or unit converts it to N. Slave and tissue: on the slave, positive when it
    /// resists. Arm and master: of the hand, positive when it pushes the master forwards
    #[arg(long, value_name = "COLUMN[:FACTOR|:UNIT]", allow_hyphen_values = true, value_parser = column("N"))]
    force: Column,
    /// Column with the force of the actuator, positive when it pushes forwards; the factor or unit converts it to N. It
    /// separates the controller from a slave; for a master it is the force of its motor (slave, master)
    #[arg(long, value_name = "COLUMN[:FACTOR|:UNIT]", allow_hyphen_values = true, value_parser = column("N"))]
    actuator: Option<Column>,
    /// Column with the position that the hand is to have, such as the motion without perturbation; the factor or unit
    /// converts it to m. Without it, the hand holds one position (arm)
    #[arg(long, value_name = "COLUMN[:FACTOR|:UNIT]", allow_hyphen_values = true, value_parser = column("m"))]
    desired: Option<Column>,
    #[command(flatten)]
    output: OutputArgs,
}

/// What can be identified.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum MachineKind {
    /// The slave, with its controller
    Slave,
    /// The master, with its motor
    Master,
    /// The operator's arm
    Arm,
    /// The tissue
    Tissue,
}

impl MachineKind {
    fn word(self) -> &'static str {
        match self {
            Self::Slave => "slave",
            Self::Master => "master",
            Self::Arm => "arm",
            Self::Tissue => "tissue",
        }
    }
}

const USAGE: &str = "\
trocar identify [OPTIONS] --time COLUMN --master COLUMN --slave COLUMN
                       --force COLUMN RECORDING...
       trocar identify --machine tissue [OPTIONS] --time COLUMN --slave COLUMN
                       --force COLUMN RECORDING...
       trocar identify --machine arm|master [OPTIONS] --time COLUMN
                       --master COLUMN --force COLUMN RECORDING...";

const MORE: &str = "\
Slave:
  controller  position gain, velocity gain and delay, by regression of the
              actuator's force on the error between master and slave
  machine     mass, viscous and Coulomb friction (and the gains, without
              --actuator): the simulated slave, with the measured master and
              force as inputs, follows the measured slave as closely as possible
  sensor      scale, offset and lag of the force sensor, if they improve the
              simulation of parts that are held out

Tissue: the simulated force, with the measured position as input, follows the
  measured force up to a rupture. Compared are a spring and damper, a power of
  the depth and a layer that stiffens, each also with friction of the shaft.

Arm: the simulated force of the hand, with the measured and the desired
  position as inputs, follows the measured force. Compared are a spring and
  damper, one with a mass, and a mass between two springs.

Master: the simulated master, with the forces of hand and motor as inputs,
  follows the measured one. Compared are viscous friction, Coulomb friction,
  and a delay of the motor.

The intervals are 95 %, from blocks of errors that are correlated in time.
The fit is 100 (1 - |simulated - measured| / |measured - mean|) %.

Files, in a folder with the name of the first recording in --out: identification.json; machine.toml with the parameters; \
slave.toml, master.toml, arm.toml or tissue.toml, a scenario with what was identified (slave.toml only if the recordings determine forces); \
with slave.toml also twin.toml, a sweep over the intervals of its parameters; \
the measured and the simulated signal of each recording as columns and figure.

Examples:
  trocar identify free.csv foam.csv --predict spring.csv --time t_s \\
      --master xm_mm:mm --slave xs_mm:mm --force f_n --actuator u_n
  trocar identify free.csv foam.csv --predict wall.csv --time t_s \\
      --master xm_rad:0.075 --slave xs_rad:0.075 --force tau_Nm:13.333333
  trocar identify --machine tissue insertion.csv --time t_s \\
      --slave z_mm:mm --force f_n
  trocar identify --machine arm push.csv --time t_s --master x_m \\
      --force hand_n --desired target_m
  trocar identify --machine master free.csv --time t_s --master x_m \\
      --force hand_n --actuator motor_n";

pub(super) fn run(args: &IdentifyArgs) -> Result<(), Failure> {
    let columns = used_columns(args)?;
    let stem = args.recordings.first().and_then(|first| Path::new(first).file_stem());
    let name = stem.map_or_else(|| "recording".into(), |stem| stem.to_string_lossy().into_owned());
    let folder = args.output.destination().open("identify", &name)?;
    let stop = Arc::new(AtomicBool::new(false));
    let flag = stop.clone();
    interrupt::on_first(move || flag.store(true, Ordering::Relaxed));
    watch(stop);
    let identified =
        catch(|| identified(args, &columns)).map_err(|_| Failure::interrupted("nothing was written"))??;
    let document = identified.document();
    let warnings = Warnings::new(&args.output);
    warnings.print(&document.warnings);
    Finish { output: &args.output, folder, all: false, report: None }.document(&document)?;
    warnings.finish()
}

/// The columns of what is identified.
enum UsedColumns {
    Slave(MachineColumns),
    Part(Part, PartColumns),
}

/// Requires each needed column, and no unused one.
fn used_columns(args: &IdentifyArgs) -> Result<UsedColumns, Failure> {
    use MachineKind::{Arm, Master, Slave, Tissue};
    let IdentifyArgs { machine, master, slave, actuator, desired, .. } = args;
    let word = machine.word();
    for (flag, column, machines) in [
        ("--master", master, &[Slave, Arm, Master][..]),
        ("--slave", slave, &[Slave, Tissue]),
        ("--actuator", actuator, &[Slave, Master]),
        ("--desired", desired, &[Arm]),
    ] {
        if column.is_some() && !machines.contains(machine) {
            return Err(Failure::input(format!(
                "{flag} is not used to identify the {word}; remove it, or give another --machine"
            )));
        }
    }
    let needed = |flag, column: &Option<Column>| {
        let missing = || Failure::input(format!("to identify the {word}, {flag} is needed; give its column"));
        column.clone().ok_or_else(missing)
    };
    let (time, force) = (args.time.clone(), args.force.clone());
    let part = |part, position, input: &Option<Column>| {
        UsedColumns::Part(
            part,
            PartColumns { time: time.clone(), position, force: force.clone(), input: input.clone() },
        )
    };
    Ok(match machine {
        Slave => {
            let (master, slave) = (needed("--master", master)?, needed("--slave", slave)?);
            UsedColumns::Slave(MachineColumns { time, master, slave, force, actuator: actuator.clone() })
        }
        Master => part(Part::Master, needed("--master", master)?, actuator),
        Arm => part(Part::Arm, needed("--master", master)?, desired),
        Tissue => part(Part::Tissue, needed("--slave", slave)?, &None),
    })
}

fn identified(args: &IdentifyArgs, columns: &UsedColumns) -> Result<Box<dyn Study>, IdentifyError> {
    let limits = Limits::default();
    let bar = progress::bar(STEPS, args.output.quiet);
    bar.set_message("identifying");
    let identified: Box<dyn Study> = match columns {
        UsedColumns::Slave(columns) => {
            let open = |path: &String| Measured::open(Path::new(path), columns, &limits);
            let (training, predictions) = opened(args, open)?;
            Box::new(identify(Request { training, predictions }, || bar.inc(1))?)
        }
        UsedColumns::Part(part, columns) => {
            let open = |path: &String| Signals::open(Path::new(path), *part, columns, &limits);
            let (training, predictions) = opened(args, open)?;
            let progress = |done: usize, steps: usize| {
                bar.set_length(steps as u64);
                bar.set_position(done as u64);
            };
            Box::new(identify_part(*part, PartRequest { training, predictions }, progress)?)
        }
    };
    bar.finish_and_clear();
    Ok(identified)
}

/// Opens the recordings for training and those to predict.
fn opened<T>(
    args: &IdentifyArgs,
    open: impl Fn(&String) -> Result<T, IdentifyError>,
) -> Result<(Vec<T>, Vec<T>), IdentifyError> {
    let all = |paths: &[String]| paths.iter().map(&open).collect::<Result<Vec<T>, IdentifyError>>();
    Ok((all(&args.recordings)?, all(&args.predict)?))
}
