//! Whether a run swings without decaying.

use super::{RunError, observe};
use crate::augmentation::Mode;
use crate::engine::{Observer, OwnParts, Signals, Trace};
use crate::interrupt;
use crate::metrics::Outcome;
use crate::moments::Moments;
use crate::operator::Operator;
use crate::scenario::Scenario;

/// The part of a run, at its end, that is examined, as a share.
const TAIL: f64 = 0.4;

/// Minimum number of swings in each half of the tail, from a peak to a trough or back.
const MIN_SWINGS: usize = 4;

/// Minimum swing in m, and in steps of the position sensor.
const MIN_SWING_M: f64 = 2e-5;
const MIN_SWING_STEPS: f64 = 2.0;

/// Ratio of the later swings to the earlier ones from which a swing may last.
const LASTING: f64 = 0.8;

/// The same for the difference of two runs. It has no noise, so the limit is closer to 1.
const LASTING_DIFFERENCE: f64 = 0.9;

/// The displacement of the hand, relative to the swing, its duration in s, and the share of the run at which it begins.
const NUDGE: f64 = 0.1;
const NUDGE_S: f64 = 0.1;
const NUDGE_AT: f64 = 0.4;

/// A difference below this share of the displacement has decayed.
const DECAYED: f64 = 1e-6;

/// Minimum number of events in each half of the tail from which they can cause the swing.
const MIN_EVENTS: usize = 2;

/// Ratio of two swings from which one is clearly larger than the other.
const CLEARLY_LARGER: f64 = 3.0;

/// Returns `Oscillating` for a run that completed but swings without decaying, otherwise its outcome.
///
/// # Errors
/// As [`run`](super::run()).
pub(super) fn outcome(scenario: &Scenario, trace: &Trace, outcome: Outcome) -> Result<Outcome, RunError> {
    if outcome != Outcome::Completed {
        return Ok(outcome);
    }
    let positions = RelativePositions::of(scenario, trace);
    Ok(match positions.lasting(scenario) {
        Some(swing) if is_of_the_loop(scenario, trace, &positions, &swing)? => {
            Outcome::Oscillating { frequency_hz: swing.frequency_hz, swing_m: swing.swing_m }
        }
        _ => outcome,
    })
}

/// Records what is read here of a run that is repeated, a sixth of all columns.
struct Positions<'a>(&'a mut Trace);

impl Observer<f64> for Positions<'_> {
    fn observe(&mut self, signals: &Signals<f64>) {
        let Self(trace) = self;
        trace.time_s.push(trace.grid.time_s(signals.tick));
        trace.desired_position_m.push(signals.desired_position_m);
        trace.master_position_m.push(signals.master_position_m);
        trace.slave_position_m.push(signals.slave_position_m);
        trace.mode.push(signals.mode as u8);
    }
}

/// Positions relative to the desired position, in the tail of a run.
struct RelativePositions {
    all: [Vec<f64>; 2],
}

/// A swing.
pub(super) struct Swing {
    pub(super) swing_m: f64,
    pub(super) frequency_hz: f64,
}

/// The swing at the end of a run that does not decay, whatever its cause.
pub(super) fn lasting_swing(scenario: &Scenario, trace: &Trace) -> Option<Swing> {
    RelativePositions::of(scenario, trace).lasting(scenario)
}

impl RelativePositions {
    fn of(scenario: &Scenario, trace: &Trace) -> Self {
        let begin = tail_begin(trace.len());
        let relative = |positions: &[f64], scale: f64| -> Vec<f64> {
            interrupt::check();
            let desired = &trace.desired_position_m[begin..];
            positions[begin..].iter().zip(desired).map(|(position, desired)| position - scale * desired).collect()
        };
        Self {
            all: [
                relative(&trace.slave_position_m, scenario.position_scale()),
                relative(&trace.master_position_m, 1.0),
            ],
        }
    }

