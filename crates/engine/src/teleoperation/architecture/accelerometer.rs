use trocar_core::lane::Lane;

/// `a_k = a_{k-1} + w ((v_k - v_{k-1}) / T - a_{k-1})`
#[derive(Debug, Clone)]
pub(super) struct Accelerometer<L> {
    weight: L,
    inverse_tick: L,
    velocity: L,
    acceleration: L,
}

impl<L: Lane> Accelerometer<L> {
    pub(super) fn new(bandwidth_hz: f64, tick_s: f64) -> Self {
        let weight = 1.0 - libm::exp(-std::f64::consts::TAU * bandwidth_hz * tick_s);
        let (weight, inverse_tick) = (L::splat(weight), L::splat(1.0 / tick_s));
        Self { weight, inverse_tick, velocity: L::zero(), acceleration: L::zero() }
    }

    #[inline(always)]
    pub(super) fn update(&mut self, velocity: L) -> L {
        let raw = (velocity - self.velocity) * self.inverse_tick;
        self.velocity = velocity;
        self.acceleration = self.acceleration + self.weight * (raw - self.acceleration);
        self.acceleration
    }
}

trocar_core::lane::gather!(Accelerometer { weight, inverse_tick, velocity, acceleration });

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_constant_acceleration_is_approached_at_the_bandwidth() {
        for tick_s in [1e-3, 5e-4] {
            let mut accelerometer = Accelerometer::<f64>::new(30.0, tick_s);
            for tick in 1..=200 {
                let acceleration = accelerometer.update(3.0 * tick_s * f64::from(tick));
                let rest = (-std::f64::consts::TAU * 30.0 * tick_s * f64::from(tick)).exp();
                assert!((acceleration - 3.0 * (1.0 - rest)).abs() < 1e-9, "{tick}: {acceleration}");
            }
        }
    }
}
