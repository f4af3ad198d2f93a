//! Layers that bulge, give way, are cut through, and hold the shaft.

use trocar_core::settings::{Key, Source, count, joined};

use super::layer::{LAYER_KEYS, LAYERS, LayerParameters};
use super::model::Model;
use super::shaft::{Shaft, ShaftParameters};
use super::surface::Surface;
use super::{Reaction, Tissue};
use crate::error::{InvalidValue, require};
use crate::lane::{Lane, Mask};

/// Where a layer begins that the needle has not come to, in m: deeper than any run gets.
const FAR_M: f64 = 1e9;

/// By how much a yield deflection falls in each tick besides its exponential relaxation, in m: nothing of note, but it
/// arrives, where otherwise ever smaller numbers would take their time.
const MIN_FALL_M: f64 = 1e-15;

/// What a layered tissue is made of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LayersParameters {
    /// The surface before anything touched it, in m.
    pub contact_m: f64,
    /// The layers from the surface down.
    pub layers: [LayerParameters; LAYERS],
    /// The shaft's friction.
    pub shaft: ShaftParameters,
}

impl LayersParameters {
    /// The keys that set it, but for those of its layers, which have sections of their own.
    pub const KEYS: &'static [Key] = &joined::<{ count(Self::GROUPS) }>(Self::GROUPS);

    const GROUPS: &'static [&'static [Key]] = &[Surface::KEYS, ShaftParameters::KEYS];

    /// Reads it.
    ///
    /// # Errors
    /// Those of the source.
    pub fn read<S: Source>(source: &mut S) -> Result<Self, S::Error> {
        let mut layers = LayerParameters::DEFAULTS;
        for (layer, keys) in layers.iter_mut().zip(&LAYER_KEYS) {
            *layer = LayerParameters::read(source, keys)?;
        }
        let contact_m = Surface::read(source)?.contact_m;
        Ok(Self { contact_m, layers, shaft: ShaftParameters::read(source)? })
    }

    /// Checks what needs no tick: the surface and the shaft.
    ///
    /// # Errors
    /// [`InvalidValue`] naming the first key out of range.
    pub fn validate(&self) -> Result<(), InvalidValue> {
        Surface { contact_m: self.contact_m }.validate()?;
        self.shaft.validate()
    }

    /// Checks every layer and the shaft, on ticks of `tick_s`.
    ///
    /// # Errors
    /// [`InvalidValue`] naming the first key out of range.
    pub fn validate_on_ticks(&self, tick_s: f64) -> Result<(), InvalidValue> {
        Surface { contact_m: self.contact_m }.validate()?;
        for (index, layer) in self.layers.iter().enumerate() {
            layer.validate(index, tick_s)?;
        }
        let is_there = self.layers.iter().any(LayerParameters::is_present);
        require(
            "tissue.organ.thickness_m",
            self.layers[LAYERS - 1].thickness_m,
            is_there,
            "above 0, as no layer is left",
        )?;
        self.shaft.validate()
    }
}

impl Default for LayersParameters {
    fn default() -> Self {
        let contact_m = Surface::DEFAULT.contact_m;
        Self { contact_m, layers: LayerParameters::DEFAULTS, shaft: ShaftParameters::DEFAULT }
    }
}

/// A needle in layers of tissue: the three phases of the paper's figure 1.
///
/// Each layer is a spring that yields. With `front` where the needle's tip has cut to, in the layer's own undeformed
/// length, and `y` the deflection at which it yields:
///
/// ```text
/// y     = target + (y - target) exp(-T/τ)
/// d     = clamp(x - front, 0, y)
/// f     = (a₁ d + a₂ d²) max(1 + c v, 0)
/// front = max(front, x - y)
/// ```
/// The target is `d_r`, where the spring reaches the rupture force, while the layer is intact; `d_c`, where it reaches the
/// cutting force, from then on; 0 once the front has reached the layer's bottom. So a needle that stands still feels the
/// force relax and then hold; one that retreats feels the spring unload, never pull. What was cut stays cut. Springs only
/// lose deflection to fronts and relaxation, so every layer dissipates.
///
/// A layer begins to bulge where the needle is when the one above is through: until then the two move as one, and only
/// the upper one is felt at the tip. Forces superpose: of the layer above, relaxing, of the one being cut, and of the
/// friction of all that the shaft is in (see [`ShaftParameters`]), whose kinetic bound is the sum of each layer's grip and
/// of its friction times the length in it. That length counts from the surface as it is dragged along, `F/σ` inward or,
/// on the way out, outward: there the tissue pulls, and the needle comes free outside of where it first touched.
///
/// All of this is a map of position and velocity, exact for any tick; a relaxation faster than a tick would not be
/// seen and is refused. For the loop to be stable the steepest slope, `a₁ + 2 a₂ d_r + σ`, has to stay below the
/// stiffest spring that the teleoperation holds (2.5 kN/m with the paper's controllers at 1 kHz).
#[derive(Debug, Clone)]
pub struct Layers<L: Lane> {
    layers: [Layer<L>; LAYERS],
    /// Layers before this one are through and relaxed, in every lane.
    first: usize,
    /// Layers from this one on have not begun, in any lane.
    begun: usize,
    /// Layers from this one on are not there.
    count: usize,
    /// Where the last layer that has begun did so; what is above of it, once the tip is beyond, and how it holds.
    last_start: L,
    above: Hold<L>,
    shaft: Shaft<L>,
    /// What holds the shaft, as of the tick before.
    held: Hold<L>,
}

