//! An insertion by hand: the pointer sets the desired position of the master, and the engine runs in real time.
//!
//! The engine is that of every other run. Its operator is a [`Hand`] that follows the pointer. Its observer waits for
//! the time of each tick and sends the signals to the page 60 times per second.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use serde_json::{Value as Json, json};
use tokio::sync::OwnedSemaphorePermit;
use tokio::sync::mpsc::Sender;
use tokio::sync::mpsc::error::TrySendError;

use super::frame::signals;
use super::limits::MAX_TICKS;
use super::pair::{PairMaker, SCHEMES};
use super::protocol::ServerMessage;
use super::state::{State, StateError, bounded};
use super::worker::or_panicked;
use trocar_core::time::TickGrid;
use trocar_document::figure::Shade;
use trocar_engine::engine::{Observer, Signals};
use trocar_engine::operator::Hand;
use trocar_figures::{self as figures, FigureError, RunView};
use trocar_metrics::HORIZON_S;
use trocar_scenario::{OperatorSpec, Scenario};
use trocar_studies::animation::{DrawnTissue, LiveDrawing, LiveMoment, animation};
use trocar_studies::compare::verdict_of_schemes;
use trocar_studies::run::{Run, RunError, event_shade, observe, run};

/// Interval of messages to the page.
const FRAME: Duration = Duration::from_micros(16_667);

/// Maximum lag of the engine behind real time. The engine does not catch up on a larger lag.
const MAX_LAG: Duration = Duration::from_millis(100);

/// Maximum sleep between two checks of the stop flag, because a tick can be long.
const MAX_SLEEP: Duration = Duration::from_millis(50);

/// Additional range of the hand, as a fraction of the travel of the scenario's operator.
const EXTRA_TRAVEL: f64 = 0.15;

/// Maximum duration of an insertion by hand, in s.
const MAX_DURATION_S: f64 = 60.0;

/// Time for which the hand rests at the end of a repeated insertion, in s: the horizon of the reported advances.
const REST_S: f64 = HORIZON_S + 0.1;

const RESULT_INTERVALS: usize = 1000;

#[derive(Debug)]
pub(super) struct Push {
    hand: Arc<Hand>,
    stop: Arc<AtomicBool>,
    range_m: (f64, f64),
}

impl Push {
    /// Starts an insertion by hand.
    pub(super) fn begin(
        id: u32,
        (state, augmented): (&State, bool),
        maker: &mut PairMaker,
        (answers, permit): (Sender<ServerMessage>, Arc<OwnedSemaphorePermit>),
    ) -> Result<Self, StateError> {
        let [classical, scenario] = [false, true].map(|enabled| by_hand(state, enabled, maker));
        let both = [classical?, scenario?];
        let scenario = both[usize::from(augmented)].clone();
        let range_m = range_m(&scenario);
        let hand = Arc::new(Hand::new(range_m.0));
        let stop = Arc::new(AtomicBool::new(false));
        let pacer = Pacer::new(id, &scenario, hand.clone(), stop.clone(), answers.clone());
        let opening = Opening::new(&scenario, augmented, range_m).message(id);
        let thread_hand = hand.clone();
        let started = std::thread::Builder::new().name("trocar push".into()).spawn(move || {
            let _permit = permit;
            if answers.blocking_send(opening).is_err() {
                return;
            }
            let mut pacer = pacer;
            pacer.start();
            let scenario = scenario.held_by(thread_hand);
            let outcome = || match observe(&scenario, &mut pacer).and_then(|_| replayed(both, &pacer.desired_m)) {
                Ok(runs) => result(id, &runs).unwrap_or_else(|error| ServerMessage::refused(id, &error)),
                Err(error) => ServerMessage::refused(id, &error),
            };
            let _ = answers.blocking_send(or_panicked(id, outcome));
        });
        match started {
            Ok(_) => Ok(Self { hand, stop, range_m }),
            Err(error) => Err(StateError::Thread(error)),
        }
    }

    pub(super) fn aim(&self, position_m: f64) {
        if position_m.is_finite() {
            self.hand.aim(position_m.clamp(self.range_m.0, self.range_m.1));
        }
    }
}

impl Drop for Push {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
    }
}

