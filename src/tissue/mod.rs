//! What the needle meets: the force of the tissue on the slave.

mod depth;
mod hunt_crossley;
mod kelvin_voigt;
mod recording;

pub use depth::DepthReplay;
pub use hunt_crossley::HuntCrossley;
pub use kelvin_voigt::KelvinVoigt;
pub use recording::RecordedForce;

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
}

impl<L: Lane> Tissue<L> {
    /// The reaction at `tick` to a slave at `position_m` (m) moving at `velocity_m_per_s` (m/s).
    #[inline(always)]
    pub fn react(&mut self, tick: u64, position_m: L, velocity_m_per_s: L) -> Reaction<L> {
        match self {
            Self::Recording(recording) => recording.react(tick),
            Self::Depth(tissue) => tissue.react(position_m),
            Self::KelvinVoigt(tissue) => tissue.react(position_m, velocity_m_per_s),
            Self::HuntCrossley(tissue) => tissue.react(position_m, velocity_m_per_s),
        }
    }
}
