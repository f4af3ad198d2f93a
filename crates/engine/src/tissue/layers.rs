use trocar_core::settings::{Key, KeySource, count, joined};

use super::layer::LayerParameters;
use super::literature::{Outside, outside};
use super::model::{DefaultLayer, Model, Springs, StatedLayer};
use super::named_layers::{Named, check_layers, measured_layers, read_layers};
use super::shaft::{Shaft, ShaftParameters};
use super::shaft_contact::ShaftContact;
use super::surface::{Surface, starts_outside};
use super::{Reaction, Tissue};
use trocar_core::error::InvalidValue;
use trocar_core::lane::{Lane, Mask};

/// Start of an unreached layer, deeper than any run.
const FAR_M: f64 = 1e9;

/// Ends the exponential relaxation before slow subnormal numbers.
const MIN_FALL_M: f64 = 1e-15;

/// Faster relaxation is too brief to affect the loop.
const SLOW_S: f64 = 0.05;

#[derive(Debug, Clone, PartialEq)]
pub struct LayersParameters {
    pub contact_m: f64,
    pub layers: Vec<Named<LayerParameters>>,
    pub shaft: ShaftParameters,
}

impl LayersParameters {
    pub const KEYS: &'static [Key] = &joined::<{ count(Self::GROUPS) }>(Self::GROUPS);

    const GROUPS: &'static [&'static [Key]] = &[Surface::KEYS, ShaftParameters::KEYS];

    pub fn read<S: KeySource>(source: &mut S) -> Result<Self, S::Error> {
        let layers = read_layers(source, LayerParameters::read)?;
        let contact_m = Surface::read(source)?.contact_m;
        Ok(Self { contact_m, layers, shaft: ShaftParameters::read(source)? })
    }

    pub fn validate(&self) -> Result<(), InvalidValue> {
        Surface { contact_m: self.contact_m }.validate()?;
        check_layers(&self.layers, LayerParameters::validate)?;
        self.shaft.validate()
    }

    pub fn validate_on_ticks(&self, tick_s: f64) -> Result<(), InvalidValue> {
        Surface { contact_m: self.contact_m }.validate()?;
        check_layers(&self.layers, |layer| layer.validate_on_ticks(tick_s))?;
        self.shaft.validate()
    }
}

impl Default for LayersParameters {
    fn default() -> Self {
        let contact_m = Surface::DEFAULT.contact_m;
        let layers = LayerParameters::DEFAULT_LIST.map(|(name, layer)| (name.into(), layer)).into();
        Self { contact_m, layers, shaft: ShaftParameters::DEFAULT }
    }
}

/// The three phases of the paper's figure 1. Each layer is a spring that yields at the deflection `y`; `front` is the
/// depth of the cut, in the layer's undeformed length:
///
/// ```text
/// y     = target + (y - target) exp(-T/τ)
/// d     = clamp(x - front, 0, y)
/// f     = (a₁ d + a₂ d²) max(1 + c v, 0)
/// front = max(front, x - y)
/// ```
/// The target is the deflection at the rupture force, then at the cutting force, and 0 once the front is at the bottom,
/// so every layer dissipates energy. The next layer begins at the needle's position. The shaft's length in the
/// tissue is measured from the dragged surface.
///
/// The loop is stable while the largest slope, `a₁ + 2 a₂ d_r + σ`, is below the teleoperation's largest stable
/// stiffness (2.5 kN/m with the paper's controllers at 1 kHz).
#[derive(Debug, Clone)]
pub struct Layers<L: Lane> {
    layers: Box<[Layer<L>]>,
    first: usize,
    begun: usize,
    last_start: L,
    above: ShaftContact<L>,
    shaft: Shaft<L>,
    held: ShaftContact<L>,
    friction: L,
}

#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
struct Layer<L: Lane> {
    front: L,
    yields_at: L,
    target: L,
    decay: L,
    stiffness: L,
    stiffening: L,
    damping: L,
    /// Front at which the layer gives way or is cut through; afterwards infinite.
    next_event: L,
    start: L,
    bottom: L,
    friction: L,
    grip: L,
    thickness: L,
    cut_deflection: L,
    ruptures: L::Mask,
}

