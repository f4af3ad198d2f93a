//! The sides find each other and agree on a session and on the time of tick 0.
//!
//! ```text
//! master  Hello   its random number, its scenario
//! slave   Reply   both random numbers, its scenario, the stamp of the Hello, the time since tick 0 of a link that runs
//! master  Start   both random numbers, the time to tick 0, half of the shortest round trip
//! slave   Ready   both random numbers
//! ```
//! The common key authenticates Hello and Reply, the session's key Start and Ready. An old packet contains an old
//! random number and therefore starts no session.
//!
//! A side that has started anew joins the running link of the other side in a new session, with tick 0 in the past.

use sha2::{Digest as _, Sha256};

use super::packet::{BODY_BYTES, Kind, PACKET_BYTES, Packet, Role, word};
use super::seal::{Key, NONCE_BYTES, Session};
use trocar_scenario::Scenario;

const OF_MASTER: usize = 0;
const OF_SLAVE: usize = 16;
const SCENARIO: usize = 32;
const FIRST_NS: usize = 64;
const SECOND_NS: usize = 72;

const MAX_WAIT_NS: i64 = 60_000_000_000;
/// One year.
const MAX_SINCE_NS: i64 = 31_536_000_000_000_000;

/// Hash of a scenario, without file paths, and the program's version: both sides must have the same.
pub fn fingerprint(scenario: &Scenario) -> [u8; 32] {
    let mut hash = Sha256::new_with_prefix(env!("CARGO_PKG_VERSION"));
    let echo = scenario.echo();
    echo.lines().filter(|line| !line.trim_start().starts_with("file =")).for_each(|line| hash.update(line));
    hash.finalize().into()
}

#[derive(Debug, Clone)]
pub struct Greeted {
    pub session: Session,
    pub start_ns: i64,
    /// The clocks of both sides agree to half of it.
    pub round_ns: i64,
}

fn part<const N: usize>(body: &[u8; BODY_BYTES], at: usize) -> [u8; N] {
    body.get(at..).and_then(|rest| rest.first_chunk()).copied().unwrap_or([0; N])
}

fn body(
    of_master: &[u8; NONCE_BYTES],
    of_slave: &[u8; NONCE_BYTES],
    scenario: &[u8; 32],
    ns: [i64; 2],
) -> [u8; BODY_BYTES] {
    let mut body = [0; BODY_BYTES];
    body[OF_MASTER..OF_SLAVE].copy_from_slice(of_master);
    body[OF_SLAVE..SCENARIO].copy_from_slice(of_slave);
    body[SCENARIO..FIRST_NS].copy_from_slice(scenario);
    body[FIRST_NS..SECOND_NS].copy_from_slice(&ns[0].to_le_bytes());
    body[SECOND_NS..SECOND_NS + 8].copy_from_slice(&ns[1].to_le_bytes());
    body
}

fn packet(kind: Kind, from: Role, body: [u8; BODY_BYTES]) -> Packet {
    Packet { kind, from, number: 0, tick: 0, sent_ns: 0, body }
}

#[derive(Debug)]
pub struct Calling {
    key: Key,
    own: [u8; NONCE_BYTES],
    scenario: [u8; 32],
    reply: Option<SlaveReply>,
    replies: u32,
    differs: bool,
    is_ready: bool,
}

#[derive(Debug)]
struct SlaveReply {
    of_slave: [u8; NONCE_BYTES],
    session: Session,
    round_ns: i64,
    /// Tick 0 of the slave's link by this side's clock; `None` if the slave's link has not begun.
    begun_ns: Option<i64>,
}

impl Calling {
    pub fn new(key: Key, own: [u8; NONCE_BYTES], scenario: [u8; 32]) -> Self {
        Self { key, own, scenario, reply: None, replies: 0, differs: false, is_ready: false }
    }

    pub fn hello(&self, now_ns: i64) -> [u8; PACKET_BYTES] {
        let body = body(&self.own, &[0; NONCE_BYTES], &self.scenario, [now_ns, 0]);
        self.key.seal(&packet(Kind::Hello, Role::Master, body))
    }

