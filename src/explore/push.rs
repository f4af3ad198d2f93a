//! An insertion by hand: the pointer sets the desired position of the master.
//!
//! The page sends the pointer at each frame of its screen, and the run continues up to the present time.

use serde_json::{Value as Json, json};

use super::frame::signals;
use super::limits::MAX_TICKS;
use super::pair::{PairMaker, SCHEMES};
use super::protocol::ServerMessage;
use super::state::{State, StateError, bounded};
use trocar_core::time::TickGrid;
use trocar_document::figure::Shade;
use trocar_engine::engine::UserDefinedParts;
use trocar_figures::{self as figures, FigureError, RunView};
use trocar_metrics::HORIZON_S;
use trocar_scenario::{OperatorSpec, Scenario};
use trocar_studies::animation::{DrawnTissue, LiveDrawing, LiveMoment, animation};
use trocar_studies::compare::verdict_of_schemes;
use trocar_studies::run::{Run, RunError, SteppedRun, event_shade, run};

/// Lag behind real time in s. The run does not catch up on a larger lag.
const MAX_LAG_S: f64 = 0.1;

/// As a fraction of the travel of the scenario's operator.
const EXTRA_TRAVEL: f64 = 0.15;

/// Maximum duration of an insertion by hand, in s.
const MAX_DURATION_S: f64 = 60.0;

/// In s, after a repeated insertion: the horizon of the reported advances.
const REST_S: f64 = HORIZON_S + 0.1;

const RESULT_INTERVALS: usize = 1000;

/// In 1/s. Aims are set 60 times a second; the hand must not jump between them.
const APPROACH_PER_S: f64 = 60.0;

/// That of a stab. Prevents an impact when the pointer jumps.
const MAX_SPEED_M_PER_S: f64 = 0.5;

#[derive(Debug)]
struct Hand {
    position_m: f64,
    aim_m: f64,
}

impl Hand {
    /// Moves towards the aim by a fraction of the distance, at most at the maximum speed.
    fn step(&mut self, tick_s: f64) {
        let way_m = self.aim_m - self.position_m;
        let max_step_m = MAX_SPEED_M_PER_S * tick_s;
        self.position_m += ((APPROACH_PER_S * tick_s).min(1.0) * way_m).clamp(-max_step_m, max_step_m);
    }
}

#[derive(Debug)]
pub(super) struct Push {
    pub(super) id: u32,
    /// Classical, augmented.
    both: [Scenario; 2],
    run: SteppedRun,
    hand: Hand,
    range_m: (f64, f64),
    /// The time of tick 0, in s.
    began_s: f64,
    tissue: DrawnTissue,
    drawing: LiveDrawing,
    /// Ticks, ruptures and alarms that the page has received.
    sent: [usize; 3],
}

impl Push {
    /// Begins an insertion by hand at a time in s. Also returns the message that opens it on the page.
    pub(super) fn begin(
        id: u32,
        (state, augmented): (&State, bool),
        maker: &mut PairMaker,
        now_s: f64,
    ) -> Result<(Self, ServerMessage), StateError> {
        let [classical, scenario] = [false, true].map(|enabled| by_hand(state, enabled, maker));
        let both = [classical?, scenario?];
        let scenario = both[usize::from(augmented)].clone();
        let range_m = range_m(&scenario);
        let tissue = DrawnTissue::of_scenario(&scenario);
        let mut drawing = LiveDrawing::new(&scenario, range_m);
        let opening = opening(id, (&scenario, augmented), range_m, (&tissue, &mut drawing));
        let run = SteppedRun::new(scenario, UserDefinedParts::default())?;
        let hand = Hand { position_m: range_m.0, aim_m: range_m.0 };
        Ok((Self { id, both, run, hand, range_m, began_s: now_s, tissue, drawing, sent: [0; 3] }, opening))
    }

    pub(super) fn aim(&mut self, position_m: f64) {
        if position_m.is_finite() {
            self.hand.aim_m = position_m.clamp(self.range_m.0, self.range_m.1);
        }
    }

