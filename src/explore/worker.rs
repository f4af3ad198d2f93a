//! The two threads of a page, one for runs and one for maps, so that neither waits for the other.
//!
//! Of several states that a page sends during a computation, only the last one is computed: a slider can move faster
//! than the machine computes, and a hostile page cannot cause more work.

use std::collections::VecDeque;
use std::panic::AssertUnwindSafe;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use tokio::sync::OwnedSemaphorePermit;
use tokio::sync::mpsc::Sender;

use super::controls;
use super::frame::{frame, picture, table};
use super::map::mapped;
use super::pair::{Pair, PairMaker, SCHEMES};
use super::protocol::{Export, File, MapRequest, ServerMessage, Show};
use super::state::{Catalogue, StateError};
use trocar_report::ColumnFormat;
use trocar_report::draw::FigureWidth;
use trocar_studies::compare::NoiseCheck;
use trocar_studies::run::{run, trace_table};

/// Maximum number of queued jobs. Further jobs are refused.
const MAX_JOBS: usize = 8;

/// Time without requests after which the noise checks start.
const IDLE: Duration = Duration::from_millis(600);

/// A request other than for a state or a map.
#[derive(Debug)]
pub(super) enum Job {
    Open { id: u32, scenario: String },
    Export(Export),
}

#[derive(Debug, Default)]
struct Queue {
    show: Option<Show>,
    map: Option<MapRequest>,
    jobs: VecDeque<Job>,
    ended: bool,
}

#[derive(Debug, Default)]
pub(super) struct Mailbox {
    queue: Mutex<Queue>,
    changed: Condvar,
}

impl Mailbox {
    fn lock(&self) -> MutexGuard<'_, Queue> {
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn show(&self, show: Show) {
        self.lock().show = Some(show);
        self.changed.notify_all();
    }

    pub(super) fn map(&self, map: MapRequest) {
        self.lock().map = Some(map);
        self.changed.notify_all();
    }

    pub(super) fn job(&self, job: Job) -> Result<(), Job> {
        let mut queue = self.lock();
        if queue.jobs.len() >= MAX_JOBS {
            return Err(job);
        }
        queue.jobs.push_back(job);
        drop(queue);
        self.changed.notify_all();
        Ok(())
    }

    pub(super) fn end(&self) {
        self.lock().ended = true;
        self.changed.notify_all();
    }
}

/// The shared data of a page's threads; the page's permit becomes free with the last thread.
pub(super) struct WorkerContext {
    pub(super) mailbox: Arc<Mailbox>,
    pub(super) catalogue: Catalogue,
    pub(super) answers: Sender<ServerMessage>,
    pub(super) permit: Arc<OwnedSemaphorePermit>,
}

/// Starts the threads of a page.
pub(super) fn start(context: WorkerContext) -> std::io::Result<()> {
    let WorkerContext { mailbox, catalogue, answers, permit } = context;
    let maps = (mailbox.clone(), PairMaker::new(catalogue.clone()), answers.clone(), permit.clone());
    std::thread::Builder::new().name("trocar map".into()).spawn(move || {
        let (mailbox, mut maker, answers, permit) = maps;
        // Maps use one thread; the other processors are for runs.
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
        while let Some(request) = next_map(&mailbox) {
            let answer = or_panicked(request.id, || {
                let answer = match &pool {
                    Ok(pool) => pool.install(|| mapped(&request, &mut maker)),
                    Err(_) => mapped(&request, &mut maker),
                };
                or_refused(request.id, answer)
            });
            if answers.blocking_send(answer).is_err() {
                break;
            }
        }
        drop(permit);
    })?;
    std::thread::Builder::new().name("trocar runs".into()).spawn(move || {
        let mut worker = RunWorker { maker: PairMaker::new(catalogue), shown: None, noise: None };
        while let Some(task) = next_task(&mailbox, worker.shown.is_some() && worker.noise.is_none()) {
            let answer = or_panicked(task.id(), || worker.answer(task));
            if answers.blocking_send(answer).is_err() {
                break;
            }
        }
        drop(permit);
    })?;
    Ok(())
}

fn or_refused(id: u32, answer: Result<ServerMessage, StateError>) -> ServerMessage {
    answer.unwrap_or_else(|reason| ServerMessage::refused_for(id, &reason, &reason.reasons()))
}

/// The answer to a request. A panic becomes a refusal, and the next request computes everything anew.
pub(super) fn or_panicked(id: u32, answer: impl FnOnce() -> ServerMessage) -> ServerMessage {
    // A panic leaves the state of the last complete answer, or a state that is computed again.
    std::panic::catch_unwind(AssertUnwindSafe(answer)).unwrap_or_else(|panic| {
        let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
        let text = text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_default();
        let reason = format!(
            "trocar failed with these values because of an internal error: {text}. Use other values, and please \
             report the error with the link of this page."
        );
        ServerMessage::refused(id, &reason)
    })
}

