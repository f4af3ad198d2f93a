//! The promise of the schemes, at any delay, for any hand and tissue.

use proptest::prelude::*;

use super::super::{AtMaster, AtSlave, Connection as _};
use super::super::{
    ControllerSettings, Lines, Link, LinkSettings, Machines, PassivitySettings, RecoverySettings, Scheme,
};
use crate::channel::{Delay, Irregularity, Schedule};
use crate::engine::{ExactPlants, Plants as _, TissueForce};
use crate::plant::{ArmParameters, ControlTiming, MasterParameters, MasterStep, SlaveParameters, SlaveStep};
use trocar_core::augmentation::{Mode, Modes};

const TICK_S: f64 = 1e-3;

/// A run of a hand that jumps between positions, against a spring with friction and an intermittent pushing force.
struct Run {
    scheme: Scheme,
    delays: [u64; 2],
    loss: f64,
    stiffness_n_per_m: f64,
    friction_n: f64,
    hand_m: Vec<f64>,
    scales: [f64; 2],
}

/// Stiffness of the friction while it sticks, in N/m. A scheme's promise holds for tissues up to a stiffness, including
/// friction.
const BRISTLE_N_PER_M: f64 = 1e3;

/// The largest generated energy (J), and the promised bound (J).
fn run(run: &Run) -> (f64, Option<f64>) {
    let slave = SlaveParameters::default();
    let step = SlaveStep::new(&slave, ControlTiming::Continuous, TICK_S).expect("valid");
    let (master, arm) = (MasterParameters::default(), ArmParameters::default());
    let master_step = MasterStep::new(&master, &arm, ControlTiming::Continuous, TICK_S).expect("valid");
    let [position_scale, force_scale] = run.scales;
    let machines = Machines {
        master_mass_kg: master.mass_kg,
        master_damping_n_s_per_m: master.damping_n_s_per_m,
        proportional_gain: slave.proportional_gain,
        velocity_gain: slave.velocity_gain,
        slave_drag: 0.0,
        slave_inertia: 0.0,
        compliance_m_per_n: 0.0,
        position_scale,
        force_scale,
    };
    let settings = LinkSettings {
        controller: ControllerSettings::DEFAULT,
        machines,
        recovery: RecoverySettings::DEFAULT,
        passivity: PassivitySettings { scheme: run.scheme, ..PassivitySettings::DEFAULT },
    };
    fn line<const N: usize>(ticks: u64, loss: f64, stream: u64) -> Delay<f64, N> {
        let irregularity = Irregularity { jitter_s: 0.0, loss };
        Delay::new(ticks, [0.0; N]).irregular(&irregularity, &Schedule::default(), TICK_S, [0.0; N], (7, stream))
    }
    let lines = Lines {
        forward: line(run.delays[0], run.loss, 0),
        backward: line(run.delays[1], run.loss, 1),
        forward_payload: line(run.delays[0], run.loss, 0),
        backward_payload: line(run.delays[1], run.loss, 1),
    };
    let mut link = Link::<f64>::new(&settings, lines, &step, TICK_S, 0.0).expect("valid");
    let mut plants = ExactPlants::<f64>::new(&master_step, &step, 0.0, 0.0);
    let (mut desired, mut bristle_m, mut before_m) = (0.0, 0.0, 0.0);
    for tick in 0..2000_usize {
        let (m, s) = (plants.master(), plants.slave());
        let push_n = if tick % 400 > 350 { -1.0 } else { 0.0 };
        let spring_n = run.stiffness_n_per_m * (s.position_m - 0.002).max(0.0);
        bristle_m += s.position_m - before_m;
        bristle_m = bristle_m.clamp(-run.friction_n / BRISTLE_N_PER_M, run.friction_n / BRISTLE_N_PER_M);
        before_m = s.position_m;
        let force_n = spring_n + push_n + BRISTLE_N_PER_M * bristle_m;
        let at_master =
            AtMaster { position_m: m.position_m, velocity_m_per_s: m.velocity_m_per_s, hand_force_n: m.hand_force_n };
        let at_slave = AtSlave { position_m: s.position_m, velocity_m_per_s: s.velocity_m_per_s, force_n };
        let target = link.to_slave(&at_master, &at_slave);
        let reference = link.limit_reference(target, &at_slave);
        let (_, feedback) = link.to_master(Modes::splat(Mode::Teleoperation), &at_slave, &at_master);
        let feedback = link.limit(feedback, &at_master);
        let aim = run.hand_m[tick * run.hand_m.len() / 2000];
        let next = desired + ((aim - desired) * 0.02).clamp(-1e-4, 1e-4);
        plants.step(desired, next, feedback, reference, 0.0, TissueForce::zero()).expect("a step");
        desired = next;
    }
    let report = link.report(0).expect("the link has a scheme");
    assert!(report.slave_refused_j.is_finite() && report.master_dissipated_j.is_finite());
    (report.generated_j, report.promised_j)
}

const SCHEMES: [Scheme; 3] = [Scheme::TimeDomain, Scheme::WaveVariables, Scheme::EnergyTank];

proptest! {
    #![proptest_config(ProptestConfig { cases: 100, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_scheme_generates_more_energy_than_it_promises(
        scheme in 0..3_usize,
        delays in [0..60_u64, 0..60_u64],
        loss in prop_oneof![Just(0.0), 0.0..0.5f64],
        stiffness_n_per_m in 0.0..19e3f64,
        friction_n in 0.0..2.0f64,
        hand_m in prop::collection::vec(-0.01..0.03f64, 4..12),
        scales in [0.3..2.0f64, 0.3..3.0f64],
    ) {
        let scheme = SCHEMES[scheme];
        let (generated_j, promised_j) =
            run(&Run { scheme, delays, loss, stiffness_n_per_m, friction_n, hand_m, scales });
        let promised_j = promised_j.expect("a promise");
        prop_assert!(generated_j <= promised_j + 1e-9, "{:?}: {} of {}", scheme, generated_j, promised_j);
    }
}

#[test]
fn without_a_scheme_a_stiff_contact_over_a_delay_exceeds_every_promise() {
    // The property above is meaningful only if these runs are not passive without a scheme.
    let (generated_j, promised_j) = run(&Run {
        scheme: Scheme::None,
        delays: [50, 50],
        loss: 0.0,
        stiffness_n_per_m: 5e3,
        friction_n: 0.0,
        hand_m: vec![0.01, -0.005],
        scales: [1.0, 1.0],
    });
    assert!(promised_j.is_none() && generated_j > 0.05, "{generated_j}");
}

#[test]
fn the_slave_stays_behind_the_hand_by_the_predicted_yielding() {
    use super::{Arrived, PAYLOAD, PassivityScheme as _, SchemeContext, SlavePort};
    let context = SchemeContext::<f64>::for_tests();
    let settings = |scheme| PassivitySettings { scheme, ..PassivitySettings::DEFAULT };
    let port = SlavePort { force_n: 7.0, cost_j_per_m: 7.0, work_j: 0.0, position_m: 0.0, velocity_m_per_s: 0.0 };
    // The hand feels nothing yet.
    let arrived = Arrived { payload: [0.0; PAYLOAD], is_fresh: true };
    for scheme in [Scheme::TimeDomain, Scheme::EnergyTank] {
        let mut scheme = super::super::AnyScheme::new(&settings(scheme), &context);
        let mut position = 0.0;
        for _ in 0..2000 {
            position = scheme.receive_position(0.03, &arrived, &port);
        }
        // 7 N on a hand of 700 N/m.
        assert!((position - 0.02).abs() < 1e-9, "{position}");
    }
}
