//! Eight scenarios in lanes have the metrics of separate runs, bit for bit, in every instruction set.

use crate::support::scenario;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use trocar::engine::InstructionSet;
use trocar::run::{PACK, can_share, measure, run_pack, run_pack_in};
use trocar::scenario::{Scenario, Source};

fn load(name: &str, settings: &[String]) -> Scenario {
    let path = format!("builtin:{name}");
    Scenario::load(&Source::parse(&path), settings).unwrap_or_else(|error| panic!("{name} {settings:?}: {error:?}"))
}

/// Returns the metrics of a separate run, with each number in the shortest form that reads back to the same value.
fn alone(scenario: &Scenario) -> String {
    format!("{:?}", measure(scenario).expect("runs"))
}

fn in_packs(set: InstructionSet, scenarios: &[Scenario]) -> Vec<String> {
    run_pack_in(set, scenarios).into_iter().map(|metrics| format!("{:?}", metrics.expect("runs"))).collect()
}

/// Returns random values of the keys that may differ between lanes.
fn settings(rng: &mut ChaCha8Rng, ranges: &[(&str, f64, f64)]) -> Vec<String> {
    let mut settings: Vec<String> =
        ranges.iter().map(|(key, low, high)| format!("{key}={:?}", low + (high - low) * rng.random::<f64>())).collect();
    settings.push(format!("simulation.seed={}", rng.random_range(1..1_000_000)));
    settings
}

/// The parameters of master and slave, equal in all lanes or different.
const MACHINES: [(&str, f64, f64); 4] = [
    ("arm.k_a_n_per_m", 150.0, 600.0),
    ("arm.b_a_n_s_per_m", 1.0, 8.0),
    ("master.mass_kg", 0.3, 1.5),
    ("slave.proportional_gain", 900.0, 1500.0),
];

/// The keys that may differ in any scenario. The large force scales make some closed loops diverge.
const COMMON: [(&str, f64, f64); 5] = [
    ("scaling.force", 0.3, 3.0),
    ("scaling.position", 0.5, 1.5),
    ("estimator.dead_zone_n", 0.01, 0.08),
    ("detector.threshold", 0.005, 0.08),
    ("detector.settle_s", 0.02, 0.3),
];

/// Keys of a scenario with augmentation.
const EVENTS: [(&str, f64, f64); 2] = [("augmentation.min_hold_s", 0.1, 0.6), ("augmentation.blend_s", 0.02, 0.3)];

/// A key for re-engaging by a ramp.
const CATCH_UP: (&str, f64, f64) = ("augmentation.catch_up_speed_m_per_s", 0.01, 0.1);

/// Checks that scenarios in packs give the results of separate runs in every instruction set. Returns these results.
fn each_as_alone(name: &str, scenarios: &[Scenario]) -> Vec<String> {
    let single: Vec<String> = scenarios.iter().map(alone).collect();
    for set in InstructionSet::ALL.into_iter().filter(|set| set.is_available()) {
        for (k, (packed, single)) in in_packs(set, scenarios).iter().zip(&single).enumerate() {
            assert!(packed == single, "{name}, {set:?}, case {k}:\n{packed}\n{single}");
        }
    }
    single
}

fn compare(name: &str, fixed: &[&str], varied: &[(&str, f64, f64)], packs: usize, seed: u64) -> (usize, usize) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let given: Vec<String> = fixed.iter().map(|&setting| setting.to_owned()).collect();
    let augments = load(name, &given).augmentation.enabled;
    let has_ramp =
        |setting: &&str| !setting.starts_with("augmentation.reengage=") && *setting != "augmentation.hold=none";
    let catches_up = augments && fixed.iter().all(has_ramp);
    let of_events = EVENTS.iter().filter(|_| augments);
    let ranges: Vec<_> =
        COMMON.iter().chain(of_events).chain(varied).copied().chain(catches_up.then_some(CATCH_UP)).collect();
    let (mut diverged, mut events) = (0, 0);
    for pack in 0..packs {
        let machines = settings(&mut rng, &MACHINES);
        let case = |rng: &mut ChaCha8Rng| {
            let mut all = given.clone();
            let machines = if pack.is_multiple_of(2) { machines.clone() } else { settings(rng, &MACHINES) };
            all.extend(machines.into_iter().chain(settings(rng, &ranges)));
            load(name, &all)
        };
        let scenarios: Vec<Scenario> = (0..PACK).map(|_| case(&mut rng)).collect();
        assert!(can_share(&scenarios) || !InstructionSet::Avx2.is_available(), "{name} {fixed:?}");
        let single = each_as_alone(&format!("{name} {fixed:?}"), &scenarios);
        diverged += single.iter().filter(|metrics| metrics.contains("Diverged")).count();
        events += single.iter().filter(|metrics| !metrics.contains("events: []")).count();
    }
    (diverged, events)
}

