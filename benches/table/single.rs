//! A single run, compared with the loop written by hand.

use std::hint::black_box;

use crate::handwritten::Handwritten;
use crate::markdown::{Table, figure};
use crate::record::Inputs;
use crate::shipped::{scenario, scenario_with};
use crate::timing::{Cost, elapsed_s, time_ns};
use crate::whole::{bare_ns, full_ns, ready};

/// Tolerance between the hand-written loop and the engine, relative to the slave's maximum position.
const TOLERANCE: f64 = 1e-9;

/// Estimators outside the fast path.
const ESTIMATORS: [(&str, &str); 4] = [
    ("exponential forgetting", "estimator.forgetting=exponential"),
    ("with friction", "estimator.parameters=stiffness-damping-friction"),
    ("least residual", "estimator.parameters=least-residual"),
    ("Hunt-Crossley", "estimator.parameters=hunt-crossley"),
];

/// Returns the baseline of the augmented scenario, after checking it against the engine's trajectory.
fn baseline() -> (Handwritten, Vec<f64>) {
    let scenario = scenario("augmented");
    let (engine, mut observer) = ready(&scenario);
    let inputs = Inputs::of(&scenario);
    let last = inputs.plants.last().map(|side| side[1]);
    let desired_m = inputs.plants.iter().map(|side| side[0]).chain(last).collect();
    let handwritten = Handwritten::new(&scenario, desired_m, inputs.sensor.clone());
    let mut slave_m = vec![0.0; handwritten.ticks()];
    let alarms = handwritten.run(&mut slave_m);
    engine.clone().run_compiled(&mut observer).expect("runs");
    let events = observer.metrics(0).alarms.len() as u64;
    assert!(events > 0 && alarms == events, "{alarms} alarms by hand, {events} by the engine");
    let of_engine = inputs.observer.iter().map(|signals| signals.slave_position_m);
    let peak_m = of_engine.clone().fold(0.0, |peak: f64, x| peak.max(x.abs()));
    let difference_m = of_engine.zip(&slave_m).fold(0.0, |max: f64, (x, y)| max.max((x - y).abs()));
    assert!(difference_m <= TOLERANCE * peak_m, "a difference of {difference_m} m with a peak of {peak_m} m");
    eprintln!("  by hand and by the engine: difference {:.1e} of the peak", difference_m / peak_m);
    (handwritten, slave_m)
}

/// Measures the baseline, and if the machine has AVX2 also the baseline compiled for it, like the engine.
#[allow(unsafe_code, reason = "calling a function that is compiled for an instruction set")]
fn baseline_costs() -> Vec<(&'static str, Cost)> {
    let (handwritten, mut slave_m) = baseline();
    let ticks = handwritten.ticks() as f64;
    let plain = time_ns(ticks, || {
        elapsed_s(|| {
            black_box(black_box(&handwritten).run(black_box(&mut slave_m)));
        })
    });
    let mut costs = vec![("written by hand", plain)];
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx2") {
        let wide = time_ns(ticks, || {
            elapsed_s(|| {
                // SAFETY: the check above ensures that the machine has the instructions of the function.
                black_box(unsafe { black_box(&handwritten).run_avx2(black_box(&mut slave_m)) });
            })
        });
        costs.push(("written by hand, for AVX2", wide));
    }
    costs
}

pub fn section() -> String {
    let mut costs: Vec<_> = baseline_costs().into_iter().map(|(name, cost)| (name.to_owned(), cost)).collect();
    let reference = costs.iter().map(|(_, cost)| cost.best).fold(f64::INFINITY, f64::min);
    for name in ["augmented", "classical", "layers/through-the-skin"] {
        let scenario = scenario(name);
        costs.push((format!("`{name}` without metrics"), bare_ns(&scenario)));
        costs.push((format!("`{name}`"), full_ns(&scenario)));
    }
    for (name, setting) in ESTIMATORS {
        let scenario = scenario_with("classical", &[setting]);
        costs.push((format!("`classical`, {name}"), full_ns(&scenario)));
    }
    let mut table = Table::new(1, &["ns per tick", "best", "median", "best / by hand"]);
    for (name, cost) in costs {
        table.row([name, figure(cost.best), figure(cost.median), figure(cost.best / reference)]);
    }
    let about = format!(
        "From a ready engine to its metrics, one case, one thread. The loop written by hand \
         (`benches/table/handwritten.rs`) implements only the `augmented` experiment, without metrics; its slave \
         position was just checked to agree with the engine's within {TOLERANCE:.0e} of the peak over the whole run. \
         Ratios refer to the faster of its two versions. The last four rows use other estimators than the paper's."
    );
    table.section("A single run beside a loop written by hand", &about)
}
