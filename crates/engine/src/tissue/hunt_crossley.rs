use super::model::{Model, Springs};
use super::power::{PowerSettings, QuarterPower, slopes_n_per_m};
use super::surface::Surface;
use super::{Reaction, Tissue};
use trocar_core::error::InvalidValue;
use trocar_core::lane::{Lane, Mask};

trocar_core::settings! {
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct HuntCrossleySettings in "tissue." {
        surface: Surface,
        /// μ of hunt-crossley, in N/m^n.
        mu: f64 [NON_NEGATIVE] = 2000.0,
        /// λ of hunt-crossley, in N·s/m^(n+1).
        lambda: f64 [NON_NEGATIVE] = 200.0,
        power: PowerSettings,
    }
}

/// `f = μ pⁿ + λ pⁿ v` for `p > 0`, else 0, with `p = x_e - contact` (eq. 2, in this crate's sign).
#[derive(Debug, Clone, Copy)]
pub struct HuntCrossley<L: Lane> {
    stiffness: L,
    damping: L,
    contact: L,
    power: QuarterPower<L>,
}

impl<L: Lane> HuntCrossley<L> {
    pub fn new(settings: &HuntCrossleySettings) -> Result<Self, InvalidValue> {
        settings.validate()?;
        Ok(Self {
            stiffness: L::splat(settings.mu),
            damping: L::splat(settings.lambda),
            contact: L::splat(settings.surface.contact_m),
            power: QuarterPower::new(&settings.power)?,
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

impl<L: Lane> Model for HuntCrossley<L> {
    type Settings = HuntCrossleySettings;

    fn build(settings: &HuntCrossleySettings, _tick_s: f64, _start_m: f64) -> Result<Self, InvalidValue> {
        Self::new(settings)
    }

    fn surface_m(settings: &HuntCrossleySettings) -> Option<f64> {
        Some(settings.surface.contact_m)
    }

    fn springs(settings: &HuntCrossleySettings, depth_m: f64) -> Option<Springs> {
        let power = settings.power.power;
        let damping = settings.lambda * depth_m.powf(power);
        Some(Springs::between(slopes_n_per_m(|_| (settings.mu, 0.0), power, depth_m), (0.0, damping)))
    }
}

trocar_core::lane::gather!(HuntCrossley { stiffness, damping, contact, power });

#[cfg(test)]
mod tests {
    use super::*;

    fn tissue(mu: f64, lambda: f64, power: f64, contact_m: f64) -> Result<HuntCrossley<f64>, InvalidValue> {
        let (surface, power) = (Surface { contact_m }, PowerSettings { power });
        HuntCrossley::new(&HuntCrossleySettings { surface, mu, lambda, power })
    }

    #[test]
    fn the_force_is_eq_2_for_every_allowed_power() {
        for quarters in 0..=31 {
            let power = 0.25 * f64::from(quarters);
            let mut tissue = tissue(300.0, 20.0, power, 1e-3).expect("valid");
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
        assert_eq!(tissue(1.0, 1.0, 1.3, 0.0).expect_err("no").name, "tissue.power");
    }

    #[test]
    fn the_spring_stiffens_from_the_surface_down_to_the_depth() {
        let settings = HuntCrossleySettings { mu: 500.0, power: PowerSettings { power: 2.0 }, ..Default::default() };
        let springs = HuntCrossley::<f64>::springs(&settings, 0.02).expect("stated");
        let ((low, high), (_, damping)) = (springs.stiffness_n_per_m, springs.damping_n_s_per_m);
        assert!(low == 0.0 && (high - 20.0).abs() < 1e-9, "{low} {high}");
        assert!((damping - settings.lambda * 4e-4).abs() < 1e-12, "{damping}");
        let surface = Surface { contact_m: 0.013 };
        assert_eq!(HuntCrossley::<f64>::surface_m(&HuntCrossleySettings { surface, ..settings }), Some(0.013));
    }

    #[test]
    fn a_needle_that_retreats_faster_than_the_tissue_is_pulled() {
        let mut tissue = tissue(300.0, 20.0, 1.0, 0.0).expect("valid");
        assert!((tissue.react(0, 0.01, -20.0).force_n + 1.0).abs() < 1e-12);
        assert!(!tissue.react(0, 0.01, 1.0).ruptured);
    }
}
