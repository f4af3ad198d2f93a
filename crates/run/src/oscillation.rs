use super::RunError;
use super::at_rest::AtRest;
use super::swings::{median, range, strength, swings};
use trocar_base::interrupt;
use trocar_engine::engine::Trace;
use trocar_metrics::Outcome;
use trocar_scenario::{EngineKind, Scenario};

const TAIL: f64 = 0.4;

/// In each half of the tail; a swing goes from peak to trough or back.
const MIN_SWINGS: usize = 4;

/// In m, and in steps of the position sensor.
const MIN_SWING_M: f64 = 2e-5;
const MIN_SWING_STEPS: f64 = 2.0;

/// Minimum ratio of the later to the earlier strength in the tail.
const LASTING: f64 = 0.8;

const MIN_WINDOW_SWINGS: usize = 8;

/// Logarithmic decays between windows below which the strength is constant, or may approach a constant.
const STAYS: f64 = 1e-3;
const APPROACHES: f64 = 0.05;

/// For the long windows at the end of the longest rest.
const STAYS_AT_LAST: f64 = 1e-2;

/// Ratio of two consecutive decays below which the decay ends: 1 for an exponential decay, smaller on the way to a
/// limit cycle.
const ENDS: f64 = 0.3;

/// With random losses: minimum ratio of the last window to the first.
const LASTING_AT_RANDOM: f64 = 0.5;

/// Minimum ratio to the oscillation at the end of the run, which can decay to a smaller one.
const PART_OF_SEEN: f64 = 0.5;

/// In multiples of the shortest: in general, with random losses, with a slow engine; and in ticks.
const MAX_REST: u64 = 64;
const MAX_RANDOM_REST: u64 = 8;
const MAX_SLOW_REST: u64 = 4;
const MAX_REST_TICKS: u64 = 400_000;

/// In events and in round trips of the link.
const REST_EVENTS: f64 = 4.0;
const REST_ROUND_TRIPS: u64 = 8;

#[derive(Debug, Clone, Copy)]
pub struct Swing {
    pub swing_m: f64,
    pub frequency_hz: f64,
}

/// `Oscillating` for a completed run that oscillates without decaying, else its outcome.
///
/// The loop sustains what continues without excitation, so the run is continued with the hand at rest.
pub(super) fn outcome(scenario: &Scenario, trace: &Trace, outcome: Outcome) -> Result<Outcome, RunError> {
    if outcome != Outcome::Completed || trace.is_empty() {
        return Ok(outcome);
    }
    let swing = sustained_swing(scenario, trace)?;
    Ok(swing.map_or(outcome, |Swing { frequency_hz, swing_m }| Outcome::Oscillating { frequency_hz, swing_m }))
}

/// The swing that does not decay at the end of a run.
pub fn lasting_swing(scenario: &Scenario, trace: &Trace) -> Option<Swing> {
    Tail::of(scenario, trace).lasting()
}

struct Tail {
    relative_m: [Vec<f64>; 2],
    tick_s: f64,
    min_m: f64,
}

impl Tail {
    fn of(scenario: &Scenario, trace: &Trace) -> Self {
        let begin = tail_begin(trace.len());
        let relative = |positions: &[f64], scale: f64| -> Vec<f64> {
            interrupt::check();
            let desired = &trace.desired_position_m[begin..];
            positions[begin..].iter().zip(desired).map(|(position, desired)| position - scale * desired).collect()
        };
        Self {
            relative_m: [
                relative(&trace.slave_position_m, scenario.position_scale()),
                relative(&trace.master_position_m, 1.0),
            ],
            tick_s: scenario.grid.tick_s(),
            min_m: MIN_SWING_M.max(MIN_SWING_STEPS * scenario.sensor.position_resolution_m),
        }
    }

    fn may_swing(&self) -> bool {
        self.relative_m.iter().any(|positions| {
            let (_, late) = positions.split_at(positions.len() / 2);
            range(late) >= self.min_m && !swings(positions, self.min_m).is_empty()
        })
    }

