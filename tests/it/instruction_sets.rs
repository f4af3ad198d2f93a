//! A run is identical, bit for bit, in the widest instruction set of the machine and in the baseline.

use crate::support::scenario;
use trocar::engine::{Observer, Signals, Trace};
use trocar::metrics::MetricsObserver;
use trocar::scenario::Scenario;

/// The signals that a trace does not contain.
#[derive(Default)]
struct Unrecorded(Vec<[u64; 5]>);

impl Observer<f64> for Unrecorded {
    fn observe(&mut self, s: &Signals<f64>) {
        let masks = [s.ruptured, s.alarm, s.alarm_taken].map(u64::from);
        self.0.push([masks[0], masks[1], masks[2], s.commanded_force_n.to_bits(), s.allowed_force_step_n.to_bits()]);
    }
}

type Seen = (Vec<Vec<u64>>, Vec<[u64; 5]>, String);

fn run(scenario: &Scenario, portably: bool) -> Seen {
    let mut engine = scenario.exact_engine::<f64>(0).expect("builds");
    let metrics = MetricsObserver::<f64>::new(scenario.grid, 4);
    let mut observer = ((Trace::new(scenario.grid), Unrecorded::default()), metrics);
    if portably { engine.run(&mut observer) } else { engine.run_compiled(&mut observer) }.expect("runs");
    let ((trace, unrecorded), metrics) = observer;
    let mut columns: Vec<Vec<u64>> =
        trace.numbers().iter().map(|column| column.iter().map(|value| value.to_bits()).collect()).collect();
    columns.push(trace.mode.iter().map(|&mode| u64::from(mode)).collect());
    // The text has the shortest decimal form that reads back to the same value.
    (columns, unrecorded.0, serde_json::to_string(&metrics.metrics(0)).expect("serialises"))
}

#[test]
fn every_signal_and_metric_has_the_same_bits() {
    let noisy = ["sensor.force_noise_std_n=0.01", "sensor.force_resolution_n=0.001", "channel.forward_delay_s=0.003"];
    let layers = [("layers/through-the-skin", &[][..]), ("tearing/firm-phantom", &[])];
    let models = [
        ["estimator.parameters=stiffness-damping-friction", "estimator.forgetting=resetting"],
        ["estimator.parameters=hunt-crossley", "estimator.forgetting=exponential"],
        ["estimator.parameters=least-residual", "estimator.forgetting=exponential"],
    ];
    let models = models.iter().map(|settings| ("layers/through-the-skin", &settings[..]));
    for (name, overrides) in
        [("classical", &[][..]), ("augmented", &[]), ("augmented", &noisy)].into_iter().chain(layers).chain(models)
    {
        let scenario = scenario(name, overrides);
        let (wide, portable) = (run(&scenario, false), run(&scenario, true));
        assert!(!wide.1.is_empty());
        assert!(wide == portable, "{name} {overrides:?}");
    }
}