#[test]
fn lanes_of_replays_are_identical_to_single_runs() {
    let (_, events) = compare("augmented", &[], &[], 25, 1);
    assert!(events > 0);
    compare("classical", &["sensor.force_noise_std_n=0.02"], &[], 12, 2);
    compare("augmented", &["augmentation.reengage=clutch", "augmentation.freeze=reference"], &[], 8, 3);
    compare("augmented", &["augmentation.force_law=amplify"], &[("augmentation.amplification", 1.0, 3.0)], 8, 4);
    compare("paper/depth-augmented", &[], &[], 6, 5);
    compare("augmented", &["augmentation.reengage=fade"], &[("augmentation.gap_time_constant_s", 0.05, 2.0)], 8, 6);
    compare(
        "augmented",
        &["augmentation.reengage=when-still"],
        &[("augmentation.still_speed_m_per_s", 0.0, 0.01)],
        8,
        7,
    );
    let fixture = ["augmentation.hold=yielding", "augmentation.force_law=guide"];
    compare("augmented", &fixture, &[("augmentation.yield_distance_m", 0.0, 0.01)], 8, 8);
    for (seed, hold) in ["none", "speed-limit", "forbidden-region"].into_iter().enumerate() {
        let hold = format!("augmentation.hold={hold}");
        compare(
            "augmented",
            &[&hold, "augmentation.force_law=damp", "augmentation.cue=true"],
            &[],
            1,
            30 + seed as u64,
        );
    }
}

#[test]
fn lanes_with_and_without_augmentation_are_identical_to_single_runs() {
    for name in ["augmented", "layers/skin-augmented", "passivity/long-delay-waves", "link/four-channel"] {
        let mut rng = ChaCha8Rng::seed_from_u64(12);
        let case = |k: usize| {
            let mut all = settings(&mut rng, &[("scaling.force", 0.6, 1.2)]);
            all.push(format!("augmentation.enabled={}", !k.is_multiple_of(3)));
            load(name, &all)
        };
        let scenarios: Vec<Scenario> = (0..3 * PACK).map(case).collect();
        let single = each_as_alone(name, &scenarios);
        let augmented = |(k, metrics): (usize, &String)| (!k.is_multiple_of(3), !metrics.contains("events: []"));
        assert!(single.iter().enumerate().map(augmented).all(|(enabled, has_events)| enabled || !has_events));
        assert!(single.iter().any(|metrics| !metrics.contains("events: []")), "{name}");
    }
}

#[test]
fn lanes_of_layered_tissues_are_identical_to_single_runs() {
    let varied = [
        ("sensor.force_noise_std_n", 0.005, 0.05),
        ("tissue.contact_m", 0.0, 0.004),
        ("tissue.layer.skin.rupture_force_n", 2.0, 6.0),
        ("tissue.layer.muscle.thickness_m", 0.008, 0.02),
        ("tissue.layer.capsule.rupture_force_n", 0.5, 2.5),
    ];
    let (_, events) = compare("layers/through-the-skin", &["augmentation.enabled=true"], &varied, 16, 6);
    assert!(events > 0);
    compare("layers/through-the-skin", &[], &varied, 8, 7);
    compare("hand/reflex-augmented", &[], &varied, 6, 8);
    compare("hand/trembling-hand", &[], &varied, 4, 9);
    // The arm stiffens and pulls back by different gains and with the same delay.
    let tense = [
        ("operator.stretch_short_gain_n_s_per_m", 1.0, 30.0),
        ("operator.stretch_long_gain_n_per_m", 1.0, 300.0),
        ("operator.stiffening_per_n", 0.01, 0.2),
    ];
    compare("hand/reflex-augmented", &[], &tense, 4, 13);
}

#[test]
fn lanes_of_layers_that_tear_and_move_are_identical_to_single_runs() {
    let varied = [
        ("tissue.layer.film.toughness_j_per_m2", 500.0, 12_000.0),
        ("tissue.layer.block.relaxation_time_s", 0.1, 3.0),
        ("tissue.breathing_amplitude_m", 1e-4, 4e-3),
        ("tissue.breathing_period_s", 1.0, 5.0),
    ];
    compare("tearing/firm-phantom", &["augmentation.enabled=true"], &varied, 12, 12);
}

