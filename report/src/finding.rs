//! What a comparison shows, as one sentence that is computed from its metrics.

use super::number::decimals;
use trocar_sim::metrics::{Outcome, RuptureMetrics};
use trocar_sim::run::Run;

/// Maximum advance of a held needle after a rupture, in m: the paper's slave is "frozen" (5.1), and the comparison with the paper
/// requires the same limit.
const HELD_M: f64 = 1e-4;

/// Maximum number of listed overshoots. For more ruptures, the maxima are compared.
const MAX_LISTED: usize = 3;

/// Returns the sentence.
pub(super) fn finding(runs: &[Run]) -> String {
    let diverged = runs.iter().filter_map(|run| match run.metrics.outcome {
        Outcome::Completed | Outcome::Oscillating { .. } => None,
        Outcome::Diverged { time_s } => Some(format!("{} diverges at {time_s} s", run.scenario.name)),
    });
    let diverged: Vec<String> = diverged.collect();
    if !diverged.is_empty() {
        let whose = if diverged.len() == 1 { "its" } else { "their" };
        return format!("{}: {whose} metrics cover the time before.", joined(&diverged));
    }
    let mut parts = vec![];
    if runs.iter().all(|run| run.metrics.ruptures.is_empty()) {
        parts.push("No layer ruptures".to_owned());
    } else {
        parts.extend(match runs {
            [run] => overshoot_of_one(run).into_iter().collect(),
            [first, second] => overshoot_of_pair(first, second),
            _ => overshoot_of_many(runs),
        });
        parts.push(detection(runs));
    }
    format!("{}, {}.", parts.join("; "), false_alarms(runs))
}

fn name(run: &Run) -> &str {
    &run.scenario.name
}

/// Returns the overshoots of the ruptures that have one. Only the last ruptures of a run can be without, near its end.
fn overshoots_m(run: &Run) -> Vec<f64> {
    run.metrics.ruptures.iter().filter_map(|rupture| rupture.slave_overshoot_m).collect()
}

fn overshoot_of_one(run: &Run) -> Option<String> {
    let overshoots_m = overshoots_m(run);
    let ruptures = Ruptures { total: overshoots_m.len(), are_all: overshoots_m.len() == run.metrics.ruptures.len() };
    (ruptures.total > 0).then(|| {
        format!("The {} after {} is {}", overshoot(&overshoots_m), ruptures.some(ruptures.total), listed(&overshoots_m))
    })
}

fn overshoot_of_pair(first: &Run, second: &Run) -> Vec<String> {
    let counts = [first, second].map(|run| run.metrics.ruptures.len());
    let mut parts = vec![];
    if counts[0] != counts[1] {
        let count = |count: usize| if count == 0 { "no rupture".to_owned() } else { counted(count as u64, "rupture") };
        parts.push(format!("{} has {} and {} {}", name(first), count(counts[0]), name(second), count(counts[1])));
    }
    let (mut before_m, mut after_m) = (overshoots_m(first), overshoots_m(second));
    let total = before_m.len().min(after_m.len());
    before_m.truncate(total);
    after_m.truncate(total);
    if total == 0 {
        if counts[0] == counts[1] {
            parts.push("The runs end too soon after the ruptures to compare the overshoot".into());
        }
        return parts;
    }
    let change = Change::of(&before_m, &after_m, Ruptures { total, are_all: counts == [total; 2] });
    let is_due_to_augmentation = !first.scenario.augmentation.enabled
        && second.scenario.augmentation.enabled
        && without_augmentation(first) == without_augmentation(second);
    parts.push(if is_due_to_augmentation {
        let (before, after) = (listed(&before_m), listed(&after_m));
        let verb = change.verb(total == 1 || total > MAX_LISTED);
        format!("Augmentation {}: {} {before} {verb} {after}", change.by_augmentation(), overshoot(&before_m))
    } else {
        let (of, than) = (name(second), name(first));
        format!("The overshoot of {of} is {}: {} against {}", change.against(than), listed(&after_m), listed(&before_m))
    });
    parts
}

/// Returns the resolved scenario without its name and its augmentation.
fn without_augmentation(run: &Run) -> Option<toml::Table> {
    let mut table: toml::Table = run.scenario.echo().parse().ok()?;
    table.remove("name");
    table.remove("augmentation");
    Some(table)
}

