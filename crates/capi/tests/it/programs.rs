//! Compiles programs in C and C++ and compares them with Rust's controller.

use std::fmt::Write as _;
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use tempfile::TempDir;
use trocar_core::rig::{HapticController, Sample, Settings};
use trocar_scenario::{Scenario, Source};

use crate::header::field;

const AUGMENTED: &str = "base = \"builtin:paper/augmented\"\n";

/// Length of the lever in the recordings, in m.
const LEVER_M: f64 = 0.075;

fn here() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Returns the folder with this package's libraries, beside the test. The loader finds the shared one by its SONAME.
fn libraries() -> PathBuf {
    let test = std::env::current_exe().expect("this program");
    let folder = test.parent().expect("in a folder").to_owned();
    #[cfg(target_os = "linux")]
    {
        let version = concat!(env!("CARGO_PKG_VERSION_MAJOR"), ".", env!("CARGO_PKG_VERSION_MINOR"));
        // Another test may have created it.
        let _ = std::os::unix::fs::symlink("libtrocar_c.so", folder.join(format!("libtrocar_c.so.{version}")));
    }
    folder
}

fn is_there(program: &str) -> bool {
    Command::new(program).arg("--version").output().is_ok_and(|output| output.status.success())
}

/// Returns the installed compilers among `names`, and prints a message if there is none. The gate installs all of them.
fn compilers(names: &[&'static str]) -> Vec<&'static str> {
    let found: Vec<_> = names.iter().copied().filter(|name| is_there(name)).collect();
    if found.is_empty() {
        println!("skipped: none of {names:?} is installed");
    }
    found
}

fn run(command: &mut Command, input: &str) -> String {
    command.env("LD_LIBRARY_PATH", libraries()).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap_or_else(|error| panic!("{command:?}: {error}"));
    let mut pipe = child.stdin.take().expect("piped");
    let output = std::thread::scope(|scope| {
        // A program that ends early closes the pipe.
        scope.spawn(move || drop(pipe.write_all(input.as_bytes())));
        child.wait_with_output().expect("ends")
    });
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{command:?}: {}: {errors}", output.status);
    String::from_utf8(output.stdout).expect("UTF-8")
}

/// Compiles a source of this package with every warning as an error. Returns the program.
fn compiled(compiler: &str, source: &str, folder: &TempDir) -> PathBuf {
    compiled_with(compiler, &[], source, folder)
}

/// Like [`compiled`], with more flags.
fn compiled_with(compiler: &str, flags: &[&str], source: &str, folder: &TempDir) -> PathBuf {
    let program = folder.path().join(compiler);
    let standard = if source.ends_with(".cpp") { "-std=c++17" } else { "-std=c99" };
    let mut command = Command::new(compiler);
    command.args([standard, "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-O1"]).args(flags);
    command.arg(format!("-DTROCAR_TEST_VERSION=\"{}\"", env!("CARGO_PKG_VERSION")));
    command.arg("-I").arg(here().join("include")).arg(here().join(source)).arg("-o").arg(&program);
    command.arg("-L").arg(libraries()).args(["-ltrocar_c", "-lm"]);
    run(&mut command, "");
    program
}

/// Samples, the settings of the controller, and the arguments that give a program the same settings.
struct Case {
    name: &'static str,
    samples: Vec<Sample>,
    settings: Settings,
    arguments: Vec<String>,
    events: u64,
}

/// Reads a recording of the lever rig: columns of time, slave angle and velocity, torque and, if there is one, master
/// angle.
fn recording(name: &'static str, torque: &str, contact_m: f64, events: u64) -> Case {
    let path = here().ancestors().nth(2).expect("in the workspace").join(name);
    let text = fs::read_to_string(path).expect("a recording of the repository");
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().expect("a header").split(',').collect();
    let place = |name: &str| header.iter().position(|column| *column == name);
    let slave = place("xs_rad").expect("the slave");
    let (velocity, force) = (place("vs_rad_s").expect("the velocity"), place(torque).expect("the torque"));
    let master = place("xm_rad").unwrap_or(slave);
    let sample = |line: &str| {
        let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().expect("a number")).collect();
        Sample {
            master_position_m: LEVER_M * cells[master],
            slave_position_m: LEVER_M * cells[slave],
            slave_velocity_m_per_s: LEVER_M * cells[velocity],
            force_n: cells[force] / LEVER_M,
        }
    };
    let samples: Vec<Sample> = lines.map(sample).collect();
    let settings = Settings { tick_s: 5e-4, contact_m, ..Settings::default() };
    let arguments = ["--tick", "5e-4", "--contact", &contact_m.to_string()].map(str::to_owned).to_vec();
    Case { name, samples, settings, arguments, events }
}

/// Returns the trace of the shipped augmented insertion.
fn augmented(folder: &TempDir) -> Case {
    let file = folder.path().join("augmented.toml");
    fs::write(&file, AUGMENTED).expect("written");
    let scenario = Scenario::load(&Source::Disk(file.clone()), &[]).expect("loads");
    let settings = scenario.rig_settings();
    let trace = trocar_studies::run::run(scenario).expect("runs").trace;
    let sample = |k: usize| Sample {
        master_position_m: trace.master_position_m[k],
        slave_position_m: trace.slave_position_m[k],
        slave_velocity_m_per_s: trace.slave_velocity_m_per_s[k],
        force_n: trace.measured_force_n[k],
    };
    let samples = (0..trace.len()).map(sample).collect();
    let arguments = vec!["--toml".to_owned(), file.display().to_string()];
    Case { name: "augmented", samples, settings, arguments, events: 2 }
}

/// Returns the three recordings of the repository and the augmented insertion.
fn cases(folder: &TempDir) -> [Case; 4] {
    [
        recording("scenarios/recordings/own_ctrl_pop.csv", "env_out_Nm_derived", 6.3e-3, 1),
        recording("tests/data/teleop_1dof/m2_f_spring.csv", "tau_e_Nm", -9e-3, 0),
        recording("tests/data/teleop_1dof/m2_d_free_motion.csv", "tau_e_Nm", 0.0, 0),
        augmented(folder),
    ]
}

impl Case {
    /// Formats the samples as input of a program.
    fn input(&self) -> String {
        let mut text = String::new();
        for Sample { master_position_m, slave_position_m, slave_velocity_m_per_s, force_n } in &self.samples {
            let _ = writeln!(text, "{master_position_m:?},{slave_position_m:?},{slave_velocity_m_per_s:?},{force_n:?}");
        }
        text
    }

    /// Returns Rust's commands: the bits of the numbers, then the words.
    fn commands(&self) -> Vec<[u64; 18]> {
        let mut controller = HapticController::new(&self.settings).expect("valid");
        let bits = |sample: &Sample| {
            let command = controller.step(sample);
            let (faults, limited) = (command.faults, command.limited);
            [
                command.slave_reference_m.to_bits(),
                command.master_force_n.to_bits(),
                command.allowed_force_step_n.to_bits(),
                command.stiffness_n_per_m.to_bits(),
                command.damping_n_s_per_m.to_bits(),
                command.predicted_force_n.to_bits(),
                command.residual_n.to_bits(),
                command.distance.to_bits(),
                command.decision.to_bits(),
                command.slave_velocity_m_per_s.to_bits(),
                u64::from(command.mode.code()),
                u64::from(command.alarm),
                u64::from(command.alarm_taken),
                u64::from(faults.master_position)
                    + 2 * u64::from(faults.slave_position)
                    + 4 * u64::from(faults.slave_velocity)
                    + 8 * u64::from(faults.force),
                u64::from(command.faulty_samples),
                u64::from(command.detection.code()),
                u64::from(command.state.code()),
                u64::from(limited.force)
                    + 2 * u64::from(limited.force_rate)
                    + 4 * u64::from(limited.reference_speed)
                    + 8 * u64::from(limited.lead),
            ]
        };
        self.samples.iter().map(bits).collect()
    }
}

/// Parses the printed rows of a program in the same form: the bits of `numbers` numbers, then words.
fn parsed<const N: usize>(text: &str, numbers: usize) -> Vec<[u64; N]> {
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        assert_eq!(cells.len(), N, "{line}");
        std::array::from_fn(|at| match cells[at] {
            number if at < numbers => number.parse::<f64>().expect("a number").to_bits(),
            word => word.parse().expect("a whole number"),
        })
    };
    text.lines().skip(1).map(row).collect()
}

