use trocar_core::settings::{Key, KeySource, count, joined};

use super::literature::{Outside, outside};
use super::model::{DefaultLayer, Model, Relaxation, Springs, StatedLayer};
use super::named_layers::{Named, check_layers, measured_layers, read_layers};
use super::shaft::{Shaft, ShaftParameters};
use super::shaft_contact::ShaftContact;
use super::surface::{Surface, starts_outside};
use super::tearing_layer::TearingLayer;
use super::viscoelastic::Viscoelastic;
use super::{Reaction, Tissue};
use trocar_core::error::InvalidValue;
use trocar_core::lane::{Lane, Mask};

/// Start of an unreached layer, deeper than any run.
const FAR_M: f64 = 1e9;

trocar_core::settings! {
    /// A common needle, and ruptures of 30 ms as in the recordings (chosen here).
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Crack in "tissue." {
        /// w: width of the crack that the needle cuts in layers that tear.
        crack_width_m: f64 [POSITIVE] = 1e-3,
        /// Maximum speed of the tip of this crack.
        crack_speed_m_per_s: f64 [POSITIVE] = 0.3,
    }
}

#[derive(Debug, Clone, PartialEq)]
pub struct TearingSettings {
    pub surface: Surface,
    pub crack: Crack,
    pub shaft: ShaftParameters,
    pub layers: Vec<Named<TearingLayer>>,
}

impl TearingSettings {
    pub const KEYS: &'static [Key] = &joined::<{ count(Self::GROUPS) }>(Self::GROUPS);

    const GROUPS: &'static [&'static [Key]] = &[Surface::KEYS, Crack::KEYS, ShaftParameters::KEYS];

    pub fn read<S: KeySource>(source: &mut S) -> Result<Self, S::Error> {
        let (surface, crack, shaft) = (Surface::read(source)?, Crack::read(source)?, ShaftParameters::read(source)?);
        let layers = read_layers(source, TearingLayer::read)?;
        Ok(Self { surface, crack, shaft, layers })
    }

    pub fn validate(&self) -> Result<(), InvalidValue> {
        self.surface.validate()?;
        self.crack.validate()?;
        self.shaft.validate()?;
        check_layers(&self.layers, TearingLayer::validate)
    }

    pub fn validate_on_ticks(&self, tick_s: f64) -> Result<(), InvalidValue> {
        self.surface.validate()?;
        self.crack.validate()?;
        self.shaft.validate()?;
        check_layers(&self.layers, |layer| layer.validate_on_ticks(tick_s))
    }
}

impl Default for TearingSettings {
    fn default() -> Self {
        let (surface, crack, shaft) = (Surface::DEFAULT, Crack::DEFAULT, ShaftParameters::DEFAULT);
        Self { surface, crack, shaft, layers: vec![("organ".into(), TearingLayer::DEFAULT)] }
    }
}

/// A viscoelastic layer with a crack at the depth `front` and the deflection `d = x - front`. A crack is faster than
/// any relaxation, so its energy release rate depends on the unrelaxed compliance `1/k₀`, which a crack of area `ℓ w`
/// doubles; the Maxwell branch's force `f_1` acts closer to the crack's tip:
///
/// ```text
/// J = f (f + χ f_1)/2 · dC/dA,   dC/dA = 1/(k₀ w ℓ)
/// ```
/// The layer ruptures when `J` reaches the toughness `R`. Then the crack advances while the force is above that of
/// steady cutting, `R w` (Azar and Hayward 2008):
///
/// ```text
/// front ← max(front, min(x - d_c, front + c_r T)),   d_c the deflection at the force R w; at 0 after the bottom
/// ```
/// The tissue never pulls: a needle that retreats faster than the layer recovers loses contact. A rupture extends a
/// crack suddenly (Mahvash and Dupont 2010); the form of `J` with `χ` is chosen here.
#[derive(Debug, Clone)]
pub struct Tearing<L: Lane> {
    layers: Box<[Layer<L>]>,
    first: usize,
    begun: usize,
    reach_m: L,
    shaft: Shaft<L>,
    held: ShaftContact<L>,
    friction_n: L,
}

#[derive(Debug, Clone, Copy)]
struct Layer<L: Lane> {
    solid: Viscoelastic<L>,
    front: L,
    start: L,
    bottom: L,
    thickness: L,
    /// 0 when the layer is cut through.
    cutting_n: L,
    /// `2 k₀ w ℓ R`.
    rupture_n2: L,
    concentration: L,
    friction: L,
    grip: L,
    ruptures: L::Mask,
    is_begun: L::Mask,
    is_open: L::Mask,
    is_through: L::Mask,
    is_done: L::Mask,
}

