//! What a comparison shows, in one or two sentences that are computed from its metrics.

use trocar_document::{counted, decimals};
use trocar_metrics::{Outcome, RuptureMetrics};
use trocar_studies::run::Run;

/// Maximum advance of a held needle after a rupture, in m: the paper's slave is "frozen" (5.1), and the comparison with the paper
/// requires the same limit.
const HELD_M: f64 = 1e-4;

/// Distances that differ by less than this share of the larger one are about the same.
const SAME_SHARE: f64 = 0.05;

/// Maximum number of listed distances. For more ruptures, the maxima are compared.
const MAX_LISTED: usize = 3;

/// The distance that the needle has gone too far after a rupture.
#[derive(Clone, Copy)]
struct Measure {
    noun: &'static str,
    of: fn(&RuptureMetrics) -> Option<f64>,
}

impl Measure {
    /// Beyond the intended motion.
    const EXCESS: Self = Self { noun: "excess advance", of: |rupture| rupture.excess_advance_m };
    /// From the rupture, for motions whose intention is not known.
    const ADVANCE: Self = Self { noun: "advance in 2 s", of: |rupture| rupture.horizon_advance_m };

    fn for_runs(runs: &[&Run]) -> Self {
        let is_known = |run: &&Run| run.metrics.ruptures.iter().any(|rupture| rupture.excess_advance_m.is_some());
        let with_ruptures = || runs.iter().filter(|run| !run.metrics.ruptures.is_empty());
        if with_ruptures().all(is_known) { Self::EXCESS } else { Self::ADVANCE }
    }

    /// Returns the distances of the ruptures that have one. Only the last ruptures of a run can be without, near its end.
    fn distances_m(self, run: &Run) -> Vec<f64> {
        run.metrics.ruptures.iter().map_while(self.of).collect()
    }
}

/// Returns the sentences.
pub(super) fn finding(runs: &[&Run]) -> String {
    let noticed = noticed(runs);
    let sentence = without_notices(runs);
    if noticed.is_empty() { sentence } else { format!("{sentence} {noticed}") }
}

/// Returns how many ruptures the operators noticed, for the runs whose operators notice changes of the force.
fn noticed(runs: &[&Run]) -> String {
    let of = |run: &&Run| {
        let noticed: Vec<u64> = run.metrics.ruptures.iter().filter_map(|rupture| rupture.noticed).collect();
        let count = noticed.iter().sum::<u64>();
        (!noticed.is_empty())
            .then(|| format!("{count} of {} in {}", counted(noticed.len() as u64, "rupture"), name(run)))
    };
    let each: Vec<String> = runs.iter().filter_map(of).collect();
    if each.is_empty() { String::new() } else { format!("The operator notices {}.", joined(&each)) }
}

/// Returns the sentences about needle and detector.
fn without_notices(runs: &[&Run]) -> String {
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
        let measure = Measure::for_runs(runs);
        parts.extend(match runs {
            [run] => distance_of_one(measure, run).into_iter().collect(),
            [first, second] => distance_of_pair(measure, first, second),
            _ => distance_of_many(measure, runs),
        });
        match detection(runs) {
            Found::All(sentence) if parts.is_empty() => return sentence,
            Found::All(sentence) => return format!("{}. {sentence}", parts_joined(&parts)),
            Found::Some(clause) => parts.push(clause),
        }
    }
    format!("{} and {}.", parts_joined(&parts), false_alarms(runs))
}

/// Joins clauses by semicolons. A clause that begins with a word of this module is in lower case after a semicolon; a name stays.
fn parts_joined(parts: &[String]) -> String {
    let lower = |(index, part): (usize, &String)| match part.strip_prefix("The ").or(part.strip_prefix("Augmentation "))
    {
        Some(rest) if index > 0 => format!("{}{rest}", part[..part.len() - rest.len()].to_lowercase()),
        _ => part.clone(),
    };
    parts.iter().enumerate().map(lower).collect::<Vec<_>>().join("; ")
}