impl<L: Lane> Layer<L> {
    fn new(parameters: &LayerParameters, tick_s: f64) -> Self {
        let intact = L::splat(parameters.deflection_m(parameters.rupture_force_n));
        let decay = match parameters.relaxation_s {
            0.0 => 0.0,
            relaxation_s => libm::exp(-tick_s / relaxation_s),
        };
        Self {
            front: L::splat(FAR_M),
            yields_at: intact,
            target: intact,
            decay: L::splat(decay),
            stiffness: L::splat(parameters.stiffness_n_per_m),
            stiffening: L::splat(parameters.stiffening_n_per_m2),
            damping: L::splat(parameters.damping_s_per_m),
            next_event: L::splat(f64::INFINITY),
            start: L::splat(FAR_M),
            bottom: L::splat(FAR_M),
            friction: L::splat(parameters.friction_n_per_m),
            grip: L::splat(parameters.grip_n),
            thickness: L::splat(parameters.thickness_m),
            cut_deflection: L::splat(parameters.deflection_m(parameters.cutting_force_n)),
            ruptures: L::Mask::splat(parameters.ruptures()),
        }
    }

    #[inline(always)]
    fn begin(&mut self, mask: L::Mask, start: L) {
        self.front = L::select(mask, start, self.front);
        self.start = L::select(mask, start, self.start);
        self.bottom = L::select(mask, start + self.thickness, self.bottom);
        self.next_event = L::select(mask, start, self.next_event);
    }

    #[inline(always)]
    fn force_on_tip_n(&mut self, position: L, velocity: L) -> L {
        let relaxed = self.target + (self.yields_at - self.target) * self.decay;
        self.yields_at = (relaxed - L::splat(MIN_FALL_M)).max(self.target);
        let d = (position - self.front).clamp(L::zero(), self.yields_at);
        let viscous = (L::splat(1.0) + self.damping * velocity).max(L::zero());
        self.front = self.front.max(position - self.yields_at);
        (d * viscous) * (self.stiffness + self.stiffening * d)
    }

    #[inline(always)]
    fn add_friction(&self, above: ShaftContact<L>, tip_m: L) -> ShaftContact<L> {
        let length_m = (tip_m - self.start).clamp(L::zero(), self.front.min(self.bottom) - self.start);
        above.and(self.friction, self.grip, length_m)
    }

    #[inline(always)]
    fn handle_events(&mut self) -> (L::Mask, L::Mask) {
        let gives_way = self.front.gt(self.next_event) & self.next_event.lt(self.bottom);
        self.target = L::select(gives_way, self.cut_deflection, self.target);
        self.next_event = L::select(gives_way, self.bottom, self.next_event);
        let is_through = self.front.gt(self.next_event);
        self.target = L::select(is_through, L::zero(), self.target);
        self.next_event = L::select(is_through, L::splat(f64::INFINITY), self.next_event);
        (gives_way & self.ruptures, is_through)
    }
}

#[inline(always)]
fn friction_of<L: Lane>(layers: &[Layer<L>], tip_m: L) -> ShaftContact<L> {
    let mut held = ShaftContact::none();
    for layer in layers {
        held = layer.add_friction(held, tip_m);
    }
    held
}

impl<L: Lane> Layers<L> {
    pub fn new(parameters: &LayersParameters, tick_s: f64, start_m: f64) -> Result<Self, InvalidValue> {
        Self::check(parameters, tick_s, start_m)?;
        let mut layers: Box<[Layer<L>]> =
            parameters.layers.iter().map(|(_, layer)| Layer::new(layer, tick_s)).collect();
        layers[0].begin(L::Mask::splat(true), L::splat(parameters.contact_m));
        Ok(Self {
            layers,
            first: 0,
            begun: 1,
            shaft: Shaft::new(&parameters.shaft, start_m),
            last_start: L::splat(parameters.contact_m),
            above: ShaftContact::none(),
            held: ShaftContact::none(),
            friction: L::zero(),
        })
    }

    #[inline(always)]
    fn update_shaft_contact(&mut self, position: L) {
        let tip = position - self.shaft.drag_m();
        self.held = if tip.ge(self.last_start).all() {
            self.layers[self.begun - 1].add_friction(self.above, tip)
        } else {
            friction_of(&self.layers[..self.begun], tip)
        };
    }

    #[cold]
    #[inline]
    fn handle_events(&mut self, position: L) -> L::Mask {
        self.handle_events_inline(position)
    }

    #[inline(always)]
    fn handle_events_inline(&mut self, position: L) -> L::Mask {
        let mut ruptured = L::Mask::splat(false);
        for i in self.first..self.begun {
            let (here, is_through) = self.layers[i].handle_events();
            ruptured = ruptured | here;
            if i + 1 < self.layers.len() && is_through.any() {
                self.layers[i + 1].begin(is_through, position);
                self.begun = self.begun.max(i + 2);
            }
        }
        let above = self.begun - 1;
        self.last_start = self.layers[above].start;
        self.above = friction_of(&self.layers[..above], L::splat(FAR_M));
        while self.first < self.begun && self.layers[self.first].yields_at.le(L::zero()).all() {
            self.first += 1;
        }
        ruptured
    }
}

