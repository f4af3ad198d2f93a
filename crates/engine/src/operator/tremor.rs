use std::f64::consts::TAU;
use std::sync::Arc;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use trocar_core::error::{InvalidValue, require};
use trocar_core::lane::Lane;

const SINES: usize = 8;

/// A motion must start at its intended position.
const GROWTH_S: f64 = 0.25;

/// Separates these random numbers from others with the same seed.
const DOMAIN: u64 = 0x7472_656d_6f72;

trocar_core::settings! {
    /// Hands tremble at 8 to 12 Hz, surgeons' by 50 to 200 µm RMS (<https://pmc.ncbi.nlm.nih.gov/articles/PMC3989364>).
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct TremorSettings in "operator.tremor_" {
        /// Root mean square of the hand's tremor, usually tens to hundreds of micrometres.
        amplitude_m: f64 [NON_NEGATIVE] = 0.0,
        /// Lower end of the tremor's band.
        low_hz: f64 [POSITIVE] = 8.0,
        /// Upper end of the tremor's band.
        high_hz: f64 [POSITIVE] = 12.0,
    }
    where high_hz: |s| s.high_hz > s.low_hz, "above operator.tremor_low_hz";
}

impl TremorSettings {
    pub fn validate_on_ticks(&self, tick_s: f64) -> Result<(), InvalidValue> {
        self.validate()?;
        let is_sampled = self.amplitude_m == 0.0 || self.high_hz < 0.5 / tick_s;
        require("operator.tremor_high_hz", self.high_hz, is_sampled, "below half the rate of the ticks").map(drop)
    }

    /// With all sines at their peak.
    pub fn largest(&self) -> [f64; 2] {
        let displacement_m = SINES as f64 * self.size_m();
        // The slope of the growth `3 s² - 2 s³` is at most 1.5.
        [displacement_m, displacement_m * (TAU * self.high_hz + 1.5 / GROWTH_S)]
    }

    fn size_m(&self) -> f64 {
        self.amplitude_m * (2.0 / SINES as f64).sqrt()
    }

    /// One sine of equal amplitude per eighth of the band, with random frequency and phase.
    pub fn displacements<L: Lane>(&self, seed: u64, first_stream: u64, tick_s: f64, ticks: u64) -> Arc<[L]> {
        let mut lanes: Vec<SineSum> =
            (0..L::WIDTH).map(|lane| SineSum::new(self, seed, first_stream + lane as u64, tick_s)).collect();
        let growth_ticks = GROWTH_S / tick_s;
        let displacement = |tick: u64| {
            let share = (tick as f64 / growth_ticks).min(1.0);
            let grown = share * share * (3.0 - 2.0 * share);
            let next = |all: L, (lane, hand): (usize, &mut SineSum)| all.with_lane(lane, grown * hand.next());
            lanes.iter_mut().enumerate().fold(L::zero(), next)
        };
        (0..ticks).map(displacement).collect()
    }
}

struct SineSum {
    size_m: f64,
    sines: [([f64; 2], [f64; 2]); SINES],
}

