//! The promises of the passivity schemes at the physical ports, over random hands, tissues and links.
//!
//! A scheme promises that hand and needle together never receive more energy than they have given plus `E_0`:
//!
//! ```text
//! E_m - E_s >= -E_0    E_m = Σ F_ed Δx_h, E_s = ∫ f_e dx_e, at every tick
//! ```
//! `examples/passive.rs` runs more cases.

use rayon::prelude::*;
use trocar::engine::Trace;
use trocar::run::{Run, RunReport, promise_gaps, run};
use trocar::scenario::{Scenario, Source};
use trocar::warning::Code;

use crate::support::passive_cases::{Case, Random};
use crate::support::scenario;

const SCHEMES: [&str; 3] = ["time-domain", "wave-variables", "energy-tank"];

fn ran(base: &str, settings: &[String]) -> Run {
    let scenario = Scenario::load(&Source::parse(&format!("builtin:{base}.toml")), settings);
    let scenario = scenario.unwrap_or_else(|error| panic!("{error:?}\n{settings:?}"));
    run(scenario).unwrap_or_else(|error| panic!("{error}\n{settings:?}"))
}

fn with(scheme: &str, settings: &[&str]) -> Vec<String> {
    settings.iter().map(|&setting| setting.to_owned()).chain([format!("passivity.scheme={scheme}")]).collect()
}

/// Returns the smallest `E_m - E_s` of a trace, computed here from forces and positions, and the total exchanged
/// energy.
fn smallest_balance(trace: &Trace) -> (f64, f64) {
    let (mut master_j, mut needle_j, mut smallest_j, mut moved_j) = (0.0, 0.0, 0.0_f64, 0.0);
    for k in 1..trace.len() {
        let master = trace.feedback_force_n[k - 1] * (trace.master_position_m[k] - trace.master_position_m[k - 1]);
        let mean_n = 0.5 * (trace.tissue_force_n[k] + trace.tissue_force_n[k - 1]);
        let needle = mean_n * (trace.slave_position_m[k] - trace.slave_position_m[k - 1]);
        (master_j, needle_j, moved_j) =
            (master_j + master, needle_j + needle, moved_j + f64::abs(master) + f64::abs(needle));
        smallest_j = smallest_j.min(master_j - needle_j);
    }
    (smallest_j, moved_j)
}

#[test]
fn no_scheme_breaks_its_promise_in_random_cases() {
    check_promises(300);
}

#[test]
#[ignore = "a minute of processor time"]
fn no_scheme_breaks_its_promise_in_two_thousand_random_cases() {
    check_promises(2000);
}

fn check_promises(count: usize) {
    let mut random = Random::new(23);
    let cases: Vec<Case> = (0..count).map(|_| Case::draw(&mut random, 2.0)).collect();
    let broken: Vec<String> = cases
        .par_iter()
        .enumerate()
        .filter_map(|(index, case)| {
            // Each case uses one scheme, in turn.
            let scheme = SCHEMES[index % 3];
            let settings = case.with(scheme);
            let run = ran(case.base, &settings);
            let promised_j = run.metrics.link.and_then(|link| link.promised_energy_j).expect("a promise");
            let (smallest_j, moved_j) = smallest_balance(&run.trace);
            let finite = run.trace.numbers().iter().all(|column| column.iter().all(|value| value.is_finite()));
            let rounding_j = 1e-9 + 1e-12 * moved_j;
            (!finite || smallest_j < -promised_j - rounding_j)
                .then(|| format!("{index}: {smallest_j} J of -{promised_j} J in {} {settings:?}", case.base))
        })
        .collect();
    assert!(broken.is_empty(), "{} cases, the first: {}", broken.len(), broken[0]);
}

#[test]
fn the_energies_of_both_engines_agree() {
    let late = ["channel.forward_delay_s=0.02", "channel.backward_delay_s=0.02", "simulation.duration_s=2"];
    let wall = [
        "operator.kind=sine",
        "operator.amplitude_m=0.005",
        "tissue.kind=kelvin-voigt",
        "tissue.stiffness_n_per_m=500",
    ];
    for scheme in ["none", "time-domain", "wave-variables", "energy-tank"] {
        let settings = with(scheme, &[&late[..], &wall[..]].concat());
        let exact = ran("paper/classical", &settings);
        let integrated = ran("paper/classical", &[&settings[..], &["simulation.engine=dop853".into()]].concat());
        let pairs = [
            (&exact.trace.hand_energy_j, &integrated.trace.hand_energy_j),
            (&exact.trace.master_energy_j, &integrated.trace.master_energy_j),
            (&exact.trace.reference_energy_j, &integrated.trace.reference_energy_j),
            (&exact.trace.needle_energy_j, &integrated.trace.needle_energy_j),
        ];
        for (at, (one, other)) in pairs.into_iter().enumerate() {
            let difference_j = one.iter().zip(other).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(difference_j < 1e-6, "{scheme}, port {at}: {difference_j} J");
        }
    }
}