fn name(run: &Run) -> &str {
    &run.scenario.name
}

fn distance_of_one(measure: Measure, run: &Run) -> Option<String> {
    let distances_m = measure.distances_m(run);
    let ruptures = Ruptures { total: distances_m.len(), are_all: distances_m.len() == run.metrics.ruptures.len() };
    (ruptures.total > 0).then(|| {
        let (what, after) = (measure.of_many(distances_m.len()), ruptures.some(ruptures.total));
        format!("The {what} after {after} is {}", listed(&distances_m))
    })
}

fn distance_of_pair(measure: Measure, first: &Run, second: &Run) -> Vec<String> {
    let counts = [first, second].map(|run| run.metrics.ruptures.len());
    let mut parts = vec![];
    if counts[0] != counts[1] {
        let count = |count: usize| if count == 0 { "no rupture".to_owned() } else { counted(count as u64, "rupture") };
        parts.push(format!("{} has {} and {} {}", name(first), count(counts[0]), name(second), count(counts[1])));
    }
    let (mut before_m, mut after_m) = (measure.distances_m(first), measure.distances_m(second));
    let total = before_m.len().min(after_m.len());
    before_m.truncate(total);
    after_m.truncate(total);
    if total == 0 {
        if counts[0] == counts[1] {
            parts.push(format!("The runs end too soon after the ruptures to compare the {}", measure.noun));
        }
        return parts;
    }
    let change = Change { measure, before_m, after_m, are_all: counts == [total; 2] };
    parts.push(if differ_in_augmentation(first, second) {
        format!("Augmentation {}", change.by_augmentation())
    } else {
        format!("The {} of {} is {}", measure.noun, name(second), change.against(name(first)))
    });
    parts
}

/// Returns whether the second run is the first one with augmentation.
pub(super) fn differ_in_augmentation(first: &Run, second: &Run) -> bool {
    !first.scenario.augmentation.enabled
        && second.scenario.augmentation.enabled
        && without_augmentation(first) == without_augmentation(second)
}

/// Returns the resolved scenario without its name and its augmentation.
fn without_augmentation(run: &Run) -> Option<toml::Table> {
    let mut table: toml::Table = run.scenario.echo().parse().ok()?;
    table.remove("name");
    table.remove("augmentation");
    Some(table)
}

fn distance_of_many(measure: Measure, runs: &[&Run]) -> Vec<String> {
    let noun = measure.noun;
    let max_m = |run: &Run| measure.distances_m(run).into_iter().reduce(f64::max);
    let with_max: Vec<(&Run, f64)> = runs.iter().filter_map(|run| Some((*run, max_m(run)?))).collect();
    let smallest = with_max.iter().min_by(|a, b| a.1.total_cmp(&b.1));
    let largest = with_max.iter().max_by(|a, b| a.1.total_cmp(&b.1));
    let mut parts = vec![];
    if let (Some((small, small_m)), Some((large, large_m))) = (smallest, largest) {
        let (low, high) = (millimetres(*small_m), millimetres(*large_m));
        parts.push(if low == high {
            format!("The maximum {noun} is about the same in every run with a rupture: {low}")
        } else {
            format!("The maximum {noun} is smallest in {} ({low}) and largest in {} ({high})", name(small), name(large))
        });
    }
    let without = runs.iter().filter(|run| run.metrics.ruptures.is_empty());
    parts.extend(without.map(|run| format!("{} has no rupture", name(run))));
    parts
}

/// The ruptures with a distance.
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
            (true, false, 2) => "ruptures 1 and 2".into(),
            (true, false, total) => format!("ruptures 1 to {total}"),
            (false, true, total) => format!("{count} of {total} ruptures"),
            (false, false, total) => format!("{count} of ruptures 1 to {total}"),
        }
    }
}

/// What happens to the distance after one rupture, from the first run to the second.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Effect {
    /// It is smaller, and almost none remains.
    Held,
    Smaller,
    Larger,
    Same,
}

