use super::greeting::{Calling, Waiting};
use super::packet::{PACKET_BYTES, Role};
use super::seal::{Key, NONCE_BYTES, Session};

const CALL_NS: i64 = 20_000_000;
const REPLIES: u32 = 10;
/// Time from an agreement to the other side's first message; afterwards the agreement no longer counts.
const PATIENCE_NS: i64 = 2_000_000_000;

/// The greeting of a side that has started anew, by a side whose link runs.
///
/// Its new random number gives a new session. Two sides that run do not agree on one: the next message continues their
/// present session.
#[derive(Debug)]
pub struct Rejoin {
    begun_ns: i64,
    greeting: Greeting,
    next_ns: i64,
    agreed_ns: Option<i64>,
}

#[derive(Debug)]
enum Greeting {
    OfMaster(Calling),
    OfSlave(Waiting),
}

#[derive(Debug, Default)]
pub struct Heard {
    pub is_known: bool,
    pub answer: Option<[u8; PACKET_BYTES]>,
    pub session: Option<Session>,
}

impl Rejoin {
    /// `own` is a random number that was never used, `scenario` the scenario's [`fingerprint`](super::fingerprint).
    pub fn new(role: Role, key: Key, own: [u8; NONCE_BYTES], scenario: [u8; 32], begun_ns: i64) -> Self {
        let greeting = match role {
            Role::Master => Greeting::OfMaster(Calling::new(key, own, scenario)),
            Role::Slave => Greeting::OfSlave(Waiting::running(key, own, scenario, begun_ns)),
        };
        Self { begun_ns, greeting, next_ns: i64::MIN, agreed_ns: None }
    }

    pub fn call(&mut self, now_ns: i64) -> Option<[u8; PACKET_BYTES]> {
        let Greeting::OfMaster(calling) = &self.greeting else { return None };
        if now_ns < self.next_ns || self.agreed_ns.is_some() {
            return None;
        }
        self.next_ns = now_ns.saturating_add(CALL_NS);
        let is_new_slave = calling.replies() >= REPLIES && calling.begun_ns().is_none();
        let start = calling.start(now_ns, self.begun_ns).filter(|_| is_new_slave);
        Some(start.unwrap_or_else(|| calling.hello(now_ns)))
    }

    pub fn take(&mut self, bytes: &[u8], now_ns: i64) -> Heard {
        let (heard, greeted) = match &mut self.greeting {
            Greeting::OfMaster(calling) => {
                let is_known = calling.take(bytes, now_ns);
                (Heard { is_known, ..Heard::default() }, calling.greeted(self.begun_ns))
            }
            Greeting::OfSlave(waiting) => {
                let answer = waiting.take(bytes, now_ns);
                (Heard { is_known: answer.is_some(), answer, session: None }, waiting.greeted().cloned())
            }
        };
        let session = greeted.filter(|_| self.agreed_ns.is_none()).map(|greeted| greeted.session);
        if session.is_some() {
            self.agreed_ns = Some(now_ns);
        }
        Heard { session, ..heard }
    }

    pub fn has_agreed(&self) -> bool {
        self.agreed_ns.is_some()
    }

    /// True if the other side has agreed, but then sent no message for too long.
    pub fn is_overdue(&self, now_ns: i64) -> bool {
        self.agreed_ns.is_some_and(|agreed_ns| now_ns.saturating_sub(agreed_ns) > PATIENCE_NS)
    }
}

#[cfg(test)]
mod tests {
    use super::super::packet::{BODY_BYTES, Kind, Packet};
    use super::*;

    const SCENARIO: [u8; 32] = [4; 32];
    const MS: i64 = 1_000_000;

    fn rejoin(role: Role, own: u8) -> Rejoin {
        Rejoin::new(role, Key::of_loopback(), [own; NONCE_BYTES], SCENARIO, 5 * MS)
    }

