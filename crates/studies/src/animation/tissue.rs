//! The drawn tissue. The simulation computes no shape: the drawing assumes that an intact interface lies at the tip.

use crate::run::Run;
use trocar_engine::tissue::{StatedLayer, TissueSettings};
use trocar_scenario::Scenario;

const RETURN_S: f64 = 0.02;

const COMPRESSED_SHARE: f64 = 0.3;

/// The needle is assumed to touch a layer at this share of the force's rise before the rupture.
const TOUCH_SHARE: f64 = 0.1;

#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    pub(super) label: String,
    pub(super) top_mm: f64,
    pub(super) torn_s: Option<f64>,
    thickness_mm: f64,
    /// True if the layer bulges until it ruptures.
    ruptures: bool,
}

#[derive(Clone, Debug)]
pub struct DrawnTissue {
    layers: Vec<Layer>,
    depths_mm: Vec<f64>,
    torn: Vec<bool>,
    last_s: f64,
}

impl DrawnTissue {
    pub fn of_scenario(scenario: &Scenario) -> Self {
        let contact_mm = 1e3 * contact_m(scenario);
        let mut top_mm = contact_mm;
        let mut layers: Vec<Layer> = stated_layers(scenario)
            .iter()
            .map(|stated| {
                let layer = at(stated, top_mm);
                top_mm += layer.thickness_mm;
                layer
            })
            .collect();
        if layers.is_empty() {
            layers.push(unnamed(contact_mm));
        }
        Self::new(layers)
    }

    /// The top of a rupturing layer is the tip's position at the rupture minus the layer's deflection.
    pub fn of_run(run: &Run) -> Self {
        let trace = &run.trace;
        let ticks: Vec<usize> = run.metrics.ruptures.iter().map(|one| nearest(&trace.time_s, one.time_s)).collect();
        let stated = stated_layers(&run.scenario);
        if stated.is_empty() {
            let mut layers = vec![];
            let mut from = 0;
            for tick in ticks {
                let touch = touch(&trace.tissue_force_n, from, tick);
                let mut layer = unnamed(1e3 * trace.slave_position_m.get(touch).copied().unwrap_or(0.0));
                layer.torn_s = trace.time_s.get(tick).copied();
                layers.push(layer);
                from = tick;
            }
            if layers.is_empty() {
                return Self::of_scenario(&run.scenario);
            }
            return Self::new(layers);
        }
        let mut layers = Self::of_scenario(&run.scenario).layers;
        let places: Vec<usize> = (0..stated.len()).filter(|index| stated[*index].ruptures).collect();
        for (index, tick) in places.into_iter().zip(ticks) {
            let tip_mm = 1e3 * trace.slave_position_m.get(tick).copied().unwrap_or(0.0);
            let top_mm = tip_mm - 1e3 * stated[index].deflection_m;
            let moved_mm = top_mm - layers[index].top_mm;
            layers[index].torn_s = trace.time_s.get(tick).copied();
            let first = if index == 0 { layers.len() } else { index };
            for layer in &mut layers[first..] {
                layer.top_mm += moved_mm;
            }
        }
        Self::new(layers)
    }

    fn new(layers: Vec<Layer>) -> Self {
        let depths_mm = layers.iter().map(|layer| layer.top_mm).collect();
        let torn = vec![false; layers.len()];
        Self { layers, depths_mm, torn, last_s: f64::NEG_INFINITY }
    }

    pub fn layers(&self) -> &[Layer] {
        &self.layers
    }

    pub fn depths_mm(&self) -> &[f64] {
        &self.depths_mm
    }

    pub fn torn(&self) -> Vec<bool> {
        self.layers.iter().map(|layer| layer.torn_s.is_some()).collect()
    }

    /// Tears the next layer that can rupture.
    pub fn tear(&mut self, time_s: f64) {
        if let Some(layer) = self.layers.iter_mut().find(|layer| layer.ruptures && layer.torn_s.is_none()) {
            layer.torn_s = Some(time_s);
        }
    }

    pub fn step(&mut self, time_s: f64, tip_mm: f64) {
        let remaining = (-(time_s - self.last_s).max(0.0) / RETURN_S).exp();
        self.last_s = time_s;
        let mut floor_mm = f64::NEG_INFINITY;
        for (index, layer) in self.layers.iter().enumerate() {
            let top_mm = layer.top_mm;
            let depth_mm = &mut self.depths_mm[index];
            self.torn[index] |= layer.torn_s.is_some_and(|torn| torn <= time_s);
            if self.torn[index] || !layer.ruptures && floor_mm < top_mm {
                *depth_mm = top_mm + (*depth_mm - top_mm) * remaining;
            } else {
                *depth_mm = if layer.ruptures { tip_mm.max(top_mm) } else { top_mm };
            }
            *depth_mm = depth_mm.max(floor_mm);
            floor_mm = *depth_mm + COMPRESSED_SHARE * layer.thickness_mm.min(5.0);
        }
    }
}

fn at(layer: &StatedLayer<'_>, top_mm: f64) -> Layer {
    let thickness_mm = 1e3 * layer.thickness_m;
    Layer {
        label: format!("{}, {} mm", layer.name, trocar_document::plain(thickness_mm)),
        top_mm,
        torn_s: None,
        thickness_mm,
        ruptures: layer.ruptures,
    }
}

fn unnamed(top_mm: f64) -> Layer {
    Layer { label: String::new(), top_mm, torn_s: None, thickness_mm: 0.0, ruptures: true }
}

fn stated_layers(scenario: &Scenario) -> Vec<StatedLayer<'_>> {
    scenario.tissue.settings().map_or_else(Vec::new, TissueSettings::layers)
}

/// The tissue's contact, or the one that the estimator assumes.
fn contact_m(scenario: &Scenario) -> f64 {
    let of = |key: &str| scenario.values().get(key)?.to_toml().as_float();
    of("tissue.contact_m").unwrap_or(scenario.contact_m)
}

/// The last tick at which the force has hardly risen since tick `from`.
fn touch(force_n: &[f64], from: usize, rupture: usize) -> usize {
    let Some(before) = force_n.get(from..rupture).filter(|before| !before.is_empty()) else { return rupture };
    let min_n = before.iter().copied().fold(f64::INFINITY, f64::min);
    let limit_n = min_n + TOUCH_SHARE * (force_n[rupture - 1] - min_n);
    from + before.iter().rposition(|force_n| *force_n <= limit_n).unwrap_or(0)
}

pub(super) fn nearest(time_s: &[f64], at_s: f64) -> usize {
    let after = time_s.partition_point(|time| *time < at_s);
    let is_before = after > 0 && (after == time_s.len() || at_s - time_s[after - 1] < time_s[after] - at_s);
    if is_before { after - 1 } else { after }
}
