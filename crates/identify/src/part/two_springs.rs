use super::signals::Signals;

const LONGEST_STEP_S: f64 = 5e-4;

/// Per sample, for recordings at low rates.
const MAX_STEPS: usize = 64;

/// Eq. 32: `m_h x_a'' = k_h (x_d - x_a) + b_h (x_d' - x_a') - F_h`, `F_h = k_a (x_a - x_h) + b_a (x_a' - x_h')`.
pub(super) struct TwoSprings {
    pub(super) k_a: f64,
    pub(super) b_a: f64,
    pub(super) k_h: f64,
    pub(super) b_h: f64,
    pub(super) mass_kg: f64,
}

type State = [f64; 2];

pub(super) struct Motions<'a> {
    pub(super) master_m: &'a [f64],
    pub(super) master_rate: &'a [f64],
    pub(super) desired_m: &'a [f64],
    pub(super) desired_rate: &'a [f64],
}

impl TwoSprings {
    /// The first state of the arm minimises the squared error.
    pub(super) fn forces_n(&self, signals: &Signals, motions: &Motions<'_>) -> Vec<f64> {
        let share = self.k_a / (self.k_a + self.k_h);
        let between = |master: f64, desired: f64| share * master + (1.0 - share) * desired;
        let rest = [
            between(motions.master_m[0], motions.desired_m[0]),
            between(motions.master_rate[0], motions.desired_rate[0]),
        ];
        let mut forces_n = self.response(signals, Some(motions), rest);
        let by_position = self.response(signals, None, [1.0, 0.0]);
        let by_velocity = self.response(signals, None, [0.0, 1.0]);
        let errors: Vec<f64> =
            signals.force_n.iter().zip(&forces_n).map(|(measured, simulated)| measured - simulated).collect();
        let [position_m, velocity] = plane(&by_position, &by_velocity, &errors);
        for (force_n, (a, b)) in forces_n.iter_mut().zip(by_position.iter().zip(&by_velocity)) {
            *force_n += position_m * a + velocity * b;
        }
        forces_n
    }

    /// Forces in N by the implicit midpoint rule. Without motions, master and desired position stay at 0.
    fn response(&self, signals: &Signals, motions: Option<&Motions<'_>>, start: State) -> Vec<f64> {
        let Self { k_a, b_a, k_h, b_h, mass_kg } = *self;
        let steps = ((signals.interval_s / LONGEST_STEP_S - 1e-9).ceil() as usize).clamp(1, MAX_STEPS);
        let step_s = signals.interval_s / steps as f64;
        let denominator = 2.0 * mass_kg / step_s + b_a + b_h + 0.5 * step_s * (k_a + k_h);
        // On a mass at 0: the force of the spring at the master, and of both springs.
        let push_n = motions.map(|Motions { master_m, master_rate, desired_m, desired_rate }| {
            let at = |sample: usize| {
                let master_n = k_a * master_m[sample] + b_a * master_rate[sample];
                (master_n, master_n + k_h * desired_m[sample] + b_h * desired_rate[sample])
            };
            (0..signals.len()).map(at).collect::<Vec<_>>()
        });
        let push_n = |sample: usize| push_n.as_ref().map_or((0.0, 0.0), |push_n| push_n[sample]);
        let [mut position_m, mut velocity] = start;
        let mut forces_n = vec![k_a * position_m + b_a * velocity - push_n(0).0];
        for sample in 1..signals.len() {
            let master_n = push_n(sample).0;
            let nearby = [sample.saturating_sub(2), sample - 1, sample, (sample + 1).min(signals.len() - 1)];
            let pushes_n = nearby.map(|sample| push_n(sample).1);
            for step in 0..steps {
                let at = (step as f64 + 0.5) / steps as f64;
                let pull_n = between(pushes_n, at) - (k_a + k_h) * position_m;
                let mean = (2.0 * mass_kg / step_s * velocity + pull_n) / denominator;
                position_m += step_s * mean;
                velocity = 2.0 * mean - velocity;
            }
            forces_n.push(k_a * position_m + b_a * velocity - master_n);
        }
        forces_n
    }
}

/// Between the second and the third sample, by the cubic of Catmull and Rom: a line would attenuate fast perturbations.
fn between([a, b, c, d]: [f64; 4], at: f64) -> f64 {
    b + 0.5 * at * (c - a + at * (2.0 * a - 5.0 * b + 4.0 * c - d + at * (3.0 * (b - c) + d - a)))
}

/// Coefficients of two columns; regularised if the columns are similar.
fn plane(first: &[f64], second: &[f64], targets: &[f64]) -> [f64; 2] {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let (aa, ab, bb) = (dot(first, first), dot(first, second), dot(second, second));
    let (at, bt) = (dot(first, targets), dot(second, targets));
    let determinant = aa * bb * (1.0 + 1e-9) - ab * ab;
    if determinant > 0.0 { [(bb * at - ab * bt) / determinant, (aa * bt - ab * at) / determinant] } else { [0.0; 2] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::part::Part;

    #[test]
    fn the_first_position_of_the_arm_is_found() {
        let arm = TwoSprings { k_a: 700.0, b_a: 30.0, k_h: 2000.0, b_h: 20.0, mass_kg: 2.0 };
        let wave: Vec<f64> = (0..2000).map(|k| 0.01 * (0.01 * f64::from(k)).sin()).collect();
        let rate: Vec<f64> = (0..2000).map(|k| 0.1 * (0.01 * f64::from(k)).cos()).collect();
        let zeros = vec![0.0; 2000];
        let motions = Motions { master_m: &wave, master_rate: &rate, desired_m: &zeros, desired_rate: &zeros };
        let signals = Signals::new("a", Part::Arm, 1e-3, wave.clone(), wave.clone(), None).expect("a recording");
        let truth = arm.response(&signals, Some(&motions), [0.004, -0.2]);
        let measured = Signals::new("a", Part::Arm, 1e-3, wave.clone(), truth.clone(), None).expect("a recording");
        let found = arm.forces_n(&measured, &motions);
        let largest = found.iter().zip(&truth).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        // The transient is several newtons.
        assert!(largest < 1e-6, "{largest}");
    }
}