impl SineSum {
    fn new(settings: &TremorSettings, seed: u64, stream: u64, tick_s: f64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed ^ DOMAIN);
        rng.set_stream(stream);
        let vector = |angle: f64| [libm::cos(angle), libm::sin(angle)];
        let width_hz = (settings.high_hz - settings.low_hz) / SINES as f64;
        let sines = std::array::from_fn(|i| {
            let frequency_hz = settings.low_hz + width_hz * (i as f64 + rng.random::<f64>());
            let phase = TAU * rng.random::<f64>();
            (vector(phase), vector(TAU * frequency_hz * tick_s))
        });
        Self { size_m: settings.size_m(), sines }
    }

    fn next(&mut self) -> f64 {
        let mut sum = 0.0;
        for ([cos, sin], [turn_cos, turn_sin]) in &mut self.sines {
            sum += *sin;
            (*cos, *sin) = (*cos * *turn_cos - *sin * *turn_sin, *sin * *turn_cos + *cos * *turn_sin);
        }
        self.size_m * sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TICK_S: f64 = 1e-3;

    fn tremor(seed: u64, ticks: u64) -> Vec<f64> {
        let settings = TremorSettings { amplitude_m: 1e-4, ..TremorSettings::default() };
        settings.displacements::<f64>(seed, 0, TICK_S, ticks).to_vec()
    }

    /// The power of the last 40 s between two frequencies (Hz), as a fraction of the power from 0.5 to 30 Hz.
    fn share_between(signal: &[f64], low_hz: f64, high_hz: f64) -> f64 {
        let tail = &signal[signal.len() - 40_000..];
        let power = |bin: usize| {
            let turn = TAU * bin as f64 / tail.len() as f64;
            let part =
                |wave: fn(f64) -> f64| -> f64 { tail.iter().enumerate().map(|(k, x)| x * wave(turn * k as f64)).sum() };
            part(libm::cos).powi(2) + part(libm::sin).powi(2)
        };
        let bins = |low: f64, high: f64| ((low * 40.0) as usize..(high * 40.0) as usize).step_by(2);
        bins(low_hz, high_hz).map(power).sum::<f64>() / bins(0.5, 30.0).map(power).sum::<f64>()
    }

    #[test]
    fn a_tremor_lies_in_its_band_and_has_its_amplitude() {
        let signal = tremor(3, 60_000);
        assert!(share_between(&signal, 7.8, 12.2) > 0.98, "{}", share_between(&signal, 7.8, 12.2));
        let rms = (signal[1000..].iter().map(|x| x * x).sum::<f64>() / 59_000.0).sqrt();
        assert!((rms - 1e-4).abs() < 3e-6, "{rms}");
        assert_eq!(signal[0], 0.0);
    }

    #[test]
    fn a_tremor_depends_on_seed_and_stream() {
        assert_eq!(tremor(1, 500), tremor(1, 500));
        assert_ne!(tremor(1, 500), tremor(2, 500));
        let settings = TremorSettings { amplitude_m: 1e-4, ..TremorSettings::default() };
        let other = settings.displacements::<f64>(1, 1, TICK_S, 500);
        assert_ne!(tremor(1, 500), other.to_vec());
    }

    #[test]
    fn a_tremor_grows_from_rest_and_stays_within_its_bounds() {
        let settings = TremorSettings { amplitude_m: 1e-4, low_hz: 8.0, high_hz: 12.0 };
        let [displacement_m, speed_m_per_s] = settings.largest();
        // Eight sines, each with √2/√8 of the root mean square, all at their peaks.
        assert!((displacement_m - 8.0 * 0.5 * 1e-4).abs() < 1e-15, "{displacement_m}");
        assert!((speed_m_per_s - displacement_m * (TAU * 12.0 + 1.5 / 0.25)).abs() < 1e-12, "{speed_m_per_s}");
        for tick_s in [1e-3, 5e-4] {
            let [growing, whole] = [1, 2].map(|stream| settings.displacements::<f64>(7, stream, tick_s, 4000));
            for signal in [&growing, &whole] {
                assert!(signal.iter().all(|x| x.abs() <= displacement_m));
                assert!(signal.windows(2).all(|pair| (pair[1] - pair[0]).abs() <= speed_m_per_s * tick_s));
            }
            // During the first quarter of a second it is the same sum of sines, scaled by 3 s² - 2 s³.
            let mut sines = SineSum::new(&settings, 7, 1, tick_s);
            for (tick, displacement) in growing.iter().enumerate() {
                let share = (tick as f64 * tick_s / 0.25).min(1.0);
                let expected = (3.0 * share * share - 2.0 * share.powi(3)) * sines.next();
                assert!((displacement - expected).abs() < 1e-15, "{tick}");
            }
        }
    }
}
