use std::collections::BTreeMap;
use std::sync::Mutex;
use std::sync::PoisonError;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use super::columns::Column;
use super::equivalent_thresholds::{RunWithEquivalents, run_with_equivalents, run_without_equivalents};
use super::error::SweepError;
use super::part::{Outcome, PACK_CASES, PackRows, Part};
use super::plan::{CaseMaker, Plan};
use super::shared_runs::{Row, SharedRuns};
use super::stability::LoopOfCase;
use crate::run::RunError;
use trocar_engine::sensor::NoiseBank;
use trocar_run::ports;

/// 64 MB over all threads.
const MAX_NUMBERS_KEPT: usize = 8 << 20;

/// Settings that do not change the results.
#[derive(Debug, Clone, Copy)]
pub struct Execution {
    pub threads: usize,
    /// Cases that differ only in the detector's threshold share runs.
    pub shares_runs: bool,
}

pub struct Progress<'a> {
    /// Once set, no new pack starts.
    pub stop: &'a AtomicBool,
    pub begun: &'a dyn Fn(u64),
    pub done: &'a (dyn Fn(u64) + Sync),
}

/// An error is that of the failed case with the lowest number.
pub fn execute(plan: &Plan, part: &Part, how: Execution, progress: &Progress<'_>) -> Result<u64, SweepError> {
    let Execution { threads, shares_runs } = how;
    let before = part.cases_done()?;
    (progress.begun)(before);
    let Progress { stop, done: report, .. } = *progress;
    let packs = part.layout().packs.clone();
    let threads = threads.clamp(1, usize::try_from(packs.end - packs.start).unwrap_or(usize::MAX).max(1));
    let (next, done, failed) = (AtomicU64::new(packs.start), AtomicU64::new(before), AtomicBool::new(false));
    let first_error: Mutex<Option<SweepError>> = Mutex::new(None);
    let fail = |error: SweepError| {
        failed.store(true, Ordering::Relaxed);
        let mut first = first_error.lock().unwrap_or_else(PoisonError::into_inner);
        let case = |error: &SweepError| if let SweepError::Case { case, .. } = error { *case } else { 0 };
        if first.as_ref().is_none_or(|first| case(&error) < case(first)) {
            *first = Some(error);
        }
    };
    let layout = part.layout();
    let cases = layout.cases_of(packs.start).start..layout.cases_of(packs.end).start;
    let shared = if shares_runs { SharedRuns::of(plan, cases) } else { None };
    // At most a share, so every thread has work.
    let fair_share = (packs.end - packs.start) / (4 * threads as u64);
    let packs_per_turn = shared.as_ref().map_or(1, |shared| shared.span().div_ceil(PACK_CASES).min(fair_share).max(1));
    let work = || {
        let mut worker = Worker::new(plan, part, shared.as_ref(), threads);
        let mut packs_of_turn = 0..0;
        while !stop.load(Ordering::Relaxed) && !failed.load(Ordering::Relaxed) {
            if packs_of_turn.is_empty() {
                let first = next.fetch_add(packs_per_turn, Ordering::Relaxed);
                packs_of_turn = first.min(packs.end)..(first + packs_per_turn).min(packs.end);
            }
            let Some(pack) = packs_of_turn.next() else { break };
            let mut run = |is_done: bool| if is_done { Ok(0) } else { worker.run(pack) };
            match if before > 0 { part.has(pack).and_then(&mut run) } else { run(false) } {
                Ok(cases) => {
                    done.fetch_add(cases, Ordering::Relaxed);
                    report(cases);
                }
                Err(error) => fail(error),
            }
        }
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|error| SweepError::Io { path: "threads".into(), source: std::io::Error::other(error) })?;
    pool.scope(|scope| (0..threads).for_each(|_| scope.spawn(|_| work())));
    match first_error.into_inner().unwrap_or_else(PoisonError::into_inner) {
        Some(error) => Err(error),
        None => Ok(done.into_inner()),
    }
}

struct Worker<'a> {
    plan: &'a Plan,
    part: &'a Part,
    shared: Option<&'a SharedRuns>,
    maker: CaseMaker<'a>,
    bank: NoiseBank,
    rows: PackRows,
}

impl<'a> Worker<'a> {
    fn new(plan: &'a Plan, part: &'a Part, shared: Option<&'a SharedRuns>, threads: usize) -> Self {
        // A seed repeats only if there are several points.
        let seeds_repeat = plan.design.points().is_some_and(|points| points > 1);
        let bank = NoiseBank::new(if seeds_repeat { MAX_NUMBERS_KEPT / threads.max(1) } else { 0 });
        Self { plan, part, shared, maker: plan.maker(), bank, rows: PackRows::default() }
    }

