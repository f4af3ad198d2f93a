use super::model::{Model, Springs};
use super::power::{PowerSettings, QuarterPower, largest_n, slopes_n_per_m};
use super::surface::Surface;
use super::{Reaction, Tissue};
use trocar_core::error::{InvalidValue, non_negative, require};
use trocar_core::lane::{Lane, Mask};

pub const MAX_DEPTHS: usize = 16;

/// `value + Σ slope_j clamp(p - from_j, 0, width_j)`
#[derive(Debug, Clone, Copy)]
struct Profile<L> {
    value: L,
    slopes: [L; MAX_DEPTHS],
}

impl<L: Lane> Profile<L> {
    fn new(name: &'static str, depths_m: &[f64], values: &[f64]) -> Result<Self, InvalidValue> {
        let equal = values.len() == depths_m.len();
        require(name, values.len() as f64, equal, "a list as long as tissue.depths_m")?;
        for &value in values {
            non_negative(name, value)?;
        }
        let slope = |j: usize| match (depths_m.get(j..j + 2), values.get(j..j + 2)) {
            (Some([from, to]), Some([here, next])) => (next - here) / (to - from),
            _ => 0.0,
        };
        let value = values.first().copied().unwrap_or(0.0);
        Ok(Self { value: L::splat(value), slopes: std::array::from_fn(|j| L::splat(slope(j))) })
    }
}

trocar_core::settings! {
    #[derive(Debug, Clone, PartialEq)]
    pub struct GeneralisedSettings in "tissue." no const {
        surface: Surface,
        power: PowerSettings,
        /// Depths below the surface at which the coefficients of generalised are given: 1 to 16, ascending; linear
        /// between them.
        depths_m: Vec<f64> = [0.0, 0.02],
        /// μ of generalised at each depth, at least 0, in N/m^n.
        mus: Vec<f64> = [2000.0, 1000.0],
        /// λ of generalised at each depth, at least 0, in N·s/m^(n+1).
        lambdas: Vec<f64> = [200.0, 200.0],
    }
}

/// `f = K p + B v` for `p > 0`, else 0, with `K = μ(p) pⁿ⁻¹` and `B = λ(p) pⁿ` (eq. 3-4, in this crate's sign). The
/// paper does not state how its coefficients vary; here only with the depth `p = x_e - contact`.
#[derive(Debug, Clone, Copy)]
pub struct Generalised<L: Lane> {
    mu: Profile<L>,
    lambda: Profile<L>,
    from: [L; MAX_DEPTHS],
    width: [L; MAX_DEPTHS],
    pieces: usize,
    contact: L,
    power: QuarterPower<L>,
}

impl<L: Lane> Generalised<L> {
    pub fn new(settings: &GeneralisedSettings) -> Result<Self, InvalidValue> {
        settings.validate()?;
        let depths_m = &settings.depths_m;
        let count = depths_m.len();
        require("tissue.depths_m", count as f64, (1..=MAX_DEPTHS).contains(&count), "a list of 1 to 16 depths")?;
        for pair in depths_m.windows(2) {
            require("tissue.depths_m", pair[1], pair[1] - pair[0] >= 1e-6, "ascending, by 1e-6 or more each")?;
        }
        let from = |j: usize| depths_m.get(j).copied().unwrap_or(0.0);
        let width = |j: usize| depths_m.get(j + 1).map_or(0.0, |to| to - from(j));
        Ok(Self {
            mu: Profile::new("tissue.mus", depths_m, &settings.mus)?,
            lambda: Profile::new("tissue.lambdas", depths_m, &settings.lambdas)?,
            from: std::array::from_fn(|j| L::splat(from(j))),
            width: std::array::from_fn(|j| L::splat(width(j))),
            pieces: count - 1,
            contact: L::splat(settings.surface.contact_m),
            power: QuarterPower::new(&settings.power)?,
        })
    }
}

impl<L: Lane> Tissue<L> for Generalised<L> {
    #[inline(always)]
    fn react(&mut self, _tick: u64, position: L, velocity: L) -> Reaction<L> {
        let depth = (position - self.contact).max(L::zero());
        let (mut mu, mut lambda) = (self.mu.value, self.lambda.value);
        for j in 0..self.pieces {
            let along = (depth - self.from[j]).clamp(L::zero(), self.width[j]);
            mu = mu + self.mu.slopes[j] * along;
            lambda = lambda + self.lambda.slopes[j] * along;
        }
        let force = (mu + lambda * velocity) * self.power.of(depth);
        let contact = depth.gt(L::zero());
        Reaction { force_n: L::select(contact, force, L::zero()), ruptured: L::Mask::splat(false) }
    }
}

impl<L: Lane> Model for Generalised<L> {
    type Settings = GeneralisedSettings;

    fn build(settings: &GeneralisedSettings, _tick_s: f64, _start_m: f64) -> Result<Self, InvalidValue> {
        Self::new(settings)
    }

    fn surface_m(settings: &GeneralisedSettings) -> Option<f64> {
        Some(settings.surface.contact_m)
    }

