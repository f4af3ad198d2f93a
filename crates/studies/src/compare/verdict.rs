use super::{SeedStudy, SeedTotals, Spread, SpreadRow};
use crate::run::{Run, outcome};
use crate::stability_check::LoopVerdict;
use trocar_document::{Verdict, counted, decimals};
use trocar_metrics::{HORIZON_S, Outcome, RuptureMetrics, TRAVEL_S};

/// Limit for "frozen" (5.1), as in the comparison with the paper.
const HELD_M: f64 = 1e-4;

/// Shares that differ by less are about the same.
const SAME_SHARE: f64 = 0.05;

const MAX_LISTED: usize = 3;

const SEED_RUPTURES: usize = 2;

const OF_SCHEMES: [&str; 2] = [" without augmentation", " with it"];

const MAX_RUNS: usize = 3;

pub fn verdict(runs: &[&Run]) -> Verdict {
    verdict_of(runs, &whose(runs))
}

fn whose(runs: &[&Run]) -> Vec<String> {
    match runs {
        [classical, augmented] if differ_in_augmentation(classical, augmented) => OF_SCHEMES.map(str::to_owned).into(),
        [_] => vec![String::new()],
        many => many.iter().map(|run| format!(" in {}", run.scenario.name)).collect(),
    }
}

pub fn verdict_of_schemes(classical: &Run, augmented: &Run) -> Verdict {
    verdict_of(&[classical, augmented], &OF_SCHEMES.map(str::to_owned))
}

/// `runs` are those of the first seeds.
pub fn verdict_over_seeds(study: &SeedStudy, runs: &[&Run]) -> Verdict {
    let whose = whose(runs);
    let of_ruptures = |metric: &str| {
        let of = |number: usize| Some((number, study.row(&format!("rupture_{number}_{metric}"))?));
        (1..=SEED_RUPTURES).filter_map(of).collect::<Vec<_>>()
    };
    let sentence = |metric: &str, start: &str| {
        let each = |(number, row): &(usize, &SpreadRow)| {
            let of = |(spread, whose): (&Option<Spread>, &String)| {
                spread.map(|spread| format!("{}{whose}", millimetres_of(&spread)))
            };
            let all: Vec<String> = row.spreads.iter().zip(&whose).filter_map(of).collect();
            (!all.is_empty()).then(|| format!("after rupture {number} by {}", joined(&all)))
        };
        let each: Vec<String> = of_ruptures(metric).iter().filter_map(each).collect();
        (!each.is_empty()).then(|| format!("{start} {}.", each.join("; ")))
    };
    let jump =
        format!("In {} seeds (medians, with the central 95 %), the slave has advanced {TRAVEL_S} s", study.seeds);
    let sentences = [
        sentence("slave_travel_m", &jump),
        sentence("horizon_advance_m", &format!("It has advanced {HORIZON_S} s")),
        absent_over_seeds(study, &whose),
        Some(detection_over_seeds(study, &whose)),
    ];
    let left_out = (study.max_ruptures() > SEED_RUPTURES)
        .then(|| format!("Left out: the advance after rupture {} and later ones; see the table.", SEED_RUPTURES + 1));
    let sentences = unstable_loops(runs).into_iter().chain(sentences.into_iter().flatten());
    Verdict { sentences: sentences.collect(), left_out: left_out.into_iter().collect() }
}

fn absent_over_seeds(study: &SeedStudy, whose: &[String]) -> Option<String> {
    let absent = (0..study.max_ruptures()).flat_map(|index| {
        study.totals.iter().zip(whose).filter_map(move |(totals, whose)| {
            let seeds = totals.seeds_with_rupture.get(index).copied().unwrap_or(0);
            (seeds < study.seeds).then(|| format!("rupture {} in {seeds} of {} seeds{whose}", index + 1, study.seeds))
        })
    });
    let absent: Vec<String> = absent.take(MAX_LISTED).collect();
    (!absent.is_empty()).then(|| format!("Not every rupture happens: {}.", joined(&absent)))
}

fn detection_over_seeds(study: &SeedStudy, whose: &[String]) -> String {
    let each = |of: &dyn Fn(&SeedTotals) -> String| {
        let each = study.totals.iter().zip(whose).map(|(totals, whose)| format!("{}{whose}", of(totals)));
        joined(&each.collect::<Vec<_>>())
    };
    let missed = each(&|totals| {
        let of = counted(totals.ruptures, "rupture");
        match totals.undecided_ruptures {
            0 => format!("{} of {of}", totals.missed_ruptures),
            undecided => format!("{} of {of} ({undecided} undecided at the end of the run)", totals.missed_ruptures),
        }
    });
    format!("Missed in all seeds: {missed}. False alarms: {}.", each(&|totals| totals.false_alarms.to_string()))
}