impl Effect {
    const ALL: [Self; 4] = [Self::Held, Self::Smaller, Self::Larger, Self::Same];

    fn of(before_m: f64, after_m: f64) -> Self {
        let is_same = (before_m - after_m).abs() < SAME_SHARE * before_m.abs().max(after_m.abs());
        if is_same || millimetres(before_m) == millimetres(after_m) {
            Self::Same
        } else if after_m > before_m {
            Self::Larger
        } else if after_m <= HELD_M {
            Self::Held
        } else {
            Self::Smaller
        }
    }

    /// Returns the effect of augmentation; the second one in a sentence does not repeat the noun.
    fn of_augmentation(self, noun: Option<&str>, after: &str) -> String {
        let what = noun.map_or_else(|| "it".to_owned(), |noun| format!("the {noun}"));
        match self {
            Self::Held => format!("leaves no {} {after}", noun.unwrap_or("such distance")),
            Self::Smaller => format!("reduces {what} {after}"),
            Self::Larger => format!("increases {what} {after}"),
            Self::Same => format!("leaves {what} about the same {after}"),
        }
    }

    fn against(self, other: &str, after: &str) -> String {
        match self {
            Self::Held | Self::Smaller => format!("smaller than {other} {after}"),
            Self::Larger => format!("larger than {other} {after}"),
            Self::Same => format!("about the same as {other} {after}"),
        }
    }
}

/// The distances of two runs after the same ruptures.
struct Change {
    measure: Measure,
    before_m: Vec<f64>,
    after_m: Vec<f64>,
    /// Whether the runs have no other ruptures.
    are_all: bool,
}

impl Change {
    /// Returns the effects that occur, each with its ruptures, counted from 0. In a comparison, holding the needle is the same as a
    /// smaller distance.
    fn groups(&self, with_held: bool) -> Vec<(Effect, Vec<usize>)> {
        let of = |(before_m, after_m): (&f64, &f64)| match Effect::of(*before_m, *after_m) {
            Effect::Held if !with_held => Effect::Smaller,
            effect => effect,
        };
        let effects: Vec<Effect> = self.before_m.iter().zip(&self.after_m).map(of).collect();
        let with = |effect: Effect| (0..effects.len()).filter(|index| effects[*index] == effect).collect::<Vec<_>>();
        Effect::ALL
            .into_iter()
            .map(|effect| (effect, with(effect)))
            .filter(|(_, ruptures)| !ruptures.is_empty())
            .collect()
    }

    /// Returns ruptures as "after …", each with its distances if they are few.
    fn after(&self, ruptures: &[usize], numbers: impl Fn(f64, f64) -> String) -> String {
        let all = Ruptures { total: self.before_m.len(), are_all: self.are_all };
        if all.total > MAX_LISTED {
            return format!("after {}", all.some(ruptures.len()));
        }
        let each: Vec<String> = ruptures
            .iter()
            .map(|&index| format!("{} ({})", index + 1, numbers(self.before_m[index], self.after_m[index])))
            .collect();
        format!("after rupture{} {}", if each.len() == 1 { "" } else { "s" }, joined(&each))
    }

    fn by_augmentation(&self) -> String {
        let total = self.before_m.len();
        let (before, after) = (listed(&self.before_m), listed(&self.after_m));
        let what = self.measure.of_many(total);
        let is_singular = total == 1 || total > MAX_LISTED;
        let groups = self.groups(true);
        if let [(effect, ruptures)] = &groups[..] {
            let all = Ruptures { total, are_all: self.are_all }.some(ruptures.len());
            let sentence = effect.of_augmentation(Some(self.measure.noun), &format!("after {all}"));
            return match (effect, is_singular) {
                (Effect::Same, _) => format!("{sentence}: {before} without it, {after} with it"),
                (Effect::Larger, true) => format!("{sentence}: {what} {before} rises to {after}"),
                (Effect::Larger, false) => format!("{sentence}: {what} {before} rise to {after}"),
                (_, true) => format!("{sentence}: {what} {before} falls to {after}"),
                (_, false) => format!("{sentence}: {what} {before} fall to {after}"),
            };
        }
        let numbers =
            |before_m: f64, after_m: f64| format!("{} to {}", three_digits(1e3 * before_m), millimetres(after_m));
        let mut is_repeated = false;
        let mut parts = vec![];
        for (effect, ruptures) in &groups {
            let noun = (!is_repeated).then_some(self.measure.noun);
            parts.push(effect.of_augmentation(noun, &self.after(ruptures, numbers)));
            is_repeated = true;
        }
        let sentence = joined(&parts);
        if total > MAX_LISTED { format!("{sentence}: {what} {before} becomes {after}") } else { sentence }
    }

