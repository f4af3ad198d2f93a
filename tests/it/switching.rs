//! The certificate of the switching compared with the engine, for random sequences of events and for the worst
//! sequence found.

use crate::support;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, OnceLock};

use trocar::augmentation::Reengage;
use trocar::scenario::{Scenario, Source};
use trocar::stability::Switching;
use trocar::stability_check::{EventRecord, EventRun, random_sequences, without_alarms, worst_events};
use trocar::time::nearest_ticks;

const TISSUE: (f64, f64) = (50.0, 600.0);

const MANUAL: &str = include_str!("../../docs/src/concepts/certificate.md");

fn source() -> Source {
    Source::parse("builtin:paper/augmented.toml")
}

/// Returns the settings, with a spring and a damper in place of the recorded force.
fn owned(settings: &[&str]) -> Vec<String> {
    let tissue = ["tissue.stiffness_n_per_m=200", "tissue.damping_n_s_per_m=5"];
    tissue.iter().chain(settings).map(|&setting| setting.to_owned()).collect()
}

fn scenario(settings: &[&str]) -> Scenario {
    Scenario::load(&source(), &owned(settings)).expect("loads")
}

fn analysed(settings: &[&str], tissue: (f64, f64)) -> Switching {
    static CACHE: Mutex<BTreeMap<String, Arc<OnceLock<Switching>>>> = Mutex::new(BTreeMap::new());
    let key = format!("{settings:?} {tissue:?}");
    let place = Arc::clone(CACHE.lock().expect("not poisoned").entry(key).or_default());
    let analyse = || {
        let settings = support::switching(&scenario(settings), tissue).expect("covered");
        Switching::of(&settings).expect("analysed")
    };
    place.get_or_init(analyse).clone()
}

/// A hold while frozen acts as a delay: force and position of the last tick are held, like with a slow sampler.
const HOLD: [&str; 8] = [
    "augmentation.decay_ratio=1.0",
    "augmentation.reengage=snap",
    "augmentation.blend_s=0.0",
    "augmentation.min_hold_s=0.05",
    "augmentation.max_hold_s=0.05",
    "augmentation.exit_quiet_s=0.0",
    "augmentation.refractory_s=0.001",
    "tissue.damping_n_s_per_m=0.0",
];

fn at_rest(settings: &[&str]) -> Scenario {
    without_alarms(&source(), &owned(settings)).expect("loads")
}

#[test]
#[ignore = "a minute of processor time: certificates"]
fn any_events_at_the_papers_numbers_are_certified_with_a_margin() {
    let switching = analysed(&[], TISSUE);
    let found = switching.certificate.as_ref().expect("certified");
    assert!(switching.is_certified());
    assert!(found.choice.dwell_ticks <= 11 && found.choice.contraction <= 1.0);
    // This method is independent of the solver and of the verification.
    assert!(found.p_at_events().symmetric_eigenvalues().min() > 0.0);
    assert_eq!(switching.growing_dwell_ticks, None);
    assert_eq!(switching.covers_lost_contact, Some(true));
    // The found and the certified growth enclose the true one.
    let certified = switching.at_refractory.as_ref().expect("certified").choice.contraction.sqrt();
    assert!(switching.growth.found <= certified && certified <= 10.0 * switching.growth.found && certified < 0.1);
    assert!(switching.by_dwell.iter().all(|point| point.certified.is_none_or(|bound| point.found <= bound)));
}

/// Returns the certified dwell in ms.
fn dwell_ms(settings: &[&str], tissue: (f64, f64)) -> Option<f64> {
    let settings = support::switching(&scenario(settings), tissue).expect("covered");
    let ticks = Switching::certified_dwell(&settings).expect("analysed")?;
    Some(1e3 * ticks as f64 * settings.of_loop.tick_s)
}

#[test]
#[ignore = "a minute of processor time: certificates"]
fn dwells_are_certified_for_stiffer_tissues_and_larger_scales() {
    // An independent solver, with one function of state and gap, gives 11, 41, 315, 42 and 172 ms.
    for (settings, tissue, limit_ms) in [
        (&[][..], (50.0, 1000.0), 41.0),
        (&[][..], (50.0, 2000.0), 315.0),
        (&["scaling.force=2"][..], TISSUE, 42.0),
        (&["scaling.force=4"][..], TISSUE, 172.0),
    ] {
        let found = dwell_ms(settings, tissue).expect("certified");
        assert!(found <= limit_ms, "{settings:?} {tissue:?}: {found} ms");
        let case = settings.first().map_or(format!("50 to {} N/m", tissue.1), |setting| format!("`{setting}`"));
        let row = format!("| {case} | {found} ms |");
        assert!(MANUAL.contains(&row), "{row}");
    }
}

