use trocar_core::error::{InvalidValue, require};
use trocar_core::lane::{Lane, Mask};

trocar_core::settings! {
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct PowerSettings in "tissue." {
        /// n of hunt-crossley and generalised, a multiple of 0.25 up to 7.75.
        power: f64 [NON_NEGATIVE] = 1.5,
    }
}

const MAX_QUARTERS: f64 = 31.0;

/// With n below 1 the slope is unbounded at the surface.
const MIN_DEPTH_M: f64 = 5e-4;

const DEPTHS: u32 = 1000;

/// Of `μ(p) pⁿ`; `mu` returns μ and its derivative. With n above 1 the slope at the surface is 0.
pub(super) fn slopes_n_per_m(mu: impl Fn(f64) -> (f64, f64), power: f64, depth_m: f64) -> (f64, f64) {
    let slope = |p: f64| {
        let (mu, change) = mu(p);
        change * p.powf(power) + power * mu * p.powf(power - 1.0)
    };
    if depth_m <= MIN_DEPTH_M {
        return (0.0, 0.0);
    }
    let share = |k: u32| f64::from(k) / f64::from(DEPTHS);
    let at = |k: u32| if k == DEPTHS { depth_m } else { MIN_DEPTH_M + (depth_m - MIN_DEPTH_M) * share(k) };
    let first = if power > 1.0 { 0.0 } else { slope(MIN_DEPTH_M) };
    (0..=DEPTHS).map(|k| slope(at(k))).fold((first, first), |(low, high), slope| (low.min(slope), high.max(slope)))
}

pub(super) fn largest_n(lambda: impl Fn(f64) -> f64, power: f64, depth_m: f64) -> f64 {
    let at = |k: u32| depth_m * f64::from(k) / f64::from(DEPTHS);
    (0..=DEPTHS).map(|k| lambda(at(k)) * at(k).powf(power)).fold(0.0, f64::max)
}

/// `pⁿ` for `n` a multiple of 0.25, by products and square roots: the same bits on every platform.
#[derive(Debug, Clone, Copy)]
pub(super) struct QuarterPower<L: Lane> {
    /// Parts 1/4, 1/2, 1, 2 and 4 of the power.
    parts: [L::Mask; 5],
}

impl<L: Lane> QuarterPower<L> {
    pub(super) fn new(settings: &PowerSettings) -> Result<Self, InvalidValue> {
        let power = settings.power;
        let quarters = 4.0 * power;
        let allowed = quarters.fract() == 0.0 && (0.0..=MAX_QUARTERS).contains(&quarters);
        require("tissue.power", power, allowed, "a multiple of 0.25 from 0 to 7.75")?;
        let bits = quarters as u32;
        Ok(Self { parts: std::array::from_fn(|bit| L::Mask::splat(bits >> bit & 1 == 1)) })
    }

    #[inline(always)]
    pub(super) fn of(&self, depth: L) -> L {
        let half = depth.sqrt();
        let square = depth * depth;
        let mut power = L::splat(1.0);
        for (mask, part) in self.parts.into_iter().zip([half.sqrt(), half, depth, square, square * square]) {
            power = power * L::select(mask, part, L::splat(1.0));
        }
        power
    }
}

impl trocar_core::lane::Gather for QuarterPower<f64> {
    type Of<L: Lane> = QuarterPower<L>;

    fn gather<L: Lane>(all: [&Self; trocar_core::lane::LANES]) -> Option<QuarterPower<L>> {
        let part = |bit: usize| trocar_core::lane::gather_mask::<L>(all.map(|one| one.parts[bit]));
        Some(QuarterPower { parts: std::array::from_fn(part) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn power(power: f64) -> QuarterPower<f64> {
        QuarterPower::new(&PowerSettings { power }).expect("a multiple of a quarter")
    }

    #[test]
    fn every_multiple_of_a_quarter_up_to_7_75_is_a_valid_power() {
        for quarters in 0..=31 {
            let exponent = 0.25 * f64::from(quarters);
            for depth in [0.25, 1.0, 2.0, 1e-3] {
                let expected = f64::powf(depth, exponent);
                assert!((power(exponent).of(depth) / expected - 1.0).abs() < 1e-12, "{depth} to {exponent}");
            }
        }
        let refused = |power| QuarterPower::<f64>::new(&PowerSettings { power }).is_err();
        assert_eq!([-0.25, 8.0, 1.3, f64::NAN].map(refused), [true; 4]);
    }

    #[test]
    fn the_slopes_are_the_extremes_of_the_derivative_down_to_the_depth() {
        let is_close =
            |(a, b): (f64, f64), (c, d): (f64, f64)| (a - c).abs() < 1e-9 * c.abs() + 1e-12 && (b - d).abs() < 1e-9 * d;
        // μ p²: from 0 to 2 μ p.
        assert!(is_close(slopes_n_per_m(|_| (500.0, 0.0), 2.0, 0.02), (0.0, 20.0)));
        // μ p: the constant μ, and nothing at the surface.
        assert!(is_close(slopes_n_per_m(|_| (500.0, 0.0), 1.0, 0.02), (500.0, 500.0)));
        // √p: steepest half a millimetre below the surface.
        let steepest = 0.5 * 3.0 / MIN_DEPTH_M.sqrt();
        assert!(is_close(slopes_n_per_m(|_| (3.0, 0.0), 0.5, 0.02), (0.5 * 3.0 / 0.02_f64.sqrt(), steepest)));
        // (1000 - 20000 p) p: 1000 - 40000 p.
        let falling = slopes_n_per_m(|p| (1000.0 - 2e4 * p, -2e4), 1.0, 0.03);
        assert!(is_close(falling, (-200.0, 1000.0 - 4e4 * MIN_DEPTH_M)), "{falling:?}");
        assert_eq!(slopes_n_per_m(|_| (500.0, 0.0), 1.0, MIN_DEPTH_M), (0.0, 0.0));
    }
}