fn millimetres_of(spread: &Spread) -> String {
    let [median, low, high] = [spread.median, spread.low, spread.high].map(|metres| three_digits(1e3 * metres));
    if low == high { format!("{median} mm") } else { format!("{median} mm ({low} to {high})") }
}

fn differ_in_augmentation(first: &Run, second: &Run) -> bool {
    let other_keys = |run: &Run| -> Option<toml::Table> {
        let mut table: toml::Table = run.scenario.echo().parse().ok()?;
        table.remove("name");
        table.remove("augmentation");
        Some(table)
    };
    !first.scenario.augmentation.enabled
        && second.scenario.augmentation.enabled
        && other_keys(first) == other_keys(second)
}

fn verdict_of(runs: &[&Run], whose: &[String]) -> Verdict {
    let unstable = unstable_loops(runs);
    let mut sentences: Vec<String> = diverged(runs).into_iter().collect();
    if sentences.is_empty() {
        if runs.iter().all(|run| run.metrics.ruptures.is_empty()) {
            sentences.push(format!("No layer ruptures, and {}.", false_alarms(runs)));
        } else {
            // The motion after a rupture says nothing about an unstable loop.
            if unstable.is_empty() {
                sentences.extend(other_counts(runs));
                sentences.extend(jump(runs, whose));
                sentences.extend(unintended(runs, whose));
                sentences.extend(later(runs, whose));
                sentences.extend(noticed(runs, whose));
            }
            sentences.push(detection(runs, whose));
        }
        sentences.extend(swings(runs));
    }
    sentences.splice(0..0, unstable);
    Verdict { sentences, left_out: vec![] }
}

fn unstable_loops(runs: &[&Run]) -> Vec<String> {
    let of = |run: &&Run| {
        let is_of_scenario = run.user_defined_parts.is_empty();
        let verdict = is_of_scenario.then(|| LoopVerdict::of(&run.scenario).ok()).flatten()?;
        Some((run.scenario.name.clone(), verdict.instability().ok()??))
    };
    let all: Vec<(String, String)> = runs.iter().filter_map(of).collect();
    match &all[..] {
        [(_, first), others @ ..] if all.len() == runs.len() && others.iter().all(|(_, other)| other == first) => {
            vec![format!("The loop is {first}.")]
        }
        all => all.iter().map(|(name, sentence)| format!("The loop of {name} is {sentence}.")).collect(),
    }
}

fn diverged(runs: &[&Run]) -> Option<String> {
    let is_diverged = |run: &&&Run| matches!(run.metrics.outcome, Outcome::Diverged { .. });
    let diverged: Vec<String> = runs.iter().filter(is_diverged).map(|run| outcome(run)).collect();
    let whose = if diverged.len() == 1 { "Its" } else { "Their" };
    (!diverged.is_empty()).then(|| format!("{}. {whose} metrics cover the time before.", diverged.join("; ")))
}

fn swings(runs: &[&Run]) -> Option<String> {
    let unstable = runs.iter().filter(|run| matches!(run.metrics.outcome, Outcome::Oscillating { .. }));
    let unstable: Vec<String> = unstable.map(|run| outcome(run)).collect();
    (!unstable.is_empty()).then(|| format!("Unstable: {}.", unstable.join("; ")))
}

/// Later sentences are about the ruptures that all runs have.
fn other_counts(runs: &[&Run]) -> Option<String> {
    let counts: Vec<usize> = runs.iter().map(|run| run.metrics.ruptures.len()).collect();
    if counts.iter().all(|count| *count == counts[0]) {
        return None;
    }
    let of = |(run, count): (&&Run, &usize)| {
        let ruptures = if *count == 0 { "no rupture".to_owned() } else { counted(*count as u64, "rupture") };
        format!("{} has {ruptures}", run.scenario.name)
    };
    Some(format!("{}.", joined(&runs.iter().zip(&counts).map(of).collect::<Vec<_>>())))
}

type OfRun<'a> = (&'a str, Vec<f64>);

struct Distances<'a> {
    runs: Vec<OfRun<'a>>,
    are_all: bool,
}