#[test]
#[ignore = "a minute of processor time: certificates"]
fn the_certified_dwell_depends_on_the_tick_only_by_rounding() {
    for tissue in [TISSUE, (50.0, 1000.0)] {
        let dwell = |tick_ms: f64| {
            let setting = format!("simulation.tick_s={}", 1e-3 * tick_ms);
            dwell_ms(&[setting.as_str()], tissue).expect("certified")
        };
        let finest_ms = dwell(0.2);
        for tick_ms in [1.0, 5.0] {
            let found_ms = dwell(tick_ms);
            let most_ms = (1.3 * finest_ms / tick_ms).ceil() * tick_ms;
            assert!(finest_ms <= found_ms && found_ms <= most_ms + 1e-9, "{tick_ms}: {found_ms} {finest_ms}");
            let is_in_manual = MANUAL.contains(&format!("{} ms at {tick_ms}", found_ms.round()));
            assert!(tissue != TISSUE || is_in_manual, "{found_ms}");
        }
    }
}

#[test]
#[ignore = "a minute of processor time: certificates"]
fn the_certificates_of_delays_and_other_architectures_agree_with_the_manual() {
    // Only the first columns of each row of the manual's table; the others take longer.
    for (setting, delays_s) in [
        ("controller.kind=position-force", &["0", "0.001"][..]),
        ("controller.kind=local-force", &["0", "0.001"]),
        ("controller.kind=position-position", &["0"]),
        ("controller.kind=four-channel", &["0"]),
    ] {
        let cell = |delay_s: &&str| {
            let delays = ["forward", "backward"].map(|way| format!("channel.{way}_delay_s={delay_s}"));
            let found_ms = dwell_ms(&[setting, &delays[0], &delays[1]], TISSUE).expect("certified");
            format!(" {found_ms} ms |")
        };
        let case = if setting == "controller.kind=position-force" { "as shipped" } else { &format!("`{setting}`") };
        let row = format!("| {case} |{}", delays_s.iter().map(cell).collect::<String>());
        assert!(MANUAL.contains(&row), "{row}");
    }
}

#[test]
#[ignore = "a minute of processor time: certificates"]
fn five_and_ten_ticks_each_way_are_certified_with_the_supervisors_time() {
    for delay_s in ["0.005", "0.01"] {
        let settings = ["forward", "backward"].map(|way| format!("channel.{way}_delay_s={delay_s}"));
        let scenario = Scenario::load(&source(), &settings).expect("loads");
        let settings = support::switching(&scenario, TISSUE).expect("covered");
        let refractory = settings.phases().refractory;
        assert!(Switching::certifies(&settings, refractory).expect("analysed"), "{delay_s}");
    }
}

#[test]
#[ignore = "a minute of processor time: certificates"]
fn amplified_forces_are_certified_at_the_enforced_time() {
    let switching = analysed(&["augmentation.force_law=amplify"], TISSUE);
    // With lost contact at any tick and an additional force.
    let peaks = switching.peaks.as_ref().expect("certified");
    assert_eq!(peaks.certificate.choice.dwell_ticks, switching.phases.refractory);
    assert!(peaks.decay_per_s > 0.0 && peaks.certificate.verify(&switching.settings).is_ok());
    assert!(switching.is_certified(), "{:?}", switching.dwell_ticks());
}

#[test]
fn a_gap_that_is_kept_has_no_certificate_and_grows_in_no_sequence() {
    let switching = analysed(&["augmentation.reengage=clutch"], TISSUE);
    assert!(switching.certificate.is_none() && switching.peaks.is_none() && !switching.is_certified());
    // On the softest tissue an event keeps 93 % of the gap, the ratio of the arm's spring to both springs together.
    let arm = &switching.settings.of_loop.arm;
    let spring = arm.k_a_n_per_m * arm.k_h_n_per_m / (arm.k_a_n_per_m + arm.k_h_n_per_m);
    let at_rest = spring / (spring + TISSUE.0);
    assert!((switching.growth.found / at_rest - 1.0).abs() < 0.01, "{} {at_rest}", switching.growth.found);
    assert!(!switching.shows_growth());
}