    fn lasting(&self) -> Option<Swing> {
        let lasting = self.relative_m.iter().filter_map(|positions| {
            let (early, late) = positions.split_at(positions.len() / 2);
            let is_lasting = strength(late) >= LASTING * strength(early);
            swing_of(early, self.tick_s, self.min_m, MIN_SWINGS)?;
            swing_of(late, self.tick_s, self.min_m, MIN_SWINGS).filter(|_| is_lasting)
        });
        larger(lasting)
    }

    fn late(&self) -> Option<Swing> {
        let late =
            |positions: &Vec<f64>| swing_of(&positions[positions.len() / 2..], self.tick_s, self.min_m, MIN_SWINGS);
        larger(self.relative_m.iter().filter_map(late))
    }
}

fn larger(swings: impl Iterator<Item = Swing>) -> Option<Swing> {
    swings.max_by(|a, b| a.swing_m.total_cmp(&b.swing_m))
}

fn swing_of(positions: &[f64], tick_s: f64, min_m: f64, min_count: usize) -> Option<Swing> {
    let all = swings(positions, min_m);
    if all.len() < min_count {
        return None;
    }
    let frequency_hz = all.len() as f64 / (2.0 * positions.len() as f64 * tick_s);
    Some(Swing { swing_m: median(all)?, frequency_hz })
}

fn tail_begin(ticks: usize) -> usize {
    ticks - (ticks as f64 * TAIL) as usize
}

/// The hand rests at its last position, which may be outside the tissue. A second trial therefore rests it at its
/// deepest position in the second half of the tail, and counts only if the run itself oscillated with at least half of
/// its frequency and [`PART_OF_SEEN`] of its size.
fn sustained_swing(scenario: &Scenario, trace: &Trace) -> Result<Option<Swing>, RunError> {
    let tail = Tail::of(scenario, trace);
    if !tail.may_swing() {
        return Ok(None);
    }
    let end = trace.len();
    let late = (tail_begin(end) + end) / 2;
    let desired_m = &trace.desired_position_m[late..];
    let is_moving = range(desired_m) >= tail.min_m;
    if let Some(swing) = swing_at_rest(scenario, trace, end, &tail)? {
        let seen = tail.late().filter(|seen| !is_moving && swing.swing_m >= PART_OF_SEEN * seen.swing_m);
        return Ok(Some(seen.unwrap_or(swing)));
    }
    let deepest = desired_m.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1));
    let Some((deepest, seen)) = deepest.filter(|_| is_moving).map(|(index, _)| late + index).zip(tail.lasting()) else {
        return Ok(None);
    };
    let swing = swing_at_rest(scenario, trace, deepest, &tail)?;
    let is_cause =
        |swing: &Swing| 2.0 * seen.frequency_hz >= swing.frequency_hz && seen.swing_m >= PART_OF_SEEN * swing.swing_m;
    Ok(swing.filter(is_cause))
}

fn swing_at_rest(scenario: &Scenario, trace: &Trace, rest: usize, tail: &Tail) -> Result<Option<Swing>, RunError> {
    let length = RestLength::of(scenario);
    let mut run = AtRest::new(scenario, rest as u64, tail_begin(trace.len()) as u64, length.max)?;
    let mut ticks = length.min;
    loop {
        run.extend_to(ticks);
        let is_last = ticks >= length.max;
        let lasts = match run.has_ended {
            // A divergence without an oscillation is a drift.
            true => Some(run.positions_m.iter().any(|positions| !swings(positions, tail.min_m).is_empty())),
            false => lasts(&run.positions_m, tail.min_m, is_last, length.is_random),
        };
        if let Some(lasts) = lasts {
            let last = |positions: &Vec<f64>| {
                let last = &positions[positions.len() - positions.len() / 4..];
                swing_of(last, tail.tick_s, tail.min_m, 2).or_else(|| swing_of(positions, tail.tick_s, tail.min_m, 1))
            };
            return Ok(larger(run.positions_m.iter().filter_map(last)).filter(|_| lasts));
        }
        ticks = (2 * ticks).min(length.max);
    }
}

/// Ticks; the minimum is doubled until the result is clear.
struct RestLength {
    min: u64,
    max: u64,
    is_random: bool,
}

