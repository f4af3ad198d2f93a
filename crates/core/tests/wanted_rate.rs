//! A wanted rate of false alarms, on noise without ruptures.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal, StudentT};
use trocar_core::detector::{CusumDetector, Detector, DetectorInput, DetectorSettings, DistanceKind, Hypotheses};

/// Minutes of each noise at each rate.
const MINUTES: f64 = 10.0;

/// Standard deviation of the noise in N, and the constant force in N on the needle at rest.
const STD_N: f64 = 0.05;
const FORCE_N: f64 = 0.2;

#[derive(Debug, Clone, Copy)]
enum Noise {
    Normal,
    /// Normal, with a correlation time of 5 ms.
    Correlated,
    /// Student's t, with its degrees of freedom.
    Heavy(f64),
}

/// The number of alarms of the adaptive detector in noise, for samples `tick_s` apart.
fn alarms(noise: Noise, tick_s: f64, wanted_per_min: f64) -> usize {
    let mut settings = DetectorSettings::for_kind(DistanceKind::Adaptive, Hypotheses::default());
    settings.distance.rate.false_alarms_per_min = Some(wanted_per_min);
    let mut detector = CusumDetector::<f64>::new(&settings, tick_s);
    let mut random = ChaCha8Rng::seed_from_u64(4711);
    let keep = (-tick_s / 5e-3).exp();
    let mut last = 0.0;
    let samples = (60.0 * MINUTES / tick_s) as usize;
    (0..samples)
        .filter(|sample| {
            let normal: f64 = StandardNormal.sample(&mut random);
            last = keep * last + (1.0 - keep * keep).sqrt() * normal;
            let unit = match noise {
                Noise::Normal => normal,
                Noise::Correlated => last,
                Noise::Heavy(freedom) => {
                    let student = StudentT::new(freedom).expect("a positive number");
                    student.sample(&mut random) * ((freedom - 2.0) / freedom).sqrt()
                }
            };
            let time_s = *sample as f64 * tick_s;
            let input = DetectorInput {
                force_n: FORCE_N + STD_N * unit,
                predicted_force_n: 0.0,
                residual_n: 0.0,
                correction: [0.0; 2],
                depth_m: 0.01 + 1e-4 * (0.5 * time_s).sin(),
                velocity_m_per_s: 0.0,
                in_contact: true,
            };
            detector.update(&input).alarm
        })
        .count()
}

#[test]
fn the_wanted_rate_of_false_alarms_holds_within_a_factor_of_three() {
    const RATES_HZ: [f64; 4] = [100.0, 333.0, 1000.0, 2000.0];
    for noise in [Noise::Normal, Noise::Correlated, Noise::Heavy(5.0), Noise::Heavy(3.0)] {
        for wanted_per_min in [0.5, 2.0, 5.0] {
            let alarms: usize = RATES_HZ.iter().map(|rate_hz| alarms(noise, 1.0 / rate_hz, wanted_per_min)).sum();
            let per_min = alarms as f64 / (MINUTES * RATES_HZ.len() as f64);
            let ratio = per_min / wanted_per_min;
            assert!((1.0 / 3.0..=3.0).contains(&ratio), "{noise:?}: {per_min} a minute for {wanted_per_min}");
        }
    }
}