impl<L: Lane> Layer<L> {
    fn new(parameters: &TearingLayer, crack_width_m: f64, tick_s: f64) -> Self {
        let TearingLayer { stiffness_n_per_m, stiffening_n_per_m2, relaxed_share, relaxation_time_s, .. } = *parameters;
        let rupture_n = parameters.rupture_force_n(crack_width_m);
        let no = L::Mask::splat(false);
        Self {
            solid: Viscoelastic::new(stiffness_n_per_m, stiffening_n_per_m2, relaxed_share, relaxation_time_s, tick_s),
            front: L::splat(FAR_M),
            start: L::splat(FAR_M),
            bottom: L::splat(FAR_M),
            thickness: L::splat(parameters.thickness_m),
            cutting_n: L::splat(parameters.cutting_force_n(crack_width_m)),
            rupture_n2: L::splat(rupture_n * rupture_n),
            concentration: L::splat(parameters.concentration),
            friction: L::splat(parameters.friction_n_per_m),
            grip: L::splat(parameters.grip_n),
            ruptures: L::Mask::splat(parameters.ruptures(crack_width_m)),
            is_begun: no,
            is_open: no,
            is_through: no,
            is_done: no,
        }
    }

    #[inline(always)]
    fn begin(&mut self, mask: L::Mask, start: L) {
        self.front = L::select(mask, start, self.front);
        self.start = L::select(mask, start, self.start);
        self.bottom = L::select(mask, start + self.thickness, self.bottom);
        self.is_begun = self.is_begun | mask;
        self.is_open = self.is_open | (mask & !self.ruptures);
    }

    /// Force on the tip, lanes that rupture, lanes that are cut through.
    #[inline(always)]
    fn react(&mut self, position: L, reach_m: L) -> (L, L::Mask, L::Mask) {
        let zero = L::zero();
        let end = self.solid.tick_end();
        let free = self.solid.deflection_at(end, zero);
        let advanced = (position - self.solid.deflection_at(end, self.cutting_n)).min(self.front + reach_m);
        self.front = L::select(self.is_open, advanced.max(self.front), self.front);
        let pressed = position - self.front;
        let touches = pressed.gt(free) & self.is_begun & !self.is_done;
        let (force, branch) = self.solid.deflect(end, pressed.max(free));
        let force_n = L::select(touches, force.max(zero), zero);
        let released_n2 = force_n * (force_n + self.concentration * branch.max(zero));
        let gives_way = touches & !self.is_open & released_n2.ge(self.rupture_n2);
        self.is_open = self.is_open | gives_way;
        let is_through = self.is_begun & !self.is_through & self.front.ge(self.bottom);
        self.is_through = self.is_through | is_through;
        self.cutting_n = L::select(is_through, zero, self.cutting_n);
        self.is_done = self.is_done | (self.is_through & force_n.le(zero));
        (force_n, gives_way, is_through)
    }

    #[inline(always)]
    fn add_friction(&self, above: ShaftContact<L>, tip_m: L) -> ShaftContact<L> {
        let length_m = (tip_m - self.start).clamp(L::zero(), self.front.min(self.bottom) - self.start);
        above.and(self.friction, self.grip, length_m)
    }
}

impl<L: Lane> Tearing<L> {
    pub fn new(settings: &TearingSettings, tick_s: f64, start_m: f64) -> Result<Self, InvalidValue> {
        Self::check(settings, tick_s, start_m)?;
        let contact_m = settings.surface.contact_m;
        let width_m = settings.crack.crack_width_m;
        let layer = |(_, layer): &Named<TearingLayer>| Layer::new(layer, width_m, tick_s);
        let mut layers: Box<[Layer<L>]> = settings.layers.iter().map(layer).collect();
        layers[0].begin(L::Mask::splat(true), L::splat(contact_m));
        Ok(Self {
            layers,
            first: 0,
            begun: 1,
            reach_m: L::splat(settings.crack.crack_speed_m_per_s * tick_s),
            shaft: Shaft::new(&settings.shaft, start_m),
            held: ShaftContact::none(),
            friction_n: L::zero(),
        })
    }
}