    /// Returns true for an authentic packet of this greeting.
    pub fn take(&mut self, bytes: &[u8], now_ns: i64) -> bool {
        let Some(Packet { kind, from: Role::Slave, body, .. }) = Packet::read(bytes) else { return false };
        if kind == Kind::Message {
            // The slave has begun, and its Ready was lost; the message is for the endpoint.
            self.is_ready |= self.reply.as_ref().is_some_and(|reply| reply.session.0.is_authentic(bytes));
            return false;
        }
        if part::<NONCE_BYTES>(&body, OF_MASTER) != self.own {
            return false;
        }
        let of_slave = part(&body, OF_SLAVE);
        match (kind, &mut self.reply) {
            (Kind::Reply, reply) if self.key.is_authentic(bytes) => {
                if part::<32>(&body, SCENARIO) != self.scenario {
                    self.differs = true;
                    return true;
                }
                let round_ns = now_ns.saturating_sub(word(&body, FIRST_NS).cast_signed()).max(0);
                self.replies += 1;
                if reply.as_ref().is_some_and(|known| known.of_slave == of_slave && known.round_ns <= round_ns) {
                    return true;
                }
                let since_ns = word(&body, SECOND_NS).cast_signed();
                let begun_ns = (1..=MAX_SINCE_NS)
                    .contains(&since_ns)
                    .then(|| now_ns.saturating_sub(round_ns / 2).saturating_sub(since_ns));
                let session = self.key.session(&self.own, &of_slave);
                *reply = Some(SlaveReply { of_slave, session, round_ns, begun_ns });
                true
            }
            (Kind::Ready, Some(reply)) if reply.session.0.is_authentic(bytes) => {
                self.is_ready = true;
                true
            }
            _ => false,
        }
    }

    pub fn replies(&self) -> u32 {
        self.replies
    }

    pub fn differs(&self) -> bool {
        self.differs
    }

    pub fn begun_ns(&self) -> Option<i64> {
        self.reply.as_ref()?.begun_ns
    }

    /// `None` before a reply.
    pub fn start(&self, now_ns: i64, start_ns: i64) -> Option<[u8; PACKET_BYTES]> {
        let reply = self.reply.as_ref()?;
        let times_ns = [start_ns.saturating_sub(now_ns), reply.round_ns / 2];
        let body = body(&self.own, &reply.of_slave, &[0; 32], times_ns);
        Some(reply.session.0.seal(&packet(Kind::Start, Role::Master, body)))
    }

    pub fn greeted(&self, start_ns: i64) -> Option<Greeted> {
        let SlaveReply { session, round_ns, .. } = self.reply.as_ref().filter(|_| self.is_ready)?;
        Some(Greeted { session: session.clone(), start_ns, round_ns: *round_ns })
    }
}

#[derive(Debug)]
pub struct Waiting {
    key: Key,
    own: [u8; NONCE_BYTES],
    scenario: [u8; 32],
    begun_ns: Option<i64>,
    greeted: Option<([u8; NONCE_BYTES], Greeted)>,
    differs: bool,
}

impl Waiting {
    pub fn new(key: Key, own: [u8; NONCE_BYTES], scenario: [u8; 32]) -> Self {
        Self { key, own, scenario, begun_ns: None, greeted: None, differs: false }
    }

    /// [`Waiting::new`] for a slave whose link runs: a master may join it.
    pub fn running(key: Key, own: [u8; NONCE_BYTES], scenario: [u8; 32], begun_ns: i64) -> Self {
        Self { begun_ns: Some(begun_ns), ..Self::new(key, own, scenario) }
    }

    pub fn take(&mut self, bytes: &[u8], now_ns: i64) -> Option<[u8; PACKET_BYTES]> {
        let Packet { kind, from: Role::Master, body: given, .. } = Packet::read(bytes)? else { return None };
        let of_master = part(&given, OF_MASTER);
        let first_ns = word(&given, FIRST_NS).cast_signed();
        match kind {
            Kind::Hello if self.key.is_authentic(bytes) => {
                self.differs |= part::<32>(&given, SCENARIO) != self.scenario;
                let since_ns = self.begun_ns.map_or(0, |begun_ns| now_ns.saturating_sub(begun_ns).max(1));
                let body = body(&of_master, &self.own, &self.scenario, [first_ns, since_ns]);
                Some(self.key.seal(&packet(Kind::Reply, Role::Slave, body)))
            }
            Kind::Start if part::<NONCE_BYTES>(&given, OF_SLAVE) == self.own => {
                let session = self.key.session(&of_master, &self.own);
                if !session.0.is_authentic(bytes) || !(-MAX_SINCE_NS..=MAX_WAIT_NS).contains(&first_ns) {
                    return None;
                }
                let half_ns = word(&given, SECOND_NS).cast_signed().clamp(0, MAX_WAIT_NS);
                let ready = packet(Kind::Ready, Role::Slave, body(&of_master, &self.own, &[0; 32], [0, 0]));
                let answer = session.0.seal(&ready);
                let announced_ns = now_ns.saturating_add(first_ns).saturating_sub(half_ns);
                let start_ns = self.begun_ns.unwrap_or(announced_ns);
                match &self.greeted {
                    None => {
                        self.greeted = Some((of_master, Greeted { session, start_ns, round_ns: 2 * half_ns }));
                        Some(answer)
                    }
                    // Only the first Start counts.
                    Some((known, _)) => (*known == of_master).then_some(answer),
                }
            }
            _ => None,
        }
    }