    fn against(&self, other: &str) -> String {
        let total = self.before_m.len();
        let groups = self.groups(false);
        if let [(effect, ruptures)] = &groups[..] {
            let all = Ruptures { total, are_all: self.are_all }.some(ruptures.len());
            let sentence = effect.against(&format!("that of {other}"), &format!("after {all}"));
            return format!("{sentence}: {} against {}", listed(&self.after_m), listed(&self.before_m));
        }
        let numbers =
            |before_m: f64, after_m: f64| format!("{} against {}", three_digits(1e3 * after_m), millimetres(before_m));
        let that = format!("that of {other}");
        let part = |(index, (effect, ruptures)): (usize, &(Effect, Vec<usize>))| {
            effect.against(if index == 0 { &that } else { "it" }, &self.after(ruptures, numbers))
        };
        let sentence = joined(&groups.iter().enumerate().map(part).collect::<Vec<_>>());
        if total > MAX_LISTED {
            return format!("{sentence}: {} against {}", listed(&self.after_m), listed(&self.before_m));
        }
        sentence
    }
}

impl Measure {
    /// Returns the name of what is told of a number of ruptures.
    fn of_many(self, ruptures: usize) -> String {
        if ruptures > MAX_LISTED { format!("maximum {}", self.noun) } else { self.noun.to_owned() }
    }
}

/// Returns the distances, or the maximum of many.
fn listed(distances_m: &[f64]) -> String {
    match distances_m.iter().copied().reduce(f64::max) {
        Some(max_m) if distances_m.len() > MAX_LISTED => millimetres(max_m),
        _ => joined(&distances_m.iter().map(|distance_m| millimetres(*distance_m)).collect::<Vec<_>>()),
    }
}

/// What is said about the detection of the ruptures.
enum Found {
    /// Every run detects all its ruptures: a sentence, which also covers the false alarms.
    All(String),
    /// A clause about the missed and the undecided ruptures.
    Some(String),
}