#[test]
fn the_columns_and_metrics_agree_with_the_sums_of_force_times_displacement() {
    for scheme in ["none", "time-domain"] {
        let run = ran("passivity/late-wall", &with(scheme, &["simulation.duration_s=3"]));
        let (smallest_j, moved_j) = smallest_balance(&run.trace);
        let ports = run.metrics.ports.expect("ticks");
        assert!((ports.generated_j + smallest_j).abs() <= 1e-12 * moved_j, "{} {smallest_j}", ports.generated_j);
        let link = run.metrics.link.expect("late");
        assert!((link.generated_energy_j + smallest_j).abs() <= 1e-9 * moved_j);
        assert_eq!(Some(&ports.needle_energy_j), run.trace.needle_energy_j.last());
        let balance_j = ports.master_kept_j + ports.link_kept_j + ports.slave_kept_j;
        assert!((balance_j - (ports.hand_energy_j - ports.needle_energy_j)).abs() <= 1e-12 * moved_j);
    }
}

#[test]
fn the_needle_is_out_when_the_hand_is_out() {
    for scheme in SCHEMES {
        for seed in 1..=6 {
            let settings = ["simulation.duration_s=25".to_owned(), format!("simulation.seed={seed}")];
            let settings = [&settings[..], &with(scheme, &[])[..]].concat();
            let run = ran("link/long-delay", &settings);
            let link = run.metrics.link.expect("late");
            assert!(link.left_behind_m < 1e-3, "{scheme}, seed {seed}: {} m", link.left_behind_m);
        }
    }
}

#[test]
fn in_free_motion_and_soft_tissue_a_scheme_keeps_the_force() {
    let late = ["channel.forward_delay_s=0.05", "channel.backward_delay_s=0.05", "simulation.duration_s=4"];
    let ramp = ["operator.kind=ramp", "operator.start_m=-0.002", "operator.end_m=0.02", "operator.speed_m_per_s=0.02"];
    let tissue = |contact_m: &'static str| {
        ["tissue.kind=kelvin-voigt", "tissue.stiffness_n_per_m=200", "tissue.damping_n_s_per_m=0", contact_m]
    };
    let peak = |scheme: &str, contact_m: &'static str| {
        let settings = with(scheme, &[&late[..], &ramp[..], &tissue(contact_m)[..]].concat());
        let trace = ran("paper/classical", &settings).trace;
        trace.operator_force_n.iter().fold(0.0, |peak, force| f64::abs(*force).max(peak))
    };
    for contact_m in ["tissue.contact_m=0", "tissue.contact_m=0.5"] {
        let plain_n = peak("none", contact_m);
        for scheme in SCHEMES {
            let ratio = peak(scheme, contact_m) / plain_n;
            assert!((0.8..=1.2).contains(&ratio), "{scheme}, {contact_m}: {ratio}");
        }
    }
}

/// Returns the largest energy (J) that the plain loop may have to spend at a tick: `E_s - E_m` so far, plus the work
/// to brake the needle in the stiffest tissue that a scheme expects. The paper's slave brakes within 4 ms of its
/// motion.
fn demanded_j(trace: &Trace) -> f64 {
    const STOP_S: f64 = 4e-3;
    const MAX_STIFFNESS_N_PER_M: f64 = 2e4;
    let (mut generated_j, mut demanded_j) = (0.0, 0.0_f64);
    for k in 1..trace.len() {
        let mean_n = 0.5 * (trace.tissue_force_n[k] + trace.tissue_force_n[k - 1]);
        generated_j += mean_n * (trace.slave_position_m[k] - trace.slave_position_m[k - 1])
            - trace.feedback_force_n[k - 1] * (trace.master_position_m[k] - trace.master_position_m[k - 1]);
        let travel_m = STOP_S * trace.slave_velocity_m_per_s[k];
        let braking_j = trace.tissue_force_n[k] * travel_m + 0.5 * MAX_STIFFNESS_N_PER_M * travel_m * travel_m;
        demanded_j = demanded_j.max(generated_j + braking_j.max(0.0));
    }
    demanded_j
}