    pub fn differs(&self) -> bool {
        self.differs
    }

    pub fn greeted(&self) -> Option<&Greeted> {
        self.greeted.as_ref().map(|(_, greeted)| greeted)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCENARIO: [u8; 32] = [4; 32];

    fn calling(of_master: u8) -> Calling {
        Calling::new(Key::of_loopback(), [of_master; NONCE_BYTES], SCENARIO)
    }

    fn waiting(of_slave: u8) -> Waiting {
        Waiting::new(Key::of_loopback(), [of_slave; NONCE_BYTES], SCENARIO)
    }

    #[test]
    fn both_sides_agree_on_session_and_start() {
        let (mut master, mut slave) = (calling(1), waiting(2));
        assert!(master.start(0, 10).is_none());
        // The slave's clock is 5000 ns ahead; a packet takes 100 ns there and 300 ns back.
        for sent in [1000, 2000] {
            let reply = slave.take(&master.hello(sent), sent + 5100).expect("a reply");
            master.take(&reply, sent + 400);
        }
        assert_eq!(master.replies(), 2);
        let start = master.start(3000, 9000).expect("a slave");
        assert!(master.greeted(9000).is_none());
        master.take(&slave.take(&start, 8100).expect("ready"), 3400);
        let (of_master, of_slave) = (master.greeted(9000).expect("ready"), slave.greeted().expect("started"));
        // 14000 by its clock, minus half of the difference between the directions.
        assert_eq!((of_master.round_ns, of_slave.start_ns, of_slave.round_ns), (400, 13_900, 400));
        let sealed = of_master.session.0.seal(&packet(Kind::Message, Role::Master, [0; BODY_BYTES]));
        assert!(of_slave.session.0.is_authentic(&sealed));
        // A repetition is answered and changes nothing.
        let again = master.start(4000, 20_000).expect("a slave");
        assert!(slave.take(&again, 9100).is_some());
        assert_eq!(slave.greeted().map(|greeted| greeted.start_ns), Some(13_900));
    }

    #[test]
    fn packets_of_an_earlier_session_have_no_effect() {
        let (mut master, mut slave) = (calling(1), waiting(2));
        let hello = master.hello(0);
        let reply = slave.take(&hello, 0).expect("a reply");
        master.take(&reply, 0);
        let start = master.start(0, 10).expect("a slave");
        let ready = slave.take(&start, 0).expect("ready");

        let mut slave = waiting(3);
        assert!(slave.take(&hello, 0).is_some(), "a reply does no harm");
        assert!(slave.take(&start, 0).is_none() && slave.greeted().is_none());
        let mut master = calling(4);
        master.take(&reply, 0);
        master.take(&ready, 0);
        assert!(master.replies() == 0 && master.start(0, 10).is_none() && master.greeted(10).is_none());
    }

    #[test]
    fn another_key_is_not_answered_and_another_scenario_is_reported() {
        let key = Key::new(&[9; 16]).expect("long enough");
        let mut slave = Waiting::new(key, [2; NONCE_BYTES], SCENARIO);
        assert!(slave.take(&calling(1).hello(0), 0).is_none());
        let mut slave = Waiting::new(Key::of_loopback(), [2; NONCE_BYTES], [5; 32]);
        let mut master = calling(1);
        master.take(&slave.take(&master.hello(0), 0).expect("a reply"), 0);
        assert!(master.differs() && slave.differs() && master.start(0, 10).is_none());
        for bytes in [&[][..], &[0; PACKET_BYTES], b"TRCR"] {
            assert!(slave.take(bytes, 0).is_none());
            master.take(bytes, 0);
        }
    }
}
