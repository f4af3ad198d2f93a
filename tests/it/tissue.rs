//! Properties of every tissue for any parameters and any motion of the needle, and properties of layers.

use crate::support::pair::Pair;
use proptest::prelude::*;
use trocar::lane::Lane;
use trocar::tissue::{
    AnyTissue, Crack, DepthCurves, DepthReplay, Generalised, GeneralisedSettings, HuntCrossley, HuntCrossleySettings,
    KelvinVoigt, KelvinVoigtSettings, LayerParameters, Layers, LayersParameters, PowerSettings, Recording,
    ShaftParameters, StillTissue, Surface, Tearing, TearingLayer, TearingSettings, Tissue,
};

const TICK_S: f64 = 1e-4;
const START_M: f64 = -4e-3;

/// Returns positions and velocities of a needle that moves between positions with minimum jerk, and starts and ends
/// outside.
fn motion(places_m: &[f64], seconds: f64) -> Vec<(f64, f64)> {
    let ticks = (seconds / TICK_S) as usize;
    let places: Vec<f64> = [START_M].into_iter().chain(places_m.iter().copied()).chain([START_M]).collect();
    let mut samples = vec![];
    for pair in places.windows(2) {
        for k in 0..ticks {
            let tau = k as f64 / ticks as f64;
            let share = tau * tau * tau * (10.0 + tau * (-15.0 + 6.0 * tau));
            let rate = 30.0 * tau * tau * (1.0 - tau) * (1.0 - tau) / seconds;
            samples.push((pair[0] + (pair[1] - pair[0]) * share, (pair[1] - pair[0]) * rate));
        }
    }
    samples.push((START_M, 0.0));
    samples
}

fn forces(tissue: &mut AnyTissue<f64>, motion: &[(f64, f64)]) -> Vec<f64> {
    motion.iter().zip(0..).map(|(&(x, v), tick)| tissue.react(tick, x, v).force_n).collect()
}

/// Returns the needle's work on the tissue and the integral of its magnitude, in J, by the trapezium rule.
fn work(motion: &[(f64, f64)], force_n: &[f64]) -> (f64, f64) {
    let steps = motion.windows(2).zip(force_n.windows(2));
    let each = steps.map(|(at, force)| 0.5 * (force[0] + force[1]) * (at[1].0 - at[0].0));
    each.fold((0.0, 0.0), |(sum, size), step| (sum + step, size + step.abs()))
}

fn layer() -> impl Strategy<Value = LayerParameters> {
    let shape = (5e-4..0.02f64, 20.0..500.0f64, 0.0..4e4f64);
    let forces = (0.05..4.0f64, 0.05..=1.0f64, prop_oneof![Just(0.0), 1e-3..0.2f64]);
    let rub = (0.0..20.0f64, 0.0..80.0f64, 0.0..0.6f64);
    (shape, forces, rub).prop_map(|((thickness_m, a1, a2), (rupture, share, relaxation_s), (c, mu, grip_n))| {
        LayerParameters {
            thickness_m,
            stiffness_n_per_m: a1,
            stiffening_n_per_m2: a2,
            rupture_force_n: rupture,
            cutting_force_n: rupture * share,
            relaxation_s,
            damping_s_per_m: c,
            friction_n_per_m: mu,
            grip_n,
        }
    })
}

fn shaft() -> impl Strategy<Value = ShaftParameters> {
    (100.0..2000.0f64, 1.0..1.5f64, 0.0..5e-3f64, 0.0..100.0f64).prop_map(|(sigma, ratio, speed, damping)| {
        ShaftParameters {
            stiffness_n_per_m: sigma,
            static_ratio: ratio,
            stick_speed_m_per_s: speed,
            damping_n_s_per_m2: damping,
        }
    })
}

fn layered() -> impl Strategy<Value = AnyTissue<f64>> {
    counted_layered().prop_map(|(tissue, _)| tissue)
}

fn counted_layered() -> impl Strategy<Value = (AnyTissue<f64>, usize)> {
    (prop::collection::vec(layer(), 1..8), shaft()).prop_filter_map("the layers are possible", |(layers, shaft)| {
        let (layers, count): (Vec<_>, _) = (layers.iter().map(|layer| ("any".into(), *layer)).collect(), layers.len());
        let parameters = LayersParameters { contact_m: 0.0, layers, shaft };
        Layers::new(&parameters, TICK_S, START_M).ok().map(|tissue| (AnyTissue::from(tissue), count))
    })
}

