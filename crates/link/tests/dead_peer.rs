//! When the other side of a link dies, the force decays and the reference stays with the last received hand.

mod support;

use support::{greeted, scenario};
use trocar_link::{MasterEnd, PACKET_BYTES, SlaveEnd};
use trocar_scenario::Scenario;

/// Number of times at which a side dies.
const DEATHS: u64 = 20;

/// Runs both ends; packets to the master are lost in the ticks of the first range, and those to the slave in the ticks
/// of the second.
fn run(scenario: &Scenario, lost: [std::ops::Range<u64>; 2]) -> (MasterEnd, SlaveEnd) {
    let (of_master, of_slave) = greeted(scenario);
    let mut master = MasterEnd::new(scenario, of_master.session).expect("builds");
    let mut slave = SlaveEnd::new(scenario, of_slave.session).expect("builds");
    for tick in 0..scenario.grid.ticks() {
        let now_ns = (tick as f64 * scenario.grid.tick_s() * 1e9).round() as i64;
        let packet: [u8; PACKET_BYTES] = master.send(now_ns);
        if !lost[1].contains(&tick) {
            slave.take(&packet, now_ns);
        }
        let packet = slave.step(now_ns).expect("steps");
        if !lost[0].contains(&tick) {
            master.take(&packet, now_ns);
        }
        master.step().expect("steps");
    }
    (master, slave)
}

/// The times of death in ticks: before, at and after the ruptures, and during events.
fn deaths() -> impl Iterator<Item = u64> {
    (0..DEATHS).map(|count| 700 + 130 * count)
}

#[test]
fn the_force_of_a_dead_slave_decays_within_the_stated_time() {
    let scenario = scenario(&[]);
    let recovery = &scenario.link.recovery;
    assert_eq!((recovery.outage_s, recovery.dead_s, recovery.dead_decay_s), (0.1, 1.0, 0.2));
    let mut decayed = 0;
    for death in deaths() {
        let (master, _) = run(&scenario, [death..u64::MAX, 0..0]);
        let force_n = &master.trace().feedback_force_n;
        // A cross-fade that is under way ends by itself, at the received force.
        let felt_n = force_n[death as usize - 1..].iter().fold(0.0_f64, |largest, force| largest.max(force.abs()));
        // 1.2 s, of which the last 5 % of the decay take 10 ms.
        let end = death as usize + 1200;
        if end >= force_n.len() {
            continue;
        }
        assert!(force_n[end - 10..].iter().all(|force| force.abs() <= 0.051 * felt_n), "{death}: {felt_n} N");
        assert_eq!(force_n[end + 1], 0.0, "{death}");
        decayed += 1;
    }
    assert_eq!(decayed, DEATHS);
}

#[test]
fn the_reference_of_a_slave_whose_master_is_dead_ends_at_the_last_received_hand() {
    let scenario = scenario(&[]);
    for death in deaths() {
        let (master, slave) = run(&scenario, [0..0, death..u64::MAX]);
        let reference_m = &slave.trace().slave_reference_m;
        let hand_m = master.trace().master_position_m[death as usize - 1];
        // An event that is under way ends by itself, at most 1.5 s later.
        let end = death as usize + 2000;
        if end < reference_m.len() {
            assert!(
                reference_m[end..].iter().all(|x| (x - hand_m).abs() < 1e-9),
                "{death}: {} {hand_m}",
                reference_m[end]
            );
        }
        let fastest = reference_m[death as usize + 1..].windows(2).map(|pair| (pair[1] - pair[0]).abs());
        let fastest = fastest.fold(0.0, f64::max);
        assert!(fastest < 1e-3, "{death}: {fastest}");
    }
}

#[test]
fn a_slave_that_comes_back_is_felt_again_without_a_jump() {
    let scenario = scenario(&[]);
    let (master, _) = run(&scenario, [1000..2600, 0..0]);
    let (undisturbed, _) = run(&scenario, [0..0, 0..0]);
    let force_n = &master.trace().feedback_force_n;
    assert_eq!(force_n[2500], 0.0);
    let largest_step_n = force_n[2600..2900].windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max);
    assert!(largest_step_n < 0.1, "{largest_step_n} N in a tick");
    let live = force_n[2900..3100].iter().map(|force| force.abs()).fold(0.0, f64::max);
    let expected = undisturbed.trace().feedback_force_n[2900..3100].iter().map(|force| force.abs()).fold(0.0, f64::max);
    assert!(live > 0.1 * expected, "{live} {expected}");
}
