//! The architectures: the tissue's impedance that each transmits to the hand, and the augmentation with each.

use std::f64::consts::TAU;

use trocar::engine::Trace;
use trocar::metrics::Metrics;
use trocar::run::run;
use trocar::scenario::{Scenario, Source};

const TICK_S: f64 = 1e-3;

fn ran(file: &str, settings: &[String]) -> (Trace, Metrics) {
    let scenario = Scenario::load(&Source::parse(&format!("builtin:{file}")), settings).expect("loads");
    let run = run(scenario).expect("runs");
    (run.trace, run.metrics)
}

/// Returns the Fourier sum of a signal over the last whole periods.
fn phasor(signal: &[f64], frequency_hz: f64, ticks: usize) -> (f64, f64) {
    let first = signal.len() - ticks;
    signal[first..].iter().zip(first..).fold((0.0, 0.0), |(re, im), (value, k)| {
        let phase = TAU * frequency_hz * k as f64 * TICK_S;
        (re + value * phase.cos(), im - value * phase.sin())
    })
}

fn ratio((a, b): (f64, f64), (c, d): (f64, f64)) -> (f64, f64) {
    let square = c * c + d * d;
    ((a * c + b * d) / square, (b * c - a * d) / square)
}

/// Returns the deviation of the impedance at the hand from the tissue's `K + jωB`, as a fraction of its magnitude.
/// The hand oscillates by 2 mm inside the tissue.
fn impedance_error(kind: &str, frequency_hz: f64, (stiffness, damping): (f64, f64), more: &[&str]) -> f64 {
    let mut settings = vec![
        format!("controller.kind={kind}"),
        "operator.kind=sine".into(),
        "operator.amplitude_m=0.002".into(),
        format!("operator.frequency_hz={frequency_hz}"),
        "tissue.kind=kelvin-voigt".into(),
        "tissue.contact_m=-0.05".into(),
        format!("tissue.stiffness_n_per_m={stiffness}"),
        format!("tissue.damping_n_s_per_m={damping}"),
        "simulation.duration_s=8".into(),
    ];
    settings.extend(more.iter().map(|&setting| setting.to_owned()));
    let (trace, _) = ran("paper/classical.toml", &settings);
    let ticks = 4000;
    let force = phasor(&trace.operator_force_n, frequency_hz, ticks);
    let position = phasor(&trace.master_position_m, frequency_hz, ticks);
    let felt = ratio(force, position);
    let (re, im) = ratio(felt, (stiffness, TAU * frequency_hz * damping));
    (re - 1.0).hypot(im)
}

#[test]
fn four_channels_show_the_tissue_within_five_percent_up_to_five_hertz() {
    for tissue in [(200.0, 5.0), (50.0, 1.0), (1000.0, 0.0), (300.0, 20.0)] {
        for frequency_hz in [0.5, 1.0, 2.0, 3.0, 5.0] {
            let error = impedance_error("four-channel", frequency_hz, tissue, &[]);
            assert!(error < 0.05, "{tissue:?} at {frequency_hz} Hz: {error}");
        }
    }
}

#[test]
fn the_papers_architecture_does_not_show_the_tissue_within_five_percent() {
    assert!(impedance_error("position-force", 5.0, (200.0, 5.0), &[]) > 0.5);
    let local = impedance_error("local-force", 5.0, (200.0, 5.0), &[]);
    let paper = impedance_error("position-force", 5.0, (200.0, 5.0), &[]);
    assert!(local < 0.5 * paper, "{local} beside {paper}");
}

#[test]
fn four_channels_stay_transparent_with_scales_grips_and_a_compliant_slave() {
    for more in [
        &["arm.grip=firm"][..],
        &["arm.grip=relaxed"],
        &["slave.compliance_m_per_n=7.7e-4"],
        &["slave.compliance_m_per_n=7.7e-4", "controller.slave_force_gain=0.5"],
    ] {
        let error = impedance_error("four-channel", 5.0, (200.0, 5.0), more);
        assert!(error < 0.05, "{more:?}: {error}");
    }
    // With half the slave motion and three times the force, the impedance at the hand is 1.5 times that of the
    // tissue.
    let scaled = ["scaling.position=0.5", "scaling.force=3"];
    let mut settings: Vec<String> = scaled.iter().map(|&setting| setting.to_owned()).collect();
    settings.extend(
        ["controller.kind=four-channel", "operator.kind=sine", "operator.amplitude_m=0.002", "operator.frequency_hz=2"]
            .map(str::to_owned),
    );
    settings
        .extend(["tissue.kind=kelvin-voigt", "tissue.contact_m=-0.05", "simulation.duration_s=8"].map(str::to_owned));
    let (trace, _) = ran("paper/classical.toml", &settings);
    let felt = ratio(phasor(&trace.operator_force_n, 2.0, 4000), phasor(&trace.master_position_m, 2.0, 4000));
    let (re, im) = ratio(felt, (1.5 * 200.0, 1.5 * TAU * 2.0 * 5.0));
    assert!((re - 1.0).hypot(im) < 0.05, "{re} {im}");
}