fn next_map(mailbox: &Mailbox) -> Option<MapRequest> {
    let mut queue = mailbox.lock();
    loop {
        if queue.ended {
            return None;
        }
        if let Some(map) = queue.map.take() {
            return Some(map);
        }
        queue = mailbox.changed.wait(queue).unwrap_or_else(PoisonError::into_inner);
    }
}

enum Task {
    Show(Show),
    Job(Job),
    /// The page has sent no request for a while.
    Idle,
}

impl Task {
    fn id(&self) -> u32 {
        match self {
            Self::Show(show) => show.id,
            Self::Job(Job::Open { id, .. }) => *id,
            Self::Job(Job::Export(export)) => export.id,
            Self::Idle => 0,
        }
    }
}

fn next_task(mailbox: &Mailbox, checks_noise: bool) -> Option<Task> {
    let mut queue = mailbox.lock();
    let since = Instant::now();
    loop {
        if queue.ended {
            return None;
        }
        if let Some(job) = queue.jobs.pop_front() {
            return Some(Task::Job(job));
        }
        if let Some(show) = queue.show.take() {
            return Some(Task::Show(show));
        }
        if !checks_noise {
            queue = mailbox.changed.wait(queue).unwrap_or_else(PoisonError::into_inner);
            continue;
        }
        let Some(left) = IDLE.checked_sub(since.elapsed()) else { return Some(Task::Idle) };
        queue = mailbox.changed.wait_timeout(queue, left).unwrap_or_else(PoisonError::into_inner).0;
    }
}

struct RunWorker {
    maker: PairMaker,
    shown: Option<(Show, Pair)>,
    /// The noise checks of that pair, when they are complete.
    noise: Option<Vec<NoiseCheck>>,
}

impl RunWorker {
    fn answer(&mut self, task: Task) -> ServerMessage {
        match task {
            Task::Show(show) => {
                let id = show.id;
                or_refused(id, self.show(show))
            }
            Task::Job(Job::Open { id, scenario }) => or_refused(id, controls::values(id, &scenario, &mut self.maker)),
            Task::Job(Job::Export(export)) => {
                let id = export.id;
                or_refused(id, self.export(&export))
            }
            Task::Idle => {
                let Some((show, pair)) = &self.shown else { return ServerMessage::json(&serde_json::Value::Null) };
                // Set first, so that the noise checks are not repeated after a failure.
                let noise = self.noise.insert(vec![]);
                match pair.in_noise() {
                    Ok(checks) => {
                        *noise = checks;
                        let table = table(&pair.runs, noise);
                        ServerMessage::json(&serde_json::json!({ "type": "table", "id": show.id, "table": table }))
                    }
                    Err(reason) => ServerMessage::refused(show.id, &reason),
                }
            }
        }
    }

    fn show(&mut self, show: Show) -> Result<ServerMessage, StateError> {
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
        Ok(ServerMessage::Frame(frame?))
    }

    fn export(&mut self, export: &Export) -> Result<ServerMessage, StateError> {
        let scenario = self.maker.written(&export.state, export.augmented)?;
        let which = usize::from(export.augmented);
        // Different names let all files of a scenario be saved into one folder.
        let name = &scenario.name;
        let name = if name.ends_with(SCHEMES[which]) { name.clone() } else { format!("{name}_{}", SCHEMES[which]) };
        let (extension, content) = match export.file {
            File::Toml => ("toml", scenario.echo()),
            File::Csv => {
                let run = run(scenario)?;
                let mut bytes = vec![];
                // Writing to memory does not fail, and the CSV text is ASCII.
                let _ = ColumnFormat::Csv.write(&trace_table(&run.trace, |_| true), &mut bytes);
                ("csv", String::from_utf8(bytes).unwrap_or_default())
            }
            File::Png => {
                let width = export.width.as_deref().map_or(Ok(FigureWidth::default()), str::parse);
                let width = width.map_err(StateError::Width)?;
                let pair = self.maker.run(&export.state)?;
                let file = (export.id, format!("{name}.png"));
                return Ok(ServerMessage::Frame(picture(&pair.runs, which, file, (export.window, width))?));
            }
        };
        Ok(ServerMessage::json(&serde_json::json!({
            "type": "file",
            "id": export.id,
            "name": format!("{name}.{extension}"),
            "content": content,
        })))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_gets_an_error_after_a_panic_and_continues() {
        let failing = || -> ServerMessage { panic!("no such lane") };
        let ServerMessage::Text(text) = or_panicked(7, failing) else { panic!("a text") };
        let message: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        assert_eq!((&message["type"], &message["id"]), (&"refused".into(), &7.into()));
        assert!(message["message"].as_str().is_some_and(|text| text.contains("no such lane")), "{message}");
        let next = or_panicked(8, || ServerMessage::Text("next".into()));
        assert!(matches!(next, ServerMessage::Text(text) if text == "next"));
    }
}
