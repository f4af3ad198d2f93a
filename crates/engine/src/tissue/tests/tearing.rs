use super::super::{
    Crack, LAYER_LIST, Model, ShaftParameters, Surface, Tearing, TearingLayer, TearingSettings, Tissue,
};
use super::{SHAFT, TICK_S, assert_near, forces, ruptures, rupturing};

/// A layer of 10 mm and 250 N/m without relaxation and friction. With a crack of 1 mm it ruptures at √2 N (5.66 mm),
/// because `2 k₀ w ℓ R` is 2 N², and is cut at 0.2 N (0.8 mm).
const PLAIN: TearingLayer = TearingLayer {
    thickness_m: 0.01,
    stiffness_n_per_m: 250.0,
    stiffening_n_per_m2: 0.0,
    relaxed_share: 1.0,
    relaxation_time_s: 1.0,
    toughness_j_per_m2: 200.0,
    release_length_m: 0.02,
    concentration: 0.0,
    friction_n_per_m: 0.0,
    grip_n: 0.0,
};

/// The crack advances at most 0.4 mm per tick.
const CRACK: Crack = Crack { crack_width_m: 1e-3, crack_speed_m_per_s: 0.4 };

fn settings(layers: &[TearingLayer]) -> TearingSettings {
    let names = ["upper", "middle", "lower"];
    let layers = names.iter().zip(layers).map(|(name, layer)| ((*name).into(), *layer)).collect();
    TearingSettings { surface: Surface { contact_m: 0.0 }, crack: CRACK, shaft: SHAFT, layers }
}

fn tissue(layers: &[TearingLayer]) -> Tearing<f64> {
    Tearing::new(&settings(layers), TICK_S, 0.0).expect("valid")
}

#[test]
fn the_forces_of_rupture_and_cutting_follow_from_toughness_and_crack() {
    assert!((PLAIN.rupture_force_n(1e-3) - 2.0_f64.sqrt()).abs() < 1e-12, "√(2 · 250 · 1e-3 · 0.02 · 200)");
    assert!((PLAIN.rupture_force_n(4e-3) - 8.0_f64.sqrt()).abs() < 1e-12, "it grows with the root of the width");
    assert!((PLAIN.cutting_force_n(1e-3) - 0.2).abs() < 1e-12 && (PLAIN.cutting_force_n(2e-3) - 0.4).abs() < 1e-12);
    // The forces are equal at a width of 2 k₀ ℓ/R = 50 mm.
    assert_eq!([0.049, 0.051].map(|width_m| PLAIN.ruptures(width_m)), [true, false]);
}

#[test]
fn equal_forces_are_not_a_rupture() {
    // 2 k₀ w ℓ R = 2 · 2 · 1 · 1 · 4 = 16 N², and R w = 4 N.
    let even = TearingLayer { stiffness_n_per_m: 2.0, release_length_m: 1.0, toughness_j_per_m2: 4.0, ..PLAIN };
    assert_eq!((even.rupture_force_n(1.0), even.cutting_force_n(1.0)), (4.0, 4.0));
    assert!(!even.ruptures(1.0));
}

#[test]
fn the_fast_slope_is_the_unrelaxed_stiffness_around_the_relaxed_deflection() {
    assert!((PLAIN.fast_slope_n_per_m(1.0) - 250.0).abs() < 1e-12, "linear");
    let layer = TearingLayer { relaxed_share: 0.4, stiffening_n_per_m2: 5000.0, ..PLAIN };
    // 100 d + 5000 d² is 0.48 N at 4 mm; there the fast slope is 250 + 2 · 5000 · 4e-3.
    assert!((layer.fast_slope_n_per_m(0.48) - 290.0).abs() < 1e-9);
}

#[test]
fn an_intact_layer_is_a_spring_below_its_surface() {
    let deep = TearingSettings { surface: Surface { contact_m: 0.02 }, ..settings(&[PLAIN]) };
    let mut tissue = Tearing::<f64>::new(&deep, TICK_S, 0.0).expect("valid");
    assert_near(&forces(&mut tissue, &[0.0, 0.02, 0.022, 0.024, 0.021]), &[0.0, 0.0, 0.5, 1.0, 0.25]);
}

#[test]
fn a_layer_ruptures_once_where_its_released_energy_reaches_the_toughness() {
    assert_eq!(ruptures(&mut tissue(&[PLAIN]), &[5.65e-3, 5.66e-3, 5.66e-3, 5.7e-3]), [1]);
    assert_eq!(ruptures(&mut tissue(&[PLAIN]), &[5.65e-3, 5.65e-3]), [0_usize; 0]);
}

