use super::model::{Model, Springs};
use super::surface::Surface;
use super::{Reaction, Tissue};
use trocar_core::error::InvalidValue;
use trocar_core::lane::{Lane, Mask};

trocar_core::settings! {
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct KelvinVoigtSettings in "tissue." {
        /// Stiffness K of kelvin-voigt.
        stiffness_n_per_m: f64 [NON_NEGATIVE] = 200.0,
        /// Damping B of kelvin-voigt.
        damping_n_s_per_m: f64 [NON_NEGATIVE] = 5.0,
        surface: Surface,
    }
}

/// `f = K p + B v` for `p > 0`, else 0, with `p = x_e - contact` (eq. 1, in this crate's sign).
#[derive(Debug, Clone, Copy)]
pub struct KelvinVoigt<L> {
    stiffness: L,
    damping: L,
    contact: L,
}

impl<L: Lane> KelvinVoigt<L> {
    pub fn new(settings: &KelvinVoigtSettings) -> Result<Self, InvalidValue> {
        settings.validate()?;
        Ok(Self {
            stiffness: L::splat(settings.stiffness_n_per_m),
            damping: L::splat(settings.damping_n_s_per_m),
            contact: L::splat(settings.surface.contact_m),
        })
    }
}

impl<L: Lane> Tissue<L> for KelvinVoigt<L> {
    #[inline(always)]
    fn react(&mut self, _tick: u64, position: L, velocity: L) -> Reaction<L> {
        let depth = position - self.contact;
        let force = self.stiffness * depth + self.damping * velocity;
        Reaction { force_n: L::select(depth.gt(L::zero()), force, L::zero()), ruptured: L::Mask::splat(false) }
    }
}

impl<L: Lane> Model for KelvinVoigt<L> {
    type Settings = KelvinVoigtSettings;

    fn build(settings: &KelvinVoigtSettings, _tick_s: f64, _start_m: f64) -> Result<Self, InvalidValue> {
        Self::new(settings)
    }

    fn surface_m(settings: &KelvinVoigtSettings) -> Option<f64> {
        Some(settings.surface.contact_m)
    }

    fn springs(settings: &KelvinVoigtSettings, _depth_m: f64) -> Option<Springs> {
        Some(Springs::constant(settings.stiffness_n_per_m, settings.damping_n_s_per_m))
    }
}

trocar_core::lane::gather!(KelvinVoigt { stiffness, damping, contact });

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tissue_is_a_spring_and_a_damper_below_its_surface() {
        let settings = KelvinVoigtSettings {
            stiffness_n_per_m: 123.0,
            damping_n_s_per_m: 4.5,
            surface: Surface { contact_m: 0.013 },
        };
        assert_eq!(KelvinVoigt::<f64>::springs(&settings, 0.0), Some(Springs::constant(123.0, 4.5)));
        assert_eq!(KelvinVoigt::<f64>::surface_m(&settings), Some(0.013));
        let mut tissue = KelvinVoigt::<f64>::new(&settings).expect("valid");
        assert_eq!(tissue.react(0, 0.013, 1.0).force_n, 0.0);
        let reaction = tissue.react(0, 0.023, 0.2);
        assert!((reaction.force_n - (1.23 + 0.9)).abs() < 1e-12 && !reaction.ruptured);
        assert!((tissue.react(0, 0.023, -0.4).force_n + 0.57).abs() < 1e-12, "a fast withdrawal pulls");
        assert_eq!(tissue.shaft_force_n(), 0.0);
    }
}
