//! The link: what each receiver gets, scaled, delayed and limited.

use std::sync::Arc;

use super::*;
use crate::channel::{Delay, Irregularity, Schedule};
use crate::plant::{ControlTiming, SlaveParameters, SlaveStep};
use trocar_core::augmentation::{Mode, Modes};

const MACHINES: Machines = Machines {
    master_mass_kg: 0.3,
    master_damping_n_s_per_m: 5.0,
    proportional_gain: 1000.0,
    velocity_gain: 16.0,
    slave_drag: 4.0,
    slave_inertia: 0.2,
    compliance_m_per_n: 0.0,
    position_scale: 0.5,
    force_scale: 3.0,
};

/// Creates a link of the paper's architecture with delays in ticks.
fn link(change: impl Fn(&mut LinkSettings), [forward, backward]: [u64; 2], outage: std::ops::Range<u64>) -> Link<f64> {
    let mut settings = LinkSettings {
        controller: ControllerSettings::DEFAULT,
        machines: MACHINES,
        recovery: RecoverySettings::DEFAULT,
        passivity: PassivitySettings::DEFAULT,
    };
    change(&mut settings);
    fn line<const N: usize>(ticks: u64, initial: [f64; N], outage: &std::ops::Range<u64>) -> Delay<f64, N> {
        let outages: Arc<[std::ops::Range<u64>]> =
            std::iter::once(outage.clone()).filter(|ticks| !ticks.is_empty()).collect();
        let schedule = Schedule::new(Arc::default(), outages);
        Delay::new(ticks, initial).irregular(&Irregularity::default(), &schedule, 1e-3, initial, (1, 0))
    }
    let lines = Lines {
        forward: line(forward, [0.0; 4], &outage),
        backward: line(backward, [0.0, 0.0, 0.0, 0.0, Modes::splat(Mode::Teleoperation).codes()], &outage),
        forward_payload: line(forward, [0.0; 4], &outage),
        backward_payload: line(backward, [0.0; 4], &outage),
    };
    let slave = SlaveStep::new(&SlaveParameters::default(), ControlTiming::Continuous, 1e-3).expect("valid");
    Link::new(&settings, lines, &slave, 1e-3, 0.0).expect("valid")
}

fn master(tick: u64) -> AtMaster<f64> {
    AtMaster { position_m: 1e-4 * tick as f64, velocity_m_per_s: 0.1, hand_force_n: 2.0 }
}

fn slave(tick: u64) -> AtSlave<f64> {
    AtSlave { position_m: 5e-5 * tick as f64, velocity_m_per_s: 0.05, force_n: 1.0 + 0.1 * tick as f64 }
}

#[test]
fn positions_and_forces_arrive_after_their_delays_scaled_for_the_receiver() {
    let mut link = link(|_| {}, [3, 2], 0..0);
    assert!(!link.is_direct() && link.as_direct().is_none());
    for tick in 0..50 {
        let target = link.to_slave(&master(tick), &slave(tick));
        let mode = if tick < 20 { Modes::splat(Mode::Teleoperation) } else { Modes::splat(Mode::Augmented) };
        let (arrived, force) = link.to_master(mode, &slave(tick), &master(tick));
        link.limit(force, &master(tick));
        let late = |ticks| tick.checked_sub(ticks);
        assert!((target - late(3).map_or(0.0, |sent| 0.5 * 1e-4 * sent as f64)).abs() < 1e-15, "{tick}");
        assert!((force - late(2).map_or(0.0, |sent| 3.0 * (1.0 + 0.1 * sent as f64))).abs() < 1e-12, "{tick}");
        assert_eq!(
            arrived,
            if tick < 22 { Modes::splat(Mode::Teleoperation) } else { Modes::splat(Mode::Augmented) },
            "{tick}"
        );
    }
    assert_eq!((link.position_scale(), link.force_scale()), (0.5, 3.0));
}

#[test]
fn outages_of_both_directions_are_reported() {
    let mut link = link(|_| {}, [0, 0], 100..350);
    for tick in 0..600 {
        link.to_slave(&master(tick), &slave(tick));
        link.to_master(Modes::splat(Mode::Teleoperation), &slave(tick), &master(tick));
    }
    let report = link.report(0).expect("a link with outages");
    assert_eq!((report.outages, report.longest_outage_ticks, report.given_up_tick), (2, 250.0, None));
    let mut link = self::link(|settings| settings.recovery.policy = Recovery::GiveUp, [0, 0], 100..350);
    let mut last = (0.0, 0.0);
    // 33 N at 50 N/s.
    for tick in 0..1000 {
        let target = link.to_slave(&master(tick), &slave(tick));
        last = (target, link.to_master(Modes::splat(Mode::Teleoperation), &slave(tick), &master(tick)).1);
    }
    assert_eq!(link.report(0).expect("a report").given_up_tick, Some(199.0));
    assert_eq!(last.1, 0.0, "the force goes to 0");
    assert!((last.0 - 0.5 * 1e-4 * 99.0).abs() < 1e-12, "the slave stays where it is: {last:?}");
}

