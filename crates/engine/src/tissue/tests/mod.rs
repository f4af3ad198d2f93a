//! Tissues with layers, and the properties of each kind in the registry.

mod layers;
mod tearing;

use super::{ShaftParameters, StatedLayer, Tissue};

const TICK_S: f64 = 1e-3;

/// A shaft with equal static and kinetic friction and no viscous friction, which drags the tissue by 0.1 mm per newton.
const SHAFT: ShaftParameters =
    ShaftParameters { stiffness_n_per_m: 1e4, static_ratio: 1.0, stick_speed_m_per_s: 1e-3, damping_n_s_per_m2: 0.0 };

/// The forces in N on a needle at rest at each position (m) in turn.
fn forces(tissue: &mut impl Tissue<f64>, positions_m: &[f64]) -> Vec<f64> {
    positions_m.iter().map(|&position_m| tissue.react(0, position_m, 0.0).force_n).collect()
}

/// The indices of the positions (m) at which a layer ruptures.
fn ruptures(tissue: &mut impl Tissue<f64>, positions_m: &[f64]) -> Vec<usize> {
    (0..positions_m.len()).filter(|&index| tissue.react(0, positions_m[index], 0.0).ruptured).collect()
}

fn rupturing<'a>(layers: &[StatedLayer<'a>]) -> Vec<&'a str> {
    layers.iter().filter(|layer| layer.ruptures).map(|layer| layer.name).collect()
}

/// Asserts the highest slopes of layers with a shaft of 400 N/m. `layer` takes a stiffness, a friction and a grip.
#[track_caller]
fn assert_the_shaft_adds_to_rough_layers<T>(highest_slope: fn(&[T]) -> f64, layer: fn(f64, f64, f64) -> T) {
    assert_eq!(highest_slope(&[layer(100.0, 0.0, 0.0), layer(300.0, 0.0, 0.0)]), 300.0, "no friction");
    assert_eq!(highest_slope(&[layer(300.0, 10.0, 0.0)]), 700.0, "the shaft sticks while the layer is cut");
    assert_eq!(highest_slope(&[layer(300.0, 0.0, 0.1)]), 700.0, "a grip holds the shaft, too");
    assert_eq!(highest_slope(&[layer(300.0, 10.0, 0.0), layer(600.0, 0.0, 0.0)]), 1000.0, "in the layer below");
    assert_eq!(highest_slope(&[layer(900.0, 0.0, 0.0), layer(300.0, 10.0, 0.0)]), 900.0, "not in the layer above");
}

#[track_caller]
fn assert_near(values: &[f64], expected: &[f64]) {
    let is_near = values.len() == expected.len() && values.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9);
    assert!(is_near, "{values:?} instead of {expected:?}");
}
