//! Tissue models: the force of the tissue on the needle.

mod depth;
mod failure;
mod fmu;
mod generalised;
mod hunt_crossley;
mod kelvin_voigt;
mod kind;
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
pub use failure::TissueFailure;
pub use fmu::{Fmu, FmuSettings, UnfitUnit, UnitProblem, UnitTissue};
pub use generalised::{Generalised, GeneralisedSettings, MAX_DEPTHS};
pub use hunt_crossley::{HuntCrossley, HuntCrossleySettings};
pub use kelvin_voigt::{KelvinVoigt, KelvinVoigtSettings};
pub use kind::{AnyTissue, StillTissue, TissueSettings};
pub use layer::LayerParameters;
pub use layers::{Layers, LayersParameters};
pub use model::{DefaultLayer, Model, Springs};
pub use motion::{Moving, OrganMotion};
pub use named_layers::{LAYER_KEYS, LAYER_LIST, Named, path_in_layer};
pub use power::PowerSettings;
pub use recording::RecordedForce;
pub use replay::{Recording, ReplayIndex, ReplaySettings};
pub use shaft::ShaftParameters;
pub use surface::Surface;
pub use tearing::{Crack, Tearing, TearingSettings};
pub use tearing_layer::TearingLayer;

use trocar_core::lane::Lane;

/// A tissue's reaction at one tick.
#[derive(Debug, Clone, Copy)]
pub struct Reaction<L: Lane> {
    /// `f_e` in N, positive when it resists insertion.
    pub force_n: L,
    /// Whether a layer ruptures at this tick: ground truth, for metrics only.
    pub ruptured: L::Mask,
}

/// Gives the tissue force for a position and velocity of the needle.
///
/// A user-defined tissue implements this for `f64`; the built-in ones for any number of lanes. A built-in tissue is one
/// file of this folder and one line in `kind.rs`.
pub trait Tissue<L: Lane> {
    /// The reaction at `tick` to a needle at `position_m` (m) moving at `velocity_m_per_s` (m/s). Called once per tick,
    /// starting at 0.
    fn react(&mut self, tick: u64, position_m: L, velocity_m_per_s: L) -> Reaction<L>;

    /// The part in N of the last reaction's force that acts on the shaft, not on the tip.
    #[inline(always)]
    fn shaft_force_n(&self) -> L {
        L::zero()
    }

    /// Why the tissue cannot go on, if it cannot: its forces are then not numbers, and the run ends with this error.
    fn failure(&self) -> Option<&TissueFailure> {
        None
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

    fn failure(&self) -> Option<&TissueFailure> {
        (**self).failure()
    }
}
