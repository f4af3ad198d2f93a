mod catalogue;
mod document;
mod people;
mod windows;

pub use catalogue::{STRATEGIES, Strategy};
pub use document::StrategiesFile;
pub(crate) use people::PERCEIVING;
pub use people::{FIXED_PERSONS, Group, PERSONS, Person};
pub use windows::WINDOWS_S;

use std::sync::{Mutex, PoisonError};

use schemars::JsonSchema;
use serde::Serialize;

use self::windows::{OfWindows, Windows};
use super::sensitivity::{Noticed, Sensitivity};
use crate::run::{RunError, run, run_pack_sharing};
use crate::stability_check::linear_loop;
use crate::sweep::{CaseMaker, Plan, SweepError, is_sweep};
use trocar_base::parallel::try_map;
use trocar_base::quantiles::{quantile_of, rank_correlation};
use trocar_core::time::nearest_ticks;
use trocar_engine::engine::InstructionSet;
use trocar_engine::sensor::NoiseBank;
use trocar_metrics::{HORIZON_S, Metrics, Outcome};
use trocar_run::run_pack_observed;
use trocar_scenario::{CaseFactory, Scenario, ScenarioError, Source, Template};
use trocar_stability::ClosedLoop;

/// 8 MB per thread.
const KEPT_NUMBERS: usize = 1 << 20;

#[derive(Debug, Clone)]
pub struct StrategyOptions {
    pub persons: Vec<&'static Person>,
    /// Maximum number of points of the sweep file, or of members of a group.
    pub patients: u64,
    pub seeds: u64,
}

/// The stability of a strategy's runs. It is a result of these runs, not a proof.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// No run diverges, and no run of the first patient oscillates at the end.
    Settles,
    /// A run of the first patient oscillates at the end without decaying.
    Oscillates,
    /// A run diverges.
    Diverges,
}

impl Verdict {
    pub fn word(self) -> &'static str {
        match self {
            Self::Settles => "settles",
            Self::Oscillates => "oscillates",
            Self::Diverges => "diverges",
        }
    }
}

/// The costs of a false alarm, as means over the events of false alarms.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct FalseAlarmCost {
    /// Duration of the event in s.
    pub event_s: f64,
    /// Largest change of the feedback force in N.
    pub force_n: f64,
    /// Advance of the needle beyond the intended motion at the return to teleoperation, in m.
    pub excess_m: f64,
}

/// Minimum share of the ruptures reached, relative to no strategy: the excess does not describe a needle that stops
/// before the layer.
pub(super) const REACHED_SHARE: f64 = 0.95;

/// The results of a strategy over all patients, persons and seeds.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct StrategyRow {
    /// Name.
    pub strategy: &'static str,
    /// Number of runs.
    pub runs: u64,
    /// Number of diverged runs.
    pub diverged: u64,
    /// Number of ruptures.
    pub ruptures: u64,
    /// Number of ruptures divided by the number without a strategy; `None` if no layer ruptures without a strategy.
    pub reached_share: Option<f64>,
    /// Number of ruptures without an alarm.
    pub missed_ruptures: u64,
    /// Number of alarms without a rupture.
    pub false_alarms: u64,
    /// Mean excess advance after a rupture in m; `None` if the intended motion is unknown.
    pub mean_excess_m: Option<f64>,
    /// 95 % quantile of the excess advance in m.
    pub high_excess_m: Option<f64>,
    /// Median depth below a ruptured layer at the return to teleoperation in m; `None` without events.
    pub depth_at_return_m: Option<f64>,
    /// Mean unintended cut of a run in m.
    pub unintended_cut_m: Option<f64>,
    /// Mean excess at the end of the insertion in m; negative if the intended depth is not reached.
    pub final_excess_m: Option<f64>,
    /// The noticed ruptures.
    pub noticed: Noticed,
    /// Median time from a rupture until it is noticed, in s.
    pub noticed_after_s: Option<f64>,
    /// d' of ruptures against 2 s without a rupture or event.
    pub against_nothing: Option<Sensitivity>,
    /// d' of ruptures against false alarms.
    pub against_false_alarms: Option<Sensitivity>,
    /// Cost of a false alarm; `None` without events.
    pub false_alarm: Option<FalseAlarmCost>,
    /// The stability of the runs.
    pub verdict: Verdict,
    /// True if the strategy is compared and on the Pareto front: no other compared strategy has at most its mean excess
    /// and at least its noticed share, with one of them better.
    pub is_on_front: bool,
    /// Mean excess advance in m for each window.
    pub window_excess_m: Vec<Option<f64>>,
}