#[test]
fn without_delay_a_scheme_changes_a_stab_only_if_the_plain_loop_comes_near_the_promise() {
    let peak = |trace: &Trace| trace.feedback_force_n.iter().fold(0.0, |peak, force| f64::abs(*force).max(peak));
    let mut random = Random::new(70);
    let cases: Vec<Case> = (0..140).map(|_| Case::draw_stab(&mut random, 1.5)).collect();
    let found: Vec<(bool, bool, String)> = cases
        .par_iter()
        .flat_map_iter(|case| {
            let plain = ran(case.base, &case.settings);
            SCHEMES.into_iter().map(move |scheme| {
                let run = ran(case.base, &case.with(scheme));
                let [with, without] = [&run, &plain].map(|run| run.metrics.tracking_rmse_m.expect("ran"));
                let tracking = with / without - 1.0;
                let force = peak(&run.trace) / peak(&plain.trace) - 1.0;
                let promised_j = run.metrics.link.and_then(|link| link.promised_energy_j).expect("a promise");
                // A scheme reserves a fifth of the promise and damps the hand over another fifth.
                let share = demanded_j(&plain.trace) / promised_j;
                let is_changed = tracking.abs() >= 0.01 || force.abs() >= 0.01;
                (is_changed, share > 0.7, format!("{scheme}: {tracking} {force} {share} {:?}", case.settings))
            })
        })
        .collect();
    let unforced: Vec<_> = found.iter().filter(|(is_changed, is_near, _)| *is_changed && !is_near).collect();
    assert!(unforced.is_empty(), "{} of {}, the first: {}", unforced.len(), found.len(), unforced[0].2);
    // Both kinds of stabs occur in the cases.
    let near = found.iter().filter(|(_, is_near, _)| *is_near).count();
    assert!((found.len() / 5..found.len() * 4 / 5).contains(&near), "{near} of {}", found.len());
}

#[test]
fn damping_that_reverses_the_motion_within_a_tick_is_refused() {
    for (scheme, key) in [
        ("wave-variables", "passivity.wave_impedance_n_s_per_m"),
        ("time-domain", "passivity.damping_limit_n_s_per_m"),
        ("energy-tank", "passivity.damping_limit_n_s_per_m"),
    ] {
        let load = |value: &str| {
            let settings = with(scheme, &[&format!("{key}={value}")]);
            Scenario::load(&Source::parse("builtin:passivity/late-wall.toml"), &settings)
        };
        let error = load("500").expect_err("2 m / T is 490").to_string();
        assert!(error.contains(key) && error.contains("490"), "{error}");
        assert!(load("480").is_ok(), "{key}");
    }
}

#[test]
fn check_names_what_a_promise_does_not_cover() {
    let gaps = |base: &str, settings: &[&str]| {
        let gaps = promise_gaps(&scenario(base, settings));
        assert!(gaps.iter().all(|gap| gap.code == Code::PromiseNotCovered));
        gaps.into_iter().filter_map(|gap| gap.place).collect::<Vec<_>>()
    };
    assert!(gaps("passivity/late-wall-tank", &[]).is_empty());
    assert!(gaps("passivity/late-wall", &["tissue.stiffness_n_per_m=30000"]).is_empty(), "it has no scheme");
    let stiff = gaps("passivity/late-wall-tank", &["tissue.stiffness_n_per_m=30000"]);
    assert_eq!(stiff, ["passivity.max_stiffness_n_per_m"]);
    assert_eq!(gaps("passivity/long-delay-waves", &[]), ["sensor"]);
    let replayed = gaps("paper/classical", &["passivity.scheme=time-domain", "slave.compliance_m_per_n=1e-4"]);
    assert_eq!(replayed, ["slave.compliance_m_per_n", "tissue.index"]);
}

#[test]
fn a_broken_promise_causes_a_warning_with_its_place_and_amount() {
    // A wall far stiffer than the scheme expects.
    let settings = [
        "passivity.budget_j=1e-4",
        "passivity.max_stiffness_n_per_m=1",
        "tissue.stiffness_n_per_m=20000",
        "operator.speed_m_per_s=0.2",
    ];
    let run = ran("passivity/late-wall", &with("time-domain", &settings));
    let warning =
        RunReport::of(&run).warnings().into_iter().find(|warning| warning.code == Code::PromiseBroken).expect("broken");
    assert_eq!(warning.place.as_deref(), Some("passivity.scheme"));
    assert!(
        warning.message.contains("mJ") && warning.message.contains(" s, with the needle at"),
        "{}",
        warning.message
    );
    for scheme in SCHEMES {
        let run = ran("passivity/late-wall", &with(scheme, &[]));
        assert!(RunReport::of(&run).warnings().iter().all(|warning| warning.code != Code::PromiseBroken), "{scheme}");
    }
}
