//! The passivity schemes of a delayed link: their effect, their cost and their logged energies.

use proptest::prelude::*;
use trocar::engine::Trace;
use trocar::metrics::Metrics;
use trocar::run::run;
use trocar::scenario::{Scenario, Source};

const SCHEMES: [&str; 3] = ["time-domain", "wave-variables", "energy-tank"];

fn ran(file: &str, settings: &[String]) -> (Trace, Metrics) {
    let scenario = Scenario::load(&Source::parse(&format!("builtin:{file}")), settings).expect("loads");
    let run = run(scenario).expect("runs");
    (run.trace, run.metrics)
}

/// Returns the peak-to-peak amplitude of a signal over an interval in s.
fn swing(signal: &[f64], from_s: usize, to_s: usize) -> f64 {
    let part = &signal[from_s * 1000..to_s * 1000];
    let (low, high) = part.iter().fold((f64::MAX, f64::MIN), |(low, high), &v| (low.min(v), high.max(v)));
    high - low
}

#[test]
fn every_scheme_stabilises_the_contact_in_which_the_plain_loop_grows() {
    let (plain, _) = ran("passivity/late-wall.toml", &[]);
    let (early, late) = (swing(&plain.feedback_force_n, 1, 3), swing(&plain.feedback_force_n, 10, 12));
    assert!(late > early && late > 10.0, "the plain loop: {early} N, then {late} N");
    for file in
        ["passivity/late-wall-time-domain.toml", "passivity/late-wall-waves.toml", "passivity/late-wall-tank.toml"]
    {
        let (trace, _) = ran(file, &[]);
        let late = swing(&trace.feedback_force_n, 10, 12);
        assert!(late < 0.05, "{file}: still {late} N");
        assert!(trace.slave_position_m[11_999] > 0.007, "{file}: it stays in contact");
    }
}

#[test]
fn without_delay_a_scheme_costs_at_most_a_hundredth_of_tracking() {
    for file in ["paper/classical.toml", "paper/augmented.toml"] {
        let (_, plain) = ran(file, &[]);
        for scheme in SCHEMES {
            let (_, metrics) = ran(file, &[format!("passivity.scheme={scheme}")]);
            let (with, without) = (metrics.tracking_rmse_m.expect("ran"), plain.tracking_rmse_m.expect("ran"));
            assert!(with <= 1.01 * without, "{file} {scheme}: {with} beside {without}");
            assert_eq!(metrics.missed_ruptures, 0, "{file} {scheme}");
        }
    }
}

/// Returns a link with a random scheme and random delays, a spring of random stiffness (N/m), and a hand that
/// oscillates inside it.
fn random_link() -> impl Strategy<Value = (Vec<String>, f64)> {
    let link = (0..SCHEMES.len(), 1..60u32, 0..60u32, 0.0..0.02, 0.0..0.3);
    (link, 50.0..300.0, 0.001..0.008, 0.3..1.5, 1..1000u64).prop_map(
        |((scheme, forth, back, jitter_s, loss), stiffness, amplitude, frequency, seed)| {
            let settings = vec![
                format!("passivity.scheme={}", SCHEMES[scheme]),
                format!("channel.forward_delay_s={}", f64::from(forth) * 1e-3),
                format!("channel.backward_delay_s={}", f64::from(back) * 1e-3),
                format!("channel.jitter_s={jitter_s}"),
                format!("channel.loss={loss}"),
                format!("simulation.seed={seed}"),
                "operator.kind=sine".into(),
                "operator.start_m=0.04".into(),
                format!("operator.amplitude_m={amplitude}"),
                format!("operator.frequency_hz={frequency}"),
                "tissue.kind=kelvin-voigt".into(),
                format!("tissue.stiffness_n_per_m={stiffness}"),
                "tissue.damping_n_s_per_m=0".into(),
                "simulation.duration_s=2".into(),
            ];
            (settings, stiffness)
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    /// The master's force is held over a tick, so the integral of force times velocity is the sum of forces times
    /// displacements. The work of the needle on a spring is the energy of the spring.
    #[test]
    fn the_logged_energies_are_the_integrals_at_the_ports((settings, stiffness) in random_link()) {
        let (trace, metrics) = ran("paper/classical.toml", &settings);
        let link = metrics.link.expect("the link is late");
        let last = trace.mode.len() - 1;
        let (mut master, mut throughput) = (0.0, 0.0);
        for k in 0..last {
            let work = trace.feedback_force_n[k] * (trace.master_position_m[k + 1] - trace.master_position_m[k]);
            master += work;
            throughput += f64::abs(work);
        }
        prop_assert!((link.master_port_energy_j - master).abs() <= 1e-6 * throughput, "{} {master}", link.master_port_energy_j);
        prop_assert!(trace.slave_position_m.iter().all(|&x| x > 0.0), "the needle stays inside");
        let held = |x: f64| 0.5 * stiffness * x * x;
        let slave = held(trace.slave_position_m[last]) - held(trace.slave_position_m[0]);
        let most = trace.slave_position_m.iter().map(|&x| held(x)).fold(0.0, f64::max);
        prop_assert!((link.slave_port_energy_j - slave).abs() <= 1e-6 * most, "{} {slave}", link.slave_port_energy_j);
    }
}
