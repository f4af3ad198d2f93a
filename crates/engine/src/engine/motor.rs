use crate::plant::MotorStep;
use trocar_core::lane::{Lane, by_index};

#[derive(Debug, Clone, Copy)]
pub(super) struct Motor<L, const N: usize> {
    range: L,
    change: L,
    command: L,
    lag: Option<Lag<L, N>>,
}

#[derive(Debug, Clone, Copy)]
struct Lag<L, const N: usize> {
    from_actual: [L; N],
    kept: L,
    gained: L,
    actual: L,
}

impl<L: Lane, const N: usize> Motor<L, N> {
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

    #[inline(always)]
    pub(super) fn command(&mut self, wanted: L) -> L {
        let within = wanted.clamp(-self.range, self.range);
        self.command = within.clamp(self.command - self.change, self.command + self.change);
        self.command
    }

    #[inline(always)]
    pub(super) fn follow(&mut self, states: [L; N]) -> [L; N] {
        let Some(lag) = &mut self.lag else { return states };
        let actual = lag.actual;
        lag.actual = lag.kept * actual + lag.gained * self.command;
        by_index!(N, |i| states[i] + lag.from_actual[i] * actual)
    }
}