#[derive(Debug)]
struct Opening(serde_json::Value);

impl Opening {
    fn new(scenario: &Scenario, augmented: bool, range_m: (f64, f64)) -> Self {
        let (grid, tissue) = (scenario.grid, DrawnTissue::of_scenario(scenario));
        let mut drawing = LiveDrawing::new(scenario, range_m);
        Self(json!({
            "type": "pushing", "augmented": augmented, "range_mm": [1e3 * range_m.0, 1e3 * range_m.1],
            "position_scale": scenario.position_scale(),
            "heights": drawing.heights(), "drawing": drawing.frame(&LiveMoment {
                tip_mm: 1e3 * scenario.position_scale() * range_m.0,
                master_mm: 1e3 * range_m.0,
                tops_mm: tissue.depths_mm(),
                torn: &tissue.torn(),
                ..LiveMoment::default()
            }),
            "figure": teleoperation_axes(augmented).ok(), "lines": LINES,
            "shades": [event_shade(scenario.augmentation.hold).css(), Shade::Reengaging.css()], "tick_s": grid.tick_s(), "longest_s": grid.time_s(grid.ticks()),
        }))
    }

    fn message(&self, id: u32) -> ServerMessage {
        let mut message = self.0.clone();
        message["id"] = id.into();
        ServerMessage::json(&message)
    }
}

