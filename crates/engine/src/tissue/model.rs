use super::literature::Outside;
use trocar_core::error::InvalidValue;
use trocar_core::settings::Key;

pub(super) const NEEDS_FILE: InvalidValue =
    InvalidValue { name: "tissue.kind", value: 0.0, requirement: "built with its file", item: None };

/// The springs and dampers between ruptures; a fall of the force is not a spring.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Springs {
    /// Smallest and largest slope while the needle advances.
    pub stiffness_n_per_m: (f64, f64),
    pub drawn_back_n_per_m: f64,
    pub damping_n_s_per_m: (f64, f64),
    pub relaxation: Option<Relaxation>,
}

/// Relaxes from `K` to `relaxed_share · K`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Relaxation {
    pub relaxed_share: f64,
    pub time_s: f64,
}

impl Springs {
    pub fn constant(stiffness_n_per_m: f64, damping_n_s_per_m: f64) -> Self {
        Self::between((stiffness_n_per_m, stiffness_n_per_m), (damping_n_s_per_m, damping_n_s_per_m))
    }

    pub fn between((low, high): (f64, f64), damping_n_s_per_m: (f64, f64)) -> Self {
        let high = high.max(0.0);
        let stiffness_n_per_m = (low.max(0.0), high);
        Self { stiffness_n_per_m, drawn_back_n_per_m: high, damping_n_s_per_m, relaxation: None }
    }

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

pub type DefaultLayer = (&'static str, Vec<(&'static str, f64)>);

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StatedLayer<'a> {
    pub name: &'a str,
    pub thickness_m: f64,
    pub ruptures: bool,
    pub deflection_m: f64,
}

pub trait Model: Sized {
    type Settings;
    const LIST_KEYS: &'static [Key] = &[];

    fn build(settings: &Self::Settings, tick_s: f64, start_m: f64) -> Result<Self, InvalidValue>;

    /// For tissues that take much memory to build.
    fn check(settings: &Self::Settings, tick_s: f64, start_m: f64) -> Result<(), InvalidValue> {
        Self::build(settings, tick_s, start_m).map(drop)
    }

    fn default_layers() -> Vec<DefaultLayer> {
        vec![]
    }

    fn layers(_settings: &Self::Settings) -> Vec<StatedLayer<'_>> {
        vec![]
    }

    fn surface_m(_settings: &Self::Settings) -> Option<f64> {
        None
    }

    /// Up to a depth in m; `None` if the model states none.
    fn springs(_settings: &Self::Settings, _depth_m: f64) -> Option<Springs> {
        None
    }

    fn outside_measured(_settings: &Self::Settings) -> Vec<Outside> {
        vec![]
    }
}
