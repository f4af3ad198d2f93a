use crate::plant::SlaveStep;

/// Brake time per lag of the slave: with 2 the paper's slave stops after 3 ms, with 1 after 11.
const BRAKE_PER_LAG: f64 = 2.0;

/// With velocity `v`, third state `w`, reference `u` ahead, and the brake `u = -β v` from the next tick on, the slave
/// comes to rest after
///
/// ```text
/// travel = per_velocity · v + per_state · w + per_lead · u
/// ```
/// Exact, because the tissue does not move the slave.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::teleoperation) struct SlaveMotion {
    pub(super) per_velocity_s: f64,
    pub(super) per_state: f64,
    pub(super) per_lead: f64,
    /// `β`.
    pub(super) brake_s: f64,
    pub(super) gain: f64,
    pub(super) resting_state: f64,
    /// Coefficients of the third state at the next tick: of `v`, `w`, `u` and the travel.
    pub(super) next_state: [f64; 4],
}

impl SlaveMotion {
    pub(in crate::teleoperation) fn new(step: &SlaveStep, tick_s: f64) -> Self {
        let gain = if step.rest[0] == 0.0 { 1.0 } else { step.rest[0] };
        let resting_state = step.rest[2] / gain;
        let [x, v, w] = [0, 1, 2].map(|i| [step.transition[i][1], step.transition[i][2], step.reference[i] / gain]);
        let w = [0, 1, 2].map(|j| w[j] - resting_state * x[j]);
        // At a steady 1 m/s, v stays 1 and w is constant; the lead is the lag.
        let lag_s = solve([[v[1], v[2]], [w[1] - 1.0, w[2]]], [1.0 - v[0], -w[0]]).map(|[_, lead]| lead);
        let brakes = lag_s.into_iter().flat_map(|lag_s| [BRAKE_PER_LAG, 1.0, 0.5, 0.0].map(|factor| factor * lag_s));
        let travels = |brake_s: f64| {
            let [a, b] = [v, w].map(|row| [row[0] - brake_s * row[2], row[1]]);
            let along = [x[0] - brake_s * x[2], x[1]];
            // Schur-Cohn: both poles are inside the unit circle.
            let (trace, determinant) = (a[0] + b[1], a[0] * b[1] - a[1] * b[0]);
            let settles = determinant.abs() < 1.0 && trace.abs() < 1.0 + determinant;
            // Sum over all ticks: along · (I - A)^-1.
            let sums = solve([[1.0 - a[0], -b[0]], [-a[1], 1.0 - b[1]]], along);
            sums.filter(|sums| settles && brake_s >= 0.0 && sums[0] > 0.0).map(|sums| (brake_s, sums))
        };
        // An unstoppable slave counts as being at its commanded position.
        let [per_velocity_s, per_state, per_lead, brake_s] = match brakes.into_iter().find_map(travels) {
            Some((brake_s, [of_v, of_w])) => {
                let travel = |j: usize| x[j] + of_v * v[j] + of_w * w[j];
                [travel(0), travel(1), travel(2), brake_s]
            }
            None => [0.0, 0.0, 1.0, 0.0],
        };
        let next_state = [w[0], w[1], w[2], tick_s];
        Self { per_velocity_s, per_state, per_lead, brake_s, gain, resting_state, next_state }
    }
}

fn solve([[a, b], [c, d]]: [[f64; 2]; 2], [e, f]: [f64; 2]) -> Option<[f64; 2]> {
    let determinant = a * d - b * c;
    let solution = [(e * d - b * f) / determinant, (a * f - e * c) / determinant];
    solution.iter().all(|value| value.is_finite()).then_some(solution)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plant::{ControlTiming, Damping, SlaveParameters};

    /// Runs a slave that brakes from a steady motion. Returns its travel and the predicted travel.
    fn brake(slave: &SlaveParameters, timing: ControlTiming) -> (f64, f64) {
        let step = SlaveStep::new(slave, timing, 1e-3).expect("valid");
        let motion = SlaveMotion::new(&step, 1e-3);
        let mut state = [0.0; 3];
        let mut advance = |reference: f64| {
            let last = state;
            state = std::array::from_fn(|i| {
                (0..3).map(|j| step.transition[i][j] * last[j]).sum::<f64>() + step.reference[i] * reference
            });
            state
        };
        let mut at = [0.0; 3];
        for tick in 0..400 {
            at = advance(5e-5 * f64::from(tick));
        }
        let lead = 0.02 * motion.gain - at[0] + 0.1 * 5e-5;
        let third = at[2] - motion.resting_state * at[0];
        let predicted = motion.per_velocity_s * at[1] + motion.per_state * third + motion.per_lead * lead;
        let from = at[0];
        at = advance((from + lead) / motion.gain);
        for _ in 0..2000 {
            at = advance((at[0] - motion.brake_s * at[1]) / motion.gain);
        }
        (at[0] - from, predicted)
    }

    #[test]
    fn the_predicted_travel_is_the_travel_of_the_slave() {
        for (damping, timing) in [
            (Damping::Velocity, ControlTiming::Continuous),
            (Damping::Velocity, ControlTiming::Sampled),
            (Damping::AsPrinted, ControlTiming::Continuous),
        ] {
            let slave = SlaveParameters { damping, ..SlaveParameters::default() };
            let (travel, predicted) = brake(&slave, timing);
            assert!((travel - predicted).abs() < 1e-9, "{damping:?} {timing:?}: {travel} {predicted}");
        }
        let second_order =
            SlaveParameters { numerator: vec![6.3], denominator: vec![1.0, 1.0, 0.0], ..SlaveParameters::default() };
        let (travel, predicted) = brake(&second_order, ControlTiming::Continuous);
        assert!((travel - predicted).abs() < 1e-9, "{travel} {predicted}");
    }
}