    /// Runs the ticks up to a time in s.
    fn advance(&mut self, now_s: f64) -> Result<(), RunError> {
        let tick_s = self.run.scenario().grid.tick_s();
        let due_s = |run: &SteppedRun| run.ticks() as f64 * tick_s;
        self.began_s = self.began_s.max(now_s - due_s(&self.run) - MAX_LAG_S);
        while !self.run.has_ended() && self.began_s + due_s(&self.run) <= now_s {
            self.hand.step(tick_s);
            self.run.step(Some(self.hand.position_m))?;
        }
        Ok(())
    }

    /// Runs up to a time in s. Returns signals, events and the drawing of the last tick; `None` if the run has ended
    /// before.
    pub(super) fn moved(&mut self, now_s: f64) -> Result<Option<ServerMessage>, StateError> {
        if self.run.has_ended() {
            return Ok(None);
        }
        self.advance(now_s)?;
        let [ticks, ruptures, alarms] = self.sent;
        let (trace, metrics) = (self.run.trace(), self.run.metrics());
        let ruptures_s: Vec<f64> = metrics.ruptures[ruptures..].iter().map(|one| one.time_s).collect();
        let alarms_s = metrics.alarms[alarms..].iter().map(|one| one.time_s);
        for (time_s, position_m) in trace.time_s.iter().zip(&trace.slave_position_m).skip(ticks) {
            if ruptures_s.contains(time_s) {
                self.tissue.tear(*time_s);
            }
            self.tissue.step(*time_s, 1e3 * position_m);
        }
        let drawing = (trace.len() > ticks).then(|| {
            let last = trace.len() - 1;
            self.drawing.frame(&LiveMoment {
                time_s: trace.time_s[last],
                tip_mm: 1e3 * trace.slave_position_m[last],
                master_mm: 1e3 * trace.master_position_m[last],
                felt_n: trace.operator_force_n[last],
                mode: trace.mode[last],
                tops_mm: self.tissue.depths_mm(),
                torn: &self.tissue.torn(),
                ruptures: !ruptures_s.is_empty(),
            })
        });
        let rows: Vec<Row> = (ticks..trace.len())
            .map(|tick| {
                [
                    trace.time_s[tick] as f32,
                    (1e3 * trace.desired_position_m[tick]) as f32,
                    (1e3 * trace.master_position_m[tick]) as f32,
                    (1e3 * trace.slave_position_m[tick]) as f32,
                    trace.tissue_force_n[tick] as f32,
                    trace.feedback_force_n[tick] as f32,
                    f32::from(trace.mode[tick]),
                    trace.operator_force_n[tick] as f32,
                ]
            })
            .collect();
        let ruptures = ruptures_s.iter().map(|time_s| (*time_s, "rupture"));
        let events: Vec<_> = ruptures.chain(alarms_s.map(|time_s| (time_s, "alarm"))).collect();
        self.sent = [trace.len(), metrics.ruptures.len(), metrics.alarms.len()];
        Ok(Some(ServerMessage::json(&json!({
            "type": "moved", "id": self.id, "columns": COLUMNS, "rows": rows, "events": events, "drawing": drawing,
        }))))
    }

    /// Repeats the motion with both schemes.
    pub(super) fn result(self) -> Result<ServerMessage, StateError> {
        Ok(result(self.id, &replayed(self.both, &self.run.trace().desired_position_m)?)?)
    }
}

