//! Encodes messages as packets and receives packets.

use super::arrivals::{Arrivals, Fate};
use super::counters::Counters;
use super::packet::{BODY_BYTES, Kind, PACKET_BYTES, Packet, Role, word};
use super::seal::Session;
use super::window::Window;
use trocar_engine::teleoperation::{Message, PAYLOAD, Received};

/// Byte offsets in a message's body: the other side's last time stamp and the time since its arrival; then sample,
/// payload and energy of the port.
const ECHO: usize = 0;
const SINCE: usize = 8;
const VALUES: usize = 16;
const NUMBERS: usize = (BODY_BYTES - VALUES) / 8;
const MAX_SAMPLE: usize = NUMBERS - PAYLOAD - 1;

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trip {
    /// By the clocks of both sides, which agree to half the round trip.
    pub one_way_s: f64,
    /// By this side's clock, without the time on the other side.
    pub round_s: Option<f64>,
}

#[derive(Debug)]
pub struct Endpoint<const N: usize> {
    role: Role,
    session: Session,
    number: u64,
    window: Window,
    counters: Counters,
    arrivals: Arrivals<N>,
    echo: Option<(i64, i64)>,
    /// Last reported energy of the other port, and the tick that sent it.
    energy: Option<(u64, f64)>,
    /// Energies of this port and the other one at the other side's last restart; messages count from 0.
    restart_j: (f64, f64),
    last_trip: Option<Trip>,
}

impl<const N: usize> Endpoint<N> {
    /// Until a message arrives, it has the `initial` sample.
    pub fn new(role: Role, session: Session, ticks: u64, initial: [f64; N]) -> Self {
        Self {
            role,
            session,
            number: 0,
            window: Window::default(),
            counters: Counters::default(),
            arrivals: Arrivals::new(ticks, initial),
            echo: None,
            energy: None,
            restart_j: (0.0, 0.0),
            last_trip: None,
        }
    }

    /// Returns the packet of a tick's message, with the energy of this side's port.
    pub fn seal<const M: usize>(
        &mut self,
        (tick, now_ns): (u64, i64),
        message: &Message<f64, M>,
        energy_j: f64,
    ) -> [u8; PACKET_BYTES] {
        const { assert!(M <= MAX_SAMPLE, "a sample fits into a packet") };
        let mut body = [0; BODY_BYTES];
        let (stamp_ns, since_ns) = self.echo.map_or((i64::MIN, 0), |(stamp, came)| (stamp, now_ns - came));
        body[ECHO..ECHO + 8].copy_from_slice(&stamp_ns.to_le_bytes());
        body[SINCE..SINCE + 8].copy_from_slice(&since_ns.to_le_bytes());
        let mut numbers = [0.0; NUMBERS];
        numbers[..M].copy_from_slice(&message.sample);
        numbers[MAX_SAMPLE..MAX_SAMPLE + PAYLOAD].copy_from_slice(&message.payload);
        numbers[NUMBERS - 1] = energy_j - self.restart_j.0;
        for (place, number) in body[VALUES..].chunks_exact_mut(8).zip(numbers) {
            place.copy_from_slice(&number.to_bits().to_le_bytes());
        }
        let packet = Packet { kind: Kind::Message, from: self.role, number: self.number, tick, sent_ns: now_ns, body };
        self.number += 1;
        self.counters.sent += 1;
        self.session.0.seal(&packet)
    }

    /// Continues in another session, with a side that has started anew; earlier packets are then foreign.
    pub fn rejoin(&mut self, session: Session, energy_j: f64) {
        self.session = session;
        (self.number, self.window, self.echo) = (0, Window::default(), None);
        self.restart_j = (energy_j, self.other_energy_j());
        self.arrivals.forget_payload();
    }