impl<L: Lane> Tissue<L> for Layers<L> {
    #[inline(always)]
    fn react(&mut self, _tick: u64, position: L, velocity: L) -> Reaction<L> {
        let mut force_n = self.shaft.friction_n(position, velocity, self.held.kinetic_n, self.held.length_m);
        self.friction = force_n;
        let mut is_event = L::Mask::splat(false);
        for layer in &mut self.layers[self.first..self.begun] {
            force_n = force_n + layer.force_on_tip_n(position, velocity);
            is_event = is_event | layer.front.gt(layer.next_event);
        }
        let is_settled = match self.layers.get(self.first) {
            Some(layer) => layer.yields_at.le(L::zero()).all(),
            None => false,
        };
        let ruptured = match is_event.any() || is_settled {
            false => L::Mask::splat(false),
            true if L::WIDTH > 1 => self.handle_events_inline(position),
            true => self.handle_events(position),
        };
        self.update_shaft_contact(position);
        Reaction { force_n, ruptured }
    }

    #[inline(always)]
    fn shaft_force_n(&self) -> L {
        self.friction
    }
}

impl<L: Lane> Model for Layers<L> {
    type Settings = LayersParameters;
    const LIST_KEYS: &'static [Key] = LayerParameters::KEYS;

    fn build(settings: &LayersParameters, tick_s: f64, start_m: f64) -> Result<Self, InvalidValue> {
        Self::new(settings, tick_s, start_m)
    }

    fn check(settings: &LayersParameters, tick_s: f64, start_m: f64) -> Result<(), InvalidValue> {
        settings.validate_on_ticks(tick_s)?;
        starts_outside(settings.contact_m, start_m)
    }

    fn default_layers() -> Vec<DefaultLayer> {
        LayerParameters::default_list()
    }

    fn surface_m(settings: &LayersParameters) -> Option<f64> {
        Some(settings.contact_m)
    }

    /// From 0 for a layer that is being cut, to the stiffest layer just before its rupture or during cutting.
    fn springs(settings: &LayersParameters, depth_m: f64) -> Option<Springs> {
        let (mut advancing, mut drawn_back, mut damping) = (0.0_f64, 0.0_f64, 0.0_f64);
        let (mut top_m, mut of_shaft) = (0.0, 0.0);
        let mut above = (0.0, 0.0);
        for (_, layer) in &settings.layers {
            let reach_m = depth_m - top_m;
            if reach_m <= 0.0 {
                break;
            }
            let [intact_n, cutting_n] = [layer.rupture_force_n, layer.cutting_force_n]
                .map(|force_n| if layer.deflection_m(force_n) > reach_m { layer.force_n(reach_m) } else { force_n });
            let [intact, cut] = [intact_n, cutting_n].map(|force_n| layer.slope_n_per_m(force_n));
            let is_slow = layer.relaxation_s > SLOW_S;
            advancing = advancing.max(intact + of_shaft);
            drawn_back = drawn_back.max(intact + of_shaft + above.0);
            damping = damping.max(layer.damping_s_per_m * intact_n + above.1);
            if layer.friction_n_per_m > 0.0 || layer.grip_n > 0.0 {
                of_shaft = settings.shaft.stiffness_n_per_m;
            }
            advancing = advancing.max(cut + of_shaft);
            drawn_back = drawn_back.max(if is_slow { intact.max(cut) } else { cut } + of_shaft + above.0);
            if is_slow {
                above = (above.0 + cut, above.1 + layer.damping_s_per_m * cutting_n);
            }
            top_m += layer.thickness_m;
        }
        let damping = damping + settings.shaft.damping_n_s_per_m2 * depth_m.min(top_m);
        let springs = Springs::between((0.0, advancing), (0.0, damping));
        Some(Springs { drawn_back_n_per_m: drawn_back, ..springs })
    }

    fn layers(settings: &LayersParameters) -> Vec<StatedLayer<'_>> {
        let layers = settings.layers.iter().map(|(name, layer)| StatedLayer {
            name,
            thickness_m: layer.thickness_m,
            ruptures: layer.ruptures(),
            deflection_m: layer.deflection_m(layer.rupture_force_n),
        });
        layers.collect()
    }

    fn outside_measured(settings: &LayersParameters) -> Vec<Outside> {
        let of_layers = measured_layers(&settings.layers, LayerParameters::measured);
        outside(of_layers.chain(settings.shaft.measured()))
    }
}

trocar_core::lane::gather!(Layer {
    front, yields_at, target, decay, stiffness, stiffening, damping, next_event, start, bottom, friction, grip, thickness,
    cut_deflection,
} masks { ruptures });
trocar_core::lane::gather!(Layers { layers, last_start, above, shaft, held, friction } same { first, begun });
