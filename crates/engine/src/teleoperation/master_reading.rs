use std::ops::Range;
use std::sync::Arc;

use super::AtMaster;
use crate::sensor::Quantiser;
use trocar_core::error::InvalidValue;
use trocar_core::estimation::VelocityFilter;
use trocar_core::lane::Lane;

trocar_core::settings! {
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct EncoderSettings in "master." {
        /// Step of the master's encoder; above 0 its velocity is estimated by a Kalman filter with
        /// sensor.acceleration_std_m_per_s2. 0: position and velocity are read exactly.
        encoder_resolution_m: f64 [ENCODER_STEP] = 0.0,
    }
}

/// While the clutch is open, the read position stays, velocity and force are 0, and the travel remains as an offset.
#[derive(Debug, Clone)]
pub struct MasterReading<L> {
    encoder: Option<(Quantiser<L>, VelocityFilter<L>)>,
    clutch: Arc<[Range<u64>]>,
    next: usize,
    is_open: bool,
    offset_m: L,
    read_m: L,
}

impl<L: Lane> MasterReading<L> {
    pub fn new(
        encoder: &EncoderSettings,
        acceleration_std_m_per_s2: f64,
        clutch: &Arc<[Range<u64>]>,
        (tick_s, start_m): (f64, f64),
    ) -> Result<Option<Self>, InvalidValue> {
        let resolution_m = encoder.encoder_resolution_m;
        if resolution_m <= 0.0 && clutch.is_empty() {
            return Ok(None);
        }
        let filter = (resolution_m > 0.0).then(|| VelocityFilter::new(tick_s, resolution_m, acceleration_std_m_per_s2));
        let filter = filter.transpose().map_err(|error| InvalidValue { name: ENCODER, ..error })?;
        let encoder = filter.map(|filter| (Quantiser::new(resolution_m), filter));
        let read_m = encoder.as_ref().map_or(L::splat(start_m), |(steps, _)| steps.read(L::splat(start_m)));
        Ok(Some(Self { encoder, clutch: clutch.clone(), next: 0, is_open: false, offset_m: L::zero(), read_m }))
    }

    #[inline(always)]
    pub fn read(&mut self, tick: u64, master: AtMaster<L>) -> AtMaster<L> {
        let AtMaster { mut position_m, mut velocity_m_per_s, hand_force_n } = master;
        if let Some((steps, filter)) = &mut self.encoder {
            position_m = steps.read(position_m);
            velocity_m_per_s = filter.update(position_m);
        }
        while self.clutch.get(self.next).is_some_and(|open| open.end <= tick) {
            self.next += 1;
        }
        self.is_open = self.clutch.get(self.next).is_some_and(|open| open.start <= tick);
        if self.is_open {
            self.offset_m = position_m - self.read_m;
            return AtMaster { position_m: self.read_m, velocity_m_per_s: L::zero(), hand_force_n: L::zero() };
        }
        self.read_m = position_m - self.offset_m;
        AtMaster { position_m: self.read_m, velocity_m_per_s, hand_force_n }
    }

    #[inline(always)]
    pub fn is_open(&self) -> bool {
        self.is_open
    }

    #[inline(always)]
    pub fn intended_m(&self, intended_m: L) -> L {
        if self.is_open { self.read_m } else { intended_m - self.offset_m }
    }
}

const ENCODER: &str = EncoderSettings::KEYS[0].path;

trocar_core::lane::gather!(MasterReading { encoder, offset_m, read_m } same { clutch, next, is_open });

#[cfg(test)]
mod tests {
    use super::*;

    fn at(position_m: f64) -> AtMaster<f64> {
        AtMaster { position_m, velocity_m_per_s: 7.0, hand_force_n: 3.0 }
    }

    fn reading(encoder_resolution_m: f64, clutch: &[Range<u64>]) -> Option<MasterReading<f64>> {
        MasterReading::new(&EncoderSettings { encoder_resolution_m }, 0.5, &clutch.into(), (1e-3, 0.0)).expect("valid")
    }

    #[test]
    fn the_travel_under_an_open_clutch_is_never_sent() {
        let mut reading = reading(0.0, &[0..2, 5..8, 8..9]).expect("a clutch");
        let sent: Vec<f64> = (0..12).map(|tick| reading.read(tick, at(tick as f64)).position_m).collect();
        // Ticks 0 and 1 and 5 to 8 are open: of eleven ticks of travel, one and four are under the clutch.
        assert_eq!(sent, [0.0, 0.0, 1.0, 2.0, 3.0, 3.0, 3.0, 3.0, 3.0, 4.0, 5.0, 6.0]);
        assert_eq!(reading.intended_m(20.0), 15.0);
    }

    #[test]
    fn an_open_clutch_sends_neither_velocity_nor_force() {
        let mut reading = reading(0.0, &[1..2, 9..10]).expect("a clutch");
        let numbers = |read: AtMaster<f64>| (read.velocity_m_per_s, read.hand_force_n);
        assert_eq!(numbers(reading.read(0, at(0.0))), (7.0, 3.0));
        assert!(!reading.is_open());
        assert_eq!(numbers(reading.read(1, at(1.0))), (0.0, 0.0));
        assert!(reading.is_open());
        assert_eq!(reading.intended_m(5.0), 0.0);
        assert_eq!(numbers(reading.read(2, at(1.0))), (7.0, 3.0));
    }

    #[test]
    fn an_encoder_rounds_the_position_and_estimates_the_velocity() {
        let mut reading = reading(1e-4, &[]).expect("an encoder");
        let mut last = 0.0;
        for tick in 0..3000_u64 {
            let read = reading.read(tick, at(0.02 * 1e-3 * tick as f64));
            assert!((read.position_m / 1e-4 - (read.position_m / 1e-4).round()).abs() < 1e-9);
            last = read.velocity_m_per_s;
        }
        assert!((last - 0.02).abs() < 0.004, "{last}");
    }

    #[test]
    fn an_ideal_encoder_without_a_clutch_needs_no_reading() {
        assert!(reading(0.0, &[]).is_none());
        let tiny =
            MasterReading::<f64>::new(&EncoderSettings { encoder_resolution_m: 1e-200 }, 0.5, &[].into(), (1e-3, 0.0));
        assert!(tiny.expect_err("no velocity").to_string().contains("master.encoder_resolution_m"));
    }
}