fn tearing_layer() -> impl Strategy<Value = TearingLayer> {
    let solid = (20.0..500.0f64, 0.0..2e4f64, 0.05..=1.0f64, 1e-3..3.0f64);
    let crack = (5e-4..0.02f64, 20.0..3000.0f64, 1e-3..0.05f64, 0.0..2.0f64);
    let rub = (0.0..80.0f64, 0.0..0.6f64);
    (solid, crack, rub).prop_map(
        |((k0, a2, relaxed_share, tau), (thickness_m, toughness, release_length_m, concentration), (mu, grip_n))| {
            TearingLayer {
                thickness_m,
                stiffness_n_per_m: k0,
                stiffening_n_per_m2: a2,
                relaxed_share,
                relaxation_time_s: tau,
                toughness_j_per_m2: toughness,
                release_length_m,
                concentration,
                friction_n_per_m: mu,
                grip_n,
            }
        },
    )
}

fn tearing() -> impl Strategy<Value = AnyTissue<f64>> {
    counted_tearing().prop_map(|(tissue, _)| tissue)
}

fn counted_tearing() -> impl Strategy<Value = (AnyTissue<f64>, usize)> {
    let crack = (2e-4..2e-3f64, 0.02..2.0f64);
    (prop::collection::vec(tearing_layer(), 1..8), crack, shaft()).prop_map(|(layers, crack, shaft)| {
        let crack = Crack { crack_width_m: crack.0, crack_speed_m_per_s: crack.1 };
        let (layers, count): (Vec<_>, _) = (layers.iter().map(|layer| ("any".into(), *layer)).collect(), layers.len());
        let settings = TearingSettings { surface: Surface::DEFAULT, crack, shaft, layers };
        (AnyTissue::from(Tearing::new(&settings, TICK_S, START_M).expect("valid")), count)
    })
}

fn any_tissue() -> impl Strategy<Value = AnyTissue<f64>> {
    let power = (2..16u32).prop_map(|quarters| 0.25 * f64::from(quarters));
    prop_oneof![
        1 => (0.0..2000.0f64, 0.0..50.0f64)
            .prop_map(|(stiffness_n_per_m, damping_n_s_per_m)| {
                let settings = KelvinVoigtSettings { stiffness_n_per_m, damping_n_s_per_m, ..KelvinVoigtSettings::DEFAULT };
                AnyTissue::from(KelvinVoigt::new(&settings).expect("valid"))
            }),
        1 => (0.0..5000.0f64, 0.0..500.0f64, power.clone())
            .prop_map(|(mu, lambda, power)| {
                let power = PowerSettings { power };
                let settings = HuntCrossleySettings { mu, lambda, power, ..HuntCrossleySettings::DEFAULT };
                AnyTissue::from(HuntCrossley::new(&settings).expect("valid"))
            }),
        1 => (prop::array::uniform3(0.0..5000.0f64), prop::array::uniform3(0.0..500.0f64), power).prop_map(
            |(mus, lambdas, power)| {
                let (surface, power) = (Surface::DEFAULT, PowerSettings { power });
                let (depths_m, mus, lambdas) = (vec![0.0, 0.01, 0.03], mus.into(), lambdas.into());
                let settings = GeneralisedSettings { surface, power, depths_m, mus, lambdas };
                AnyTissue::from(Generalised::new(&settings).expect("valid"))
            }
        ),
        3 => layered(),
        3 => tearing(),
    ]
}

