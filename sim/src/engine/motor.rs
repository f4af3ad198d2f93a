//! A motor that is limited in range and rate and lags behind what it is told, from tick to tick.

use crate::lane::{Lane, by_index};
use crate::plant::MotorStep;

/// What stands between a wanted command and the `N` states of a machine.
#[derive(Debug, Clone, Copy)]
pub(super) struct Motor<L, const N: usize> {
    range: L,
    /// Greatest change from one tick to the next.
    change: L,
    /// Held over the last tick.
    command: L,
    /// Asked of every tick; the answer is that of the whole run, so that a motor without a lag does no more than ask.
    lag: Option<Lag<L, N>>,
}

/// The part of a [`MotorStep`] that concerns what the motor does, and that.
#[derive(Debug, Clone, Copy)]
struct Lag<L, const N: usize> {
    from_actual: [L; N],
    kept: L,
    gained: L,
    actual: L,
}

impl<L: Lane, const N: usize> Motor<L, N> {
    /// A motor that has long been under the command `at_rest`, of a range and a greatest change per tick that are infinite
    /// without a limit, at a machine that moves the first `N` of its side's states.
    pub(super) fn new<const STATES: usize>(
        (range, change): (f64, f64),
        step: &MotorStep<STATES>,
        at_rest: f64,
    ) -> Self {
        let command = L::splat(at_rest.clamp(-range, range));
        let lag = step.from_actual.iter().any(|&effect| effect != 0.0).then(|| Lag {
            from_actual: std::array::from_fn(|i| L::splat(step.from_actual[i])),
            kept: L::splat(step.kept),
            gained: L::splat(step.gained),
            actual: command,
        });
        Self { range: L::splat(range), change: L::splat(change), command, lag }
    }

    /// The command that a wanted one comes to over the next tick.
    #[inline(always)]
    pub(super) fn command(&mut self, wanted: L) -> L {
        let within = wanted.clamp(-self.range, self.range);
        self.command = within.clamp(self.command - self.change, self.command + self.change);
        self.command
    }

    /// Adds to the states at the end of the tick what the motor was still doing at its start, and goes there itself.
    #[inline(always)]
    pub(super) fn follow(&mut self, states: [L; N]) -> [L; N] {
        let Some(lag) = &mut self.lag else { return states };
        let actual = lag.actual;
        lag.actual = lag.kept * actual + lag.gained * self.command;
        by_index!(N, |i| states[i] + lag.from_actual[i] * actual)
    }
}