impl RestLength {
    fn of(scenario: &Scenario) -> Self {
        let (tick_s, ticks) = (scenario.grid.tick_s(), scenario.grid.ticks());
        let augmentation = &scenario.augmentation;
        let events = &augmentation.automaton;
        let event_s = if augmentation.enabled { events.max_hold_s + events.refractory_s } else { 0.0 };
        let delays = scenario.longest_delays_ticks().into_iter().sum::<u64>();
        let wanted = ((REST_EVENTS * event_s / tick_s) as u64).max(REST_ROUND_TRIPS * delays);
        let min = ticks.max(wanted.min(MAX_REST_TICKS / MAX_REST));
        let is_random = !scenario.irregularity.is_none()
            || scenario.forward_schedule.has_delays()
            || scenario.backward_schedule.has_delays();
        let is_slow = scenario.engine == EngineKind::Dop853;
        let longest = match (is_slow, is_random) {
            (true, _) => MAX_SLOW_REST,
            (false, true) => MAX_RANDOM_REST,
            (false, false) => MAX_REST,
        };
        Self { min, max: (longest * min).min(MAX_REST_TICKS).max(2 * min), is_random }
    }
}

/// `None` if a longer rest is needed. Compares the last three quarters of the rest: motion caused by the hand decays in
/// the first one.
fn lasts(positions_m: &[Vec<f64>; 2], min_m: f64, is_last: bool, is_random: bool) -> Option<bool> {
    let window = positions_m[0].len() / 4;
    let windows = positions_m.each_ref().map(|positions| [1, 2, 3].map(|k| &positions[k * window..(k + 1) * window]));
    let moving: Vec<_> = windows.iter().filter(|windows| range(windows[2]) >= min_m).collect();
    if moving.is_empty() {
        return Some(false);
    }
    let is_lasting = |windows: &&[&[f64]; 3]| {
        let counts = windows.map(|window| swings(window, min_m).len());
        let [first, second, third] = windows.map(strength);
        if is_random {
            return is_last && counts[2] >= MIN_SWINGS && third >= LASTING_AT_RANDOM * first;
        }
        let (before, change) = ((second / first).ln(), (third / second).ln());
        let approaches = before.min(change) > -APPROACHES && change > ENDS * before.min(0.0);
        match is_last {
            false => {
                counts.iter().all(|count| *count >= MIN_WINDOW_SWINGS)
                    && before > -APPROACHES
                    && (change > -STAYS || approaches)
            }
            true => counts[2] >= 2 && (change > -STAYS_AT_LAST || approaches),
        }
    };
    let any = moving.iter().any(is_lasting);
    (any || is_last).then_some(any)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn verdict(strength: impl Fn(f64) -> f64, is_last: bool) -> Option<bool> {
        let signal: Vec<f64> =
            (0..40_000).map(|k| f64::from(k) * 1e-3).map(|t| strength(t) * (30.0 * t).sin()).collect();
        lasts(&[signal, vec![0.0; 40_000]], 1e-5, is_last, false)
    }

    #[test]
    fn a_constant_swing_lasts_and_a_decaying_one_does_not() {
        for is_last in [false, true] {
            assert_eq!(verdict(|_| 1e-3, is_last), Some(true));
            assert_eq!(verdict(|t| 1e-3 * (-t).exp(), is_last), Some(false));
            assert_eq!(verdict(|t| 1e-5 * (0.1 * t).exp(), is_last), Some(true), "it grows");
            assert_eq!(verdict(|t| 1e-3 + 1e-4 * (-0.3 * t).exp(), is_last), Some(true), "it approaches a cycle");
        }
        // A longer rest shows slow decays clearly.
        for slow in [0.01, 0.001] {
            assert_eq!(verdict(|t| 1e-3 * (-slow * t).exp(), false), None, "{slow}");
        }
        assert_eq!(verdict(|t| 1e-3 * (-0.01 * t).exp(), true), Some(false));
        assert_eq!(verdict(|t| 1e-3 / (1.0 + t), true), Some(false), "a decay that is not exponential");
    }
}