    fn run(&mut self, pack: u64) -> Result<u64, SweepError> {
        let cases = self.part.layout().cases_of(pack);
        let mut known: BTreeMap<u64, Row> =
            cases.clone().filter_map(|case| Some((case, self.shared?.take(case)?))).collect();
        let missing: Vec<u64> = cases.clone().filter(|case| !known.contains_key(case)).collect();
        if !missing.is_empty() {
            known.extend(self.run_cases(&missing)?);
            // Marks them as read.
            missing.iter().for_each(|&case| drop(self.shared.and_then(|shared| shared.take(case))));
        }
        self.rows.clear();
        for (_, row) in known.range(cases.clone()) {
            self.rows.push(row.outcome, row.values.iter().copied());
        }
        self.part.write(pack, &mut self.rows)?;
        Ok(cases.end - cases.start)
    }

    fn ahead(&self, lanes_taken: usize) -> Option<u64> {
        self.shared.filter(|_| lanes_taken < PACK_CASES as usize)?.ahead()
    }

    fn run_cases(&mut self, cases: &[u64]) -> Result<Vec<(u64, Row)>, SweepError> {
        let columns = &self.plan.design.columns;
        let has_loop = columns.iter().any(Column::is_of_loop);
        let has_ports = columns.iter().any(Column::is_of_ports);
        let (mut running, mut scenarios, mut higher) = (vec![], vec![], vec![]);
        while let Some(case) = cases.get(running.len()).copied().or_else(|| self.ahead(running.len())) {
            let scenario = self.maker.scenario(case)?;
            let cap = scenario.detector.cusum.cap;
            higher.push(self.shared.map_or_else(Vec::new, |shared| shared.higher(case, cap)));
            scenarios.push(scenario);
            running.push(case);
        }
        let mut rows = vec![];
        let runs = match self.shared {
            Some(_) => run_with_equivalents(&mut self.bank, &scenarios, &higher),
            None => run_without_equivalents(&mut self.bank, &scenarios),
        };
        for (k, (case, run)) in running.into_iter().zip(runs).enumerate() {
            let (row, thresholds) = match run {
                Ok(RunWithEquivalents { mut metrics, thresholds }) => {
                    if has_ports {
                        metrics.ports = ports(&scenarios[k]).map_err(|error| self.maker.refused(case, error))?;
                    }
                    let of_case = has_loop.then(|| LoopOfCase::new(&scenarios[k]));
                    let outcome = Outcome::of(metrics.outcome);
                    let values = columns.iter().map(|column| column.value(&metrics, of_case.as_ref())).collect();
                    (Row { outcome, values }, thresholds)
                }
                Err(RunError::Engine { .. }) => {
                    (Row { outcome: Outcome::Failed, values: vec![None; columns.len()] }, vec![])
                }
                Err(error @ RunError::Scenario(_)) => return Err(self.maker.refused(case, error)),
            };
            if let Some(shared) = self.shared {
                shared.keep(case, row.clone(), &thresholds);
            }
            rows.push((case, row));
        }
        Ok(rows)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sweep::Shard;
    use trocar_scenario::Source;

    #[test]
    fn shared_results_are_removed_after_all_their_cases_are_written() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("sweep.toml");
        let text = "base = \"builtin:paper/augmented.toml\"\nseeds = 3\n[set]\nsimulation.duration_s = 6.0\n\
                    sensor.force_noise_std_n = 0.03\ndetector.cap = 0.4\n[axes]\nscaling.force = [0.7, 1.4]\n\
                    detector.threshold = { from = 2e-3, to = 0.2, points = 9, log = true }\n";
        std::fs::write(&file, text).expect("written");
        let plan = Plan::load(&Source::parse(file.to_str().expect("a path")), &[]).expect("a sweep");
        let part = Part::open(&folder.path().join("part"), plan.layout(Shard::WHOLE)).expect("a part");
        let shared = SharedRuns::of(&plan, 0..plan.design.cases()).expect("thresholds");
        let mut worker = Worker::new(&plan, &part, Some(&shared), 1);
        let packs = part.layout().packs.clone();
        worker.run(packs.start).expect("runs");
        assert!(!shared.is_empty());
        let cases: u64 = (packs.start + 1..packs.end).map(|pack| worker.run(pack).expect("runs")).sum();
        assert_eq!((cases + 8, shared.is_empty()), (54, true));
    }
}