    fn springs(settings: &GeneralisedSettings, depth_m: f64) -> Option<Springs> {
        let GeneralisedSettings { depths_m, mus, lambdas, .. } = settings;
        let at = |values: &[f64], depth_m: f64| {
            let end = depths_m.partition_point(|&given_m| given_m <= depth_m).min(depths_m.len() - 1);
            match end.checked_sub(1) {
                Some(begin) if depth_m < depths_m[end] => {
                    let slope = (values[end] - values[begin]) / (depths_m[end] - depths_m[begin]);
                    (values[begin] + slope * (depth_m - depths_m[begin]), slope)
                }
                _ => (values[end], 0.0),
            }
        };
        let mu = |depth_m: f64| at(mus, depth_m);
        let power = settings.power.power;
        let damping = largest_n(|depth_m| at(lambdas, depth_m).0, power, depth_m);
        Some(Springs::between(slopes_n_per_m(mu, power, depth_m), (0.0, damping)))
    }
}

trocar_core::lane::gather!(Profile { value, slopes });
trocar_core::lane::gather!(Generalised { mu, lambda, from, width, contact, power } same { pieces });

#[cfg(test)]
mod tests {
    use super::super::{HuntCrossley, HuntCrossleySettings};
    use super::*;

    fn settings(depths_m: &[f64], mus: &[f64], lambdas: &[f64], power: f64, contact_m: f64) -> GeneralisedSettings {
        let (depths_m, mus, lambdas) = (depths_m.into(), mus.into(), lambdas.into());
        let (surface, power) = (Surface { contact_m }, PowerSettings { power });
        GeneralisedSettings { surface, power, depths_m, mus, lambdas }
    }

    #[test]
    fn the_coefficients_are_linear_between_the_depths() {
        let settings = settings(&[0.01, 0.02, 0.04], &[100.0, 300.0, 0.0], &[0.0, 10.0, 10.0], 1.0, 5e-3);
        let mut tissue = Generalised::<f64>::new(&settings).expect("valid");
        for (p, mu, lambda) in
            [(0.005, 100.0, 0.0), (0.01, 100.0, 0.0), (0.015, 200.0, 5.0), (0.03, 150.0, 10.0), (0.05, 0.0, 10.0)]
        {
            let force = tissue.react(0, 5e-3 + p, 0.2).force_n;
            assert!((force - (mu * p + lambda * p * 0.2)).abs() < 1e-12, "{p}: {force}");
        }
        assert_eq!(tissue.react(0, 5e-3, 1.0).force_n, 0.0);
    }

    #[test]
    fn with_one_depth_the_model_is_hunt_crossley() {
        let settings = settings(&[0.0], &[2000.0], &[200.0], 1.5, 1e-3);
        let mut general = Generalised::<f64>::new(&settings).expect("valid");
        let (surface, power) = (settings.surface, settings.power);
        let even = HuntCrossleySettings { surface, mu: 2000.0, lambda: 200.0, power };
        let mut model = HuntCrossley::<f64>::new(&even).expect("valid");
        for k in -10..100 {
            let (x, v) = (1e-3 * f64::from(k), 0.01 * f64::from(k % 7 - 3));
            assert!((general.react(0, x, v).force_n - model.react(0, x, v).force_n).abs() < 1e-12);
        }
    }

    #[test]
    fn the_slopes_are_the_slopes_of_the_force() {
        for (mus, power) in [(vec![100.0, 300.0, 50.0], 1.0), (vec![2000.0, 1000.0, 1000.0], 1.5), (vec![5.0; 3], 0.5)]
        {
            let settings = settings(&[0.0, 0.01, 0.02], &mus, &[0.0; 3], power, 5e-3);
            let mut tissue = Generalised::<f64>::new(&settings).expect("valid");
            let mut force_n = |depth_m: f64| tissue.react(0, 5e-3 + depth_m, 0.0).force_n;
            let slopes = (1..=2900).map(|k| {
                let depth_m = 1e-3 + 1e-5 * f64::from(k);
                (force_n(depth_m) - force_n(depth_m - 1e-5)) / 1e-5
            });
            let (least, largest) = slopes.fold((f64::MAX, f64::MIN), |(a, b), slope| (a.min(slope), b.max(slope)));
            let springs = <Generalised<f64> as Model>::springs(&settings, 0.03).expect("stated");
            let (low, high) = springs.stiffness_n_per_m;
            assert!(low <= least.max(0.0) + 0.5 && largest <= high + 0.5, "{low} {least} {largest} {high}");
        }
    }

    #[test]
    fn impossible_lists_are_refused() {
        let refused = |depths_m: &[f64], mus: &[f64], lambdas: &[f64]| {
            Generalised::<f64>::new(&settings(depths_m, mus, lambdas, 1.0, 0.0)).err().map(|error| error.name)
        };
        assert_eq!(refused(&[0.0, 0.01], &[1.0, 2.0], &[3.0, 4.0]), None);
        assert_eq!(refused(&[], &[], &[]), Some("tissue.depths_m"));
        let (depths_m, ones): (Vec<f64>, [f64; 17]) = ((0..17).map(|k| 1e-3 * f64::from(k)).collect(), [1.0; 17]);
        assert_eq!(refused(&depths_m, &ones, &ones), Some("tissue.depths_m"));
        assert_eq!(refused(&depths_m[..16], &ones[..16], &ones[..16]), None);
        assert_eq!(refused(&[0.0, 0.0], &[1.0; 2], &[1.0; 2]), Some("tissue.depths_m"), "not ascending");
        assert_eq!(refused(&[0.0, 0.01], &[1.0], &[1.0; 2]), Some("tissue.mus"));
        assert_eq!(refused(&[0.0, 0.01], &[1.0; 2], &[1.0, -1.0]), Some("tissue.lambdas"));
    }
}
