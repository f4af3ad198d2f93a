//! The laws and gains of the architectures against the equations of `gains`.

use super::four_channel::FourChannel;
use super::local_force::LocalForce;
use super::position_force::PositionForce;
use super::position_position::PositionPosition;
use super::*;
use trocar_core::augmentation::{Mode, Modes};

/// Machines with all numbers different.
const MACHINES: Machines = Machines {
    master_mass_kg: 0.3,
    master_damping_n_s_per_m: 5.0,
    proportional_gain: 1000.0,
    velocity_gain: 16.0,
    slave_drag: 4.0,
    slave_inertia: 0.2,
    compliance_m_per_n: 1e-4,
    position_scale: 0.5,
    force_scale: 3.0,
};

fn settings() -> ControllerSettings {
    let mut settings = ControllerSettings::DEFAULT;
    (settings.coupling.stiffness_n_per_m, settings.coupling.damping_n_s_per_m) = (800.0, 12.0);
    (settings.local_force.master_force_gain, settings.local_force.slave_force_gain) = (6.0, 2.0);
    settings
}

fn gains<A: BuiltInArchitecture<f64>>() -> (MasterGains, SlaveGains) {
    A::gains(&settings(), &MACHINES).expect("valid")
}

#[test]
fn the_gains_are_lawrences_gains_for_the_machines() {
    let (none, still) = (MasterGains::default(), SlaveGains::default());
    assert_eq!(gains::<PositionForce<f64>>(), (MasterGains { force: 1.0, ..none }, still));
    let coupled = MasterGains { position: 2400.0, velocity: 36.0, ..none };
    assert_eq!(gains::<PositionPosition<f64>>(), (coupled, still));
    let load = MasterGains { force: 7.0, hand: 6.0, ..none };
    assert_eq!(gains::<LocalForce<f64>>(), (load, SlaveGains { local_force: 2e-3, ..still }));
    let (master, slave) = gains::<FourChannel<f64>>();
    assert_eq!(master, MasterGains { position: 2400.0, velocity: 36.0, drag: 10.0, inertia: 0.6, ..load });
    assert_eq!(slave.local_force, 2e-3);
    assert!((slave.velocity - 0.5 * 20.0 / 1000.0).abs() < 1e-15, "{slave:?}");
    assert!((slave.acceleration - 0.5 * 0.2 / 1000.0).abs() < 1e-15, "{slave:?}");
    assert!((slave.hand_force - (2e-3 + 1e-4) / 3.0).abs() < 1e-15, "{slave:?}");
}

#[test]
fn a_slave_without_a_proportional_gain_cannot_be_compliant() {
    let machines = Machines { proportional_gain: 0.0, ..MACHINES };
    let error = <LocalForce<f64> as BuiltInArchitecture<f64>>::gains(&settings(), &machines).expect_err("no gain");
    assert_eq!(error.name, "slave.proportional_gain");
}

/// Compares the linear law of the gains with an architecture, at each tick of a motion.
fn compare<A: BuiltInArchitecture<f64>>() {
    let tick_s = 1e-3;
    let mut architecture = A::build(&settings(), &MACHINES, tick_s).expect("valid");
    let (m, s) = gains::<A>();
    let weight = 1.0 - (-std::f64::consts::TAU * settings().four_channel.acceleration_bandwidth_hz * tick_s).exp();
    let (mut a_h, mut a_e, mut last_h, mut last_e) = (0.0, 0.0, 0.0, 0.0);
    for tick in 0..50 {
        let t = tick_s * f64::from(tick);
        let master = AtMaster { position_m: 0.01 + t, velocity_m_per_s: (50.0 * t).sin(), hand_force_n: 2.0 - 7.0 * t };
        let slave = AtSlave { position_m: 0.004 + 0.3 * t, velocity_m_per_s: (40.0 * t).cos(), force_n: 1.0 + 5.0 * t };
        let f_e = MACHINES.force_scale * slave.force_n;
        a_h += weight * ((master.velocity_m_per_s - last_h) / tick_s - a_h);
        a_e += weight * ((slave.velocity_m_per_s - last_e) / tick_s - a_e);
        (last_h, last_e) = (master.velocity_m_per_s, slave.velocity_m_per_s);

        let sent = architecture.master_sends(&master);
        assert_eq!((sent.position_m, sent.velocity_m_per_s), (master.position_m, master.velocity_m_per_s));
        assert_eq!(sent.hand_force_n, master.hand_force_n);
        let target = architecture.slave_target(&sent, &slave);
        let expected = MACHINES.position_scale * master.position_m
            + s.velocity * master.velocity_m_per_s
            + s.acceleration * a_h
            + s.hand_force * master.hand_force_n
            - s.local_force * slave.force_n;
        assert!((target - expected).abs() < 1e-12, "{tick}: {target} instead of {expected}");

        let sample = architecture.slave_sends(&slave, f_e);
        assert_eq!((sample.force_n, sample.position_m), (f_e, slave.position_m));
        assert_eq!(sample.velocity_m_per_s, slave.velocity_m_per_s);
        // A scheme may replace the sample's force.
        let arrived = ArrivedAtMaster { sample, force_n: f_e + 0.5, mode: Modes::splat(Mode::Teleoperation) };
        let force = architecture.master_force(&arrived, &master);
        let expected = m.force * (f_e + 0.5) - m.hand * master.hand_force_n
            + m.position * (MACHINES.position_scale * master.position_m - slave.position_m)
            + m.velocity * (MACHINES.position_scale * master.velocity_m_per_s - slave.velocity_m_per_s)
            - m.drag * slave.velocity_m_per_s
            - m.inertia * a_e;
        assert!((force - expected).abs() < 1e-9 * expected.abs().max(1.0), "{tick}: {force} instead of {expected}");
    }
}

#[test]
fn each_architecture_equals_the_linear_law_of_its_gains() {
    compare::<PositionForce<f64>>();
    compare::<PositionPosition<f64>>();
    compare::<LocalForce<f64>>();
    compare::<FourChannel<f64>>();
}

#[test]
fn all_but_position_force_hold_their_force_while_the_slave_is_frozen() {
    fn changes<A: BuiltInArchitecture<f64>>() -> f64 {
        let mut architecture = A::build(&settings(), &MACHINES, 1e-3).expect("valid");
        let mut at = |mode, position_m: f64, force_n: f64| {
            let master = AtMaster { position_m, velocity_m_per_s: 0.0, hand_force_n: position_m };
            let sample = SlaveSample { force_n, position_m: 0.0, velocity_m_per_s: 0.0, acceleration_m_per_s2: 0.0 };
            architecture.master_force(&ArrivedAtMaster { sample, force_n, mode: Modes::splat(mode) }, &master)
        };
        let before = at(Mode::Teleoperation, 0.01, 4.0);
        at(Mode::Augmented, 0.05, 3.0) - before
    }
    assert_eq!([changes::<PositionPosition<f64>>(), changes::<LocalForce<f64>>()], [-1.0; 2]);
    assert!((changes::<FourChannel<f64>>() + 1.0).abs() < 1e-12);
}

#[test]
fn energies_are_scaled_by_the_ratio_of_force_to_position_scale() {
    assert_eq!(MACHINES.energy_scale(), 6.0);
    assert_eq!(Machines { position_scale: 0.0, ..MACHINES }.energy_scale(), 1.0, "an open loop");
}
