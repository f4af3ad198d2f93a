//! The cost of a tick on this machine, as the tables of `benches/README.md`.
//!
//! `cargo bench --bench table` measures and prints them; `-- --write` also writes the file. One process measures
//! everything, so that ratios are comparable. Progress goes to standard error.

mod components;
mod counted;
mod handwritten;
mod lanes;
mod linear;
mod machine;
mod markdown;
mod measured;
mod operations;
mod parts;
mod peak;
mod record;
mod share;
mod shipped;
mod side_by_side;
mod single;
mod sweeps;
mod timing;
mod whole;

use std::io::Write;
use std::path::Path;

const HEAD: &str = "# The cost of a tick

Written by `cargo bench --bench table -- --write`, which takes one to two minutes; without `-- --write` the tables are
only printed. All figures are from one run of that command: the best and the median of many repetitions, in ns per tick,
or per tick and case where cases run side by side. On a machine with other load, the best is the cost of the code, and
the difference to the median is due to the load.
";

fn main() {
    let has = |flag: &str| std::env::args().any(|argument| argument == flag);
    if !has("--bench") {
        // `cargo test --benches` also builds and starts this program, but an unoptimised build is not worth
        // measuring.
        return;
    }
    let peaks = begin("the machine", peak::measure);
    let machine = machine::section();
    let components = begin("a tick by component", components::section);
    let single = begin("a single run", single::section);
    let costs = begin("lanes", lanes::measure);
    let with_bank = begin("lanes, noise drawn in advance", lanes::measure_with_bank);
    let counts = begin("operations", operations::count);
    let sweeps = begin("sweeps", sweeps::section);
    let linear = begin("cost against cases and ticks", linear::section);
    let (lanes, operations) = (lanes::section(&costs, &with_bank), operations::section(&counts));
    let share = share::section(&peaks, &counts, &costs);
    let sections = [HEAD.to_owned(), machine, components, single, lanes, operations, share, sweeps, linear];
    let page = sections.join("\n");
    print!("{page}");
    if has("--write") {
        write(&Path::new(env!("CARGO_MANIFEST_DIR")).join("benches"), &page).expect("benches/README.md can be written");
    }
}

/// Prints the name of a measurement, then runs it.
fn begin<T>(what: &str, measure: impl FnOnce() -> T) -> T {
    eprintln!("measuring {what}");
    measure()
}

/// Writes `README.md` under a temporary name first, so that the file is never incomplete.
fn write(folder: &Path, page: &str) -> std::io::Result<()> {
    let mut file = tempfile::Builder::new().prefix(".README").tempfile_in(folder)?;
    file.write_all(page.as_bytes())?;
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        file.as_file().set_permissions(std::fs::Permissions::from_mode(0o644))?;
    }
    file.persist(folder.join("README.md"))?;
    Ok(())
}
