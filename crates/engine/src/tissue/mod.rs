mod depth;
mod generalised;
mod hunt_crossley;
mod kelvin_voigt;
mod layer;
mod layers;
pub mod literature;
mod model;
mod motion;
mod named_layers;
mod power;
mod recording;
mod replay;
mod shaft;
mod shaft_contact;
mod surface;
mod tearing;
mod tearing_layer;
#[cfg(test)]
mod tests;
mod viscoelastic;

pub use depth::{DepthCurves, DepthReplay};
pub use generalised::{Generalised, GeneralisedSettings, MAX_DEPTHS};
pub use hunt_crossley::{HuntCrossley, HuntCrossleySettings};
pub use kelvin_voigt::{KelvinVoigt, KelvinVoigtSettings};
pub use layer::LayerParameters;
pub use layers::{Layers, LayersParameters};
pub use model::{DefaultLayer, Model, Relaxation, Springs, StatedLayer};
pub use motion::{Moving, OrganMotion};
pub use named_layers::{LAYER_KEYS, LAYER_LIST, Named, path_in_layer};
pub use power::PowerSettings;
pub use recording::RecordedForce;
pub use replay::{Recording, ReplayIndex, ReplaySettings};
pub use shaft::ShaftParameters;
pub use surface::Surface;
pub use tearing::{Crack, Tearing, TearingSettings};
pub use tearing_layer::TearingLayer;

use self::literature::Outside;
use trocar_core::error::InvalidValue;
use trocar_core::lane::Lane;
use trocar_core::settings::{ActsFor, Key, acting, count_distinct, distinct};

#[derive(Debug, Clone, Copy)]
pub struct Reaction<L: Lane> {
    /// `f_e`, positive when the tissue resists insertion.
    pub force_n: L,
    /// Ground truth, for metrics only.
    pub ruptured: L::Mask,
}

/// A built-in tissue is one file of this folder and one row of the registry; a user-defined one implements this trait
/// for `f64`.
pub trait Tissue<L: Lane> {
    /// Once per tick, from 0.
    fn react(&mut self, tick: u64, position_m: L, velocity_m_per_s: L) -> Reaction<L>;

    /// Part of the last force.
    #[inline(always)]
    fn shaft_force_n(&self) -> L {
        L::zero()
    }
}

impl<L: Lane, T: Tissue<L> + ?Sized> Tissue<L> for Box<T> {
    #[inline(always)]
    fn react(&mut self, tick: u64, position_m: L, velocity_m_per_s: L) -> Reaction<L> {
        (**self).react(tick, position_m, velocity_m_per_s)
    }

    #[inline(always)]
    fn shaft_force_n(&self) -> L {
        (**self).shaft_force_n()
    }
}

trocar_core::registry! {
    /// Tissue: the recording's force; a spring and damper, linear (eq. 1), stiffening (eq. 2) or varying with depth
    /// (eq. 3-4); or layers that rupture at a force, or by the energy that a crack releases.
    #[derive(Debug, Clone, PartialEq)]
    pub enum TissueSettings at "tissue.kind" = Recording no const;
    pub enum StillTissue<L: Lane> by (each, of_kind);

    "recording" => Recording(ReplaySettings) = replay::Recording,
    "kelvin-voigt" => KelvinVoigt(KelvinVoigtSettings) = kelvin_voigt::KelvinVoigt,
    "hunt-crossley" => HuntCrossley(HuntCrossleySettings) = hunt_crossley::HuntCrossley,
    "generalised" => Generalised(GeneralisedSettings) = generalised::Generalised,
    "layers" => Layers(LayersParameters) = layers::Layers,
    "tearing" => Tearing(TearingSettings) = tearing::Tearing,
}

impl TissueSettings {
    pub const LIST_KEYS: &'static [Key] = {
        const GROUPS: &[&[Key]] = &of_kind!([WORD, Part] => {
            const LIST: &[Key] = <Part<f64> as Model>::LIST_KEYS;
            const COUNT: usize = LIST.len();
            &acting::<COUNT>(&[LIST], ActsFor::new(TissueSettings::KEY.path, &[WORD]))
        });
        &distinct::<{ count_distinct(GROUPS) }>(GROUPS)
    };

    pub fn default_layers(word: &str) -> Vec<DefaultLayer> {
        let all = of_kind!([WORD, Part] => (WORD, <Part<f64> as Model>::default_layers as fn() -> Vec<DefaultLayer>));
        all.into_iter().find(|(known, _)| *known == word).map_or_else(Vec::new, |(_, layers)| layers())
    }

    pub fn layers(&self) -> Vec<StatedLayer<'_>> {
        of_kind!(self, Part(kind_settings) => Part::<f64>::layers(kind_settings))
    }

    /// `None` for a recording.
    pub fn surface_m(&self) -> Option<f64> {
        of_kind!(self, Part(kind_settings) => Part::<f64>::surface_m(kind_settings))
    }

    pub fn springs(&self, depth_m: f64) -> Option<Springs> {
        of_kind!(self, Part(kind_settings) => Part::<f64>::springs(kind_settings, depth_m))
    }

    pub fn outside_measured(&self) -> Vec<Outside> {
        of_kind!(self, Part(kind_settings) => Part::<f64>::outside_measured(kind_settings))
    }

    pub fn check(&self, tick_s: f64, start_m: f64) -> Result<(), InvalidValue> {
        of_kind!(self, Part(kind_settings) => Part::<f64>::check(kind_settings, tick_s, start_m))
    }

    pub fn build<L: Lane>(&self, tick_s: f64, start_m: f64) -> Result<StillTissue<L>, InvalidValue> {
        of_kind!(self, Part(kind_settings) => Part::build(kind_settings, tick_s, start_m).map(StillTissue::<L>::from))
    }
}

impl<L: Lane> Tissue<L> for StillTissue<L> {
    #[inline(always)]
    fn react(&mut self, tick: u64, position_m: L, velocity_m_per_s: L) -> Reaction<L> {
        each!(self, tissue => tissue.react(tick, position_m, velocity_m_per_s))
    }

    #[inline(always)]
    fn shaft_force_n(&self) -> L {
        each!(self, tissue => tissue.shaft_force_n())
    }
}

#[derive(Debug, Clone)]
pub enum AnyTissue<L: Lane> {
    Still(StillTissue<L>),
    Moving(Box<Moving<L>>),
}

trocar_core::variants!(either of AnyTissue { Still, Moving });
trocar_core::lane::gather_variants!(AnyTissue { Still, Moving });

impl<L: Lane, T: Into<StillTissue<L>>> From<T> for AnyTissue<L> {
    fn from(tissue: T) -> Self {
        Self::Still(tissue.into())
    }
}

impl<L: Lane> Tissue<L> for AnyTissue<L> {
    #[inline(always)]
    fn react(&mut self, tick: u64, position_m: L, velocity_m_per_s: L) -> Reaction<L> {
        either!(self, tissue => tissue.react(tick, position_m, velocity_m_per_s))
    }

    #[inline(always)]
    fn shaft_force_n(&self) -> L {
        either!(self, tissue => tissue.shaft_force_n())
    }
}