#[test]
fn an_unrelaxed_force_releases_more_energy() {
    // Half of the stiffness relaxes, within 1e6 s: the force is k₀ d, of which the Maxwell branch carries half. With
    // χ = 6 the layer ruptures at f (f + 6 f/2) = 2 N², so at √0.5 N or 2.83 mm.
    let layer = TearingLayer { relaxed_share: 0.5, relaxation_time_s: 1e6, concentration: 6.0, ..PLAIN };
    let mut tissue = tissue(&[layer]);
    assert_eq!(ruptures(&mut tissue, &[2.82e-3, 2.83e-3]), [1]);
}

#[test]
fn the_crack_advances_at_its_speed_down_to_the_cutting_force_and_stops() {
    let mut tissue = tissue(&[PLAIN]);
    assert!(tissue.react(0, 6e-3, 0.0).ruptured);
    // Each 0.4 mm per tick lowers the force of 1.5 N by 0.1 N, down to 0.2 N.
    let falling: Vec<f64> = (1..=13).map(|tick| 1.5 - 0.1 * f64::from(tick)).collect();
    assert_near(&forces(&mut tissue, &[6e-3; 13]), &falling);
    assert_near(&forces(&mut tissue, &[6e-3, 6.2e-3, 6e-3, 5.2e-3]), &[0.2, 0.2, 0.15, 0.0]);
}

#[test]
fn a_layer_that_is_cut_at_its_rupture_force_is_open_from_its_surface() {
    let soft = TearingLayer { release_length_m: 1e-5, ..PLAIN };
    assert_eq!(rupturing(&Tearing::<f64>::layers(&settings(&[PLAIN, soft, PLAIN]))), ["upper", "lower"]);
    let mut tissue = tissue(&[soft]);
    assert_eq!(ruptures(&mut tissue, &[5e-4, 1e-3]), [0_usize; 0]);
    // From the first tick on, the crack follows at the deflection of 0.8 mm, which gives 0.2 N.
    assert_near(&forces(&mut tissue, &[1e-3, 1.1e-3]), &[0.2, 0.2]);
}

#[test]
fn a_layer_that_is_cut_through_gives_way_to_the_next_one_at_the_needle() {
    let upper = TearingLayer { thickness_m: 9.9e-3, ..PLAIN };
    let mut tissue = tissue(&[upper, TearingLayer { stiffness_n_per_m: 500.0, ..PLAIN }]);
    forces(&mut tissue, &[6e-3; 30]);
    // In steps of 0.4 mm. The crack is 0.8 mm above the tip, so at the last step, 10.8 mm, it reaches 10 mm, the end of
    // the upper layer.
    let steps: Vec<f64> = (1..=12).map(|step| 6e-3 + 4e-4 * f64::from(step)).collect();
    assert_near(&forces(&mut tissue, &steps), &[0.2; 12]);
    // The crack leaves the upper layer within two ticks. The lower one has its surface at 10.8 mm.
    assert_near(&forces(&mut tissue, &[0.0108, 0.0108, 0.0108, 0.0128]), &[0.1, 0.0, 0.0, 1.0]);
}

#[test]
fn the_friction_is_the_grip_plus_the_friction_of_the_cut_length() {
    let rough = TearingLayer { friction_n_per_m: 50.0, grip_n: 0.2, ..PLAIN };
    let mut tissue = tissue(&[rough]);
    forces(&mut tissue, &[5e-3, 6e-3]);
    assert_eq!(tissue.shaft_force_n(), 0.0, "nothing is cut yet");
    forces(&mut tissue, &[6e-3; 100]);
    // The cut is at 5.2 mm. After 1 mm more it has followed by 0.4 mm, and the force on the tip is 0.2 N + 250 N/m ·
    // 0.6 mm.
    assert_near(&forces(&mut tissue, &[7e-3]), &[0.35 + 0.2 + 50.0 * 5.2e-3]);
    assert_near(&[tissue.shaft_force_n()], &[0.2 + 50.0 * 5.2e-3]);
    forces(&mut tissue, &[0.03; 100]);
    assert_near(&forces(&mut tissue, &[0.04]), &[0.2 + 50.0 * 0.01]);
    // During the withdrawal the friction pulls.
    assert_near(&forces(&mut tissue, &[0.03]), &[-(0.2 + 50.0 * 0.01)]);
    forces(&mut tissue, &[4e-3]);
    let dragged_m = (0.2 + 50.0 * 0.01) / 1e4;
    assert_near(&forces(&mut tissue, &[3e-3]), &[-(0.2 + 50.0 * (4e-3 + dragged_m))]);
}

