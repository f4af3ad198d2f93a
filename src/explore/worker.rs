//! The threads that compute for a page: one for runs, one for maps, so that neither waits for the other.
//!
//! Of several states that a page sent while one was computed only the last counts: a page that moves a slider faster than
//! the machine runs gets every frame that there is time for, and a hostile one gains nothing by asking often.

use std::collections::VecDeque;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use tokio::sync::OwnedSemaphorePermit;
use tokio::sync::mpsc::Sender;

use super::controls;
use super::frame::{frame, table};
use super::map::mapped;
use super::pair::{Pair, PairMaker, SCHEMES};
use super::protocol::{Answer, Export, File, MapRequest, Show};
use super::state::{Catalogue, StateError};
use trocar_report::write_trace_csv;
use trocar_sim::compare::NoiseCheck;
use trocar_sim::run::run;

/// How many files and openings may wait; beyond, they are refused.
const MAX_JOBS: usize = 8;

/// How long a page's controls must rest until its runs are looked at in noise.
const REST: Duration = Duration::from_millis(600);

/// What is asked for besides the state to show.
#[derive(Debug)]
pub(super) enum Job {
    Open { id: u32, scenario: String },
    Export(Export),
}

#[derive(Debug, Default)]
struct Waiting {
    show: Option<Show>,
    map: Option<MapRequest>,
    jobs: VecDeque<Job>,
    ended: bool,
}

/// Where a page's wishes wait for its threads.
#[derive(Debug, Default)]
pub(super) struct Mailbox {
    waiting: Mutex<Waiting>,
    changed: Condvar,
}

impl Mailbox {
    fn lock(&self) -> MutexGuard<'_, Waiting> {
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn show(&self, show: Show) {
        self.lock().show = Some(show);
        self.changed.notify_all();
    }

    pub(super) fn map(&self, map: MapRequest) {
        self.lock().map = Some(map);
        self.changed.notify_all();
    }

    /// Gives the job back where too many wait already.
    pub(super) fn job(&self, job: Job) -> Result<(), Job> {
        let mut waiting = self.lock();
        if waiting.jobs.len() >= MAX_JOBS {
            return Err(job);
        }
        waiting.jobs.push_back(job);
        drop(waiting);
        self.changed.notify_all();
        Ok(())
    }

    /// Ends the threads once they have finished what they are at.
    pub(super) fn end(&self) {
        self.lock().ended = true;
        self.changed.notify_all();
    }
}

/// What the threads of one page share. The permit is the page's: the next one comes in when the last thread has ended.
pub(super) struct WorkerContext {
    pub(super) mailbox: Arc<Mailbox>,
    pub(super) catalogue: Catalogue,
    pub(super) answers: Sender<Answer>,
    pub(super) permit: Arc<OwnedSemaphorePermit>,
}

/// Starts the threads of a page.
///
/// # Errors
/// Where the system has no thread left.
pub(super) fn start(office: WorkerContext) -> std::io::Result<()> {
    let WorkerContext { mailbox, catalogue, answers, permit } = office;
    let maps = (mailbox.clone(), PairMaker::new(catalogue.clone()), answers.clone(), permit.clone());
    std::thread::Builder::new().name("trocar map".into()).spawn(move || {
        let (mailbox, mut maker, answers, permit) = maps;
        // One thread a map: the processors are for the runs.
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
        while let Some(request) = next_map(&mailbox) {
            let answer = match &pool {
                Ok(pool) => pool.install(|| mapped(&request, &mut maker)),
                Err(_) => mapped(&request, &mut maker),
            };
            if answers.blocking_send(or_refused(request.id, answer)).is_err() {
                break;
            }
        }
        drop(permit);
    })?;
    std::thread::Builder::new().name("trocar runs".into()).spawn(move || {
        let mut desk = RunWorker { maker: PairMaker::new(catalogue), shown: None, noise: None };
        while let Some(task) = next_task(&mailbox, desk.shown.is_some() && desk.noise.is_none()) {
            if answers.blocking_send(desk.answer(task)).is_err() {
                break;
            }
        }
        drop(permit);
    })?;
    Ok(())
}

fn or_refused(id: u32, answer: Result<Answer, StateError>) -> Answer {
    answer.unwrap_or_else(|reason| Answer::refused(id, &reason))
}