#[test]
#[ignore = "a minute of processor time: certificates"]
fn a_hundred_thousand_random_sequences_stay_within_the_certified_bound() {
    let short = [
        "augmentation.min_hold_s=0.02",
        "augmentation.max_hold_s=0.1",
        "augmentation.exit_quiet_s=0.0",
        "augmentation.blend_s=0.02",
        "augmentation.refractory_s=0.15",
    ];
    let snap = ["augmentation.reengage=snap"];
    // Number of sequences, ticks of each, and the minimum share of the bound that they reach: short ones end before the
    // motion has built up.
    for (settings, count, ticks, share) in
        [(&[][..], 2_000, 2_500, 0.1), (&snap[..], 1_000, 2_500, 0.1), (&short[..], 96_000, 240, 0.05)]
    {
        let switching = analysed(settings, TISSUE);
        assert!(switching.is_certified(), "{settings:?}");
        let peaks = switching.peaks.as_ref().expect("bounded");
        let bound = peaks.needle_m_per_n;
        let base = at_rest(settings);
        let farthest = random_sequences(&base, (TISSUE, switching.phases), (count, ticks), 7).expect("runs");
        assert!(farthest.events > count, "{settings:?}: hardly any events");
        let found = farthest.needle_m_per_n;
        assert!(found <= bound, "{settings:?}: {found} beyond {bound}");
        // The bound is not trivially large.
        assert!(found > share * bound, "{settings:?}: {found} of {bound}");
    }
}

#[test]
#[ignore = "a minute of processor time: certificates"]
fn the_motion_decays_in_the_engine_on_the_worst_sequence_found() {
    for policy in ["ramp", "snap"] {
        let setting = format!("augmentation.reengage={policy}");
        let settings = if policy == "ramp" { vec![] } else { vec![setting.as_str()] };
        let switching = analysed(&settings, TISSUE);
        let shown = worst_events(&source(), &[setting], &switching).expect("loads");
        let mut seen = EventRecord::default();
        // The tick of the release does not belong to an event.
        shown.build().expect("built").run(&mut seen).expect("runs");
        assert_eq!(seen.events, shown.events.len() as u64);
        let at = &seen.at_events_m;
        assert!(at[at.len() - 1].abs() < 1e-3 * at[0].abs(), "{policy}: {at:?}");
    }
}

#[test]
#[ignore = "a minute of processor time: certificates"]
fn the_worst_sequence_is_shown_whatever_tissue_and_operator_are_set() {
    let layers = Source::parse("layers/skin-augmented");
    let set =
        owned(&["tissue.layer.skin.rupture_force_n=8", "operator.movement_s=4", "operator.tremor_amplitude_m=1e-5"]);
    let shown = worst_events(&layers, &set, &analysed(&[], TISSUE)).expect("loads");
    assert_eq!(shown.name, "worst-events");
}

#[test]
#[ignore = "a minute of processor time: certificates"]
fn fast_switching_that_makes_a_stable_loop_unstable_is_refused_and_shown() {
    let switching = analysed(&HOLD, (1500.0, 1500.0));
    let of_loop = trocar::stability::LinearLoop { stiffness_n_per_m: 1500.0, ..switching.settings.of_loop.clone() };
    assert!(trocar::stability::ClosedLoop::new(&of_loop).expect("built").is_stable().expect("counted"));
    assert!(!switching.is_certified());
    let (found, growing) =
        (switching.certificate.as_ref().expect("slowly"), switching.growing_dwell_ticks.expect("fast"));
    assert!(growing >= switching.phases.refractory && growing < found.choice.dwell_ticks);
    assert!(switching.shown.found > 1.0);
    // The growth in the engine agrees with the analysis, event by event.
    let shown = worst_events(&source(), &owned(&HOLD), &switching).expect("loads");
    let mut seen = EventRecord::default();
    shown.build().expect("built").run(&mut seen).expect("runs");
    let period = switching.shown.worst.len();
    let at = &seen.at_events_m;
    assert!(at.len() >= period + 4, "{at:?}");
    let last = at.len() - 1;
    // Average over several events, because an oscillating pole makes the growth of a single event uneven.
    let rounds = (last - 2) / period;
    let growth = (at[last] / at[last - rounds * period]).abs().powf(1.0 / (rounds * period) as f64);
    assert!(growth > 1.0 && (growth / switching.shown.found - 1.0).abs() < 0.1, "{growth} {}", switching.shown.found);
    // If teleoperation between events lasts as long as certified, the motion decays.
    let ticks = found.choice.dwell_ticks;
    let calm = format!("augmentation.refractory_s={}", ticks as f64 * 1e-3);
    let calm: Vec<&str> = HOLD.iter().copied().chain([calm.as_str()]).collect();
    let switching = analysed(&calm, (1500.0, 1500.0));
    assert!(switching.is_certified() && switching.shown.found < 1.0);
}

#[test]
#[ignore = "a minute of processor time: certificates"]
fn cases_that_the_certificate_does_not_cover_are_reported() {
    for (setting, word) in [
        ("augmentation.enabled=false", "there are no events"),
        ("channel.forward_delay_s=0.03", "24 ticks"),
        ("channel.forward_delay_s=0.0005", "whole number of ticks"),
        ("passivity.scheme=time-domain", "passivity"),
    ] {
        let reason = support::switching(&scenario(&[setting]), TISSUE).expect_err("not covered");
        assert!(reason.contains(word), "{reason}");
    }
    // A tissue with unstable teleoperation has no certificate for any dwell.
    let unstable = analysed(&["tissue.damping_n_s_per_m=0.0"], (50.0, 3000.0));
    assert!(unstable.certificate.is_none() && unstable.peaks.is_none() && !unstable.is_certified());
    // The unstable master of the paper's printed equations has none either.
    let printed = analysed(&["master.coupling=as-printed"], TISSUE);
    assert!(printed.certificate.is_none() && printed.growth.found > 1.0);
}