/// The linear loops of all patients and persons, each at the worst stiffness of its tissue. Strategies act only during
/// events, and do not change this loop.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, JsonSchema)]
pub struct LinearLoops {
    /// Number of loops that could be analysed.
    pub count: u64,
    /// Number of loops that are stable both in contact and in free motion.
    pub stable: u64,
    /// The smallest gain margin of the stable loops; `None` if no stable loop has a limit.
    pub min_gain_margin: Option<f64>,
    /// Number of stable loops that no gain factor makes unstable.
    pub unlimited: u64,
}

impl LinearLoops {
    fn add(&mut self, scenario: &Scenario) {
        let verdict = linear_loop(scenario).and_then(|settings| {
            let margins = ClosedLoop::new(&settings)?.margins()?;
            Ok((settings.in_range()?.is_stable, margins.gain))
        });
        if let Ok((is_stable, gain)) = verdict {
            self.count += 1;
            self.stable += u64::from(is_stable);
            self.unlimited += u64::from(gain == Some(f64::INFINITY));
            let limit = gain.filter(|gain| gain.is_finite());
            self.min_gain_margin = self.min_gain_margin.into_iter().chain(limit).reduce(f64::min);
        }
    }

    fn merge(mut self, other: Self) -> Self {
        self.count += other.count;
        self.stable += other.stable;
        self.unlimited += other.unlimited;
        self.min_gain_margin = self.min_gain_margin.into_iter().chain(other.min_gain_margin).reduce(f64::min);
        self
    }
}

/// A study of every strategy.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct StrategyStudy {
    /// Name of the scenario or the population.
    pub name: String,
    /// Number of patients.
    pub patients: u64,
    /// The persons.
    pub persons: Vec<&'static str>,
    /// Number of seeds per patient and person.
    pub seeds: u64,
    /// The 5 %, 50 % and 95 % quantiles of the master's velocity at the ruptures without a strategy, in m/s.
    pub velocities_m_per_s: Option<[f64; 3]>,
    /// The linear loops of all patients and persons.
    pub linear_loops: LinearLoops,
    /// A row per strategy.
    pub rows: Vec<StrategyRow>,
    /// Spearman's rank correlation between the strategies' mean excess for each window and for 2 s.
    pub rank_correlations: Vec<Option<f64>>,
}

enum Cases {
    Population(Box<Plan>),
    One(Box<Template>),
}

enum Maker<'a> {
    Population(Box<CaseMaker<'a>>, u64),
    One(Box<CaseFactory<'a>>, u64),
}

impl Cases {
    fn load(source: &Source, settings: &[String], options: &StrategyOptions) -> Result<Self, ScenarioError> {
        if is_sweep(source) {
            let mut plan = Plan::load(source, settings)?;
            plan.design.seeds = options.seeds;
            return Ok(Self::Population(Box::new(plan)));
        }
        Template::new(source, vec![], settings, &[]).map(|template| Self::One(Box::new(template)))
    }

    fn patients(&self, options: &StrategyOptions) -> u64 {
        match self {
            Self::Population(plan) => plan.design.points().unwrap_or(0).min(options.patients),
            Self::One(_) if options.persons.iter().any(|person| person.group.is_some()) => options.patients,
            Self::One(_) => 1,
        }
    }

    fn name(&self) -> &str {
        match self {
            Self::Population(plan) => &plan.design.name,
            Self::One(template) => &template.first().name,
        }
    }

    fn maker(&self) -> Maker<'_> {
        match self {
            Self::Population(plan) => Maker::Population(Box::new(plan.maker()), plan.design.seeds),
            Self::One(template) => Maker::One(Box::new(template.factory()), template.first().seed),
        }
    }
}