/// What holds the shaft: the bound of its kinetic friction in N, and its length in the tissue in m.
#[derive(Debug, Clone, Copy)]
struct Hold<L> {
    kinetic_n: L,
    length_m: L,
}

/// A layer and what has become of it.
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
    /// Where a front has to come for the layer to give way or to be through; never, once it is.
    next_event: L,
    start: L,
    bottom: L,
    friction: L,
    grip: L,
    thickness: L,
    cut_deflection: L,
    /// Whether it lets go when it gives way: its rupture force is above its cutting force.
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
            ruptures: L::Mask::splat(parameters.rupture_force_n > parameters.cutting_force_n),
        }
    }

    /// Lets the layer begin at `start`, where the mask holds.
    #[inline(always)]
    fn begin(&mut self, mask: L::Mask, start: L) {
        self.front = L::select(mask, start, self.front);
        self.start = L::select(mask, start, self.start);
        self.bottom = L::select(mask, start + self.thickness, self.bottom);
        self.next_event = L::select(mask, start, self.next_event);
    }

    /// The force on the tip in N, after the tick's relaxation; cuts where the layer yields.
    #[inline(always)]
    fn press(&mut self, position: L, velocity: L) -> L {
        let relaxed = self.target + (self.yields_at - self.target) * self.decay;
        self.yields_at = (relaxed - L::splat(MIN_FALL_M)).max(self.target);
        let d = (position - self.front).clamp(L::zero(), self.yields_at);
        let viscous = (L::splat(1.0) + self.damping * velocity).max(L::zero());
        self.front = self.front.max(position - self.yields_at);
        (d * viscous) * (self.stiffness + self.stiffening * d)
    }

    /// The length in m of a shaft with its tip at `tip_m` that is in what was cut of the layer.
    #[inline(always)]
    fn holds_m(&self, tip_m: L) -> L {
        (tip_m - self.start).clamp(L::zero(), self.front.min(self.bottom) - self.start)
    }

    /// Takes over what happened to the layer at this tick: from intact to cut, from cut to through. Gives where it
    /// ruptured and where it is through.
    #[inline(always)]
    fn pass_events(&mut self) -> (L::Mask, L::Mask) {
        let gives_way = self.front.gt(self.next_event) & self.next_event.lt(self.bottom);
        self.target = L::select(gives_way, self.cut_deflection, self.target);
        self.next_event = L::select(gives_way, self.bottom, self.next_event);
        // A needle fast enough gives way and is through in one tick.
        let is_through = self.front.gt(self.next_event);
        self.target = L::select(is_through, L::zero(), self.target);
        self.next_event = L::select(is_through, L::splat(f64::INFINITY), self.next_event);
        (gives_way & self.ruptures, is_through)
    }
}

impl<L: Lane> Hold<L> {
    fn nothing() -> Self {
        Self { kinetic_n: L::zero(), length_m: L::zero() }
    }

    /// What layers do with the tip at `tip_m`, from the surface down.
    #[inline(always)]
    fn of(layers: &[Layer<L>], tip_m: L) -> Self {
        let mut held = Self::nothing();
        for layer in layers {
            held = held.and(layer, tip_m);
        }
        held
    }

    /// What one layer does besides.
    #[inline(always)]
    fn and(self, layer: &Layer<L>, tip_m: L) -> Self {
        let length = layer.holds_m(tip_m);
        let grip = L::select(length.gt(L::zero()), layer.grip, L::zero());
        Self { kinetic_n: self.kinetic_n + (layer.friction * length + grip), length_m: self.length_m + length }
    }
}