fn highest_slope(layers: &[TearingLayer]) -> f64 {
    let settings = TearingSettings { shaft: ShaftParameters { stiffness_n_per_m: 400.0, ..SHAFT }, ..settings(layers) };
    let (least, highest) = Tearing::<f64>::springs(&settings, f64::INFINITY).expect("known").stiffness_n_per_m;
    assert_eq!(least, 0.0);
    highest
}

#[test]
fn the_stiffest_spring_is_a_layers_fast_slope_with_the_shaft_in_the_rough_layers_above() {
    let layer = |stiffness_n_per_m, friction_n_per_m, grip_n| TearingLayer {
        stiffness_n_per_m,
        friction_n_per_m,
        grip_n,
        ..PLAIN
    };
    super::assert_the_shaft_adds_to_rough_layers(highest_slope, layer);
    // √(k₀² + 4 a₂ f) at the rupture, √2 N, and at 0.2 N for a layer that is only cut.
    let stiffening = TearingLayer { stiffening_n_per_m2: 1e4, ..PLAIN };
    assert!((highest_slope(&[stiffening]) - (62_500.0 + 4e4 * 2.0_f64.sqrt()).sqrt()).abs() < 1e-9);
    let soft = TearingLayer { release_length_m: 1e-5, ..stiffening };
    assert!((highest_slope(&[soft]) - (62_500.0_f64 + 8e3).sqrt()).abs() < 1e-9, "it does not rupture");
    let rough = TearingLayer { grip_n: 0.1, ..stiffening };
    assert!((highest_slope(&[rough]) - (400.0 + (62_500.0_f64 + 8e3).sqrt())).abs() < 1e-9);
}

#[test]
fn impossible_settings_are_refused_with_the_name_of_their_key() {
    let refused =
        |settings: &TearingSettings, start_m| Tearing::<f64>::new(settings, TICK_S, start_m).err().map(|e| e.name);
    let good = settings(&[PLAIN]);
    assert_eq!((refused(&good, 0.0), good.validate()), (None, Ok(())));
    assert_eq!(refused(&good, 1e-6), Some("tissue.contact_m"), "the needle starts in the tissue");
    assert_eq!(refused(&settings(&[]), 0.0), Some(LAYER_LIST));
    let at_a_tick = |relaxation_time_s| settings(&[TearingLayer { relaxation_time_s, ..PLAIN }]);
    assert_eq!(refused(&at_a_tick(TICK_S), 0.0), None);
    assert_eq!(refused(&at_a_tick(0.9 * TICK_S), 0.0), Some("tissue.layer.*.relaxation_time_s"));
    assert_eq!(at_a_tick(0.9 * TICK_S).validate(), Ok(()), "without a tick, no relaxation is too fast");
    let wrong = [
        (TearingSettings { surface: Surface { contact_m: f64::NAN }, ..good.clone() }, "tissue.contact_m"),
        (TearingSettings { crack: Crack { crack_width_m: 0.0, ..CRACK }, ..good.clone() }, "tissue.crack_width_m"),
        (TearingSettings { shaft: ShaftParameters { static_ratio: 0.5, ..SHAFT }, ..good }, "tissue.static_ratio"),
        (settings(&[TearingLayer { thickness_m: 0.0, ..PLAIN }]), "tissue.layer.*.thickness_m"),
    ];
    for (settings, key) in wrong {
        assert_eq!(refused(&settings, 0.0), Some(key));
        assert_eq!(settings.validate().map_err(|error| error.name), Err(key));
    }
}

#[test]
fn each_measured_value_has_the_key_of_its_field() {
    let layer = TearingLayer {
        thickness_m: 1.0,
        stiffness_n_per_m: 2.0,
        stiffening_n_per_m2: 3.0,
        toughness_j_per_m2: 4.0,
        friction_n_per_m: 5.0,
        grip_n: 6.0,
        ..PLAIN
    };
    let keys =
        ["thickness_m", "stiffness_n_per_m", "stiffening_n_per_m2", "toughness_j_per_m2", "friction_n_per_m", "grip_n"];
    for ((index, (key, value, _)), expected) in layer.measured().into_iter().enumerate().zip(keys) {
        assert_eq!((key, value), (format!("tissue.layer.*.{expected}").as_str(), 1.0 + index as f64));
    }
}
