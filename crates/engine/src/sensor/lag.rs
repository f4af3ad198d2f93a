use trocar_core::lane::Lane;

/// `τ y' = u - y`, `τ = 1/(2π f)`, for an input that is linear between ticks:
///
/// ```text
/// y_k = a y_{k-1} + b_0 u_{k-1} + b_1 u_k
/// a = exp(-T/τ),  q = (1 - a) τ/T,  b_0 = q - a,  b_1 = 1 - q
/// ```
/// A held input would leave a delay of one tick at a large bandwidth.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lag<L> {
    keep: L,
    before: L,
    now: L,
    output: L,
    input: L,
}

impl<L: Lane> Lag<L> {
    pub(super) fn new(bandwidth_hz: f64, tick_s: f64, input: f64) -> Self {
        let ticks = std::f64::consts::TAU * bandwidth_hz * tick_s;
        let keep = libm::exp(-ticks);
        // Below the smallest normal number the output is constant.
        let mean = if ticks > f64::MIN_POSITIVE { -libm::expm1(-ticks) / ticks } else { 1.0 };
        Self {
            keep: L::splat(keep),
            before: L::splat(mean - keep),
            now: L::splat(1.0 - mean),
            output: L::splat(input),
            input: L::splat(input),
        }
    }

    #[inline(always)]
    pub(super) fn update(&mut self, input: L) -> L {
        self.output = self.keep * self.output + self.before * self.input + self.now * input;
        self.input = input;
        self.output
    }
}

trocar_core::lane::gather!(Lag { keep, before, now, output, input });

#[cfg(test)]
mod tests {
    use super::*;

    const TICK_S: f64 = 1e-3;

    fn time_constant_s(bandwidth_hz: f64) -> f64 {
        1.0 / (std::f64::consts::TAU * bandwidth_hz)
    }

    #[test]
    fn a_ramp_is_followed_as_in_the_closed_form() {
        let tau = time_constant_s(40.0);
        let mut lag = Lag::<f64>::new(40.0, TICK_S, 0.0);
        for k in 0..100 {
            let t = f64::from(k) * TICK_S;
            let expected = t - tau * (1.0 - (-t / tau).exp());
            assert!((lag.update(t) - expected).abs() < 1e-15, "{k}");
        }
    }

    #[test]
    fn a_wide_band_passes_the_input_and_a_zero_band_blocks_it() {
        let (mut wide, mut narrow) = (Lag::<f64>::new(1e12, TICK_S, 0.0), Lag::<f64>::new(1e-300, TICK_S, 2.0));
        for k in 0..50 {
            let input = (f64::from(k) * 0.7).sin();
            assert!((wide.update(input) - input).abs() < 1e-8);
            assert_eq!(narrow.update(input), 2.0);
        }
    }
}
