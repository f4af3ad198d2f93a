//! Running a sweep, or a part of it.

use std::sync::Mutex;
use std::sync::PoisonError;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use super::columns::Column;
use super::error::SweepError;
use super::part::{Outcome, PackRows, Part};
use super::plan::{CaseMaker, Plan};
use super::stability::LoopOfCase;
use crate::metrics;
use crate::run::{RunError, run_pack_sharing};
use crate::scenario::Scenario;
use crate::sensor::NoiseBank;

/// Numbers of noise that all threads keep together, 64 MB of them.
const MOST_NUMBERS_KEPT: usize = 8 << 20;

/// How a sweep is watched and ended.
pub struct Progress<'a> {
    /// Once this is set no pack is begun any more; those in flight are finished and kept.
    pub stop: &'a AtomicBool,
    /// Told once how many cases were done before.
    pub begun: &'a dyn Fn(u64),
    /// Told of cases as they are done.
    pub done: &'a (dyn Fn(u64) + Sync),
}

/// Runs the packs of a part that it does not have yet, on `threads` threads; gives how many cases are done in all. The order
/// in which packs are done does not matter: each has its place.
///
/// # Errors
/// [`SweepError`]: of the first case, among those begun, that cannot be run; a part that cannot be read or written.
pub fn execute(plan: &Plan, part: &Part, threads: usize, progress: &Progress<'_>) -> Result<u64, SweepError> {
    let before = part.cases_done()?;
    (progress.begun)(before);
    let Progress { stop, done: tell, .. } = *progress;
    let packs = part.layout().packs.clone();
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
    let work = || {
        let mut worker = Worker::new(plan, part, threads);
        while !stop.load(Ordering::Relaxed) && !failed.load(Ordering::Relaxed) {
            let pack = next.fetch_add(1, Ordering::Relaxed);
            if pack >= packs.end {
                break;
            }
            // Where nothing was done before, nothing is there.
            let mut run = |is_done: bool| if is_done { Ok(0) } else { worker.run(pack) };
            match if before > 0 { part.has(pack).and_then(&mut run) } else { run(false) } {
                Ok(cases) => {
                    done.fetch_add(cases, Ordering::Relaxed);
                    tell(cases);
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

/// What one thread keeps from pack to pack.
struct Worker<'a> {
    plan: &'a Plan,
    part: &'a Part,
    maker: CaseMaker<'a>,
    bank: NoiseBank,
    scenarios: Vec<Scenario>,
    rows: PackRows,
}

impl<'a> Worker<'a> {
    /// One of so many threads.
    fn new(plan: &'a Plan, part: &'a Part, threads: usize) -> Self {
        // Only where there are several points does a seed come again.
        let comes_again = plan.design.points().is_some_and(|points| points > 1);
        let bank = NoiseBank::new(if comes_again { MOST_NUMBERS_KEPT / threads.max(1) } else { 0 });
        Self { plan, part, maker: plan.maker(), bank, scenarios: vec![], rows: PackRows::default() }
    }

    /// Runs and keeps one pack; gives its cases.
    fn run(&mut self, pack: u64) -> Result<u64, SweepError> {
        let Self { plan, part, maker, bank, scenarios, rows } = self;
        let columns = &plan.design.columns;
        let cases = part.layout().cases_of(pack);
        scenarios.clear();
        let has_loop = columns.iter().any(Column::is_of_loop);
        let mut loops = vec![];
        for case in cases.clone() {
            let scenario = maker.scenario(case)?;
            loops.push(has_loop.then(|| maker.loop_settings(&scenario)));
            scenarios.push(scenario);
        }
        rows.clear();
        for (k, (case, run)) in cases.clone().zip(run_pack_sharing(bank, scenarios)).enumerate() {
            let of_case = loops[k].as_ref().map(|settings| LoopOfCase::new(&scenarios[k], settings));
            match run {
                Ok(metrics) => {
                    let outcome = match metrics.outcome {
                        metrics::Outcome::Completed => Outcome::Completed,
                        metrics::Outcome::Diverged { .. } => Outcome::Diverged,
                    };
                    rows.push(outcome, columns.iter().map(|column| column.value(&metrics, of_case.as_ref())));
                }
                Err(RunError::Integration { .. }) => rows.push(Outcome::Failed, columns.iter().map(|_| None)),
                Err(error @ RunError::Scenario(_)) => return Err(maker.refused(case, error)),
            }
        }
        part.write(pack, rows)?;
        Ok(cases.end - cases.start)
    }
}
