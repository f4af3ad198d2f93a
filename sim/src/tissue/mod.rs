//! What the needle meets: the force of the tissue on the slave.

mod depth;
mod generalised;
mod hunt_crossley;
mod kelvin_voigt;
mod kind;
mod layer;
mod layers;
pub mod literature;
mod power;
mod recording;
mod replay;
mod shaft;
mod surface;

pub use depth::DepthReplay;
pub use generalised::{Generalised, GeneralisedSettings, MAX_DEPTHS};
pub use hunt_crossley::{HuntCrossley, HuntCrossleySettings};
pub use kelvin_voigt::{KelvinVoigt, KelvinVoigtSettings};
pub use kind::{Model, TissueSettings};
pub use layer::{LAYER_KEYS, LAYER_NAMES, LAYERED_KEYS, LAYERS, LayerKeys, LayerParameters};
pub use layers::{Layers, LayersParameters};
pub use power::PowerSettings;
pub use recording::RecordedForce;
pub use replay::{ReplayIndex, ReplaySettings};
pub use shaft::ShaftParameters;
pub use surface::Surface;

use crate::lane::Lane;

/// A tissue's answer at one tick.
#[derive(Debug, Clone, Copy)]
pub struct Reaction<L: Lane> {
    /// `f_e` in N, positive when it resists insertion.
    pub force_n: L,
    /// Whether a layer ruptures at this tick: the truth, for metrics only.
    pub ruptured: L::Mask,
}

/// The kinds of tissue.
#[derive(Debug, Clone)]
pub enum Tissue<L: Lane> {
    /// A recorded force, replayed over time whatever the slave does.
    Recording(RecordedForce),
    /// A recorded force, replayed by depth: it answers to where the slave is.
    Depth(DepthReplay<L>),
    /// A spring and a damper in parallel (eq. 1).
    KelvinVoigt(KelvinVoigt<L>),
    /// A spring and a damper that stiffen with depth (eq. 2).
    HuntCrossley(HuntCrossley<L>),
    /// A spring and a damper whose coefficients vary with depth (eq. 3-4).
    Generalised(Box<Generalised<L>>),
    /// Layers that bulge, give way, are cut through, and hold the shaft.
    Layers(Box<Layers<L>>),
}

impl<L: Lane> Tissue<L> {
    /// No tissue: nothing resists.
    #[must_use]
    pub(crate) fn nothing() -> Self {
        Self::KelvinVoigt(KelvinVoigt::nothing())
    }

    /// The reaction at `tick` to a slave at `position_m` (m) moving at `velocity_m_per_s` (m/s).
    #[inline(always)]
    pub fn react(&mut self, tick: u64, position_m: L, velocity_m_per_s: L) -> Reaction<L> {
        match self {
            Self::Recording(recording) => recording.react(tick),
            Self::Depth(tissue) => tissue.react(position_m),
            Self::KelvinVoigt(tissue) => tissue.react(position_m, velocity_m_per_s),
            Self::HuntCrossley(tissue) => tissue.react(position_m, velocity_m_per_s),
            // Out of line but for lanes side by side, which a call would take out of their registers.
            Self::Generalised(tissue) if L::WIDTH > 1 => tissue.react_here(position_m, velocity_m_per_s),
            Self::Generalised(tissue) => tissue.react(position_m, velocity_m_per_s),
            Self::Layers(tissue) if L::WIDTH > 1 => tissue.react(position_m, velocity_m_per_s),
            Self::Layers(tissue) => tissue.react_apart(position_m, velocity_m_per_s),
        }
    }
}

crate::lane::gather_variants!(Tissue { Recording, Depth, KelvinVoigt, HuntCrossley, Generalised, Layers });