fn assert_equal<const N: usize>(case: &Case, compiler: &str, found: &[[u64; N]], expected: &[[u64; N]]) {
    assert_eq!(found.len(), expected.len(), "{}", case.name);
    for (k, (found, expected)) in found.iter().zip(expected).enumerate() {
        assert_eq!(found, expected, "{} with {compiler}, sample {k}", case.name);
    }
}

/// Checks the commands that a program of the rig has printed.
fn assert_same(case: &Case, compiler: &str, text: &str) {
    assert_equal(case, compiler, &parsed(text, 10), &case.commands());
}

#[test]
fn a_program_in_c_gives_the_commands_of_rust_bit_for_bit() {
    let folder = TempDir::new().expect("a folder");
    let cases = cases(&folder);
    for case in &cases {
        let events: u64 = case.commands().iter().map(|command| command[12]).sum();
        assert_eq!(events, case.events, "{}", case.name);
    }
    for compiler in compilers(&["gcc", "clang"]) {
        let program = compiled(compiler, "examples/rig.c", &folder);
        for case in &cases {
            let found = run(Command::new(&program).args(&case.arguments), &case.input());
            assert_same(case, compiler, &found);
        }
    }
}

#[test]
fn the_detector_alone_in_c_gives_the_alarms_of_the_rig_bit_for_bit() {
    let folder = TempDir::new().expect("a folder");
    // Columns of the rig's commands: estimates, decision and velocity, then alarm and detection.
    let of_rig = |command: &[u64; 18]| [3, 4, 5, 6, 7, 8, 9, 11, 15].map(|column: usize| command[column]);
    for compiler in compilers(&["gcc", "clang"]) {
        let program = compiled(compiler, "examples/detector.c", &folder);
        for case in cases(&folder) {
            let mut input = String::new();
            for Sample { slave_position_m, slave_velocity_m_per_s, force_n, .. } in &case.samples {
                let _ = writeln!(input, "{slave_position_m:?},{slave_velocity_m_per_s:?},{force_n:?}");
            }
            let text = run(Command::new(&program).args(&case.arguments), &input);
            let found: Vec<[u64; 9]> = parsed(&text, 7);
            assert_equal(&case, compiler, &found, &case.commands().iter().map(of_rig).collect::<Vec<_>>());
            let alarms: u64 = found.iter().map(|row| row[7]).sum();
            assert!(alarms >= case.events, "{}: {alarms} alarms", case.name);
        }
    }
}

