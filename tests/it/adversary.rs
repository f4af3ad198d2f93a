//! Fixed cases of the adversary in `benches/adversary`.

#[path = "../../benches/adversary/case.rs"]
mod case;
#[path = "../../benches/adversary/draw.rs"]
mod draw;
#[path = "../../benches/adversary/hand.rs"]
mod hand;
#[path = "../../benches/adversary/recording.rs"]
mod recording;
#[path = "../../benches/adversary/swing.rs"]
mod swing;
#[path = "../../benches/adversary/tissue.rs"]
mod tissue;

use case::{Case, Judged};
use rayon::prelude::*;
use swing::Motion;

#[test]
fn no_loop_that_swings_is_called_stable() {
    let folder = tempfile::tempdir().expect("a folder");
    let judge = |number| Case::new(number, false).judge(folder.path()).expect("judged");
    // The last seven were called stable before the verdict covered damping and retreats.
    let cases: Vec<u64> = (0..33).chain([76, 93, 186, 819, 1382, 1396, 1734]).collect();
    let all: Vec<Judged> = cases.into_par_iter().map(judge).collect();
    let of = |motion| all.iter().filter(move |one| one.motion == motion);
    for one in of(Motion::Swings) {
        assert_ne!(one.is_stable, Some(true), "{}: {}\n{}", one.case.kind, one.sentence, one.case.toml);
    }
    assert!(of(Motion::Swings).count() >= 8 && of(Motion::Rests).count() >= 8);
    assert!(of(Motion::Rests).any(|one| one.is_stable == Some(true)));
}
