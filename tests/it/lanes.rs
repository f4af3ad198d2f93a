//! Two scenarios in lanes are identical, bit for bit, to single runs, with every kind of link and every estimator.

use crate::support::pair::Pair;
use trocar::engine::{Observer, Signals};
use trocar::lane::{Lane, Mask};
use trocar::scenario::{Scenario, Source};

#[derive(Default)]
struct Seen(Vec<Vec<u64>>);

impl Seen {
    fn tick<L: Lane>(s: &Signals<L>, lane: usize) -> Vec<u64> {
        let numbers = [
            s.master_position_m,
            s.operator_force_n,
            s.slave_reference_m,
            s.slave_position_m,
            s.measured_force_n,
            s.feedback_force_n,
            s.residual_n,
            s.extra_parameter,
            s.decision,
            s.mode.codes(),
            s.allowed_force_step_n,
        ];
        let masks = [s.ruptured, s.alarm, s.alarm_taken].map(|mask| u64::from(mask.lane(lane)));
        numbers.iter().map(|number| number.lane(lane).to_bits()).chain(masks).collect()
    }
}

impl Observer<f64> for Seen {
    fn observe(&mut self, s: &Signals<f64>) {
        self.0.push(Self::tick(s, 0));
    }
}

#[derive(Default)]
struct Both([Seen; 2]);

impl Observer<Pair> for Both {
    fn observe(&mut self, s: &Signals<Pair>) {
        for (lane, seen) in self.0.iter_mut().enumerate() {
            seen.0.push(Seen::tick(s, lane));
        }
    }
}

#[test]
fn a_lane_gives_the_same_bits_as_a_single_run() {
    let late = ["channel.forward_delay_s=0.012", "channel.backward_delay_s=0.007"];
    let rough = ["channel.jitter_s=0.004", "channel.loss=0.3", "channel.outage_s=0.004"];
    for settings in [
        &[][..],
        &["controller.kind=local-force"],
        &["controller.kind=position-position", "slave.compliance_m_per_n=7.7e-4"],
        &["controller.kind=four-channel", "controller.slave_force_gain=0.5"],
        &["estimator.parameters=stiffness-damping-friction", "detector.motion=inserting"],
        &["estimator.parameters=hunt-crossley", "detector.minimum_depth_m=0.01"],
        &["estimator.parameters=least-residual", "estimator.forgetting=exponential"],
        &["estimator.forgetting=exponential", "estimator.forgetting_factor=0.99"],
        &[late[0], late[1], rough[0], rough[1], rough[2]],
        &[late[0], late[1], rough[0], rough[1], rough[2], "channel.recovery=hold"],
        &[late[0], late[1], rough[0], rough[1], "channel.outage_s=0.009", "channel.recovery=give-up"],
        &[late[0], rough[0], rough[1], "passivity.scheme=time-domain", "passivity.budget_j=1e-4"],
        &[late[0], late[1], rough[1], "passivity.scheme=wave-variables"],
        &[late[0], late[1], rough[1], "passivity.scheme=energy-tank", "passivity.tank_level_j=1e-3"],
    ] {
        let settings: Vec<String> = settings.iter().map(|&setting| setting.to_owned()).collect();
        let source = Source::parse("builtin:hand/reflex-augmented.toml");
        let scenario = Scenario::load(&source, &settings).expect("loads");
        let mut both = Both::default();
        scenario.exact_engine::<Pair>(5).expect("builds").run(&mut both).expect("runs");
        for (lane, seen) in both.0.iter().enumerate() {
            let mut single = Seen::default();
            scenario.exact_engine::<f64>(5 + lane as u64).expect("builds").run(&mut single).expect("runs");
            assert!(single.0.len() > 1000);
            let differs = single.0.iter().zip(&seen.0).position(|(a, b)| a != b);
            assert_eq!(differs, None, "{settings:?}, lane {lane}");
        }
        assert_ne!(both.0[0].0, both.0[1].0, "the lanes have noise of their own");
    }
}
