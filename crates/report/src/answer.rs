//! The answer of a page, in sentences with numbers: what the needle did at the first rupture, what the hand felt, and whether the
//! runs are stable. [`finding`](super::finding) tells of all ruptures.

use super::finding::{differ_in_augmentation, false_alarms, joined};
use super::tables::outcome;
use trocar_document::{counted, show};
use trocar_metrics::{Outcome, RUPTURE_WINDOW_S, RuptureMetrics, TRAVEL_S, Unit};
use trocar_studies::run::Run;

/// Maximum number of runs with a number each.
const MAX_RUNS: usize = 3;

/// Returns the answer of some runs.
pub(super) fn answer(runs: &[&Run]) -> String {
    match runs {
        [first, second] if differ_in_augmentation(first, second) => answer_of_schemes(first, second),
        _ => told(runs, &runs.iter().map(|run| format!("in {}", run.scenario.name)).collect::<Vec<_>>()),
    }
}

/// Returns the answer of a classical and an augmented run of the same scenario.
#[must_use]
pub fn answer_of_schemes(classical: &Run, augmented: &Run) -> String {
    told(&[classical, augmented], &["without augmentation".to_owned(), "with it".to_owned()])
}

fn told(runs: &[&Run], whose: &[String]) -> String {
    let mut sentences = vec![];
    let ruptures: Vec<Option<&RuptureMetrics>> = runs.iter().map(|run| run.metrics.ruptures.first()).collect();
    if ruptures.iter().all(Option::is_none) {
        sentences.push("No layer ruptures".to_owned());
    } else if runs.len() <= MAX_RUNS {
        let advance = |one: &RuptureMetrics| one.slave_overshoot_m.map(|metres| show(Some(metres), Unit::Metre));
        if let Some(numbers) = of_each(&ruptures, whose, advance) {
            sentences
                .push(format!("In the {RUPTURE_WINDOW_S} s after the first rupture the needle advances {numbers}"));
        }
        let fall = |one: &RuptureMetrics| one.felt_contrast.map(|share| show(Some(share), Unit::Share));
        if let Some(numbers) = of_each(&ruptures, whose, fall) {
            sentences.push(format!("In the first {TRAVEL_S} s the force on the hand falls {numbers}"));
        }
    }
    sentences.extend(missed(runs, whose));
    sentences.push(stability(runs));
    sentences.iter().map(|sentence| format!("{sentence}.")).collect::<Vec<_>>().join(" ")
}

/// Returns "by 9.3 mm without augmentation and by 0.02 mm with it", or `None` if no run has the number.
fn of_each(
    ruptures: &[Option<&RuptureMetrics>],
    whose: &[String],
    number: impl Fn(&RuptureMetrics) -> Option<String>,
) -> Option<String> {
    let numbers: Vec<Option<String>> = ruptures.iter().map(|rupture| rupture.and_then(&number)).collect();
    let (known, of): (Vec<&String>, Vec<&String>) =
        numbers.iter().zip(whose).filter_map(|(number, whose)| Some((number.as_ref()?, whose))).unzip();
    match &known[..] {
        [] => None,
        [one] if ruptures.len() == 1 => Some(format!("by {one}")),
        [first, others @ ..] if known.len() == ruptures.len() && others.iter().all(|other| other == first) => {
            Some(format!("by {first} in {}", if known.len() == 2 { "both runs" } else { "all runs" }))
        }
        _ => {
            let each = known.iter().zip(of).map(|(number, whose)| format!("by {number} {whose}"));
            Some(joined(&each.collect::<Vec<_>>()))
        }
    }
}

