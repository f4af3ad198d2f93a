use super::super::DetectorInput;
use super::super::hypotheses::Hypotheses;
use super::{BuiltIn, Distance, DistanceSettings};
use crate::lane::{Lane, Mask};

const WINDOW_S: f64 = 3e-3;

/// For the noise estimate, and refractory period after an alarm.
const KNOWN_S: f64 = 0.05;
const MUTE_S: f64 = 0.1;

const MAX_SAMPLES: usize = 64;

const MEMORY_S: f64 = 1.0;

const LEAST_NOISE_N: f64 = 1e-6;

/// Of normal noise, in multiples of its mean magnitude.
const STD_OF_MEAN: f64 = 1.253_314_137_315_5;

/// `s_k = (y_{k-w} - y_k) / σ_k` over 3 ms; `σ_k` follows from the mean magnitude of these changes.
#[derive(Debug, Clone)]
pub struct WindowedDerivative<L> {
    window: [L; MAX_SAMPLES],
    length: usize,
    newest: usize,
    samples: f64,
    noise: L,
    share: f64,
    /// In samples.
    known: f64,
    mute: f64,
    /// Samples left of the refractory period.
    muted: L,
}

impl<L: Lane> BuiltIn for WindowedDerivative<L> {
    const UNIT: &'static str = "1";
    const ACCUMULATES: bool = false;
    const IS_BASELINE: bool = true;
    const WAITS_FOR: Option<&'static str> = Some("50 ms to learn the noise, and for 0.1 s after an alarm");

    fn tuning(_hypotheses: &Hypotheses) -> (f64, f64) {
        (7.0, 0.0)
    }

    fn new(_settings: &DistanceSettings, tick_s: f64) -> Self {
        Self {
            window: [L::zero(); MAX_SAMPLES],
            length: (libm::round(WINDOW_S / tick_s) as usize).clamp(1, MAX_SAMPLES),
            newest: 0,
            samples: 0.0,
            noise: L::zero(),
            share: -libm::expm1(-tick_s / MEMORY_S),
            known: KNOWN_S / tick_s,
            mute: MUTE_S / tick_s,
            muted: L::zero(),
        }
    }
}

impl<L: Lane> Distance<L> for WindowedDerivative<L> {
    #[inline(always)]
    fn update(&mut self, input: &DetectorInput<L>) -> L {
        if self.samples == 0.0 {
            self.window = [input.force_n; MAX_SAMPLES];
        }
        self.samples += 1.0;
        let fall = self.window[self.newest] - input.force_n;
        self.window[self.newest] = input.force_n;
        self.newest = (self.newest + 1) % self.length;
        let noise = self.noise.max(L::splat(LEAST_NOISE_N));
        let share = self.share.max(1.0 / self.samples);
        self.noise = self.noise + L::splat(share) * (L::splat(STD_OF_MEAN) * fall.abs() - self.noise);
        self.muted = (self.muted - L::splat(1.0)).max(L::zero());
        L::select(self.muted.gt(L::zero()), L::zero(), fall / noise)
    }

    #[inline(always)]
    fn reset(&mut self, mask: L::Mask) {
        self.muted = L::select(mask, L::splat(self.mute), self.muted);
    }

    #[inline(always)]
    fn accumulates(&self) -> bool {
        Self::ACCUMULATES
    }

    #[inline(always)]
    fn is_ready(&self) -> Option<L::Mask> {
        Some(L::Mask::splat(self.samples >= self.known))
    }
}

crate::lane::gather!(WindowedDerivative { window, noise, muted } same { length, newest, samples, share, known, mute } stored);

#[cfg(test)]
mod tests {
    use super::super::super::fixtures::with_force;
    use super::*;

    fn derivative(tick_s: f64) -> WindowedDerivative<f64> {
        WindowedDerivative::new(&DistanceSettings::DEFAULT, tick_s)
    }

    /// A triangle wave, whose changes over three samples are at most 0.6 N.
    fn force_n(k: u32) -> f64 {
        0.2 * f64::from([0, 1, 2, 3, 2, 1][k as usize % 6])
    }

    #[test]
    fn the_distance_is_the_fall_over_3_ms_in_multiples_of_the_mean_change() {
        let mut derivative = derivative(1e-3);
        let mut changes = vec![];
        let mut forces = vec![];
        for k in 0..300 {
            forces.push(force_n(k));
            let fall = forces[forces.len().saturating_sub(4)] - force_n(k);
            // During the first second the mean covers all changes so far.
            let noise = STD_OF_MEAN * changes.iter().sum::<f64>() / changes.len().max(1) as f64;
            let distance = derivative.update(&with_force(force_n(k)));
            assert!((distance - fall / noise.max(LEAST_NOISE_N)).abs() < 1e-6 * distance.abs().max(1.0), "{k}");
            changes.push(fall.abs());
        }
    }

    #[test]
    fn after_a_second_the_noise_is_forgotten_with_its_memory() {
        let mut derivative = derivative(1e-3);
        for k in 0..5000 {
            derivative.update(&with_force(force_n(k)));
        }
        let before = derivative.noise;
        for _ in 0..503 {
            derivative.update(&with_force(0.2));
        }
        let ratio = derivative.noise / before;
        assert!((ratio - (-0.5_f64).exp()).abs() < 5e-3, "{ratio}");
    }

    #[test]
    fn the_noise_is_known_after_50_ms_and_an_alarm_inhibits_alarms_for_a_tenth_of_a_second() {
        for tick_s in [1e-3, 5e-4] {
            let mut derivative = derivative(tick_s);
            let known = (0..).find(|&k| {
                derivative.update(&with_force(force_n(k)));
                derivative.is_ready() == Some(true)
            });
            assert_eq!(known, Some((0.05 / tick_s) as u32 - 1));
            derivative.reset(false);
            let falling =
                |derivative: &mut WindowedDerivative<f64>, k: u32| derivative.update(&with_force(-f64::from(k)));
            assert!(falling(&mut derivative, 1) > 0.0, "no alarm, no mute");
            derivative.reset(true);
            let first = (1..1000).find(|&k| falling(&mut derivative, k + 1) > 0.0);
            assert_eq!(first, Some((0.1 / tick_s) as u32));
        }
    }

    #[test]
    fn the_window_is_3_ms_and_at_least_one_sample() {
        assert_eq!([1e-3, 5e-4, 1e-5, 0.1].map(|tick_s| derivative(tick_s).length), [3, 6, MAX_SAMPLES, 1]);
    }
}
