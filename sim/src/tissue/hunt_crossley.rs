//! The Hunt-Crossley model (eq. 2).

use super::power::QuarterPower;
use super::{Reaction, Tissue};
use crate::error::{InvalidValue, finite, non_negative};
use crate::lane::{Lane, Mask};

/// `f = μ pⁿ + λ pⁿ v` for `p > 0`, 0 otherwise, with `p = x_e - contact` (eq. 2, in this crate's sign).
///
/// The power is a whole number of quarters, from 0 to 7.75, so that nothing transcendental happens in the tick.
#[derive(Debug, Clone, Copy)]
pub struct HuntCrossley<L: Lane> {
    stiffness: L,
    damping: L,
    contact: L,
    power: QuarterPower<L>,
}

impl<L: Lane> HuntCrossley<L> {
    /// A tissue of μ (N/mⁿ) and λ (N·s/mⁿ⁺¹), both at least 0, and of power n, whose surface is at `contact_m` (m).
    ///
    /// # Errors
    /// [`InvalidValue`] naming the parameter out of range.
    pub fn new(mu: f64, lambda: f64, power: f64, contact_m: f64) -> Result<Self, InvalidValue> {
        Ok(Self {
            power: QuarterPower::new(power)?,
            stiffness: L::splat(non_negative("tissue.mu", mu)?),
            damping: L::splat(non_negative("tissue.lambda", lambda)?),
            contact: L::splat(finite("tissue.contact_m", contact_m)?),
        })
    }
}

impl<L: Lane> Tissue<L> for HuntCrossley<L> {
    #[inline(always)]
    fn react(&mut self, _tick: u64, position: L, velocity: L) -> Reaction<L> {
        let depth = (position - self.contact).max(L::zero());
        let power = self.power.of(depth);
        let force = self.stiffness * power + self.damping * power * velocity;
        let contact = depth.gt(L::zero());
        Reaction { force_n: L::select(contact, force, L::zero()), ruptured: L::Mask::splat(false) }
    }
}

crate::lane::gather!(HuntCrossley { stiffness, damping, contact, power });

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_eq_2_for_every_power_it_takes() {
        for quarters in 0..=31 {
            let power = 0.25 * f64::from(quarters);
            let mut tissue = HuntCrossley::<f64>::new(300.0, 20.0, power, 1e-3).expect("valid");
            for depth in [1e-6, 0.004, 0.05, 1.5] {
                let exact = 300.0 * f64::powf(depth, power) + 20.0 * f64::powf(depth, power) * 0.03;
                let force = tissue.react(0, 1e-3 + depth, 0.03).force_n;
                assert!((force - exact).abs() < 1e-9 * exact, "{power} at {depth}: {force} {exact}");
            }
            assert_eq!(tissue.react(0, 0.0, 1.0).force_n, 0.0);
        }
    }

    #[test]
    fn a_power_between_quarters_is_refused() {
        assert_eq!(HuntCrossley::<f64>::new(1.0, 1.0, 1.3, 0.0).expect_err("no").name, "tissue.power");
    }
}