fn opening(
    id: u32,
    (scenario, augmented): (&Scenario, bool),
    range_m: (f64, f64),
    (tissue, drawing): (&DrawnTissue, &mut LiveDrawing),
) -> ServerMessage {
    let grid = scenario.grid;
    ServerMessage::json(&json!({
        "type": "pushing", "id": id, "augmented": augmented, "range_mm": [1e3 * range_m.0, 1e3 * range_m.1],
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

/// `desired_m` has one position per tick, after which the hand rests.
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

/// A recorded force becomes a function of depth, because the hand does not follow the recording.
fn by_hand(state: &State, augmented: bool, maker: &mut PairMaker) -> Result<Scenario, StateError> {
    let mut state = state.clone();
    let plain = maker.written(&state, augmented)?;
    let mut set = |key: &str, value: serde_json::Value| drop(state.set.insert(key.to_owned(), value));
    if plain.values().get("tissue.kind").is_some_and(|kind| kind.to_toml().as_str() == Some("recording")) {
        set("tissue.index", "depth".into());
    }
    let duration_s = plain.grid.time_s(plain.grid.ticks());
    // The limit on ticks shortens the insertion.
    let longest_s = MAX_DURATION_S.min((MAX_TICKS - 1) as f64 * plain.grid.tick_s());
    if duration_s < longest_s && plain.values().get("recording.file").is_none() {
        set("simulation.duration_s", longest_s.into());
    }
    bounded(maker.written(&state, augmented)?)
}

/// Reaches from the operator's first position to a little beyond the deepest, in m.
fn range_m(scenario: &Scenario) -> (f64, f64) {
    let (from_m, to_m) = match &scenario.operator {
        OperatorSpec::Recording(positions) => {
            let start = positions.first().copied().unwrap_or(0.0);
            (start, positions.iter().copied().fold(start, f64::max))
        }
        OperatorSpec::Ramp { start_m, end_m, .. } => (*start_m, start_m.max(*end_m)),
    };
    (from_m, to_m + EXTRA_TRAVEL * (to_m - from_m))
}

/// See [`COLUMNS`].
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

/// By panel: tissue, feedback and felt force; slave and master position.
const LINES: [&[usize]; 2] = [&[4, 5, 7], &[3, 2]];

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

    #[test]
    fn a_hand_moves_to_its_aim_at_no_more_than_the_maximum_speed() {
        let mut hand = Hand { position_m: 0.0, aim_m: 0.05 };
        let mut fastest = 0.0_f64;
        for _ in 0..400 {
            let before = hand.position_m;
            hand.step(1e-3);
            fastest = fastest.max(hand.position_m - before);
        }
        assert!((hand.position_m - 0.05).abs() < 1e-6);
        assert!((fastest - 0.5e-3).abs() < 1e-15);
        // Near the aim, 60 per s for 1 ms.
        let mut hand = Hand { position_m: 0.1, aim_m: 0.104 };
        hand.step(1e-3);
        assert!((hand.position_m - 0.10024).abs() < 1e-15, "{}", hand.position_m);
        hand.step(1.0);
        assert_eq!(hand.position_m, 0.104, "at most all of it");
    }

    /// Begins an insertion at 0 s.
    fn begun(scenario: &str, augmented: bool) -> Push {
        let state = State { scenario: format!("builtin:{scenario}.toml"), ..State::default() };
        let mut maker = PairMaker::new(Catalogue::new(None));
        Push::begin(1, (&state, augmented), &mut maker, 0.0).expect("good").0
    }

    #[test]
    fn a_run_follows_the_time_but_does_not_catch_up_on_a_large_lag() {
        let mut push = begun("layers/skin-augmented", true);
        for (now_s, ticks) in [(0.0, 1), (0.0, 1), (0.0505, 51), (10.0, 151), (10.0205, 171)] {
            push.aim(f64::NAN);
            push.moved(now_s).expect("runs").expect("goes on");
            assert!(push.run.ticks().abs_diff(ticks) <= 1, "{} at {now_s} s", push.run.ticks());
        }
        push.aim(f64::MAX);
        assert_eq!(push.hand.aim_m, push.range_m.1, "the travel is bounded");
    }

    #[test]
    fn the_repeated_insertion_has_the_ruptures_of_the_live_one() {
        for scenario in ["paper/augmented", "layers/skin-augmented"] {
            for live in [0, 1] {
                let mut push = begun(scenario, live == 1);
                // At 10 mm/s for 6 s, with 60 frames per second.
                for frame in 0..=360 {
                    let now_s = f64::from(frame) / 60.0;
                    push.aim(push.range_m.0 + 0.01 * now_s);
                    push.advance(now_s).expect("runs");
                }
                let times = |ruptures: &[trocar_metrics::RuptureMetrics]| -> Vec<f64> {
                    ruptures.iter().map(|one| one.time_s).collect()
                };
                let felt = times(&push.run.metrics().ruptures);
                let runs = replayed(push.both, &push.run.trace().desired_position_m).expect("runs");
                assert_eq!(times(&runs[live].metrics.ruptures), felt, "{scenario}, {live}");
                assert!(!felt.is_empty());
            }
        }
    }
}