impl<'a> Distances<'a> {
    /// Only the last ruptures can lack a distance, near the end of the run.
    fn of(runs: &[&Run], whose: &'a [String], read: fn(&RuptureMetrics) -> Option<f64>) -> Option<Self> {
        let of_run = |(run, whose): (&&Run, &'a String)| {
            let ruptures = &run.metrics.ruptures;
            let distances_m: Vec<f64> = ruptures.iter().map_while(read).collect();
            (!ruptures.is_empty()).then_some((whose.as_str(), distances_m))
        };
        let mut of_runs: Vec<OfRun<'_>> = runs.iter().zip(whose).filter_map(of_run).collect();
        let count = of_runs.iter().map(|(_, distances_m)| distances_m.len()).min().filter(|count| *count > 0)?;
        of_runs.iter_mut().for_each(|(_, distances_m)| distances_m.truncate(count));
        let are_all = runs.iter().all(|run| [0, count].contains(&run.metrics.ruptures.len()));
        Some(Self { runs: of_runs, are_all })
    }

    fn ruptures(&self) -> String {
        match (self.runs[0].1.len(), self.are_all) {
            (1, true) => "the rupture".into(),
            (2, true) => "both ruptures".into(),
            (count, true) => format!("all {count} ruptures"),
            (1, false) => "rupture 1".into(),
            (2, false) => "ruptures 1 and 2".into(),
            (count, false) => format!("ruptures 1 to {count}"),
        }
    }

    fn common(&self) -> Option<&[f64]> {
        let first = &self.runs[0].1;
        let is_alike = |(_, other): &OfRun<'_>| first.iter().zip(other).all(|(a, b)| are_same(*a, *b));
        (self.runs.len() > 1 && self.runs.iter().all(is_alike)).then_some(first)
    }

    fn each(&self, phrase: impl Fn(&[f64]) -> String) -> String {
        if let Some(common) = self.common() {
            let all = if self.runs.len() == 2 { "in both runs" } else { "in every run with a rupture" };
            return format!("{} {all}", phrase(common));
        }
        let of_run = |(whose, distances_m): &OfRun<'_>| format!("{}{whose}", phrase(distances_m));
        if self.runs.len() <= MAX_RUNS {
            return joined(&self.runs.iter().map(of_run).collect::<Vec<_>>());
        }
        let max_m = |(_, distances_m): &OfRun<'_>| distances_m.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let mut sorted: Vec<&OfRun<'_>> = self.runs.iter().collect();
        sorted.sort_by(|a, b| max_m(a).total_cmp(&max_m(b)));
        format!("{} (the least) and {} (the most)", of_run(sorted[0]), of_run(sorted[sorted.len() - 1]))
    }
}

fn jump(runs: &[&Run], whose: &[String]) -> Option<String> {
    let distances = Distances::of(runs, whose, |rupture| rupture.slave_travel_m)?;
    let phrase = |distances_m: &[f64]| match distances_m.iter().map(|metres| metres.abs()).fold(0.0, f64::max) {
        most_m if most_m <= HELD_M => format!("stays within {}", millimetres(most_m)),
        _ => format!("advances by {}", listed(distances_m)),
    };
    Some(format!("In the {TRAVEL_S} s after {} the slave {}.", distances.ruptures(), distances.each(phrase)))
}

fn unintended(runs: &[&Run], whose: &[String]) -> Option<String> {
    let is_known = |run: &&Run| run.metrics.ruptures.iter().any(|rupture| rupture.excess_advance_m.is_some());
    if !runs.iter().filter(|run| !run.metrics.ruptures.is_empty()).all(is_known) {
        return None;
    }
    let distances = Distances::of(runs, whose, |rupture| rupture.excess_advance_m)?;
    let each = distances.each(|distances_m| format!("by {}", listed(distances_m)));
    Some(format!("Up to {HORIZON_S} s after {} it goes beyond the intended motion {each}.", distances.ruptures()))
}