/// A message with the rows and events since the last message, and the drawing of the last row. `tops_mm` are the tops
/// of the layers; `torn` is true for ruptured layers.
fn moved(
    id: u32,
    (rows, events): (&[Row], &[(f64, &'static str)]),
    (tops_mm, torn): (&[f64], &[bool]),
    drawing: &mut LiveDrawing,
) -> ServerMessage {
    let drawing = rows.last().map(|row| {
        let [time_s, _, master_mm, tip_mm, _, _, mode, felt_n] = row.map(f64::from);
        let ruptures = events.iter().any(|(_, kind)| *kind == "rupture");
        drawing.frame(&LiveMoment { time_s, tip_mm, master_mm, felt_n, mode: mode as u8, tops_mm, torn, ruptures })
    });
    ServerMessage::json(&json!({
        "type": "moved", "id": id, "columns": COLUMNS, "rows": rows, "events": events, "drawing": drawing,
    }))
}

/// Repeats an insertion by hand with both schemes. `desired_m` has one position per tick, after which the hand rests.
fn replayed(both: [Scenario; 2], desired_m: &[f64]) -> Result<[Run; 2], RunError> {
    let again = |mut scenario: Scenario, enabled: bool| {
        let tick_s = scenario.grid.tick_s();
        let ticks = scenario.grid.ticks().min(desired_m.len() as u64 + (REST_S / tick_s) as u64);
        if let Ok(grid) = TickGrid::new(tick_s, ticks as f64 * tick_s) {
            scenario.grid = grid;
        }
        let last_m = desired_m.last().copied().unwrap_or_default();
        let rest = std::iter::repeat_n(last_m, (ticks as usize + 1).saturating_sub(desired_m.len()));
        scenario.operator = OperatorSpec::Recording(desired_m.iter().copied().chain(rest).collect());
        SCHEMES[usize::from(enabled)].clone_into(&mut scenario.name);
        run(scenario)
    };
    let [classical, augmented] = both;
    Ok([again(classical, false)?, again(augmented, true)?])
}

fn result(id: u32, runs: &[Run; 2]) -> Result<ServerMessage, FigureError> {
    let [classical, augmented] = runs;
    let length = classical.trace.len().max(augmented.trace.len());
    let figure = signals(runs, &(0..length))?.for_page(RESULT_INTERVALS);
    Ok(ServerMessage::json(&json!({
        "type": "pushed",
        "id": id,
        "answer": verdict_of_schemes(classical, augmented).text(),
        "overshoot_mm": runs.each_ref().map(|run| {
            run.metrics.ruptures.iter().map(|one| one.slave_overshoot_m.map(|m| 1e3 * m)).collect::<Vec<_>>()
        }),
        "animation": animation(&[classical, augmented]),
        "figure": figure,
    })))
}

/// The scenario of a state for an insertion by hand. A recorded force becomes a function of depth, because the hand
/// does not follow the recording.
fn by_hand(state: &State, augmented: bool, maker: &mut PairMaker) -> Result<Scenario, StateError> {
    let mut state = state.clone();
    let plain = maker.written(&state, augmented)?;
    let mut set = |key: &str, value: serde_json::Value| drop(state.set.insert(key.to_owned(), value));
    if plain.values().get("tissue.kind").is_some_and(|kind| kind.to_toml().as_str() == Some("recording")) {
        set("tissue.index", "depth".into());
    }
    let duration_s = plain.grid.time_s(plain.grid.ticks());
    // The limit on ticks applies here too, so a shorter tick shortens the insertion.
    let longest_s = MAX_DURATION_S.min((MAX_TICKS - 1) as f64 * plain.grid.tick_s());
    if duration_s < longest_s && plain.values().get("recording.file").is_none() {
        set("simulation.duration_s", longest_s.into());
    }
    bounded(maker.written(&state, augmented)?)
}

/// Range of the hand in m: from the first position of the scenario's operator to a little beyond the deepest.
fn range_m(scenario: &Scenario) -> (f64, f64) {
    let (from_m, to_m) = travel(scenario);
    (from_m, to_m + EXTRA_TRAVEL * (to_m - from_m))
}

fn travel(scenario: &Scenario) -> (f64, f64) {
    match &scenario.operator {
        OperatorSpec::Recording(positions) => {
            let start = positions.first().copied().unwrap_or(0.0);
            (start, positions.iter().copied().fold(start, f64::max))
        }
        OperatorSpec::Ramp { start_m, end_m, .. } => (*start_m, start_m.max(*end_m)),
        OperatorSpec::Hand(hand) => (hand.position_m(), hand.position_m()),
    }
}

struct Pacer {
    id: u32,
    hand: Arc<Hand>,
    stop: Arc<AtomicBool>,
    answers: Sender<ServerMessage>,
    tick: Duration,
    tick_s: f64,
    began: Instant,
    last_sent: Instant,
    rows: Vec<Row>,
    /// The desired positions of the hand in m, one per tick.
    desired_m: Vec<f64>,
    events: Vec<(f64, &'static str)>,
    tissue: DrawnTissue,
    drawing: LiveDrawing,
    is_closed: bool,
}

/// A row of a message; see [`COLUMNS`].
type Row = [f32; COLUMNS.len()];

const COLUMNS: [&str; 8] = [
    "time_s",
    "desired_position_mm",
    "master_position_mm",
    "slave_position_mm",
    "tissue_force_n",
    "feedback_force_n",
    "mode",
    "operator_force_n",
];

/// The columns of the figure's lines by panel: tissue, feedback and felt force; slave and master position.
const LINES: [&[usize]; 2] = [&[4, 5, 7], &[3, 2]];

impl Pacer {
    fn new(
        id: u32,
        scenario: &Scenario,
        hand: Arc<Hand>,
        stop: Arc<AtomicBool>,
        answers: Sender<ServerMessage>,
    ) -> Self {
        let tick_s = scenario.grid.tick_s();
        let now = Instant::now();
        let tick = Duration::from_secs_f64(tick_s);
        let rows = Vec::with_capacity((4.0 * FRAME.as_secs_f64() / tick_s) as usize + 8);
        Self {
            id,
            hand,
            stop,
            answers,
            tick,
            tick_s,
            began: now,
            last_sent: now,
            rows,
            desired_m: Vec::with_capacity(scenario.grid.ticks() as usize + 1),
            events: vec![],
            tissue: DrawnTissue::of_scenario(scenario),
            drawing: LiveDrawing::new(scenario, range_m(scenario)),
            is_closed: false,
        }
    }

    fn start(&mut self) {
        self.began = Instant::now();
        self.last_sent = self.began;
    }

    fn send(&mut self) {
        let tissue = (self.tissue.depths_mm(), &*self.tissue.torn());
        let message = moved(self.id, (&self.rows, &self.events), tissue, &mut self.drawing);
        match self.answers.try_send(message) {
            Ok(()) => {
                self.rows.clear();
                self.events.clear();
            }
            // A slow page gets these rows with the next message; one that is too slow is closed.
            Err(TrySendError::Full(_)) if self.rows.len() < 4096 => {}
            Err(_) => self.is_closed = true,
        }
    }
}

impl Observer<f64> for Pacer {
    fn observe(&mut self, s: &Signals<f64>) {
        let time_s = s.tick as f64 * self.tick_s;
        self.desired_m.push(s.desired_position_m);
        self.rows.push([
            time_s as f32,
            (1e3 * s.desired_position_m) as f32,
            (1e3 * s.master_position_m) as f32,
            (1e3 * s.slave_position_m) as f32,
            s.tissue_force_n as f32,
            s.feedback_force_n as f32,
            f32::from(s.mode.lane(0).code()),
            s.operator_force_n as f32,
        ]);
        if s.ruptured {
            self.tissue.tear(time_s);
            self.events.push((time_s, "rupture"));
        }
        self.tissue.step(time_s, 1e3 * s.slave_position_m);
        if s.alarm_taken {
            self.events.push((time_s, "alarm"));
        }
        self.hand.step(self.tick_s);
        let due = self.began + self.tick.mul_f64((s.tick + 1) as f64);
        let now = Instant::now();
        if now + self.tick > self.last_sent + FRAME {
            self.send();
            self.last_sent = now;
        }
        match due.checked_duration_since(now) {
            Some(mut early) => {
                while !early.is_zero() && !self.is_done() {
                    let sleep = early.min(MAX_SLEEP);
                    std::thread::sleep(sleep);
                    early -= sleep;
                }
            }
            None if now - due > MAX_LAG => self.began += now - due,
            None => {}
        }
    }

    fn is_done(&self) -> bool {
        self.is_closed || self.stop.load(Ordering::Relaxed)
    }
}

fn teleoperation_axes(is_augmented: bool) -> Result<Json, FigureError> {
    let zero: &[f64] = &[0.0];
    let view = RunView {
        name: "",
        is_augmented,
        time_s: zero,
        master_position_m: zero,
        slave_position_m: zero,
        operator_force_n: zero,
        tissue_force_n: zero,
        feedback_force_n: zero,
        mode: &[0],
        event: Shade::Frozen,
        rupture_times_s: vec![].into(),
        alarm_times_s: vec![].into(),
    };
    Ok(figures::comparison(&[view], None)?.for_page(1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::explore::Catalogue;

    /// Moves a hand at 10 mm/s and records its positions.
    struct Script {
        hand: Arc<Hand>,
        tick_s: f64,
        desired_m: Vec<f64>,
        rupture_times_s: Vec<f64>,
    }

    impl Observer<f64> for Script {
        fn observe(&mut self, s: &Signals<f64>) {
            self.desired_m.push(s.desired_position_m);
            self.rupture_times_s.extend(s.ruptured.then_some(s.tick as f64 * self.tick_s));
            self.hand.aim(0.01 * s.tick as f64 * self.tick_s);
            self.hand.step(self.tick_s);
        }

        fn is_done(&self) -> bool {
            self.desired_m.len() > 6000
        }
    }

    #[test]
    fn the_repeated_insertion_has_the_ruptures_of_the_live_one() {
        let mut maker = PairMaker::new(Catalogue::new(None));
        for scenario in ["paper/augmented", "layers/skin-augmented"] {
            let state = State { scenario: format!("builtin:{scenario}.toml"), ..State::default() };
            let both = [false, true].map(|enabled| by_hand(&state, enabled, &mut maker).expect("good"));
            for live in [0, 1] {
                let hand = Arc::new(Hand::new(range_m(&both[live]).0));
                let tick_s = both[live].grid.tick_s();
                let mut script = Script { hand: hand.clone(), tick_s, desired_m: vec![], rupture_times_s: vec![] };
                observe(&both[live].clone().held_by(hand), &mut script).expect("runs");
                let runs = replayed(both.clone(), &script.desired_m).expect("runs");
                let again: Vec<f64> = runs[live].metrics.ruptures.iter().map(|one| one.time_s).collect();
                assert_eq!(again, script.rupture_times_s, "{scenario}, {live}");
                assert!(!again.is_empty());
            }
        }
    }
}
