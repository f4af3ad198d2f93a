//! `y = clip(quantise(lag(f + bias) + noise))` with white noise at any bandwidth.

mod bank;
mod lag;
mod noise;

pub use self::bank::NoiseBank;
use self::lag::Lag;
use self::noise::WhiteNoise;
use trocar_core::chain::Measurement;
use trocar_core::error::InvalidValue;
use trocar_core::estimation::VelocityFilter;
use trocar_core::lane::Lane;

trocar_core::settings! {
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct SensorSettings in "sensor." {
        /// Bias added to every force reading.
        force_bias_n: f64 [ANY] = 0.0,
        /// First-order bandwidth of the force reading, before its noise; 0: no lag.
        force_bandwidth_hz: f64 [NON_NEGATIVE] = 0.0,
        /// Standard deviation of the white noise on the force.
        force_noise_std_n: f64 [NON_NEGATIVE] = 0.0,
        /// Step of the force reading; 0: no quantisation.
        force_resolution_n: f64 [NON_NEGATIVE] = 0.0,
        /// Maximum force reading, in both directions: readings beyond it are clipped; no limit by default.
        force_range_n: Option<f64> [POSITIVE],
        /// Places the sensor at the tip, so that it does not measure the friction on the shaft.
        at_tip: bool = false,
        /// Step of the slave's encoder; above 0 the velocity is estimated by a Kalman filter.
        position_resolution_m: f64 [ENCODER_STEP] = 0.0,
        /// Standard deviation of the acceleration in the Kalman filter.
        acceleration_std_m_per_s2: f64 [POSITIVE] = 0.5,
    }
}

impl SensorSettings {
    pub fn reads_force_exactly(&self) -> bool {
        let Self { force_bias_n, force_bandwidth_hz, force_noise_std_n, force_resolution_n, force_range_n, .. } = *self;
        [force_bias_n, force_bandwidth_hz, force_noise_std_n, force_resolution_n] == [0.0; 4] && force_range_n.is_none()
    }

    pub fn reads_position_exactly(&self) -> bool {
        self.position_resolution_m == 0.0
    }
}

#[derive(Debug, Clone, Copy)]
pub(crate) struct Quantiser<L>(Option<(L, L)>);

impl<L: Lane> Quantiser<L> {
    pub(crate) fn new(step: f64) -> Self {
        Self((step > 0.0).then(|| (L::splat(step), L::splat(1.0 / step))))
    }

    #[inline(always)]
    pub(crate) fn read(&self, value: L) -> L {
        match self.0 {
            Some((step, inverse)) => value.round_to(step, inverse),
            None => value,
        }
    }
}

pub trait Sensor<L: Lane> {
    fn read(&mut self, force_n: L, position_m: L, velocity_m_per_s: L) -> Measurement<L>;

    #[inline(always)]
    fn excludes_shaft(&self) -> bool {
        false
    }

    fn share_noise(&mut self, _bank: &mut NoiseBank, _ticks: u64) {}
}

impl<L: Lane, S: Sensor<L> + ?Sized> Sensor<L> for Box<S> {
    #[inline(always)]
    fn read(&mut self, force_n: L, position_m: L, velocity_m_per_s: L) -> Measurement<L> {
        (**self).read(force_n, position_m, velocity_m_per_s)
    }

    #[inline(always)]
    fn excludes_shaft(&self) -> bool {
        (**self).excludes_shaft()
    }
}

#[derive(Debug, Clone, Copy)]
pub struct PerfectSensor;

impl<L: Lane> Sensor<L> for PerfectSensor {
    #[inline(always)]
    fn read(&mut self, force_n: L, position_m: L, velocity_m_per_s: L) -> Measurement<L> {
        Measurement { force_n, position_m, velocity_m_per_s }
    }
}

impl trocar_core::lane::Gather for PerfectSensor {
    type Of<L: Lane> = Self;

    fn gather<L: Lane>(_all: [&Self; trocar_core::lane::LANES]) -> Option<Self> {
        Some(Self)
    }
}

#[derive(Debug, Clone)]
pub struct ForceSensor<L> {
    bias_n: Option<L>,
    lag: Option<Lag<L>>,
    noise_std_n: L,
    noise: Option<WhiteNoise<L>>,
    force: Quantiser<L>,
    range_n: Option<L>,
}

