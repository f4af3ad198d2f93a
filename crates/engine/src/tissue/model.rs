//! The interface of a built-in tissue to the registry.

use super::literature::Outside;
use trocar_core::error::InvalidValue;
use trocar_core::settings::Key;

/// Error for a tissue that cannot be built from its settings alone.
pub(super) const NEEDS_FILE: InvalidValue =
    InvalidValue { name: "tissue.kind", value: 0.0, requirement: "built with its file", item: None };

/// The springs and dampers that a tissue shows to a linear loop between ruptures. A fall of the force is not a spring.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Springs {
    /// Smallest and largest slope of the force over the position while the needle advances, in N/m.
    pub stiffness_n_per_m: (f64, f64),
    /// Largest slope while the needle is drawn back, in N/m.
    pub drawn_back_n_per_m: f64,
    /// Smallest and largest damping, in N·s/m.
    pub damping_n_s_per_m: (f64, f64),
    /// The relaxation of the stiffest spring, if it relaxes.
    pub relaxation: Option<Relaxation>,
}

/// The relaxation of a spring with the stiffness `K` of a fast deflection: `relaxed_share · K` remains of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Relaxation {
    /// Stiffness of a slow deflection over that of a fast one, from 0 to 1.
    pub relaxed_share: f64,
    /// Time constant of a held deflection, in s.
    pub time_s: f64,
}

impl Springs {
    /// A spring (N/m) and a damper (N·s/m).
    #[must_use]
    pub fn constant(stiffness_n_per_m: f64, damping_n_s_per_m: f64) -> Self {
        Self::between((stiffness_n_per_m, stiffness_n_per_m), (damping_n_s_per_m, damping_n_s_per_m))
    }

    /// Springs (N/m) and dampers (N·s/m) that are the same in both directions of the needle. A slope below 0 is a fall.
    #[must_use]
    pub fn between((low, high): (f64, f64), damping_n_s_per_m: (f64, f64)) -> Self {
        let high = high.max(0.0);
        let stiffness_n_per_m = (low.max(0.0), high);
        Self { stiffness_n_per_m, drawn_back_n_per_m: high, damping_n_s_per_m, relaxation: None }
    }

    /// The springs and dampers of both, without relaxation.
    #[must_use]
    pub fn and(&self, other: &Self) -> Self {
        let both = |(low, high): (f64, f64), other: (f64, f64)| (low.min(other.0), high.max(other.1));
        Self {
            stiffness_n_per_m: both(self.stiffness_n_per_m, other.stiffness_n_per_m),
            drawn_back_n_per_m: self.drawn_back_n_per_m.max(other.drawn_back_n_per_m),
            damping_n_s_per_m: both(self.damping_n_s_per_m, other.damping_n_s_per_m),
            relaxation: None,
        }
    }
}

/// A default layer: its name, and the values of the keys that differ from the defaults.
pub type DefaultLayer = (&'static str, Vec<(&'static str, f64)>);

/// Properties of a layer, from its settings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StatedLayer<'a> {
    /// Name of the layer.
    pub name: &'a str,
    /// Thickness in m.
    pub thickness_m: f64,
    /// True if the layer ruptures. Other layers are cut without a rupture.
    pub ruptures: bool,
    /// Deflection at the rupture, in m.
    pub deflection_m: f64,
}

/// Requirements of the registry besides the trait.
pub trait Model: Sized {
    /// Settings of the tissue.
    type Settings;
    /// Keys of a layer in the list of layers.
    const LIST_KEYS: &'static [Key] = &[];

    /// Creates the tissue, with the needle tip at `start_m`.
    ///
    /// # Errors
    /// [`InvalidValue`] naming the setting out of range; also if the tissue needs a file.
    fn build(settings: &Self::Settings, tick_s: f64, start_m: f64) -> Result<Self, InvalidValue>;

    /// Checks the settings for [`Model::build`]. A tissue that needs memory checks them without building.
    ///
    /// # Errors
    /// See [`Model::build`].
    fn check(settings: &Self::Settings, tick_s: f64, start_m: f64) -> Result<(), InvalidValue> {
        Self::build(settings, tick_s, start_m).map(drop)
    }

    /// The layers of a scenario that lists none.
    fn default_layers() -> Vec<DefaultLayer> {
        vec![]
    }

    /// The layers, from the surface down. Each ruptures at most once, and in this order.
    fn layers(_settings: &Self::Settings) -> Vec<StatedLayer<'_>> {
        vec![]
    }

    /// The surface of the undeformed tissue, in m; `None` if it is unknown.
    fn surface_m(_settings: &Self::Settings) -> Option<f64> {
        None
    }

    /// The springs and dampers down to a depth in m below the surface; `None` if they depend on an unknown depth. The
    /// linear loop does not cover a tissue without this statement.
    fn springs(_settings: &Self::Settings, _depth_m: Option<f64>) -> Option<Springs> {
        None
    }

    /// The properties outside the range of the measurements.
    fn outside_measured(_settings: &Self::Settings) -> Vec<Outside> {
        vec![]
    }
}
