//! Tries to falsify the verdict of the linear loop by random scenarios with a quiet hand.
//!
//! ```text
//! cargo bench --bench adversary -- 2000
//! cargo bench --bench adversary -- 60 --certificate
//! ```
//! A loop that is called stable must come to rest while the hand rests. `--certificate` does the same for scenarios
//! with augmentation and the certificate of their events. Keeps the scenarios of all counterexamples, for `trocar run`.
//! Fails if there is one.

mod case;
mod draw;
mod hand;
mod recording;
mod swing;
mod tissue;

use std::path::Path;
use std::process::ExitCode;

use case::{Case, Judged};
use rayon::prelude::*;
use swing::Motion;
use tissue::KINDS;

/// Number of cases at rest that are called not stable and shown.
const SHOWN: usize = 5;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let has = |flag: &str| arguments.iter().any(|argument| argument == flag);
    if !has("--bench") {
        // Built and started by `cargo test --benches`, too.
        return ExitCode::SUCCESS;
    }
    let count = arguments.iter().find_map(|argument| argument.parse().ok()).unwrap_or(2000);
    let (folder, kept) = (tempfile::tempdir().expect("a folder"), Path::new(env!("CARGO_TARGET_TMPDIR")));
    let is_augmented = has("--certificate");
    let judge = |number| Case::new(number, is_augmented).judge(folder.path());
    let mut all: Vec<Judged> = vec![];
    for judged in (0..count).into_par_iter().map(judge).collect::<Vec<_>>() {
        match judged {
            Ok(judged) => all.push(judged),
            Err(error) => println!("error: {error}"),
        }
    }
    table(&all);
    let of = |motion, is_stable| all.iter().filter(move |one| (one.motion, one.is_stable) == (motion, Some(is_stable)));
    for one in of(Motion::Rests, false).take(SHOWN) {
        println!("\nrests and is called not stable: {}\n{}", one.sentence, one.case.toml);
    }
    for one in of(Motion::Swings, true) {
        let path = one.case.write(kept).expect("written");
        println!("\nCOUNTEREXAMPLE {}: {}\n{}", path.display(), one.sentence, one.case.toml);
    }
    let is_refuted = of(Motion::Swings, true).next().is_some();
    if is_refuted || all.len() < count as usize { ExitCode::FAILURE } else { ExitCode::SUCCESS }
}

/// Prints the counts of each kind of tissue and of all.
fn table(all: &[Judged]) {
    println!("{:14} cases  swing  of these stable   rest  of these stable  not stable  unknown", "tissue");
    let row = |kind: &str, is_in: &dyn Fn(&Judged) -> bool| {
        let count = |is: &dyn Fn(&Judged) -> bool| all.iter().filter(|one| is_in(one) && is(one)).count();
        let motion = |motion| count(&|one| one.motion == motion);
        let called = |motion, is_stable| count(&|one| (one.motion, one.is_stable) == (motion, is_stable));
        println!(
            "{kind:14} {:5} {:6} {:16} {:6} {:16} {:11} {:8}",
            count(&|_| true),
            motion(Motion::Swings),
            called(Motion::Swings, Some(true)),
            motion(Motion::Rests),
            called(Motion::Rests, Some(true)),
            called(Motion::Rests, Some(false)),
            called(Motion::Rests, None),
        );
    };
    for kind in KINDS {
        row(kind, &|one| one.case.kind == kind);
    }
    row("all", &|_| true);
}
