//! A program can link this crate and another BLAS, and each uses its own routines.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::time::SystemTime;
use std::{env, fs};

/// Routines of BLAS and LAPACK without the prefix of their precision.
const ROUTINES: [&str; 38] = [
    "asum", "axpy", "copy", "dot", "nrm2", "rot", "scal", "swap", "gemv", "ger", "symv", "syr", "syr2", "trmv", "trsv",
    "gemm", "symm", "syrk", "syr2k", "trmm", "trsm", "gesv", "getrf", "getri", "getrs", "geqrf", "ormqr", "potrf",
    "potri", "potrs", "syev", "syevd", "syevr", "sygv", "geev", "gesdd", "gesvd", "gelsd",
];

/// Return value of the user's routines, which trocar's routines never return.
const MARK: f64 = 41.0;

/// Returns a BLAS in a single object file, so that all its names are linked.
fn blas() -> String {
    let names =
        ROUTINES.iter().flat_map(|routine| ["s", "d", "c", "z"].map(|precision| format!("{precision}{routine}_")));
    names.map(|name| format!("#[unsafe(no_mangle)] pub extern \"C\" fn {name}() -> f64 {{ {MARK:?} }}\n")).collect()
}

/// Certifies a scenario, which needs semidefinite programs, and calls the BLAS.
const PROGRAM: &str = r#"
use user_blas as _;
use trocar::scenario::{Scenario, Source};
use trocar::stability::{LinearLoop, Switching, SwitchingSettings, TissueRange};
unsafe extern "C" {
    fn dgemm_() -> f64;
    fn dpotrf_() -> f64;
}
fn main() {
    let snap = ["augmentation.reengage=snap".to_owned()];
    let scenario = Scenario::load(&Source::parse("builtin:paper/augmented.toml"), &snap).expect("loads");
    let settings = LinearLoop::of(&scenario, TissueRange::spring(200.0, 5.0)).expect("analysed");
    let settings = SwitchingSettings::of(&scenario, settings, (50.0, 600.0)).expect("covered");
    let dwell = Switching::certified_dwell(&settings).expect("analysed");
    // SAFETY: the test defines both functions without arguments.
    println!("{:?} {:?} {dwell:?}", unsafe { dgemm_() }, unsafe { dpotrf_() });
}
"#;

/// Returns cargo's folder with the dependencies of this test, and the latest trocar library in it.
fn built() -> (PathBuf, PathBuf) {
    let folder = env::current_exe().expect("a path").parent().expect("a folder").to_owned();
    let is_library = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        name.starts_with("libtrocar-") && name.ends_with(".rlib")
    };
    let files = fs::read_dir(&folder).expect("a folder").map(|entry| entry.expect("an entry").path());
    let age = |path: &PathBuf| path.metadata().and_then(|about| about.modified()).unwrap_or(SystemTime::UNIX_EPOCH);
    let library = files.filter(is_library).max_by_key(age).expect("cargo has built the library for this test");
    (folder, library)
}

fn run(command: &mut Command) -> Output {
    let output = command.output().expect("runs");
    assert!(output.status.success(), "{command:?}\n{}", String::from_utf8_lossy(&output.stderr));
    output
}

fn rustc(folder: &Path) -> Command {
    let mut command = Command::new(env::var_os("RUSTC").unwrap_or_else(|| "rustc".into()));
    command.current_dir(folder).args(["--edition=2024", "-Ccodegen-units=1"]);
    command
}

#[test]
fn a_program_with_its_own_blas_links_and_each_uses_its_own_routines() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("user_blas.rs"), blas()).expect("written");
    fs::write(folder.path().join("programme.rs"), PROGRAM).expect("written");
    run(rustc(folder.path()).args(["--crate-type=rlib", "user_blas.rs"]));
    let (dependencies, library) = built();
    let mut programme = rustc(folder.path());
    programme.arg("-L").arg(format!("dependency={}", dependencies.display()));
    programme.arg("--extern").arg(format!("trocar={}", library.display()));
    run(programme.args(["--extern=user_blas=libuser_blas.rlib", "programme.rs"]));
    let output = run(&mut Command::new(folder.path().join("programme")));
    assert_eq!(String::from_utf8_lossy(&output.stdout), format!("{MARK:?} {MARK:?} Some(1)\n"));
}