#[test]
fn lanes_are_identical_to_single_runs_even_if_some_of_them_diverge() {
    let kelvin_voigt = [("tissue.stiffness_n_per_m", 100.0, 6000.0), ("tissue.damping_n_s_per_m", 0.0, 20.0)];
    let fixed = ["operator.kind=ramp", "operator.end_m=0.05", "operator.speed_m_per_s=0.02"];
    let with = |more: &[&'static str]| fixed.iter().chain(more).copied().collect::<Vec<_>>();
    let (diverged, _) =
        compare("augmented", &with(&["tissue.kind=kelvin-voigt", "tissue.contact_m=0.01"]), &kelvin_voigt, 14, 10);
    assert!(diverged > 0, "some lanes diverge");
    let hunt_crossley = [("tissue.mu", 500.0, 60_000.0), ("tissue.lambda", 0.0, 500.0)];
    compare("augmented", &with(&["tissue.kind=hunt-crossley", "tissue.power=1.5"]), &hunt_crossley, 8, 11);
    compare("augmented", &with(&["tissue.kind=generalised"]), &[], 1, 14);
}

#[test]
fn lanes_of_links_and_other_estimators_are_identical_to_single_runs() {
    let late = ["channel.forward_delay_s=0.012", "channel.backward_delay_s=0.007"];
    let rough = ["channel.jitter_s=0.004", "channel.loss=0.2", "channel.outage_s=0.004"];
    for (seed, fixed) in [
        &late[..],
        &[late[0], rough[0], rough[1], rough[2]],
        &[late[0], late[1], rough[0], rough[1], rough[2], "channel.recovery=hold"],
        &[late[0], late[1], rough[0], rough[1], "channel.outage_s=0.009", "channel.recovery=give-up"],
        &[late[1], rough[1], "passivity.scheme=time-domain", "passivity.budget_j=1e-4"],
        &[late[0], late[1], rough[1], "passivity.scheme=wave-variables"],
        &[late[0], late[1], rough[1], "passivity.scheme=energy-tank", "passivity.tank_level_j=1e-3"],
        &["controller.kind=four-channel", "controller.slave_force_gain=0.5"],
        &["controller.kind=local-force"],
        &["controller.kind=position-position", "slave.compliance_m_per_n=7.7e-4"],
        &["estimator.parameters=stiffness-damping-friction", "estimator.forgetting=exponential"],
        &["estimator.parameters=hunt-crossley", "detector.minimum_depth_m=0.01"],
        &["estimator.parameters=least-residual", "detector.motion=inserting"],
        &["detector.distance=page-hinkley"],
        &["detector.distance=likelihood-ratio"],
        &["sensor.position_resolution_m=1e-5", "sensor.force_bandwidth_hz=80", "sensor.force_range_n=8"],
    ]
    .iter()
    .enumerate()
    {
        compare("layers/through-the-skin", fixed, &[], 1, 20 + seed as u64);
    }
}

#[test]
fn scenarios_that_cannot_share_a_pack_run_separately() {
    let replayed = ["augmented", "paper/depth-augmented"];
    let cases = [
        ("augmented", &["simulation.duration_s=2"][..]),
        ("augmented", &["channel.forward_delay_s=0.0035"]),
        ("augmented", &["actuator.master_force_limit_n=3", "simulation.control=sampled"]),
    ];
    let recordings = replayed.map(|name| (name, &["recording.scale.force_n=1.1"][..]));
    let ruptures = replayed.map(|name| (name, &["recording.ruptures_s=[5.52]"][..]));
    for (name, settings) in cases.into_iter().chain(recordings).chain(ruptures) {
        // Three, because fewer always run separately.
        let scenarios = [scenario(name, &[]), scenario(name, settings), scenario(name, &[])];
        assert!(!can_share(&scenarios), "{name} {settings:?}");
        let together = run_pack(&scenarios).into_iter().map(|metrics| format!("{:?}", metrics.expect("runs")));
        assert_eq!(
            together.collect::<Vec<_>>(),
            scenarios.iter().map(alone).collect::<Vec<_>>(),
            "{name} {settings:?}"
        );
    }
}

#[test]
fn delays_of_whole_ticks_may_differ() {
    let case = |ticks: u32| {
        let delays = [("forward", ticks), ("backward", 30 - ticks)];
        let delays = delays.map(|(way, ticks)| format!("channel.{way}_delay_s={}", f64::from(ticks) / 1000.0));
        load("layers/through-the-skin", &delays)
    };
    let scenarios: Vec<Scenario> = [1, 2, 3, 7, 12, 20, 25, 29].map(case).into();
    assert!(can_share(&scenarios) || !InstructionSet::Avx2.is_available());
    let single: Vec<String> = scenarios.iter().map(alone).collect();
    for set in InstructionSet::ALL.into_iter().filter(|set| set.is_available()) {
        assert_eq!(in_packs(set, &scenarios), single, "{set:?}");
    }
}

#[test]
fn partial_packs_and_several_packs_keep_their_order() {
    let scenarios: Vec<Scenario> =
        (0..21).map(|i| load("augmented", &[format!("scaling.force={}", 0.5 + 0.05 * f64::from(i))])).collect();
    let single: Vec<String> = scenarios.iter().map(alone).collect();
    for count in [0, 1, 2, 3, 7, 8, 9, 21] {
        assert_eq!(in_packs(InstructionSet::widest(), &scenarios[..count]), single[..count], "{count}");
    }
}
