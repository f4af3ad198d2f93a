//! Running a sweep, or a part of it.

use std::sync::Mutex;
use std::sync::PoisonError;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use super::columns::Column;
use super::error::SweepError;
use super::ladder::{Ladder, Question, Row};
use super::part::{Outcome, PACK_CASES, PackRows, Part};
use super::plan::{CaseMaker, Plan};
use super::stability::LoopOfCase;
use crate::metrics;
use crate::run::{Asked, RunError, run_pack_asking};
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
    let layout = part.layout();
    let cases = layout.cases_of(packs.start).start..layout.cases_of(packs.end).start;
    let ladder = Ladder::of(plan, cases);
    // What one thread finds out should not be run by another meanwhile; but none should be left without work.
    let fair = (packs.end - packs.start) / (4 * threads.max(1) as u64);
    let at_once = ladder.as_ref().map_or(1, |ladder| ladder.span().div_ceil(PACK_CASES).min(fair).max(1));
    let work = || {
        let mut worker = Worker::new(plan, part, ladder.as_ref(), threads);
        let mut own = 0..0;
        while !stop.load(Ordering::Relaxed) && !failed.load(Ordering::Relaxed) {
            if own.is_empty() {
                let first = next.fetch_add(at_once, Ordering::Relaxed);
                own = first.min(packs.end)..(first + at_once).min(packs.end);
            }
            let Some(pack) = own.next() else { break };
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
    /// What all threads know together of runs that cases share.
    ladder: Option<&'a Ladder>,
    maker: CaseMaker<'a>,
    bank: NoiseBank,
    rows: PackRows,
}

impl<'a> Worker<'a> {
    /// One of so many threads.
    fn new(plan: &'a Plan, part: &'a Part, ladder: Option<&'a Ladder>, threads: usize) -> Self {
        // Only where there are several points does a seed come again.
        let comes_again = plan.design.points().is_some_and(|points| points > 1);
        let bank = NoiseBank::new(if comes_again { MOST_NUMBERS_KEPT / threads.max(1) } else { 0 });
        Self { plan, part, ladder, maker: plan.maker(), bank, rows: PackRows::default() }
    }

    /// Runs and keeps one pack; gives its cases.
    fn run(&mut self, pack: u64) -> Result<u64, SweepError> {
        let cases = self.part.layout().cases_of(pack);
        let mut rows: Vec<Option<Row>> = cases.clone().map(|case| self.ladder?.take(case)).collect();
        let missing: Vec<u64> = cases.clone().filter(|case| rows[(case - cases.start) as usize].is_none()).collect();
        if !missing.is_empty() {
            for (case, row) in self.answer(&missing)? {
                if cases.contains(&case) {
                    rows[(case - cases.start) as usize] = Some(row);
                }
            }
        }
        self.rows.clear();
        rows.into_iter().flatten().for_each(|row| self.rows.push(row.outcome, row.values.into_iter()));
        self.part.write(pack, &mut self.rows)?;
        Ok(cases.end - cases.start)
    }

    /// Runs cases, and beside them others whose turn comes later, where lanes are left over.
    fn answer(&mut self, cases: &[u64]) -> Result<Vec<(u64, Row)>, SweepError> {
        let question = |&case: &u64| match self.ladder {
            Some(ladder) => ladder.question(case),
            None => Question { case, higher: vec![] },
        };
        let mut questions: Vec<Question> = cases.iter().map(question).collect();
        while let Some(ladder) = self.ladder.filter(|_| questions.len() < PACK_CASES as usize) {
            let Some(case) = ladder.ahead() else { break };
            questions.push(ladder.question(case));
        }
        let columns = &self.plan.design.columns;
        let has_loop = columns.iter().any(Column::is_of_loop);
        let (mut scenarios, mut loops, mut higher) = (vec![], vec![], vec![]);
        for Question { case, higher: above } in &mut questions {
            let scenario = self.maker.scenario(*case)?;
            loops.push(has_loop.then(|| self.maker.loop_settings(&scenario)));
            above.retain(|&threshold| threshold < scenario.detector.cusum.cap);
            higher.push(std::mem::take(above));
            scenarios.push(scenario);
        }
        let mut rows = vec![];
        let answers = run_pack_asking(&mut self.bank, &scenarios, &higher);
        for (k, (Question { case, .. }, answer)) in questions.into_iter().zip(answers).enumerate() {
            let (row, alike) = match answer {
                Ok(Asked { metrics, alike }) => {
                    let of_case = loops[k].as_ref().map(|settings| LoopOfCase::new(&scenarios[k], settings));
                    let outcome = match metrics.outcome {
                        metrics::Outcome::Completed => Outcome::Completed,
                        metrics::Outcome::Diverged { .. } => Outcome::Diverged,
                    };
                    let values = columns.iter().map(|column| column.value(&metrics, of_case.as_ref())).collect();
                    (Row { outcome, values }, alike)
                }
                Err(RunError::Integration { .. }) => {
                    (Row { outcome: Outcome::Failed, values: vec![None; columns.len()] }, vec![])
                }
                Err(error @ RunError::Scenario(_)) => return Err(self.maker.refused(case, error)),
            };
            if let Some(ladder) = self.ladder {
                ladder.keep(case, row.clone(), &alike);
            }
            rows.push((case, row));
        }
        Ok(rows)
    }
}
