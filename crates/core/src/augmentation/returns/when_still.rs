use super::{BuiltIn, Return, ReturnMap, ReturnTick, closed_by};
use crate::lane::Lane;

crate::settings! {
    /// Settings of [`WhenStill`].
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct WhenStillSettings in "augmentation." {
        /// Speed of the hand into the tissue, averaged over 0.2 s, below which the gap closes.
        still_speed_m_per_s: f64 [NON_NEGATIVE] = 0.001,
        /// Speed at which the gap closes while the hand stands still.
        return_speed_m_per_s: f64 [POSITIVE] = 0.005,
    }
}

/// Longer than a period of tremor (8 to 12 Hz), shorter than a pause.
const AVERAGE_S: f64 = 0.2;

/// While the hand's average speed `v` is low, `gap = gap⁻ - clamp(gap⁻, -c T, c T)`, `c = return speed + max(-v, 0)`,
/// also in teleoperation: a hand that moves back closes the gap itself.
#[derive(Debug, Clone)]
pub struct WhenStill<L> {
    still_step: L,
    return_step: L,
    share: L,
    mean_step: L,
}

impl<L: Lane> BuiltIn for WhenStill<L> {
    type Settings = WhenStillSettings;
    type Map = ReturnMap;

    fn build(settings: &WhenStillSettings, tick_s: f64) -> Self {
        Self {
            still_step: L::splat(settings.still_speed_m_per_s * tick_s),
            return_step: L::splat(settings.return_speed_m_per_s * tick_s),
            share: L::splat(1.0 - libm::exp(-tick_s / AVERAGE_S)),
            mean_step: L::zero(),
        }
    }
}

impl<L: Lane> Return<L> for WhenStill<L> {
    const CONTINUES: bool = true;

    #[inline(always)]
    fn gap_m(&mut self, now: &ReturnTick<L>) -> L {
        self.mean_step = self.mean_step + self.share * (now.hand_step_m - self.mean_step);
        let step = self.return_step - self.mean_step.min(L::zero());
        let closed = closed_by(now.gap_m, step);
        let waits = self.mean_step.gt(self.still_step);
        L::select(now.begins | waits, now.gap_m, closed)
    }
}

crate::lane::gather!(WhenStill { still_step, return_step, share, mean_step } stored);

#[cfg(test)]
mod tests {
    use super::*;

    const TICK_S: f64 = 1e-3;

    /// The gap in m after a motion of the hand at this speed for a time, from a gap of -10 mm.
    fn after(part: &mut WhenStill<f64>, gap_m: f64, speed_m_per_s: f64, ticks: u32) -> f64 {
        let step = |gap_m, _| {
            part.gap_m(&ReturnTick { gap_m, hand_step_m: speed_m_per_s * TICK_S, force_n: 0.0, begins: false })
        };
        (0..ticks).fold(gap_m, step)
    }

    #[test]
    fn the_gap_waits_for_a_moving_hand_and_closes_for_one_that_stands_still() {
        let settings = WhenStillSettings { still_speed_m_per_s: 0.001, return_speed_m_per_s: 0.005 };
        let mut part = WhenStill::<f64>::build(&settings, TICK_S);
        // The average needs 0.2 s ln(10/9) = 21 ms to pass 1 mm/s at 10 mm/s; until then the gap closes.
        let moved_m = after(&mut part, -0.01, 0.01, 2000);
        assert!((moved_m + 0.01 - 0.021 * 0.005).abs() < 1e-5, "{moved_m}");
        // 0.2 s ln(10) = 0.46 s after the stop the average is below 1 mm/s, and the gap closes at 5 mm/s.
        let stopped_m = after(&mut part, moved_m, 0.0, 1000);
        assert!((stopped_m - moved_m - 0.54 * 0.005).abs() < 1e-5, "{stopped_m}");
    }

    #[test]
    fn a_hand_that_moves_back_closes_the_gap_by_its_motion() {
        let settings = WhenStillSettings { still_speed_m_per_s: 0.0, return_speed_m_per_s: 0.001 };
        let mut part = WhenStill::<f64>::build(&settings, TICK_S);
        after(&mut part, 0.0, -0.01, 2000);
        // 10 mm/s of the hand and 1 mm/s of the return.
        let gap_m = after(&mut part, -0.02, -0.01, 1000);
        assert!((gap_m + 0.009).abs() < 1e-6, "{gap_m}");
        assert_eq!(after(&mut part, gap_m, -0.01, 1000), 0.0);
    }
}