impl<L: Lane> Layers<L> {
    /// An untouched tissue, on ticks of `tick_s`, with the needle at `start_m` (m).
    ///
    /// # Errors
    /// [`InvalidValue`] as [`LayersParameters::validate`], or for a needle that begins inside.
    pub fn new(parameters: &LayersParameters, tick_s: f64, start_m: f64) -> Result<Self, InvalidValue> {
        parameters.validate_on_ticks(tick_s)?;
        let outside = start_m <= parameters.contact_m;
        require(
            "tissue.contact_m",
            parameters.contact_m,
            outside,
            "at least where the needle begins, which is outside",
        )?;
        let present: Vec<LayerParameters> = parameters.layers.into_iter().filter(LayerParameters::is_present).collect();
        let layer = |i: usize| Layer::new(present.get(i).unwrap_or(&LayerParameters::ABSENT), tick_s);
        let mut layers: [Layer<L>; LAYERS] = std::array::from_fn(layer);
        layers[0].begin(L::Mask::splat(true), L::splat(parameters.contact_m));
        Ok(Self {
            layers,
            first: 0,
            begun: 1,
            count: present.len(),
            shaft: Shaft::new(&parameters.shaft, start_m),
            last_start: L::splat(parameters.contact_m),
            above: Hold::nothing(),
            held: Hold::nothing(),
        })
    }

    /// What holds the shaft until the next tick. It need not wait for this tick's friction nor this one for it.
    #[inline(always)]
    fn hold(&mut self, position: L) {
        let tip = position - self.shaft.drag_m();
        // A layer begins where the one above is through, so that a tip in the last one is through all others.
        self.held = if tip.ge(self.last_start).all() {
            self.above.and(&self.layers[self.begun - 1], tip)
        } else {
            Hold::of(&self.layers[..self.begun], tip)
        };
    }

    /// Takes over what happened to layers at this tick, and what it means for the next ones. Gives where one ruptured.
    #[cold]
    #[inline]
    fn pass_events(&mut self, position: L) -> L::Mask {
        self.pass_events_here(position)
    }

    #[inline(always)]
    fn pass_events_here(&mut self, position: L) -> L::Mask {
        let mut ruptured = L::Mask::splat(false);
        for i in self.first..self.begun {
            let (here, is_through) = self.layers[i].pass_events();
            ruptured = ruptured | here;
            if i + 1 < self.count && is_through.any() {
                self.layers[i + 1].begin(is_through, position);
                self.begun = self.begun.max(i + 2);
            }
        }
        let above = self.begun - 1;
        self.last_start = self.layers[above].start;
        self.above = Hold::of(&self.layers[..above], L::splat(FAR_M));
        // A layer yields at nothing only once it is through and relaxed: it presses no more.
        while self.first < self.begun && self.layers[self.first].yields_at.le(L::zero()).all() {
            self.first += 1;
        }
        ruptured
    }
}

impl<L: Lane> Tissue<L> for Layers<L> {
    #[inline(always)]
    fn react(&mut self, _tick: u64, position: L, velocity: L) -> Reaction<L> {
        // Few layers are on the tip at a time, and which ones seldom changes.
        let mut force_n = self.shaft.rub(position, velocity, self.held.kinetic_n, self.held.length_m);
        let mut is_event = L::Mask::splat(false);
        for layer in &mut self.layers[self.first..self.begun] {
            force_n = force_n + layer.press(position, velocity);
            is_event = is_event | layer.front.gt(layer.next_event);
        }
        let is_settled = match self.layers.get(self.first) {
            Some(layer) => layer.yields_at.le(L::zero()).all(),
            None => false,
        };
        let ruptured = match is_event.any() || is_settled {
            false => L::Mask::splat(false),
            true if L::WIDTH > 1 => self.pass_events_here(position),
            true => self.pass_events(position),
        };
        self.hold(position);
        Reaction { force_n, ruptured }
    }
}

impl<L: Lane> Model for Layers<L> {
    type Settings = LayersParameters;

    fn build(settings: &LayersParameters, tick_s: f64, start_m: f64) -> Result<Self, InvalidValue> {
        Self::new(settings, tick_s, start_m)
    }
}

crate::lane::gather!(Layer {
    front, yields_at, target, decay, stiffness, stiffening, damping, next_event, start, bottom, friction, grip, thickness,
    cut_deflection,
} masks { ruptures });
crate::lane::gather!(Hold { kinetic_n, length_m });
crate::lane::gather!(Layers { layers, last_start, above, shaft, held } same { first, begun, count });