fn next_map(mailbox: &Mailbox) -> Option<MapRequest> {
    let mut waiting = mailbox.lock();
    loop {
        if waiting.ended {
            return None;
        }
        if let Some(map) = waiting.map.take() {
            return Some(map);
        }
        waiting = mailbox.changed.wait(waiting).unwrap_or_else(PoisonError::into_inner);
    }
}

enum Task {
    Show(Show),
    Job(Job),
    /// Nobody has asked for anything for a while.
    Rest,
}

fn next_task(mailbox: &Mailbox, wants_rest: bool) -> Option<Task> {
    let mut waiting = mailbox.lock();
    let since = Instant::now();
    loop {
        if waiting.ended {
            return None;
        }
        if let Some(job) = waiting.jobs.pop_front() {
            return Some(Task::Job(job));
        }
        if let Some(show) = waiting.show.take() {
            return Some(Task::Show(show));
        }
        if !wants_rest {
            waiting = mailbox.changed.wait(waiting).unwrap_or_else(PoisonError::into_inner);
            continue;
        }
        let Some(left) = REST.checked_sub(since.elapsed()) else { return Some(Task::Rest) };
        waiting = mailbox.changed.wait_timeout(waiting, left).unwrap_or_else(PoisonError::into_inner).0;
    }
}

/// The thread of the runs, with the pair that it showed last.
struct RunWorker {
    maker: PairMaker,
    shown: Option<(Show, Pair)>,
    /// What was seen of that pair in noise, once it was looked at.
    noise: Option<Vec<NoiseCheck>>,
}

impl RunWorker {
    fn answer(&mut self, task: Task) -> Answer {
        match task {
            Task::Show(show) => {
                let id = show.id;
                self.show(show).unwrap_or_else(|reason| Answer::refused(id, &reason))
            }
            Task::Job(Job::Open { id, scenario }) => or_refused(id, controls::values(id, &scenario, &mut self.maker)),
            Task::Job(Job::Export(export)) => {
                let id = export.id;
                or_refused(id, self.export(&export))
            }
            Task::Rest => {
                let Some((show, pair)) = &self.shown else { return Answer::json(&serde_json::Value::Null) };
                // What fails once would fail again: it is not looked at anew.
                let noise = self.noise.insert(vec![]);
                match pair.in_noise() {
                    Ok(seen) => {
                        *noise = seen;
                        let table = table(&pair.runs, noise);
                        Answer::json(&serde_json::json!({ "type": "table", "id": show.id, "table": table }))
                    }
                    Err(reason) => Answer::refused(show.id, &reason),
                }
            }
        }
    }

    fn show(&mut self, show: Show) -> Result<Answer, StateError> {
        let began = Instant::now();
        let same = |shown: &(Show, Pair)| shown.0.state == show.state;
        let pair = match self.shown.take().filter(same) {
            Some((_, pair)) => pair,
            None => {
                self.noise = None;
                self.maker.run(&show.state)?
            }
        };
        let frame = frame(&pair, self.noise.as_deref().unwrap_or_default(), &show, began);
        self.shown = Some((show, pair));
        Ok(Answer::Frame(frame))
    }

    fn export(&mut self, export: &Export) -> Result<Answer, StateError> {
        let scenario = self.maker.written(&export.state, export.augmented)?;
        let (name, ending) = (scenario.name.clone(), if export.file == File::Toml { "toml" } else { "csv" });
        let content = match export.file {
            File::Toml => scenario.echo(),
            File::Csv => {
                let run = run(scenario)?;
                let mut bytes = vec![];
                // Writing to memory does not fail, and the numbers are text.
                let _ = write_trace_csv(&run.trace, &mut bytes);
                String::from_utf8(bytes).unwrap_or_default()
            }
        };
        let scheme = SCHEMES[usize::from(export.augmented)];
        // Both files of a scenario may lie in one folder.
        let name = if name.ends_with(scheme) { name } else { format!("{name}_{scheme}") };
        Ok(Answer::json(&serde_json::json!({
            "type": "file",
            "id": export.id,
            "name": format!("{name}.{ending}"),
            "content": content,
        })))
    }
}