/// Returns what is said about the ruptures that are detected and missed in all runs.
fn detection(runs: &[&Run]) -> Found {
    let ruptures = || runs.iter().flat_map(|run| &run.metrics.ruptures);
    let delays_s: Vec<f64> = ruptures().filter_map(|rupture: &RuptureMetrics| rupture.detection_delay_s).collect();
    if delays_s.len() == ruptures().count() {
        let max_ms = three_digits(1e3 * delays_s.into_iter().fold(0.0, f64::max));
        let counts: Vec<usize> = runs.iter().map(|run| run.metrics.ruptures.len()).collect();
        let who = match runs.len() {
            1 => "The run detects",
            2 => "Both runs detect",
            _ => "All runs detect",
        };
        let what = match (counts.iter().all(|count| *count == counts[0]), counts[0]) {
            (true, 1) => "the rupture".to_owned(),
            (true, 2) => "both ruptures".to_owned(),
            (true, count) => format!("all {count} ruptures"),
            (false, _) => "every rupture".to_owned(),
        };
        let alarms = match runs.iter().all(|run| run.metrics.false_alarms == 0) {
            true => "with no missed rupture and no false alarm".to_owned(),
            false => format!("with no missed rupture; {}", false_alarms(runs)),
        };
        return Found::All(format!("{who} {what} within {max_ms} ms, {alarms}."));
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
    Found::Some(parts.join(", "))
}

pub(super) fn false_alarms(runs: &[&Run]) -> String {
    let raises = runs.iter().filter(|run| run.metrics.false_alarms > 0).map(|run| {
        let count = counted(run.metrics.false_alarms, "false alarm");
        format!("{} raises {count}", name(run))
    });
    let raises: Vec<String> = raises.collect();
    if raises.is_empty() { "no alarm is false".into() } else { raises.join(", ") }
}

/// Joins texts with commas and "and".
pub(super) fn joined(texts: &[String]) -> String {
    match texts {
        [] => String::new(),
        [one] => one.clone(),
        [others @ .., last] => format!("{} and {last}", others.join(", ")),
    }
}

fn millimetres(metres: f64) -> String {
    format!("{} mm", three_digits(1e3 * metres))
}

/// Returns a number with three significant digits, at most four decimals and no zeros at its end.
fn three_digits(value: f64) -> String {
    if value < 0.0 {
        return format!("-{}", three_digits(-value));
    }
    if value > 0.0 && value < 1e-4 {
        return "below 0.0001".into();
    }
    let text = format!("{value:.*}", decimals(value, 3));
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trocar_scenario::{Scenario, Source};
    use trocar_studies::run::run;

    fn finding(runs: &[Run]) -> String {
        super::finding(&runs.iter().collect::<Vec<_>>())
    }

    /// Runs a shipped scenario. The sentence is computed from metrics, which a test can then set.
    fn shipped(name: &str) -> Run {
        run(Scenario::load(&Source::Builtin(name.into()), &[]).expect("a scenario")).expect("a run")
    }

    fn with_excess(run: &Run, name: &str, excesses_mm: &[f64]) -> Run {
        let mut run = run.clone();
        let rupture = run.metrics.ruptures[0].clone();
        run.scenario.name = name.into();
        let of = |mm: &f64| RuptureMetrics { excess_advance_m: Some(1e-3 * mm), ..rupture.clone() };
        run.metrics.ruptures = excesses_mm.iter().map(of).collect();
        run
    }

    #[test]
    fn the_sentence_is_computed_from_the_numbers() {
        let (classical, augmented) = (shipped("classical.toml"), shipped("augmented.toml"));
        let pair = |a: &Run, b: &Run| finding(&[a.clone(), b.clone()]);
        assert_eq!(
            pair(&classical, &augmented),
            "Augmentation leaves the advance in 2 s about the same after both ruptures: 11 mm and 11.9 mm without it, 11 mm and \
             11.9 mm with it. Both runs detect both ruptures within 8 ms, with no missed rupture and no false alarm."
        );
        let of = |a: &[f64], b: &[f64]| {
            pair(&with_excess(&classical, "classical", a), &with_excess(&augmented, "augmented", b))
        };
        let said = |sentence: String| sentence.split(". ").next().unwrap_or_default().to_owned();
        assert_eq!(
            said(of(&[9.0, 7.0], &[0.05, 8.0])),
            "Augmentation leaves no excess advance after rupture 1 (9 to 0.05 mm) and increases it after rupture 2 (7 to 8 mm)"
        );
        assert_eq!(
            said(of(&[5.42, 6.12], &[0.135, 8.17])),
            "Augmentation reduces the excess advance after rupture 1 (5.42 to 0.135 mm) and increases it after rupture 2 (6.12 to \
             8.17 mm)"
        );
        assert_eq!(
            said(of(&[9.0, 7.0, 6.0], &[4.0, 7.1, 3.0])),
            "Augmentation reduces the excess advance after ruptures 1 (9 to 4 mm) and 3 (6 to 3 mm) and leaves it about the same \
             after rupture 2 (7 to 7.1 mm)"
        );
        assert_eq!(
            said(of(&[9.0, 7.0, 6.0, 5.0], &[4.0, 8.0, 3.0, 2.0])),
            "Augmentation reduces the excess advance after 3 of 4 ruptures and increases it after 1 of 4 ruptures: maximum \
             excess advance 9 mm becomes 8 mm"
        );
        assert_eq!(
            said(of(&[9.0], &[0.5])),
            "Augmentation reduces the excess advance after the rupture: excess advance 9 mm falls to 0.5 mm"
        );
        assert_eq!(
            said(of(&[9.0], &[9.5])),
            "Augmentation increases the excess advance after the rupture: excess advance 9 mm rises to 9.5 mm"
        );
        assert_eq!(
            said(of(&[9.0], &[9.4])),
            "Augmentation leaves the excess advance about the same after the rupture: 9 mm without it, 9.4 mm with it"
        );
        assert_eq!(
            said(of(&[4.0, 3.0, 2.0, 1.0], &[0.0, 0.0, 0.0, 0.0])),
            "Augmentation leaves no excess advance after all 4 ruptures: maximum excess advance 4 mm falls to 0 mm"
        );
        assert!(of(&[9.0, 7.0], &[0.0]).starts_with(
            "classical has 2 ruptures and augmented 1 rupture; augmentation leaves no excess advance after rupture 1: excess advance 9 mm"
        ));
        assert!(
            of(&[9.0, 7.0, 1.0], &[0.0, 0.0])
                .contains("; augmentation leaves no excess advance after ruptures 1 and 2: excess advance")
        );
        // The order matters: only the second scenario can be the augmented one.
        assert_eq!(
            said(pair(&augmented, &classical)),
            "The advance in 2 s of classical is about the same as that of augmented after both ruptures: 11 mm and 11.9 mm against \
             11 mm and 11.9 mm"
        );
        let (a, b) = (with_excess(&classical, "a", &[1.0, 2.0]), with_excess(&classical, "b", &[2.0, 1.0]));
        assert_eq!(
            said(pair(&a, &b)),
            "The excess advance of b is smaller than that of a after rupture 2 (1 against 2 mm) and larger than it after rupture 1 \
             (2 against 1 mm)"
        );
        let near = with_excess(&classical, "near", &[1.02, 1.99]);
        assert_eq!(
            said(pair(&a, &near)),
            "The excess advance of near is about the same as that of a after both ruptures: 1.02 mm and 1.99 mm against 1 mm and 2 \
             mm"
        );
        let c = with_excess(&classical, "c", &[]);
        assert!(
            pair(&a, &with_excess(&classical, "d", &[1.0])).contains("; the excess advance of d is about the same")
        );
        assert_eq!(
            finding(&[a.clone(), b, c.clone()]),
            "The maximum excess advance is about the same in every run with a rupture: 2 mm; c has no rupture. All runs detect \
             every rupture within 3 ms, with no missed rupture and no false alarm."
        );
        assert_eq!(finding(&[c.clone(), c]), "No layer ruptures and no alarm is false.");
        assert_eq!(said(finding(&[a])), "The excess advance after both ruptures is 1 mm and 2 mm");
    }

    #[test]
    fn misses_false_alarms_and_divergence_are_named() {
        let classical = shipped("classical.toml");
        let mut bad = classical.clone();
        bad.scenario.name = "bad".into();
        (bad.metrics.missed_ruptures, bad.metrics.false_alarms) = (1, 2);
        bad.metrics.ruptures[1].detection_delay_s = None;
        let sentence = finding(&[classical.clone(), bad.clone()]);
        assert!(sentence.ends_with("; bad misses 1 of 2 ruptures and bad raises 2 false alarms."), "{sentence}");
        let mut alarmed = classical.clone();
        (alarmed.scenario.name, alarmed.metrics.false_alarms) = ("alarmed".into(), 1);
        let sentence = finding(&[classical.clone(), alarmed]);
        assert!(
            sentence.ends_with(" within 5 ms, with no missed rupture; alarmed raises 1 false alarm."),
            "{sentence}"
        );
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