fn later(runs: &[&Run], whose: &[String]) -> Option<String> {
    let held: Vec<(&Run, &String)> = runs.iter().copied().zip(whose).filter(|(run, _)| returns(run)).collect();
    let (held_runs, held_whose): (Vec<&Run>, Vec<String>) =
        held.into_iter().map(|(run, whose)| (run, whose.clone())).unzip();
    let returned = Distances::of(&held_runs, &held_whose, |rupture| rupture.return_jump_m).map(|distances| {
        let each = distances.each(|distances_m| format!("by {}", listed(distances_m)));
        format!("On its return it advances {each}")
    });
    let depth = Distances::of(runs, whose, |rupture| rupture.horizon_advance_m).map(|distances| {
        let when = format!("{HORIZON_S} s after {}", distances.ruptures());
        match distances.common() {
            Some(all_m) if runs.len() == 2 => {
                format!("{when} both are equally deep ({})", listed(all_m))
            }
            _ => {
                let each = distances.each(|distances_m| format!("{} deeper than at the rupture", listed(distances_m)));
                format!("{when} it is {each}")
            }
        }
    });
    let clauses: Vec<String> = returned.into_iter().chain(depth).collect();
    (!clauses.is_empty()).then(|| format!("{}.", clauses.join("; ")))
}

fn returns(run: &Run) -> bool {
    run.metrics.ruptures.first().is_some_and(|rupture| rupture.return_jump_m.is_some())
}

fn noticed(runs: &[&Run], whose: &[String]) -> Option<String> {
    let of = |(run, whose): (&&Run, &String)| {
        let noticed: Vec<u64> = run.metrics.ruptures.iter().filter_map(|rupture| rupture.noticed).collect();
        let count = noticed.iter().sum::<u64>();
        (!noticed.is_empty()).then(|| format!("{count} of {}{whose}", counted(noticed.len() as u64, "rupture")))
    };
    let each: Vec<String> = runs.iter().zip(whose).filter_map(of).collect();
    (!each.is_empty()).then(|| format!("The operator notices {}.", joined(&each)))
}

fn detection(runs: &[&Run], whose: &[String]) -> String {
    let ruptures = || runs.iter().flat_map(|run| &run.metrics.ruptures);
    let delays_s: Vec<f64> = ruptures().filter_map(|rupture| rupture.detection_delay_s).collect();
    if delays_s.len() == ruptures().count() {
        let max_ms = three_digits(1e3 * delays_s.into_iter().fold(0.0, f64::max));
        let who = match runs.len() {
            1 => "The run detects",
            2 => "Both runs detect",
            _ => "All runs detect",
        };
        let alarms = match runs.iter().all(|run| run.metrics.false_alarms == 0) {
            true => "with no missed rupture and no false alarm".to_owned(),
            false => format!("with no missed rupture; {}", false_alarms(runs)),
        };
        return format!("{who} every rupture within {max_ms} ms, {alarms}.");
    }
    let clause = |run: &Run, whose: &str| {
        let metrics = &run.metrics;
        let total = counted(metrics.ruptures.len() as u64, "rupture");
        let reason = metrics.ruptures.iter().find_map(|rupture| rupture.miss.as_ref());
        let because = reason.map_or(String::new(), |miss| format!(" ({})", miss.reason));
        let is_missed = if metrics.missed_ruptures == 1 { "is" } else { "are" };
        let missed = format!("{} of {total} {is_missed} missed{whose}{because}", metrics.missed_ruptures);
        let undecided = counted(metrics.undecided_ruptures, "rupture");
        let undecided = format!("{} ends too soon to decide on {undecided}", run.scenario.name);
        let missed = (metrics.missed_ruptures > 0).then_some(missed);
        missed.into_iter().chain((metrics.undecided_ruptures > 0).then_some(undecided)).collect::<Vec<_>>()
    };
    let is_same = runs.len() == 2 && clause(runs[0], "") == clause(runs[1], "");
    let clauses = match is_same && runs.iter().all(|run| run.metrics.undecided_ruptures == 0) {
        true => clause(runs[0], " in both runs"),
        false => runs.iter().zip(whose).flat_map(|(run, whose)| clause(run, whose)).collect(),
    };
    format!("{}; {}.", clauses.join("; "), false_alarms(runs))
}

fn false_alarms(runs: &[&Run]) -> String {
    let raises = runs
        .iter()
        .filter(|run| run.metrics.false_alarms > 0)
        .map(|run| format!("{} raises {}", run.scenario.name, counted(run.metrics.false_alarms, "false alarm")));
    let raises: Vec<String> = raises.collect();
    if raises.is_empty() { "no alarm is false".into() } else { joined(&raises) }
}

fn are_same(a_m: f64, b_m: f64) -> bool {
    (a_m - b_m).abs() < SAME_SHARE * a_m.abs().max(b_m.abs()) || millimetres(a_m) == millimetres(b_m)
}

