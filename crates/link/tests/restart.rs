//! A side that was killed is started anew and joins the other side: without a jump, in a new session.

mod support;

use support::greeted;
use trocar_link::{Calling, Key, MasterEnd, PACKET_BYTES, Rejoin, Role, SlaveEnd, Waiting, fingerprint};
use trocar_scenario::Scenario;

const SCHEMES: [&str; 4] = ["none", "time-domain", "wave-variables", "energy-tank"];

/// Differences of commands are rounded.
const ROUNDING: f64 = 1.0 + 1e-9;

/// Duration from the death to the restart, in ticks: longer than three outages.
const DEAD_TICKS: u64 = 900;

fn scenario(scheme: &str) -> Scenario {
    support::scenario(&[&format!("passivity.scheme={scheme}")])
}

/// Replaces a side at a tick and returns the other side's new session by its greeting.
fn restart(scenario: &Scenario, dead: Role, ends: &mut (MasterEnd, SlaveEnd), tick: u64, now_ns: i64) {
    let (key, hash) = (Key::of_loopback(), fingerprint(scenario));
    match dead {
        Role::Master => {
            let mut slave = Rejoin::new(Role::Slave, key.clone(), [4; 16], hash, 0);
            let mut master = Calling::new(key, [3; 16], hash);
            master.take(&slave.take(&master.hello(now_ns), now_ns).answer.expect("a reply"), now_ns);
            let start = master.start(now_ns, master.begun_ns().expect("it runs")).expect("a slave");
            let heard = slave.take(&start, now_ns);
            ends.1.rejoin(heard.session.expect("a session"));
            master.take(&heard.answer.expect("ready"), now_ns);
            let session = master.greeted(0).expect("ready").session;
            ends.0 = MasterEnd::new(scenario, session).expect("builds");
            ends.0.skip_to(tick).expect("computes");
        }
        Role::Slave => {
            let mut master = Rejoin::new(Role::Master, key.clone(), [4; 16], hash, 0);
            let mut slave = Waiting::new(key, [3; 16], hash);
            let mut session = None;
            for call in 0..20 {
                let now_ns = now_ns + call * 20_000_000;
                let answer = master.call(now_ns).and_then(|packet| slave.take(&packet, now_ns));
                session = session.or_else(|| answer.and_then(|answer| master.take(&answer, now_ns).session));
            }
            ends.0.rejoin(session.expect("a session"));
            ends.1 = SlaveEnd::new(scenario, slave.greeted().expect("started").session.clone()).expect("builds");
            ends.1.skip_to(tick).expect("computes");
        }
    }
}

/// Runs both ends. A side dies at a tick and is started anew later. From then on, `again` is given to both ends before
/// each tick: the packets of the first session, if it is true.
fn run(scenario: &Scenario, dead: Role, death: u64, again: bool) -> (MasterEnd, SlaveEnd) {
    let (of_master, of_slave) = greeted(scenario);
    let mut ends = (
        MasterEnd::new(scenario, of_master.session).expect("builds"),
        SlaveEnd::new(scenario, of_slave.session).expect("builds"),
    );
    let mut first: Vec<[u8; PACKET_BYTES]> = vec![];
    for tick in 0..scenario.grid.ticks() {
        let now_ns = (tick as f64 * scenario.grid.tick_s() * 1e9).round() as i64;
        let is_dead = (death..death + DEAD_TICKS).contains(&tick);
        if tick == death + DEAD_TICKS {
            restart(scenario, dead, &mut ends, tick, now_ns);
        }
        if again && tick >= death + DEAD_TICKS {
            for packet in first.iter().rev().take(20) {
                assert!(ends.0.take(packet, now_ns).is_none() && ends.1.take(packet, now_ns).is_none());
            }
        }
        let mut sent = vec![];
        if !(is_dead && dead == Role::Master) {
            let packet = ends.0.send(now_ns);
            sent.push(packet);
            ends.1.take(&packet, now_ns);
        }
        if !(is_dead && dead == Role::Slave) {
            let packet = ends.1.step(now_ns).expect("steps");
            sent.push(packet);
            ends.0.take(&packet, now_ns);
        }
        if !(is_dead && dead == Role::Master) {
            ends.0.step().expect("steps");
        }
        if tick < death {
            first.extend(sent);
        }
    }
    assert!(ends.0.has_ended() && ends.1.has_ended());
    ends
}

fn largest_step(values: &[f64]) -> f64 {
    values.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max)
}