    pub fn take(&mut self, bytes: &[u8], now_ns: i64) {
        self.last_trip = None;
        let Some(packet) = Packet::read(bytes) else {
            self.counters.malformed += 1;
            return;
        };
        if packet.from == self.role || !self.session.0.is_authentic(bytes) {
            self.counters.foreign += 1;
            return;
        }
        if packet.kind != Kind::Message {
            // A delayed greeting of this session.
            return;
        }
        let numbers: [f64; NUMBERS] = std::array::from_fn(|i| f64::from_bits(word(&packet.body, VALUES + 8 * i)));
        if !numbers.iter().all(|number| number.is_finite()) {
            self.counters.malformed += 1;
            return;
        }
        if !self.window.accept(packet.number) {
            self.counters.replayed += 1;
            return;
        }
        let message = Message {
            sample: std::array::from_fn(|i| numbers[i]),
            payload: std::array::from_fn(|i| numbers[MAX_SAMPLE + i]),
        };
        match self.arrivals.take(packet.tick, message) {
            Fate::Taken => {}
            Fate::Overtaken => self.counters.overtaken += 1,
            Fate::Repeated => {
                self.counters.replayed += 1;
                return;
            }
            Fate::OutOfRange => {
                self.counters.out_of_range += 1;
                return;
            }
        }
        self.counters.received += 1;
        self.note_times(&packet, now_ns);
        if self.energy.is_none_or(|(tick, _)| tick < packet.tick) {
            self.energy = Some((packet.tick, self.restart_j.1 + numbers[NUMBERS - 1]));
        }
    }

    fn note_times(&mut self, packet: &Packet, now_ns: i64) {
        let seconds = |ns: i64| ns as f64 * 1e-9;
        let (stamp_ns, since_ns) = (word(&packet.body, ECHO).cast_signed(), word(&packet.body, SINCE).cast_signed());
        let round_ns = || now_ns.checked_sub(stamp_ns)?.checked_sub(since_ns);
        self.last_trip = Some(Trip {
            one_way_s: seconds(now_ns.saturating_sub(packet.sent_ns)),
            round_s: if stamp_ns == i64::MIN { None } else { round_ns().map(seconds) },
        });
        self.echo = Some((packet.sent_ns, now_ns));
    }

    pub fn at_next_tick(&mut self) -> Received<f64, N> {
        self.arrivals.at_next_tick()
    }

    pub fn counters(&self) -> Counters {
        self.counters
    }

    pub fn delays(&self) -> &[u32] {
        self.arrivals.delays()
    }

    pub fn last_trip(&self) -> Option<Trip> {
        self.last_trip
    }

    pub fn other_energy_j(&self) -> f64 {
        self.energy.map_or(0.0, |(_, energy_j)| energy_j)
    }
}

