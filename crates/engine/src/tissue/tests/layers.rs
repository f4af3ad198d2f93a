use super::super::{LAYER_LIST, LayerParameters, Layers, LayersParameters, Model, ShaftParameters, Tissue};
use super::{SHAFT, TICK_S, assert_near, forces, ruptures, rupturing};

/// A layer of 10 mm and 100 N/m that yields at 1 N (10 mm) and is cut at 0.5 N (5 mm), at once and without friction.
const PLAIN: LayerParameters = LayerParameters {
    thickness_m: 0.01,
    stiffness_n_per_m: 100.0,
    stiffening_n_per_m2: 0.0,
    rupture_force_n: 1.0,
    cutting_force_n: 0.5,
    relaxation_s: 0.0,
    damping_s_per_m: 0.0,
    friction_n_per_m: 0.0,
    grip_n: 0.0,
};

fn parameters(layers: &[LayerParameters]) -> LayersParameters {
    let names = ["upper", "middle", "lower"];
    let layers = names.iter().zip(layers).map(|(name, layer)| ((*name).into(), *layer)).collect();
    LayersParameters { contact_m: 0.0, layers, shaft: SHAFT }
}

fn tissue(layers: &[LayerParameters]) -> Layers<f64> {
    Layers::new(&parameters(layers), TICK_S, 0.0).expect("valid")
}

#[test]
fn the_force_before_the_rupture_is_linear_plus_quadratic_in_the_deflection_below_the_surface() {
    let stiffening = LayerParameters { stiffening_n_per_m2: 5000.0, ..PLAIN };
    let deep = LayersParameters { contact_m: 0.02, ..parameters(&[stiffening]) };
    let mut tissue = Layers::<f64>::new(&deep, TICK_S, 0.0).expect("valid");
    // 100 d + 5000 d² at d = 0, 2 and 4 mm.
    assert_near(&forces(&mut tissue, &[0.0, 0.02, 0.022, 0.024]), &[0.0, 0.0, 0.22, 0.48]);
}

#[test]
fn the_damping_multiplies_the_force_and_never_makes_it_pull() {
    let mut tissue = tissue(&[LayerParameters { damping_s_per_m: 2.0, ..PLAIN }]);
    let mut at = |velocity| tissue.react(0, 4e-3, velocity).force_n;
    assert_near(&[at(0.0), at(0.1), at(-0.25), at(-1.0)], &[0.4, 0.48, 0.2, 0.0]);
}

#[test]
fn a_layer_ruptures_once_beyond_its_rupture_force_and_falls_to_its_cutting_force() {
    let path = [9.9e-3, 0.0105, 0.0105, 0.012];
    assert_near(&forces(&mut tissue(&[PLAIN]), &path), &[0.99, 1.0, 0.5, 0.5]);
    assert_eq!(ruptures(&mut tissue(&[PLAIN]), &path), [1]);
    assert_eq!(
        ruptures(&mut tissue(&[PLAIN]), &[0.01, 0.01]),
        [0_usize; 0],
        "the rupture force alone does not rupture"
    );
}

#[test]
fn after_the_rupture_the_force_relaxes_exponentially() {
    let mut tissue = tissue(&[LayerParameters { relaxation_s: 0.02, ..PLAIN }]);
    assert!(tissue.react(0, 0.0105, 0.0).ruptured);
    for tick in 1..=100 {
        let force = tissue.react(tick, 0.0105, 0.0).force_n;
        let expected = 0.5 + 0.5 * (-TICK_S * tick as f64 / 0.02).exp();
        assert!((force - expected).abs() < 1e-9, "{tick}: {force} instead of {expected}");
    }
}

#[test]
fn a_layer_that_is_cut_at_its_rupture_force_gives_way_without_a_rupture() {
    let blunt = LayerParameters { rupture_force_n: 0.5, ..PLAIN };
    assert_eq!(rupturing(&Layers::<f64>::layers(&parameters(&[PLAIN, blunt, PLAIN]))), ["upper", "lower"]);
    let mut tissue = tissue(&[blunt]);
    assert_eq!(ruptures(&mut tissue, &[4e-3, 6e-3, 8e-3, 0.012]), [0_usize; 0]);
    assert_near(&forces(&mut tissue, &[0.012, 0.013]), &[0.5, 0.5]);
}

