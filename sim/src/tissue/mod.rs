//! What the needle meets: the force of the tissue on the slave.

mod depth;
mod generalised;
mod hunt_crossley;
mod kelvin_voigt;
mod layer;
mod layers;
pub mod literature;
mod power;
mod recording;
mod shaft;

pub use depth::{DepthCurves, DepthReplay};
pub use generalised::{Generalised, MAX_DEPTHS};
pub use hunt_crossley::HuntCrossley;
pub use kelvin_voigt::KelvinVoigt;
pub use layer::{LAYER_KEYS, LAYER_NAMES, LAYERS, LayerKeys, LayerParameters};
pub use layers::{Layers, LayersParameters};
pub use recording::RecordedForce;
pub use shaft::ShaftParameters;

use crate::lane::Lane;

/// A tissue's answer at one tick.
#[derive(Debug, Clone, Copy)]
pub struct Reaction<L: Lane> {
    /// `f_e` in N, positive when it resists insertion.
    pub force_n: L,
    /// Whether a layer ruptures at this tick: the truth, for metrics only.
    pub ruptured: L::Mask,
}

/// Answers to where the needle is with a force.
///
/// A tissue of one's own implements this for `f64`; the built-in ones do for any number of lanes. A built-in tissue is one file
/// of this folder and one line of [`tissues!`].
pub trait Tissue<L: Lane> {
    /// The reaction at `tick` to a needle at `position_m` (m) moving at `velocity_m_per_s` (m/s). Called once for each tick,
    /// from 0 on.
    fn react(&mut self, tick: u64, position_m: L, velocity_m_per_s: L) -> Reaction<L>;
}

impl<L: Lane, T: Tissue<L> + ?Sized> Tissue<L> for Box<T> {
    #[inline(always)]
    fn react(&mut self, tick: u64, position_m: L, velocity_m_per_s: L) -> Reaction<L> {
        (**self).react(tick, position_m, velocity_m_per_s)
    }
}

/// The enum of the built-in tissues, from a line each: variant and type.
macro_rules! tissues {
    ($($(#[$doc:meta])* $Variant:ident($Part:ty),)*) => {
        /// Any of the built-in tissues.
        #[derive(Debug, Clone)]
        pub enum AnyTissue<L: Lane> {
            $($(#[$doc])* $Variant($Part),)*
        }

        impl<L: Lane> Tissue<L> for AnyTissue<L> {
            #[inline(always)]
            fn react(&mut self, tick: u64, position_m: L, velocity_m_per_s: L) -> Reaction<L> {
                match self {
                    $(Self::$Variant(part) => part.react(tick, position_m, velocity_m_per_s),)*
                }
            }
        }

        crate::lane::gather_variants!(AnyTissue { $($Variant),* });
    };
}

tissues! {
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