#[cfg(test)]
mod tests {
    use rand::{Rng as _, RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::super::seal::{Key, NONCE_BYTES};
    use super::*;

    const TICKS: u64 = 2000;

    fn session(of_slave: u8) -> Session {
        Key::of_loopback().session(&[1; NONCE_BYTES], &[of_slave; NONCE_BYTES])
    }

    fn master() -> Endpoint<5> {
        Endpoint::new(Role::Master, session(2), TICKS, [0.0; 5])
    }

    fn slave() -> Endpoint<4> {
        Endpoint::new(Role::Slave, session(2), TICKS, [0.0; 4])
    }

    fn message(value: f64) -> Message<f64, 4> {
        Message { sample: [value; 4], payload: [2.0 * value; PAYLOAD] }
    }

    /// The state that a packet can change, without the counters and the travel times.
    fn state(end: &Endpoint<4>) -> String {
        format!("{:?} {:?} {:?} {:?}", end.window, end.arrivals, end.echo, end.energy)
    }

    #[test]
    fn a_message_arrives_as_it_was_sent() {
        let (mut master, mut slave) = (master(), slave());
        let packet = master.seal((0, 1000), &message(1.5), 0.25);
        slave.take(&packet, 4000);
        assert_eq!(slave.last_trip(), Some(Trip { one_way_s: 3e-6, round_s: None }));
        let received = slave.at_next_tick();
        assert_eq!((received.sample, received.payload, received.is_fresh), ([1.5; 4], [3.0; PAYLOAD], true));
        assert_eq!(slave.other_energy_j(), 0.25);
        let back = slave.seal((0, 5000), &Message { sample: [1.0; 5], payload: [0.0; PAYLOAD] }, 0.0);
        master.take(&back, 9000);
        // The round trip took 9000 - 1000 ns, including 1000 ns on the slave.
        let round_s = master.last_trip().and_then(|trip| trip.round_s).expect("an echo");
        assert!((round_s - 7e-6).abs() < 1e-15);
        assert_eq!((master.counters().sent, master.counters().received), (1, 1));
    }

    #[test]
    fn a_packet_of_another_key_or_session_or_with_an_old_number_changes_nothing() {
        let (mut master, mut slave) = (master(), slave());
        let old = master.seal((0, 0), &message(1.0), 0.0);
        slave.take(&old, 0);
        let before = state(&slave);
        slave.take(&old, 1);
        assert_eq!((state(&slave), slave.counters().replayed), (before.clone(), 1));
        let wrong = Key::new(&[7; 32]).expect("long").session(&[1; NONCE_BYTES], &[2; NONCE_BYTES]);
        for (count, session) in [session(3), wrong].into_iter().enumerate() {
            let mut other = Endpoint::<5>::new(Role::Master, session, TICKS, [0.0; 5]);
            other.seal((0, 0), &message(1.0), 0.0);
            slave.take(&other.seal((1, 0), &message(9.0), 0.0), 2);
            assert_eq!((state(&slave), slave.counters().foreign), (before.clone(), count as u64 + 1));
        }
        // A packet of the slave, sent back to it.
        let own = slave.seal((0, 0), &Message { sample: [1.0; 5], payload: [0.0; PAYLOAD] }, 0.0);
        slave.take(&own, 3);
        assert_eq!((state(&slave), slave.counters().foreign), (before.clone(), 3));
        // Authentic, but not a number.
        let not_finite = master.seal((1, 0), &message(f64::NAN), 0.0);
        slave.take(&not_finite, 4);
        assert_eq!((state(&slave), slave.counters().malformed), (before, 1));
        assert_eq!((slave.counters().received, slave.counters().dropped()), (1, 5));
    }

    #[test]
    fn a_million_random_and_mutated_packets_only_change_the_counters() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let (mut master, mut slave) = (master(), slave());
        for tick in 0..10 {
            slave.take(&master.seal((tick, 0), &message(1.0), 0.0), 0);
            slave.at_next_tick();
        }
        let (before, counted) = (state(&slave), slave.counters());
        let valid = master.seal((10, 0), &message(1.0), 0.0);
        let mut random = [0; 2 * PACKET_BYTES];
        for round in 0..1_000_000_u32 {
            if round % 4 == 0 {
                // Change up to four bits of a valid packet, or cut it.
                let mut mutated = valid;
                for _ in 0..rng.random_range(1..5) {
                    mutated[rng.random_range(0..PACKET_BYTES)] ^= 1 << rng.random_range(0..8);
                }
                let length = if round % 16 == 0 { rng.random_range(0..PACKET_BYTES) } else { PACKET_BYTES };
                // The changes may have cancelled each other.
                mutated[40] ^= u8::from(mutated == valid);
                slave.take(&mutated[..length], 0);
            } else {
                let length = rng.random_range(0..random.len());
                rng.fill_bytes(&mut random[..length]);
                // Half of them resemble packets.
                if round % 2 == 0 {
                    let length = length.min(8);
                    random[..length].copy_from_slice(&valid[..length]);
                }
                slave.take(&random[..length], 0);
            }
        }
        let counters = slave.counters();
        assert_eq!(state(&slave), before);
        assert_eq!(counters.dropped() - counted.dropped(), 1_000_000);
        assert_eq!(Counters { malformed: 0, foreign: 0, ..counters }, Counters { malformed: 0, foreign: 0, ..counted });
        assert!(counters.malformed > 700_000 && counters.foreign > 100_000, "{counters:?}");
        // The end still works.
        slave.take(&valid, 0);
        assert_eq!(slave.counters().received, 11);
    }
}
