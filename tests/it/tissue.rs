//! Properties of every tissue for any parameters and any motion of the needle, and properties of layers.

use proptest::prelude::*;
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