/// Returns a clause for each run that misses ruptures, or one for all, with the reason of the first one.
fn missed(runs: &[&Run], whose: &[String]) -> Vec<String> {
    let clause = |run: &Run, whose: &str| {
        let metrics = &run.metrics;
        let of_all = format!("{} of {}", metrics.missed_ruptures, counted(metrics.ruptures.len() as u64, "rupture"));
        let is_missed = if metrics.missed_ruptures == 1 { "is" } else { "are" };
        let reason = metrics.ruptures.iter().find_map(|rupture| rupture.miss.as_ref());
        let because = reason.map_or(String::new(), |miss| format!(" ({})", miss.reason));
        (metrics.missed_ruptures > 0).then(|| format!("{of_all} {is_missed} missed {whose}{because}"))
    };
    let of_both: Vec<_> = runs.iter().filter_map(|run| clause(run, "in both runs")).collect();
    match &of_both[..] {
        [first, second] if runs.len() == 2 && first == second => vec![first.clone()],
        _ => runs.iter().zip(whose).filter_map(|(run, whose)| clause(run, whose)).collect(),
    }
}

/// Returns whether the runs end at rest, and the false alarms, if any.
fn stability(runs: &[&Run]) -> String {
    let unstable: Vec<String> =
        runs.iter().filter(|run| run.metrics.outcome != Outcome::Completed).map(|run| outcome(run)).collect();
    let stable = match (&unstable[..], runs.len()) {
        ([], 1) => "The run neither diverges nor ends in a swing".to_owned(),
        ([], 2) => "Neither run diverges or ends in a swing".to_owned(),
        ([], _) => "No run diverges or ends in a swing".to_owned(),
        (unstable, _) => format!("Unstable: {}", unstable.join("; ")),
    };
    if runs.iter().all(|run| run.metrics.false_alarms == 0) {
        return stable;
    }
    format!("{stable}; {}", false_alarms(runs))
}

#[cfg(test)]
mod tests {
    use super::*;
    use trocar_scenario::{Scenario, Source};
    use trocar_studies::run::run;

    fn shipped(name: &str, settings: &[&str]) -> Run {
        let settings: Vec<String> = settings.iter().map(|setting| (*setting).to_owned()).collect();
        run(Scenario::load(&Source::Builtin(name.into()), &settings).expect("a scenario")).expect("a run")
    }

    #[test]
    fn a_pair_is_told_with_its_metrics() {
        let (classical, augmented) = (shipped("paper/classical.toml", &[]), shipped("paper/augmented.toml", &[]));
        let overshoot = |run: &Run| show(run.metrics.ruptures[0].slave_overshoot_m, Unit::Metre);
        let fall = |run: &Run| show(run.metrics.ruptures[0].felt_contrast, Unit::Share);
        assert_eq!(
            answer(&[&classical, &augmented]),
            format!(
                "In the 0.5 s after the first rupture the needle advances by {} without augmentation and by {} with it. In the \
                 first 0.3 s the force on the hand falls by {} without augmentation and by {} with it. Neither run diverges or \
                 ends in a swing.",
                overshoot(&classical),
                overshoot(&augmented),
                fall(&classical),
                fall(&augmented)
            )
        );
        let one = answer(&[&classical]);
        assert!(one.contains(&format!("the needle advances by {}. ", overshoot(&classical))), "{one}");
        assert!(one.ends_with("The run neither diverges nor ends in a swing."), "{one}");
        let same = answer(&[&classical, &classical.clone()]);
        assert!(same.contains(&format!("by {} in both runs.", overshoot(&classical))), "{same}");
    }

    #[test]
    fn misses_with_their_reason_and_unstable_runs_are_told() {
        let settings = ["detector.threshold=100"];
        let (classical, augmented) =
            (shipped("paper/classical.toml", &settings), shipped("paper/augmented.toml", &settings));
        let missed = answer(&[&classical, &augmented]);
        assert!(
            missed.contains(" 2 of 2 ruptures are missed in both runs (below the threshold: g reached "),
            "{missed}"
        );
        let wall = answer(&[&shipped("passivity/late-wall.toml", &[])]);
        assert!(wall.starts_with("No layer ruptures. Unstable: late-wall: oscillating, by "), "{wall}");
        let mut alarmed = classical.clone();
        alarmed.metrics.false_alarms = 3;
        assert!(answer(&[&alarmed]).ends_with("; classical raises 3 false alarms."));
        let mut early = classical;
        early.metrics.ruptures[0].slave_overshoot_m = None;
        early.metrics.ruptures[0].felt_contrast = None;
        assert!(!answer(&[&early]).contains("needle advances"));
    }
}