#[test]
fn the_part_that_a_scheme_withholds_in_an_outage_stays_withheld() {
    // The scheme has not enough energy for 100 mm against 1 kN, and the link is down meanwhile.
    let mut link = link(|settings| settings.passivity.scheme = Scheme::TimeDomain, [2, 2], 100..2000);
    let mut target = 0.0;
    let still = |position_m: f64, force_n: f64| AtSlave { position_m, velocity_m_per_s: 0.0, force_n };
    let hand = |position_m: f64| AtMaster { position_m, velocity_m_per_s: 0.0, hand_force_n: 0.0 };
    for tick in 0..400 {
        let at_slave = still(0.0, if tick < 90 { 0.0 } else { 1000.0 });
        let at_master = hand(if tick < 90 { 0.0 } else { 0.2 });
        target = link.to_slave(&at_master, &at_slave);
        let reference = link.limit_reference(target, &at_slave);
        let (_, force) = link.to_master(Modes::splat(Mode::Teleoperation), &at_slave, &at_master);
        link.limit(force, &at_master);
        assert!(reference < 0.01, "{tick}: the scheme holds the slave: {reference}");
    }
    assert!(target < 0.01, "it does not go on to where the hand was: {target}");
}

#[test]
fn the_report_contains_both_energies_the_largest_excess_and_the_distance_left_behind() {
    let mut link = link(|_| {}, [1, 1], 0..0);
    let (mut e_m, mut e_s, mut generated, mut held) = (0.0, 0.0, 0.0_f64, 0.0);
    for tick in 0..60 {
        // The needle goes in and returns by a third; the hand returns completely.
        let turn = |tick: u64| if tick < 40 { tick as f64 } else { 80.0 - tick as f64 };
        let (mut m, mut s) = (master(tick), slave(tick));
        m.position_m = 1e-4 * turn(tick);
        s.position_m = 5e-5 * turn(tick).max(30.0 - 29.0 / (1.0 + tick as f64));
        if tick > 0 {
            let mut last = slave(tick - 1);
            last.position_m = 5e-5 * turn(tick - 1).max(30.0 - 29.0 / tick as f64);
            e_m += held * (m.position_m - 1e-4 * turn(tick - 1));
            e_s += 0.5 * (s.force_n + last.force_n) * (s.position_m - last.position_m);
        } else {
            e_s += 0.5 * s.force_n * s.position_m;
        }
        generated = generated.max(6.0 * e_s - e_m);
        link.to_slave(&m, &s);
        link.limit_reference(0.0, &s);
        let (_, force) = link.to_master(Modes::splat(Mode::Teleoperation), &s, &m);
        held = link.limit(force, &m);
    }
    let report = link.report(0).expect("a delayed link");
    assert!((report.master_port_j - e_m).abs() < 1e-12 && (link.master_energy_j() - e_m).abs() < 1e-12, "{report:?}");
    assert!((report.slave_port_j - e_s).abs() < 1e-12 && (link.slave_energy_j() - 6.0 * e_s).abs() < 1e-12);
    assert!((report.generated_j - generated).abs() < 1e-12 && generated > 0.0, "{report:?} {generated}");
    // At tick 59 both have moved: 21 steps of 0.1 mm, halved, against the needle.
    let needle = 5e-5 * 21.0_f64.max(30.0 - 29.0 / 60.0);
    assert!((report.left_behind_m - (needle - 0.5 * 1e-4 * 21.0)).abs() < 1e-12, "{report:?}");
    assert_eq!((report.outages, report.longest_outage_ticks, report.given_up_tick), (0, 0.0, None));
    assert_eq!((report.promised_j, report.master_dissipated_j, report.slave_refused_j), (None, 0.0, 0.0));
}

#[test]
fn only_the_papers_link_is_the_baseline() {
    let paper = LinkSettings {
        controller: ControllerSettings::DEFAULT,
        machines: MACHINES,
        recovery: RecoverySettings::DEFAULT,
        passivity: PassivitySettings::DEFAULT,
    };
    assert!(paper.is_baseline());
    let [mut local, mut scheme, mut compliant] = [paper; 3];
    local.controller.kind = ControllerKind::LocalForce;
    scheme.passivity.scheme = Scheme::TimeDomain;
    compliant.machines.compliance_m_per_n = 1e-4;
    assert_eq!([local, scheme, compliant].map(|settings| settings.is_baseline()), [false; 3]);
}