fn overshoot_of_many(runs: &[Run]) -> Vec<String> {
    let max_m = |run: &Run| overshoots_m(run).into_iter().reduce(f64::max);
    let with_max: Vec<(&Run, f64)> = runs.iter().filter_map(|run| Some((run, max_m(run)?))).collect();
    let smallest = with_max.iter().min_by(|a, b| a.1.total_cmp(&b.1));
    let largest = with_max.iter().max_by(|a, b| a.1.total_cmp(&b.1));
    let mut parts = vec![];
    if let (Some((small, small_m)), Some((large, large_m))) = (smallest, largest) {
        let (low, high) = (millimetres(*small_m), millimetres(*large_m));
        parts.push(if low == high {
            format!("The maximum overshoot is about the same in every run with a rupture: {low}")
        } else {
            format!(
                "The maximum overshoot is smallest in {} ({low}) and largest in {} ({high})",
                name(small),
                name(large)
            )
        });
    }
    let without = runs.iter().filter(|run| run.metrics.ruptures.is_empty());
    parts.extend(without.map(|run| format!("{} has no rupture", name(run))));
    parts
}

/// The ruptures with an overshoot.
#[derive(Clone, Copy)]
struct Ruptures {
    total: usize,
    /// Whether the runs have no other ruptures.
    are_all: bool,
}

impl Ruptures {
    /// Returns the name of `count` of the ruptures.
    fn some(self, count: usize) -> String {
        match (count == self.total, self.are_all, self.total) {
            (true, true, 1) => "the rupture".into(),
            (true, true, 2) => "both ruptures".into(),
            (true, true, total) => format!("all {total} ruptures"),
            (true, false, 1) => "rupture 1".into(),
            (true, false, total) => format!("ruptures 1 to {total}"),
            (false, true, total) => format!("{count} of {total} ruptures"),
            (false, false, total) => format!("{count} of ruptures 1 to {total}"),
        }
    }
}

/// The number of ruptures after which the overshoot is smaller or larger in the second run, and after which the needle is held.
struct Change {
    ruptures: Ruptures,
    held: usize,
    smaller: usize,
    larger: usize,
}

impl Change {
    /// Overshoots with the same printed value count as equal.
    fn of(before_m: &[f64], after_m: &[f64], ruptures: Ruptures) -> Self {
        let count = |is: &dyn Fn(f64, f64) -> bool| {
            let differs = |before: f64, after: f64| millimetres(before) != millimetres(after);
            before_m
                .iter()
                .zip(after_m)
                .filter(|(before, after)| differs(**before, **after) && is(**before, **after))
                .count()
        };
        Self {
            ruptures,
            held: count(&|before, after| after < before && after <= HELD_M),
            smaller: count(&|before, after| after < before),
            larger: count(&|before, after| after > before),
        }
    }

    fn by_augmentation(&self) -> String {
        let larger = self.ruptures.some(self.larger);
        let benefit = if self.held > 0 {
            format!("holds the needle after {}", self.ruptures.some(self.held))
        } else if self.smaller > 0 {
            format!("reduces the overshoot after {}", self.ruptures.some(self.smaller))
        } else if self.larger > 0 {
            return format!("increases the overshoot after {larger}");
        } else {
            return "hardly changes the overshoot".into();
        };
        if self.larger > 0 { format!("{benefit} and increases the overshoot after {larger}") } else { benefit }
    }

    fn against(&self, other: &str) -> String {
        let [smaller, larger] = [self.smaller, self.larger].map(|count| self.ruptures.some(count));
        match (self.smaller > 0, self.larger > 0) {
            (true, true) => format!("smaller than that of {other} after {smaller} and larger after {larger}"),
            (true, false) => format!("smaller than that of {other} after {smaller}"),
            (false, true) => format!("larger than that of {other} after {larger}"),
            (false, false) => format!("about that of {other} after {}", self.ruptures.some(self.ruptures.total)),
        }
    }

    fn verb(&self, is_singular: bool) -> &'static str {
        let total = self.ruptures.total;
        match (self.smaller == total, self.larger == total, is_singular) {
            (true, _, true) => "falls to",
            (true, _, false) => "fall to",
            (_, true, true) => "rises to",
            (_, true, false) => "rise to",
            (_, _, true) => "becomes",
            (_, _, false) => "become",
        }
    }
}