#[test]
fn a_retreat_unloads_the_spring_and_the_cut_remains() {
    let mut tissue = tissue(&[PLAIN]);
    // At 10.5 mm and a deflection of 5 mm, the cut is at 5.5 mm.
    forces(&mut tissue, &[0.0105, 0.0105]);
    assert_near(&forces(&mut tissue, &[8e-3, 5e-3, 0.0, 7e-3, 0.0105]), &[0.25, 0.0, 0.0, 0.15, 0.5]);
    assert_eq!(ruptures(&mut tissue, &[0.0, 9e-3, 0.0105]), [0_usize; 0], "it ruptures once");
}

#[test]
fn the_next_layer_begins_at_the_needle_when_the_layer_above_is_cut_through() {
    let lower = LayerParameters { stiffness_n_per_m: 200.0, ..PLAIN };
    let mut tissue = tissue(&[PLAIN, lower]);
    // The cut of the upper layer is 5 mm above the tip, so it is cut through beyond 15 mm. The lower layer then bulges
    // from 16 mm.
    assert_near(&forces(&mut tissue, &[0.011, 0.014, 0.016, 0.017, 0.02]), &[1.0, 0.5, 0.5, 0.2, 0.8]);
    // The lower layer reaches its rupture force of 1 N at 5 mm, and its cutting force at 2.5 mm.
    assert_near(&forces(&mut tissue, &[0.0212, 0.0212, 0.025]), &[1.0, 0.5, 0.5]);
    // The cut is at 22.5 mm, in the layer from 16 to 26 mm, which is cut through when the needle is beyond 28.5 mm.
    assert_near(&forces(&mut tissue, &[0.0284, 0.0286, 0.0287]), &[0.5, 0.5, 0.0]);
}

#[test]
fn the_force_of_a_layer_that_is_cut_through_relaxes_and_adds_to_the_force_of_the_next() {
    let slow = LayerParameters { relaxation_s: 0.02, ..PLAIN };
    let mut tissue = tissue(&[slow, PLAIN]);
    forces(&mut tissue, &[0.0105; 2000]);
    assert_near(&forces(&mut tissue, &[0.016]), &[0.5]);
    for tick in 1..=50 {
        let force = tissue.react(tick, 0.018, 0.0).force_n;
        let expected = 0.5 * (-TICK_S * tick as f64 / 0.02).exp() + 0.2;
        assert!((force - expected).abs() < 1e-9, "{tick}: {force} instead of {expected}");
    }
}

#[test]
fn a_fast_needle_cuts_through_in_the_tick_of_the_rupture() {
    let mut tissue = tissue(&[PLAIN, PLAIN]);
    assert_eq!(ruptures(&mut tissue, &[0.021, 0.021, 0.0311]), [0, 2], "the lower layer begins at 21 mm");
    assert_near(&forces(&mut tissue, &[0.0311]), &[0.5]);
}

#[test]
fn the_friction_is_the_grip_plus_the_friction_of_the_cut_length() {
    let rough = LayerParameters { friction_n_per_m: 50.0, grip_n: 0.2, ..PLAIN };
    let mut tissue = tissue(&[rough]);
    forces(&mut tissue, &[5e-3, 0.011]);
    assert_eq!(tissue.shaft_force_n(), 0.0, "nothing is cut yet");
    // At 11 mm the cut is at 1 mm, at 12 mm at 7 mm. The friction of a tick uses the length at the tick before.
    forces(&mut tissue, &[0.012]);
    assert_near(&[tissue.shaft_force_n()], &[0.2 + 50.0 * 1e-3]);
    assert_near(&forces(&mut tissue, &[0.013]), &[0.5 + 0.2 + 50.0 * 7e-3]);
    // At most 10 mm of the shaft are in a layer of 10 mm.
    forces(&mut tissue, &[0.02, 0.03]);
    assert_near(&[tissue.shaft_force_n()], &[0.2 + 50.0 * 0.01]);
}

#[test]
fn a_withdrawal_pulls_by_the_friction_of_the_length_still_in_the_dragged_layer() {
    let rough = LayerParameters { friction_n_per_m: 50.0, ..PLAIN };
    let mut tissue = tissue(&[rough]);
    forces(&mut tissue, &[0.011, 0.012, 0.02, 0.03]);
    assert_near(&forces(&mut tissue, &[0.02]), &[-0.5]);
    // The pull of 0.5 N drags the layer outward by 0.05 mm.
    forces(&mut tissue, &[4e-3]);
    assert_near(&forces(&mut tissue, &[2e-3]), &[-50.0 * 4.05e-3]);
    assert_near(&forces(&mut tissue, &[-1e-3, -2e-3]), &[-50.0 * (2e-3 + 50.0 * 4.05e-3 / 1e4), 0.0]);
}