impl<L: Lane> ForceSensor<L> {
    /// Lane `i` draws its noise from stream `first_stream + i`.
    pub fn new(settings: &SensorSettings, tick_s: f64, seed: u64, first_stream: u64) -> Self {
        let SensorSettings { force_bias_n, force_bandwidth_hz, force_noise_std_n, .. } = *settings;
        Self {
            bias_n: (force_bias_n != 0.0).then(|| L::splat(force_bias_n)),
            lag: (force_bandwidth_hz > 0.0).then(|| Lag::new(force_bandwidth_hz, tick_s, force_bias_n)),
            noise_std_n: L::splat(force_noise_std_n),
            noise: (force_noise_std_n > 0.0).then(|| WhiteNoise::new(seed, first_stream)),
            force: Quantiser::new(settings.force_resolution_n),
            range_n: settings.force_range_n.map(L::splat),
        }
    }

    pub(crate) fn silence(&mut self) {
        self.noise = None;
    }

    #[inline(always)]
    pub fn read_force(&mut self, force_n: L) -> L {
        let mut read = force_n;
        if let Some(bias_n) = self.bias_n {
            read = read + bias_n;
        }
        if let Some(lag) = &mut self.lag {
            read = lag.update(read);
        }
        if let Some(noise) = &mut self.noise {
            read = read + self.noise_std_n * noise.draw();
        }
        read = self.force.read(read);
        if let Some(range_n) = self.range_n {
            read = read.clamp(-range_n, range_n);
        }
        read
    }
}

impl<L: Lane> Sensor<L> for ForceSensor<L> {
    #[inline(always)]
    fn read(&mut self, force_n: L, position_m: L, velocity_m_per_s: L) -> Measurement<L> {
        Measurement { force_n: self.read_force(force_n), position_m, velocity_m_per_s }
    }

    fn share_noise(&mut self, bank: &mut NoiseBank, ticks: u64) {
        if let Some(noise) = &mut self.noise {
            noise.take_from(bank, ticks);
        }
    }
}

#[derive(Debug, Clone)]
pub struct AnySensor<L> {
    force: ForceSensor<L>,
    position: Quantiser<L>,
    velocity: Option<VelocityFilter<L>>,
    at_tip: bool,
}

impl<L: Lane> AnySensor<L> {
    pub fn new(settings: &SensorSettings, tick_s: f64, (seed, first_stream): (u64, u64)) -> Result<Self, InvalidValue> {
        let resolution_m = settings.position_resolution_m;
        let acceleration = settings.acceleration_std_m_per_s2;
        let filter = (resolution_m > 0.0).then(|| VelocityFilter::new(tick_s, resolution_m, acceleration));
        Ok(Self {
            force: ForceSensor::new(settings, tick_s, seed, first_stream),
            position: Quantiser::new(resolution_m),
            velocity: filter.transpose()?,
            at_tip: settings.at_tip,
        })
    }

    pub fn silence(&mut self) {
        self.force.silence();
    }
}

impl<L: Lane> Sensor<L> for AnySensor<L> {
    #[inline(always)]
    fn read(&mut self, force_n: L, position_m: L, velocity_m_per_s: L) -> Measurement<L> {
        let position_m = self.position.read(position_m);
        let velocity_m_per_s = match &mut self.velocity {
            Some(filter) => filter.update(position_m),
            None => velocity_m_per_s,
        };
        self.force.read(force_n, position_m, velocity_m_per_s)
    }

    #[inline(always)]
    fn excludes_shaft(&self) -> bool {
        self.at_tip
    }

    fn share_noise(&mut self, bank: &mut NoiseBank, ticks: u64) {
        self.force.share_noise(bank, ticks);
    }
}

trocar_core::lane::gather!(ForceSensor { bias_n, lag, noise_std_n, noise, force, range_n });
trocar_core::lane::gather!(AnySensor { force, position, velocity } same { at_tip });

impl trocar_core::lane::Gather for Quantiser<f64> {
    type Of<L: Lane> = Quantiser<L>;