impl Cases {
    fn of_patient(&self, persons: &[&Person], patient: u64) -> Result<Vec<Scenario>, RunError> {
        let first = self.maker().scenario(patient)?;
        let of = |person: &&Person| {
            let mut scenario = first.clone();
            person.replace_operator(&mut scenario, patient);
            scenario
        };
        Ok(persons.iter().map(of).collect())
    }
}

impl Maker<'_> {
    fn scenario(&mut self, patient: u64) -> Result<Scenario, RunError> {
        match self {
            Self::Population(maker, seeds) => maker.scenario(patient * *seeds).map_err(|error| match error {
                SweepError::Case { source, .. } => *source,
                other => ScenarioError::new(other.to_string()).into(),
            }),
            Self::One(factory, first_seed) => Ok(factory.build(&[], *first_seed)?),
        }
    }
}

#[derive(Debug, Clone, Default)]
struct Tally {
    runs: u64,
    diverged: u64,
    missed: u64,
    false_alarms: u64,
    ruptures: u64,
    excesses_m: Vec<f64>,
    depths_m: Vec<f64>,
    cuts_m: Vec<f64>,
    final_m: Vec<f64>,
    velocities: Vec<f64>,
    first_rupture_s: Option<f64>,
    noticed: Noticed,
    noticed_after_s: Vec<f64>,
    false_notices: u64,
    undisturbed_s: f64,
    false_events: Noticed,
    /// Sums over the events of false alarms: duration, force, excess.
    costs: [f64; 3],
    windows: OfWindows,
}

impl Tally {
    fn add(&mut self, metrics: &Metrics) {
        self.runs += 1;
        if let Outcome::Diverged { .. } = metrics.outcome {
            self.diverged += 1;
            return;
        }
        self.missed += metrics.missed_ruptures;
        self.false_alarms += metrics.false_alarms;
        self.ruptures += metrics.ruptures.len() as u64;
        self.final_m.extend(metrics.final_excess_m);
        let cuts: Vec<f64> = metrics.ruptures.iter().filter_map(|rupture| rupture.unintended_cut_m).collect();
        self.cuts_m.extend((!cuts.is_empty()).then(|| cuts.iter().sum::<f64>()));
        for rupture in &metrics.ruptures {
            self.excesses_m.extend(rupture.excess_advance_m);
            self.depths_m.extend(rupture.depth_at_return_m);
            self.velocities.push(rupture.master_velocity_m_per_s);
            if let Some(noticed) = rupture.noticed {
                self.noticed.trials += 1;
                self.noticed.noticed += noticed;
            }
            self.noticed_after_s.extend(rupture.noticed_after_s);
        }
        let first_s = metrics.ruptures.first().map(|rupture| rupture.time_s);
        self.first_rupture_s = [self.first_rupture_s, first_s].into_iter().flatten().reduce(f64::min);
        self.false_notices += metrics.false_notices.unwrap_or(0);
        self.undisturbed_s += metrics.undisturbed_s.unwrap_or(0.0);
    }

    fn add_false_alarm(&mut self, metrics: &Metrics, time_s: f64) {
        let event = metrics.events.iter().find(|event| event.is_false == 1 && (event.start_s - time_s).abs() < 1e-9);
        let Some(event) = event else { return };
        self.false_events.trials += 1;
        self.false_events.noticed += event.noticed.unwrap_or(0);
        let event_s = event.augmented_s.unwrap_or(0.0) + event.reengaging_s.unwrap_or(0.0);
        let terms = [event_s, event.force_change_n, event.excess_at_return_m.unwrap_or(0.0)];
        self.costs.iter_mut().zip(terms).for_each(|(cost, term)| *cost += term);
    }