#[test]
fn the_friction_of_two_layers_adds_up() {
    let layer = |friction_n_per_m, grip_n| LayerParameters { friction_n_per_m, grip_n, ..PLAIN };
    let mut tissue = tissue(&[layer(50.0, 0.0), layer(20.0, 0.1)]);
    // The lower layer begins at 16 mm, where the upper one is cut through. At 27 mm it is cut to 22 mm, at 27.5 mm to 22.5 mm.
    forces(&mut tissue, &[0.011, 0.016, 0.0265, 0.027]);
    assert_near(&forces(&mut tissue, &[0.0275]), &[0.5 + 50.0 * 0.01 + 0.1 + 20.0 * 6e-3]);
    // Here the shaft is only in the upper layer.
    forces(&mut tissue, &[6e-3]);
    let dragged_m = (50.0 * 0.01 + 0.1 + 20.0 * 6.5e-3) / 1e4;
    assert_near(&forces(&mut tissue, &[5e-3]), &[-50.0 * (6e-3 + dragged_m)]);
}

fn highest_slope(layers: &[LayerParameters]) -> f64 {
    let shaft = ShaftParameters { stiffness_n_per_m: 400.0, ..SHAFT };
    let parameters = LayersParameters { shaft, ..parameters(layers) };
    let (least, highest) = Layers::<f64>::springs(&parameters, f64::INFINITY).expect("known").stiffness_n_per_m;
    assert_eq!(least, 0.0);
    highest
}

#[test]
fn the_stiffest_spring_is_a_layers_slope_at_its_rupture_with_the_shaft_in_the_rough_layers_above() {
    let layer = |stiffness_n_per_m, friction_n_per_m, grip_n| LayerParameters {
        stiffness_n_per_m,
        friction_n_per_m,
        grip_n,
        ..PLAIN
    };
    super::assert_the_shaft_adds_to_rough_layers(highest_slope, layer);
    // √(a₁² + 4 a₂ f) at 1 N and, with the shaft, at 0.5 N.
    let stiffening = LayerParameters { stiffness_n_per_m: 0.0, stiffening_n_per_m2: 1e4, ..PLAIN };
    assert!((highest_slope(&[stiffening]) - 200.0).abs() < 1e-9);
    let rough = LayerParameters { grip_n: 0.1, ..stiffening };
    assert!((highest_slope(&[rough]) - (400.0 + 2e4_f64.sqrt())).abs() < 1e-9);
}

#[test]
fn impossible_parameters_are_refused_with_the_name_of_their_key() {
    let refused =
        |parameters: &LayersParameters, start_m| Layers::<f64>::new(parameters, TICK_S, start_m).err().map(|e| e.name);
    let good = parameters(&[PLAIN]);
    assert_eq!((refused(&good, 0.0), good.validate()), (None, Ok(())));
    assert_eq!(refused(&good, 1e-6), Some("tissue.contact_m"), "the needle starts in the tissue");
    assert_eq!(refused(&parameters(&[]), 0.0), Some(LAYER_LIST));
    let fast = parameters(&[LayerParameters { relaxation_s: 1e-4, ..PLAIN }]);
    assert_eq!(refused(&fast, 0.0), Some("tissue.layer.*.relaxation_s"));
    assert_eq!(fast.validate(), Ok(()), "without a tick, no relaxation is too fast");
    let wrong = [
        (LayersParameters { contact_m: f64::NAN, ..good.clone() }, "tissue.contact_m"),
        (LayersParameters { shaft: ShaftParameters { static_ratio: 0.5, ..SHAFT }, ..good }, "tissue.static_ratio"),
        (parameters(&[LayerParameters { thickness_m: 0.0, ..PLAIN }]), "tissue.layer.*.thickness_m"),
    ];
    for (parameters, key) in wrong {
        assert_eq!(refused(&parameters, 0.0), Some(key));
        assert_eq!(parameters.validate().map_err(|error| error.name), Err(key));
    }
}
