//! The page of a link: its pointer moves the operator's hand, and it shows the signals known to the master's side.
//!
//! The link runs on its own thread. Its ticks and the page share only the [`Hand`] and the rows of the last [`FRAME`],
//! so a slow page delays no tick.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use axum::extract::ws::{Message, WebSocket};
use serde::Deserialize;
use serde_json::json;
use tokio::sync::OwnedSemaphorePermit;
use tokio::time::interval;

use super::limits::{MAX_SILENCE, PING_INTERVAL};
use super::protocol::ServerMessage;
use super::push::{FRAME, Opening, Row, moved, range_m};
use super::session::{Allowance, message, sent};
use super::state::SCHEME;
use trocar_engine::operator::Hand;
use trocar_scenario::{Scenario, Value};
use trocar_studies::animation::{DrawnTissue, LiveDrawing};

/// Maximum number of rows that wait for the page; further rows are dropped.
const MAX_ROWS: usize = 4096;

/// Maximum time to deliver the last message to the page.
const LAST_MESSAGE: Duration = Duration::from_millis(500);

#[derive(Deserialize)]
#[serde(tag = "type", rename_all = "lowercase")]
enum Request {
    Push {
        id: u32,
    },
    /// The desired position of the hand, in m.
    Aim {
        m: f64,
    },
    Stop {},
}

#[derive(Debug, Default)]
struct Waiting {
    /// The id of the request with which the leading page began.
    leader: Option<u32>,
    rows: Vec<Row>,
    events: Vec<(f64, &'static str)>,
    tops_mm: Vec<f64>,
    torn: Vec<bool>,
    drawing: Option<LiveDrawing>,
    end: Option<String>,
    is_delivered: bool,
}

/// The field in which an operator leads a link with the pointer.
#[derive(Debug)]
pub struct Field {
    hand: Arc<Hand>,
    range_m: (f64, f64),
    opening: Opening,
    stop: AtomicBool,
    waiting: Mutex<Waiting>,
    changed: Condvar,
}

impl Field {
    /// The field of a scenario. Its range is the travel of the scenario's operator and a little more.
    #[must_use]
    pub fn new(scenario: &Scenario) -> Self {
        let range_m = range_m(scenario);
        let is_augmented = scenario.values().get(SCHEME) == Some(&Value::Flag(true));
        let rows = Vec::with_capacity(MAX_ROWS);
        Self {
            hand: Arc::new(Hand::new(range_m.0)),
            range_m,
            opening: Opening::new(scenario, is_augmented, range_m),
            stop: AtomicBool::new(false),
            waiting: Mutex::new(Waiting {
                rows,
                drawing: Some(LiveDrawing::new(scenario, range_m)),
                ..Waiting::default()
            }),
            changed: Condvar::new(),
        }
    }

    #[must_use]
    pub fn hand(&self) -> &Arc<Hand> {
        &self.hand
    }

    fn waiting(&self) -> MutexGuard<'_, Waiting> {
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits up to `time` until the operator is ready. Returns true if the operator is ready.
    pub fn wait(&self, time: Duration) -> bool {
        let waiting = self.waiting();
        let outcome = self.changed.wait_timeout_while(waiting, time, |waiting| waiting.leader.is_none());
        outcome.is_ok_and(|(waiting, _)| waiting.leader.is_some())
    }

