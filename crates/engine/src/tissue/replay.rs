use super::model::NEEDS_FILE;
use super::{DepthReplay, Model, Reaction, RecordedForce, Tissue};
use trocar_core::error::InvalidValue;
use trocar_core::lane::Lane;

trocar_core::settings! {
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct ReplaySettings in "tissue." {
        index: ReplayIndex,
    }
}

trocar_core::choice! {
    /// Replay the recording by time, or by depth, which makes the force on a frozen slave constant.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub enum ReplayIndex at "tissue.index" = Time {
        "time" => Time,
        "depth" => Depth in "tissue." {
            /// Travel over which the force changes to the force of the withdrawal when the needle retreats, in a replay
            /// by depth.
            presliding_m: f64 [POSITIVE] = 5e-3,
        },
    }
}

#[derive(Debug, Clone)]
pub enum Recording<L> {
    Time(RecordedForce),
    Depth(DepthReplay<L>),
}

impl<L: Lane> Model for Recording<L> {
    type Settings = ReplaySettings;

    fn build(_settings: &ReplaySettings, _tick_s: f64, _start_m: f64) -> Result<Self, InvalidValue> {
        Err(NEEDS_FILE)
    }

    fn check(_settings: &ReplaySettings, _tick_s: f64, _start_m: f64) -> Result<(), InvalidValue> {
        Ok(())
    }
}

impl<L: Lane> Tissue<L> for Recording<L> {
    #[inline(always)]
    fn react(&mut self, tick: u64, position_m: L, velocity_m_per_s: L) -> Reaction<L> {
        match self {
            Self::Time(replay) => replay.react(tick, position_m, velocity_m_per_s),
            Self::Depth(replay) => replay.react(tick, position_m, velocity_m_per_s),
        }
    }
}

trocar_core::lane::gather_variants!(Recording { Time, Depth });