fn listed(distances_m: &[f64]) -> String {
    match distances_m {
        [others @ .., last] if distances_m.len() <= MAX_LISTED => {
            let numbers: Vec<String> = others.iter().map(|metres| three_digits(1e3 * metres)).collect();
            joined(&[numbers, vec![millimetres(*last)]].concat())
        }
        many => format!("at most {}", millimetres(many.iter().copied().fold(f64::NEG_INFINITY, f64::max))),
    }
}

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
    use crate::run::run;
    use trocar_scenario::{Scenario, Source};

    fn shipped(name: &str, settings: &[&str]) -> Run {
        let settings: Vec<String> = settings.iter().map(|setting| (*setting).to_owned()).collect();
        run(Scenario::load(&Source::parse(name), &settings).expect("a scenario")).expect("a run")
    }

    /// A run with copies of its first rupture that have the given travel at 0.3 s and excess advance, in mm.
    fn with(run: &Run, name: &str, numbers_mm: &[[f64; 2]]) -> Run {
        let mut run = run.clone();
        let rupture = run.metrics.ruptures[0].clone();
        run.scenario.name = name.into();
        let of = |[travel, excess]: &[f64; 2]| RuptureMetrics {
            slave_travel_m: Some(1e-3 * travel),
            excess_advance_m: Some(1e-3 * excess),
            ..rupture.clone()
        };
        run.metrics.ruptures = numbers_mm.iter().map(of).collect();
        run
    }

    #[test]
    fn numbers_of_other_runs_have_the_names_of_the_runs() {
        let run = shipped("paper/classical", &[]);
        let (one, two) = (with(&run, "one", &[[5.0, 3.0]]), with(&run, "two", &[[2.0, 0.0]]));
        let text = verdict(&[&one, &two]).text();
        assert!(
            text.starts_with(
                "In the 0.3 s after the rupture the slave advances by 5 mm in one and advances by 2 mm in two."
            ),
            "{text}"
        );
        assert!(text.contains("it goes beyond the intended motion by 3 mm in one and by 0 mm in two."), "{text}");
        let more = with(&run, "more", &[[5.0, 3.0], [5.0, 3.0]]);
        let text = verdict(&[&one, &more]).text();
        assert!(
            text.starts_with(
                "one has 1 rupture and more has 2 ruptures. In the 0.3 s after rupture 1 the slave \
            advances by 5 mm in both runs."
            ),
            "{text}"
        );
        let many: Vec<Run> = (0..4).map(|k| with(&run, &format!("r{k}"), &[[1.0 + f64::from(k), 0.0]])).collect();
        let text = verdict(&many.iter().collect::<Vec<_>>()).text();
        assert!(text.contains("advances by 1 mm in r0 (the least) and advances by 4 mm in r3 (the most)"), "{text}");
        let four = with(&run, "four", &[[1.0, 0.0], [2.0, 0.0], [7.0, 0.0], [3.0, 0.0]]);
        let text = verdict(&[&four]).text();
        assert!(text.starts_with("In the 0.3 s after all 4 ruptures the slave advances by at most 7 mm."), "{text}");
    }

    #[test]
    fn the_verdict_does_not_praise_a_detector_that_misses_ruptures() {
        let missed = verdict(&[&shipped("paper/augmented", &["detector.threshold=100"])]).text();
        assert!(missed.contains("2 of 2 ruptures are missed (below the threshold: g reached "), "{missed}");
        assert!(missed.ends_with("; no alarm is false."), "{missed}");
        let wall = verdict(&[&shipped("passivity/late-wall", &[])]).text();
        assert!(
            wall.starts_with("The loop is not stable at force scale 1.000: at most 0.9075. No layer ruptures")
                && wall.contains("Unstable: late-wall: oscillating, by "),
            "{wall}"
        );
        let mut run = shipped("paper/classical", &[]);
        run.metrics.false_alarms = 3;
        assert!(verdict(&[&run]).text().ends_with("with no missed rupture; classical raises 3 false alarms."));
        run.metrics.outcome = Outcome::Diverged { time_s: 1.5 };
        assert_eq!(
            verdict(&[&run]).text(),
            "classical: ended at 1.5 s, as the recorded force pushes the hand out of its workspace. Its metrics cover the time \
             before."
        );
    }

    #[test]
    fn distances_have_three_digits() {
        let shown = [0.0, 8.954e-3, 1.1e-2, 1e-8, -2.5e-4].map(millimetres);
        assert_eq!(shown, ["0 mm", "8.95 mm", "11 mm", "below 0.0001 mm", "-0.25 mm"]);
    }
}