#[test]
fn a_side_joins_without_a_jump_of_force_or_reference() {
    for (scheme, dead) in SCHEMES.into_iter().flat_map(|scheme| [(scheme, Role::Master), (scheme, Role::Slave)]) {
        let scenario = scenario(scheme);
        let (safety, recovery) = (&scenario.safety, &scenario.link.recovery);
        let tick_s = scenario.grid.tick_s();
        for death in [300, 900, 1500] {
            let (master, slave) = run(&scenario, dead, death, false);
            let back = (death + DEAD_TICKS) as usize;
            let (force_n, reference_m) = (&master.trace().feedback_force_n, &slave.trace().slave_reference_m);
            let case = format!("{scheme}, the {} at tick {death}", dead.word());
            // The last tick before the return is that of the first step.
            let step_m = largest_step(&reference_m[back - 1..]);
            assert!(step_m <= safety.reference_speed_m_per_s * tick_s * ROUNDING, "{case}: {step_m} m in a tick");
            let step_n = largest_step(&force_n[back - 1..]);
            assert!(step_n <= safety.force_rate_n_per_s * tick_s * ROUNDING, "{case}: {step_n} N in a tick");
            // At the return itself the recovery bounds the reference, and the force if no scheme damps the hand.
            let step_m = (reference_m[back] - reference_m[back - 1]).abs();
            assert!(step_m <= recovery.speed_m_per_s * tick_s * ROUNDING, "{case}: {step_m} m");
            let step_n = (force_n[back] - force_n[back - 1]).abs();
            let limit_n = recovery.force_rate_n_per_s * tick_s * ROUNDING;
            assert!(step_n <= limit_n || scheme != "none", "{case}: {step_n} N");
        }
    }
}

#[test]
fn the_run_continues_with_the_new_side() {
    for (scheme, dead) in SCHEMES.into_iter().flat_map(|scheme| [(scheme, Role::Master), (scheme, Role::Slave)]) {
        let scenario = scenario(scheme);
        let (master, slave) = run(&scenario, dead, 900, false);
        let (hand_m, needle_m) = (&master.trace().master_position_m, &slave.trace().slave_position_m);
        let gap_m = |tick: usize| (hand_m[tick] - needle_m[tick]).abs();
        let last = hand_m.len() - 1;
        assert!(gap_m(1800) > 4e-3, "{scheme} {dead:?}: {} m", gap_m(1800));
        // A scheme may keep the needle behind: it limits the advance by the energy from the hand.
        let limit_m = if scheme == "none" { 2e-3 } else { f64::INFINITY };
        assert!(gap_m(last) < limit_m, "{scheme} {dead:?}: {} m", gap_m(last));
        let advance_m = needle_m[last] - needle_m[1800];
        assert!(advance_m > 5e-3, "{scheme} {dead:?}: {advance_m} m");
        let felt_n = master.trace().feedback_force_n[2500..].iter().fold(0.0_f64, |most, force| most.max(force.abs()));
        assert!(felt_n > 0.3, "{scheme} {dead:?}: {felt_n} N");
        for meter in [master.meter(), slave.meter()] {
            assert!(
                meter.promised_j.is_none_or(|limit_j| meter.generated_j <= limit_j),
                "{scheme} {dead:?}: {meter:?}"
            );
        }
        let (survivor, new) = match dead {
            Role::Master => (slave.meter(), master.meter()),
            Role::Slave => (master.meter(), slave.meter()),
        };
        assert_eq!(survivor.promised_j, new.promised_j.map(|promised_j| 1.5 * promised_j));
    }
}

#[test]
fn packets_of_the_first_session_change_nothing_after_a_restart() {
    let scenario = scenario("time-domain");
    for dead in [Role::Master, Role::Slave] {
        let (plain, disturbed) = (run(&scenario, dead, 900, false), run(&scenario, dead, 900, true));
        assert_eq!(plain.0.trace().columns().len(), disturbed.0.trace().columns().len());
        assert_eq!(format!("{:?}", plain.0.trace()), format!("{:?}", disturbed.0.trace()), "{dead:?}");
        assert_eq!(format!("{:?}", plain.1.trace()), format!("{:?}", disturbed.1.trace()), "{dead:?}");
        let (plain, disturbed) =
            ([plain.0.counters(), plain.1.counters()], [disturbed.0.counters(), disturbed.1.counters()]);
        for (plain, disturbed) in plain.iter().zip(disturbed) {
            assert_eq!(disturbed.foreign - plain.foreign, 20 * (5000 - 1800), "{dead:?}");
            assert_eq!((plain.received, plain.replayed), (disturbed.received, disturbed.replayed));
        }
    }
}