fn overshoot(overshoots_m: &[f64]) -> &'static str {
    if overshoots_m.len() > MAX_LISTED { "maximum overshoot" } else { "overshoot" }
}

/// Returns the overshoots, or the maximum of many.
fn listed(overshoots_m: &[f64]) -> String {
    match overshoots_m.iter().copied().reduce(f64::max) {
        Some(max_m) if overshoots_m.len() > MAX_LISTED => millimetres(max_m),
        _ => joined(&overshoots_m.iter().map(|overshoot_m| millimetres(*overshoot_m)).collect::<Vec<_>>()),
    }
}

/// Returns a sentence part about the ruptures that are detected and missed in all runs.
fn detection(runs: &[Run]) -> String {
    let ruptures = || runs.iter().flat_map(|run| &run.metrics.ruptures);
    let delays_s: Vec<f64> = ruptures().filter_map(|rupture: &RuptureMetrics| rupture.detection_delay_s).collect();
    if delays_s.len() == ruptures().count() {
        let max_ms = three_digits(1e3 * delays_s.into_iter().fold(0.0, f64::max));
        let counts: Vec<usize> = runs.iter().map(|run| run.metrics.ruptures.len()).collect();
        return match (counts.iter().all(|count| *count == counts[0]), counts[0]) {
            (true, 1) => format!("it is detected within {max_ms} ms"),
            (true, 2) => format!("both are detected within {max_ms} ms, none is missed"),
            (true, count) => format!("all {count} are detected within {max_ms} ms, none is missed"),
            (false, _) => format!("every rupture is detected within {max_ms} ms, none is missed"),
        };
    }
    let mut parts = vec![];
    for run in runs {
        let (name, metrics) = (name(run), &run.metrics);
        match (metrics.missed_ruptures, metrics.ruptures.len()) {
            (0, _) => {}
            (_, 1) => parts.push(format!("{name} misses the rupture")),
            (missed, total) => parts.push(format!("{name} misses {missed} of {total} ruptures")),
        }
        if metrics.undecided_ruptures > 0 {
            parts.push(format!("{name} ends too soon to decide on {}", counted(metrics.undecided_ruptures, "rupture")));
        }
    }
    parts.join(", ")
}

fn false_alarms(runs: &[Run]) -> String {
    let raises = runs.iter().filter(|run| run.metrics.false_alarms > 0).map(|run| {
        let count = counted(run.metrics.false_alarms, "false alarm");
        format!("{} raises {count}", name(run))
    });
    let raises: Vec<String> = raises.collect();
    if raises.is_empty() { "no alarm is false".into() } else { raises.join(", ") }
}