    /// Standard deviation of the positions in the second half of the tail, of hand or needle, in m: of the larger.
    fn late_std_m(&self) -> f64 {
        let std_m = |values: &[f64]| {
            interrupt::check();
            let mut moments = Moments::default();
            values.iter().for_each(|value| moments.add(*value));
            moments.variance().sqrt()
        };
        self.all.iter().map(|positions| std_m(&positions[positions.len() / 2..])).fold(0.0, f64::max)
    }

    /// The largest swing that does not become clearly smaller.
    fn lasting(&self, scenario: &Scenario) -> Option<Swing> {
        let min_m = MIN_SWING_M.max(MIN_SWING_STEPS * scenario.sensor.position_resolution_m);
        let tick_s = scenario.grid.tick_s();
        let lasting = self.all.iter().filter_map(|positions| {
            let (early, late) = positions.split_at(positions.len() / 2);
            let frequency_hz = |swings: usize| swings as f64 / (2.0 * late.len() as f64 * tick_s);
            let (early, late) = (swings(early, min_m), swings(late, min_m));
            if early.len().min(late.len()) < MIN_SWINGS {
                return None;
            }
            let frequency_hz = frequency_hz(late.len());
            let (before_m, swing_m) = (median(early)?, median(late)?);
            (swing_m >= LASTING * before_m).then_some(Swing { swing_m, frequency_hz })
        });
        lasting.max_by(|a, b| a.swing_m.total_cmp(&b.swing_m))
    }
}