/// Returns a recording by depth, in to 30 mm and out, with any forces.
fn replayed() -> impl Strategy<Value = AnyTissue<f64>> {
    let forces = prop::collection::vec(-3.0..6.0f64, 60);
    (forces, 1e-4..0.02f64, prop::collection::vec(0.0..0.03f64, 0..3)).prop_map(
        |(mut force_n, presliding_m, ruptures)| {
            (force_n[0], force_n[59]) = (0.0, 0.0);
            let way_in = (0..30).map(|k| 1e-3 * f64::from(k));
            let position_m: Vec<f64> = way_in.clone().chain(way_in.rev()).collect();
            let replay = DepthReplay::new(
                DepthCurves::new(&position_m, &force_n).expect("valid").into(),
                ruptures.into(),
                presliding_m,
                START_M,
            );
            AnyTissue::from(Recording::Depth(replay.expect("valid")))
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    #[test]
    fn a_replay_by_depth_dissipates_over_a_closed_motion(
        mut tissue in replayed(),
        places in prop::collection::vec(-3e-3..0.04f64, 1..6),
    ) {
        let motion = motion(&places, 0.5);
        let (sum, size) = work(&motion, &forces(&mut tissue, &motion));
        prop_assert!(sum >= -1e-3 * size, "{sum} J of {size} J");
    }

    #[test]
    fn every_tissue_dissipates_over_a_closed_motion_and_none_pushes_before_contact(
        mut tissue in any_tissue(),
        places in prop::collection::vec(-3e-3..0.06f64, 1..5),
        seconds in 0.2..1.0f64,
    ) {
        let motion = motion(&places, seconds);
        let force_n = forces(&mut tissue, &motion);
        let first = motion.iter().position(|&(x, _)| x > 0.0).unwrap_or(motion.len());
        prop_assert!(force_n[..first].iter().all(|&force| force == 0.0), "before contact");
        prop_assert!(force_n.iter().all(|force| force.is_finite()));
        let (sum, size) = work(&motion, &force_n);
        prop_assert!(sum >= -1e-3 * size, "{sum} J of {size} J");
    }

    #[test]
    fn each_layer_ruptures_at_most_once_and_a_second_insertion_dissipates_too(
        (mut tissue, layers) in prop_oneof![counted_layered(), counted_tearing()],
        depth in 0.01..0.06f64,
    ) {
        let motion = motion(&[depth], 1.0);
        let mut insert = || {
            let reactions = motion.iter().map(|&(x, v)| tissue.react(0, x, v)).collect::<Vec<_>>();
            let force_n: Vec<f64> = reactions.iter().map(|reaction| reaction.force_n).collect();
            (reactions.iter().filter(|reaction| reaction.ruptured).count(), work(&motion, &force_n))
        };
        let ((ruptures, _), (again, (sum, size))) = (insert(), insert());
        prop_assert!(ruptures + again <= layers, "{ruptures} then {again} of {layers}");
        // A crack that the first insertion has not driven through a layer continues in the second insertion, and may
        // reach the next layer.
        prop_assert!(again == 0 || matches!(tissue, AnyTissue::Still(StillTissue::Tearing(_))), "{ruptures} then {again}");
        prop_assert!(sum >= -1e-3 * size, "{sum} J of {size} J");
    }
}

/// Returns a membrane over an organ without damping or friction, so that each force follows from the law alone.
fn membrane() -> LayersParameters {
    let [.., (_, capsule), (_, organ)] = LayerParameters::DEFAULT_LIST;
    let capsule = LayerParameters { damping_s_per_m: 0.0, grip_n: 0.0, thickness_m: 0.05, ..capsule };
    let organ = LayerParameters { damping_s_per_m: 0.0, friction_n_per_m: 0.0, ..organ };
    let shaft = ShaftParameters { damping_n_s_per_m2: 0.0, static_ratio: 1.0, ..ShaftParameters::default() };
    LayersParameters { contact_m: 0.0, layers: vec![("capsule".into(), capsule), ("organ".into(), organ)], shaft }
}

fn tissue(parameters: &LayersParameters) -> AnyTissue<f64> {
    AnyTissue::from(Layers::new(parameters, TICK_S, START_M).expect("valid"))
}

#[test]
fn a_membrane_ruptures_at_its_rupture_force_and_relaxes_to_its_cutting_force() {
    let parameters = membrane();
    let (_, capsule) = parameters.layers[0];
    let mut tissue = tissue(&parameters);
    let (step, mut x) = (1e-6, 0.0);
    let mut before = 0.0;
    let at_rupture = loop {
        x += step;
        let reaction = tissue.react(0, x, 0.0);
        if reaction.ruptured {
            break reaction.force_n;
        }
        let law = capsule.stiffness_n_per_m * x + capsule.stiffening_n_per_m2 * x * x;
        assert!((reaction.force_n - law).abs() < 1e-12, "phase 1 is the loading law");
        before = reaction.force_n;
        assert!(before <= capsule.rupture_force_n, "not above the rupture force");
    };
    assert!((at_rupture - capsule.rupture_force_n).abs() < 1e-12 && before <= at_rupture, "{at_rupture}");
    // The needle is at rest: deflection and force relax exponentially and then stay constant.
    let deflection = |force: f64| capsule.deflection_m(force);
    let (from, to) = (deflection(capsule.rupture_force_n), deflection(capsule.cutting_force_n));
    for k in 0..6000 {
        let force = tissue.react(0, x, 0.0).force_n;
        let time_s = TICK_S * f64::from(k + 1);
        let expected = to + (from - to) * (-time_s / capsule.relaxation_s).exp();
        assert!((deflection(force) - expected).abs() < 1e-9, "{k}: {force}");
    }
    let held = tissue.react(0, x, 0.0).force_n;
    assert!((held - capsule.cutting_force_n).abs() < 1e-6, "{held}");
    assert!(
        (0..1000).all(|_| (tissue.react(0, x, 0.0).force_n - held).abs() < 1e-9),
        "a frozen needle feels a held force"
    );
    for _ in 0..5000 {
        x += step;
        assert!((tissue.react(0, x, 0.0).force_n - capsule.cutting_force_n).abs() < 1e-6);
    }
}

#[test]
fn the_force_of_extraction_is_negative_and_contact_ends_outside_of_the_first_contact() {
    let mut parameters = membrane();
    let grip_n = 0.4;
    parameters.layers[0].1.grip_n = grip_n;
    parameters.layers[0].1.friction_n_per_m = 10.0;
    let mut tissue = tissue(&parameters);
    let (mut deepest_pull, mut free_at) = (0.0_f64, None);
    for (x, v) in motion(&[0.04], 1.0) {
        let force = tissue.react(0, x, v).force_n;
        if v < 0.0 {
            deepest_pull = deepest_pull.min(force);
            if force == 0.0 && free_at.is_none() {
                free_at = Some(x);
            }
        }
    }
    let free_at = free_at.expect("it comes free");
    let expected = -grip_n / parameters.shaft.stiffness_n_per_m;
    assert!(deepest_pull < -grip_n, "friction along the shaft adds to the grip: {deepest_pull}");
    assert!(free_at < 0.0 && (free_at - expected).abs() < 2e-4, "{free_at} instead of {expected}");
}

#[test]
fn a_shaft_sticks_up_to_the_static_friction_and_slides_at_the_kinetic_friction() {
    let mut parameters = membrane();
    parameters.layers[0].1.grip_n = 0.5;
    parameters.shaft.static_ratio = 1.4;
    let mut tissue = tissue(&parameters);
    let way_in = motion(&[0.03], 1.0);
    for &(x, v) in &way_in[..way_in.len() / 2] {
        tissue.react(0, x, v);
    }
    let (x, step) = (0.03, 1e-6);
    // Relax at rest, then move out at 10 mm/s until the tip no longer presses.
    for _ in 0..5000 {
        tissue.react(0, x, 0.0);
    }
    let pulls: Vec<f64> =
        (1..20_000).map(|k| tissue.react(0, x - step * f64::from(k), -0.01).force_n).skip(12_000).collect();
    assert!(pulls.iter().all(|pull| (pull + 0.5).abs() < 1e-9), "kinetic: {:?}", &pulls[..3]);
    let held = x - step * 19_999.0;
    for _ in 0..10 {
        tissue.react(0, held, 0.0);
    }
    let most = (1..2000).map(|k| tissue.react(0, held - step * f64::from(k), -0.01).force_n).fold(0.0, f64::min);
    assert!((most + 0.7).abs() < 0.01, "static: {most}");
}

#[test]
fn lanes_of_different_motions_are_identical_to_single_runs() {
    let [fast, slow] = [motion(&[0.05, 0.01, 0.06], 0.4), motion(&[0.02, 0.03, 0.06], 0.4)];
    let parameters = LayersParameters { contact_m: 0.0, ..LayersParameters::default() };
    let together = Layers::<Pair>::new(&parameters, TICK_S, START_M).expect("valid");
    let mut together = AnyTissue::from(together);
    let mut alone = [tissue(&parameters), tissue(&parameters)];
    let mut ruptures = 0;
    for (tick, (&(xa, va), &(xb, vb))) in fast.iter().zip(&slow).enumerate() {
        let both = together.react(tick as u64, Pair([xa, xb]), Pair([va, vb]));
        for (lane, (x, v)) in [(xa, va), (xb, vb)].into_iter().enumerate() {
            let one = alone[lane].react(tick as u64, x, v);
            assert_eq!(both.force_n.lane(lane).to_bits(), one.force_n.to_bits(), "lane {lane} at {tick}");
            assert_eq!(trocar::lane::Mask::lane(both.ruptured, lane), one.ruptured);
            ruptures += u32::from(one.ruptured);
        }
    }
    assert_eq!(ruptures, 6, "skin, muscle and capsule in both");
}