#[test]
fn four_channels_are_stable_with_a_stiff_tissue_in_a_firm_grip() {
    let error = impedance_error("four-channel", 0.5, (4000.0, 0.0), &["arm.grip=firm"]);
    assert!(error < 0.05, "{error}");
}

#[test]
fn position_position_feels_the_tissue_only_with_a_compliant_slave() {
    let peak = |more: &str| {
        let settings = [
            "controller.kind=position-position",
            "operator.kind=ramp",
            "operator.speed_m_per_s=0.005",
            "tissue.kind=kelvin-voigt",
            "simulation.duration_s=6",
            more,
        ];
        let (trace, _) = ran("paper/classical.toml", &settings.map(str::to_owned));
        trace.feedback_force_n[trace.feedback_force_n.len() - 1]
    };
    // At rest at 20 mm the stiff slave follows the hand exactly. The compliant slave lags by 0.77 mm/N, and the
    // coupling spring has 1000 N/m.
    assert!(peak("slave.compliance_m_per_n=0").abs() < 0.01);
    let felt = peak("slave.compliance_m_per_n=7.7e-4");
    // f = K x_e, x_e = x_h - c f, F = K_c c f, and the hand deflects by F / 698.845.
    let (k, c, coupling, arm) = (200.0, 7.7e-4, 1000.0, 698.845);
    let share = k / (1.0 + c * k);
    let expected = coupling * c * share * 0.02 / (1.0 + coupling * c * share / arm);
    assert!((felt - expected).abs() < 1e-3 * expected, "{felt} beside {expected}");
}

#[test]
fn augmentation_holds_the_needle_with_every_architecture() {
    for kind in ["position-force", "local-force", "position-position", "four-channel"] {
        let settings = [format!("controller.kind={kind}")];
        let (trace, augmented) = ran("paper/augmented.toml", &settings);
        let (_, classical) = ran("paper/classical.toml", &settings);
        let first = &augmented.ruptures[0];
        assert!(first.detection_delay_s.is_some_and(|delay| delay < 0.01), "{kind}: {first:?}");
        assert!(
            first.slave_overshoot_m < Some(0.1 * classical.ruptures[0].slave_overshoot_m.expect("a rupture")),
            "{kind}: {first:?}"
        );
        assert!(augmented.feedback_step_excess_n < 1e-9, "{kind}: {}", augmented.feedback_step_excess_n);
        let mut frozen = 0;
        for k in 1..trace.mode.len() {
            if trace.mode[k] == 1 && trace.mode[k - 1] == 1 {
                assert_eq!(trace.slave_reference_m[k], trace.slave_reference_m[k - 1], "{kind} at {k}");
                frozen += 1;
            }
        }
        assert!(frozen > 400, "{kind}: {frozen}");
    }
}

#[test]
fn settings_that_exclude_each_other_are_refused_with_a_remedy() {
    for (settings, expected) in [
        (&["controller.kind=four-channel", "passivity.scheme=wave-variables"][..], "wave variables carry"),
        (&["controller.kind=local-force", "master.coupling=as-printed"], "without the hand's force"),
        (&["controller.kind=four-channel", "slave.damping=as-printed"], "needs velocity damping"),
        (&["controller.kind=four-channel", "slave.proportional_gain=0"], "above 0 for this controller.kind"),
        (&["controller.kind=four-channel", "scaling.position=0"], "scaling.position is 0"),
        (&["passivity.scheme=energy-tank", "scaling.force=0"], "scaling.force is 0"),
        (&["passivity.scheme=energy-tank", "passivity.tank_share=1"], "below 1"),
        (&["passivity.tank_share=0.5"], "it acts for passivity.scheme = \"energy-tank\""),
        (
            &["slave.compliance_m_per_n=1e-3", "simulation.control=sampled", "actuator.slave_lag_s=0.01"],
            "needs a motor without limits and lag",
        ),
    ] {
        let settings: Vec<String> = settings.iter().map(|&setting| setting.to_owned()).collect();
        let error = Scenario::load(&Source::parse("builtin:paper/classical.toml"), &settings).expect_err("refused");
        assert!(error.to_string().contains(expected), "{error}");
    }
}