fn tail_begin(ticks: usize) -> usize {
    ticks - (ticks as f64 * TAIL) as usize
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_unstable_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

/// The changes from each peak to the next trough and back, of at least `min`.
fn swings(values: &[f64], min: f64) -> Vec<f64> {
    interrupt::check();
    let Some(&first) = values.first() else { return vec![] };
    let (mut low, mut high, mut is_rising) = (first, first, None);
    let mut all = vec![];
    for &value in values {
        match is_rising {
            None => {
                (low, high) = (low.min(value), high.max(value));
                if high - low >= min {
                    is_rising = Some(value == high);
                }
            }
            Some(true) => {
                high = high.max(value);
                if high - value >= min {
                    all.push(high - low);
                    (low, is_rising) = (value, Some(false));
                }
            }
            Some(false) => {
                low = low.min(value);
                if value - low >= min {
                    all.push(high - low);
                    (high, is_rising) = (value, Some(true));
                }
            }
        }
    }
    all
}

/// The scenario's operator, displaced for a short time.
struct Nudged<O> {
    operator: O,
    begin: u64,
    ticks: u64,
    nudge_m: f64,
}

impl<O: Operator<f64>> Operator<f64> for Nudged<O> {
    fn desired_position_m(&mut self, tick: u64, felt_n: f64) -> f64 {
        let desired_m = self.operator.desired_position_m(tick, felt_n);
        match tick.checked_sub(self.begin) {
            Some(since) if since <= self.ticks => {
                let share = since as f64 / self.ticks as f64;
                desired_m + 4.0 * self.nudge_m * share * (1.0 - share)
            }
            _ => desired_m,
        }
    }

    fn master(&mut self, position_m: f64) {
        self.operator.master(position_m);
    }

    fn cue(&mut self, is_on: bool) {
        self.operator.cue(is_on);
    }
}

/// Whether the loop and its events cause the swing, not the noise.
///
/// Noise and tremor can hold a swing of the loop in step, so that a displacement of the hand is forgotten; and events that they
/// raise come at other times after a displacement, so that it never is. So a run with them is held against copies first.
fn is_of_the_loop(
    scenario: &Scenario,
    trace: &Trace,
    positions: &RelativePositions,
    swing: &Swing,
) -> Result<bool, RunError> {
    let swing_m = positions.late_std_m();
    if scenario.sensor.force_noise_std_n > 0.0 || scenario.tremor.amplitude_m > 0.0 {
        let mut quiet = scenario.clone();
        quiet.sensor.force_noise_std_n = 0.0;
        quiet.tremor.amplitude_m = 0.0;
        let (is_completed, quiet_m) = end_of(&quiet)?;
        if !is_completed && swing_m * CLEARLY_LARGER > quiet_m {
            return Ok(true);
        }
        if events_recur(trace) {
            let mut plain = scenario.clone();
            plain.augmentation.enabled = false;
            let (is_completed, plain_m) = end_of(&plain)?;
            if is_completed {
                return Ok(swing_m > CLEARLY_LARGER * plain_m);
            }
        }
    }
    is_sustained(scenario, trace, swing)
}

/// Whether events begin several times in each half of the tail.
fn events_recur(trace: &Trace) -> bool {
    let tail = &trace.mode[tail_begin(trace.len())..];
    let augmented = Mode::Augmented as u8;
    let begins = |modes: &[u8]| modes.windows(2).filter(|pair| pair[0] != augmented && pair[1] == augmented).count();
    let (early, late) = tail.split_at(tail.len() / 2);
    begins(early).min(begins(late)) >= MIN_EVENTS
}

/// Whether a scenario's run completes without a lasting swing, and the standard deviation at its end in m.
fn end_of(scenario: &Scenario) -> Result<(bool, f64), RunError> {
    let mut trace = Trace::new(scenario.grid);
    let metrics = observe(scenario, &mut Positions(&mut trace))?;
    let is_completed = outcome(scenario, &trace, metrics.outcome)? == Outcome::Completed;
    Ok((is_completed, RelativePositions::of(scenario, &trace).late_std_m()))
}

/// Whether a short displacement of the hand has a lasting effect: whether the loop sustains the swing.
fn is_sustained(scenario: &Scenario, trace: &Trace, swing: &Swing) -> Result<bool, RunError> {
    let nudge_m = NUDGE * swing.swing_m;
    let operator = Nudged {
        operator: scenario.human_operator()?,
        begin: (NUDGE_AT * trace.len() as f64) as u64,
        ticks: ((NUDGE_S / scenario.grid.tick_s()) as u64).max(2),
        nudge_m,
    };
    let mut other = Trace::new(scenario.grid);
    let integration = |source| RunError::Engine { name: scenario.name.clone(), source };
    scenario
        .build_with(OwnParts::default().operator(operator))?
        .run_wide(&mut Positions(&mut other))
        .map_err(integration)?;
    let begin = tail_begin(trace.len());
    if other.len() < trace.len() {
        return Ok(true);
    }
    let speeds = |positions: &[f64], others: &[f64]| -> Vec<f64> {
        let difference: Vec<f64> = positions[begin..].iter().zip(&others[begin..]).map(|(a, b)| b - a).collect();
        difference.windows(2).map(|pair| pair[1] - pair[0]).collect()
    };
    // Of the differences of positions between ticks: a lasting offset, as after a cut, is no swing.
    let sides = [
        speeds(&trace.slave_position_m, &other.slave_position_m),
        speeds(&trace.master_position_m, &other.master_position_m),
    ];
    let rms = |values: &[f64]| (values.iter().map(|value| value * value).sum::<f64>() / values.len() as f64).sqrt();
    Ok(sides.iter().any(|side| {
        let (early, late) = side.split_at(side.len() / 2);
        let (before, after) = (rms(early), rms(late));
        // NaN, from a run that diverged, counts as lasting.
        !(after < LASTING_DIFFERENCE * before || after < DECAYED * nudge_m)
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wave(amplitude: impl Fn(f64) -> f64) -> Vec<f64> {
        (0..2000).map(|k| f64::from(k) * 1e-3).map(|t| amplitude(t) * (20.0 * t).sin()).collect()
    }

    #[test]
    fn swings_go_from_peak_to_trough() {
        let all = swings(&wave(|_| 0.5e-3), 1e-4);
        assert!(all.len() >= 11 && all.iter().skip(1).all(|swing| (swing - 1e-3).abs() < 1e-6), "{all:?}");
        assert!(swings(&wave(|_| 1e-5), 1e-4).is_empty());
        assert!(swings(&[0.0; 100], 1e-4).is_empty() && swings(&[], 1e-4).is_empty());
        let drift: Vec<f64> = (0..1000).map(|k| f64::from(k) * 1e-5).collect();
        assert!(swings(&drift, 1e-4).is_empty(), "a drift does not reverse");
    }
}