#[test]
#[ignore = "a minute of processor time: certificates"]
fn releasing_the_slave_moves_the_needle_suddenly_with_snap_only() {
    let events = analysed(&["augmentation.reengage=snap"], TISSUE).events;
    let of = |wanted: fn(&Reengage) -> bool| events.iter().find(|event| wanted(&event.reengage)).expect("there");
    let ramp = of(|policy| matches!(policy, Reengage::Ramp { .. }));
    let (clutch, snap) = (of(|policy| *policy == Reengage::Clutch), of(|policy| *policy == Reengage::Snap));
    assert_eq!((ramp.reference_jump_m, clutch.reference_jump_m), (0.0, 0.0));
    assert!((snap.reference_jump_m - 0.009).abs() < 1e-12);
    assert!(ramp.slave_speed_m_per_s < 0.04 && snap.slave_speed_m_per_s > 0.3, "{ramp:?} {snap:?}");
    assert!(clutch.slave_motion_m < 1e-6 && clutch.force_n < 1e-6);
    assert!(snap.force_step_n > 2.0 * ramp.force_step_n);
}

#[test]
fn scheduled_events_are_accepted_when_an_alarm_would_be() {
    let base = at_rest(&[]);
    let held = nearest_ticks(0.5, base.grid.tick_s());
    // The second event occurs while frozen, the third in the refractory period; the fourth is accepted.
    let run = EventRun {
        stiffness_n_per_m: 300.0,
        amplitude_m: 1e-5,
        period_s: 1.0,
        held_ticks: held,
        alarms: vec![100, 300, 750, 1200],
        ticks: 2000,
    };
    let seen = run.run(&base).expect("runs");
    assert_eq!(seen.events, 2);
    let folder = crate::support::test_folder::TestFolder::new();
    for (events, phrase) in [("[-1.0]", "at least 0"), ("[2.0, 1.0]", "must ascend"), ("[1.0, 1.0001]", "ascend")] {
        let setting = format!("augmentation.events_s={events}");
        folder.refused(&["check", "builtin:paper/augmented.toml", "--set", &setting], &[phrase]);
    }
}

#[test]
#[ignore = "a minute of processor time: certificates"]
fn the_command_writes_the_printed_results_of_the_switching() {
    let folder = crate::support::test_folder::TestFolder::new();
    let small = ["--x", "scaling.force=0.1:10:8", "--y", "tissue.stiffness_n_per_m=10:2000:8"];
    let stated = ["--set", "augmentation.reengage=snap", "--set", "tissue.stiffness_n_per_m=200"];
    let command = [&["stability", "builtin:paper/augmented.toml", "--tissue", "50:600"], &stated[..]].concat();
    let printed = folder.good(&[&command[..], &small].concat());
    for phrase in ["switching: 50.00 to 600.0 N/m", "certificate: decays", "certified", "growth per event"] {
        assert!(printed.contains(phrase), "no {phrase:?} in\n{printed}");
    }
    let out = folder.path("out/augmented");
    for name in
        ["switching.csv", "certificate.json", "released.csv", "switching.svg", "switching.png", "worst_events.toml"]
    {
        assert!(out.join(name).is_file(), "{name}");
    }
    folder.good(&["check", out.join("worst_events.toml").to_str().expect("a path")]);
    let certificate = out.join("certificate.json");
    let file = certificate.to_str().expect("a path");
    let verify = [&["stability", "builtin:paper/augmented.toml", "--verify", file], &stated[..]].concat();
    let printed = folder.good(&verify);
    assert!(printed.contains("statement: ") && printed.contains("with 50.00 to 600.0 N/m"), "{printed}");
    let other = folder.trocar(&verify[..4]);
    assert!(other.code == 1 && other.err.contains("give the scenario and the --set"), "{}", other.err);
    folder.refused(&["stability", "--verify", file], &["trocar stability SCENARIO --verify"]);
    folder.refused(&[&verify[..], &["--tissue", "50:600"]].concat(), &["cannot be used with"]);
    folder.refused(&[&verify[..], &["--out", "other"]].concat(), &["cannot be used with"]);
    std::fs::write(&certificate, "{}").expect("written");
    folder.refused(&verify, &["not a certificate file"]);
    folder.refused(&["stability", "--tissue", "600:50"], &["LOW:HIGH"]);
}
