use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal, StudentT};

use super::{log_uniform, uniform};

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Noise {
    White,
    /// Correlated over 1 to 10 ms.
    Correlated,
    /// Half of the standard deviation, rounded to steps.
    Quantised,
    /// One outlier every 2 s.
    Spikes,
    /// Student's t with 3 degrees of freedom.
    HeavyTailed,
    Drift,
    /// 60 to 90 pulses per minute.
    Heartbeat,
}

impl Noise {
    pub const ALL: [Self; 7] =
        [Self::White, Self::Correlated, Self::Quantised, Self::Spikes, Self::HeavyTailed, Self::Drift, Self::Heartbeat];

    pub(super) fn drawn(random: &mut ChaCha8Rng) -> Self {
        super::one_of(random, &Self::ALL)
    }

    pub(super) fn add(self, random: &mut ChaCha8Rng, std_n: f64, tick_s: f64, forces: &mut [f64]) {
        let memory_s = log_uniform(random, 1e-3, 1e-2);
        let keep = libm::exp(-tick_s / memory_s);
        let heavy = StudentT::new(3.0);
        let (slow_n, slow_hz) = (uniform(random, 0.05, 0.3), uniform(random, 0.05, 0.3));
        let (pulse_n, pulse_hz) = (uniform(random, 0.02, 0.2), uniform(random, 1.0, 1.5));
        let phase = uniform(random, 0.0, 1.0);
        let step_n = std_n * 3.0_f64.sqrt();
        let mut correlated = 0.0;
        for (sample, force_n) in forces.iter_mut().enumerate() {
            let time_s = sample as f64 * tick_s;
            let normal: f64 = StandardNormal.sample(random);
            let turn = |hz: f64| time_s * hz + phase;
            *force_n += match self {
                Self::White => std_n * normal,
                Self::Correlated => {
                    correlated = keep * correlated + libm::sqrt(1.0 - keep * keep) * normal;
                    std_n * correlated
                }
                Self::Quantised => 0.5 * std_n * normal,
                Self::Spikes => {
                    let is_spike = uniform(random, 0.0, 1.0) < 0.5 * tick_s;
                    std_n * if is_spike { 12.0 * normal.signum() } else { normal }
                }
                // The variance of Student's t with 3 degrees of freedom is 3.
                Self::HeavyTailed => heavy.map_or(0.0, |t| t.sample(random)) * std_n / 3.0_f64.sqrt(),
                Self::Drift => std_n * normal + slow_n * libm::sin(std::f64::consts::TAU * turn(slow_hz)),
                Self::Heartbeat => {
                    // Rises over 60 ms and falls over 150 ms.
                    let since_s = (turn(pulse_hz) - turn(pulse_hz).floor()) / pulse_hz;
                    let half = |x: f64| 0.5 - 0.5 * libm::cos(std::f64::consts::PI * x.clamp(0.0, 1.0));
                    std_n * normal + pulse_n * half(since_s / 0.06) * (1.0 - half((since_s - 0.06) / 0.15))
                }
            };
            if self == Self::Quantised {
                *force_n = (*force_n / step_n).round() * step_n;
            }
        }
    }
}