    fn merge(&mut self, other: Self) {
        self.runs += other.runs;
        self.diverged += other.diverged;
        self.missed += other.missed;
        self.false_alarms += other.false_alarms;
        self.ruptures += other.ruptures;
        self.excesses_m.extend(other.excesses_m);
        self.depths_m.extend(other.depths_m);
        self.cuts_m.extend(other.cuts_m);
        self.final_m.extend(other.final_m);
        self.velocities.extend(other.velocities);
        for (all, one) in [(&mut self.noticed, other.noticed), (&mut self.false_events, other.false_events)] {
            all.trials += one.trials;
            all.noticed += one.noticed;
        }
        self.noticed_after_s.extend(other.noticed_after_s);
        self.false_notices += other.false_notices;
        self.undisturbed_s += other.undisturbed_s;
        self.costs.iter_mut().zip(other.costs).for_each(|(cost, term)| *cost += term);
        for ((sum, count), (other_sum, other_count)) in self.windows.iter_mut().zip(other.windows) {
            (*sum, *count) = (*sum + other_sum, *count + other_count);
        }
    }

    fn row(mut self, strategy: &'static str, verdict: Verdict) -> StrategyRow {
        let nothing_trials = (self.undisturbed_s / HORIZON_S).round() as u64;
        let nothing = Noticed { trials: nothing_trials, noticed: self.false_notices.min(nothing_trials) };
        let events = self.false_events.trials as f64;
        let [event_s, force_n, excess_m] = self.costs.map(|sum| sum / events);
        StrategyRow {
            strategy,
            runs: self.runs,
            diverged: self.diverged,
            ruptures: self.ruptures,
            reached_share: None,
            missed_ruptures: self.missed,
            false_alarms: self.false_alarms,
            mean_excess_m: mean(&self.excesses_m),
            high_excess_m: quantile_of(&mut self.excesses_m, 0.95),
            depth_at_return_m: quantile_of(&mut self.depths_m, 0.5),
            unintended_cut_m: mean(&self.cuts_m),
            final_excess_m: mean(&self.final_m),
            noticed: self.noticed,
            noticed_after_s: quantile_of(&mut self.noticed_after_s, 0.5),
            against_nothing: Sensitivity::of(&self.noticed, &nothing),
            against_false_alarms: Sensitivity::of(&self.noticed, &self.false_events),
            false_alarm: (events > 0.0).then_some(FalseAlarmCost { event_s, force_n, excess_m }),
            verdict: if self.diverged > 0 { Verdict::Diverges } else { verdict },
            is_on_front: false,
            window_excess_m: self
                .windows
                .iter()
                .map(|(sum, count)| (*count > 0).then(|| sum / *count as f64))
                .collect(),
        }
    }
}

impl StrategyRow {
    pub fn reaches_the_ruptures(&self) -> bool {
        self.reached_share.is_some_and(|share| share >= REACHED_SHARE)
    }

    pub fn is_compared(&self) -> bool {
        self.reaches_the_ruptures() && self.verdict == Verdict::Settles
    }
}

