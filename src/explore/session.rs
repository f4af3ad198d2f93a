//! One page: its WebSocket, its requests and its answers.

use std::sync::Arc;
use std::time::Instant;

use axum::extract::ws::{CloseFrame, Message, WebSocket, close_code};
use tokio::sync::OwnedSemaphorePermit;
use tokio::sync::mpsc::{self, Sender};
use tokio::time::{interval, timeout};

use super::controls::greeting;
use super::limits::{MAX_ENDING, MAX_SILENCE, MESSAGES, PING_INTERVAL, SEND_TIMEOUT};
use super::pair::PairMaker;
use super::protocol::{Request, ServerMessage};
use super::push::Push;
use super::state::Catalogue;
use super::worker::{Job, Mailbox, WorkerContext, start};

const MAX_ANSWERS: usize = 4;

/// A token bucket: allows a burst of messages and limits their rate.
struct Allowance {
    left: f64,
    updated: Instant,
}

impl Allowance {
    fn new(now: Instant) -> Self {
        Self { left: MESSAGES.0, updated: now }
    }

    fn take(&mut self, now: Instant) -> bool {
        let (burst, per_s) = MESSAGES;
        self.left = (self.left + per_s * now.duration_since(self.updated).as_secs_f64()).min(burst);
        self.updated = now;
        self.left -= 1.0;
        self.left >= 0.0
    }
}

struct Session {
    mailbox: Arc<Mailbox>,
    answers: Sender<ServerMessage>,
    permit: Arc<OwnedSemaphorePermit>,
    maker: PairMaker,
    push: Option<Push>,
}

impl Drop for Session {
    fn drop(&mut self) {
        self.mailbox.end();
    }
}

pub(super) async fn serve(mut socket: WebSocket, catalogue: Catalogue, first: String, permit: OwnedSemaphorePermit) {
    let (answers, mut answered) = mpsc::channel(MAX_ANSWERS);
    let permit = Arc::new(permit);
    let mailbox = Arc::new(Mailbox::default());
    let context = WorkerContext {
        mailbox: mailbox.clone(),
        catalogue: catalogue.clone(),
        answers: answers.clone(),
        permit: permit.clone(),
    };
    if start(context).is_err() {
        mailbox.end();
        return close(&mut socket, close_code::AGAIN, "no thread is available").await;
    }
    let mut session = Session { mailbox, answers, permit, maker: PairMaker::new(catalogue.clone()), push: None };
    if !sent(&mut socket, message(greeting(&catalogue, &first))).await {
        return;
    }
    let mut allowance = Allowance::new(Instant::now());
    let mut last_received = Instant::now();
    let mut ping = interval(PING_INTERVAL);
    loop {
        tokio::select! {
            answer = answered.recv() => {
                // This session holds a sender, so the channel is open.
                let Some(answer) = answer else { return };
                if !sent(&mut socket, message(answer)).await {
                    return;
                }
            }
            _ = ping.tick() => {
                if last_received.elapsed() > MAX_SILENCE || !sent(&mut socket, Message::Ping("".into())).await {
                    return;
                }
            }
            received = socket.recv() => {
                last_received = Instant::now();
                let text = match received {
                    Some(Ok(Message::Text(text))) => text,
                    Some(Ok(Message::Ping(_) | Message::Pong(_))) => {
                        if allowance.take(last_received) { continue }
                        return close(&mut socket, close_code::POLICY, "too many messages").await;
                    }
                    Some(Ok(Message::Binary(_))) => return close(&mut socket, close_code::UNSUPPORTED, "text only").await,
                    // The page is closed, or the message is invalid or too large.
                    Some(Ok(Message::Close(_)) | Err(_)) | None => return,
                };
                if !allowance.take(last_received) {
                    return close(&mut socket, close_code::POLICY, "too many messages").await;
                }
                match serde_json::from_str(&text) {
                    Ok(request) => {
                        if let Some(answer) = session.take(request)
                            && !sent(&mut socket, message(answer)).await
                        {
                            return;
                        }
                    }
                    Err(_) => return close(&mut socket, close_code::POLICY, "invalid message").await,
                }
            }
        }
    }
}

impl Session {
    fn take(&mut self, request: Request) -> Option<ServerMessage> {
        match request {
            Request::Show(show) => self.mailbox.show(show),
            Request::Map(map) => self.mailbox.map(map),
            Request::Open { id, scenario } => return self.job(id, Job::Open { id, scenario }),
            Request::Export(export) => return self.job(export.id, Job::Export(export)),
            Request::Push { id, state, augmented } => {
                self.push = None;
                // The page, its two threads and each running insertion hold one permit each.
                if Arc::strong_count(&self.permit) > 3 + MAX_ENDING {
                    return Some(ServerMessage::refused(id, &"too many requests at once"));
                }
                let (maker, answers, permit) = (&mut self.maker, self.answers.clone(), self.permit.clone());
                // Reading a recording takes some milliseconds and must not block other pages.
                let begun =
                    tokio::task::block_in_place(|| Push::begin(id, (&state, augmented), maker, (answers, permit)));
                match begun {
                    Ok(push) => self.push = Some(push),
                    Err(reason) => return Some(ServerMessage::refused(id, &reason)),
                }
            }
            Request::Aim { m } => {
                if let Some(push) = &self.push {
                    push.aim(m);
                }
            }
            Request::Stop {} => self.push = None,
        }
        None
    }

    fn job(&mut self, id: u32, job: Job) -> Option<ServerMessage> {
        let too_many = |_| ServerMessage::refused(id, &"too many requests at once");
        self.mailbox.job(job).err().map(too_many)
    }
}

fn message(answer: ServerMessage) -> Message {
    match answer {
        ServerMessage::Text(text) => Message::Text(text.into()),
        ServerMessage::Frame(bytes) => Message::Binary(bytes.into()),
    }
}

async fn sent(socket: &mut WebSocket, message: Message) -> bool {
    matches!(timeout(SEND_TIMEOUT, socket.send(message)).await, Ok(Ok(())))
}

async fn close(socket: &mut WebSocket, code: u16, reason: &'static str) {
    sent(socket, Message::Close(Some(CloseFrame { code, reason: reason.into() }))).await;
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn an_allowance_passes_a_burst_and_then_limits_the_rate() {
        let start = Instant::now();
        let mut allowance = Allowance::new(start);
        let passed = (0..10_000).filter(|_| allowance.take(start)).count();
        assert_eq!(passed as f64, MESSAGES.0);
        let mut allowance = Allowance { left: 0.0, updated: start };
        let passed = (1..=10_000).filter(|k| allowance.take(start + Duration::from_millis(10 * k))).count();
        assert_eq!(passed, 10_000, "100 per second are below the limit");
    }
}
