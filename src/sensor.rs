//! What the sensors make of force and position: noise and quantisation.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

use crate::error::{InvalidValue, non_negative};
use crate::lane::Lane;

/// What the sensors do.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SensorSettings {
    /// Standard deviation of the white noise on the force in N, at least 0.
    pub force_noise_std_n: f64,
    /// Step of the force reading in N, at least 0; 0 reads exactly.
    pub force_resolution_n: f64,
    /// Step of the slave's position reading in m, at least 0; 0 reads position and velocity exactly.
    pub position_resolution_m: f64,
}

impl SensorSettings {
    /// Checks the ranges that the fields state.
    ///
    /// # Errors
    /// [`InvalidValue`] naming the first setting out of range.
    pub fn validate(&self) -> Result<(), InvalidValue> {
        non_negative("sensor.force_noise_std_n", self.force_noise_std_n)?;
        non_negative("sensor.force_resolution_n", self.force_resolution_n)?;
        non_negative("sensor.position_resolution_m", self.position_resolution_m)?;
        Ok(())
    }
}

/// Rounds to multiples of a step; a step of 0 leaves the number as it is.
#[derive(Debug, Clone, Copy)]
struct Quantiser<L>(Option<(L, L)>);

impl<L: Lane> Quantiser<L> {
    fn new(step: f64) -> Self {
        Self((step > 0.0).then(|| (L::splat(step), L::splat(1.0 / step))))
    }

    #[inline(always)]
    fn read(&self, value: L) -> L {
        self.0.map_or(value, |(step, inverse)| value.round_to(step, inverse))
    }
}

/// The sensors at work. Lane `i` draws its noise from stream `first_stream + i` of the seed, whatever the other lanes do.
#[derive(Debug, Clone)]
pub struct Sensor<L> {
    noise_std_n: L,
    noise: Option<Box<[ChaCha8Rng]>>,
    force: Quantiser<L>,
    position: Quantiser<L>,
}

impl<L: Lane> Sensor<L> {
    /// Sensors with the noise of `seed`, from stream `first_stream` on.
    #[must_use]
    pub fn new(settings: &SensorSettings, seed: u64, first_stream: u64) -> Self {
        let stream = |lane| {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            rng.set_stream(first_stream + lane as u64);
            rng
        };
        Self {
            noise_std_n: L::splat(settings.force_noise_std_n),
            noise: (settings.force_noise_std_n > 0.0).then(|| (0..L::WIDTH).map(stream).collect()),
            force: Quantiser::new(settings.force_resolution_n),
            position: Quantiser::new(settings.position_resolution_m),
        }
    }

    /// Whether force and position are read as they are.
    #[must_use]
    pub fn is_exact(&self) -> bool {
        self.noise.is_none() && self.force.0.is_none() && self.position.0.is_none()
    }

    /// The force as measured, in N.
    #[inline(always)]
    pub fn read_force(&mut self, force_n: L) -> L {
        let mut read = force_n;
        if let Some(streams) = &mut self.noise {
            read = read + self.noise_std_n * draw(streams);
        }
        self.force.read(read)
    }

    /// The position as measured, in m.
    #[inline(always)]
    pub fn read_position(&self, position_m: L) -> L {
        self.position.read(position_m)
    }
}

/// A standard normal number for each lane, from its own stream.
#[inline(never)]
fn draw<L: Lane>(streams: &mut [ChaCha8Rng]) -> L {
    let mut noise = L::zero();
    for (lane, rng) in streams.iter_mut().enumerate() {
        noise = noise.with_lane(lane, StandardNormal.sample(rng));
    }
    noise
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_has_the_stated_spread_and_is_seeded() {
        let settings = SensorSettings { force_noise_std_n: 0.025, ..SensorSettings::default() };
        let draw = |seed, stream| {
            let mut sensor = Sensor::<f64>::new(&settings, seed, stream);
            (0..20_000).map(|_| sensor.read_force(1.0)).collect::<Vec<_>>()
        };
        let sample = draw(1, 0);
        let variance = sample.iter().map(|y| (y - 1.0).powi(2)).sum::<f64>() / sample.len() as f64;
        assert!((variance.sqrt() - 0.025).abs() < 5e-4, "{variance}");
        assert_eq!(sample, draw(1, 0));
        assert_ne!(sample, draw(2, 0));
        assert_ne!(sample, draw(1, 1));
    }

    #[test]
    fn readings_are_multiples_of_the_step() {
        let settings = SensorSettings { force_resolution_n: 0.5, position_resolution_m: 1e-3, ..Default::default() };
        let mut sensor = Sensor::<f64>::new(&settings, 0, 0);
        assert_eq!(sensor.read_force(1.3), 1.5);
        assert!((sensor.read_position(0.012_34) - 0.012).abs() < 1e-15);
    }
}