    fn gather<L: Lane>(all: [&Self; trocar_core::lane::LANES]) -> Option<Quantiser<L>> {
        trocar_core::lane::Gather::gather(trocar_core::lane::of_each!(all, |one| &one.0)).map(Quantiser)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TICK_S: f64 = 1e-3;

    fn measurements(settings: &SensorSettings, forces: impl Iterator<Item = f64>) -> Vec<f64> {
        let mut sensor = ForceSensor::<f64>::new(settings, TICK_S, 3, 0);
        forces.map(|force_n| sensor.read_force(force_n)).collect()
    }

    #[test]
    fn a_bias_has_settled_before_the_first_tick() {
        let settings = SensorSettings { force_bias_n: 0.3, force_bandwidth_hz: 5.0, ..Default::default() };
        for read in measurements(&settings, (0..20).map(|_| 0.0)) {
            assert!((read - 0.3).abs() < 1e-15, "{read}");
        }
    }

    #[test]
    fn no_reading_is_beyond_the_range_even_when_its_step_does_not_divide_it() {
        let settings = SensorSettings {
            force_range_n: Some(5.0),
            force_resolution_n: 0.3,
            force_noise_std_n: 2.0,
            ..Default::default()
        };
        let read = measurements(&settings, (0..2000).map(|k| 0.01 * f64::from(k) - 10.0));
        let (min, max) = read.iter().fold((0.0_f64, 0.0_f64), |(a, b), &y| (a.min(y), b.max(y)));
        assert_eq!((min, max), (-5.0, 5.0));
        let inside = read.iter().filter(|y| y.abs() < 5.0);
        assert!(
            inside.clone().count() > 500 && inside.into_iter().all(|y| ((y / 0.3).round() * 0.3 - y).abs() < 1e-12)
        );
    }

    #[test]
    fn noise_has_the_stated_spread_and_is_seeded() {
        let settings = SensorSettings { force_noise_std_n: 0.025, ..SensorSettings::default() };
        let draw = |seed, stream| {
            let mut sensor = ForceSensor::<f64>::new(&settings, TICK_S, seed, stream);
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
        let mut sensor = AnySensor::<f64>::new(&settings, TICK_S, (0, 0)).expect("valid");
        let measurement = sensor.read(1.3, 0.012_34, 0.0);
        assert_eq!(measurement.force_n, 1.5);
        assert!((measurement.position_m - 0.012).abs() < 1e-15);
    }

    #[test]
    fn with_an_encoder_the_velocity_comes_from_its_filter() {
        let settings = SensorSettings { position_resolution_m: 1e-5, ..Default::default() };
        let mut sensor = AnySensor::<f64>::new(&settings, TICK_S, (0, 0)).expect("valid");
        let mut filter = VelocityFilter::<f64>::new(TICK_S, 1e-5, settings.acceleration_std_m_per_s2).expect("valid");
        for tick in 0..200 {
            let position = 3.7e-5 * f64::from(tick);
            let measurement = sensor.read(0.0, position, 99.0);
            assert_eq!(measurement.velocity_m_per_s, filter.update(measurement.position_m));
        }
    }

    #[test]
    fn a_silenced_sensor_reads_without_noise_and_a_bank_changes_nothing() {
        let settings = SensorSettings { force_noise_std_n: 0.1, force_bias_n: 0.25, ..Default::default() };
        let new = || AnySensor::<f64>::new(&settings, TICK_S, (3, 1)).expect("valid");
        let (mut separate, mut shared, mut silenced) = (new(), new(), new());
        shared.share_noise(&mut NoiseBank::new(1000), 500);
        silenced.silence();
        for _ in 0..500 {
            assert_eq!(separate.read(1.0, 0.0, 0.0).force_n, shared.read(1.0, 0.0, 0.0).force_n);
            assert_eq!(silenced.read(1.0, 0.0, 0.0).force_n, 1.25);
        }
    }

    #[test]
    fn the_noise_is_added_after_the_bias() {
        let settings = SensorSettings { force_noise_std_n: 0.1, force_bias_n: 0.25, ..Default::default() };
        let mut noise = WhiteNoise::<f64>::new(3, 0);
        for read in measurements(&settings, (0..50).map(f64::from)).into_iter().zip(0..) {
            assert_eq!(read.0, f64::from(read.1) + 0.25 + 0.1 * noise.draw());
        }
    }

    #[test]
    fn a_sensor_is_exact_only_without_any_imperfection() {
        let default = SensorSettings::default();
        assert!(default.reads_force_exactly() && default.reads_position_exactly());
        assert!(!SensorSettings { position_resolution_m: 1e-6, ..default }.reads_position_exactly());
        for settings in [
            SensorSettings { force_bias_n: -0.1, ..default },
            SensorSettings { force_bandwidth_hz: 100.0, ..default },
            SensorSettings { force_noise_std_n: 0.1, ..default },
            SensorSettings { force_resolution_n: 0.1, ..default },
            SensorSettings { force_range_n: Some(9.0), ..default },
        ] {
            assert!(!settings.reads_force_exactly(), "{settings:?}");
        }
    }
}
