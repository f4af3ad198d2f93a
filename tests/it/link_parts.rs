//! The parts of the link: the direct link equals the full one, and user-defined parts equal built-in ones.

use crate::support::scenario;
use proptest::prelude::*;
use trocar::augmentation::{Mode, Modes};
use trocar::teleoperation::{
    Architecture, Arrived, ArrivedAtMaster, AtMaster, AtSlave, Connection, DirectLink, Link, MasterSample,
    PassivityScheme, Payload, SlavePort,
};

/// Returns the link of an insertion from 0 m, with ticks of 1 ms and these settings.
fn link(settings: &[&str]) -> Link<f64> {
    let base = ["operator.kind=ramp", "tissue.kind=kelvin-voigt", "simulation.duration_s=1"];
    let scenario = scenario("paper/classical", &[&base[..], settings].concat());
    scenario.general_engine(0).expect("builds").parts.link
}

const MODES: [Mode; 3] = [Mode::Teleoperation, Mode::Augmented, Mode::Reengaging];

/// Returns the results of a tick: the arriving mode, and the target of the reference, the arriving force, the
/// feedback force, and the reference with the tissue force.
fn tick(link: &mut impl Connection<f64>, mode: Mode, master: &AtMaster<f64>, slave: &AtSlave<f64>) -> (Mode, [u64; 4]) {
    let commanded_m = link.to_slave(master, slave);
    let target_m = link.limit_reference(commanded_m, slave);
    let (arrived_mode, force_n) = link.to_master(Modes::splat(mode), slave, master);
    let fed_back_n = link.limit(force_n, master);
    let reference_m = target_m - link.deflection_m(slave.force_n);
    (arrived_mode.lane(0), [target_m, force_n, fed_back_n, reference_m].map(f64::to_bits))
}

/// Compares two links over ten thousand ticks of an oscillating hand and a needle that follows or is frozen at times.
fn compare(mut one: impl Connection<f64>, mut other: impl Connection<f64>) {
    for k in 0..10_000 {
        let t = 1e-3 * f64::from(k);
        let master = AtMaster {
            position_m: 0.02 * (1.3 * t).sin(),
            velocity_m_per_s: 0.026 * (1.3 * t).cos(),
            hand_force_n: 2.0 * (0.7 * t).sin(),
        };
        let slave = AtSlave {
            position_m: 0.02 * (1.3 * t - 0.02).sin(),
            velocity_m_per_s: 0.026 * (1.3 * t - 0.02).cos(),
            force_n: 3.0 * (2.1 * t).sin().abs(),
        };
        let mode = MODES[(k / 700) as usize % 3];
        assert_eq!(tick(&mut one, mode, &master, &slave), tick(&mut other, mode, &master, &slave), "tick {k}");
    }
    assert_eq!(one.report(0), other.report(0));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn the_direct_link_is_identical_to_the_full_one_bit_for_bit(
        scales in (-3.0..3.0f64, -5.0..5.0f64), policy in prop::sample::select(vec!["ramp", "hold", "give-up"]),
        ticks in prop::collection::vec((-0.1..0.1f64, -1.0..1.0f64, -20.0..20.0f64, 0..3_usize), 1..200),
    ) {
        let (position, force) = (scales.0.exp(), scales.1.exp());
        let settings = [
            format!("scaling.position={position}"), format!("scaling.force={force}"), format!("channel.recovery={policy}"),
        ];
        let mut full = link(&settings.each_ref().map(String::as_str));
        prop_assert!(full.is_direct() && full.report(0).is_none());
        let (mut direct, mut built) = (full.as_direct().expect("direct"), DirectLink::new(position, force));
        for (x, v, f, mode) in ticks {
            let master = AtMaster { position_m: x, velocity_m_per_s: v, hand_force_n: -f };
            let slave = AtSlave { position_m: 0.9 * x, velocity_m_per_s: -v, force_n: f };
            let expected = tick(&mut full, MODES[mode], &master, &slave);
            prop_assert_eq!(tick(&mut direct, MODES[mode], &master, &slave), expected);
            prop_assert_eq!(tick(&mut built, MODES[mode], &master, &slave), expected);
        }
        prop_assert_eq!(direct.report(0), None);
    }
}

#[test]
fn a_link_with_any_effect_is_not_direct() {
    for setting in [
        "controller.kind=local-force",
        "controller.kind=position-position",
        "controller.kind=four-channel",
        "passivity.scheme=time-domain",
        "passivity.scheme=energy-tank",
        "passivity.scheme=wave-variables",
        "slave.compliance_m_per_n=1e-3",
        "channel.forward_delay_s=0.001",
        "channel.loss=0.1",
    ] {
        let link = link(&[setting]);
        assert!(!link.is_direct() && link.as_direct().is_none() && link.report(0).is_some(), "{setting}");
    }
    // The effect of a user-defined part is unknown.
    assert!(!link(&[]).with_scheme(Nothing).is_direct());
}

/// A scheme without effect.
struct Nothing;

impl PassivityScheme<f64> for Nothing {}

/// A scheme that carries the tissue force in its payload.
struct UserDefinedForce {
    force_n: f64,
}

impl PassivityScheme<f64> for UserDefinedForce {
    fn receive_position(&mut self, position_m: f64, _arrived: &Arrived<f64>, port: &SlavePort<f64>) -> f64 {
        self.force_n = port.force_n;
        position_m
    }

    fn slave_sends(&mut self) -> Payload<f64> {
        [self.force_n, 0.0, 0.0, 0.0]
    }

    fn receive_force(&mut self, _force_n: f64, arrived: &Arrived<f64>, _velocity_m_per_s: f64) -> f64 {
        arrived.payload[0]
    }
}

/// A separate implementation of a spring and a damper between master and slave.
struct UserDefinedSpring {
    stiffness: f64,
    damping: f64,
    /// The total force and the tissue force at the last tick at which the slave was not frozen.
    unfrozen: (f64, f64),
}

impl Architecture<f64> for UserDefinedSpring {
    fn slave_target(&mut self, arrived: &MasterSample<f64>, _slave: &AtSlave<f64>) -> f64 {
        arrived.position_m
    }

    fn master_force(&mut self, arrived: &ArrivedAtMaster<f64>, master: &AtMaster<f64>) -> f64 {
        let slave = &arrived.sample;
        if arrived.mode.is_augmented() {
            return self.unfrozen.0 + (slave.force_n - self.unfrozen.1);
        }
        let force_n = self.stiffness * (master.position_m - slave.position_m)
            + self.damping * (master.velocity_m_per_s - slave.velocity_m_per_s);
        self.unfrozen = (force_n, slave.force_n);
        force_n
    }
}

const LATE: [&str; 3] = ["channel.forward_delay_s=0.003", "channel.backward_delay_s=0.005", "channel.loss=0.1"];

#[test]
fn a_boxed_scheme_that_carries_the_force_is_identical_to_the_plain_link_bit_for_bit() {
    let scheme: Box<dyn PassivityScheme<f64> + Send> = Box::new(UserDefinedForce { force_n: 0.0 });
    compare(link(&LATE).with_scheme(scheme), link(&LATE));
}

#[test]
fn a_boxed_copy_of_an_architecture_is_identical_to_the_built_in_one_bit_for_bit() {
    let architecture: Box<dyn Architecture<f64> + Send> =
        Box::new(UserDefinedSpring { stiffness: 1000.0, damping: 10.0, unfrozen: (0.0, 0.0) });
    let built_in = link(&[&LATE[..], &["controller.kind=position-position"]].concat());
    compare(link(&LATE).with_architecture(architecture), built_in);
}