impl<L: Lane> Tissue<L> for Tearing<L> {
    #[inline(always)]
    fn react(&mut self, _tick: u64, position: L, velocity: L) -> Reaction<L> {
        self.friction_n = self.shaft.friction_n(position, velocity, self.held.kinetic_n, self.held.length_m);
        let mut force_n = self.friction_n;
        let mut ruptured = L::Mask::splat(false);
        let (first, begun) = (self.first, self.begun);
        for index in first..begun {
            let (on_tip_n, gives_way, is_through) = self.layers[index].react(position, self.reach_m);
            force_n = force_n + on_tip_n;
            ruptured = ruptured | gives_way;
            if is_through.any() && index + 1 < self.layers.len() {
                self.layers[index + 1].begin(is_through, position);
                self.begun = self.begun.max(index + 2);
            }
        }
        while self.first < self.begun && self.layers[self.first].is_done.all() {
            self.first += 1;
        }
        let tip_m = position - self.shaft.drag_m();
        self.held = ShaftContact::none();
        for layer in &self.layers[..self.begun] {
            self.held = layer.add_friction(self.held, tip_m);
        }
        Reaction { force_n, ruptured }
    }

    #[inline(always)]
    fn shaft_force_n(&self) -> L {
        self.friction_n
    }
}

impl<L: Lane> Model for Tearing<L> {
    type Settings = TearingSettings;
    const LIST_KEYS: &'static [Key] = TearingLayer::KEYS;

    fn build(settings: &TearingSettings, tick_s: f64, start_m: f64) -> Result<Self, InvalidValue> {
        Self::new(settings, tick_s, start_m)
    }

    fn check(settings: &TearingSettings, tick_s: f64, start_m: f64) -> Result<(), InvalidValue> {
        settings.validate_on_ticks(tick_s)?;
        starts_outside(settings.surface.contact_m, start_m)
    }

    fn default_layers() -> Vec<DefaultLayer> {
        TearingLayer::default_list()
    }

    fn surface_m(settings: &TearingSettings) -> Option<f64> {
        Some(settings.surface.contact_m)
    }

    /// With fast slopes.
    fn springs(settings: &TearingSettings, depth_m: f64) -> Option<Springs> {
        let width_m = settings.crack.crack_width_m;
        let (mut highest, mut top_m, mut of_shaft) = (0.0_f64, 0.0, 0.0);
        let mut relaxation = None;
        for (_, layer) in &settings.layers {
            if depth_m <= top_m {
                break;
            }
            let cut = layer.fast_slope_n_per_m(layer.cutting_force_n(width_m));
            let intact = if layer.ruptures(width_m) {
                layer.fast_slope_n_per_m(layer.rupture_force_n(width_m)) + of_shaft
            } else {
                0.0
            };
            if layer.friction_n_per_m > 0.0 || layer.grip_n > 0.0 {
                of_shaft = settings.shaft.stiffness_n_per_m;
            }
            let slope = intact.max(cut + of_shaft);
            if slope > highest {
                let relaxing = layer.stiffness_n_per_m * (1.0 - layer.relaxed_share);
                let (relaxed_share, time_s) = (1.0 - relaxing / slope, layer.relaxation_time_s);
                (highest, relaxation) = (slope, Some(Relaxation { relaxed_share, time_s }));
            }
            top_m += layer.thickness_m;
        }
        let springs = Springs::between((0.0, highest), (0.0, settings.shaft.damping_n_s_per_m2 * depth_m.min(top_m)));
        Some(Springs { relaxation, ..springs })
    }

    fn layers(settings: &TearingSettings) -> Vec<StatedLayer<'_>> {
        let width_m = settings.crack.crack_width_m;
        let layers = settings.layers.iter().map(|(name, layer)| StatedLayer {
            name,
            thickness_m: layer.thickness_m,
            ruptures: layer.ruptures(width_m),
            deflection_m: layer.rupture_force_n(width_m) / layer.stiffness_n_per_m,
        });
        layers.collect()
    }

    fn outside_measured(settings: &TearingSettings) -> Vec<Outside> {
        let of_layers = measured_layers(&settings.layers, TearingLayer::measured);
        outside(of_layers.chain(settings.shaft.measured()))
    }
}

trocar_core::lane::gather!(Layer {
    solid, front, start, bottom, thickness, cutting_n, rupture_n2, concentration, friction, grip,
} masks { ruptures, is_begun, is_open, is_through, is_done });
trocar_core::lane::gather!(Tearing { layers, reach_m, shaft, held, friction_n } same { first, begun });
