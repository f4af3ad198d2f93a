//! What the person wants: the desired position that the arm pulls the master towards.

mod motion;

pub use motion::{insertion_extraction, minimum_jerk, sine};

use std::sync::Arc;

use crate::error::{InvalidValue, finite};
use crate::lane::Lane;

/// How far from 0 a person may go, in m: farther is no insertion, and a run that gets there has diverged.
pub const MOST_POSITION_M: f64 = 1.0;

/// The kinds of intention. The desired position is linear between ticks.
#[derive(Debug, Clone)]
pub enum Operator<L> {
    /// A recorded or computed motion, one position a tick; the last one is held after its end.
    Recording(Arc<[f64]>),
    /// A constant speed from a start to an end.
    Ramp(Ramp<L>),
}

/// `x_d = start + speed · t` until `end` is reached, then `end`.
#[derive(Debug, Clone, Copy)]
pub struct Ramp<L> {
    start: L,
    step: L,
    low: L,
    high: L,
}

impl<L: Lane> Ramp<L> {
    /// A ramp from `start_m` at `speed_m_per_s` (either sign) to `end_m`, on ticks `tick_s` apart.
    ///
    /// # Errors
    /// [`InvalidValue`] naming the argument that is not finite.
    pub fn new(start_m: f64, end_m: f64, speed_m_per_s: f64, tick_s: f64) -> Result<Self, InvalidValue> {
        finite("operator.start_m", start_m)?;
        finite("operator.end_m", end_m)?;
        finite("operator.speed_m_per_s", speed_m_per_s)?;
        Ok(Self {
            start: L::splat(start_m),
            step: L::splat(speed_m_per_s.abs() * (end_m - start_m).signum() * tick_s),
            low: L::splat(start_m.min(end_m)),
            high: L::splat(start_m.max(end_m)),
        })
    }
}

/// The position of a motion at `tick`, in m; the last one is held after its end.
#[inline(always)]
pub fn recorded<L: Lane>(positions: &[f64], tick: u64) -> L {
    let held = || positions.last().copied().unwrap_or(0.0);
    L::splat(positions.get(tick as usize).copied().unwrap_or_else(held))
}

impl<L: Lane> Operator<L> {
    /// The desired position at `tick` in m.
    #[inline(always)]
    pub fn desired_position_m(&self, tick: u64) -> L {
        match self {
            Self::Recording(positions) => recorded(positions, tick),
            Self::Ramp(ramp) => (ramp.start + ramp.step * L::splat(tick as f64)).clamp(ramp.low, ramp.high),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ramp_ends_where_it_should_in_either_direction() {
        let at = |start, end, tick| {
            let ramp = Ramp::<f64>::new(start, end, 0.01, 1e-3).expect("valid");
            Operator::Ramp(ramp).desired_position_m(tick)
        };
        assert_eq!(at(0.0, 0.02, 0), 0.0);
        assert!((at(0.0, 0.02, 500) - 0.005).abs() < 1e-15);
        assert_eq!(at(0.0, 0.02, 5000), 0.02);
        assert!((at(0.02, 0.0, 500) - 0.015).abs() < 1e-15);
        assert_eq!(at(0.02, 0.0, 5000), 0.0);
    }
}