    /// True if the operator has ended the link or left the page.
    #[must_use]
    pub fn has_ended(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    pub(crate) fn add(&self, row: Row, event: Option<(f64, &'static str)>, tissue: &DrawnTissue) {
        let mut waiting = self.waiting();
        if waiting.rows.len() < MAX_ROWS {
            waiting.rows.push(row);
        }
        waiting.events.extend(event);
        waiting.tops_mm.clear();
        waiting.tops_mm.extend_from_slice(tissue.depths_mm());
        if event.is_some() || waiting.torn.is_empty() {
            waiting.torn = tissue.torn();
        }
    }

    pub fn end(&self, text: String) {
        let mut waiting = self.waiting();
        waiting.end = Some(text);
        let is_due = |waiting: &mut Waiting| waiting.leader.is_some() && !waiting.is_delivered;
        // A page that has left gets no message.
        let _ = self.changed.wait_timeout_while(waiting, LAST_MESSAGE, is_due);
    }

    /// Handles a request and returns the answer. If the page leads, `leads` is the id of its first request.
    fn take(&self, request: &Request, leads: &mut Option<u32>) -> Option<ServerMessage> {
        match *request {
            Request::Push { id } => {
                let mut waiting = self.waiting();
                if waiting.leader.is_some() {
                    let reason = "another page already controls this link";
                    return Some(ServerMessage::refused(id, &reason));
                }
                (waiting.leader, *leads) = (Some(id), Some(id));
                self.changed.notify_all();
                return Some(self.opening.message(id));
            }
            Request::Aim { m } if leads.is_some() && m.is_finite() => {
                self.hand.aim(m.clamp(self.range_m.0, self.range_m.1));
            }
            Request::Stop {} if leads.is_some() => self.stop.store(true, Ordering::Relaxed),
            Request::Aim { .. } | Request::Stop {} => {}
        }
        None
    }

    fn next(&self, id: u32) -> Option<(ServerMessage, bool)> {
        let mut waiting = self.waiting();
        let waiting = &mut *waiting;
        if let Some(drawing) = waiting.drawing.as_mut().filter(|_| !waiting.rows.is_empty()) {
            let tissue = (&*waiting.tops_mm, &*waiting.torn);
            let message = moved(id, (&waiting.rows, &waiting.events), tissue, drawing);
            waiting.rows.clear();
            waiting.events.clear();
            return Some((message, false));
        }
        let text = waiting.end.as_ref().filter(|_| !waiting.is_delivered)?;
        Some((ServerMessage::json(&json!({ "type": "pushed", "id": id, "text": text })), true))
    }

    fn delivered(&self) {
        self.waiting().is_delivered = true;
        self.changed.notify_all();
    }
}

/// Serves a page until it closes, violates a limit, or stops reading; the link of a leading page ends with it.
pub(super) async fn serve(mut socket: WebSocket, field: Arc<Field>, _permit: OwnedSemaphorePermit) {
    let mut leads = None;
    converse(&mut socket, &field, &mut leads).await;
    if leads.is_some() {
        field.stop.store(true, Ordering::Relaxed);
        field.delivered();
    }
}

async fn converse(socket: &mut WebSocket, field: &Field, leads: &mut Option<u32>) {
    let mut allowance = Allowance::new(Instant::now());
    let mut last_received = Instant::now();
    let (mut ping, mut frame) = (interval(PING_INTERVAL), interval(FRAME));
    loop {
        tokio::select! {
            _ = frame.tick() => {
                let Some((news, is_last)) = leads.and_then(|id| field.next(id)) else { continue };
                if !sent(socket, message(news)).await {
                    return;
                }
                if is_last {
                    field.delivered();
                }
            }
            _ = ping.tick() => {
                if last_received.elapsed() > MAX_SILENCE || !sent(socket, Message::Ping("".into())).await {
                    return;
                }
            }
            received = socket.recv() => {
                last_received = Instant::now();
                let Some(Ok(received)) = received else { return };
                if !allowance.take(last_received) {
                    return;
                }
                let text = match received {
                    Message::Text(text) => text,
                    Message::Ping(_) | Message::Pong(_) => continue,
                    Message::Binary(_) | Message::Close(_) => return,
                };
                let Ok(request) = serde_json::from_str(&text) else { return };
                if let Some(answer) = field.take(&request, leads)
                    && !sent(socket, message(answer)).await
                {
                    return;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trocar_scenario::Source;

    fn json_of(answer: Option<ServerMessage>) -> serde_json::Value {
        let Some(ServerMessage::Text(text)) = answer else { return serde_json::Value::Null };
        serde_json::from_str(&text).expect("JSON")
    }

    #[test]
    fn only_one_page_leads_and_other_pages_change_nothing() {
        let scenario = Scenario::load(&Source::parse("layers/skin-augmented"), &[]).expect("shipped");
        let field = Field::new(&scenario);
        assert!(!field.wait(Duration::ZERO));
        let (mut first, mut second) = (None, None);
        field.take(&Request::Aim { m: 0.01 }, &mut first);
        field.hand.step(1.0);
        assert_eq!(field.hand.position_m(), field.range_m.0, "nobody has begun");
        let opening = json_of(field.take(&Request::Push { id: 3 }, &mut first));
        assert_eq!((opening["type"].as_str(), opening["id"].as_u64()), (Some("pushing"), Some(3)));
        assert!(field.wait(Duration::ZERO));
        assert_eq!(json_of(field.take(&Request::Push { id: 1 }, &mut second))["type"], "refused");
        for request in [Request::Aim { m: 0.02 }, Request::Stop {}] {
            field.take(&request, &mut second);
        }
        assert!(!field.has_ended());
        field.take(&Request::Aim { m: f64::MAX }, &mut first);
        for _ in 0..10_000 {
            field.hand.step(1e-3);
        }
        assert!((field.hand.position_m() - field.range_m.1).abs() < 1e-9, "the travel is bounded");
        field.take(&Request::Stop {}, &mut first);
        assert!(field.has_ended());
    }
}