impl StrategyStudy {
    /// The results do not depend on the threads. False alarms are raised in separate runs, halfway to the patient's
    /// first rupture.
    pub fn of(
        source: &Source,
        settings: &[String],
        options: &StrategyOptions,
        done: impl Fn(u64) + Sync,
    ) -> Result<Self, RunError> {
        let load = |strategy: &Strategy| {
            let of_strategy = strategy.settings.iter().chain(&PERCEIVING).map(|&setting| setting.to_owned());
            Cases::load(source, &settings.iter().cloned().chain(of_strategy).collect::<Vec<_>>(), options)
        };
        let cases: Vec<Cases> = try_map(STRATEGIES.len(), |strategy| load(&STRATEGIES[strategy]))?;
        let patients = cases.first().map_or(0, |first| first.patients(options));

        let run_all = |strategies: std::ops::Range<usize>, alarms_s: &[Option<f64>]| -> Result<Vec<Tally>, RunError> {
            let units: Vec<(usize, u64)> =
                strategies.flat_map(|strategy| (0..patients).map(move |patient| (strategy, patient))).collect();
            let banks = Mutex::new(vec![]);
            let unit = |unit: usize| {
                let (strategy, patient) = units[unit];
                let alarm_s = alarms_s.get(patient as usize).copied().flatten();
                // A thread reuses its noise bank for the next unit of work.
                let kept = banks.lock().unwrap_or_else(PoisonError::into_inner).pop();
                let mut bank = kept.unwrap_or_else(|| NoiseBank::new(KEPT_NUMBERS));
                let tally = run_unit(&mut bank, &cases[strategy], options, patient, alarm_s)?;
                banks.lock().unwrap_or_else(PoisonError::into_inner).push(bank);
                done(tally.runs);
                Ok(tally)
            };
            try_map(units.len(), unit)
        };
        let plain = run_all(0..1, &[])?;
        let alarms_s: Vec<Option<f64>> =
            plain.iter().map(|tally| tally.first_rupture_s.map(|time_s| 0.5 * time_s)).collect();
        let mut tallies = plain;
        tallies.extend(run_all(1..STRATEGIES.len(), &alarms_s)?);

        let verdict = |strategy: usize| -> Result<Verdict, RunError> {
            let swings = |scenario: Scenario| -> Result<bool, RunError> {
                Ok(matches!(run(scenario)?.metrics.outcome, Outcome::Oscillating { .. }))
            };
            let all = cases[strategy].of_patient(&options.persons, 0)?;
            let swings = all.into_iter().map(swings).collect::<Result<Vec<_>, _>>()?;
            Ok(if swings.contains(&true) { Verdict::Oscillates } else { Verdict::Settles })
        };
        let verdicts: Vec<Verdict> = try_map(STRATEGIES.len(), verdict)?;
        let of_patient = |patient: usize| -> Result<LinearLoops, RunError> {
            let mut loops = LinearLoops::default();
            cases[0].of_patient(&options.persons, patient as u64)?.iter().for_each(|scenario| loops.add(scenario));
            Ok(loops)
        };
        let linear_loops =
            try_map(patients as usize, of_patient)?.into_iter().fold(LinearLoops::default(), LinearLoops::merge);
        let mut all = tallies.into_iter();
        let mut velocities = None;
        let mut rows: Vec<StrategyRow> = vec![];
        for (strategy, verdict) in STRATEGIES.iter().zip(verdicts) {
            let mut tally = Tally::default();
            all.by_ref().take(patients as usize).for_each(|one| tally.merge(one));
            if rows.is_empty() {
                let of_share = [0.05, 0.5, 0.95].map(|share| quantile_of(&mut tally.velocities, share));
                velocities = of_share.iter().all(Option::is_some).then(|| of_share.map(Option::unwrap_or_default));
            }
            rows.push(tally.row(strategy.name, verdict));
        }
        set_reached(&mut rows);
        mark_front(&mut rows);
        let rank_correlations = rank_correlations(&rows);
        Ok(Self {
            name: cases.first().map_or_else(String::new, |first| first.name().to_owned()),
            patients,
            persons: options.persons.iter().map(|person| person.name).collect(),
            seeds: options.seeds,
            velocities_m_per_s: velocities,
            linear_loops,
            rows,
            rank_correlations,
        })
    }
}

fn run_unit(
    bank: &mut NoiseBank,
    cases: &Cases,
    options: &StrategyOptions,
    patient: u64,
    alarm_s: Option<f64>,
) -> Result<Tally, RunError> {
    // The steps of a person's machines are computed once.
    let firsts = cases.of_patient(&options.persons, patient)?;
    let with_seed = |first: &Scenario, offset: u64| {
        let mut other = first.clone();
        other.seed = first.seed.wrapping_add(offset);
        other
    };
    let scenarios: Vec<Scenario> =
        firsts.iter().flat_map(|first| (0..options.seeds).map(|offset| with_seed(first, offset))).collect();
    let mut tally = Tally::default();
    for metrics in run_pack_sharing(bank, &scenarios) {
        tally.add(&metrics?);
    }
    let mut firsts = firsts;
    for run in run_pack_observed(InstructionSet::widest(), bank, &firsts, &Windows(&firsts)) {
        let (_, windows) = run?;
        for ((sum, count), (of_run, ruptures)) in tally.windows.iter_mut().zip(windows) {
            (*sum, *count) = (*sum + of_run, *count + ruptures);
        }
    }
    if let Some(alarm_s) = alarm_s {
        let mut time_s = 0.0;
        for scenario in &mut firsts {
            let tick = nearest_ticks(alarm_s, scenario.grid.tick_s());
            time_s = scenario.grid.time_s(tick);
            scenario.events = [tick].into();
        }
        for metrics in run_pack_sharing(bank, &firsts) {
            tally.add_false_alarm(&metrics?, time_s);
        }
    }
    Ok(tally)
}

fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

fn set_reached(rows: &mut [StrategyRow]) {
    let all = rows.first().map_or(0, |first| first.ruptures);
    rows.iter_mut().filter(|_| all > 0).for_each(|row| row.reached_share = Some(row.ruptures as f64 / all as f64));
}

fn mark_front(rows: &mut [StrategyRow]) {
    let point = |row: &StrategyRow| row.mean_excess_m.zip(row.noticed.share()).filter(|_| row.is_compared());
    let points: Vec<Option<(f64, f64)>> = rows.iter().map(point).collect();
    let dominates = |a: (f64, f64), b: (f64, f64)| a.0 <= b.0 && a.1 >= b.1 && a != b;
    for (row, point) in rows.iter_mut().zip(&points) {
        row.is_on_front = point.is_some_and(|point| !points.iter().flatten().any(|other| dominates(*other, point)));
    }
}

fn rank_correlations(rows: &[StrategyRow]) -> Vec<Option<f64>> {
    let of_window =
        |window: usize| -> Vec<Option<f64>> { rows.iter().map(|row| row.window_excess_m[window]).collect() };
    let reference = WINDOWS_S.iter().position(|window_s| *window_s == HORIZON_S).map(of_window);
    let correlation = |window: usize| {
        let both: Vec<(f64, f64)> =
            of_window(window).into_iter().zip(reference.clone()?).filter_map(|(a, b)| a.zip(b)).collect();
        rank_correlation(&both)
    };
    (0..WINDOWS_S.len()).map(correlation).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn study(threads: usize) -> StrategyStudy {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let source = Source::parse("layers/skin-augmented");
        let options = StrategyOptions { persons: FIXED_PERSONS.to_vec(), patients: 1, seeds: 3 };
        pool.install(|| StrategyStudy::of(&source, &[], &options, |_| ())).expect("runs")
    }

    #[test]
    fn a_study_does_not_depend_on_the_threads_and_has_a_front() {
        let study_of_one = study(1);
        assert_eq!(study_of_one, study(2));
        let rows = &study_of_one.rows;
        assert_eq!(rows.len(), STRATEGIES.len());
        assert!(rows.iter().any(|row| row.is_on_front));
        let row = |name: &str| rows.iter().find(|row| row.strategy == name).expect("a row");
        let excess_mm = |name: &str| 1e3 * row(name).mean_excess_m.expect("known");
        assert!(
            excess_mm("freeze-clutch") < 0.5 * excess_mm("none"),
            "{} {}",
            excess_mm("freeze-clutch"),
            excess_mm("none")
        );
        assert!(row("none").false_alarm.is_none() && row("freeze-decay").false_alarm.is_some());
        // A false alarm and a rupture give the same cue.
        let cue = row("cue").against_false_alarms.expect("trials");
        assert!(cue.is_none(), "{cue:?}");
    }

    #[test]
    fn the_front_contains_the_rows_that_no_row_dominates() {
        let row = |mean_excess_m: f64, noticed: u64, ruptures: u64, verdict: Verdict| {
            let noticed = Noticed { trials: 10, noticed };
            let tally = Tally { runs: 1, ruptures, ..Tally::default() };
            StrategyRow { mean_excess_m: Some(mean_excess_m), noticed, ..tally.row("row", verdict) }
        };
        let mut rows = [
            row(1.0, 5, 100, Verdict::Settles),
            row(2.0, 9, 95, Verdict::Settles),
            row(2.0, 5, 100, Verdict::Settles),
            row(0.0, 10, 100, Verdict::Diverges),
            // A strategy that misses one layer in sixteen is not compared.
            row(0.0, 10, 94, Verdict::Settles),
        ];
        set_reached(&mut rows);
        mark_front(&mut rows);
        assert_eq!(rows[1].reached_share, Some(0.95));
        assert_eq!(rows.map(|row| row.is_on_front), [true, true, false, false, false]);
    }
}