/// Runs Valgrind, which fails for every error and for memory without a pointer to it. The reader of scenarios keeps
/// tables of names for the life of the process, which Valgrind calls possibly lost.
fn valgrind(program: &Path) -> Command {
    let mut valgrind = Command::new("valgrind");
    valgrind
        .args(["--quiet", "--error-exitcode=1", "--leak-check=full", "--errors-for-leak-kinds=definite"])
        .arg(program);
    valgrind
}

#[test]
fn valgrind_finds_no_error_in_a_program_in_c() {
    if !is_there("valgrind") {
        println!("skipped: valgrind is not installed");
        return;
    }
    let folder = TempDir::new().expect("a folder");
    for compiler in compilers(&["gcc", "clang"]).into_iter().take(1) {
        let program = compiled(compiler, "examples/rig.c", &folder);
        for case in cases(&folder) {
            let output = run(valgrind(&program).args(&case.arguments), &case.input());
            assert_same(&case, "valgrind", &output);
        }
        let check = compiled(compiler, "tests/c/check.c", &folder);
        run(&mut valgrind(&check), "");
    }
}

#[test]
fn sizes_rejections_and_texts_agree_with_the_header() {
    let folder = TempDir::new().expect("a folder");
    for compiler in compilers(&["gcc", "clang"]) {
        run(&mut Command::new(compiled(compiler, "tests/c/check.c", &folder)), "");
    }
}