fn counted(count: u64, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

/// Joins texts with commas and "and".
fn joined(texts: &[String]) -> String {
    match texts {
        [] => String::new(),
        [one] => one.clone(),
        [others @ .., last] => format!("{} and {last}", others.join(", ")),
    }
}

fn millimetres(metres: f64) -> String {
    format!("{} mm", three_digits(1e3 * metres))
}

/// Returns a number that is not negative with three significant digits, at most four decimals and no zeros at its end.
fn three_digits(value: f64) -> String {
    if value > 0.0 && value < 1e-4 {
        return "below 0.0001".into();
    }
    let text = format!("{value:.*}", decimals(value, 3));
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trocar_sim::run::run;
    use trocar_sim::scenario::{Scenario, Source};

    /// Runs a shipped scenario. The sentence is computed from metrics, which a test can then set.
    fn shipped(name: &str) -> Run {
        run(Scenario::load(&Source::Builtin(name.into()), &[]).expect("a scenario")).expect("a run")
    }

    fn with_overshoots(run: &Run, name: &str, overshoots_mm: &[f64]) -> Run {
        let mut run = run.clone();
        let rupture = run.metrics.ruptures[0].clone();
        run.scenario.name = name.into();
        let of = |mm: &f64| RuptureMetrics { slave_overshoot_m: Some(1e-3 * mm), ..rupture.clone() };
        run.metrics.ruptures = overshoots_mm.iter().map(of).collect();
        run
    }

    #[test]
    fn the_sentence_is_computed_from_the_numbers() {
        let (classical, augmented) = (shipped("classical.toml"), shipped("augmented.toml"));
        let pair = |a: &Run, b: &Run| finding(&[a.clone(), b.clone()]);
        assert_eq!(
            pair(&classical, &augmented),
            "Augmentation holds the needle after both ruptures: overshoot 9.31 mm and 6.66 mm fall to 0.016 mm and 0 mm; \
             both are detected within 8 ms, none is missed, no alarm is false."
        );
        let of = |a: &[f64], b: &[f64]| {
            pair(&with_overshoots(&classical, "classical", a), &with_overshoots(&augmented, "augmented", b))
        };
        let said = |sentence: String| sentence.split(';').next().unwrap_or_default().to_owned();
        assert_eq!(
            said(of(&[9.0, 7.0], &[0.05, 8.0])),
            "Augmentation holds the needle after 1 of 2 ruptures and increases the overshoot after 1 of 2 ruptures: \
             overshoot 9 mm and 7 mm become 0.05 mm and 8 mm"
        );
        assert_eq!(
            said(of(&[9.0], &[0.5])),
            "Augmentation reduces the overshoot after the rupture: overshoot 9 mm falls to 0.5 mm"
        );
        assert_eq!(
            said(of(&[9.0], &[9.5])),
            "Augmentation increases the overshoot after the rupture: overshoot 9 mm rises to 9.5 mm"
        );
        assert_eq!(said(of(&[9.0], &[9.0])), "Augmentation hardly changes the overshoot: overshoot 9 mm becomes 9 mm");
        assert_eq!(
            said(of(&[4.0, 3.0, 2.0, 1.0], &[0.0, 0.0, 0.0, 0.0])),
            "Augmentation holds the needle after all 4 ruptures: maximum overshoot 4 mm falls to 0 mm"
        );
        assert!(of(&[9.0, 7.0], &[0.0]).starts_with("classical has 2 ruptures and augmented 1 rupture; "));
        // The order matters: only the second scenario can be the augmented one.
        assert_eq!(
            said(pair(&augmented, &classical)),
            "The overshoot of classical is larger than that of augmented after both ruptures: 9.31 mm and 6.66 mm against \
             0.016 mm and 0 mm"
        );
        let (a, b) = (with_overshoots(&classical, "a", &[1.0, 2.0]), with_overshoots(&classical, "b", &[2.0, 1.0]));
        assert_eq!(
            said(pair(&a, &b)),
            "The overshoot of b is smaller than that of a after 1 of 2 ruptures and larger after 1 of 2 ruptures: 2 mm and \
             1 mm against 1 mm and 2 mm"
        );
        let c = with_overshoots(&classical, "c", &[]);
        assert_eq!(
            finding(&[a.clone(), b, c.clone()]),
            "The maximum overshoot is about the same in every run with a rupture: 2 mm; c has no rupture; every rupture is \
             detected within 3 ms, none is missed, no alarm is false."
        );
        assert_eq!(finding(&[c.clone(), c]), "No layer ruptures, no alarm is false.");
        assert_eq!(said(finding(&[a])), "The overshoot after both ruptures is 1 mm and 2 mm");
    }

    #[test]
    fn misses_false_alarms_and_divergence_are_named() {
        let classical = shipped("classical.toml");
        let mut bad = classical.clone();
        bad.scenario.name = "bad".into();
        (bad.metrics.missed_ruptures, bad.metrics.false_alarms) = (1, 2);
        bad.metrics.ruptures[1].detection_delay_s = None;
        let sentence = finding(&[classical.clone(), bad.clone()]);
        assert!(sentence.ends_with("; bad misses 1 of 2 ruptures, bad raises 2 false alarms."), "{sentence}");
        bad.metrics.outcome = Outcome::Diverged { time_s: 0.83 };
        let sentence = finding(&[classical.clone(), bad.clone()]);
        assert_eq!(sentence, "bad diverges at 0.83 s: its metrics cover the time before.");
        assert_eq!(
            finding(&[bad.clone(), bad]),
            "bad diverges at 0.83 s and bad diverges at 0.83 s: their metrics cover the time before."
        );
    }

    #[test]
    fn numbers_have_three_digits() {
        let shown = [9.308, 0.01604, 17.24, 123.4, 0.0, 1e-9, 99.96, 8.0].map(three_digits);
        assert_eq!(shown, ["9.31", "0.016", "17.2", "123", "0", "below 0.0001", "100", "8"]);
    }
}