    #[test]
    fn a_new_master_joins_the_slave_at_the_slave_s_time() {
        let mut slave = rejoin(Role::Slave, 2);
        let mut master = Calling::new(Key::of_loopback(), [3; NONCE_BYTES], SCENARIO);
        assert!(slave.call(0).is_none(), "a slave does not call");
        // Both clocks agree; a packet takes 1 ms.
        let heard = slave.take(&master.hello(1000 * MS), 1001 * MS);
        assert!(heard.is_known && heard.session.is_none());
        master.take(&heard.answer.expect("a reply"), 1002 * MS);
        assert_eq!(master.begun_ns(), Some(5 * MS));
        let start = master.start(1003 * MS, 5 * MS).expect("a slave");
        let heard = slave.take(&start, 1004 * MS);
        assert!(heard.session.is_some() && slave.has_agreed());
        master.take(&heard.answer.expect("ready"), 1005 * MS);
        assert!(master.greeted(5 * MS).is_some());
        // A repetition is answered, and the session begins once.
        let heard = slave.take(&start, 1006 * MS);
        assert!(heard.answer.is_some() && heard.session.is_none());
        assert!(!slave.is_overdue(3004 * MS) && slave.is_overdue(3005 * MS));
    }

    #[test]
    fn a_master_that_runs_calls_a_new_slave_and_no_slave_that_runs() {
        let calls = |slave: &mut Waiting| {
            let mut master = rejoin(Role::Master, 1);
            let sessions = (0..40).filter(|k| {
                let now_ns = 1000 * MS + k * 20 * MS;
                let Some(packet) = master.call(now_ns) else { return false };
                assert!(master.call(now_ns + 19 * MS).is_none(), "one packet in 20 ms");
                slave.take(&packet, now_ns).is_some_and(|answer| master.take(&answer, now_ns).session.is_some())
            });
            sessions.count()
        };
        let mut new = Waiting::new(Key::of_loopback(), [2; NONCE_BYTES], SCENARIO);
        assert_eq!(calls(&mut new), 1);
        assert_eq!(new.greeted().map(|greeted| greeted.start_ns), Some(5 * MS));
        let mut runs = Waiting::running(Key::of_loopback(), [2; NONCE_BYTES], SCENARIO, 5 * MS);
        assert_eq!(calls(&mut runs), 0);
        assert!(runs.greeted().is_none());
    }

    #[test]
    fn a_message_of_the_new_slave_replaces_its_lost_ready_and_is_no_greeting() {
        let mut master = rejoin(Role::Master, 1);
        let mut slave = Waiting::new(Key::of_loopback(), [2; NONCE_BYTES], SCENARIO);
        for k in 0..12 {
            let now_ns = k * 20 * MS;
            let answer = slave.take(&master.call(now_ns).expect("due"), now_ns).expect("an answer");
            if slave.greeted().is_none() {
                master.take(&answer, now_ns);
            }
        }
        let session = slave.greeted().expect("started").session.clone();
        let body = [0; BODY_BYTES];
        let message = Packet { kind: Kind::Message, from: Role::Slave, number: 0, tick: 9, sent_ns: 0, body };
        let heard = master.take(&session.0.seal(&message), 300 * MS);
        assert!(heard.session.is_some() && !heard.is_known, "the endpoint takes the message");
        let heard = master.take(&session.0.seal(&message), 301 * MS);
        assert!(heard.session.is_none() && !heard.is_known);
    }

    #[test]
    fn packets_of_an_earlier_greeting_begin_no_session() {
        let mut first = rejoin(Role::Slave, 2);
        let mut master = Calling::new(Key::of_loopback(), [3; NONCE_BYTES], SCENARIO);
        let hello = master.hello(0);
        master.take(&first.take(&hello, 0).answer.expect("a reply"), 0);
        let start = master.start(0, 0).expect("a slave");
        assert!(first.take(&start, 0).session.is_some());
        let mut second = rejoin(Role::Slave, 7);
        assert!(second.take(&hello, 0).session.is_none());
        let heard = second.take(&start, 0);
        assert!(!heard.is_known && heard.session.is_none() && !second.has_agreed());
    }
}