#[test]
fn under_sanitisers_no_sequence_of_samples_makes_a_command_exceed_its_limits() {
    let folder = TempDir::new().expect("a folder");
    for compiler in compilers(&["gcc", "clang"]).into_iter().take(1) {
        let flags = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all"];
        let program = compiled_with(compiler, &flags, "tests/c/adversarial.c", &folder);
        run(&mut Command::new(program), "");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_program_asks_the_loader_for_the_versioned_library() {
    let folder = TempDir::new().expect("a folder");
    if !is_there("readelf") {
        println!("skipped: readelf is not installed");
        return;
    }
    for compiler in compilers(&["gcc", "clang"]).into_iter().take(1) {
        let program = compiled(compiler, "tests/c/check.c", &folder);
        let needed = run(Command::new("readelf").arg("--dynamic").arg(program), "");
        let version = concat!(env!("CARGO_PKG_VERSION_MAJOR"), ".", env!("CARGO_PKG_VERSION_MINOR"));
        assert!(needed.contains(&format!("[libtrocar_c.so.{version}]")), "{needed}");
    }
}

#[test]
fn each_field_of_the_settings_has_the_offset_of_its_key() {
    let folder = TempDir::new().expect("a folder");
    for compiler in compilers(&["gcc", "clang"]) {
        let mut source = String::from("#include \"trocar.h\"\n");
        for (place, key) in Settings::KEYS.iter().enumerate() {
            let (name, offset) = (field(key), 8 * (place + 1));
            // An array of negative length does not compile.
            let _ = writeln!(source, "char at_{place}[offsetof(trocar_rig_settings, {name}) == {offset} ? 1 : -1];");
        }
        let size = 8 * (Settings::KEYS.len() + 1);
        let _ = writeln!(source, "char all[sizeof(trocar_rig_settings) == {size} ? 1 : -1];");
        let file = folder.path().join("places.c");
        fs::write(&file, source).expect("written");
        let object = folder.path().join("places.o");
        run(Command::new(compiler).arg("-c").arg("-I").arg(here().join("include")).arg(file).arg("-o").arg(object), "");
    }
}

#[test]
fn a_program_in_cpp_announces_the_same_alarms() {
    let folder = TempDir::new().expect("a folder");
    let case = augmented(&folder);
    let commands = case.commands();
    let alarms = commands.iter().enumerate().filter(|(_, command)| command[11] == 1);
    let expected: Vec<_> = alarms.map(|(k, command)| (k, command[0], command[1])).collect();
    for compiler in compilers(&["g++", "clang++"]) {
        let program = compiled(compiler, "examples/rig.cpp", &folder);
        let text = run(Command::new(program).arg(&case.arguments[1]), &case.input());
        let row = |line: &str| {
            let cells: Vec<&str> = line.split(',').collect();
            let bits = |at: usize| cells[at].parse::<f64>().expect("a number").to_bits();
            (cells[0].parse::<usize>().expect("a sample"), bits(1), bits(2))
        };
        assert_eq!(text.lines().map(row).collect::<Vec<_>>(), expected, "{compiler}");
    }
}

#[test]
fn the_ros2_controller_gives_the_commands_of_rust_with_a_stub_of_ros() {
    let folder = TempDir::new().expect("a folder");
    let case = augmented(&folder);
    let stub = here().join("tests/ros2_stub").display().to_string();
    for compiler in compilers(&["g++", "clang++"]) {
        let program = compiled_with(compiler, &["-I", &stub], "tests/ros2_stub/main.cpp", &folder);
        let text = run(Command::new(program).arg(&case.arguments[1]), &case.input());
        let commands = case.commands();
        assert_eq!(text.lines().count(), commands.len(), "{compiler}");
        for (k, (line, command)) in text.lines().zip(&commands).enumerate() {
            let (reference, force) = line.split_once(',').expect("two numbers");
            let number = |text: &str| text.parse::<f64>().expect("a number");
            // The force pushes the master against the direction of insertion.
            assert_eq!(
                [number(reference).to_bits(), (-number(force)).to_bits()],
                command[..2],
                "{compiler}, sample {k}"
            );
        }
    }
}

#[test]
fn cmake_and_pkg_config_find_the_installed_library() {
    if compilers(&["gcc", "clang"]).is_empty() || !is_there("cmake") {
        println!("skipped: CMake is not installed");
        return;
    }
    let folder = TempDir::new().expect("a folder");
    let at = |name: &str| folder.path().join(name).display().to_string();
    let (built, prefix, examples) = (at("built"), at("prefix"), at("examples"));
    let cmake = |arguments: &[&str]| run(Command::new("cmake").args(arguments), "");
    let source = here().display().to_string();
    cmake(&["-S", &source, "-B", &built, &format!("-DTROCAR_BUILD_DIR={}", libraries().display())]);
    cmake(&["--install", &built, "--prefix", &prefix]);
    let source = here().join("examples").display().to_string();
    cmake(&["-S", &source, "-B", &examples, &format!("-DCMAKE_PREFIX_PATH={prefix}")]);
    cmake(&["--build", &examples]);
    let case = augmented(&folder);
    let input = case.input();
    let found = run(Command::new(format!("{examples}/rig")).args(&case.arguments), &input);
    assert_same(&case, "CMake", &found);
    // Linked statically.
    let alarms = run(Command::new(format!("{examples}/rig_cpp")).arg(&case.arguments[1]), &input);
    let expected = case.commands().iter().filter(|command| command[11] == 1).count();
    assert_eq!(alarms.lines().count(), expected);

    if !is_there("pkg-config") {
        println!("skipped: pkg-config is not installed");
        return;
    }
    let mut ask = Command::new("pkg-config");
    let flags =
        run(ask.env("PKG_CONFIG_PATH", format!("{prefix}/lib/pkgconfig")).args(["--cflags", "--libs", "trocar"]), "");
    let program = at("by_pkg_config");
    let mut gcc = Command::new(compilers(&["gcc", "clang"])[0]);
    run(gcc.arg(here().join("examples/rig.c")).args(flags.split_whitespace()).args(["-o", &program]), "");
    assert_same(&case, "pkg-config", &run(Command::new(&program).args(&case.arguments), &input));
}
